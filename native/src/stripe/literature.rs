//! The other estimators of a peak's place (Swanbom 2007, 2.3.3 and 6.3.4.2).

/// Where a window begins on its ray and its samples; those outside the picture are NaN and do not count.
type Window<'y> = (f64, &'y [f64]);

fn known((first, samples): Window<'_>) -> impl Iterator<Item = (f64, f64)> + '_ {
    samples.iter().enumerate().filter(|(_, y)| y.is_finite()).map(move |(k, &y)| (first + k as f64, y))
}

/// Vertex of the parabola fitted to the `count` samples nearest to the crossing at `position`, `fraction` of the way between two windows
/// (Swanbom 2007, 6.3.4.2).
pub fn parabola((first, samples): Window, (position, fraction): (f64, f64), count: usize) -> Option<f64> {
    let half = (count - 1) as f64 / 2.0;
    let start = (position - fraction - half).round() + if fraction > 0.5 { 1.0 } else { 0.0 };
    let mean = (0..count).map(|k| (k as f64 - half).powi(2)).sum::<f64>() / count as f64;
    let (mut slope, mut levers, mut bend, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for (k, value) in samples[(start - first) as usize..].iter().take(count).enumerate() {
        let lever = k as f64 - half;
        let square = lever * lever - mean;
        slope += value * lever;
        levers += lever * lever;
        bend += value * square;
        squares += square * square;
    }
    let (slope, bend) = (slope / levers, bend / squares);
    (bend < 0.0).then(|| start + half - slope / (2.0 * bend))
}

pub fn brightest(window: Window) -> f64 {
    let first_highest = |best: (f64, f64), sample: (f64, f64)| if sample.1 > best.1 { sample } else { best };
    known(window).fold((f64::NAN, f64::NEG_INFINITY), first_highest).0
}

pub fn centroid(window: Window, background: f64) -> f64 {
    let (mut total, mut moment) = (0.0, 0.0);
    for (x, y) in known(window) {
        let weight = (y - background).max(0.0);
        total += weight;
        moment += weight * x;
    }
    moment / total
}

/// Best match of a peak at `position` over a `background` with a Gaussian of the line's `width`, by two Newton steps.
pub fn correlation(window: Window, (position, background): (f64, f64), width: f64) -> f64 {
    let variance = width * width;
    let mut offset = 0.0;
    for _ in 0..2 {
        let (mut first, mut second) = (0.0, 0.0);
        for (x, y) in known(window) {
            let z = x - position - offset;
            let product = (y - background) * (-z * z / (2.0 * variance)).exp();
            first += product * z;
            second += product * (z * z / variance - 1.0);
        }
        if second < 0.0 {
            offset += (-first / second).clamp(-1.0, 1.0);
        }
    }
    position + offset
}
