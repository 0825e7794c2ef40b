//! Peaks that are not looked at again, each fitted on its own (see the Python function `refine`).

use super::batch::Batch;
use super::describe::describe;
use super::fit::Fit;
use super::lanes::LANES;
use super::refine::{widest, LONGEST_STEP};
use super::settings::Settings;
use super::settle::Found;

/// One weighted Gauss-Newton step of every peak of `line` that has samples and for which `left` says so, from its own place and height.
pub fn alone(line: &mut Found, left: impl Fn(usize) -> bool, settings: &Settings) {
    let mut batch = Batch::new(settings);
    let mut fit = None;
    let mut rays = (0..line.position.len()).filter(|&ray| left(ray) && !line.samples[ray].is_empty()).peekable();
    let side = settings.side() as f64;
    while let Some(ray) = rays.next() {
        let first = (line.position[ray] + 0.5).floor() - side;
        let full = batch.add(line.samples[ray], (line.position[ray] - first, 0.0), ray);
        if !full && rays.peek().is_some() {
            continue;
        }
        describe(&mut batch, settings);
        let fit: &mut Fit = fit.get_or_insert_with(|| Fit::new(settings));
        let (moved, u) = (fit.step(&batch), fit.uncertainty());
        for lane in 0..std::mem::take(&mut batch.filled).min(LANES) {
            let (ray, moved) = (batch.rays[lane], moved.0[lane]);
            let span = batch.shape.fall.0[lane] - batch.shape.rise.0[lane];
            let left_it = moved.abs() > LONGEST_STEP;
            let own = if moved.is_nan() { widest(&batch.shape, lane) } else { u.0[lane].min(span) };
            line.u[ray] = if left_it { own.hypot(moved.abs().min(span)) } else { own };
            line.position[ray] += if left_it || moved.is_nan() { 0.0 } else { moved };
        }
    }
}
