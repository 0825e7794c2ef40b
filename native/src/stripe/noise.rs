//! How noisy the picture is, learnt from the picture itself (see the Python module `_noise`).

use super::rays::Ray;
use super::sampling::{Grey, Plane};
use super::settings::Noise;
use super::statistics::{median, nearest_even};

pub const QUANTISATION: f64 = 1.0 / 12.0;
const ALIGNED: f64 = 0.985;
const FOURTH_DIFFERENCE: [i64; 5] = [1, -4, 6, -4, 1];
/// Sum of the squares of the fourth difference.
const FOURTH_SQUARE: f64 = 70.0;
const FEWEST_RUNS: usize = 200;
const RUNS_PER_BIN: usize = 60;
const FEWEST_BINS: usize = 4;
const MOST_BINS: usize = 24;
const FAINT_RUNS: f64 = 0.05;
/// Median of chi-square with one degree of freedom over its mean.
const CHI_MEDIAN: f64 = 0.4549;
pub const NORMAL: f64 = 1.4826;
/// Digits by which runs are sorted: two are enough for five grey values of 16 bits.
const DIGITS: usize = 1 << 11;
const FEWEST_PAIRS: usize = 16;
pub const CONTRAST: f64 = 0.04;
pub const MOST_CONTRAST: f64 = 1.0;

/// Least standard deviation of a pixel: that of rounding to whole grey values.
pub fn background_noise(median_difference: f64) -> f64 {
    (NORMAL * median_difference / 2f64.sqrt()).max(QUANTISATION.sqrt())
}

/// (additive, gain) of the pixel noise near peaks, given as (ray, place), from fourth differences along the line.
pub fn pixel_noise<T: Grey>(plane: &Plane<T>, peaks: &[(Ray, [f64; 2])]) -> (f64, f64) {
    let runs = runs_near(plane, peaks);
    if runs.len() < FEWEST_RUNS {
        return (0.0, 0.0);
    }
    let runs = by_level(runs);
    let faint = quantile(&runs, FAINT_RUNS);
    let bins = (runs.len() / RUNS_PER_BIN).clamp(FEWEST_BINS, MOST_BINS);
    let (mut design, mut target, mut end) = (Vec::with_capacity(bins), Vec::with_capacity(bins), 0);
    for bin in 0..bins {
        let begin = end;
        end += runs.len() / bins + usize::from(bin < runs.len() % bins);
        let mean = runs[begin..end].iter().map(|(level, _)| (level - faint).max(0.0)).sum::<f64>() / (end - begin) as f64;
        let mut squares: Vec<f64> = runs[begin..end].iter().map(|(_, square)| *square).collect();
        let variance = median(&mut squares) / CHI_MEDIAN;
        let scale = 1.0 / (variance + QUANTISATION);
        design.push([scale, mean * scale, mean * mean * scale]);
        target.push(variance * scale);
    }
    let terms = nonnegative_least_squares(&design, &target);
    (terms[0], terms[1])
}

/// Five runs of five pixels along the line at every peak: (sum of levels, squared fourth difference).
fn runs_near<T: Grey>(plane: &Plane<T>, peaks: &[(Ray, [f64; 2])]) -> Vec<(u32, f64)> {
    let mut runs = Vec::with_capacity(5 * peaks.len());
    for axis in 0..2 {
        for (_, place) in peaks.iter().filter(|(ray, _)| ray.direction[1 - axis].abs() > ALIGNED) {
            runs.extend((-2..=2).map(|beside| run(plane, *place, axis, 2.0 * f64::from(beside))));
        }
    }
    runs
}

/// The run along `axis` about a place, `beside` pixels across from it.
fn run<T: Grey>(plane: &Plane<T>, place: [f64; 2], axis: usize, beside: f64) -> (u32, f64) {
    let mut at = place;
    at[1 - axis] += beside;
    let middle = |value: f64, count: usize| (nearest_even(value).max(2) as usize).min(count - 3);
    let (column, row) = (middle(at[0], plane.width), middle(at[1], plane.height));
    let pace = if axis == 0 { plane.bands } else { plane.bands * plane.width };
    let first = plane.index(column, row) - 2 * pace;
    let pixels = &plane.data[first..=first + 4 * pace];
    let (mut level, mut difference) = (0, 0i64);
    for (k, weight) in FOURTH_DIFFERENCE.iter().enumerate() {
        let value = pixels[k * pace].level();
        level += value;
        difference += weight * i64::from(value);
    }
    let difference = difference as f64;
    (level, difference * difference / FOURTH_SQUARE)
}

