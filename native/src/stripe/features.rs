//! The scatter of a line freed of what features of the wall add to it (see the Python module `_features`).

use super::vectors::{vectorised, Vectors};

/// Square of the standard deviations from which a difference counts as a feature.
const CUT_SQUARE: f64 = 6.25;
/// Mean square of a standard normal z nearer than that.
const KEPT: f64 = 0.911255;
const ROUNDS: usize = 12;
/// Sums added up side by side.
const SIDE_BY_SIDE: usize = 8;

/// Mean of `squares` that features add nothing to: those are cut off and the rest averaged, in rounds that start from a mean of `size`.
pub fn mean_square(squares: &[f64], mut size: f64, vectors: Vectors) -> f64 {
    let mut kept = 0;
    for _ in 0..ROUNDS {
        let (before, (count, sum)) = (kept, below(squares, CUT_SQUARE * size, vectors));
        kept = count;
        if kept == 0 || kept == before {
            break;
        }
        size = sum / kept as f64 / KEPT;
    }
    size
}

/// Number and sum of the `values` below a limit.
fn below(values: &[f64], limit: f64, vectors: Vectors) -> (usize, f64) {
    vectorised!(vectors, below_of(values: &[f64], limit: f64) -> (usize, f64))
}

#[inline(always)]
fn below_of(values: &[f64], limit: f64) -> (usize, f64) {
    let (mut counts, mut sums) = ([0.0; SIDE_BY_SIDE], [0.0; SIDE_BY_SIDE]);
    let mut add = |values: &[f64; SIDE_BY_SIDE]| {
        for (k, &value) in values.iter().enumerate() {
            counts[k] += if value < limit { 1.0 } else { 0.0 };
            sums[k] += if value < limit { value } else { 0.0 };
        }
    };
    let (whole, rest) = values.as_chunks();
    whole.iter().for_each(&mut add);
    let mut last = [f64::INFINITY; SIDE_BY_SIDE];
    last[..rest.len()].copy_from_slice(rest);
    add(&last);
    (counts.iter().sum::<f64>() as usize, sums.iter().sum())
}
