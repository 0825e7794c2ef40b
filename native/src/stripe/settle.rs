//! A second look at the line that was chosen (see the Python module `_settle`).

use super::alone::alone;
use super::anchor::{anchor, Anchor};
use super::breadth::breadths;
use super::flanks::Flanks;
use super::generalised::functionals;
use super::neighbours::standpoints;
use super::plateau::{bright_rays, on_plateaus};
use super::rays::Rays;
use super::refine::LONGEST_STEP;
use super::sampling::{Grey, Plane};
use super::second::Second;
use super::settings::{Estimator, Noise, Settings};
use super::statistics::floor;
use super::windows::{standing, Windows};

const REACH: f64 = 6.0;
const NEAR: f64 = 3.0;
const FARTHEST: f64 = 1.5;
const ROUGH: f64 = 0.2;
const ENOUGH: usize = 375;

/// The line before (see the Python class `Found`); of its rays with a place the samples on each side of the peak.
pub struct Found<'a> {
    pub position: &'a mut [f64],
    pub u: &'a mut [f64],
    pub height: &'a [f64],
    pub base: &'a [f64],
    pub saturated: &'a [bool],
    pub samples: &'a [&'a [f64]],
}

/// `line` looked at again; the noise model that its places hold for.
pub fn settle<T: Grey>(plane: &Plane<T>, rays: &Rays, mut line: Found, settings: &Settings) -> Noise {
    if settings.estimator != Estimator::ZeroCrossing || !line.position.iter().any(|place| place.is_finite()) {
        return settings.noise.clone();
    }
    if bright_rays(&line, settings, rays).is_none() {
        return settled(plane, rays, line, settings);
    }
    let samples = on_plateaus(plane, rays, &mut line, settings);
    let samples: Vec<&[f64]> = samples.iter().map(|samples| &samples[..]).collect();
    settled(plane, rays, Found { samples: &samples, ..line }, settings)
}

fn settled<T: Grey>(plane: &Plane<T>, rays: &Rays, mut line: Found, settings: &Settings) -> Noise {
    let mut store = None;
    let mut first = look((plane, &mut store), rays, &line, line.position, settings, (REACH, None));
    if first.hidden.contains(&true) {
        // flanks tell much from places that are all a little off
        first = look((plane, &mut store), rays, &line, &first.better(&line), settings, (REACH, None));
    }
    // from better places they are better still
    let (known, told) = (first.better(&line), first.rough <= ROUGH * first.noise.width);
    let Look { place: settled, u, calm, hidden, noise, .. } =
        look((plane, &mut store), rays, &line, &known, settings, (NEAR, told.then_some(first)));
    let Anchor { aside, astray } = anchor(line.position, (&settled, &u), &calm, &hidden, (noise.width, rays.spacing));
    let left = Settings { noise: noise.clone(), ..settings.clone() };
    let stays = |ray: usize| settled[ray].is_nan();
    alone((plane, rays), &mut line, settings.side(), stays, &left);
    for ray in (0..settled.len()).filter(|&ray| !settled[ray].is_nan()) {
        let (place, off) = (settled[ray] + aside, line.position[ray] - settled[ray] - aside);
        (line.position[ray], line.u[ray]) =
            if off.abs() <= astray * u[ray] { (place, u[ray]) } else { (line.position[ray], u[ray].hypot(off)) };
    }
    noise
}

/// What one look from the places known so far has shown: places and uncertainties, NaN where the line was not found again.
struct Look {
    place: Vec<f64>,
    u: Vec<f64>,
    calm: Vec<bool>,
    /// Of which the top is clipped; none where none is.
    hidden: Vec<bool>,
    noise: Noise,
    rough: f64,
    height: Vec<f64>,
    response: f64,
    /// How wide the line of each ray is (see `breadth`).
    levels: Vec<i8>,
}

impl Look {
    /// Places that are better than those of `line` where they have been found.
    fn better(&self, line: &Found) -> Vec<f64> {
        self.place.iter().zip(line.position.iter()).map(|(a, b)| if a.is_nan() { *b } else { *a }).collect()
    }
}

