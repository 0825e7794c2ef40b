//! Planes, sheets and beams: normal . x = level, one meeting per ray. The twin of `calibore.lasers._flat` and `_beam`.

use super::camera::Ray;
use super::lanes::{dot, vector, Lanes, Vector};
use super::surface::{Contact, Meeting, Surface, GRAZING_SINE, SURFACE};

/// Lit where `light` . x >= `start`.
#[derive(Clone, Copy)]
pub struct Flat {
    normal: Vector,
    level: Lanes,
    light: Vector,
    start: Lanes,
}

impl Surface for Flat {
    const TWICE: bool = false;

    #[inline(always)]
    fn of(numbers: &[Lanes; SURFACE]) -> Self {
        let [a, b, c, level, x, y, z, start] = *numbers;
        Flat { normal: [a, b, c], level, light: [x, y, z], start }
    }

    #[inline(always)]
    fn meet(&self, ray: &Ray) -> [Meeting; 2] {
        let slope = dot(ray.direction, self.normal);
        let distance = (self.level - dot(ray.origin, self.normal)) / slope;
        let length = dot(self.normal, self.normal).sqrt();
        let reach = dot(ray.origin, self.light) - self.start + distance * dot(ray.direction, self.light);
        let meeting = Meeting {
            distance,
            exists: !slope.is_nan() & !reach.less(Lanes::ZERO),
            grazing: slope.abs().less(Lanes::all(GRAZING_SINE) * length),
            behind: distance.at_most(Lanes::ZERO),
        };
        [meeting, meeting]
    }

    #[inline(always)]
    fn contact(&self, ray: &Ray, distance: Lanes) -> Contact {
        Contact {
            gradient: self.normal,
            per_slope: Lanes::ONE / dot(ray.direction, self.normal),
            arm: ray.point(distance),
            length: Lanes::ONE,
        }
    }

    #[inline(always)]
    fn moved(&self, contact: &Contact, motion: &[f64; SURFACE]) -> Lanes {
        dot(contact.arm, vector([motion[0], motion[1], motion[2]])) - Lanes::all(motion[3])
    }
}
