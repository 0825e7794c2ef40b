//! What differs along the line, told piece by piece (see the Python module `_pieces`).

use std::ops::Range;

pub const PIECES: usize = 16;
pub const FEWEST: f64 = 8.0;

/// Of a number for every piece.
pub type Pieces = [f64; PIECES];

/// Number of the piece that `ray` of so many lies on.
pub fn piece(ray: usize, count: usize) -> usize {
    ray * PIECES / count
}

/// Of so many rays those on a piece.
pub fn rays_of(piece: usize, count: usize) -> Range<usize> {
    (piece * count).div_ceil(PIECES)..((piece + 1) * count).div_ceil(PIECES)
}

/// `values`, those that are NaN from the pieces on both sides; None where fewer than half are known.
pub fn bridged(values: Pieces, closed: bool) -> Option<Pieces> {
    let known: Vec<usize> = (0..PIECES).filter(|&k| values[k].is_finite()).collect();
    if 2 * known.len() < PIECES {
        return None;
    }
    let (first, last) = (known[0], known[known.len() - 1]);
    let between = |k: usize| {
        let before = known.iter().rev().find(|&&other| other <= k).copied();
        let after = known.iter().find(|&&other| other >= k).copied();
        match (before, after) {
            (Some(before), Some(after)) => interpolated((before, values[before]), (after, values[after]), k as f64),
            (Some(before), None) if closed => interpolated((before, values[before]), (first + PIECES, values[first]), k as f64),
            (None, Some(after)) if closed => interpolated((last, values[last]), (after + PIECES, values[after]), (k + PIECES) as f64),
            (Some(end), None) | (None, Some(end)) => values[end],
            (None, None) => f64::NAN,
        }
    };
    Some(std::array::from_fn(between))
}

fn interpolated((before, low): (usize, f64), (after, high): (usize, f64), place: f64) -> f64 {
    match after - before {
        0 => low,
        span => low + (high - low) * (place - before as f64) / span as f64,
    }
}

/// Each of `values` with half the mean of those on both sides.
pub fn smoothed(values: Pieces, closed: bool) -> Pieces {
    let (before, after) = match closed {
        true => (values[PIECES - 1], values[0]),
        false => (values[0], values[PIECES - 1]),
    };
    std::array::from_fn(|k| {
        let (left, right) = (if k == 0 { before } else { values[k - 1] }, if k + 1 == PIECES { after } else { values[k + 1] });
        0.25 * left + 0.5 * values[k] + 0.25 * right
    })
}

/// `values` of the middles of the pieces at `ray` of so many.
pub fn along(values: &Pieces, ray: usize, count: usize, closed: bool) -> f64 {
    let place = (ray as f64 + 0.5) * PIECES as f64 / count as f64 - 0.5;
    let beyond = |k: usize| if closed { k % PIECES } else { k.min(PIECES - 1) };
    match place < 0.0 {
        true => interpolated((0, values[if closed { PIECES - 1 } else { 0 }]), (1, values[0]), place + 1.0),
        false => {
            let low = place as usize;
            interpolated((low, values[low]), (low + 1, values[beyond(low + 1)]), place)
        }
    }
}
