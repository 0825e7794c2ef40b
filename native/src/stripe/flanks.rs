//! What the flanks tell of a line whose top is clipped (see the Python module `_flanks`).

use super::breadth::{breadth, breadths};
use super::neighbours::{reach_of, Standpoint};
use super::noise::MOST_CONTRAST;
use super::rays::Rays;
use super::settings::{Noise, MOST_SAMPLES};
use super::statistics::median;
use super::windows::{Windows, PHASES};

const OFTEN: f64 = 0.2;
const ROUNDS: usize = 6;
const UNSMEARED: usize = 2;
const MOST: f64 = 2.5;
const HIGHEST: f64 = 64.0;
const FEWEST: usize = 24;
const SEEN: f64 = 0.5;

/// What is learnt from the samples further from the middle than those that are often clipped on the rays nearby.
pub struct Flanks {
    pub windows: Windows,
    /// How far from the middle samples are often clipped on the rays about each, and half a sample further; -1 where none is.
    pub flank: Vec<f64>,
    pub noise: Noise,
    /// How wide the line of each ray is (see `breadths`); none where its top is hidden anywhere.
    pub levels: Vec<i8>,
}

impl Flanks {
    /// Of the line in `windows` about `stand`, which learns its height, from the rays `within` of each; its width from one ray in `every`.
    pub fn of(windows: &Windows, stand: &mut Standpoint, rays: &Rays, noise: Noise, (within, every): (f64, usize)) -> Flanks {
        let reach = reach_of(stand.start.len(), within, rays.spacing);
        let flank = often(&windows.clipped, reach, rays.closed);
        let flank: Vec<f64> = flank.into_iter().map(|far| if far >= 0.0 { far + 0.5 * windows.apart } else { -1.0 }).collect();
        let (usual, width) = (stand.height.clone(), noise.width);
        let mut flanks = Flanks { windows: windows.beyond(&usual, &flank), flank, noise, levels: Vec::new() };
        let hidden = flanks.hidden();
        if !hidden.contains(&true) {
            (flanks.noise, flanks.levels) = breadths(&flanks.windows, stand, every, flanks.noise, rays.closed);
            return flanks;
        }
        stand.height = flanks.heights(stand, &usual, (reach, rays.closed));
        for round in 0..ROUNDS {
            if round >= ROUNDS - UNSMEARED {
                let windows = windows.clone().unsmeared(rays, &hidden, &stand.height, flanks.noise.width);
                flanks.windows = windows.beyond(&usual, &flanks.flank);
            }
            let learnt = breadth(&flanks.windows, stand, every, flanks.noise);
            flanks.noise = Noise { width: learnt.width.clamp(width / MOST, width * MOST), ..learnt };
            stand.height = flanks.heights(stand, &usual, (reach, rays.closed));
        }
        let both = hidden.iter().zip(&stand.calm).filter(|(hidden, calm)| **hidden && **calm).count();
        if both as f64 > SEEN * stand.calm.iter().filter(|calm| **calm).count() as f64 {
            flanks.noise.contrast = MOST_CONTRAST;
        }
        flanks
    }

    /// On which rays the top of the line is hidden.
    pub fn hidden(&self) -> Vec<bool> {
        self.flank.iter().map(|flank| *flank >= 0.0).collect()
    }

    /// Height of the line where its top is clipped, elsewhere the `usual` one: by least squares of a Gaussian on the samples of the rays within
    /// `reach` of each, its height and the background free.
    fn heights(&self, stand: &Standpoint, usual: &[f64], (reach, closed): (usize, bool)) -> Vec<f64> {
        let sums = near(&self.sums(stand), reach, closed);
        let solved = sums.iter().map(|[count, one, two, total, leaning]| {
            let determinant = count * two - one * one;
            if determinant > 0.0 {
                (count * leaning - one * total) / determinant
            } else {
                f64::NAN
            }
        });
        let mut height: Vec<f64> = solved.collect();
        let seen = |ray: &usize| stand.calm[*ray] && self.flank[*ray] < 0.0 && height[*ray] > 0.0;
        let mut over: Vec<f64> = (0..height.len()).filter(seen).map(|ray| usual[ray] / height[ray]).collect();
        if over.len() >= FEWEST {
            let over = median(&mut over);
            height.iter_mut().for_each(|height| *height *= over);
        }
        let of = |ray: usize| match self.flank[ray] >= 0.0 && usual[ray] > 0.0 && height[ray].is_finite() {
            true => height[ray].clamp(usual[ray], HIGHEST * usual[ray]),
            false => usual[ray],
        };
        (0..height.len()).map(of).collect()
    }

