//! One line of light as rays on the wall and as a ring on the clock grid: the twin of `calibore.profiling._line_ring`.

use std::f64::consts::{PI, TAU};

use super::gridding::{grid, root_of_squares, Gridded, Rays};
use super::statistics::turned;
use crate::meeting::measure::Pixels;
use crate::meeting::modes::Mode;
use crate::meeting::placing::{place_all, Placed};
use crate::meeting::rig::Make;

/// See `calibore.status.Status`.
pub mod status {
    pub const OK: u8 = 0;
    pub const SATURATED: u8 = 2;
    pub const NO_PEAK: u8 = 3;
    pub const GRAZING: u8 = 8;
    pub const EXTRAPOLATED: u8 = 11;
    pub const WATER: u8 = 15;
}

/// What was found in the picture, ray by ray: `enlargement` one number or one for each.
pub struct Line<'a> {
    pub u_position: &'a [f64],
    pub status: &'a [u8],
    pub enlargement: &'a [f64],
    pub correlation: &'a [f64],
    /// Rays whose meeting is too near to ceasing to be; empty: none.
    pub grazing: &'a [bool],
}

/// Where the rig was calibrated: zenith and radius from, to.
pub struct Valid {
    pub zenith: [f64; 2],
    pub radius: [f64; 2],
}

/// x, y, z, radius, clock and standard uncertainty of the radius over the rays, their status, and the ring.
pub struct OnWall {
    pub rays: [Vec<f64>; 6],
    pub status: Vec<u8>,
    pub ring: Gridded,
}

/// None where no ray meets the light. `stated`: standard uncertainty of a line position, if not the observed.
pub fn on_wall(
    (make, parameters, modes): (&Make, &[f64], &[Mode]),
    pixels: &Pixels,
    line: &Line,
    (stated, valid, positions): (Option<f64>, Option<&Valid>, usize),
) -> Option<OnWall> {
    let mut placed = place_all(make, parameters, modes, pixels);
    let n = placed.status.len();
    let there = |status: u8| [status::OK, status::GRAZING].contains(&status);
    let grazing = (0..line.grazing.len()).filter(|&i| line.grazing[i]);
    grazing.for_each(|i| {
        if there(placed.status[i]) {
            forget(&mut placed, i)
        }
    });
    let mut status: Vec<u8> = placed.status.iter().zip(line.status).map(|(&place, &line)| told(place, line)).collect();
    if let Some(valid) = valid {
        tell_outside(valid, &placed, &mut status);
    }
    let clock = every_clock(&placed.columns[4])?;
    let [x, y, z, radius, _, along, turn, _] = placed.columns;
    let enlargement: Vec<f64> = (0..n).map(|i| line.enlargement[i.min(line.enlargement.len() - 1)]).collect();
    let common = |i: usize| placed.radial.iter().map(|mode| mode[i] * mode[i]).sum::<f64>().sqrt();
    let u_radius = (0..n).map(|i| root_of_squares(along[i] * line.u_position[i] * enlargement[i], common(i))).collect();
    let rays = Rays {
        clock: &clock,
        radius: &radius,
        axial: &z,
        along: &along,
        turn: &turn,
        u_position: line.u_position,
        enlargement: &enlargement,
        status: &status,
        radial: &placed.radial,
        turned: &placed.turned,
    };
    let ring = grid(&rays, line.correlation, stated, positions);
    Some(OnWall { rays: [x, y, z, radius, clock, u_radius], status, ring })
}

fn forget(placed: &mut Placed, i: usize) {
    placed.status[i] = status::GRAZING;
    placed.columns.iter_mut().take(7).chain(&mut placed.radial).chain(&mut placed.turned).for_each(|column| column[i] = f64::NAN);
}

/// What is said of a ray: what the picture says, unless its meeting with the light is no good.
fn told(place: u8, line: u8) -> u8 {
    if line <= status::SATURATED && place != status::OK {
        place
    } else {
        line
    }
}

fn tell_outside(valid: &Valid, placed: &Placed, status: &mut [u8]) {
    let within = |value: f64, [low, high]: [f64; 2]| value >= low && value <= high;
    for (i, told) in status.iter_mut().enumerate() {
        let zenith = placed.columns[7][i].clamp(-1.0, 1.0).acos();
        let inside = within(zenith, valid.zenith) && within(placed.columns[3][i], valid.radius);
        if has_value(*told) && !inside {
            *told = status::EXTRAPOLATED;
        }
    }
}

pub fn has_value(status: u8) -> bool {
    status <= status::SATURATED || status == status::EXTRAPOLATED
}

/// `clock` with its gaps interpolated round the ring; none where there is nothing.
fn every_clock(clock: &[f64]) -> Option<Vec<f64>> {
    let found: Vec<usize> = (0..clock.len()).filter(|&i| clock[i].is_finite()).collect();
    let (&first, &last) = (found.first()?, found.last()?);
    let mut turns = vec![clock[first]];
    for pair in found.windows(2) {
        let step = turned(clock[pair[1]] - clock[pair[0]] + PI, TAU) - PI;
        turns.push(turns[turns.len() - 1] + step);
    }
    let sense = if turns[turns.len() - 1] < turns[0] { -TAU } else { TAU };
    let (n, end) = (clock.len() as f64, turns[turns.len() - 1]);
    let mut every = vec![0.0; clock.len()];
    let mut fill = |(from, low): (f64, f64), (to, high): (f64, f64)| {
        let slope = (high - low) / (to - from);
        for i in from.max(0.0) as usize..(to.min(n - 1.0) as usize + 1).min(clock.len()) {
            every[i] = turned(slope * (i as f64 - from) + low, TAU);
        }
    };
    fill((last as f64 - n, end - sense), (first as f64, turns[0]));
    fill((last as f64, end), (first as f64 + n, turns[0] + sense));
    for (k, pair) in found.windows(2).enumerate() {
        fill((pair[0] as f64, turns[k]), (pair[1] as f64, turns[k + 1]));
    }
    Some(every)
}
