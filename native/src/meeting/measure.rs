//! Pixels to wall points with their uncertainty to first order: the twin of `calibore.rigs.triangulate` and of propagation.

use super::camera::Sight;
use super::functions::clock;
use super::lanes::{dot, Lanes, Mask, Vector, LANES};
use super::modes::{Mode, Motion};
use super::mount::{square_from_axis, Mount, Ray};
use super::rig::{Make, Rig};
use super::surface::{Contact, Meeting, Surface};

/// Radius, axial, clock, and the independent and common uncertainty of radius and axial.
pub const COLUMNS: usize = 7;

/// See `calibore.status.Status`.
mod status {
    use super::Lanes;

    pub const OK: Lanes = Lanes::all(0.0);
    pub const NO_PEAK: Lanes = Lanes::all(3.0);
    pub const OUTSIDE_LENS: Lanes = Lanes::all(7.0);
    pub const GRAZING: Lanes = Lanes::all(8.0);
    pub const BEHIND: Lanes = Lanes::all(9.0);
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

pub struct Point {
    pub columns: [Lanes; COLUMNS],
    pub status: [u8; LANES],
}

#[inline(always)]
pub fn measure<S: Surface, M: Mount>(make: &Make, rig: &Rig<S, M>, modes: &[Mode], pixels: &Pixels, from: usize) -> Point {
    let (u, v) = (Lanes::load(&pixels.u[from..]), Lanes::load(&pixels.v[from..]));
    let sight = rig.camera.sight(&make.optics, u, v);
    let ray = Ray::of(&sight, &rig.mount);
    let meeting = chosen(&rig.surface.meet(&ray), &ray, pixels.choice, from, S::TWICE);
    let status = status_of(u.is_nan() | v.is_nan(), sight.seen, &meeting);
    let measured = meeting.admissible() & sight.seen;
    let distance = measured.choose(meeting.distance, Lanes::NAN);
    let contact = rig.surface.contact(&ray, distance);
    let point = ray.point(distance);
    let radius = rig.mount.radius(&sight, distance, point);
    let [zenith, azimuth] = sight.turns();
    let turns = [rig.mount.turn(zenith), rig.mount.turn(azimuth)];
    let per_radius = Lanes::ONE / radius;
    let outwards = [point[0] * per_radius, point[1] * per_radius];
    let by_radius = Slope::of(&Outwards(outwards), &ray, &contact, turns, distance);
    let by_axial = Slope::of(&Ahead, &ray, &contact, turns, distance);
    let (mut common_radius, mut common_axial) = (Lanes::ZERO, Lanes::ZERO);
    for mode in modes {
        let motion = mode.motion((&rig.surface, &rig.mount), &contact, &sight, distance);
        let (mut radial, mut axial) = (by_radius.change(&motion), by_axial.change(&motion));
        if M::PARAMETERS > 0 {
            let leaving = dot(contact.gradient, motion.shift);
            radial = radial + (-by_radius.carried).fused(leaving, Outwards(outwards).of(motion.shift));
            axial = axial + (-by_axial.carried).fused(leaving, Ahead.of(motion.shift));
        }
        common_radius = radial.fused(radial, common_radius);
        common_axial = axial.fused(axial, common_axial);
    }
    let columns = [
        radius,
        point[2],
        clock(point[0], point[1]),
        by_radius.noise(&sight, pixels, from),
        measured.choose(common_radius.sqrt(), Lanes::NAN),
        by_axial.noise(&sight, pixels, from),
        measured.choose(common_axial.sqrt(), Lanes::NAN),
    ];
    Point { columns, status }
}

/// A part of a vector.
pub trait Coordinate {
    fn of(&self, vector: Vector) -> Lanes;
}

/// Along a direction (x, y) away from the axis.
pub struct Outwards(pub [Lanes; 2]);

impl Coordinate for Outwards {
    #[inline(always)]
    fn of(&self, vector: Vector) -> Lanes {
        self.0[0].fused(vector[0], self.0[1] * vector[1])
    }
}

/// Along the axis.
struct Ahead;

impl Coordinate for Ahead {
    #[inline(always)]
    fn of(&self, vector: Vector) -> Lanes {
        vector[2]
    }
}

/// How one coordinate of the meeting changes: `carried` when the surface leaves the ray, `turned` when the ray turns.
pub struct Slope {
    pub carried: Lanes,
    turned: [Lanes; 2],
}

impl Slope {
    #[inline(always)]
    pub fn of(coordinate: &impl Coordinate, ray: &Ray, contact: &Contact, turns: [Vector; 2], distance: Lanes) -> Self {
        let carried = coordinate.of(ray.direction) * contact.per_slope;
        let [zenith, azimuth] = turns;
        let by_zenith = (-carried).fused(dot(contact.gradient, zenith), coordinate.of(zenith));
        let by_azimuth = (-carried).fused(dot(contact.gradient, azimuth), coordinate.of(azimuth));
        Slope { carried, turned: [distance * by_zenith, distance * by_azimuth] }
    }

    #[inline(always)]
    pub fn change(&self, motion: &Motion) -> Lanes {
        let turned = self.turned[1].fused(motion.turns[1], self.turned[0] * motion.turns[0]);
        (-self.carried).fused(motion.surface, turned)
    }

    /// By u and by v of the pixel.
    #[inline(always)]
    pub fn by_pixel(&self, sight: &Sight) -> [Lanes; 2] {
        let (zenith, azimuth) = (self.turned[0] * sight.by_radius, self.turned[1] * sight.across);
        let by_u = zenith.fused(sight.cos_azimuth, -(azimuth * sight.sin_azimuth));
        [by_u, zenith.fused(sight.sin_azimuth, azimuth * sight.cos_azimuth) * sight.per_aspect]
    }

    #[inline(always)]
    fn noise(&self, sight: &Sight, pixels: &Pixels, from: usize) -> Lanes {
        let [by_u, by_v] = self.by_pixel(sight);
        let size = match pixels.direction {
            Some([u, v]) => (by_u * Lanes::load(&u[from..]) + by_v * Lanes::load(&v[from..])).abs(),
            None => by_u.fused(by_u, by_v * by_v).sqrt(),
        };
        size * pixels.noise.at(from)
    }
}

/// Of two meetings the one ahead that is nearer to the radius, or one that at least exists.
#[inline(always)]
pub fn chosen(meetings: &[Meeting; 2], ray: &Ray, choice: Choice, from: usize, twice: bool) -> Meeting {
    let [near, far] = meetings;
    if !twice {
        return *near;
    }
    let second = match choice {
        Choice::Numbered(branch) => branch.at(from).more(Lanes::ZERO),
        Choice::Nearest(prior) => {
            let prior = prior.at(from);
            let squares = [square_from_axis(ray.point(near.distance)), square_from_axis(ray.point(far.distance))];
            let usable = [near.ahead() & squares[0].more(Lanes::ZERO), far.ahead() & squares[1].more(Lanes::ZERO)];
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
pub fn status_of(no_pixel: Mask, seen: Mask, meeting: &Meeting) -> [u8; LANES] {
    let behind = meeting.behind.choose(status::BEHIND, status::OK);
    let grazing = (meeting.grazing | !meeting.exists).choose(status::GRAZING, behind);
    let unseen = seen.choose(grazing, status::OUTSIDE_LENS);
    no_pixel.choose(status::NO_PEAK, unseen).to_bytes()
}
