//! How a rig's parameters move together: one mode for each column of a factor of the covariance, of one standard uncertainty.

use super::camera::Sight;
use super::lanes::{Lanes, Vector};
use super::mount::Mount;
use super::surface::{Contact, Surface, SURFACE};

const MOUNT: usize = 2;
/// Numbers of one mode: of the surface, of the mount, and of k, c1, c2, aspect and principal point.
pub const MODE: usize = SURFACE + MOUNT + 6;

pub struct Mode {
    surface: [f64; SURFACE],
    mount: [f64; MOUNT],
    k: f64,
    residual: [f64; 2],
    aspect: f64,
    centre: [f64; 2],
    /// Whether the residual, and whether aspect or centre move at all.
    bends: bool,
    slides: bool,
}

/// What a mode does: the surface leaves the meeting, the ray turns by zenith and azimuth, and shifts with its mount.
pub struct Motion {
    pub surface: Lanes,
    pub turns: [Lanes; 2],
    pub shift: Vector,
}

impl Mode {
    pub fn of(numbers: &[f64; MODE]) -> Self {
        let [a, b, c, d, e, f, g, baseline, aim, k, c1, c2, aspect, u, v] = *numbers;
        Mode {
            surface: [a, b, c, d, e, f, g],
            mount: [baseline, aim],
            k,
            residual: [c1, c2],
            aspect,
            centre: [u, v],
            bends: c1 != 0.0 || c2 != 0.0,
            slides: aspect != 0.0 || u != 0.0 || v != 0.0,
        }
    }

    /// What it does to the numbers of the surface.
    pub fn of_surface(&self) -> &[f64; SURFACE] {
        &self.surface
    }

    /// By how much it turns the ray with growing zenith and with growing azimuth.
    #[inline(always)]
    pub fn turns(&self, sight: &Sight) -> [Lanes; 2] {
        let mut zenith = sight.by_lens[0] * Lanes::all(self.k);
        let mut azimuth = Lanes::ZERO;
        if self.bends {
            let [c1, c2] = self.residual;
            zenith = sight.by_lens[2].fused(Lanes::all(c2), sight.by_lens[1].fused(Lanes::all(c1), zenith));
        }
        if self.slides {
            let [u, v] = self.centre;
            let (x, y) = (Lanes::all(-u), -(sight.y.fused(Lanes::all(self.aspect), Lanes::all(v)) * sight.per_aspect));
            let (c, s) = (sight.cos_azimuth, sight.sin_azimuth);
            zenith = sight.by_radius.fused(c.fused(x, s * y), zenith);
            azimuth = sight.across * c.fused(y, -(s * x));
        }
        [zenith, azimuth]
    }

    #[inline(always)]
    pub fn motion<S: Surface, M: Mount>(&self, parts: (&S, &M), contact: &Contact, sight: &Sight, distance: Lanes) -> Motion {
        let surface = parts.0.moved(contact, &self.surface);
        Motion { surface, turns: self.turns(sight), shift: parts.1.moved(self.mount, sight.direction, distance) }
    }
}
