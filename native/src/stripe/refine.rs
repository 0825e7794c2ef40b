//! The sub-pixel place of a peak and its standard uncertainty, by the estimator asked for.

use super::peak::SATURATED_FROM;
use super::{Estimator, Settings};

const LONGEST_STEP: f64 = 2.0;
/// Most samples in a Gauss-Newton window (half width 24).
const MOST: usize = 49;

/// Samples of the window that lie inside the picture.
struct Window {
    x: [f64; MOST],
    y: [f64; MOST],
    count: usize,
}

impl Window {
    fn around(y: &[f64], position: f64, half: usize) -> Self {
        let middle = (position + 0.5) as usize;
        let (low, high) = (middle.saturating_sub(half), (middle + half).min(y.len() - 1));
        let mut window = Window { x: [0.0; MOST], y: [0.0; MOST], count: 0 };
        for sample in low..=high {
            if y[sample].is_finite() {
                window.x[window.count] = sample as f64;
                window.y[window.count] = y[sample];
                window.count += 1;
            }
        }
        window
    }

    fn samples(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.x[..self.count].iter().copied().zip(self.y[..self.count].iter().copied())
    }
}

/// (position, u), or none where the estimator finds no peak.
pub fn refine(
    y: &[f64],
    position: f64,
    fraction: f64,
    height: f64,
    background: f64,
    edges: (f64, f64),
    settings: &Settings,
) -> Option<(f64, f64)> {
    if matches!(settings.estimator, Estimator::Crossing) {
        return Some((position, 0.0));
    }
    let (moved, u) = gauss_newton(y, position, height, background, settings);
    let window = || Window::around(y, position, settings.half_fit);
    match settings.estimator {
        Estimator::ZeroCrossing if moved.abs() <= LONGEST_STEP => Some((position + moved, u)),
        Estimator::ZeroCrossing | Estimator::Crossing => Some((position, u.hypot(moved))),
        Estimator::Parabola => parabola(y, position, fraction, settings).map(|place| (place, u)),
        Estimator::Maximum => Some((brightest(&window()), u.hypot((1.0f64 / 12.0).sqrt()))),
        Estimator::Threshold => Some((0.5 * (edges.0 + edges.1), u)),
        Estimator::Centroid => Some((centroid(&window(), background), u)),
        Estimator::Correlation => Some((position + correlation(&window(), position, background, settings), u)),
    }
}

/// The step of one weighted Gauss-Newton iteration for (amplitude, position, background) of a Gaussian line, and the
/// standard uncertainty of the position under pixel noise and correlated speckle.
fn gauss_newton(y: &[f64], position: f64, height: f64, background: f64, settings: &Settings) -> (f64, f64) {
    let noise = &settings.noise;
    let inverse = 1.0 / (noise.width * noise.width);
    let white = SATURATED_FROM * settings.saturation;
    let middle = (position + 0.5) as usize;
    let low = middle.saturating_sub(settings.half_fit);
    let samples = &y[low..=(middle + settings.half_fit).min(y.len() - 1)];
    let (mut line, mut weight) = ([0.0; MOST], [0.0; MOST]);
    let (mut aa, mut ab, mut ac, mut bb, mut bc, mut cc) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    // exp(-z^2 / 2 s^2) at unit steps by recurrence: two exponentials for the whole window
    let begin = low as f64 - position;
    let mut shape = (-0.5 * begin * begin * inverse).exp();
    let mut ratio = (-(begin + 0.5) * inverse).exp();
    for (k, &sample) in samples.iter().enumerate() {
        line[k] = height * shape;
        weight[k] = if sample < white { 1.0 / noise.variance(line[k]) } else { 0.0 };
        let slope = line[k] * (begin + k as f64) * inverse;
        let (wa, wb) = (weight[k] * shape, weight[k] * slope);
        aa += wa * shape;
        ab += wa * slope;
        ac += wa;
        bb += wb * slope;
        bc += wb;
        cc += weight[k];
        shape *= ratio;
        ratio *= noise.step;
    }
    let Some(row) = inverse_row(&[[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]]) else { return (f64::INFINITY, 0.0) };
    let (mut functional, mut moved, mut pixel) = ([0.0; MOST], 0.0, 0.0);
    for (k, &sample) in samples.iter().enumerate().filter(|(k, _)| weight[*k] > 0.0) {
        let slope = line[k] * (begin + k as f64) * inverse;
        let f = weight[k] * (row[0] * line[k] / height + row[1] * slope + row[2]);
        moved += f * (sample - line[k] - background);
        pixel += f * f * (noise.additive + noise.gain * line[k]);
        functional[k] = f * line[k];
    }
    let speckle = noise.contrast * speckled(&functional[..samples.len()], &noise.correlation);
    (moved, (pixel + speckle).max(0.0).sqrt())
}

