//! The rays of one line as points of the wall, and how radius and clock of each move: the twin of `calibore.profiling._take`.

use super::cone::Cone;
use super::dispatch::{widest, Work};
use super::flat::Flat;
use super::functions::clock;
use super::lanes::{Lanes, LANES};
use super::measure::{chosen, status_of, Outwards, Pixels, Slope};
use super::modes::Mode;
use super::mount::{Forward, Mount, Ray};
use super::rig::{Make, Rig};
use super::surface::{Kind, Surface};

/// Rows over the n points: x, y, z [m], radius [m], clock [rad]; `along` [m/px] and `turn` [rad/px], of radius and clock with a pixel
/// along the ray's own direction; cosine of the zenith.
pub const COLUMNS: usize = 8;

#[derive(Default)]
pub struct Placed {
    pub columns: [Vec<f64>; COLUMNS],
    /// What each mode does to radius and clock of the points.
    pub radial: Vec<Vec<f64>>,
    pub turned: Vec<Vec<f64>>,
    pub status: Vec<u8>,
}

/// For cameras that face ahead. The pixels need directions.
pub fn place_all(make: &Make, parameters: &[f64], modes: &[Mode], pixels: &Pixels) -> Placed {
    let (n, mut placed) = (pixels.u.len(), Placed::default());
    let row = || vec![0.0; n];
    placed.columns = std::array::from_fn(|_| row());
    placed.radial = modes.iter().map(|_| row()).collect();
    placed.turned = placed.radial.clone();
    placed.status = vec![0; n];
    let to = &mut placed;
    match make.kind {
        Kind::Cone => widest(Placing { make, rig: &make.same::<Cone, Forward>(parameters), modes, pixels, to }),
        _ => widest(Placing { make, rig: &make.same::<Flat, Forward>(parameters), modes, pixels, to }),
    }
    placed
}

struct Placing<'a, S> {
    make: &'a Make,
    rig: &'a Rig<S, Forward>,
    modes: &'a [Mode],
    pixels: &'a Pixels<'a>,
    to: &'a mut Placed,
}

impl<S: Surface> Work for Placing<'_, S> {
    #[inline(always)]
    fn run(mut self) {
        for from in (0..self.pixels.u.len()).step_by(LANES) {
            self.place(from);
        }
    }
}

impl<S: Surface> Placing<'_, S> {
    #[inline(always)]
    fn place(&mut self, from: usize) {
        let (rig, pixels) = (self.rig, self.pixels);
        let (u, v) = (Lanes::load(&pixels.u[from..]), Lanes::load(&pixels.v[from..]));
        let sight = rig.camera.sight(&self.make.optics, u, v);
        let ray = Ray::of(&sight, &rig.mount);
        let meeting = chosen(&rig.surface.meet(&ray), &ray, pixels.choice, from, S::TWICE);
        let status = status_of(u.is_nan() | v.is_nan(), sight.seen, &meeting);
        let distance = (meeting.admissible() & sight.seen).choose(meeting.distance, Lanes::NAN);
        let contact = rig.surface.contact(&ray, distance);
        let point = ray.point(distance);
        let radius = rig.mount.radius(&sight, distance, point);
        let per_radius = Lanes::ONE / radius;
        let outwards = Outwards([point[0] * per_radius, point[1] * per_radius]);
        let clockwise = Outwards([-(outwards.0[1] * per_radius), outwards.0[0] * per_radius]);
        let turns = sight.turns();
        let by_radius = Slope::of(&outwards, &ray, &contact, turns, distance);
        let by_clock = Slope::of(&clockwise, &ray, &contact, turns, distance);
        let [du, dv] = pixels.direction.unwrap_or([&[], &[]]);
        let (du, dv) = (Lanes::load(&du[from..]), Lanes::load(&dv[from..]));
        let ([radius_by_u, radius_by_v], [clock_by_u, clock_by_v]) = (by_radius.by_pixel(&sight), by_clock.by_pixel(&sight));
        let (along, turn) = (radius_by_u * du + radius_by_v * dv, clock_by_u * du + clock_by_v * dv);
        for (k, mode) in self.modes.iter().enumerate() {
            let motion = mode.motion((&rig.surface, &rig.mount), &contact, &sight, distance);
            by_radius.change(&motion).store(&mut self.to.radial[k][from..]);
            by_clock.change(&motion).store(&mut self.to.turned[k][from..]);
        }
        let [x, y, z] = point;
        let columns = [x, y, z, radius, clock(x, y), along, turn, sight.cosine];
        columns.into_iter().zip(&mut self.to.columns).for_each(|(values, column)| values.store(&mut column[from..]));
        self.to.status[from..].iter_mut().zip(status).for_each(|(to, status)| *to = status);
    }
}
