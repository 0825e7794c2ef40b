//! Planes, sheets and beams: normal . x = level, one meeting per ray. The twin of `calibore.lasers._flat` and `_beam`.

use super::functions::sin_cos;
use super::lanes::{along, dot, vector, Lanes, Vector};
use super::mount::Ray;
use super::surface::{Contact, Kind, Meeting, Surface, GRAZING_SINE, SURFACE};

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
    fn of(kind: Kind, parameters: &[Lanes]) -> Self {
        if kind == Kind::Beam {
            return beam(parameters);
        }
        let (one, first, second) = (Lanes::ONE, -parameters[1], -parameters[2]);
        let normal = if kind == Kind::Sheet { [one, first, second] } else { [first, second, one] };
        Flat { normal, level: parameters[0], light: [Lanes::ZERO; 3], start: Lanes::ZERO }
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

/// The plane through a beam at right angles to the plane of beam and pupil; see `calibore.lasers.Beam`.
#[inline(always)]
fn beam(parameters: &[Lanes]) -> Flat {
    let source = [parameters[0], parameters[1], parameters[2]];
    let ((across, ahead), (sine, cosine)) = (sin_cos(parameters[3]), sin_cos(parameters[4]));
    let light = [across * sine, -(across * cosine), ahead];
    let start = dot(source, light);
    let foot = along(source, -start, light);
    let level = dot(foot, foot).sqrt();
    Flat { normal: [foot[0] / level, foot[1] / level, foot[2] / level], level, light, start }
}
