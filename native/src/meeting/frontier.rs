//! How far the meetings of rays with a cone are from ceasing to exist: the twin of `calibore.lasers._cone_frontier`, which tells why.

use super::cone::Cone;
use super::lanes::{along, cross, dot, minus, vector, Lanes, Mask, Vector};
use super::surface::SURFACE;

/// A measure that falls to 0 at the frontier, and its slopes.
#[derive(Clone, Copy)]
pub struct Frontier {
    pub value: Lanes,
    by_arm: Vector,
    by_direction: Vector,
    by_axis: Vector,
    by_half_angle: Lanes,
}

impl Frontier {
    /// What a turn of the ray does.
    #[inline(always)]
    pub fn turned(&self, direction: Vector) -> Lanes {
        dot(self.by_direction, direction)
    }

    /// What a motion of apex, axis and half angle does.
    #[inline(always)]
    pub fn moved(&self, motion: &[f64; SURFACE]) -> Lanes {
        let [a, b, c, x, y, z, opening] = *motion;
        let turned = dot(self.by_axis, vector([x, y, z])) - dot(self.by_arm, vector([a, b, c]));
        turned + self.by_half_angle * Lanes::all(opening)
    }

    #[inline(always)]
    fn plus(&self, sign: f64, other: &Frontier) -> Frontier {
        let sign = Lanes::all(sign);
        Frontier {
            value: sign.fused(other.value, self.value),
            by_arm: along(self.by_arm, sign, other.by_arm),
            by_direction: along(self.by_direction, sign, other.by_direction),
            by_axis: along(self.by_axis, sign, other.by_axis),
            by_half_angle: sign.fused(other.by_half_angle, self.by_half_angle),
        }
    }

    #[inline(always)]
    fn scaled(&self, by: Lanes) -> Frontier {
        Frontier {
            value: by * self.value,
            by_arm: scaled(self.by_arm, by),
            by_direction: scaled(self.by_direction, by),
            by_axis: scaled(self.by_axis, by),
            by_half_angle: by * self.by_half_angle,
        }
    }

    /// Infinitely far, with slopes 0, for rays that do not meet the double cone.
    #[inline(always)]
    fn where_it_exists(self, exists: Mask) -> Frontier {
        let kept = |slope: Vector| slope.map(|part| exists.choose(part, Lanes::ZERO));
        Frontier {
            value: exists.choose(self.value, Lanes::all(f64::INFINITY)),
            by_arm: kept(self.by_arm),
            by_direction: kept(self.by_direction),
            by_axis: kept(self.by_axis),
            by_half_angle: exists.choose(self.by_half_angle, Lanes::ZERO),
        }
    }
}

#[inline(always)]
fn scaled(a: Vector, by: Lanes) -> Vector {
    [by * a[0], by * a[1], by * a[2]]
}

/// The ray touches the cone; its far meeting, and its near one, recede to infinity. For rays from the origin.
#[inline(always)]
pub fn frontiers(cone: &Cone, direction: Vector) -> [Frontier; 3] {
    let arm = minus([Lanes::ZERO; 3], cone.apex);
    let touching = touching(cone, arm, direction);
    let exists = touching.value.more(Lanes::ZERO);
    let (root, middle) = (root_of(cone, &touching, exists), half_linear(cone, arm, direction));
    let (reach, square) = (dot(arm, cone.axis), cone.cosine * cone.cosine);
    let inside = reach.fused(reach, -(square * dot(arm, arm))).more(Lanes::ZERO).choose(Lanes::ONE, -Lanes::ONE);
    let far = root.plus(-1.0, &middle).scaled(inside).where_it_exists(exists);
    let near = root.plus(1.0, &middle).scaled(-inside).where_it_exists(exists);
    [touching, far, near]
}

#[inline(always)]
fn touching(cone: &Cone, arm: Vector, direction: Vector) -> Frontier {
    let normal = cross(arm, direction);
    let lean = dot(normal, cone.axis);
    let vector = along(scaled(normal, cone.sine * cone.sine), -lean, cone.axis);
    let per_square = Lanes::ONE / dot(arm, arm);
    let value = dot(normal, vector) * per_square;
    let twice = Lanes::all(2.0) * per_square;
    Frontier {
        value,
        by_arm: scaled(along(cross(direction, vector), -value, arm), twice),
        by_direction: scaled(cross(vector, arm), twice),
        by_axis: scaled(normal, -(twice * lean)),
        by_half_angle: twice * cone.sine * cone.cosine * dot(normal, normal),
    }
}

/// The root of the discriminant over the length of the arm.
#[inline(always)]
fn root_of(cone: &Cone, touching: &Frontier, exists: Mask) -> Frontier {
    let root = exists.choose(touching.value, Lanes::ONE).sqrt();
    let cosine = cone.cosine.abs();
    let turn = cone.cosine.less(Lanes::ZERO).choose(cone.sine, -cone.sine);
    let slopes = touching.scaled(cosine / (Lanes::all(2.0) * root));
    Frontier { value: cosine * root, by_half_angle: turn.fused(root, slopes.by_half_angle), ..slopes }
}

#[inline(always)]
fn half_linear(cone: &Cone, arm: Vector, direction: Vector) -> Frontier {
    let (axis, square) = (cone.axis, cone.cosine * cone.cosine);
    let (steep, reach, together) = (dot(direction, axis), dot(arm, axis), dot(arm, direction));
    let per_length = Lanes::ONE / dot(arm, arm).sqrt();
    let value = steep.fused(reach, -(square * together)) * per_length;
    let by_arm = along(along(scaled(axis, steep), -square, direction), -(value * per_length), arm);
    Frontier {
        value,
        by_arm: scaled(by_arm, per_length),
        by_direction: scaled(along(scaled(axis, reach), -square, arm), per_length),
        by_axis: scaled(along(scaled(arm, steep), reach, direction), per_length),
        by_half_angle: Lanes::all(2.0) * cone.sine * cone.cosine * together * per_length,
    }
}
