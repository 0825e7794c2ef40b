//! Cones of light, one nappe: axis . w = cos(half angle) |w|. The twin of `calibore.lasers._cone` and `_cone_meetings`, which tell why the
//! roots and the discriminant are written as they are.

use super::camera::Ray;
use super::lanes::{along, cross, dot, minus, vector, Lanes, Vector};
use super::surface::{Contact, Meeting, Surface, GRAZING_SINE, SURFACE};

#[derive(Clone, Copy)]
pub struct Cone {
    apex: Vector,
    axis: Vector,
    cosine: Lanes,
    sine: Lanes,
    per_cosine: Lanes,
}

impl Surface for Cone {
    const TWICE: bool = true;

    #[inline(always)]
    fn of(numbers: &[Lanes; SURFACE]) -> Self {
        let [a, b, c, x, y, z, cosine, sine] = *numbers;
        Cone { apex: [a, b, c], axis: [x, y, z], cosine, sine, per_cosine: Lanes::ONE / cosine }
    }

    #[inline(always)]
    fn meet(&self, ray: &Ray) -> [Meeting; 2] {
        let (arm, u) = (minus(ray.origin, self.apex), ray.direction);
        let (cosine, sine) = (self.cosine * self.cosine, self.sine * self.sine);
        let (steep, reach) = (dot(u, self.axis), dot(arm, self.axis));
        let square = steep * steep - cosine * dot(u, u);
        let half_linear = steep * reach - cosine * dot(arm, u);
        let constant = reach * reach - cosine * dot(arm, arm);
        let normal = cross(arm, u);
        let discriminant = cosine * (sine * dot(normal, normal) - dot(normal, self.axis).squared());
        let real = discriminant.at_least(Lanes::ZERO);
        let root = real.choose(discriminant, Lanes::ONE).sqrt();
        let rising = half_linear.more(Lanes::ZERO);
        let sum = rising.choose(half_linear + root, root - half_linear);
        let (first, second) = (constant / sum, sum / square);
        let least = Lanes::all(GRAZING_SINE) * self.sine;
        let meeting = |distance: Lanes| {
            let reach = reach + distance * steep;
            Meeting {
                distance,
                exists: real & (self.cosine * reach).more(Lanes::ZERO) & distance.abs().less(Lanes::all(f64::INFINITY)),
                grazing: root.at_most(least * reach.abs()),
                behind: distance.at_most(Lanes::ZERO),
            }
        };
        [meeting(rising.choose(-first, second)), meeting(rising.choose(-second, first))]
    }

    #[inline(always)]
    fn contact(&self, ray: &Ray, distance: Lanes) -> Contact {
        let arm = along(minus(ray.origin, self.apex), distance, ray.direction);
        // on the cone
        let length = dot(arm, self.axis) * self.per_cosine;
        let shrink = self.cosine / length;
        let gradient = [self.axis[0] - shrink * arm[0], self.axis[1] - shrink * arm[1], self.axis[2] - shrink * arm[2]];
        Contact { gradient, per_slope: Lanes::ONE / dot(gradient, ray.direction), arm, length }
    }

    /// `motion` of the apex, of the axis, and of the half angle.
    #[inline(always)]
    fn moved(&self, contact: &Contact, motion: &[f64; SURFACE]) -> Lanes {
        let [a, b, c, x, y, z, opening, _] = *motion;
        dot(contact.arm, vector([x, y, z])) - dot(contact.gradient, vector([a, b, c])) + self.sine * contact.length * Lanes::all(opening)
    }
}
