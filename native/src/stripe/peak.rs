//! Peaks on one ray: where the slope fitted to a window of samples turns from rising to falling (see the Python module `_scan`).

use super::settings::Settings;
use super::trace::Trace;
use super::vectors::{vectorised, Vectors};
use std::array::from_fn;

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

    /// Where on the ray in `trace` the slope turns and it is bright, in order along the ray, and the part of it between two windows.
    #[inline(always)]
    pub fn crossings(&mut self, trace: &Trace, mut found: impl FnMut((f64, f64))) {
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
                        found((position, fraction));
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
