//! From a pixel to a ray, and how the ray turns: the twin of `calibore.optics._camera`.

use super::lanes::{Lanes, Mask, Vector};
use super::lens::{Lens, Optics};

#[derive(Clone, Copy)]
pub struct Camera {
    pub lens: Lens,
    /// u scale over v scale of the pixels.
    pub per_aspect: Lanes,
    pub centre: [Lanes; 2],
}

/// The ray of a pixel in the camera frame. `across` is sin(zenith) / image radius.
pub struct Sight {
    pub direction: Vector,
    pub seen: Mask,
    pub sine: Lanes,
    pub cosine: Lanes,
    pub cos_azimuth: Lanes,
    pub sin_azimuth: Lanes,
    pub by_radius: Lanes,
    pub by_lens: [Lanes; 3],
    pub across: Lanes,
    pub per_aspect: Lanes,
    pub y: Lanes,
}

impl Camera {
    /// From k, c1, c2, aspect and principal point.
    #[inline(always)]
    pub fn of(optics: &Optics, parameters: &[Lanes]) -> Self {
        let (k, aspect) = (parameters[0], parameters[3]);
        let possible = k.more(Lanes::ZERO) & aspect.more(Lanes::ZERO);
        let lens = Lens::of(optics, possible.choose(k, Lanes::NAN), parameters[1], parameters[2]);
        Camera { lens, per_aspect: Lanes::ONE / aspect, centre: [parameters[4], parameters[5]] }
    }

    #[inline(always)]
    pub fn sight(&self, optics: &Optics, u: Lanes, v: Lanes) -> Sight {
        let (x, y) = (u - self.centre[0], (v - self.centre[1]) * self.per_aspect);
        let radius = x.fused(x, y * y).sqrt();
        let off_axis = radius.more(Lanes::ZERO);
        let inverse = Lanes::ONE / off_axis.choose(radius, Lanes::ONE);
        let (cos_azimuth, sin_azimuth) = (off_axis.choose(x * inverse, Lanes::ONE), y * inverse);
        let zenith = self.lens.zenith(optics, radius);
        Sight {
            direction: [zenith.sine * cos_azimuth, zenith.sine * sin_azimuth, zenith.cosine],
            seen: zenith.seen,
            sine: zenith.sine,
            cosine: zenith.cosine,
            cos_azimuth,
            sin_azimuth,
            by_radius: zenith.by_radius,
            by_lens: zenith.by_lens,
            across: off_axis.choose(zenith.sine * inverse, zenith.by_radius),
            per_aspect: self.per_aspect,
            y,
        }
    }
}

impl Sight {
    /// Unit vectors in which the ray turns with growing zenith and with growing azimuth.
    #[inline(always)]
    pub fn turns(&self) -> [Vector; 2] {
        let (c, s) = (self.cos_azimuth, self.sin_azimuth);
        [[self.cosine * c, self.cosine * s, -self.sine], [-s, c, Lanes::ZERO]]
    }
}
