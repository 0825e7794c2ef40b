//! Settings of one scan along rays (see the Python module `_estimators`).

use super::vectors::Vectors;

#[derive(Clone, Copy, PartialEq)]
pub enum Estimator {
    ZeroCrossing,
    Parabola,
    Maximum,
    Threshold,
    Centroid,
    Correlation,
    Crossing,
    Steger,
}

impl Estimator {
    /// By its number in the Python enumeration.
    pub fn numbered(number: u8) -> Option<Self> {
        use Estimator::*;
        [ZeroCrossing, Parabola, Maximum, Threshold, Centroid, Correlation, Crossing, Steger].get(number as usize).copied()
    }
}

/// Variance model in grey values, line width and speckle grain in pixels (see the Python class `NoiseModel`).
#[derive(Clone)]
pub struct Noise {
    pub additive: f64,
    pub gain: f64,
    pub contrast: f64,
    pub width: f64,
    pub grain: f64,
}

/// Samples per fitted parabola (Swanbom 2007, 6.3.4.2), and per slope in a first look.
pub const PUBLISHED_WINDOW: usize = 8;
/// Samples above this fraction of white carry no information about the line's place.
pub const SATURATED_FROM: f64 = 0.97;
/// Limits of the half width of the Gauss-Newton window.
const NARROWEST_FIT: f64 = 4.0;
pub const WIDEST_FIT: usize = 24;
/// Samples of a ray in a generalised fit.
pub const MOST_SAMPLES: usize = 25;

#[derive(Clone)]
pub struct Settings {
    pub estimator: Estimator,
    pub noise: Noise,
    pub gate: f64,
    pub prominence: f64,
    pub threshold: f64,
    pub white: f64,
    pub window: usize,
    /// Additive variance of the pixels themselves, which that of the noise model may exceed.
    pub sensor: f64,
    /// Whether the samples about every peak are kept.
    pub keeps: bool,
    pub vectors: Vectors,
}

impl Settings {
    /// The same for a first look: by slope alone, or the dissertation's way throughout.
    pub fn plain(&self) -> Settings {
        let estimator = if self.estimator == Estimator::Parabola { self.estimator } else { Estimator::Crossing };
        Settings { estimator, keeps: false, ..self.clone() }
    }

    /// The same for the look in which the line is chosen: what is looked at again needs no more than a place and its samples.
    pub fn choosing(&self) -> Settings {
        match self.estimator {
            Estimator::ZeroCrossing => Settings { estimator: Estimator::Crossing, keeps: true, ..self.clone() },
            _ => self.clone(),
        }
    }

    /// Samples on each side of a peak in which its background and half height are looked for.
    pub fn reach(&self) -> usize {
        self.window + 2
    }

    /// Samples on each side of a peak that are looked at at all.
    pub fn side(&self) -> usize {
        self.reach().max(self.half_fit())
    }

    /// Half width of the Gauss-Newton window: three line widths.
    pub fn half_fit(&self) -> usize {
        (3.0 * self.noise.width).ceil().clamp(NARROWEST_FIT, WIDEST_FIT as f64) as usize
    }

    /// Neighbouring samples that are averaged for a generalised fit, so that it has no more than it can bear.
    pub fn group(&self) -> usize {
        (2 * self.half_fit() + 1).div_ceil(MOST_SAMPLES)
    }

    /// Brightness from which a sample counts as saturated.
    pub fn saturated_from(&self) -> f64 {
        SATURATED_FROM * self.white
    }
}
