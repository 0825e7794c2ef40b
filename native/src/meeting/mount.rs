//! Where the camera stands in the rig: the twin of `calibore.rigs._mount`.

use super::camera::Sight;
use super::functions::sin_cos;
use super::lanes::{along, Lanes, Vector};

pub trait Mount: Copy + Send + Sync {
    /// Parameters of the mount.
    const PARAMETERS: usize;

    fn of(parameters: &[Lanes]) -> Self;

    /// An arrow of the camera's frame in that of the rig.
    fn turn(&self, arrow: Vector) -> Vector;

    fn origin(&self) -> Vector;

    /// How far the point at `distance` is from the axis of the rig.
    fn radius(&self, sight: &Sight, distance: Lanes, point: Vector) -> Lanes;

    /// How the end of an arrow at `distance` moves with `motion` of the parameters.
    fn moved(&self, motion: [f64; 2], arrow: Vector, distance: Lanes) -> Vector;
}

/// The frame of the rig is the camera's.
#[derive(Clone, Copy)]
pub struct Forward;

impl Mount for Forward {
    const PARAMETERS: usize = 0;

    #[inline(always)]
    fn of(_: &[Lanes]) -> Self {
        Forward
    }

    #[inline(always)]
    fn turn(&self, arrow: Vector) -> Vector {
        arrow
    }

    #[inline(always)]
    fn origin(&self) -> Vector {
        [Lanes::ZERO; 3]
    }

    #[inline(always)]
    fn radius(&self, sight: &Sight, distance: Lanes, _: Vector) -> Lanes {
        distance.abs() * sight.sine
    }

    #[inline(always)]
    fn moved(&self, _: [f64; 2], _: Vector, _: Lanes) -> Vector {
        [Lanes::ZERO; 3]
    }
}

/// On a rotating head: `baseline` from the sheet, the axis at the angle of `sine` and `cosine` from it.
#[derive(Clone, Copy)]
pub struct SideFacing {
    baseline: Lanes,
    sine: Lanes,
    cosine: Lanes,
}

impl Mount for SideFacing {
    const PARAMETERS: usize = 2;

    #[inline(always)]
    fn of(parameters: &[Lanes]) -> Self {
        let (sine, cosine) = sin_cos(parameters[1]);
        SideFacing { baseline: parameters[0], sine, cosine }
    }

    #[inline(always)]
    fn turn(&self, arrow: Vector) -> Vector {
        let [x, y, z] = arrow;
        [self.cosine.fused(x, -(self.sine * z)), self.sine.fused(x, self.cosine * z), -y]
    }

    #[inline(always)]
    fn origin(&self) -> Vector {
        [self.baseline, Lanes::ZERO, Lanes::ZERO]
    }

    #[inline(always)]
    fn radius(&self, _: &Sight, _: Lanes, point: Vector) -> Lanes {
        square_from_axis(point).sqrt()
    }

    #[inline(always)]
    fn moved(&self, motion: [f64; 2], arrow: Vector, distance: Lanes) -> Vector {
        let ([x, _, z], turned) = (arrow, distance * Lanes::all(motion[1]));
        let sideways = -(self.sine.fused(x, self.cosine * z) * turned);
        [sideways + Lanes::all(motion[0]), self.cosine.fused(x, -(self.sine * z)) * turned, Lanes::ZERO]
    }
}

#[inline(always)]
pub fn square_from_axis(point: Vector) -> Lanes {
    point[0].fused(point[0], point[1] * point[1])
}

/// A ray in the frame of the rig.
#[derive(Clone, Copy)]
pub struct Ray {
    pub origin: Vector,
    pub direction: Vector,
}

impl Ray {
    #[inline(always)]
    pub fn of(sight: &Sight, mount: &impl Mount) -> Self {
        Ray { origin: mount.origin(), direction: mount.turn(sight.direction) }
    }

    #[inline(always)]
    pub fn point(&self, distance: Lanes) -> Vector {
        along(self.origin, distance, self.direction)
    }
}
