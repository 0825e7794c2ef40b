//! Entries of the fuzzing targets in `native/fuzz`: `measure_points` and `draw_points` below Python.

use super::drawing::{draw_all, Plan};
use super::draws::SUMMARY;
use super::measure::{Choice, Pixels, Shared, COLUMNS};
use super::modes::{Mode, MODE};
use super::points::measure_all;
use super::rig::Make;

/// Kind of surface, side-facing, lens law, half image height, residual.
pub type Makes = (u8, bool, u8, f64, bool);

/// Numbers of one mode.
pub const MODE_NUMBERS: usize = MODE;

/// Pixels and what is told with each.
#[derive(Clone, Copy)]
pub struct Points<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub choice: &'a [f64],
    pub noise: &'a [f64],
    pub direction: Option<[&'a [f64]; 2]>,
}

/// How many parameters such a rig has; None where there is no such rig.
pub fn parameters(make: Makes) -> Option<usize> {
    Some(Make::new(make.0, make.1, make.2, make.3, make.4)?.parameters())
}

/// Columns and status.
pub fn measured(make: Makes, rig: &[f64], modes: &[f64], points: Points, numbered: bool, threads: usize) -> (Vec<f64>, Vec<u8>) {
    let make = Make::new(make.0, make.1, make.2, make.3, make.4).expect("a make that `parameters` knows");
    let modes: Vec<Mode> = modes.as_chunks::<MODE>().0.iter().map(Mode::of).collect();
    let choice = Shared(points.choice);
    let pixels = Pixels {
        u: points.u,
        v: points.v,
        choice: if numbered { Choice::Numbered(choice) } else { Choice::Nearest(choice) },
        noise: Shared(points.noise),
        direction: points.direction,
    };
    let (mut columns, mut status) = (vec![0.0; COLUMNS * points.u.len()], vec![0; points.u.len()]);
    measure_all(&make, rig, &modes, &pixels, &mut columns, &mut status, threads);
    (columns, status)
}

/// A summary for each point; `rigs` holds a row of parameters per draw, `points.choice` the branch.
pub fn drawn(make: Makes, rig: &[f64], rigs: &[f64], points: Points, (seed, probability): (u64, Option<f64>), threads: usize) -> Vec<f64> {
    let make = Make::new(make.0, make.1, make.2, make.3, make.4).expect("a make that `parameters` knows");
    let Points { u, v, choice: branch, noise, direction } = points;
    let plan = Plan { make, parameters: rig, rigs, seed, probability, u, v, branch, noise, direction };
    let mut summaries = vec![[0.0; SUMMARY]; u.len()];
    let mut kept = vec![0.0; 2 * u.len() * plan.draws()];
    draw_all(&plan, &mut summaries, &mut kept, threads);
    summaries.into_flattened()
}
