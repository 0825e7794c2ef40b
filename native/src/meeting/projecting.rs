//! From a point to its pixel, for cameras that face ahead: the twin of `calibore.optics.Camera.project`.

use std::f64::consts::{FRAC_PI_2, PI};

use super::lanes::Lanes;
use super::lens::{Law, Lens};
use super::rig::Make;

const CAMERA: usize = 6;

/// A camera, its lens with the zenith at which that ends.
pub struct Projector {
    law: Law,
    k: f64,
    half_height: f64,
    residual: [f64; 2],
    aspect: f64,
    centre: [f64; 2],
    last: f64,
}

impl Projector {
    /// Of a rig whose frame is the camera's; `parameters` as in `Make::rig`.
    pub fn of(make: &Make, parameters: &[f64]) -> Self {
        let camera = &parameters[parameters.len() - CAMERA..];
        let (k, optics) = (camera[0], &make.optics);
        let residual = if optics.residual { [camera[1], camera[2]] } else { [0.0; 2] };
        let law = optics.law;
        let mut last = last_zenith(law);
        if optics.residual {
            let lens = Lens::of(optics, Lanes::all(k), Lanes::all(residual[0]), Lanes::all(residual[1]));
            let ratio = lens.limit.0[0] * optics.half_height / k;
            last = if ratio >= law.end() { last } else { zenith(law, ratio) };
        }
        Projector { law, k, half_height: optics.half_height, residual, aspect: camera[3], centre: [camera[4], camera[5]], last }
    }

    /// u and v; NaN for points that the lens does not image.
    pub fn pixel(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let off_axis = (x * x + y * y).sqrt();
        let scale = self.image_radius(off_axis.atan2(z)) / if off_axis > 0.0 { off_axis } else { 1.0 };
        [self.centre[0] + scale * x, self.centre[1] + self.aspect * scale * y]
    }

    fn image_radius(&self, zenith: f64) -> f64 {
        if zenith.is_nan() || zenith >= self.last {
            return f64::NAN;
        }
        let q = self.k * ratio(self.law, zenith) / self.half_height;
        let ([c1, c2], square) = (self.residual, q * q);
        q * (1.0 + (c1 + c2 * square) * square) * self.half_height
    }
}

fn last_zenith(law: Law) -> f64 {
    match law {
        Law::Perspective | Law::Sine => FRAC_PI_2,
        Law::Stereographic | Law::Equidistant | Law::EquisolidAngle => PI,
    }
}

fn ratio(law: Law, zenith: f64) -> f64 {
    match law {
        Law::Perspective => zenith.tan(),
        Law::Stereographic => (0.5 * zenith).tan(),
        Law::Equidistant => zenith,
        Law::Sine => zenith.sin(),
        Law::EquisolidAngle => (0.5 * zenith).sin(),
    }
}

fn zenith(law: Law, ratio: f64) -> f64 {
    match law {
        Law::Perspective => ratio.atan(),
        Law::Stereographic => 2.0 * ratio.atan(),
        Law::Equidistant => ratio,
        Law::Sine => ratio.asin(),
        Law::EquisolidAngle => 2.0 * ratio.asin(),
    }
}
