//! Both meetings of rays with a cone, and how many standard uncertainties each is from ceasing to exist: the twins of
//! `calibore.rigs.meetings_of` and `margin`, for cameras that face ahead.

use super::camera::Sight;
use super::cone::Cone;
use super::dispatch::{widest, Work};
use super::frontier::frontiers;
use super::lanes::{along, Lanes, Vector, LANES};
use super::modes::Mode;
use super::mount::{Forward, Mount, Ray};
use super::rig::{Make, Rig};
use super::surface::Surface;

/// Second-order term of each frontier on the near and on the far meeting; see `SECOND_ORDER` of the twin.
const SECOND_ORDER: [[f64; 2]; 3] = [[1.0, 1.0], [0.0, -RECEDING], [RECEDING, 0.0]];
const RECEDING: f64 = 4.0;
const FOLDS: [bool; 3] = [true, false, false];
const LEAST: f64 = 1e-300;

/// Radius of each ray's near and far meeting, NaN where it is not ahead; and whether they exist at all.
pub struct Candidates {
    pub radius: [Vec<f64>; 2],
    pub exists: [Vec<bool>; 2],
}

/// Pixels, and per ray the direction along which they are uncertain and by how much.
pub struct Folding<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub direction: [&'a [f64]; 2],
    pub noise: &'a [f64],
    /// 1 for the far meeting.
    pub branch: &'a [f64],
}

pub fn candidates(make: &Make, parameters: &[f64], u: &[f64], v: &[f64]) -> Candidates {
    let n = u.len();
    let mut to = Candidates { radius: [vec![0.0; n], vec![0.0; n]], exists: [vec![false; n], vec![false; n]] };
    widest(Meeting { make, rig: &make.same(parameters), u, v, to: &mut to });
    to
}

pub fn margins(make: &Make, parameters: &[f64], modes: &[Mode], rays: &Folding) -> Vec<f64> {
    let mut to = vec![0.0; rays.u.len()];
    widest(Margins { make, rig: &make.same(parameters), modes, rays, to: &mut to });
    to
}

struct Meeting<'a> {
    make: &'a Make,
    rig: &'a Rig<Cone, Forward>,
    u: &'a [f64],
    v: &'a [f64],
    to: &'a mut Candidates,
}

impl Work for Meeting<'_> {
    #[inline(always)]
    fn run(self) {
        for from in (0..self.u.len()).step_by(LANES) {
            let sight = self.rig.camera.sight(&self.make.optics, Lanes::load(&self.u[from..]), Lanes::load(&self.v[from..]));
            let ray = Ray::of(&sight, &self.rig.mount);
            for (k, meeting) in self.rig.surface.meet(&ray).iter().enumerate() {
                let radius = self.rig.mount.radius(&sight, meeting.distance, ray.direction);
                meeting.ahead().choose(radius, Lanes::NAN).store(&mut self.to.radius[k][from..]);
                let exists = self.to.exists[k][from..].iter_mut().zip(meeting.exists.0);
                exists.for_each(|(to, exists)| *to = exists != 0);
            }
        }
    }
}

struct Margins<'a> {
    make: &'a Make,
    rig: &'a Rig<Cone, Forward>,
    modes: &'a [Mode],
    rays: &'a Folding<'a>,
    to: &'a mut [f64],
}

impl Work for Margins<'_> {
    #[inline(always)]
    fn run(self) {
        for from in (0..self.to.len()).step_by(LANES) {
            self.margin(from).store(&mut self.to[from..]);
        }
    }
}

impl Margins<'_> {
    #[inline(always)]
    fn margin(&self, from: usize) -> Lanes {
        let (rig, rays) = (self.rig, self.rays);
        let at = |values: &[f64]| Lanes::load(&values[from..]);
        let sight = rig.camera.sight(&self.make.optics, at(rays.u), at(rays.v));
        let turns = sight.turns();
        let along_noise = turned_along(&sight, turns, rays.direction.map(at));
        let (noise, far) = (at(rays.noise), at(rays.branch).more(Lanes::ZERO));
        let found = frontiers(&rig.surface, sight.direction);
        let mut squares = [Lanes::ZERO; 3];
        for mode in self.modes {
            let [zenith, azimuth] = mode.turns(&sight);
            let shift = turn(turns, zenith, azimuth);
            for (frontier, square) in found.iter().zip(&mut squares) {
                let change = frontier.turned(shift) + frontier.moved(mode.of_surface());
                *square = change.fused(change, *square);
            }
        }
        let (mut curvature, mut nearest) = (Lanes::ZERO, Lanes::all(f64::INFINITY));
        for (k, frontier) in found.iter().enumerate() {
            let by_noise = frontier.turned(along_noise) * noise;
            let spread = by_noise.fused(by_noise, squares[k]).sqrt();
            let bend = far.choose(Lanes::all(SECOND_ORDER[k][1]), Lanes::all(SECOND_ORDER[k][0]));
            let finite = frontier.value.is_finite() | frontier.value.is_nan();
            let concerns = bend.abs().more(Lanes::ZERO) & spread.more(Lanes::ZERO) & finite;
            let away = frontier.value / spread;
            let counts = if FOLDS[k] { concerns } else { concerns & frontier.value.at_most(Lanes::ZERO) };
            nearest = counts.choose(away.least(nearest), nearest);
            let bent = concerns & frontier.value.more(Lanes::ZERO);
            curvature = curvature + bent.choose(bend / away, Lanes::ZERO);
        }
        let bound = curvature.abs();
        let bound = Lanes::ONE / bound.more(Lanes::all(LEAST)).choose(bound, Lanes::all(LEAST));
        nearest.least(bound)
    }
}

/// How the ray turns with a step of the pixel in this direction.
#[inline(always)]
fn turned_along(sight: &Sight, turns: [Vector; 2], [du, dv]: [Lanes; 2]) -> Vector {
    let dv = dv * sight.per_aspect;
    let (outwards, round) = (sight.cos_azimuth.fused(du, sight.sin_azimuth * dv), sight.cos_azimuth.fused(dv, -(sight.sin_azimuth * du)));
    turn(turns, sight.by_radius * outwards, sight.across * round)
}

#[inline(always)]
fn turn([by_zenith, by_azimuth]: [Vector; 2], zenith: Lanes, azimuth: Lanes) -> Vector {
    along(along([Lanes::ZERO; 3], zenith, by_zenith), azimuth, by_azimuth)
}
