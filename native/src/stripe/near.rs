//! Where peaks lie under the settings learnt so far, near the highest ones of the first look (see the Python module `_learn`).

use super::batch::Batch;
use super::describe::describe;
use super::fit::Fit;
use super::lanes::LANES;
use super::peak::{margin, Finder};
use super::rays::Rays;
use super::refine::{has_left, moved_place};
use super::sampling::{Grey, Plane};
use super::scan::{gate_of, Candidates};
use super::settings::Settings;
use super::statistics::floor;
use super::trace::Trace;

/// The highest peak near each ray's highest candidate, fitted under several trials.
pub struct Near<'a, const N: usize> {
    settings: &'a Settings,
    /// Peaks as they come, and those kept, not yet fitted.
    batch: Batch,
    kept: Batch,
    trials: [Trial; N],
    peaks: usize,
}

/// Places under one noise model, NaN on rays without a peak; and how many of them the step to the model's place has left.
struct Trial {
    fit: Fit,
    places: Vec<f64>,
    lost: usize,
}

/// Places near the candidates `found` under every one of the `trials`, which differ in additive noise only, NaN on rays without a peak; and the
/// share of them that the step to the model's place has left.
pub fn places_near<T: Grey, const N: usize>(
    plane: &Plane<T>,
    rays: &Rays,
    found: &Candidates,
    settings: &Settings,
    trials: &[Settings; N],
) -> [(Vec<f64>, f64); N] {
    let (gate, margin, reach) = (gate_of(settings), margin(settings), 2 * settings.reach() as i64);
    let (mut finder, mut trace) = (Finder::new(settings), Trace::new(rays.samples));
    let trials = trials.each_ref().map(|trial| Trial { fit: Fit::new(trial), places: vec![f64::NAN; rays.rays.len()], lost: 0 });
    let mut near = Near { settings, batch: Batch::new(settings), kept: Batch::new(settings), trials, peaks: 0 };
    for (index, (ray, highest)) in rays.rays.iter().zip(found.highest()).enumerate() {
        let Some(peak) = highest else { continue };
        let middle = floor(peak.position);
        let end = ((middle + reach + 2).max(0) as usize).min(rays.samples);
        let span = ((middle - reach).max(0) as usize, end);
        trace.read(plane, &ray.track(), span, gate, margin);
        finder.crossings(&trace, |position| {
            if near.batch.add(trace.values(), position, index) {
                near.keep();
            }
        });
    }
    near.keep();
    near.fit();
    let peaks = near.peaks.max(1) as f64;
    near.trials.map(|trial| (trial.places, trial.lost as f64 / peaks))
}

impl<const N: usize> Near<'_, N> {
    /// Keeps the peaks of the batch that stand out, the highest of each ray, and empties it.
    fn keep(&mut self) {
        describe(&mut self.batch, self.settings);
        for from in 0..std::mem::take(&mut self.batch.filled) {
            if !self.batch.shape.stands[from] {
                continue;
            }
            let last = self.kept.filled.checked_sub(1).filter(|&last| self.kept.rays[last] == self.batch.rays[from]);
            match last {
                Some(last) if self.batch.shape.height.0[from] > self.kept.shape.height.0[last] => self.kept.put(last, &self.batch, from),
                Some(_) => {}
                None => {
                    if self.kept.filled == LANES {
                        self.fit();
                    }
                    self.kept.put(self.kept.filled, &self.batch, from);
                    self.kept.filled += 1;
                }
            }
        }
    }

    /// Fits those kept under every trial.
    fn fit(&mut self) {
        let kept = &mut self.kept;
        for trial in &mut self.trials {
            let moved = trial.fit.step(kept);
            for lane in 0..kept.filled {
                trial.places[kept.rays[lane]] = moved_place(kept.position.0[lane], moved.0[lane]);
                trial.lost += usize::from(has_left(moved.0[lane]));
            }
        }
        self.peaks += std::mem::take(&mut kept.filled);
    }
}
