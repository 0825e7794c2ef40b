//! Samples of all rays about the places they are looked at from (see the Python module `_windows`).

use std::collections::HashMap;

use super::plateau::bright_rays;
use super::rays::{Ray, Rays};
use super::sampling::{Grey, Plane};
use super::settings::Settings;
use super::settle::Found;
use super::statistics::floor;
use super::walk::GROUP;

/// Standpoints lie on this part of a pixel.
pub const PHASES: f64 = 8.0;
/// Windows are laid out by whole groups of samples: their sums are four at a time.
pub const FOUR: usize = 4;

/// What rays have in common that weight their samples alike: distance of the middle of the window from the standpoint, usual height of the
/// line, the missing samples, one bit each, and the line's width.
#[derive(Clone)]
pub struct Pattern {
    pub fraction: f64,
    pub height: f64,
    pub missing: u32,
    /// The line is wider than elsewhere by so many levels of `breadth`.
    pub level: i8,
}

const UNKNOWN: (i16, u32, usize) = (0, u32::MAX, 0);

#[derive(Clone)]
pub struct Windows {
    pub count: usize,
    /// Distance of neighbouring samples.
    pub apart: f64,
    /// Distance of the middle of each ray's window from its standpoint.
    pub fraction: Vec<f64>,
    pub patterns: Vec<Pattern>,
    /// Sample of each ray with which its window begins.
    pub first: Vec<i64>,
    /// Number of each ray's pattern.
    pub pattern: Vec<usize>,
    /// How wide the line of each ray is, none where it is as wide everywhere; and of the ray that is looked at.
    levels: Vec<i8>,
    level: i8,
    known: HashMap<(i16, i16, u32, i8), usize>,
    /// The pattern looked up before of every phase.
    last: [(i16, u32, usize); PHASES as usize + 1],
    /// By rows; 0 where they are missing, but for clipped ones.
    values: Vec<f64>,
    row: usize,
    /// Sample in the middle of each ray's window, and which are missing.
    taken: Vec<(i64, u32)>,
    samples: usize,
    /// How far from the standpoint the farthest clipped sample of each ray is; -1 where none is.
    pub clipped: Vec<f64>,
    /// Which are, one bit each.
    pub white_bits: Vec<u32>,
    /// Which rays may have clipped samples, none where no ray has; and from which brightness on they are.
    pub bright: Option<Vec<bool>>,
    pub white: f64,
    /// Memory for the samples of one ray at their places and a group behind them, and for those of its window.
    line: Vec<f64>,
    pub window: Vec<f64>,
}

/// `start` moved to the nearest place where rays may be looked at from.
pub fn standing(start: f64) -> f64 {
    if start.is_finite() {
        floor(start * PHASES + 0.5) as f64 / PHASES
    } else {
        f64::NAN
    }
}

impl Windows {
    /// Of the rays of `line`, none of which is looked at yet.
    pub fn new(rays: &Rays, line: &Found, settings: &Settings) -> Windows {
        let (group, number) = (settings.group(), rays.rays.len());
        let count = 2 * (settings.half_fit() / group) + 1;
        let row = count.next_multiple_of(FOUR);
        Windows {
            count,
            apart: group as f64,
            fraction: vec![0.0; number],
            patterns: Vec::new(),
            first: vec![0; number],
            pattern: vec![0; number],
            levels: Vec::new(),
            level: 0,
            known: HashMap::new(),
            last: [UNKNOWN; PHASES as usize + 1],
            values: vec![0.0; row * number],
            row,
            taken: vec![(i64::MIN, 0); number],
            samples: rays.samples,
            clipped: vec![-1.0; number],
            white_bits: vec![0; number],
            bright: bright_rays(line, settings, rays),
            white: settings.saturated_from(),
            line: vec![f64::NAN; rays.samples + GROUP],
            window: vec![f64::NAN; count * group],
        }
    }

    /// Looks at the rays of `line` that have a `start`, as if for the first time.
    pub fn about<T: Grey>(&mut self, plane: &Plane<T>, rays: &Rays, line: &Found, (start, height): (&[f64], &[f64]), side: i64) {
        self.forget_patterns();
        self.pattern.fill(0);
        (self.levels, self.level) = (Vec::new(), 0);
        for (number, ray) in rays.rays.iter().enumerate().filter(|(number, _)| start[*number].is_finite()) {
            let known = (floor(line.position[number] + 0.5) - side, line.samples[number]);
            self.look(plane, (ray, known), number, (start[number], height[number]));
        }
    }

    /// Takes the samples of a ray about `start`, where the line is `height`, from those `known` from a place on, else from the picture.
    pub fn look<T: Grey>(
        &mut self,
        plane: &Plane<T>,
        (ray, (first, known)): (&Ray, (i64, &[f64])),
        number: usize,
        (start, height): (f64, f64),
    ) {
        let middle = floor(start + 0.5);
        let low = middle - (self.window.len() / 2) as i64;
        // what is clipped counts by its distance from the standpoint
        if self.bright.is_some() || self.taken[number].0 != middle {
            let from = usize::try_from(low - first).ok().and_then(|from| known.get(from..from + self.window.len()));
            self.taken[number] = (middle, self.take(plane, ray, from, number, (low, start)));
        }
        (self.fraction[number], self.first[number]) = (middle as f64 - start, low);
        let missing = self.taken[number].1 | self.white_bits[number];
        self.pattern[number] = self.pattern_of(middle as f64 - start, height, missing);
    }

