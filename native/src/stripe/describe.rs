//! How high and wide peaks stand over what is beside them, several at once (see the Python module `_scan`).

use super::batch::{Batch, Shape};
use super::lanes::Lanes;
use super::settings::Settings;
use super::vectors::vectorised;

const SATURATED_SAMPLES: f64 = 2.0;

/// Fills in the shape of all peaks of `batch`.
pub fn describe(batch: &mut Batch, settings: &Settings) {
    vectorised!(settings.vectors, described(batch: &mut Batch, settings: &Settings))
}

#[inline(always)]
fn described(batch: &mut Batch, settings: &Settings) {
    let reach = settings.reach();
    let window = batch.about(reach);
    // NaN compares false, so samples outside the picture do not count
    let least = |samples: &[Lanes]| samples.iter().fold(Lanes::all(f64::INFINITY), |least, sample| least.least(*sample));
    let (left, right) = (least(&window[..=reach]), least(&window[reach..]));
    let base = left.at_least(right, left, right);
    let height = batch.top - base;
    let level = base + Lanes::all(0.5) * height;
    let (rise, before) = edge(level, reach, |step| window[reach - step]);
    let (fall, after) = edge(level, reach, |step| window[reach + step]);
    let (white, one) = (Lanes::all(settings.saturated_from()), Lanes::all(1.0));
    let saturated = window.iter().fold(Lanes::ZERO, |count, sample| count + sample.at_least(white, one, Lanes::ZERO));
    let (top, prominence, threshold) = (batch.top, settings.prominence, settings.threshold);
    batch.shape = Shape {
        height,
        background: Lanes::all(0.5) * (left + right),
        base,
        rise: batch.middle - rise - before,
        fall: batch.middle + fall + after,
        stands: std::array::from_fn(|k| height.0[k] >= prominence && !(top.0[k] < threshold)),
        saturated: saturated.0.map(|count| count >= SATURATED_SAMPLES),
    };
}

/// How far from the middle the line falls to `level` on one side, in whole steps before it and the rest; `reach` where it does not, and
/// the last sample where it leaves the picture. All samples are looked at, because a loop that ends early is harder to foresee.
#[inline(always)]
fn edge(level: Lanes, reach: usize, sample: impl Fn(usize) -> Lanes) -> (Lanes, Lanes) {
    let (mut steps, mut inner, mut outer) = (Lanes::all(reach as f64), Lanes::ZERO, Lanes::all(f64::NAN));
    for step in (0..reach).rev() {
        let (here, beyond) = (sample(step), sample(step + 1));
        steps = beyond.at_least(level, steps, Lanes::all(step as f64));
        inner = beyond.at_least(level, inner, here);
        outer = beyond.at_least(level, outer, beyond);
    }
    let crossed = (inner - level) / (inner - outer);
    let rest = Lanes(std::array::from_fn(|k| if outer.0[k].is_finite() && inner.0[k] >= level.0[k] { crossed.0[k].max(0.0) } else { 0.0 }));
    (steps, rest)
}
