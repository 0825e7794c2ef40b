//! Pixels to wall points with their uncertainty to first order: the twin of `calibore.rigs.triangulate` and of propagation.

use super::camera::{Camera, Mount, Ray, Sight, CAMERA, MOUNT};
use super::functions::clock;
use super::lanes::{dot, Lanes, Mask, Vector, LANES};
use super::modes::{Mode, Motion};
use super::rig::{Make, Numbers};
use super::surface::{Contact, Meeting, Surface, SURFACE};

/// Radius, axial, clock, and the independent and common uncertainty of radius and axial.
pub const COLUMNS: usize = 7;

pub mod status {
    pub const OK: u8 = 0;
    pub const NO_PEAK: u8 = 3;
    pub const OUTSIDE_LENS: u8 = 7;
    pub const GRAZING: u8 = 8;
    pub const BEHIND: u8 = 9;
}

/// One number for all points, or one for each.
#[derive(Clone, Copy)]
pub struct Shared<'a>(pub &'a [f64]);

impl Shared<'_> {
    #[inline(always)]
    fn at(&self, from: usize) -> Lanes {
        if let [one] = self.0 {
            Lanes::all(*one)
        } else {
            Lanes::load(&self.0[from..])
        }
    }
}

/// Which meeting counts: the one nearest to a radius, as a ratio, or the one of this number.
#[derive(Clone, Copy)]
pub enum Choice<'a> {
    Nearest(Shared<'a>),
    Numbered(Shared<'a>),
}

#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub choice: Choice<'a>,
    pub noise: Shared<'a>,
    /// u and v parts of the direction of the noise; both u and v are noisy where there is none.
    pub direction: Option<[&'a [f64]; 2]>,
}

/// A surface, a camera and its mount, the same in all lanes or another one in each.
pub struct Rig<S> {
    pub surface: S,
    pub mount: Option<Mount>,
    pub camera: Camera,
}

impl<S: Surface> Rig<S> {
    pub fn same(make: &Make, numbers: &Numbers) -> Self {
        let lanes = |numbers: &[f64; MOUNT]| Mount::of(&numbers.map(Lanes::all));
        let camera: [Lanes; CAMERA] = numbers.camera.map(Lanes::all);
        let surface: [Lanes; SURFACE] = numbers.surface.map(Lanes::all);
        Rig { surface: S::of(&surface), mount: make.side_facing.then(|| lanes(&numbers.mount)), camera: Camera::of(&camera) }
    }

    /// Unit vectors in which the ray turns with growing zenith and with growing azimuth.
    #[inline(always)]
    fn turns(&self, sight: &Sight) -> [Vector; 2] {
        let turns = sight.turns();
        match &self.mount {
            Some(mount) => [mount.turn(turns[0]), mount.turn(turns[1])],
            None => turns,
        }
    }
}

pub struct Point {
    pub columns: [Lanes; COLUMNS],
    pub status: [u8; LANES],
}

#[inline(always)]
pub fn measure<S: Surface>(make: &Make, rig: &Rig<S>, modes: &[Mode], pixels: &Pixels, from: usize) -> Point {
    let (u, v) = (Lanes::load(&pixels.u[from..]), Lanes::load(&pixels.v[from..]));
    let sight = rig.camera.sight(&make.optics, u, v);
    let ray = Ray::of(&sight, rig.mount.as_ref());
    let meeting = chosen(&rig.surface.meet(&ray), &ray, pixels.choice, from, S::TWICE);
    let status = status_of(u.is_nan() | v.is_nan(), sight.seen, &meeting);
    let measured = meeting.admissible() & sight.seen;
    let distance = measured.choose(meeting.distance, Lanes::NAN);
    let contact = rig.surface.contact(&ray, distance);
    let point = ray.point(distance);
    let radius = (point[0] * point[0] + point[1] * point[1]).sqrt();
    let turns = rig.turns(&sight);
    let per_radius = Lanes::ONE / radius;
    let outwards = [point[0] * per_radius, point[1] * per_radius];
    let slopes = [
        Slope::of(|a: Vector| outwards[0] * a[0] + outwards[1] * a[1], &ray, &contact, turns, distance),
        Slope::of(|a: Vector| a[2], &ray, &contact, turns, distance),
    ];
    let independent = [slopes[0].noise(&sight, pixels, from), slopes[1].noise(&sight, pixels, from)];
    let mut common = [Lanes::ZERO; 2];
    for mode in modes {
        let motion = mode.motion(&rig.surface, &contact, &sight, distance);
        let along = [outwards[0] * motion.shift[0] + outwards[1] * motion.shift[1], motion.shift[2]];
        for i in 0..2 {
            let mut change = slopes[i].change(&motion);
            if mode.moves_mount() {
                change = change + along[i] - slopes[i].carried * dot(contact.gradient, motion.shift);
            }
            common[i] = common[i] + change * change;
        }
    }
    let or_nan = |value: Lanes| measured.choose(value, Lanes::NAN);
    let (common_radius, common_axial) = (or_nan(common[0].sqrt()), or_nan(common[1].sqrt()));
    Point { columns: [radius, point[2], clock(point[0], point[1]), independent[0], common_radius, independent[1], common_axial], status }
}

/// How one coordinate of the meeting changes: `carried` when the surface leaves the ray, `turned` when the ray turns.
struct Slope {
    carried: Lanes,
    turned: [Lanes; 2],
}

impl Slope {
    #[inline(always)]
    fn of(coordinate: impl Fn(Vector) -> Lanes, ray: &Ray, contact: &Contact, turns: [Vector; 2], distance: Lanes) -> Self {
        let carried = coordinate(ray.direction) * contact.per_slope;
        let turned = |turn: Vector| distance * (coordinate(turn) - carried * dot(contact.gradient, turn));
        Slope { carried, turned: [turned(turns[0]), turned(turns[1])] }
    }

    #[inline(always)]
    fn change(&self, motion: &Motion) -> Lanes {
        self.turned[0] * motion.turns[0] + self.turned[1] * motion.turns[1] - self.carried * motion.surface
    }

    #[inline(always)]
    fn noise(&self, sight: &Sight, pixels: &Pixels, from: usize) -> Lanes {
        let (zenith, azimuth) = (self.turned[0] * sight.by_radius, self.turned[1] * sight.across);
        let by_u = zenith * sight.cos_azimuth - azimuth * sight.sin_azimuth;
        let by_v = (zenith * sight.sin_azimuth + azimuth * sight.cos_azimuth) * sight.per_aspect;
        let size = match pixels.direction {
            Some([u, v]) => (by_u * Lanes::load(&u[from..]) + by_v * Lanes::load(&v[from..])).abs(),
            None => (by_u * by_u + by_v * by_v).sqrt(),
        };
        size * pixels.noise.at(from)
    }
}

/// Of two meetings the admissible one that is nearer to the radius, or one that at least exists.
#[inline(always)]
fn chosen(meetings: &[Meeting; 2], ray: &Ray, choice: Choice, from: usize, twice: bool) -> Meeting {
    let [near, far] = meetings;
    if !twice {
        return *near;
    }
    let second = match choice {
        Choice::Numbered(branch) => branch.at(from).more(Lanes::ZERO),
        Choice::Nearest(prior) => {
            let prior = prior.at(from);
            let square_of = |meeting: &Meeting| {
                let point = ray.point(meeting.distance);
                point[0] * point[0] + point[1] * point[1]
            };
            let squares = [square_of(near), square_of(far)];
            let usable = [near.admissible() & squares[0].more(Lanes::ZERO), far.admissible() & squares[1].more(Lanes::ZERO)];
            // |log| of the ratio of the larger square to the prior, less that of the smaller one
            let farther = squares[1].more(squares[0]);
            let product_beyond = (squares[0] * squares[1]).more(prior.squared() * prior.squared());
            let far_is_nearer = (farther & !product_beyond) | (!farther & product_beyond);
            (usable[1] & (!usable[0] | far_is_nearer)) | (!usable[0] & !usable[1] & far.exists & !near.exists)
        }
    };
    near.or(far, second)
}

#[inline(always)]
fn status_of(no_pixel: Mask, seen: Mask, meeting: &Meeting) -> [u8; LANES] {
    let mut codes = [0; LANES];
    for (k, code) in codes.iter_mut().enumerate() {
        let choose = |mask: u64, yes: u8, no: u64| (mask & u64::from(yes)) | (!mask & no);
        let behind = choose(meeting.behind.0[k], status::BEHIND, u64::from(status::OK));
        let grazing = choose(meeting.grazing.0[k] | !meeting.exists.0[k], status::GRAZING, behind);
        let unseen = choose(!seen.0[k], status::OUTSIDE_LENS, grazing);
        *code = choose(no_pixel.0[k], status::NO_PEAK, unseen) as u8;
    }
    codes
}
