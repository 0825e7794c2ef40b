//! Steger's line detector (see the Python module `_ridge`).

use super::rays::{Ray, Rays};
use super::refine::LONGEST_STEP;
use super::sampling::{Grey, Plane};
use super::settings::{Noise, Settings};
use super::statistics::floor;

const NARROWEST: f64 = 1.0;
const WIDEST: f64 = 8.0;
const WITHIN: f64 = 0.6;
const MOST_PIXELS: usize = 4;
const LEAST_CROSSING: f64 = 0.25;

/// (position, u) of the peak of `height` at each `position` along `rays`; NaN where there is no line about it.
pub fn ridges<T: Grey>(plane: &Plane<T>, rays: &Rays, position: &[f64], height: &[f64], settings: &Settings) -> Vec<(f64, f64)> {
    let kernel = Kernel::of(&settings.noise);
    let peaks = rays.rays.iter().zip(position).zip(height);
    peaks.map(|((ray, &position), &height)| kernel.ridge(plane, ray, position, height).unwrap_or((f64::NAN, f64::NAN))).collect()
}

/// Samples of a Gaussian, of its first and of its second derivative; and the variance of the slope across a line of height 0, the part of it
/// that grows with the height, and that which grows with its square.
struct Kernel {
    half: usize,
    weights: Vec<[f64; 3]>,
    variance: [f64; 3],
}

/// What a pixel sees of the line: the second derivative across it, the unit vector across it, and its point.
struct Seen {
    bend: f64,
    across: [f64; 2],
    point: [f64; 2],
}

impl Kernel {
    fn of(noise: &Noise) -> Kernel {
        let sigma = noise.width.clamp(NARROWEST, WIDEST);
        let half = (4.0 * sigma).ceil() as usize;
        let square = sigma * sigma;
        let reach = || (0..=2 * half).map(|k| k as f64 - half as f64);
        let total: f64 = reach().map(|x| (-x * x / (2.0 * square)).exp()).sum();
        let weights = reach().map(|x| {
            let smooth = (-x * x / (2.0 * square)).exp() / total;
            [smooth, x / square * smooth, (x * x / (square * square) - 1.0 / square) * smooth]
        });
        Kernel { half, weights: weights.collect(), variance: variance(sigma, noise) }
    }

    fn ridge<T: Grey>(&self, plane: &Plane<T>, ray: &Ray, position: f64, height: f64) -> Option<(f64, f64)> {
        let start = ray.at(position);
        let mut from = start;
        for _ in 0..MOST_PIXELS {
            let pixel = self.pixel(plane, from)?;
            let seen = self.seen(plane, pixel)?;
            let off = |other: [f64; 2]| (seen.point[0] - other[0]).abs().max((seen.point[1] - other[1]).abs());
            if off(pixel.map(|place| place as f64)) <= WITHIN {
                return self.crossing(&seen, ray, (position, start), height);
            }
            if off(start) > 2.0 * LONGEST_STEP {
                return None;
            }
            from = seen.point;
        }
        None
    }

    /// Where the line crosses the ray, straight from the point seen.
    fn crossing(&self, seen: &Seen, ray: &Ray, (position, start): (f64, [f64; 2]), height: f64) -> Option<(f64, f64)> {
        let along = |v: [f64; 2]| seen.across[0] * v[0] + seen.across[1] * v[1];
        let crossing = along(ray.direction);
        let step = along([seen.point[0] - start[0], seen.point[1] - start[1]]) / crossing;
        if !(crossing.abs() >= LEAST_CROSSING && step.abs() <= LONGEST_STEP) {
            return None;
        }
        let [dark, lit, speckled] = self.variance;
        let moved = (dark + lit * height + speckled * height * height).sqrt();
        Some((position + step, moved / (seen.bend * crossing).abs()))
    }

    /// The pixel at a place, if all it is weighed with lies in the picture; none where the place is NaN.
    fn pixel<T: Grey>(&self, plane: &Plane<T>, place: [f64; 2]) -> Option<[usize; 2]> {
        if place.iter().any(|place| place.is_nan()) {
            return None;
        }
        let within = |place: f64, size: usize| {
            let pixel = usize::try_from(floor(place + 0.5)).ok()?;
            (pixel >= self.half && pixel + self.half < size).then_some(pixel)
        };
        Some([within(place[0], plane.width)?, within(place[1], plane.height)?])
    }

    /// The line as seen from a pixel; none where there is no ridge.
    fn seen<T: Grey>(&self, plane: &Plane<T>, pixel: [usize; 2]) -> Option<Seen> {
        let (mut du, mut dv, mut uu, mut vv, mut uv) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (k, down) in self.weights.iter().enumerate() {
            let first = plane.index(pixel[0] - self.half, pixel[1] + k - self.half);
            let mut row = [0.0; 3];
            for (value, along) in plane.data[first..].iter().step_by(plane.bands).zip(&self.weights) {
                let value: f64 = (*value).into();
                row.iter_mut().zip(along).for_each(|(sum, weight)| *sum += value * weight);
            }
            du += row[1] * down[0];
            dv += row[0] * down[1];
            uu += row[2] * down[0];
            vv += row[0] * down[2];
            uv += row[1] * down[1];
        }
        let half = 0.5 * (uu - vv);
        let bend = 0.5 * (uu + vv) - (half * half + uv * uv).sqrt();
        let across = if uu < vv { [bend - vv, uv] } else { [uv, bend - uu] };
        let length = across[0].hypot(across[1]);
        if !(bend < 0.0 && length > 0.0) {
            return None;
        }
        let across = across.map(|part| part / length);
        let t = -(du * across[0] + dv * across[1]) / bend;
        Some(Seen { bend, across, point: [pixel[0] as f64 + t * across[0], pixel[1] as f64 + t * across[1]] })
    }
}

fn variance(sigma: f64, noise: &Noise) -> [f64; 3] {
    let [smooth, wide, grain] = [sigma, noise.width, noise.grain].map(|length| 1.0 / (length * length));
    let white = smooth * smooth / (8.0 * std::f64::consts::PI);
    let lit = white * smooth / sigma / (smooth + 0.5 * wide).powf(1.5);
    let narrow = smooth + wide;
    let speckled = 0.5 * grain * smooth.powi(3) / (narrow * narrow + narrow * grain).powf(1.5);
    let along = 1.0 + (grain + wide) / smooth;
    [noise.additive * white, noise.gain * lit, noise.contrast * speckled / along.sqrt()]
}
