//! Monte Carlo: the meetings of noisy pixels with rigs drawn at random, every draw's rig the same for all pixels.

use super::intervals::intervals;
use super::lanes::{Lanes, Mask, LANES};
use super::mount::{Mount, Ray};
use super::random::Stream;
use super::rig::{Make, Rig};
use super::surface::Surface;

/// Mean of radius and axial, their variances and covariance, values that exist, and `intervals` of both.
pub const SUMMARY: usize = 6 + 2 * 5;
/// Rigs that stay in the cache while some pixels meet them.
pub const BLOCK: usize = 16;

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

impl Pixel {
    #[inline(always)]
    fn place(&self, stream: &mut Stream) -> [Lanes; 2] {
        let (u, v, noise) = (Lanes::all(self.u), Lanes::all(self.v), self.noise);
        if noise == 0.0 {
            return [u, v];
        }
        let [first, second] = stream.normals();
        match self.direction {
            None => [first.fused(Lanes::all(noise), u), second.fused(Lanes::all(noise), v)],
            Some([x, y]) => [first.fused(Lanes::all(noise * x), u), first.fused(Lanes::all(noise * y), v)],
        }
    }
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

    /// Adds the meetings with `rigs`, chunks of lanes of which the first has the number `from`, and keeps them where there is room.
    #[inline(always)]
    pub fn add<S: Surface, M: Mount>(&mut self, make: &Make, rigs: &[Rig<S, M>], from: usize, kept: Option<[&mut [f64]; 2]>) {
        let pixel = self.pixel;
        let near = pixel.near.map(Lanes::all);
        let mut kept = kept;
        let (mut count, mut sums, mut stream) = (self.count, self.sums, self.stream);
        for (chunk, rig) in rigs.iter().enumerate() {
            let [u, v] = pixel.place(&mut stream);
            let (radius, axial, here) = met(make, rig, (u, v), pixel.far);
            let r = here.choose(radius - near[0], Lanes::ZERO);
            let h = here.choose(axial - near[1], Lanes::ZERO);
            count = count + here.choose(Lanes::ONE, Lanes::ZERO);
            let [r_sum, h_sum, rr, hh, rh] = sums;
            sums = [r_sum + r, h_sum + h, r.fused(r, rr), h.fused(h, hh), r.fused(h, rh)];
            if let Some([radii, axials]) = &mut kept {
                let place = (from + chunk) * LANES;
                here.choose(radius, Lanes::NAN).store(&mut radii[place..]);
                here.choose(axial, Lanes::NAN).store(&mut axials[place..]);
            }
        }
        (self.count, self.sums, self.stream) = (count, sums, stream);
    }

    /// `SUMMARY` numbers; of no value where there is no or only one draw to tell them.
    pub fn summary(&self, values: &mut [Vec<f64>; 2], probability: Option<f64>) -> [f64; SUMMARY] {
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
        if let Some(probability) = probability {
            for (values, to) in values.iter_mut().zip(summary[6..].chunks_exact_mut(5)) {
                to.copy_from_slice(&intervals(present(values), probability));
            }
        }
        summary
    }
}

/// The values that are no NaN, moved to the front.
fn present(values: &mut [f64]) -> &mut [f64] {
    let mut count = 0;
    for i in 0..values.len() {
        let value = values[i];
        values[count] = value;
        count += usize::from(!value.is_nan());
    }
    &mut values[..count]
}

/// Radius and axial of the meeting, and whether there is one: ahead, lit and seen, grazing or not.
#[inline(always)]
fn met<S: Surface, M: Mount>(make: &Make, rig: &Rig<S, M>, pixel: (Lanes, Lanes), far: bool) -> (Lanes, Lanes, Mask) {
    let sight = rig.camera.sight(&make.optics, pixel.0, pixel.1);
    let ray = Ray::of(&sight, &rig.mount);
    let [first, second] = rig.surface.meet(&ray);
    let meeting = if far { second } else { first };
    let here = meeting.ahead() & sight.seen;
    let point = ray.point(meeting.distance);
    (rig.mount.radius(&sight, meeting.distance, point), point[2], here)
}

/// The meeting with one rig, without noise; 0 where there is none.
pub fn nominal<S: Surface, M: Mount>(make: &Make, rig: &Rig<S, M>, pixel: &Pixel) -> [f64; 2] {
    let (radius, axial, here) = met(make, rig, (Lanes::all(pixel.u), Lanes::all(pixel.v)), pixel.far);
    [here.choose(radius, Lanes::ZERO).0[0], here.choose(axial, Lanes::ZERO).0[0]]
}
