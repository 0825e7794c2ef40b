//! A closed line in an image: find it, centre the rays on it, measure it (see the Python module `_twin`).

use super::centre::ring_centre;
use super::choice::RESOLVED;
use super::guide::{guided_spans, COARSE, LEAST_MARGIN};
use super::learn::{first_settings, learn_noise, SPARSE};
use super::measure::{Line, Sight};
use super::rays::{Annulus, Rays};
use super::sampling::{Grey, Plane};
use super::scan::{scan, Candidates};
use super::settings::{Estimator, Settings};

const SETTLED: f64 = 0.5;
const MOST_RECENTRINGS: usize = 8;
const FEWEST_TO_CENTRE: usize = 8;
const UNCLEAR: f64 = 0.5;
const LEARNT: usize = 192;

const OUTSIDE: &str = "The region where the ring is expected lies outside the image.";
const NOTHING: &str = "There is no laser ring in the image: nothing stands out from its background.";
const UNCONNECTED: &str = "There is no laser ring in the image: too few connected peaks to find its centre.";
const NO_CIRCLE: &str = "There is no laser ring in the image: its peaks lie on no circle.";

/// The ring and the centre its rays start from, or a sentence why there is none.
pub fn measure<T: Grey>(plane: &Plane<T>, mut ring: Annulus, estimator: Estimator) -> Result<(Line, [f64; 2]), &'static str> {
    sweep(plane, &ring);
    let (settings, approach) = approach(plane, &mut ring, estimator)?;
    let mut recentrings = 0;
    loop {
        let (rays, spans) = (ring.every(1), approach.spans(ring.centre));
        let sight = Sight::along(plane, &rays, &settings.choosing(), |ray| spans[ray / COARSE]);
        let centre = centre_of(&rays, &sight, ring.counted)?;
        recentrings += 1;
        if distance(centre, ring.centre) < SETTLED || recentrings == MOST_RECENTRINGS {
            return Ok((sight.line(plane, &rays, settings), ring.centre));
        }
        ring.centre = centre;
    }
}

/// What the last coarse scan has found, and from where.
struct Approach {
    found: Candidates,
    centre: [f64; 2],
    samples: usize,
    spacing: f64,
}

impl Approach {
    /// Where to look for peaks on the rays from `centre`.
    fn spans(&self, centre: [f64; 2]) -> Vec<(usize, usize)> {
        guided_spans(&self.found, self.samples, self.spacing, distance(centre, self.centre))
    }
}

/// Coarse scans: learns the settings, and moves the centre of `ring` until it is near enough for the last one to guide.
fn approach<T: Grey>(plane: &Plane<T>, ring: &mut Annulus, estimator: Estimator) -> Result<(Settings, Approach), &'static str> {
    let mut settings = first_settings(plane, &ring.every((ring.direction.len() / SPARSE).max(1)), estimator).ok_or(OUTSIDE)?;
    if settings.prominence >= UNCLEAR * settings.white {
        return Err(NOTHING);
    }
    let mut recentrings = 0;
    loop {
        let rays = ring.every(COARSE);
        let found = scan(plane, &rays, &settings.plain(), |_| (0, rays.samples));
        if found.peaks.is_empty() {
            return Err(NOTHING);
        }
        if recentrings == 0 {
            settings = learn_noise(plane, &rays, &found, settings);
        }
        let sight = Sight::among(plane, &rays, found, settings.noise.width);
        let from = std::mem::replace(&mut ring.centre, centre_of(&rays, &sight, ring.counted)?);
        recentrings += 1;
        if distance(from, ring.centre) <= LEAST_MARGIN || recentrings == MOST_RECENTRINGS {
            return Ok((settings, Approach { found: sight.candidates, centre: from, samples: rays.samples, spacing: rays.spacing }));
        }
    }
}

/// The line that crosses the picture from left to right, or runs `down` it.
pub fn measure_line<T: Grey>(plane: &Plane<T>, estimator: Estimator, down: bool) -> Result<Line, &'static str> {
    let rays = if down { Rays::rows(plane.width, plane.height) } else { Rays::columns(plane.width, plane.height) };
    let settings = first_settings(plane, &rays, estimator).ok_or(OUTSIDE)?;
    let stride = (rays.rays.len() / LEARNT).clamp(1, COARSE);
    let few = rays.every(stride);
    let found = scan(plane, &few, &settings.plain(), |_| (0, few.samples));
    let settings = learn_noise(plane, &few, &found, settings);
    let spans = guided_spans(&found, few.samples, few.spacing, 0.0);
    Ok(Sight::along(plane, &rays, &settings.choosing(), |ray| spans[ray / stride]).line(plane, &rays, settings))
}

/// Centre of the line in sight, by the rays that are `counted` (one for each ray of the dense set).
fn centre_of(rays: &Rays, sight: &Sight, counted: &[bool]) -> Result<[f64; 2], &'static str> {
    let (mut points, mut index) = (Vec::with_capacity(rays.rays.len()), Vec::with_capacity(rays.rays.len()));
    let counted = counted.iter().step_by(rays.stride);
    for (i, ((ray, chosen), counted)) in rays.rays.iter().zip(&sight.chosen).zip(counted).enumerate() {
        if *counted && chosen.status <= RESOLVED {
            points.push(ray.at(sight.candidates.peaks[chosen.pick].position));
            index.push(i);
        }
    }
    if points.len() < FEWEST_TO_CENTRE {
        return Err(UNCONNECTED);
    }
    ring_centre(&points, &index, rays.rays.len()).ok_or(NO_CIRCLE)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Has all rows of the annulus fetched: rays cross the rows, and a picture that is not in the processor's cache comes into it several times
/// faster in the order in which it lies in memory.
fn sweep<T: Grey>(plane: &Plane<T>, ring: &Annulus) {
    const CACHE_LINE: usize = 64;
    let half = |radius: f64, row: f64| (radius * radius - row * row).max(0.0).sqrt();
    let [column, middle] = ring.centre;
    let within = |place: f64, end: usize| place.clamp(0.0, end as f64) as usize;
    for row in within(middle - ring.outer, plane.height)..within(middle + ring.outer, plane.height) {
        let across = row as f64 - middle;
        let (outer, inner) = (half(ring.outer, across), half(ring.inner, across));
        for (from, to) in [(column - outer, column - inner), (column + inner, column + outer)] {
            let (from, to) = (plane.index(within(from, plane.width), row), plane.index(within(to, plane.width), row));
            plane.data.get(from..to).unwrap_or(&[]).iter().step_by(CACHE_LINE / size_of::<T>()).for_each(fetch);
        }
    }
}

/// Asks for a value to be brought near, and does not wait for it.
#[inline(always)]
fn fetch<T: Grey>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch reads nothing and writes nothing, and every x86-64 processor has it
    unsafe {
        std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T1 }>(std::ptr::from_ref(value).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    std::hint::black_box(value.level());
}
