//! What the line says about its own noise: the scatter of neighbouring peaks (see the Python modules `_scatter` and `_features`).

use super::features::mean_square;
use super::statistics::{median, middle_two};
use super::vectors::{vectorised, Vectors};

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

/// Places along a line and the variance of each; NaN where there is none.
struct Places<'a> {
    position: &'a [f64],
    variance: Vec<f64>,
    closed: bool,
    vectors: Vectors,
}

fn forgotten(width: f64, spacing: f64) -> usize {
    (FORGOTTEN * width / spacing).ceil() as usize
}

/// Robust scatter about neighbours just beyond the reach of the noise correlation; infinite if there are too few.
pub fn neighbour_scatter(position: &[f64], width: f64, spacing: f64, vectors: Vectors) -> f64 {
    let places = Places { position, variance: vec![1.0; position.len()], closed: false, vectors };
    let mut squares = vec![0.0; position.len()];
    let known = places.squares(forgotten(width, spacing).max(1), &mut squares);
    match robust_square(&mut squares, known) {
        Some((ratio, _)) => (ratio / SECOND_DIFFERENCE).sqrt(),
        None => f64::INFINITY,
    }
}

/// Scale of the modelled uncertainty `u` and correlation of neighbours, freed of features of the wall where enough differences are left.
pub fn observe(position: &[f64], u: &[f64], width: f64, spacing: f64, closed: bool, vectors: Vectors) -> Scatter {
    let far = forgotten(width, spacing).clamp(3, (position.len() / 16).max(3));
    let places = Places { position, variance: u.iter().map(|u| u * u).collect(), closed, vectors };
    let (mut ratios, mut freed, mut squares) = (Vec::with_capacity(far + 2), Vec::with_capacity(far + 2), vec![0.0; position.len()]);
    for lag in 1..far + 3 {
        let known = places.squares(lag, &mut squares);
        let (ratio, start) = robust_square(&mut squares, known).unwrap_or((f64::NAN, f64::NAN));
        ratios.push(ratio);
        freed.push(if start.is_nan() { start } else { mean_square(&squares, start, vectors) });
    }
    let mut beyond: Vec<f64> = ratios[far - 1..].iter().copied().filter(|r| !r.is_nan()).collect();
    let total = median(&mut beyond) / SECOND_DIFFERENCE;
    if !ratios[far - 1].is_finite() || total == 0.0 {
        return Scatter { scale: 1.0, correlation: Vec::new() };
    }
    let known = freed[far - 1..].iter().all(|square| !square.is_nan());
    let calm = median(&mut freed[far - 1..].to_vec()) / SECOND_DIFFERENCE;
    if known && calm > 0.0 && calm < f64::INFINITY {
        return Scatter { scale: calm.sqrt(), correlation: correlation(&freed, calm, far) };
    }
    Scatter { scale: total.sqrt(), correlation: correlation(&ratios, total, far) }
}

/// Of neighbouring peaks at lags 1 to `far` - 1, from the mean squares `ratios` of second differences at those.
fn correlation(ratios: &[f64], total: f64, far: usize) -> Vec<f64> {
    let mut correlation = vec![0.0; 2 * far + 1];
    for lag in (1..far).rev() {
        // var(p_i - (p_i-k + p_i+k) / 2) = (1.5 - 2 rho_k + rho_2k / 2) sigma^2
        let seen = if ratios[lag - 1].is_finite() { ratios[lag - 1] / total } else { SECOND_DIFFERENCE };
        correlation[lag] = ((SECOND_DIFFERENCE + 0.5 * correlation[2 * lag] - seen) / 2.0).clamp(0.0, HIGHEST);
    }
    correlation[1..far].to_vec()
}

/// Robust mean square of the `known` smallest, as the median tells it and as its upper neighbour does; none if too few. Reorders `squares`.
fn robust_square(squares: &mut [f64], known: usize) -> Option<(f64, f64)> {
    let of_median = |median: f64| median / (NORMAL_HALF * NORMAL_HALF);
    (known >= FEWEST).then(|| {
        let (lower, upper) = middle_two(squares, known);
        (of_median(0.5 * (lower + upper)), of_median(upper))
    })
}

impl Places<'_> {
    /// The squared second differences at `lag` over the variance of their middle, infinite where there is none; and how many there are.
    fn squares(&self, lag: usize, squares: &mut [f64]) -> usize {
        let (places, vectors) = (self, self.vectors);
        vectorised!(vectors, squares_of(places: &Places<'_>, lag: usize, squares: &mut [f64]) -> usize)
    }
}

#[inline(always)]
fn squares_of(places: &Places<'_>, lag: usize, squares: &mut [f64]) -> usize {
    let (position, variance, count) = (places.position, &places.variance[..], places.position.len());
    let square = |(b, vb): (f64, f64), (p, v): (f64, f64), (a, va): (f64, f64)| {
        let difference = p - 0.5 * (b + a);
        let square = SECOND_DIFFERENCE * difference * difference / (v + 0.25 * (vb + va));
        if square.is_finite() {
            square
        } else {
            f64::INFINITY
        }
    };
    let near = lag.min(count);
    squares[..near].fill(f64::INFINITY);
    squares[count.saturating_sub(lag)..].fill(f64::INFINITY);
    if 2 * lag < count {
        let middles = position[lag..].iter().zip(&variance[lag..]);
        let befores = position.iter().zip(variance);
        let afters = position[2 * lag..].iter().zip(&variance[2 * lag..]);
        for (scaled, (((b, vb), (p, v)), (a, va))) in squares[lag..].iter_mut().zip(befores.zip(middles).zip(afters)) {
            *scaled = square((*b, *vb), (*p, *v), (*a, *va));
        }
    } else {
        squares.fill(f64::INFINITY);
    }
    if places.closed {
        let at = |i: usize| (position[i % count], variance[i % count]);
        for i in (0..near).chain(count.saturating_sub(lag).max(lag)..count) {
            squares[i] = square(at(i + count - near), at(i), at(i + lag));
        }
    }
    squares.iter().map(|square| u64::from(*square < f64::INFINITY)).sum::<u64>() as usize
}
