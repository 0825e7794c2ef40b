//! Monte Carlo: the meetings of noisy pixels with rigs drawn at random, every draw's rig the same for all pixels.

use super::camera::{Camera, Mount, Ray, CAMERA, MOUNT};
use super::intervals::intervals;
use super::lanes::{Lanes, Mask, LANES};
use super::random::Stream;
use super::rig::{Make, Numbers};
use super::surface::{Surface, SURFACE};

/// Mean of radius and axial, their variances and covariance, values that exist, and `intervals` of both.
pub const SUMMARY: usize = 6 + 2 * 5;
/// Rigs that stay in the cache while some pixels meet them.
pub const BLOCK: usize = 16;

/// Drawn rigs in chunks of lanes; NaN in lanes beyond the last one, which meets nothing.
pub struct Rigs {
    pub surface: Vec<[Lanes; SURFACE]>,
    pub camera: Vec<[Lanes; CAMERA]>,
    pub mount: Vec<[Lanes; MOUNT]>,
}

impl Rigs {
    /// Of rows of parameters.
    pub fn new(make: &Make, rows: &[f64]) -> Self {
        let rows: Vec<&[f64]> = rows.chunks_exact(make.parameters()).collect();
        let mut rigs = Rigs { surface: Vec::new(), camera: Vec::new(), mount: Vec::new() };
        for chunk in rows.chunks(LANES) {
            let numbers: Vec<Numbers> = chunk.iter().map(|row| make.numbers(row)).collect();
            rigs.surface.push(across(&numbers, |n| &n.surface));
            rigs.camera.push(across(&numbers, |n| &n.camera));
            if make.side_facing {
                rigs.mount.push(across(&numbers, |n| &n.mount));
            }
        }
        rigs
    }
}

fn across<const N: usize>(numbers: &[Numbers], part: impl Fn(&Numbers) -> &[f64; N]) -> [Lanes; N] {
    std::array::from_fn(|i| Lanes(std::array::from_fn(|k| numbers.get(k).map_or(f64::NAN, |n| part(n)[i]))))
}

/// One pixel: its place and noise, and which meeting counts.
#[derive(Clone, Copy)]
pub struct Pixel {
    pub u: f64,
    pub v: f64,
    pub far: bool,
    pub noise: f64,
    pub direction: Option<[f64; 2]>,
    /// Values near which radius and axial will be, for the accuracy of sums.
    pub near: [f64; 2],
}

pub struct Tally {
    pixel: Pixel,
    stream: Stream,
    count: Lanes,
    sums: [Lanes; 5],
}

impl Tally {
    pub fn new(pixel: Pixel, stream: Stream) -> Self {
        Tally { pixel, stream, count: Lanes::ZERO, sums: [Lanes::ZERO; 5] }
    }

    /// Adds the meetings with the rigs of chunks `from`..`to`, and keeps them where there is room.
    #[inline(always)]
    pub fn add<S: Surface>(&mut self, make: &Make, rigs: &Rigs, from: usize, to: usize, kept: Option<[&mut [f64]; 2]>) {
        let pixel = self.pixel;
        let near = pixel.near.map(Lanes::all);
        let mut kept = kept;
        let (mut count, mut sums) = (self.count, self.sums);
        for chunk in from..to {
            let [u, v] = self.place();
            let camera = Camera::of(&rigs.camera[chunk]);
            let mount = rigs.mount.get(chunk).map(Mount::of);
            let (radius, axial, here) = met(make, &S::of(&rigs.surface[chunk]), &camera, mount.as_ref(), (u, v), pixel.far);
            let r = here.choose(radius - near[0], Lanes::ZERO);
            let h = here.choose(axial - near[1], Lanes::ZERO);
            count = count + here.choose(Lanes::ONE, Lanes::ZERO);
            for (sum, term) in sums.iter_mut().zip([r, h, r * r, h * h, r * h]) {
                *sum = *sum + term;
            }
            if let Some([radii, axials]) = &mut kept {
                let place = chunk * LANES;
                here.choose(radius, Lanes::NAN).store(&mut radii[place..]);
                here.choose(axial, Lanes::NAN).store(&mut axials[place..]);
            }
        }
        (self.count, self.sums) = (count, sums);
    }

    #[inline(always)]
    fn place(&mut self) -> [Lanes; 2] {
        let Pixel { u, v, noise, direction, .. } = self.pixel;
        let (u, v) = (Lanes::all(u), Lanes::all(v));
        if noise == 0.0 {
            return [u, v];
        }
        let [first, second] = self.stream.normals();
        match direction {
            None => [u + Lanes::all(noise) * first, v + Lanes::all(noise) * second],
            Some([x, y]) => [u + Lanes::all(noise * x) * first, v + Lanes::all(noise * y) * first],
        }
    }

    /// `SUMMARY` numbers; of no value where there is no or only one draw to tell them.
    pub fn summary(&self, kept: Option<[&mut Vec<f64>; 2]>, probability: f64) -> [f64; SUMMARY] {
        let mut summary = [f64::NAN; SUMMARY];
        let count = self.count.sum();
        let [r, h, rr, hh, rh] = [0, 1, 2, 3, 4].map(|i| self.sums[i].sum());
        let (mean_r, mean_h) = (r / count, h / count);
        let about = |products: f64, a: f64, b: f64| (products - count * a * b) / (count - 1.0);
        if count > 0.0 {
            summary[..2].copy_from_slice(&[self.pixel.near[0] + mean_r, self.pixel.near[1] + mean_h]);
        }
        if count > 1.0 {
            let variances = [about(rr, mean_r, mean_r).max(0.0), about(hh, mean_h, mean_h).max(0.0), about(rh, mean_r, mean_h)];
            summary[2..5].copy_from_slice(&variances);
        }
        summary[5] = count;
        if let Some(kept) = kept {
            for (values, to) in kept.into_iter().zip(summary[6..].chunks_exact_mut(5)) {
                values.retain(|value| !value.is_nan());
                to.copy_from_slice(&intervals(values, probability));
            }
        }
        summary
    }
}

/// Radius and axial of the meeting, and whether there is one: ahead, lit and seen, grazing or not.
#[inline(always)]
fn met<S: Surface>(
    make: &Make,
    surface: &S,
    camera: &Camera,
    mount: Option<&Mount>,
    pixel: (Lanes, Lanes),
    far: bool,
) -> (Lanes, Lanes, Mask) {
    let sight = camera.sight(&make.optics, pixel.0, pixel.1);
    let ray = Ray::of(&sight, mount);
    let [first, second] = surface.meet(&ray);
    let meeting = if far { second } else { first };
    let here = meeting.exists & !meeting.behind & sight.seen & meeting.distance.less(Lanes::all(f64::INFINITY));
    let point = ray.point(meeting.distance);
    ((point[0] * point[0] + point[1] * point[1]).sqrt(), point[2], here)
}

/// The meeting with one rig, without noise; 0 where there is none.
pub fn nominal<S: Surface>(make: &Make, numbers: &Numbers, pixel: &Pixel) -> [f64; 2] {
    let (surface, camera) = (S::of(&numbers.surface.map(Lanes::all)), Camera::of(&numbers.camera.map(Lanes::all)));
    let mount = make.side_facing.then(|| Mount::of(&numbers.mount.map(Lanes::all)));
    let at = (Lanes::all(pixel.u), Lanes::all(pixel.v));
    let (radius, axial, here) = met(make, &surface, &camera, mount.as_ref(), at, pixel.far);
    [here.choose(radius, Lanes::ZERO).0[0], here.choose(axial, Lanes::ZERO).0[0]]
}
