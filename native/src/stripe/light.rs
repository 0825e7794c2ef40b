//! Laser light or other light: told by how wide a peak is and what colour it has (see the Python module `_light`).

use super::rays::Rays;
use super::sampling::{Grey, Plane};
use super::scan::{Candidates, Peak};
use super::statistics::median;

const WIDEST: f64 = 3.0;
const FOREIGN: f64 = 0.35;

/// Which candidates look like laser light of a line of `width`.
pub fn laser_light<T: Grey>(plane: &Plane<T>, rays: &Rays, candidates: &Candidates, width: f64) -> Vec<bool> {
    let mut laser: Vec<bool> = candidates.peaks.iter().map(|peak| peak.width <= WIDEST * width).collect();
    if plane.bands == 1 {
        return laser;
    }
    let mut share = Vec::with_capacity(laser.len());
    for (ray, line) in rays.rays.iter().enumerate() {
        share.extend(candidates.peaks[candidates.of(ray)].iter().map(|peak| foreign_share(plane, line.at(peak.position), peak)));
    }
    let mut of_laser: Vec<f64> = share.iter().zip(&laser).filter(|(_, laser)| **laser).map(|(share, _)| *share).collect();
    if all_near_median(&of_laser) {
        return laser;
    }
    let most = median(&mut of_laser) + FOREIGN;
    for (laser, share) in laser.iter_mut().zip(share) {
        *laser &= !(share > most);
    }
    laser
}

/// Whether no share can be above the median by as much as that of foreign light: the usual picture, decided without the median.
fn all_near_median(shares: &[f64]) -> bool {
    let highest = shares.iter().fold(f64::NEG_INFINITY, |highest, &share| share.max(highest));
    // with some of it to spare for rounding
    let least = highest - 0.999 * FOREIGN;
    2 * shares.iter().filter(|share| **share >= least).count() > shares.len() + 1
}

/// Brightest other colour over the own colour, both above the own colour's background.
fn foreign_share<T: Grey>(plane: &Plane<T>, [column, row]: [f64; 2], peak: &Peak) -> f64 {
    let nearest = |value: f64, count: usize| ((value + 0.5).max(0.0) as i64 as usize).min(count - 1);
    let at = plane.index(nearest(column, plane.width), nearest(row, plane.height)) - plane.band;
    let (mut own, mut rest) = (0.0, f64::NEG_INFINITY);
    for (band, &value) in plane.data[at..at + plane.bands].iter().enumerate() {
        let value: f64 = value.into();
        if band == plane.band {
            own = value;
        } else {
            rest = value.max(rest);
        }
    }
    (rest - peak.background) / (own - peak.background).max(1.0)
}
