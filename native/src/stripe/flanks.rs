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
const SETTLED: f64 = 1e-3;
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
        let round = |flanks: &mut Flanks, stand: &mut Standpoint| {
            let before = flanks.noise.width;
            flanks.noise.width = breadth(&flanks.windows, stand, every, flanks.noise.clone()).width.clamp(width / MOST, width * MOST);
            stand.height = flanks.heights(stand, &usual, (reach, rays.closed));
            (flanks.noise.width - before).abs() <= SETTLED * before
        };
        (0..ROUNDS).any(|_| round(&mut flanks, stand));
        for _ in 0..if rays.closed { UNSMEARED } else { 0 } {
            let windows = windows.clone().unsmeared(rays, &hidden, &stand.height, flanks.noise.width);
            flanks.windows = windows.beyond(&usual, &flanks.flank);
            round(&mut flanks, stand);
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
            for (k, (value, bell)) in windows.of(ray).iter().zip(bell).enumerate().take(windows.count) {
                let known = f64::from(!missing >> k & 1);
                let (seen, value) = (known * *bell, known * value);
                for (sum, part) in sums.iter_mut().zip([known, seen, seen * seen, value, seen * value]) {
                    *sum += part;
                }
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
    let mut some = Vec::with_capacity(2 * reach + 1);
    let mut about = |ray: i64| {
        some.clear();
        some.extend((ray - far..=ray + far).map(at));
        // the usual ray has few clipped ones nearby
        match some.iter().filter(|value| **value >= 0.0).count() + rank > 2 * reach {
            true => *some.select_nth_unstable_by(rank, f64::total_cmp).1,
            false => -1.0,
        }
    };
    (0..count).map(&mut about).collect()
}

/// Sums of the `values` within `reach` of each.
fn near(values: &[[f64; 5]], reach: usize, closed: bool) -> Vec<[f64; 5]> {
    let (count, nothing) = (values.len(), [0.0; 5]);
    let beside = |side: &[[f64; 5]]| if closed { side.to_vec() } else { vec![nothing; reach] };
    let around = [beside(&values[count - reach..]), values.to_vec(), beside(&values[..reach])].concat();
    let mut until = vec![nothing];
    for value in around {
        let before = until[until.len() - 1];
        until.push(std::array::from_fn(|k| before[k] + value[k]));
    }
    until.iter().zip(&until[2 * reach + 1..]).map(|(before, until)| std::array::from_fn(|k| until[k] - before[k])).collect()
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