/// (mean level, squared fourth difference) of `runs` in ascending order of level, those of the same level in the order they came in: sorted
/// by the digits of the level from the last one on.
fn by_level(mut runs: Vec<(u32, f64)>) -> Vec<(f64, f64)> {
    let highest = runs.iter().map(|run| run.0).max().unwrap_or(0);
    let (mut sorted, mut shift) = (runs.clone(), 0);
    while highest >> shift > 0 {
        let digit = |run: &(u32, f64)| (run.0 >> shift) as usize % DIGITS;
        let mut place = [0; DIGITS + 1];
        runs.iter().for_each(|run| place[digit(run) + 1] += 1);
        (0..DIGITS).for_each(|k| place[k + 1] += place[k]);
        for run in &runs {
            sorted[place[digit(run)]] = *run;
            place[digit(run)] += 1;
        }
        std::mem::swap(&mut runs, &mut sorted);
        shift += DIGITS.ilog2();
    }
    runs.into_iter().map(|(level, square)| (f64::from(level) / 5.0, square)).collect()
}

/// Quantile by linear interpolation of levels in ascending order.
fn quantile(sorted: &[(f64, f64)], fraction: f64) -> f64 {
    let place = fraction * (sorted.len() - 1) as f64;
    let below = place as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below].0 + (place - below as f64) * (sorted[above].0 - sorted[below].0)
}

/// argmin |design x - target| over x >= 0 for three columns, by trying every set of columns.
fn nonnegative_least_squares(design: &[[f64; 3]], target: &[f64]) -> [f64; 3] {
    const SETS: [&[usize]; 7] = [&[0], &[1], &[2], &[0, 1], &[0, 2], &[1, 2], &[0, 1, 2]];
    let mut best = (target.iter().map(|t| t * t).sum::<f64>(), [0.0; 3]);
    for chosen in SETS {
        let Some(x) = least_squares(design, target, chosen) else { continue };
        let misfit = |(row, t): (&[f64; 3], &f64)| (row[0] * x[0] + row[1] * x[1] + row[2] * x[2] - t).powi(2);
        let total = design.iter().zip(target).map(misfit).sum::<f64>();
        if x.iter().all(|&x| x >= 0.0) && total < best.0 {
            best = (total, x);
        }
    }
    best.1
}

/// Least squares in the `chosen` columns by Gram-Schmidt; none where they are not independent.
fn least_squares(design: &[[f64; 3]], target: &[f64], chosen: &[usize]) -> Option<[f64; 3]> {
    const DEPENDENT: f64 = 1e-12;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut base: Vec<Vec<f64>> = Vec::new();
    let mut upper = [[0.0; 3]; 3];
    for (j, &column) in chosen.iter().enumerate() {
        let mut rest: Vec<f64> = design.iter().map(|row| row[column]).collect();
        let whole = dot(&rest, &rest).sqrt();
        for (i, unit) in base.iter().enumerate() {
            upper[i][j] = dot(unit, &rest);
            rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= upper[i][j] * u);
        }
        upper[j][j] = dot(&rest, &rest).sqrt();
        if !(upper[j][j] > DEPENDENT * whole) {
            return None;
        }
        rest.iter_mut().for_each(|r| *r /= upper[j][j]);
        base.push(rest);
    }
    let mut x = [0.0; 3];
    for j in (0..chosen.len()).rev() {
        let known: f64 = (j + 1..chosen.len()).map(|k| upper[j][k] * x[chosen[k]]).sum();
        x[chosen[j]] = (dot(&base[j], target) - known) / upper[j][j];
    }
    Some(x)
}

/// `noise` with contrast and grain learnt from peak heights of neighbouring rays, NaN where missing.
pub fn speckle(noise: Noise, height: &[f64], spacing: f64) -> Noise {
    let logarithm: Vec<f64> = height.iter().map(|h| if h.is_nan() { f64::NAN } else { h.max(1e-3).ln() }).collect();
    let far = ((6.0 * noise.width / spacing).ceil() as usize).max(1);
    let close = ((1.0 / spacing).round_ties_even() as usize).max(1);
    let spread = pair_variance(&logarithm, far);
    let near = pair_variance(&logarithm, close);
    let shared = (1.0 - near / spread.max(1e-12)).clamp(0.05, 0.95);
    let blur = (close as f64 * spacing / (-4.0 * shared.ln()).sqrt()).min(0.95 * noise.width);
    let grain = 1.0 / (1.0 / (blur * blur) - 1.0 / (noise.width * noise.width)).sqrt();
    Noise { contrast: spread.clamp(1e-6, MOST_CONTRAST), grain: grain.min(1e3), ..noise }
}

/// Half the robust variance of the differences of values `lag` rays apart.
fn pair_variance(values: &[f64], lag: usize) -> f64 {
    let pairs = values.iter().zip(values.get(lag..).unwrap_or_default());
    let mut difference: Vec<f64> = pairs.map(|(a, b)| (b - a).abs()).filter(|d| d.is_finite()).collect();
    if difference.len() < FEWEST_PAIRS {
        return CONTRAST;
    }
    (NORMAL * median(&mut difference)).powi(2) / 2.0
}
