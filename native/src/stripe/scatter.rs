//! What the line says about its own noise: the scatter of neighbouring peaks (see the Python module `_scatter`).

use super::statistics::median;

const NORMAL_HALF: f64 = 0.6745;
/// Noise is independent beyond this many line widths along the line.
const FORGOTTEN: f64 = 6.0;
const FEWEST: usize = 40;
/// Variance of a second difference over that of its independent terms.
const SECOND_DIFFERENCE: f64 = 1.5;
/// Correlation of neighbours is kept below this.
const HIGHEST: f64 = 0.99;

pub struct Scatter {
    pub scale: f64,
    pub correlation: Vec<f64>,
}

fn forgotten(width: f64, spacing: f64) -> usize {
    (FORGOTTEN * width / spacing).ceil() as usize
}

/// Robust scatter about neighbours just beyond the reach of the noise correlation; infinite if there are too few.
pub fn neighbour_scatter(position: &[f64], width: f64, spacing: f64) -> f64 {
    let variance = vec![1.0; position.len()];
    let ratio = ratio(position, &variance, forgotten(width, spacing).max(1), false, &mut Vec::new());
    if ratio.is_finite() {
        (ratio / SECOND_DIFFERENCE).sqrt()
    } else {
        f64::INFINITY
    }
}

/// Scale of the modelled uncertainty `u` and correlation of neighbours.
pub fn observe(position: &[f64], u: &[f64], width: f64, spacing: f64, closed: bool) -> Scatter {
    let far = forgotten(width, spacing).clamp(3, (position.len() / 16).max(3));
    let variance: Vec<f64> = u.iter().map(|u| u * u).collect();
    let mut buffer = Vec::with_capacity(position.len());
    let ratios: Vec<f64> = (1..far + 3).map(|lag| ratio(position, &variance, lag, closed, &mut buffer)).collect();
    if !ratios[far - 1].is_finite() {
        return Scatter { scale: 1.0, correlation: Vec::new() };
    }
    let mut beyond: Vec<f64> = ratios[far - 1..].iter().copied().filter(|r| !r.is_nan()).collect();
    let total = median(&mut beyond) / SECOND_DIFFERENCE;
    if total == 0.0 {
        return Scatter { scale: 1.0, correlation: Vec::new() };
    }
    let mut correlation = vec![0.0; 2 * far + 1];
    for lag in (1..far).rev() {
        // var(p_i - (p_i-k + p_i+k) / 2) = (1.5 - 2 rho_k + rho_2k / 2) sigma^2
        let seen = if ratios[lag - 1].is_finite() { ratios[lag - 1] / total } else { SECOND_DIFFERENCE };
        correlation[lag] = ((SECOND_DIFFERENCE + 0.5 * correlation[2 * lag] - seen) / 2.0).clamp(0.0, HIGHEST);
    }
    Scatter { scale: total.sqrt(), correlation: correlation[1..far].to_vec() }
}

/// Robust mean square of second differences at `lag` over the variance of their middle; NaN if too few.
fn ratio(position: &[f64], variance: &[f64], lag: usize, closed: bool, squares: &mut Vec<f64>) -> f64 {
    let count = position.len();
    squares.clear();
    if lag < count {
        let mut add = |before: usize, i: usize, after: usize| {
            let difference = position[i] - 0.5 * (position[before] + position[after]);
            let square = variance[i] + 0.25 * (variance[before] + variance[after]);
            let scaled = SECOND_DIFFERENCE * difference * difference / square;
            if scaled.is_finite() {
                squares.push(scaled);
            }
        };
        for i in lag..count.saturating_sub(lag) {
            add(i - lag, i, i + lag);
        }
        let ends = (0..lag.min(count)).chain(count.saturating_sub(lag).max(lag)..count);
        for i in ends.filter(|_| closed) {
            add((i + count - lag) % count, i, (i + lag) % count);
        }
    }
    if squares.len() < FEWEST {
        return f64::NAN;
    }
    median(squares) / (NORMAL_HALF * NORMAL_HALF)
}
