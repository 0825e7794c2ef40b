//! The sub-pixel place of a peak and its standard uncertainty, by the estimator asked for (see the Python module `_refine`).

use super::fit::{Batch, Fit};
use super::literature::{brightest, centroid, correlation, parabola};
use super::peak::Standing;
use super::scan::Peak;
use super::settings::{Estimator, Settings};

/// A step longer than this has left the peak.
const LONGEST_STEP: f64 = 2.0;

/// Refines many peaks under the same settings.
pub struct Refiner<'a> {
    settings: &'a Settings,
    fit: Fit,
    batch: Batch,
}

impl<'a> Refiner<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        Refiner { settings, fit: Fit::new(settings), batch: Batch::new() }
    }

    /// Place of a peak on a ray of samples `y` before any Gauss-Newton step, or none where the estimator finds no peak.
    pub fn place(&self, y: &[f64], peak: &Standing) -> Option<f64> {
        let window = || {
            let (middle, half) = ((peak.position + 0.5) as usize, self.fit.half());
            let low = middle.saturating_sub(half);
            (low, &y[low..=(middle + half).min(y.len() - 1)])
        };
        match self.settings.estimator {
            Estimator::ZeroCrossing | Estimator::Crossing => Some(peak.position),
            Estimator::Parabola => parabola(y, peak, self.settings.window),
            Estimator::Maximum => Some(brightest(window())),
            Estimator::Threshold => Some(0.5 * (peak.rise + peak.fall)),
            Estimator::Centroid => Some(centroid(window(), peak.background)),
            Estimator::Correlation => Some(correlation(window(), peak, self.settings.noise.width)),
        }
    }

    /// Has the peak at `index` of `peaks`, `standing` on a ray of samples `y`, fitted now or with later ones.
    pub fn add(&mut self, y: &[f64], standing: &Standing, index: usize, peaks: &mut [Peak]) {
        if self.settings.estimator != Estimator::Crossing && self.batch.add(y, self.fit.half(), standing, index) {
            self.finish(peaks);
        }
    }

    /// Fits the peaks that are waiting.
    pub fn finish(&mut self, peaks: &mut [Peak]) {
        let (moved, u) = (self.fit.step(&self.batch), self.fit.uncertainty());
        for lane in 0..self.batch.filled {
            let (standing, peak) = (&self.batch.peaks[lane], &mut peaks[self.batch.targets[lane]]);
            let u = if moved.0[lane].is_nan() { (standing.fall - standing.rise) / 12f64.sqrt() } else { u.0[lane] };
            peak.u = match self.settings.estimator {
                Estimator::ZeroCrossing => {
                    peak.position = moved_place(standing, moved.0[lane]);
                    if moved.0[lane].abs() > LONGEST_STEP {
                        u.hypot(moved.0[lane])
                    } else {
                        u
                    }
                }
                Estimator::Maximum => u.hypot((1.0f64 / 12.0).sqrt()),
                _ => u,
            };
        }
        self.batch.filled = 0;
    }
}

/// The place of a peak after its Gauss-Newton step; the zero crossing where that has left the peak or there is none.
pub fn moved_place(peak: &Standing, moved: f64) -> f64 {
    peak.position + if has_left(moved) { 0.0 } else { moved }
}

/// Whether a Gauss-Newton step has left the peak, or there is none.
pub fn has_left(moved: f64) -> bool {
    !(moved.abs() <= LONGEST_STEP)
}
