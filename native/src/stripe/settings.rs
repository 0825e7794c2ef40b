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

#[derive(Clone)]
pub struct Settings {
    pub estimator: Estimator,
    pub noise: Noise,
    pub gate: f64,
    pub prominence: f64,
    pub threshold: f64,
    pub white: f64,
    pub window: usize,
    pub vectors: Vectors,
}

impl Settings {
    /// The same for a first look: by slope alone, or the dissertation's way throughout.
    pub fn plain(&self) -> Settings {
        let estimator = if self.estimator == Estimator::Parabola { self.estimator } else { Estimator::Crossing };
        Settings { estimator, ..self.clone() }
    }

    /// Samples on each side of a peak in which its background and half height are looked for.
    pub fn reach(&self) -> usize {
        self.window + 2
    }

    /// Half width of the Gauss-Newton window: three line widths.
    pub fn half_fit(&self) -> usize {
        (3.0 * self.noise.width).ceil().clamp(NARROWEST_FIT, WIDEST_FIT as f64) as usize
    }

    /// Brightness from which a sample counts as saturated.
    pub fn saturated_from(&self) -> f64 {
        SATURATED_FROM * self.white
    }
}