/// The line looked at from where the neighbours of each ray say that it is, as far as places are `known`; what holds for all of it is as `before`,
/// or learnt; the windows of the look before are used again.
fn look<T: Grey>(
    (plane, store): (&Plane<T>, &mut Option<Windows>),
    rays: &Rays,
    line: &Found,
    known: &[f64],
    settings: &Settings,
    (reach, before): (f64, Option<Look>),
) -> Look {
    let mut hidden = Vec::new();
    let (told, height) = before
        .map(|before| {
            hidden = before.hidden;
            ((before.noise, before.response, before.levels), before.height)
        })
        .unzip();
    let width = told.as_ref().map_or(settings.noise.width, |(noise, ..)| noise.width);
    let mut stand = standpoints((known, height), line, (reach * width, rays.spacing), rays.closed);
    stand.start.iter_mut().for_each(|start| *start = standing(*start));
    let mut windows = store.take().unwrap_or_else(|| Windows::new(rays, line, settings));
    windows.about(plane, rays, line, (&stand.start, &stand.height), settings.side() as i64);
    let every = (known.len() / ENOUGH).max(1);
    let longest = LONGEST_STEP.max(FARTHEST * width);
    let (learnt, mut flanks) = (told.is_none(), None);
    if learnt && windows.bright.is_some() {
        let noise = Noise { additive: settings.sensor, ..settings.noise.clone() };
        let seen = flanks.insert(Flanks::of(&windows, &mut stand, rays, noise, (reach * width, every)));
        hidden = seen.hidden();
        windows = windows.raised(&stand.height).unsmeared(rays, &hidden, &stand.height, seen.noise.width);
    } else if let Some((noise, ..)) = &told {
        windows = windows.unsmeared(rays, &hidden, &stand.height, noise.width);
    }
    let (noise, response, levels) = told.unwrap_or_else(|| match &flanks {
        Some(seen) => (seen.noise.clone(), 1.0, seen.levels.clone()),
        None => {
            let noise = Noise { additive: settings.sensor, ..settings.noise.clone() };
            let (noise, levels) = breadths(&windows, &stand, every, noise, rays.closed);
            (noise, 1.0, levels)
        }
    });
    if !levels.is_empty() {
        let all = flanks.iter_mut().map(|seen| &mut seen.windows).chain([&mut windows]);
        all.for_each(|windows| windows.widened(&levels, (&stand.start, &stand.height)));
    }
    let second = Second { windows: &windows, stand: &stand, flanks: flanks.as_ref(), settings, every, longest };
    let (noise, response) = match learnt {
        true => {
            let noise = second.noise(rays, line.base, noise);
            let response = second.response(&noise);
            (noise, response)
        }
        false => (noise, response),
    };
    let mut found = functionals(&windows, &windows.patterns, &noise, 0.0, settings.vectors);
    let (mut moved, mut u) = second.steps(&found, &noise);
    for ray in second.misled(&moved, &u) {
        (stand.start[ray], stand.calm[ray]) = (standing(known[ray]), false);
        let samples = (floor(line.position[ray] + 0.5) - settings.side() as i64, line.samples[ray]);
        windows.turn_to(ray);
        windows.look(plane, (&rays.rays[ray], samples), ray, (stand.start[ray], stand.height[ray]));
        if rays.closed && hidden.get(ray) == Some(&true) {
            windows.unsmear(&rays.rays[ray], ray, (stand.height[ray], noise.width));
        }
        let new = &windows.patterns[found.len()..];
        found.extend(functionals(&windows, new, &noise, 0.0, settings.vectors));
        let (number, low) = (windows.pattern[ray], 1.0 / stand.height[ray]);
        moved[ray] = found[number].step(windows.of(ray), low);
        u[ray] = found[number].doubt(low, &windows.patterns[number], &noise);
    }
    let kept = |ray: usize| (moved[ray] / response).abs() <= longest;
    let place = |ray: usize| if kept(ray) { stand.start[ray] + moved[ray] / response } else { f64::NAN };
    let place = (0..moved.len()).map(place).collect();
    u.iter_mut().for_each(|u| *u /= response);
    *store = Some(windows);
    Look { place, u, calm: stand.calm, hidden, noise, rough: stand.rough, height: stand.height, response, levels }
}
