//! Settings of a scan, learnt from the picture (see the Python module `_learn`).

use super::noise::{background_noise, pixel_noise, speckle, CONTRAST, QUANTISATION};
use super::rays::{Ray, Rays};
use super::sampling::{Grey, Plane};
use super::scan::Candidates;
use super::settings::{Estimator, Noise, Settings, PUBLISHED_WINDOW};
use super::sparse::Sparse;
use super::statistics::median;

const PUBLISHED_THRESHOLD: f64 = 45.0;
pub const SPARSE: usize = 48;
const FLOOR_RANK: usize = 20;
const PROMINENT: f64 = 6.0;
const FAINTEST: f64 = 0.08;
const GATE: f64 = 0.6;
const FEWEST_TO_LEARN: usize = 24;
const NARROWEST_LINE: f64 = 0.6;
const WIDEST_LINE: f64 = 12.0;
const SMALLEST_WINDOW: f64 = 6.0;
pub const LARGEST_WINDOW: f64 = 32.0;
/// Width and grain before they are learnt.
const USUAL: f64 = 1.5;
const USUAL_GAIN: f64 = 0.05;

/// Settings for the first look, from a sparse sample of the search region; none where all of it is outside.
pub fn first_settings<T: Grey>(plane: &Plane<T>, rays: &Rays, estimator: Estimator) -> Option<Settings> {
    let mut sparse = Sparse::of(plane, rays, (rays.rays.len() / SPARSE).max(1));
    if sparse.brightest.is_empty() {
        return None;
    }
    let (floor, noise) = (sparse.values.ranked(FLOOR_RANK), background_noise(sparse.differences.ranked(2)));
    let level = (median(&mut sparse.brightest) - floor).max(0.0);
    let prominence = (PROMINENT * noise).max(FAINTEST * level);
    let white = f64::from(T::WHITE);
    let threshold = if estimator == Estimator::Parabola { PUBLISHED_THRESHOLD * white / 255.0 } else { 0.0 };
    let sensor = noise * noise;
    let noise = Noise { additive: sensor, gain: USUAL_GAIN, contrast: CONTRAST, width: USUAL, grain: USUAL };
    let (gate, vectors) = (floor + GATE * prominence, plane.vectors);
    Some(Settings { estimator, noise, gate, prominence, threshold, white, window: PUBLISHED_WINDOW, sensor, keeps: false, vectors })
}

/// `settings` with the noise model, line width and window learnt from `found` along `rays`.
pub fn learn_noise<T: Grey>(plane: &Plane<T>, rays: &Rays, found: &Candidates, mut settings: Settings) -> Settings {
    let (mut peaks, mut widths): (Vec<(Ray, [f64; 2])>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut height = Vec::with_capacity(rays.rays.len());
    for (ray, highest) in rays.rays.iter().zip(found.highest()) {
        let good = highest.filter(|peak| !peak.saturated);
        height.push(good.map_or(f64::NAN, |peak| peak.height));
        peaks.extend(good.map(|peak| (*ray, ray.at(peak.position))));
        widths.extend(good.map(|peak| peak.width));
    }
    if peaks.len() < FEWEST_TO_LEARN {
        let mut widths: Vec<f64> = found.highest().flatten().map(|peak| peak.width).collect();
        return if widths.len() < FEWEST_TO_LEARN { settings } else { broad(settings, median(&mut widths)) };
    }
    let middle = median(&mut widths);
    let width = middle.clamp(NARROWEST_LINE, WIDEST_LINE);
    let (additive, gain) = pixel_noise(plane, &peaks);
    let first = settings.noise.additive;
    let noise = Noise { additive: additive.max(first), gain, width, ..settings.noise };
    settings.sensor = if additive + gain > 0.0 { additive.max(QUANTISATION).min(first) } else { first };
    settings.noise = speckle(noise, &height, rays.spacing);
    broad(settings, middle)
}

/// `settings` for a line of that `width`.
fn broad(mut settings: Settings, width: f64) -> Settings {
    let width = width.clamp(NARROWEST_LINE, WIDEST_LINE);
    settings.noise.width = width;
    if settings.estimator == Estimator::Parabola {
        return settings;
    }
    settings.window = (2.0 * (2.0 * width).round_ties_even()).clamp(SMALLEST_WINDOW, LARGEST_WINDOW) as usize;
    settings
}
