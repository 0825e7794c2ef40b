//! Where the neighbours of each ray say that the line is (see the Python module `_neighbours`).

use super::noise::NORMAL;
use super::pieces::{rays_of, smoothed, FEWEST, PIECES};
use super::settle::Found;
use super::statistics::median;

const FEWEST_BESIDE: usize = 4;
const LARGEST_PART: usize = 16;
const ASTRAY: f64 = 3.0;
/// Standard deviation of a normal distribution over its mean absolute deviation.
const MEAN: f64 = 1.2533;
/// Values added at the same time.
const TOGETHER: usize = 4;
const CALM: f64 = 0.75;

/// Where rays are looked at from (see the Python class `Standpoint`).
pub struct Standpoint {
    pub start: Vec<f64>,
    pub height: Vec<f64>,
    pub calm: Vec<bool>,
    /// Standard deviation of places about their neighbours.
    pub rough: f64,
}

/// From `position` and `height` of the peaks of rays `spacing` apart, NaN where there is none.
pub fn standpoints(
    (position, height): (&[f64], Option<Vec<f64>>),
    line: &Found,
    (within, spacing): (f64, f64),
    closed: bool,
) -> Standpoint {
    let reach = reach_of(position.len(), within, spacing);
    let near = Near { reach, closed };
    let seen: Vec<bool> = position.iter().map(|place| place.is_finite()).collect();
    let (guide, _) = near.line(position, &seen);
    let astray: Vec<f64> = position.iter().zip(&guide).map(|(place, guide)| (place - guide).abs()).collect();
    let mut known: Vec<f64> = astray.iter().copied().filter(|astray| !astray.is_nan()).collect();
    let rough = NORMAL * median(&mut known);
    let limit = limits(&astray, rough, closed);
    let straight: Vec<bool> = astray.iter().zip(&limit).map(|(astray, limit)| astray <= limit).collect();
    let (guide, count) = near.line(position, &straight);
    let enough = CALM * (2 * reach + 1) as f64;
    let calm: Vec<bool> =
        (0..position.len()).map(|ray| straight[ray] && (position[ray] - guide[ray]).abs() <= limit[ray] && count[ray] >= enough).collect();
    let start = (0..position.len()).map(|ray| if calm[ray] { guide[ray] } else { position[ray] }).collect();
    Standpoint { start, height: height.unwrap_or_else(|| near.mean(line.height, &seen)), calm, rough }
}

/// Neighbours on each side of a ray, of `count` rays `spacing` apart, that lie `within` of it.
pub fn reach_of(count: usize, within: f64, spacing: f64) -> usize {
    ((within / spacing).ceil() as usize).clamp(FEWEST_BESIDE, FEWEST_BESIDE.max(count / LARGEST_PART))
}

/// How far `astray` the places of straight line may be; all are `rough`, those of a piece may be rougher.
fn limits(astray: &[f64], rough: f64, closed: bool) -> Vec<f64> {
    let most = ASTRAY * rough;
    let clipped = |off: f64| if off < most { off } else { most };
    let told = |k: usize| {
        let here = &astray[rays_of(k, astray.len())];
        let unknown = here.iter().filter(|off| off.is_nan()).count();
        let (some, rest) = here.as_chunks::<TOGETHER>();
        let mut sums = [0.0; TOGETHER];
        some.iter().for_each(|some| (0..TOGETHER).for_each(|k| sums[k] += clipped(some[k])));
        let total = sums.iter().sum::<f64>() + rest.iter().map(|&off| clipped(off)).sum::<f64>() - most * unknown as f64;
        let count = (here.len() - unknown) as f64;
        if count >= FEWEST {
            MEAN * total / count
        } else {
            rough
        }
    };
    let here = smoothed(std::array::from_fn(told), closed);
    let mut limits = Vec::with_capacity(astray.len());
    (0..PIECES).for_each(|k| limits.resize(rays_of(k, astray.len()).end, ASTRAY * here[k].max(rough)));
    limits
}

/// The rays within `reach` of each.
struct Near {
    reach: usize,
    closed: bool,
}

/// Sums over the rays near one: how many there are, their distances from it, the squares of these, their values, and values by distances.
#[derive(Default, Clone, Copy)]
struct Sums {
    count: f64,
    turn: f64,
    square: f64,
    total: f64,
    leaning: f64,
}

impl Sums {
    /// With so many rays `lever` away and their value.
    #[inline(always)]
    fn with(&mut self, lever: f64, (count, value): (f64, f64)) {
        self.count += count;
        self.turn += count * lever;
        self.square += count * lever * lever;
        self.total += value;
        self.leaning += value * lever;
    }

    /// As seen from the next ray.
    fn stepped(&mut self) {
        self.square += self.count - 2.0 * self.turn;
        self.turn -= self.count;
        self.leaning -= self.total;
    }

    fn line(&self) -> f64 {
        let determinant = self.count * self.square - self.turn * self.turn;
        let above = self.square * self.total - self.turn * self.leaning;
        if determinant > 0.0 {
            above / determinant
        } else {
            f64::INFINITY
        }
    }
}

impl Near {
    /// What `tell` makes of the sums about each ray of those `values` that count.
    fn about<R>(&self, values: &[f64], counts: &[bool], first: f64, tell: impl Fn(&Sums) -> R) -> Vec<R> {
        let (rays, reach) = (values.len(), self.reach);
        let mut seen = vec![(0.0, 0.0); rays + 2 * reach];
        for (seen, (value, counts)) in seen[reach..].iter_mut().zip(values.iter().zip(counts)) {
            *seen = if *counts { (1.0, value - first) } else { (0.0, 0.0) };
        }
        if self.closed {
            seen.copy_within(rays..rays + reach, 0);
            seen.copy_within(reach..2 * reach, rays + reach);
        }
        let (mut sums, lever) = (Sums::default(), reach as f64);
        seen[..=2 * reach].iter().enumerate().for_each(|(k, seen)| sums.with(k as f64 - lever, *seen));
        let mut told = Vec::with_capacity(rays);
        told.push(tell(&sums));
        for (gone, come) in seen.iter().zip(&seen[2 * reach + 1..]) {
            sums.with(-lever, (-gone.0, -gone.1));
            sums.stepped();
            sums.with(lever, *come);
            told.push(tell(&sums));
        }
        told
    }

    /// Value at each ray of the straight line through those about it that count, infinite where there are too few; and how many count.
    fn line(&self, values: &[f64], counts: &[bool]) -> (Vec<f64>, Vec<f64>) {
        let first = values.iter().zip(counts).find(|(_, counts)| **counts).map_or(0.0, |(value, _)| *value);
        self.about(values, counts, first, |sums| (first + sums.line(), sums.count)).into_iter().unzip()
    }

    /// Mean about each ray of those that count; 0 where none does.
    fn mean(&self, values: &[f64], counts: &[bool]) -> Vec<f64> {
        self.about(values, counts, 0.0, |sums| if sums.count > 0.0 { sums.total / sums.count } else { 0.0 })
    }
}
