//! Where on its ray the final scan looks, from what every fifth ray has shown (see the Python module `_guide`).

use super::chain::{SLACK, STEEPEST};
use super::scan::Candidates;
use super::statistics::floor;

/// Every fifth ray is enough to find the centre and to learn the noise.
pub const COARSE: usize = 5;
/// Pixels looked at on each side of what the coarse scan found, at least.
pub const LEAST_MARGIN: f64 = 12.0;

/// First and end sample to look for peaks, for each coarse ray and those after it.
pub fn guided_spans(coarse: &Candidates, samples: usize, spacing: f64, shift: f64) -> Vec<(usize, usize)> {
    let margin = LEAST_MARGIN.max(SLACK + STEEPEST * spacing) + shift;
    let extent = |ray: usize| {
        let places = coarse.peaks[coarse.of(ray)].iter().map(|peak| peak.position);
        places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), place| (place.min(low), place.max(high)))
    };
    let extents: Vec<(f64, f64)> = (0..coarse.rays()).map(extent).collect();
    let count = extents.len();
    let span = |group: usize| {
        let around = (0..4).map(|k| extents[(group + count + k - 1) % count]);
        let (low, high) = around.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        if low > high || shift > LEAST_MARGIN {
            return (0, samples);
        }
        (floor(low - margin).max(0) as usize, (floor(high + margin + 1.0).max(0) as usize).min(samples))
    };
    (0..count).map(span).collect()
}
