//! What one look at all rays says, of each and of the whole line (see the Python module `_settle`).

use super::across::speckle_across;
use super::flanks::Flanks;
use super::generalised::{functionals_of, Functional};
use super::neighbours::Standpoint;
use super::rays::Rays;
use super::scatter::neighbour_scatter;
use super::settings::{Noise, Settings};
use super::statistics::median;
use super::vectors::{vectorised, Vectors};
use super::windows::Windows;

const FLOORS: [f64; 4] = [0.0014, 0.01, 0.07, 0.5];
const WORTH: f64 = 0.97;
const LOST: f64 = 0.05;
const MISLED: f64 = 4.0;
const SHIFT: f64 = 0.2;
const FEWEST_ASIDE: usize = 24;
const GREATEST_PART: f64 = 4.0;
const MOST_RESPONSE: f64 = 2.0;

/// The second look at all rays.
pub struct Second<'a> {
    pub windows: &'a Windows,
    pub stand: &'a Standpoint,
    /// Where the line is clipped.
    pub flanks: Option<&'a Flanks>,
    pub settings: &'a Settings,
    /// What holds for the whole picture is learnt from one ray in so many.
    pub every: usize,
    pub longest: f64,
}

impl Second<'_> {
    /// The rays on which the line is not where their neighbours say.
    pub fn misled(&self, moved: &[f64], u: &[f64]) -> Vec<usize> {
        (0..moved.len()).filter(|&ray| self.stand.calm[ray] && !(moved[ray].abs() <= MISLED * u[ray])).collect()
    }

    /// `noise` with contrast, grain and floor of the line, learnt from the line itself.
    pub fn noise(&self, rays: &Rays, base: &[f64], noise: Noise) -> Noise {
        let (windows, flank) = self.flanks.map_or((self.windows, None), |seen| (&seen.windows, Some(&seen.flank[..])));
        self.best_floor(rays, speckle_across(windows, self.stand, (base, flank, self.every), noise))
    }

    /// `noise` with the additive noise under which neighbours agree best.
    fn best_floor(&self, rays: &Rays, noise: Noise) -> Noise {
        let few = || (0..self.stand.start.len()).step_by(self.every);
        let mut heights: Vec<f64> = few().filter(|&ray| self.stand.start[ray].is_finite()).map(|ray| self.stand.height[ray]).collect();
        let (known, height) = (heights.len(), median(&mut heights));
        let mut best: Option<(f64, Noise)> = None;
        for fraction in FLOORS {
            let tried = Noise { additive: noise.additive.max((fraction * height) * (fraction * height)), ..noise.clone() };
            let moved = self.moved(&tried, 0.0);
            let place = |(ray, moved): (usize, &f64)| if moved.abs() <= self.longest { self.stand.start[ray] + moved } else { f64::NAN };
            let place: Vec<f64> = few().zip(&moved).map(place).collect();
            let seen = place.iter().filter(|place| place.is_finite()).count();
            let scatter = match (known - seen) as f64 <= LOST * known as f64 {
                true => neighbour_scatter(&place, noise.width, rays.spacing * self.every as f64, self.settings.vectors),
                false => f64::INFINITY,
            };
            if best.as_ref().is_none_or(|(least, _)| scatter < WORTH * *least || least.is_infinite()) {
                best = Some((scatter, tried));
            }
        }
        best.map_or(noise, |(_, noise)| noise)
    }

    /// How far the place found moves per pixel that the line moves, seen from the same standpoint.
    pub fn response(&self, noise: &Noise) -> f64 {
        let shift = SHIFT * noise.width;
        let (after, before) = (self.moved(noise, shift), self.moved(noise, -shift));
        let calm = self.stand.calm.iter().step_by(self.every);
        let per_pixel = after.iter().zip(&before).zip(calm).filter(|(_, calm)| **calm).map(|((after, before), _)| after - before);
        let known: Vec<f64> = per_pixel.map(|moved| moved / (2.0 * shift)).filter(|value| value.is_finite()).collect();
        if known.len() < FEWEST_ASIDE {
            return 1.0;
        }
        let mean = known.iter().map(|value| value.clamp(-GREATEST_PART, GREATEST_PART)).sum::<f64>() / known.len() as f64;
        mean.clamp(1.0 / MOST_RESPONSE, MOST_RESPONSE)
    }

    /// Steps of one ray in `every`, looked at from `aside` of its standpoint.
    fn moved(&self, noise: &Noise, aside: f64) -> Vec<f64> {
        let few = (0..self.stand.start.len()).step_by(self.every);
        let found = functionals_of(self.windows, few, (noise, aside), self.settings.vectors);
        moved(self.settings.vectors, self, &found, self.every)
    }

    /// Step and uncertainty of every ray; NaN where the samples fix no place or there are none.
    pub fn steps(&self, found: &[Functional], noise: &Noise) -> (Vec<f64>, Vec<f64>) {
        let doubt = |(ray, height): (usize, &f64)| {
            let number = self.windows.pattern[ray];
            found[number].doubt(1.0 / height, &self.windows.patterns[number], noise)
        };
        (moved(self.settings.vectors, self, found, 1), self.stand.height.iter().enumerate().map(doubt).collect())
    }
}

fn moved(vectors: Vectors, second: &Second, found: &[Functional], every: usize) -> Vec<f64> {
    vectorised!(vectors, moved_of(second: &Second<'_>, found: &[Functional], every: usize) -> Vec<f64>)
}

#[inline(always)]
fn moved_of(second: &Second<'_>, found: &[Functional], every: usize) -> Vec<f64> {
    let (windows, stand) = (second.windows, second.stand);
    let step = |ray: usize| match stand.start[ray].is_finite() && stand.height[ray] > 0.0 {
        true => found[windows.pattern[ray]].step(windows.of(ray), 1.0 / stand.height[ray]),
        false => f64::NAN,
    };
    (0..stand.start.len()).step_by(every).map(step).collect()
}
