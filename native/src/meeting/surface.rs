//! What a surface of light is to a kernel: where rays meet it, and how it moves.

use super::lanes::{Lanes, Mask, Vector};
use super::mount::Ray;

/// Numbers that say how a surface moves: normal and level of flat ones; apex, axis and half angle of cones.
pub const SURFACE: usize = 7;
/// Sine of the angle between ray and surface; see `calibore.lasers.GRAZING_SINE`.
pub const GRAZING_SINE: f64 = 0.01;

#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Plane,
    Cone,
    Sheet,
    Beam,
}

impl Kind {
    pub fn numbered(number: u8) -> Option<Self> {
        [Kind::Plane, Kind::Cone, Kind::Sheet, Kind::Beam].get(usize::from(number)).copied()
    }

    pub fn parameters(self) -> usize {
        match self {
            Kind::Plane | Kind::Sheet => 3,
            Kind::Cone | Kind::Beam => 5,
        }
    }
}

/// Where rays meet the surface: `distance` along them; `exists` where there is light.
#[derive(Clone, Copy)]
pub struct Meeting {
    pub distance: Lanes,
    pub exists: Mask,
    pub grazing: Mask,
    pub behind: Mask,
}

impl Meeting {
    #[inline(always)]
    pub fn ahead(&self) -> Mask {
        self.exists & !self.behind & self.distance.is_finite()
    }

    #[inline(always)]
    pub fn admissible(&self) -> Mask {
        self.exists & !self.grazing & !self.behind
    }

    /// Lane by lane, `other` where `mask` says so.
    #[inline(always)]
    pub fn or(&self, other: &Meeting, mask: Mask) -> Meeting {
        let pick = |a: Mask, b: Mask| (mask & b) | (!mask & a);
        Meeting {
            distance: mask.choose(other.distance, self.distance),
            exists: pick(self.exists, other.exists),
            grazing: pick(self.grazing, other.grazing),
            behind: pick(self.behind, other.behind),
        }
    }
}

/// The surface at a point: `gradient` of F, 1 / its slope along the ray, and the `arm` from where the surface's parameters are told.
pub struct Contact {
    pub gradient: Vector,
    pub per_slope: Lanes,
    pub arm: Vector,
    pub length: Lanes,
}

pub trait Surface: Copy + Send + Sync {
    /// Whether a ray may meet it a second time.
    const TWICE: bool;

    /// From its parameters.
    fn of(kind: Kind, parameters: &[Lanes]) -> Self;

    /// Where the ray enters the solid of light, and where it leaves it; twice the same unless `TWICE`.
    fn meet(&self, ray: &Ray) -> [Meeting; 2];

    fn contact(&self, ray: &Ray, distance: Lanes) -> Contact;

    /// dF at a point when the surface's numbers change by `motion`.
    fn moved(&self, contact: &Contact, motion: &[f64; SURFACE]) -> Lanes;
}
