//! Peaks on one ray: where the slope fitted to a window of samples turns from rising to falling.

use super::refine::refine;
use super::sampling::Trace;
use super::{Peak, Settings};

const FULL_WIDTH: f64 = 2.354820045;
pub const SATURATED_FROM: f64 = 0.97;

/// All peaks of the ray in `trace`, in order along the ray.
pub fn peaks(trace: &Trace, settings: &Settings, found: &mut Vec<Peak>) {
    found.clear();
    let window = settings.window;
    let samples = trace.value.len();
    if samples <= window {
        return;
    }
    let half = (window - 1) as f64 / 2.0;
    let mut next = 0;
    for &(first, last) in &trace.stretches {
        let from = first.saturating_sub(window / 2 + 3).max(next);
        let to = (last + 3).saturating_sub(window / 2).min(samples - window - 1);
        let mut before = f64::NAN;
        for start in from..=to.max(from) {
            if start + window >= samples || start > to {
                break;
            }
            if before.is_nan() {
                before = slope(&trace.value[start..start + window], half);
            }
            let after = slope(&trace.value[start + 1..start + 1 + window], half);
            if before > 0.0 && after <= 0.0 {
                let fraction = before / (before - after);
                let position = start as f64 + half + fraction;
                if lit(trace, position) {
                    found.extend(describe(&trace.value, position, fraction, settings));
                }
            }
            before = after;
            next = start + 1;
        }
    }
}

fn slope(window: &[f64], half: f64) -> f64 {
    window.iter().enumerate().map(|(k, y)| (k as f64 - half) * y).sum()
}

fn lit(trace: &Trace, position: f64) -> bool {
    let middle = (position + 0.5) as usize;
    let last = trace.bright.len() - 1;
    trace.bright[middle] || trace.bright[middle.saturating_sub(1)] || trace.bright[(middle + 1).min(last)]
}

/// One candidate refined, or none where it does not stand out.
fn describe(y: &[f64], position: f64, fraction: f64, settings: &Settings) -> Option<Peak> {
    let (middle, whole) = ((position + 0.5) as usize, position as usize);
    let (low, high) = (middle.saturating_sub(settings.reach), (middle + settings.reach).min(y.len() - 1));
    let (left, right) = (least(&y[low..=middle]), least(&y[middle..=high]));
    let background = left.max(right);
    let top = y[whole] + (y[whole + 1] - y[whole]) * (position - whole as f64);
    let height = top - background;
    if !(height >= settings.prominence) || top < settings.threshold {
        return None;
    }
    let half = background + 0.5 * height;
    let rise = half_height(y, middle, half, low);
    let fall = half_height(y, middle, half, high);
    let white = SATURATED_FROM * settings.saturation;
    let saturated = y[low..=high].iter().filter(|&&v| v >= white).count() >= 2;
    let (place, u) = refine(y, position, fraction, height, 0.5 * (left + right), (rise, fall), settings)?;
    Some(Peak { position: place, height, background, width: (fall - rise) / FULL_WIDTH, u, saturated })
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::min)
}

/// Where the line falls to `level` on the way from `middle` to `end`; `end` itself where it does not.
fn half_height(y: &[f64], middle: usize, level: f64, end: usize) -> f64 {
    let step: isize = if end > middle { 1 } else { -1 };
    let mut k = middle;
    while k != end {
        let beyond = y[(k as isize + step) as usize];
        if beyond < level {
            let crossed = if y[k] >= level { ((y[k] - level) / (y[k] - beyond)).max(0.0) } else { 0.0 };
            return k as f64 + step as f64 * crossed;
        }
        if !beyond.is_finite() {
            return k as f64;
        }
        k = (k as isize + step) as usize;
    }
    end as f64
}
