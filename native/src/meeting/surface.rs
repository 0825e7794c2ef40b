//! What a surface of light is to a kernel: where rays meet it, and how it moves.

use super::camera::Ray;
use super::lanes::{Lanes, Mask, Vector};

/// Numbers that describe a surface, and that say how it moves.
pub const SURFACE: usize = 8;
/// Sine of the angle between ray and surface; see `calibore.lasers.GRAZING_SINE`.
pub const GRAZING_SINE: f64 = 0.01;

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

    /// From the numbers of `Rig::numbers`.
    fn of(numbers: &[Lanes; SURFACE]) -> Self;

    /// Where the ray enters the solid of light, and where it leaves it; twice the same unless `TWICE`.
    fn meet(&self, ray: &Ray) -> [Meeting; 2];

    fn contact(&self, ray: &Ray, distance: Lanes) -> Contact;

    /// dF at a point when the surface's numbers change by `motion`.
    fn moved(&self, contact: &Contact, motion: &[f64; SURFACE]) -> Lanes;
}
