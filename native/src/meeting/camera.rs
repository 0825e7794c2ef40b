//! From a pixel to a ray, and how the ray turns: the twin of `calibore.optics._camera` and `calibore.rigs._mount`.

use super::lanes::{along, dot, vector, Lanes, Mask, Vector};
use super::lens::{Lens, Optics};

pub const CAMERA: usize = 7;
pub const MOUNT: usize = 12;

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
    /// From the numbers of `Rig::numbers`.
    #[inline(always)]
    pub fn of(numbers: &[Lanes; CAMERA]) -> Self {
        let [per_k, c1, c2, limit, per_aspect, u, v] = *numbers;
        Camera { lens: Lens { per_k, c1, c2, limit }, per_aspect, centre: [u, v] }
    }

    #[inline(always)]
    pub fn sight(&self, optics: &Optics, u: Lanes, v: Lanes) -> Sight {
        let (x, y) = (u - self.centre[0], (v - self.centre[1]) * self.per_aspect);
        let radius = (x * x + y * y).sqrt();
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

/// Rows of the rotation, and the translation, from the camera frame into that of the rig.
#[derive(Clone, Copy)]
pub struct Mount {
    pub rotation: [Vector; 3],
    pub translation: Vector,
}

impl Mount {
    #[inline(always)]
    pub fn of(numbers: &[Lanes; MOUNT]) -> Self {
        let [a, b, c, d, e, f, g, h, i, x, y, z] = *numbers;
        Mount { rotation: [[a, b, c], [d, e, f], [g, h, i]], translation: [x, y, z] }
    }

    #[inline(always)]
    pub fn turn(&self, arrow: Vector) -> Vector {
        [dot(self.rotation[0], arrow), dot(self.rotation[1], arrow), dot(self.rotation[2], arrow)]
    }
}

/// A ray in the frame of the rig.
#[derive(Clone, Copy)]
pub struct Ray {
    pub origin: Vector,
    pub direction: Vector,
}

impl Ray {
    #[inline(always)]
    pub fn of(sight: &Sight, mount: Option<&Mount>) -> Self {
        match mount {
            Some(mount) => Ray { origin: mount.translation, direction: mount.turn(sight.direction) },
            None => Ray { origin: vector([0.0; 3]), direction: sight.direction },
        }
    }

    #[inline(always)]
    pub fn point(&self, distance: Lanes) -> Vector {
        along(self.origin, distance, self.direction)
    }
}
