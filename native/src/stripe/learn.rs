//! Settings of a scan, learnt from the picture (see the Python module `_learn`).

use super::fit::{Batch, Fit};
use super::noise::{background_noise, pixel_noise, speckle, CONTRAST};
use super::peak::{margin, Finder, Standing};
use super::rays::{Ray, Rays};
use super::refine::{has_left, moved_place};
use super::sampling::{Grey, Plane, Trace};
use super::scan::{gate_of, Candidates};
use super::scatter::neighbour_scatter;
use super::settings::{Estimator, Noise, Settings, PUBLISHED_WINDOW};
use super::statistics::{floor, median, Histogram};

const PUBLISHED_THRESHOLD: f64 = 45.0;
const SPARSE: usize = 48;
const FLOOR_RANK: usize = 20;
const PROMINENT: f64 = 6.0;
const FAINTEST: f64 = 0.08;
const GATE: f64 = 0.6;
const FEWEST_TO_LEARN: usize = 24;
const NARROWEST_LINE: f64 = 0.6;
const WIDEST_LINE: f64 = 12.0;
const SMALLEST_WINDOW: f64 = 6.0;
const LARGEST_WINDOW: f64 = 32.0;
const FLOORS: [f64; 3] = [0.01, 0.07, 0.5];
const LOST: f64 = 0.05;
const RAISED: f64 = 0.03;
/// Width and grain before they are learnt.
const USUAL: f64 = 1.5;
const USUAL_GAIN: f64 = 0.05;

/// Settings for the first look, from a sparse sample of the search region; none where all of it is outside.
pub fn first_settings<T: Grey>(plane: &Plane<T>, rays: &Rays, estimator: Estimator) -> Option<Settings> {
    let (mut values, mut differences) = (Histogram::new(T::WHITE), Histogram::new(T::WHITE));
    let (mut brightest, mut line) = (Vec::new(), Vec::new());
    for ray in rays.rays.iter().step_by((rays.rays.len() / SPARSE).max(1)) {
        let track = ray.track();
        let (first, end) = track.inside(plane.width, plane.height, rays.samples);
        line.clear();
        line.extend((first..end).map(|sample| plane.data[plane.nearest_index(track.at(sample))].level()));
        line.iter().for_each(|&value| values.add(value));
        line.iter().zip(line.iter().skip(2)).for_each(|(a, b)| differences.add(a.abs_diff(*b)));
        brightest.extend(line.iter().max().map(|&value| f64::from(value)));
    }
    if brightest.is_empty() {
        return None;
    }
    let (floor, noise) = (values.ranked(FLOOR_RANK), background_noise(differences.ranked(2)));
    let level = (median(&mut brightest) - floor).max(0.0);
    let prominence = (PROMINENT * noise).max(FAINTEST * level);
    let white = f64::from(T::WHITE);
    let threshold = if estimator == Estimator::Parabola { PUBLISHED_THRESHOLD * white / 255.0 } else { 0.0 };
    let noise = Noise { additive: noise * noise, gain: USUAL_GAIN, contrast: CONTRAST, width: USUAL, grain: USUAL };
    Some(Settings { estimator, noise, gate: floor + GATE * prominence, prominence, threshold, white, window: PUBLISHED_WINDOW })
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
        return settings;
    }
    let width = median(&mut widths).clamp(NARROWEST_LINE, WIDEST_LINE);
    let (additive, gain) = pixel_noise(plane, &peaks);
    let noise = Noise { additive: additive.max(settings.noise.additive), gain, width, ..settings.noise };
    settings.noise = speckle(noise, &height, rays.spacing);
    if settings.estimator == Estimator::Parabola {
        return settings;
    }
    settings.window = (2.0 * (2.0 * width).round_ties_even()).clamp(SMALLEST_WINDOW, LARGEST_WINDOW) as usize;
    best_floor(plane, rays, found, settings)
}

/// `settings` with the additive noise under which neighbouring peaks agree best.
fn best_floor<T: Grey>(plane: &Plane<T>, rays: &Rays, found: &Candidates, settings: Settings) -> Settings {
    if settings.estimator != Estimator::ZeroCrossing {
        return settings;
    }
    let mut heights: Vec<f64> = found.highest().flatten().map(|peak| peak.height).collect();
    let height = median(&mut heights);
    let with_floor = |fraction: f64| {
        let additive = settings.noise.additive.max((fraction * height) * (fraction * height));
        Settings { noise: Noise { additive, ..settings.noise.clone() }, ..settings.clone() }
    };
    let trials = FLOORS.map(with_floor);
    let scatter_of = |place: &[f64]| neighbour_scatter(place, settings.noise.width, rays.spacing);
    let tried = places_under(plane, rays, found, &trials);
    let (mut floors, mut scatter) = (FLOORS, tried.each_ref().map(|(place, _)| scatter_of(place)));
    if tried[0].1 > LOST {
        let [(place, lost)] = places_under(plane, rays, found, &[with_floor(RAISED)]);
        (floors[0], scatter[0]) = (RAISED, if lost > LOST { f64::INFINITY } else { scatter_of(&place) });
    }
    let first = usize::from(scatter[0] == f64::INFINITY && floors[0] == RAISED);
    let best = (first..floors.len()).reduce(|best, k| if scatter[k] < scatter[best] { k } else { best }).unwrap_or(0);
    with_floor(floors[best])
}

/// Places of the highest peak near each ray's highest candidate under every one of the `trials`, which differ in additive noise only; and the
/// share of them that the step to the model's place has left.
fn places_under<T: Grey, const N: usize>(
    plane: &Plane<T>,
    rays: &Rays,
    found: &Candidates,
    trials: &[Settings; N],
) -> [(Vec<f64>, f64); N] {
    let (mut places, mut lost) = ([(); N].map(|()| vec![f64::NAN; rays.rays.len()]), [0usize; N]);
    let (mut fits, mut batch) = (trials.each_ref().map(Fit::new), Batch::new());
    let settings = &trials[0];
    let (gate, margin, reach) = (gate_of(settings), margin(settings), 2 * settings.reach() as i64);
    let (finder, mut trace) = (Finder::new(settings), Trace::new(rays.samples));
    let mut finish = |batch: &mut Batch| {
        for ((fit, places), lost) in fits.iter_mut().zip(&mut places).zip(&mut lost) {
            let moved = fit.step(batch);
            for lane in 0..batch.filled {
                places[batch.targets[lane]] = moved_place(&batch.peaks[lane], moved.0[lane]);
                *lost += usize::from(has_left(moved.0[lane]));
            }
        }
        batch.filled = 0;
    };
    for (index, (ray, highest)) in rays.rays.iter().zip(found.highest()).enumerate() {
        let Some(peak) = highest else { continue };
        let (middle, mut best): (i64, Option<Standing>) = (floor(peak.position), None);
        let end = ((middle + reach + 2).max(0) as usize).min(rays.samples);
        trace.read(plane, &ray.track(), ((middle - reach).max(0) as usize, end), gate, margin);
        finder.standing(&trace, |peak| best = best.filter(|b| b.height >= peak.height).or(Some(peak)));
        if best.is_some_and(|peak| batch.add(&trace.value, settings.half_fit(), &peak, index)) {
            finish(&mut batch);
        }
    }
    finish(&mut batch);
    let mut lost = lost.into_iter();
    places.map(|place| {
        let seen = place.iter().filter(|place| place.is_finite()).count().max(1);
        let share = lost.next().unwrap_or(0) as f64 / seen as f64;
        (place, share)
    })
}
