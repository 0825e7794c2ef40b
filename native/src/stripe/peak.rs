//! Peaks on one ray: where the slope fitted to a window of samples turns from rising to falling (see the Python module `_scan`).

use super::settings::Settings;
use super::trace::Trace;
use super::vectors::{vectorised, Vectors};
use std::array::from_fn;

const FULL_WIDTH: f64 = 2.354820045;
const SATURATED_SAMPLES: usize = 2;
const NOWHERE: usize = usize::MAX;

/// A peak that stands out (see the Python class `Standing`); `base` is the higher background of its two sides.
#[derive(Clone, Copy, Default)]
pub struct Standing {
    pub position: f64,
    pub fraction: f64,
    pub height: f64,
    pub background: f64,
    pub rise: f64,
    pub fall: f64,
    pub base: f64,
    pub saturated: bool,
}

impl Standing {
    /// Gaussian sigma from the full width at half height.
    pub fn width(&self) -> f64 {
        (self.fall - self.rise) / FULL_WIDTH
    }
}

/// Samples beyond a bright stretch that finding and refining its peaks may look at.
pub fn margin(settings: &Settings) -> usize {
    settings.reach().max(settings.half_fit()).max(settings.window / 2 + 3) + 1
}

/// Finds the peaks on many rays under the same settings.
pub struct Finder<'a> {
    settings: &'a Settings,
    /// Distances of a window's samples from its middle, the outermost pair first.
    lever: Vec<f64>,
    slope: Vec<f64>,
}

impl<'a> Finder<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        let half = (settings.window - 1) as f64 / 2.0;
        Finder { settings, lever: (0..settings.window / 2).map(|k| half - k as f64).collect(), slope: Vec::new() }
    }

    /// All peaks of the ray in `trace` that stand out, in order along the ray.
    pub fn standing(&mut self, trace: &Trace, mut found: impl FnMut(Standing)) {
        let window = self.settings.window;
        let windows = (trace.values().len() + 1).saturating_sub(window);
        let half = (window - 1) as f64 / 2.0;
        let values = trace.values();
        let mut next = 0;
        for (number, &(first, last)) in trace.stretches.iter().enumerate() {
            // a peak one sample beside the stretch still counts as lit; one window more on each side for rounding
            let from = first.saturating_sub(window / 2 + 2).max(next);
            let to = (last + 4).saturating_sub(window / 2).min(windows);
            if from + 1 >= to {
                continue;
            }
            self.slope.resize(to - from, 0.0);
            slopes(self.settings.vectors, &self.lever, &values[from..to + window - 1], &mut self.slope);
            for (start, pair) in (from..to).zip(self.slope.windows(2)) {
                let (before, after) = (pair[0], pair[1]);
                if (before > 0.0) & (after <= 0.0) {
                    let fraction = before / (before - after);
                    let position = start as f64 + half + fraction;
                    if lit(&trace.stretches[number..], position) {
                        describe(values, position, fraction, self.settings).map(&mut found);
                    }
                }
            }
            next = to - 1;
        }
    }
}

/// Fitted slope times a positive constant of every window of `samples`.
fn slopes(vectors: Vectors, lever: &[f64], samples: &[f64], slope: &mut [f64]) {
    vectorised!(vectors, slopes_of(lever: &[f64], samples: &[f64], slope: &mut [f64]))
}

#[inline(always)]
fn slopes_of(lever: &[f64], samples: &[f64], slope: &mut [f64]) {
    // the usual windows have their own copies of the loop, of known length
    match lever.len() {
        3 => slopes_by::<3>(lever, samples, slope),
        4 => slopes_by::<4>(lever, samples, slope),
        5 => slopes_by::<5>(lever, samples, slope),
        _ => slopes_by_any(lever, samples, slope),
    }
}

