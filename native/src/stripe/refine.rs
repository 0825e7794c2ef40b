//! The sub-pixel place of a peak and its standard uncertainty, by the estimator asked for (see the Python module `_refine`).

use super::batch::{Batch, Shape};
use super::describe::describe;
use super::fit::Fit;
use super::lanes::Lanes;
use super::literature::{brightest, centroid, correlation, parabola};
use super::scan::{Candidates, Peak};
use super::settings::{Estimator, Settings};

/// A step longer than this has left the peak.
pub const LONGEST_STEP: f64 = 2.0;
const FULL_WIDTH: f64 = 2.354820045;

/// Describes and refines many peaks under the same settings.
pub struct Refiner<'a> {
    settings: &'a Settings,
    fit: Fit,
    batch: Batch,
}

impl<'a> Refiner<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        Refiner { settings, fit: Fit::new(settings), batch: Batch::new(settings) }
    }

    /// Has the peak at `position` (and the fraction of it between two windows) on a ray of samples `y` refined now or with later ones.
    #[inline(always)]
    pub fn add(&mut self, y: &[f64], position: (f64, f64), ray: usize, found: &mut Candidates) {
        if self.batch.add(y, position, ray) {
            self.finish(found);
        }
    }

    /// Adds the waiting ones that stand out to those `found`.
    pub fn finish(&mut self, found: &mut Candidates) {
        describe(&mut self.batch, self.settings);
        let (moved, u) = self.fitted();
        for lane in (0..self.batch.filled).filter(|&lane| self.batch.shape.stands[lane]) {
            let Some(place) = self.place(lane) else { continue };
            let shape = &self.batch.shape;
            let span = shape.fall.0[lane] - shape.rise.0[lane];
            let u = if moved.0[lane].is_nan() { widest(shape, lane) } else { u.0[lane] };
            let u = match self.settings.estimator {
                Estimator::Crossing | Estimator::Steger => 0.0,
                Estimator::Maximum => u.hypot((1.0f64 / 12.0).sqrt()),
                _ => u,
            };
            let (height, background, width) = (shape.height.0[lane], shape.base.0[lane], span / FULL_WIDTH);
            let (saturated, row) = (shape.saturated[lane], found.rows);
            if self.settings.keeps {
                self.batch.keep(lane, &mut found.kept);
                found.rows += 1;
            }
            found.add(self.batch.rays[lane], Peak { position: place, height, background, width, u, saturated, row });
        }
        self.batch.filled = 0;
    }

    /// The Gauss-Newton steps and uncertainties of the batch, if anybody wants them.
    fn fitted(&mut self) -> (Lanes, Lanes) {
        if matches!(self.settings.estimator, Estimator::Crossing | Estimator::Steger) || !self.batch.shape.stands.contains(&true) {
            return (Lanes::ZERO, Lanes::ZERO);
        }
        (self.fit.step(&self.batch), self.fit.uncertainty())
    }

    /// Place of one peak of the batch, or none where the estimator finds no peak.
    fn place(&self, lane: usize) -> Option<f64> {
        let (batch, shape, settings) = (&self.batch, &self.batch.shape, self.settings);
        let (position, background) = (batch.position.0[lane], shape.background.0[lane]);
        let (first, samples) = match settings.estimator {
            Estimator::ZeroCrossing | Estimator::Crossing | Estimator::Steger => return Some(position),
            Estimator::Threshold => return Some(0.5 * (shape.rise.0[lane] + shape.fall.0[lane])),
            Estimator::Parabola => batch.samples(lane, settings.reach()),
            _ => batch.samples(lane, self.fit.half()),
        };
        let window = (first, &samples[..]);
        match settings.estimator {
            Estimator::Parabola => parabola(window, (position, batch.fraction.0[lane]), settings.window),
            Estimator::Maximum => Some(brightest(window)),
            Estimator::Centroid => Some(centroid(window, background)),
            _ => Some(correlation(window, (position, background), settings.noise.width)),
        }
    }
}

/// Standard uncertainty of a peak whose samples fix no place: it may be anywhere within its full width at half height.
pub fn widest(shape: &Shape, lane: usize) -> f64 {
    (shape.fall.0[lane] - shape.rise.0[lane]) / 12f64.sqrt()
}
