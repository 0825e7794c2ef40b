//! A rig from its parameters, in the order of `calibore.rigs.Rig.parameter_names`: the same in all lanes, or another one in each.

use super::camera::Camera;
use super::lanes::{each, Lanes, LANES};
use super::lens::{Law, Optics};
use super::mount::{Mount, SideFacing};
use super::surface::{Kind, Surface};

/// What a rig is made of; that does not move.
#[derive(Clone, Copy)]
pub struct Make {
    pub kind: Kind,
    pub side_facing: bool,
    pub optics: Optics,
}

/// The most parameters that a rig has.
const MOST: usize = 5 + SideFacing::PARAMETERS + CAMERA;
const CAMERA: usize = 6;

#[derive(Clone, Copy)]
pub struct Rig<S, M> {
    pub surface: S,
    pub mount: M,
    pub camera: Camera,
}

impl Make {
    pub fn new(kind: u8, side_facing: bool, law: u8, half_height: f64, residual: bool) -> Option<Self> {
        let optics = Optics { law: Law::numbered(law)?, half_height, residual };
        Some(Make { kind: Kind::numbered(kind)?, side_facing, optics })
    }

    pub fn parameters(&self) -> usize {
        self.kind.parameters() + if self.side_facing { SideFacing::PARAMETERS } else { 0 } + CAMERA
    }

    /// One rig for each of at most `LANES` `rows` of parameters; NaN in the other lanes, where rays meet nothing.
    #[inline(always)]
    pub fn rig<S: Surface, M: Mount>(&self, rows: &[f64]) -> Rig<S, M> {
        let count = self.parameters();
        let mut lanes = [Lanes::ZERO; MOST];
        for (i, lane) in lanes.iter_mut().take(count).enumerate() {
            *lane = each!(Lanes, 0.0, |k| rows.get(k * count + i).copied().unwrap_or(f64::NAN));
        }
        let (surface, rest) = lanes[..count].split_at(self.kind.parameters());
        let (mount, camera) = rest.split_at(M::PARAMETERS);
        Rig { surface: S::of(self.kind, surface), mount: M::of(mount), camera: Camera::of(&self.optics, camera) }
    }

    /// The same rig in all lanes.
    pub fn same<S: Surface, M: Mount>(&self, parameters: &[f64]) -> Rig<S, M> {
        self.rig(&parameters.repeat(LANES))
    }
}