#[inline(always)]
fn slopes_by<const PAIRS: usize>(lever: &[f64], samples: &[f64], slope: &mut [f64]) {
    let Some(lever) = lever.first_chunk::<PAIRS>() else { return };
    let count = slope.len();
    let left: [&[f64]; PAIRS] = from_fn(|k| &samples[k..k + count]);
    let right: [&[f64]; PAIRS] = from_fn(|k| &samples[2 * PAIRS - 1 - k..2 * PAIRS - 1 - k + count]);
    for (i, slope) in slope.iter_mut().enumerate() {
        let mut sum = 0.0;
        for k in 0..PAIRS {
            sum += lever[k] * (right[k][i] - left[k][i]);
        }
        *slope = sum;
    }
}

#[inline(always)]
fn slopes_by_any(lever: &[f64], samples: &[f64], slope: &mut [f64]) {
    slope.fill(0.0);
    let last = 2 * lever.len() - 1;
    for (k, lever) in lever.iter().enumerate() {
        let (left, right) = (&samples[k..], &samples[last - k..]);
        for ((slope, left), right) in slope.iter_mut().zip(left).zip(right) {
            *slope += lever * (right - left);
        }
    }
}

/// Whether the sample at `position` or one beside it is bright; `stretches` from the first that may hold it.
fn lit(stretches: &[(usize, usize)], position: f64) -> bool {
    let middle = (position + 0.5) as usize;
    stretches.iter().take_while(|(first, _)| *first <= middle + 1).any(|(_, last)| middle <= last + 1)
}

/// One candidate described, or none where it does not stand out.
fn describe(y: &[f64], position: f64, fraction: f64, settings: &Settings) -> Option<Standing> {
    let (middle, whole) = ((position + 0.5) as usize, position as usize);
    let (low, high) = (middle.saturating_sub(settings.reach()), (middle + settings.reach()).min(y.len() - 1));
    let (left, right) = (least(&y[low..=middle]), least(&y[middle..=high]));
    let base = left.max(right);
    let top = y[whole] + (y[whole + 1] - y[whole]) * (position - whole as f64);
    let height = top - base;
    if !(height >= settings.prominence) || top < settings.threshold {
        return None;
    }
    let half = base + 0.5 * height;
    let (rise, fall) = edges(y, middle, half, low, high);
    let white = settings.saturated_from();
    let saturated = y[low..=high].iter().filter(|&&v| v >= white).count() >= SATURATED_SAMPLES;
    Some(Standing { position, fraction, height, background: 0.5 * (left + right), rise, fall, base, saturated })
}

fn least(values: &[f64]) -> f64 {
    // NaN compares false, so samples outside the picture do not count
    let smaller = |least: f64, v: f64| if v < least { v } else { least };
    let (fours, rest) = values.as_chunks::<4>();
    let sides = fours.iter().fold([f64::INFINITY; 4], |least, v| from_fn(|k| smaller(least[k], v[k])));
    rest.iter().chain(&sides).fold(f64::INFINITY, |least, &v| smaller(least, v))
}

/// Places where the line falls to `level` before and after `middle`, at most from `low` to `high`; the sample before where it leaves the
/// picture. All samples are looked at, because a loop that ends early is harder to foresee.
fn edges(y: &[f64], middle: usize, level: f64, low: usize, high: usize) -> (f64, f64) {
    let (mut rise, mut fall) = (NOWHERE, NOWHERE);
    for (k, &value) in (low..middle).zip(&y[low..middle]) {
        rise = if value >= level { rise } else { k };
    }
    for (k, &value) in (middle + 1..high + 1).zip(&y[middle + 1..=high]).rev() {
        fall = if value >= level { fall } else { k };
    }
    let share = |from: usize, to: usize| {
        let crossed = (y[from] - level) / (y[from] - y[to]);
        if y[to].is_finite() && y[from] >= level {
            crossed.max(0.0)
        } else {
            0.0
        }
    };
    let rise = if rise == NOWHERE { low as f64 } else { (rise + 1) as f64 - share(rise + 1, rise) };
    (rise, if fall == NOWHERE { high as f64 } else { (fall - 1) as f64 + share(fall - 1, fall) })
}
