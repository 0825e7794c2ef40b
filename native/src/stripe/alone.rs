//! Peaks that are not looked at again, each fitted on its own (see the Python function `refine`).

use super::batch::Batch;
use super::describe::describe;
use super::fit::Fit;
use super::lanes::LANES;
use super::rays::Rays;
use super::refine::{widest, LONGEST_STEP};
use super::sampling::{Grey, Plane};
use super::settings::Settings;
use super::settle::Found;
use super::walk::GROUP;

/// One weighted Gauss-Newton step of every peak of `line` that has samples and for which `left` says so, from its own place and height; there
/// are as many samples `beside` each as the settings before asked for.
pub fn alone<T: Grey>(
    (plane, rays): (&Plane<T>, &Rays),
    line: &mut Found,
    beside: usize,
    left: impl Fn(usize) -> bool,
    settings: &Settings,
) {
    let (enough, mut whole) = (settings.side() <= beside, vec![f64::NAN; rays.samples + GROUP]);
    let mut batch = Batch::new(settings);
    let mut fit = None;
    let mut some = (0..line.position.len()).filter(|&ray| left(ray) && !line.samples[ray].is_empty()).peekable();
    while let Some(ray) = some.next() {
        let (first, samples) = match enough {
            true => ((line.position[ray] + 0.5).floor() - beside as f64, line.samples[ray]),
            false => (0.0, plane.whole(&rays.rays[ray], &mut whole)),
        };
        let full = batch.add(samples, (line.position[ray] - first, 0.0), ray);
        if !full && some.peek().is_some() {
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
