//! A rig's parameters, in the order of `calibore.rigs.Rig.parameter_names`, turned into the numbers the kernels meet rays with.

use super::camera::{CAMERA, MOUNT};
use super::lens::{limit_of_residual, Law, Optics};
use super::surface::SURFACE;

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

    fn parameters(self) -> usize {
        match self {
            Kind::Plane | Kind::Sheet => 3,
            Kind::Cone | Kind::Beam => 5,
        }
    }
}

#[derive(Clone, Copy)]
pub struct Make {
    pub kind: Kind,
    pub side_facing: bool,
    pub optics: Optics,
}

#[derive(Clone, Copy)]
pub struct Numbers {
    pub surface: [f64; SURFACE],
    pub mount: [f64; MOUNT],
    pub camera: [f64; CAMERA],
}

impl Make {
    pub fn new(kind: u8, side_facing: bool, law: u8, half_height: f64, residual: bool) -> Option<Self> {
        let optics = Optics { law: Law::numbered(law)?, half_height, residual };
        Some(Make { kind: Kind::numbered(kind)?, side_facing, optics })
    }

    pub fn parameters(&self) -> usize {
        self.kind.parameters() + if self.side_facing { 2 } else { 0 } + 6
    }

    /// `parameters` of the surface, of the mount, and k, c1, c2, aspect and principal point of the camera.
    pub fn numbers(&self, parameters: &[f64]) -> Numbers {
        let (surface, rest) = parameters.split_at(self.kind.parameters());
        let (mount, camera) = rest.split_at(if self.side_facing { 2 } else { 0 });
        let surface = match self.kind {
            Kind::Plane => [-surface[1], -surface[2], 1.0, surface[0], 0.0, 0.0, 0.0, 0.0],
            Kind::Sheet => [1.0, -surface[1], -surface[2], surface[0], 0.0, 0.0, 0.0, 0.0],
            Kind::Cone => cone(surface),
            Kind::Beam => beam(surface),
        };
        let [k, c1, c2, aspect, u, v] = std::array::from_fn(|i| camera[i]);
        let per_k = if k > 0.0 && aspect > 0.0 { 1.0 / k } else { f64::NAN };
        let mount = if self.side_facing { side_facing(mount) } else { forward() };
        Numbers { surface, mount, camera: [per_k, c1, c2, limit_of_residual(c1, c2), 1.0 / aspect, u, v] }
    }
}

/// Apex, axis, cosine and sine of the half angle.
fn cone(parameters: &[f64]) -> [f64; SURFACE] {
    let (sin_aim, cos_aim) = parameters[1].sin_cos();
    let (sin_half, cos_half) = parameters[2].sin_cos();
    let (sin_clock, cos_clock) = parameters[3].sin_cos();
    let (baseline, offset) = (parameters[0], parameters[4]);
    [baseline * sin_clock, -baseline * cos_clock, offset, -sin_aim * sin_clock, sin_aim * cos_clock, cos_aim, cos_half, sin_half]
}

/// Normal, level, direction of the light and where along it the light starts.
fn beam(parameters: &[f64]) -> [f64; SURFACE] {
    let source = [parameters[0], parameters[1], parameters[2]];
    let (across, ahead) = parameters[3].sin_cos();
    let (sine, cosine) = parameters[4].sin_cos();
    let light = [across * sine, -across * cosine, ahead];
    let start: f64 = (0..3).map(|i| source[i] * light[i]).sum();
    let foot: [f64; 3] = std::array::from_fn(|i| source[i] - light[i] * start);
    let level = foot.iter().map(|x| x * x).sum::<f64>().sqrt();
    [foot[0] / level, foot[1] / level, foot[2] / level, level, light[0], light[1], light[2], start]
}

fn side_facing(parameters: &[f64]) -> [f64; MOUNT] {
    let (s, c) = parameters[1].sin_cos();
    [c, 0.0, -s, s, 0.0, c, 0.0, -1.0, 0.0, parameters[0], 0.0, 0.0]
}

fn forward() -> [f64; MOUNT] {
    [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
}