/// Sum over sample pairs of the speckle functional times the correlation at their distance.
fn speckled(functional: &[f64], correlation: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (distance, &shared) in correlation.iter().enumerate().take(functional.len()) {
        let pairs: f64 = functional[distance..].iter().zip(functional).map(|(a, b)| a * b).sum();
        sum += if distance == 0 { shared * pairs } else { 2.0 * shared * pairs };
    }
    sum
}

/// Second row (position) of the inverse of a symmetric 3 x 3 matrix, or none where it is singular.
fn inverse_row(m: &[[f64; 3]; 3]) -> Option<[f64; 3]> {
    let cofactor = [
        m[1][2] * m[2][0] - m[1][0] * m[2][2],
        m[0][0] * m[2][2] - m[0][2] * m[2][0],
        m[0][2] * m[1][0] - m[0][0] * m[1][2],
    ];
    let determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    if !(determinant > 1e-12 * m[0][0] * m[1][1] * m[2][2]) {
        return None;
    }
    Some(cofactor.map(|c| c / determinant))
}

/// Vertex of the parabola fitted to the window nearest to the crossing (Swanbom 2007, 6.3.4.2).
fn parabola(y: &[f64], position: f64, fraction: f64, settings: &Settings) -> Option<f64> {
    let count = settings.window;
    let half = (count - 1) as f64 / 2.0;
    let start = (position - fraction - half).round() as usize + usize::from(fraction > 0.5);
    let mean = (0..count).map(|k| (k as f64 - half).powi(2)).sum::<f64>() / count as f64;
    let (mut slope, mut levers, mut bend, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..count {
        let lever = k as f64 - half;
        let square = lever * lever - mean;
        slope += y[start + k] * lever;
        levers += lever * lever;
        bend += y[start + k] * square;
        squares += square * square;
    }
    let (slope, bend) = (slope / levers, bend / squares);
    (bend < 0.0).then(|| start as f64 + half - slope / (2.0 * bend))
}

fn brightest(window: &Window) -> f64 {
    let mut best = (f64::NEG_INFINITY, f64::NAN);
    for (x, y) in window.samples() {
        if y > best.0 {
            best = (y, x);
        }
    }
    best.1
}

fn centroid(window: &Window, background: f64) -> f64 {
    let (mut total, mut moment) = (0.0, 0.0);
    for (x, y) in window.samples() {
        let weight = (y - background).max(0.0);
        total += weight;
        moment += weight * x;
    }
    moment / total
}

/// Offset from `position` of the best match with a Gaussian of the line's width, by two Newton steps.
fn correlation(window: &Window, position: f64, background: f64, settings: &Settings) -> f64 {
    let variance = settings.noise.width * settings.noise.width;
    let mut offset = 0.0;
    for _ in 0..2 {
        let (mut first, mut second) = (0.0, 0.0);
        for (x, y) in window.samples() {
            let z = x - position - offset;
            let match_ = (y - background) * (-z * z / (2.0 * variance)).exp();
            first += match_ * z;
            second += match_ * (z * z / variance - 1.0);
        }
        if second < 0.0 {
            offset += (-first / second).clamp(-1.0, 1.0);
        }
    }
    offset
}
