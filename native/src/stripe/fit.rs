//! One weighted Gauss-Newton step of a Gaussian line, for several peaks at once (see the Python module `_refine`).

use super::batch::{Batch, MOST};
use super::lanes::Lanes;
use super::settings::Settings;
use super::vectors::{vectorised, Vectors};

/// Least determinant, relative to its diagonal, at which the samples still fix a place.
const SINGULAR: f64 = 1e-12;
/// Speckle correlation below this is none.
const UNCORRELATED: f64 = 1e-6;

/// The fit under one noise model.
pub struct Fit {
    vectors: Vectors,
    half: usize,
    /// 1 / width^2.
    inverse: Lanes,
    additive: Lanes,
    gain: Lanes,
    contrast: Lanes,
    white: Lanes,
    /// Gaussian of the line's width at whole distances from its middle.
    bell: Vec<f64>,
    /// Speckle correlation at sample distances 1, 2, ... up to where it has faded.
    correlation: Vec<f64>,
    line: [Lanes; MOST],
    /// Gaussian of every sample, then its slope.
    slope: [Lanes; MOST],
    /// Weights of the samples, then the functional that moves the peak.
    functional: [Lanes; MOST],
}

impl Fit {
    pub fn new(settings: &Settings) -> Self {
        let (noise, half) = (&settings.noise, settings.half_fit());
        let inverse = 1.0 / (noise.width * noise.width);
        let square = |d: usize| (d * d) as f64;
        let shared = |d: usize| (-square(d) / (4.0 * noise.grain * noise.grain)).exp();
        Fit {
            vectors: settings.vectors,
            half,
            inverse: Lanes::all(inverse),
            additive: Lanes::all(noise.additive),
            gain: Lanes::all(noise.gain),
            contrast: Lanes::all(noise.contrast),
            white: Lanes::all(settings.saturated_from()),
            bell: (0..=half).map(|d| (-0.5 * square(d) * inverse).exp()).collect(),
            correlation: (1..=2 * half).map(shared).take_while(|&c| c > UNCORRELATED).collect(),
            line: [Lanes::ZERO; MOST],
            slope: [Lanes::ZERO; MOST],
            functional: [Lanes::ZERO; MOST],
        }
    }

    pub fn half(&self) -> usize {
        self.half
    }

    /// The step for (amplitude, position, background) along position, leaving its functional behind; NaN where the samples fix no place.
    pub fn step(&mut self, batch: &Batch) -> Lanes {
        let fit = self;
        vectorised!(fit.vectors, step(fit: &mut Fit, batch: &Batch) -> Lanes)
    }

    #[inline(always)]
    fn stepped(&mut self, batch: &Batch) -> Lanes {
        self.gaussian(batch);
        let [amplitude, position, level] = inverse_row(self.normal(batch));
        let amplitude = amplitude / batch.shape.height;
        let mut moved = Lanes::ZERO;
        let samples = self.functional.iter_mut().zip(&self.line).zip(&self.slope).zip(batch.to_fit(self.half));
        for (((functional, line), slope), sample) in samples.take(2 * self.half + 1) {
            *functional *= amplitude * *line + position * *slope + level;
            moved += (*functional * (*sample - *line - batch.shape.background)).where_less(*sample, self.white);
        }
        moved
    }

    /// exp(-(k + offset)^2 / 2 width^2) = bell(k) exp(-offset^2 / 2 width^2) exp(-offset / width^2)^k for all samples k.
    #[inline(always)]
    fn gaussian(&mut self, batch: &Batch) {
        let offset = batch.offset * self.inverse;
        let (mut right, mut left) = (Lanes::all(1.0), Lanes::all(1.0));
        let growth = offset.exponential();
        let decay = Lanes::all(1.0) / growth;
        let top = (Lanes::all(-0.5) * offset * batch.offset).exponential();
        for (k, &bell) in self.bell.iter().enumerate() {
            let bell = Lanes::all(bell) * top;
            (self.slope[self.half + k], self.slope[self.half - k]) = (bell * right, bell * left);
            right *= decay;
            left *= growth;
        }
    }

    /// Normal matrix (aa, ab, ac, bb, bc, cc) of the fit; leaves line, slope and weight of every sample behind. Samples that are saturated
    /// or outside the picture weigh nothing.
    #[inline(always)]
    fn normal(&mut self, batch: &Batch) -> [Lanes; 6] {
        let (mut aa, mut ab, mut ac, mut bb, mut bc, mut cc) =
            (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        let mut z = (batch.offset - Lanes::all(self.half as f64)) * self.inverse;
        let samples = self.line.iter_mut().zip(&mut self.slope).zip(&mut self.functional).zip(batch.to_fit(self.half));
        for (((line, slope), weight), sample) in samples.take(2 * self.half + 1) {
            let shape = *slope;
            *line = batch.shape.height * shape;
            *slope = *line * z;
            let variance = self.additive + (self.gain + self.contrast * *line) * *line;
            *weight = (Lanes::all(1.0) / variance).where_less(*sample, self.white);
            let (wa, wb) = (*weight * shape, *weight * *slope);
            aa += wa * shape;
            ab += wa * *slope;
            ac += wa;
            bb += wb * *slope;
            bc += wb;
            cc += *weight;
            z += self.inverse;
        }
        [aa, ab, ac, bb, bc, cc]
    }

    /// Standard uncertainty of the functional left by `step` under pixel noise and correlated speckle.
    pub fn uncertainty(&mut self) -> Lanes {
        let fit = self;
        vectorised!(fit.vectors, uncertainty(fit: &mut Fit) -> Lanes)
    }

    #[inline(always)]
    fn doubt(&mut self) -> Lanes {
        let count = 2 * self.half + 1;
        let mut pixel = Lanes::ZERO;
        for (functional, line) in self.functional.iter_mut().zip(&self.line).take(count) {
            pixel += *functional * *functional * (self.additive + self.gain * *line);
            *functional *= *line;
        }
        let (speckled, mut sum) = (&self.functional[..count], Lanes::ZERO);
        for (k, own) in speckled.iter().enumerate() {
            let mut others = Lanes::ZERO;
            for (&shared, other) in self.correlation.iter().zip(&speckled[k + 1..]) {
                others += Lanes::all(shared) * *other;
            }
            sum += *own * (*own + others + others);
        }
        let variance = pixel + self.contrast * sum;
        Lanes(variance.0.map(|v| v.max(0.0).sqrt()))
    }
}

#[inline(always)]
fn step(fit: &mut Fit, batch: &Batch) -> Lanes {
    fit.stepped(batch)
}

#[inline(always)]
fn uncertainty(fit: &mut Fit) -> Lanes {
    fit.doubt()
}

/// Second row (position) of the inverse of a symmetric 3 x 3 matrix; NaN where it is singular.
#[inline(always)]
fn inverse_row([aa, ab, ac, bb, bc, cc]: [Lanes; 6]) -> [Lanes; 3] {
    let row = [bc * ac - ab * cc, aa * cc - ac * ac, ac * ab - aa * bc];
    let mut determinant = aa * (bb * cc - bc * bc) + ab * row[0] + ac * (ab * bc - bb * ac);
    for (k, value) in determinant.0.iter_mut().enumerate() {
        if !(*value > SINGULAR * aa.0[k] * bb.0[k] * cc.0[k]) {
            *value = f64::NAN;
        }
    }
    row.map(|cofactor| cofactor / determinant)
}
