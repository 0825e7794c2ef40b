//! Which candidate on each ray is the line: the rule of the Python module `_chain`.

use super::chain;
use super::light::laser_light;
use super::rays::Rays;
use super::sampling::{Grey, Plane};
use super::scan::Candidates;

pub const OK: u8 = 0;
pub const RESOLVED: u8 = 1;
pub const SATURATED: u8 = 2;
pub const NO_PEAK: u8 = 3;
pub const MULTIPLE: u8 = 4;
pub const OFF_RING: u8 = 5;
pub const NOT_LASER: u8 = 6;

const SHORTEST: usize = 10;
const SLIGHT: f64 = 0.15;
const RIVAL: f64 = 0.5;

/// (chosen candidate, status) per ray; the candidate has no meaning where the status has no value.
pub fn line_among<T: Grey>(plane: &Plane<T>, rays: &Rays, candidates: &Candidates, width: f64) -> Vec<(usize, u8)> {
    let laser = laser_light(plane, rays, candidates, width);
    let mut lengths = chain::lengths(candidates, &laser, rays.spacing, rays.closed);
    lengths.iter_mut().for_each(|length| *length *= rays.stride);
    (0..candidates.rays()).map(|ray| choose(candidates, &lengths, candidates.of(ray))).collect()
}

fn choose(candidates: &Candidates, lengths: &[usize], range: std::ops::Range<usize>) -> (usize, u8) {
    let (mut pick, mut highest) = (range.start, 0.0f64);
    for index in range.clone().filter(|&index| lengths[index] > 0) {
        highest = highest.max(candidates.peaks[index].height);
        if lengths[index] > lengths[pick] {
            pick = index;
        }
    }
    if range.is_empty() {
        return (pick, NO_PEAK);
    }
    let best = lengths[pick];
    let counts = |&index: &usize| index != pick && (lengths[index] >= SHORTEST || candidates.peaks[index].height >= SLIGHT * highest);
    let rival = range.filter(counts).map(|index| lengths[index]).max().unwrap_or(0);
    let status = match (best, rival) {
        (0, _) => NOT_LASER,
        (best, _) if best < SHORTEST => OFF_RING,
        (best, rival) if rival as f64 > RIVAL * best as f64 && rival >= SHORTEST => MULTIPLE,
        (_, 0) => OK,
        _ => RESOLVED,
    };
    (pick, status)
}
