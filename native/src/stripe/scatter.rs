//! Scatter of neighbouring peaks (see the Python module `_scatter`).

const NORMAL_HALF: f64 = 0.6745;
const FEWEST: usize = 40;

/// Robust mean square of second differences at `lag` over the squared uncertainty of their middle; NaN if too few.
pub fn ratio(position: &[f64], u: &[f64], lag: usize, closed: bool) -> f64 {
    let count = position.len();
    let mut z: Vec<f64> = Vec::with_capacity(count);
    let (first, end) = if closed { (0, count) } else { (lag.min(count), count.saturating_sub(lag)) };
    for i in first..end {
        let (before, after) = ((i + count - lag % count) % count, (i + lag) % count);
        let difference = position[i] - 0.5 * (position[before] + position[after]);
        let square = (u[i] * u[i] + 0.25 * u[before] * u[before] + 0.25 * u[after] * u[after]) / 1.5;
        let scaled = difference.abs() / square.sqrt();
        if scaled.is_finite() {
            z.push(scaled);
        }
    }
    if z.len() < FEWEST {
        return f64::NAN;
    }
    (median(&mut z) / NORMAL_HALF).powi(2)
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    let even = values.len() % 2 == 0;
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if even {
        let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (lower + upper)
    } else {
        upper
    }
}