    /// Takes the samples of a ray from `low` on, if need be `from` the picture; which are missing, one bit each.
    fn take<T: Grey>(&mut self, plane: &Plane<T>, ray: &Ray, from: Option<&[f64]>, number: usize, (low, start): (i64, f64)) -> u32 {
        let long = self.window.len();
        match from {
            Some(samples) if long == self.count && !self.is_bright(number) => {
                return take(&mut self.values[number * self.row..][..long], samples)
            }
            Some(samples) => self.window.copy_from_slice(samples),
            None => self.read(plane, ray, low),
        }
        self.note_clipped(plane, ray, (low, start), number);
        self.grouped(number)
    }

    /// Tells the rays that have a `start` by `levels` of width as well, none where it does not differ.
    pub fn widened(&mut self, levels: &[i8], (start, height): (&[f64], &[f64])) {
        let mut rays: Vec<usize> = (0..levels.len()).filter(|&ray| start[ray].is_finite()).collect();
        // patterns of one width together
        rays.sort_by_key(|&ray| levels[ray]);
        let before = self.forget_patterns();
        self.levels = levels.to_vec();
        for ray in rays {
            let missing = before[self.pattern[ray]].missing;
            self.turn_to(ray);
            self.pattern[ray] = self.pattern_of(self.fraction[ray], height[ray], missing);
        }
    }

    /// The patterns until now, for which others are to come.
    pub fn forget_patterns(&mut self) -> Vec<Pattern> {
        self.known.clear();
        self.last = [UNKNOWN; PHASES as usize + 1];
        std::mem::take(&mut self.patterns)
    }

    /// Has the next patterns those of a line as wide as that of `ray`.
    pub fn turn_to(&mut self, ray: usize) {
        let level = self.levels.get(ray).copied().unwrap_or(0);
        if level != self.level {
            (self.level, self.last) = (level, [UNKNOWN; PHASES as usize + 1]);
        }
    }

    /// Reads the samples of the window from `low` on from the picture.
    fn read<T: Grey>(&mut self, plane: &Plane<T>, ray: &Ray, low: i64) {
        let track = ray.track();
        let (first, end) = track.inside(plane.width, plane.height, self.samples);
        let (from, to) = (low.max(first as i64), (low + self.window.len() as i64).min(end as i64));
        self.window.fill(f64::NAN);
        if from < to {
            let seen = from as usize..to as usize;
            plane.interpolate(&track, (seen.start, seen.end), &mut self.line);
            self.window[(from - low) as usize..(to - low) as usize].copy_from_slice(&self.line[seen]);
        }
    }

    /// Takes light away from a sample.
    pub fn darken(&mut self, ray: usize, sample: usize, light: f64) {
        self.values[ray * self.row + sample] -= light;
    }

    /// Notes the means of the groups of the window; which of them are missing, one bit each.
    fn grouped(&mut self, number: usize) -> u32 {
        let group = self.window.len() / self.count;
        for some in self.window.chunks_exact_mut(group) {
            some[0] = some.iter().sum::<f64>() / group as f64;
        }
        let mut means = [0.0; super::settings::MOST_SAMPLES];
        means.iter_mut().zip(self.window.iter().step_by(group)).for_each(|(mean, value)| *mean = *value);
        take(&mut self.values[number * self.row..][..self.count], &means[..self.count])
    }

    pub fn pattern_of(&mut self, fraction: f64, height: f64, missing: u32) -> usize {
        // the power of two nearest on a scale of logarithms: sqrt(2) times as high as one is nearer to the next
        let scaled = height.max(f64::MIN_POSITIVE) * std::f64::consts::SQRT_2;
        let (phase, level) = ((fraction * PHASES) as i16, ((scaled.to_bits() >> 52) & 0x7ff) as i16 - 1023);
        let last = &mut self.last[(phase + PHASES as i16 / 2) as usize];
        if (last.0, last.1) != (level, missing) {
            let (patterns, next, wide) = (&mut self.patterns, self.known.len(), self.level);
            let number = *self.known.entry((phase, level, missing, wide)).or_insert_with(|| {
                patterns.push(Pattern { fraction, height: f64::from(level).exp2(), missing, level: wide });
                next
            });
            *last = (level, missing, number);
        }
        last.2
    }

    /// Distance of a sample from the middle of its window.
    pub fn offset(&self, sample: usize) -> f64 {
        let middle = if self.apart as usize % 2 == 1 { 0.0 } else { -0.5 };
        (sample as f64 - (self.count / 2) as f64) * self.apart + middle
    }

    /// The samples of a ray, and zeros up to a whole group.
    #[inline(always)]
    pub fn of(&self, ray: usize) -> &[f64] {
        &self.values[ray * self.row..][..self.row]
    }
}

/// Copies `samples`, 0 where they are unknown; which, one bit each.
fn take(values: &mut [f64], samples: &[f64]) -> u32 {
    if !samples.iter().fold(false, |unknown, sample| unknown | sample.is_nan()) {
        values.copy_from_slice(samples);
        return 0;
    }
    let mut missing = 0;
    for (k, (value, &sample)) in values.iter_mut().zip(samples).enumerate() {
        let known = !sample.is_nan();
        *value = if known { sample } else { 0.0 };
        missing |= u32::from(!known) << k;
    }
    missing
}
