//! The peaks that the settings learnt so far show where the first look has found the highest ones (see the Python module `_learn`).

use super::fit::{Batch, Fit};
use super::lanes::LANES;
use super::peak::{margin, Finder, Standing};
use super::rays::Rays;
use super::refine::{has_left, moved_place};
use super::sampling::{Grey, Plane};
use super::scan::{gate_of, Candidates};
use super::settings::Settings;
use super::statistics::floor;
use super::trace::{Look, Trace};

/// The highest peak near each ray's highest candidate, ready to be fitted.
pub struct Near {
    batches: Vec<Batch>,
    rays: usize,
}

impl Near {
    pub fn highest<T: Grey>(plane: &Plane<T>, rays: &Rays, found: &Candidates, settings: &Settings) -> Near {
        let (gate, margin, reach) = (gate_of(settings), margin(settings), 2 * settings.reach() as i64);
        let (mut finder, mut trace) = (Finder::new(settings), Trace::new(rays.samples));
        let (mut batches, mut batch) = (Vec::with_capacity(rays.rays.len() / LANES + 1), Batch::new());
        for (index, (ray, highest)) in rays.rays.iter().zip(found.highest()).enumerate() {
            let Some(peak) = highest else { continue };
            let (middle, mut best): (i64, Option<Standing>) = (floor(peak.position), None);
            let end = ((middle + reach + 2).max(0) as usize).min(rays.samples);
            let span = ((middle - reach).max(0) as usize, end);
            trace.read(plane, &ray.track(), Look::Within(span), gate, margin);
            finder.standing(&trace, |peak| best = best.filter(|b| b.height >= peak.height).or(Some(peak)));
            if best.is_some_and(|peak| batch.add(trace.values(), settings.half_fit(), &peak, index)) {
                batches.push(std::mem::replace(&mut batch, Batch::new()));
            }
        }
        batches.push(batch);
        Near { batches, rays: rays.rays.len() }
    }

    /// Their places under every one of the `trials`, which differ in additive noise only, NaN on rays without a peak; and the share of them
    /// that the step to the model's place has left.
    pub fn places_under<const N: usize>(&self, trials: &[Settings; N]) -> [(Vec<f64>, f64); N] {
        trials.each_ref().map(|settings| {
            let (mut fit, mut places, mut seen, mut lost) = (Fit::new(settings), vec![f64::NAN; self.rays], 0usize, 0usize);
            for batch in &self.batches {
                let moved = fit.step(batch);
                for lane in 0..batch.filled {
                    places[batch.targets[lane]] = moved_place(&batch.peaks[lane], moved.0[lane]);
                    lost += usize::from(has_left(moved.0[lane]));
                }
                seen += batch.filled;
            }
            let share = lost as f64 / seen.max(1) as f64;
            (places, share)
        })
    }
}