    /// Of the samples of each calm ray: how many there are, sums of the bell and its square, of their values, and of bell times value.
    fn sums(&self, stand: &Standpoint) -> Vec<[f64; 5]> {
        let (windows, inverse) = (&self.windows, -0.5 / (self.noise.width * self.noise.width));
        let mut bells = vec![[f64::NAN; MOST_SAMPLES]; PHASES as usize + 1];
        let mut of = |ray: usize| {
            let mut sums = [0.0; 5];
            let bell = &mut bells[(windows.fraction[ray] * PHASES + PHASES / 2.0) as usize];
            if bell[0].is_nan() {
                (0..windows.count).for_each(|k| bell[k] = (inverse * (windows.offset(k) + windows.fraction[ray]).powi(2)).exp());
            }
            let missing = windows.patterns[windows.pattern[ray]].missing;
            for (k, value) in windows.of(ray).iter().enumerate().take(windows.count).filter(|(k, _)| missing >> k & 1 == 0) {
                let parts = [1.0, bell[k], bell[k] * bell[k], *value, bell[k] * value];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
            sums
        };
        (0..stand.calm.len()).map(|ray| if stand.calm[ray] { of(ray) } else { [0.0; 5] }).collect()
    }
}

/// What the `values` within `reach` of each often reach; beyond the ends of an open line they are as at its ends.
fn often(values: &[f64], reach: usize, closed: bool) -> Vec<f64> {
    let (count, far, rank) = (values.len() as i64, reach as i64, ((1.0 - OFTEN) * (2 * reach) as f64) as usize);
    let at = |near: i64| values[if closed { near.rem_euclid(count) } else { near.clamp(0, count - 1) } as usize];
    let about = |ray: i64| *(ray - far..=ray + far).map(at).collect::<Vec<f64>>().select_nth_unstable_by(rank, f64::total_cmp).1;
    (0..count).map(about).collect()
}

/// Sums of the `values` within `reach` of each.
fn near(values: &[[f64; 5]], reach: usize, closed: bool) -> Vec<[f64; 5]> {
    let about = |ray: usize| {
        let mut sums = [0.0; 5];
        for near in within(ray, reach, values.len(), closed) {
            sums.iter_mut().zip(values[near]).for_each(|(sum, value)| *sum += value);
        }
        sums
    };
    (0..values.len()).map(about).collect()
}

/// The rays within `reach` of a `ray` of `count`, round a closed ring.
fn within(ray: usize, reach: usize, count: usize, closed: bool) -> impl Iterator<Item = usize> {
    let (ray, reach, count) = (ray as i64, reach as i64, count as i64);
    (ray - reach..=ray + reach).filter(move |near| closed || (0..count).contains(near)).map(move |near| near.rem_euclid(count) as usize)
}

impl Windows {
    /// The same samples where the line is `height`, without those that are clipped.
    pub fn raised(&self, height: &[f64]) -> Windows {
        self.again(height, |_, missing| missing)
    }

    /// The same samples with those that are clipped, but without those up to `flank` from the standpoint.
    pub fn beyond(&self, height: &[f64], flank: &[f64]) -> Windows {
        self.again(height, |ray, missing| {
            let near = (0..self.count).filter(|&k| (self.offset(k) + self.fraction[ray]).abs() <= flank[ray]);
            near.fold(missing & !self.white_bits[ray], |missing, k| missing | 1 << k)
        })
    }

    /// The same samples where the line is `height`, without the `missing` ones of each ray.
    fn again(&self, height: &[f64], missing: impl Fn(usize, u32) -> u32) -> Windows {
        let mut again = self.clone();
        let before = again.forget_patterns();
        for (ray, height) in height.iter().enumerate() {
            let missing = missing(ray, before[self.pattern[ray]].missing);
            again.pattern[ray] = again.pattern_of(self.fraction[ray], *height, missing);
        }
        again
    }
}
