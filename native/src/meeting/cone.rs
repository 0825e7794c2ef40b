//! Cones of light, one nappe: axis . w = cos(half angle) |w|. The twin of `calibore.lasers._cone` and `_cone_meetings`, which tell why the
//! roots and the discriminant are written as they are.

use super::functions::sin_cos;
use super::lanes::{along, cross, dot, minus, vector, Lanes, Mask, Vector};
use super::mount::Ray;
use super::surface::{Contact, Kind, Meeting, Surface, GRAZING_SINE, SURFACE};

#[derive(Clone, Copy)]
pub struct Cone {
    pub apex: Vector,
    pub axis: Vector,
    pub cosine: Lanes,
    pub sine: Lanes,
    per_cosine: Lanes,
}

impl Surface for Cone {
    const TWICE: bool = true;

    #[inline(always)]
    fn of(_: Kind, parameters: &[Lanes]) -> Self {
        let (baseline, offset) = (parameters[0], parameters[4]);
        let ((sin_aim, cos_aim), (sine, cosine)) = (sin_cos(parameters[1]), sin_cos(parameters[2]));
        let (x, y) = sin_cos(parameters[3]);
        let (apex, axis) = ([baseline * x, -(baseline * y), offset], [-(sin_aim * x), sin_aim * y, cos_aim]);
        Cone { apex, axis, cosine, sine, per_cosine: Lanes::ONE / cosine }
    }

    #[inline(always)]
    fn meet(&self, ray: &Ray) -> [Meeting; 2] {
        let (arm, u) = (minus(ray.origin, self.apex), ray.direction);
        let (cosine, sine) = (self.cosine * self.cosine, self.sine * self.sine);
        let (steep, reach) = (dot(u, self.axis), dot(arm, self.axis));
        let square = steep.fused(steep, -(cosine * dot(u, u)));
        let half_linear = steep.fused(reach, -(cosine * dot(arm, u)));
        let constant = reach.fused(reach, -(cosine * dot(arm, arm)));
        let normal = cross(arm, u);
        let discriminant = cosine * sine.fused(dot(normal, normal), -dot(normal, self.axis).squared());
        let real = discriminant.at_least(Lanes::ZERO);
        let root = real.choose(discriminant, Lanes::ONE).sqrt();
        let rising = half_linear.more(Lanes::ZERO);
        let sum = rising.choose(half_linear + root, root - half_linear);
        let (first, second) = (constant / sum, sum / square);
        let at = At { cone: self, real, root, steep, reach };
        [at.distance(rising.choose(-first, second)), at.distance(rising.choose(-second, first))]
    }

    #[inline(always)]
    fn contact(&self, ray: &Ray, distance: Lanes) -> Contact {
        let arm = along(minus(ray.origin, self.apex), distance, ray.direction);
        // on the cone
        let length = dot(arm, self.axis) * self.per_cosine;
        let shrink = self.cosine / length;
        let gradient = along(self.axis, -shrink, arm);
        Contact { gradient, per_slope: Lanes::ONE / dot(gradient, ray.direction), arm, length }
    }

    /// `motion` of the apex, of the axis, and of the half angle.
    #[inline(always)]
    fn moved(&self, contact: &Contact, motion: &[f64; SURFACE]) -> Lanes {
        let [a, b, c, x, y, z, opening] = *motion;
        let opened = self.sine * contact.length * Lanes::all(opening);
        opened + dot(contact.arm, vector([x, y, z])) - dot(contact.gradient, vector([a, b, c]))
    }
}

/// A ray on its way to the cone, and whether it is `real` that they meet.
struct At<'a> {
    cone: &'a Cone,
    real: Mask,
    root: Lanes,
    steep: Lanes,
    reach: Lanes,
}

impl At<'_> {
    #[inline(always)]
    fn distance(&self, distance: Lanes) -> Meeting {
        let reach = distance.fused(self.steep, self.reach);
        Meeting {
            distance,
            exists: self.real & (self.cone.cosine * reach).more(Lanes::ZERO) & distance.is_finite(),
            grazing: self.root.at_most(Lanes::all(GRAZING_SINE) * self.cone.sine * reach.abs()),
            behind: distance.at_most(Lanes::ZERO),
        }
    }
}
