//! Peaks on one ray: where the slope fitted to a window of samples turns from rising to falling (see the Python module `_scan`).

use super::sampling::Trace;
use super::settings::Settings;

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
}

impl<'a> Finder<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        let half = (settings.window - 1) as f64 / 2.0;
        Finder { settings, lever: (0..settings.window / 2).map(|k| half - k as f64).collect() }
    }

    /// All peaks of the ray in `trace` that stand out, in order along the ray.
    pub fn standing(&self, trace: &Trace, mut found: impl FnMut(Standing)) {
        let window = self.settings.window;
        let windows = (trace.value.len() + 1).saturating_sub(window);
        let half = (window - 1) as f64 / 2.0;
        let values = &trace.value[..];
        let mut next = 0;
        for (number, &(first, last)) in trace.stretches.iter().enumerate() {
            // a peak one sample beside the stretch still counts as lit; one window more on each side for rounding
            let from = first.saturating_sub(window / 2 + 2).max(next);
            let to = (last + 4).saturating_sub(window / 2).min(windows);
            if from + 1 >= to {
                continue;
            }
            let mut before = f64::NAN;
            for (start, samples) in (from..to).zip(values[from..].windows(window)) {
                let after = self.slope(samples);
                if (before > 0.0) & (after <= 0.0) {
                    let fraction = before / (before - after);
                    let position = (start - 1) as f64 + half + fraction;
                    if lit(&trace.stretches[number..], position) {
                        describe(values, position, fraction, self.settings).map(&mut found);
                    }
                }
                before = after;
            }
            next = to - 1;
        }
    }

    /// Fitted slope times a positive constant: the window's samples by their distance from its middle.
    #[inline(always)]
    fn slope(&self, window: &[f64]) -> f64 {
        let pairs = |levers: &[f64], samples: &[f64]| -> f64 {
            let sides = samples.iter().zip(samples.iter().rev());
            levers.iter().zip(sides).map(|(lever, (left, right))| lever * (right - left)).sum()
        };
        // the usual windows have their own copies of the loop, of known length
        match (&self.lever[..], window) {
            (levers @ [_, _, _], samples @ [_, _, _, _, _, _]) => pairs(levers, samples),
            (levers @ [_, _, _, _], samples @ [_, _, _, _, _, _, _, _]) => pairs(levers, samples),
            (levers, samples) => pairs(levers, samples),
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
    values.iter().fold(f64::INFINITY, |least, &v| if v < least { v } else { least })
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
