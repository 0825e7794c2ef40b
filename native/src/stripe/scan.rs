//! Candidates on every ray, highest first (see the Python module `_scan`).

use super::peak::{margin, Finder, Standing};
use super::rays::Rays;
use super::refine::Refiner;
use super::sampling::{Grey, Plane};
use super::settings::Settings;
use super::trace::{Look, Trace};

/// Candidates kept per ray.
const MOST_PEAKS: usize = 4;

/// One candidate (see the Python class `Peaks`).
#[derive(Clone, Copy)]
pub struct Peak {
    pub position: f64,
    pub height: f64,
    pub background: f64,
    pub width: f64,
    pub u: f64,
    pub saturated: bool,
}

/// The candidates of all rays in one row.
pub struct Candidates {
    pub peaks: Vec<Peak>,
    /// Where each ray's candidates end.
    ends: Vec<usize>,
}

impl Candidates {
    pub fn of(&self, ray: usize) -> std::ops::Range<usize> {
        let first = if ray == 0 { 0 } else { self.ends[ray - 1] };
        first..self.ends[ray]
    }

    pub fn rays(&self) -> usize {
        self.ends.len()
    }

    /// The highest candidate of every ray.
    pub fn highest(&self) -> impl Iterator<Item = Option<&Peak>> {
        (0..self.rays()).map(|ray| self.peaks[self.of(ray)].first())
    }
}

/// Brightness from which a nearest pixel passes the gate.
pub fn gate_of(settings: &Settings) -> u32 {
    settings.gate.ceil() as u32
}

/// Candidates of every ray, looked for where `look` says.
pub fn scan<'a, T: Grey>(plane: &Plane<T>, rays: &Rays, settings: &Settings, look: impl Fn(usize) -> Look<'a>) -> Candidates {
    let count = rays.rays.len();
    let (mut peaks, mut ends) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut trace, mut found) = (Trace::new(rays.samples), Vec::with_capacity(16));
    let (mut finder, mut refiner) = (Finder::new(settings), Refiner::new(settings));
    let (gate, margin) = (gate_of(settings), margin(settings));
    for (index, ray) in rays.rays.iter().enumerate() {
        found.clear();
        trace.read(plane, &ray.track(), look(index), gate, margin);
        finder.standing(&trace, |peak| found.extend(refiner.place(trace.values(), &peak).map(|place| (peak, place))));
        if found.len() > 1 {
            found.sort_by(|(a, _): &(Standing, f64), (b, _)| b.height.total_cmp(&a.height));
            found.truncate(MOST_PEAKS);
        }
        for (peak, position) in &found {
            let (height, background, width) = (peak.height, peak.base, peak.width());
            peaks.push(Peak { position: *position, height, background, width, u: 0.0, saturated: peak.saturated });
            refiner.add(trace.values(), peak, peaks.len() - 1, &mut peaks);
        }
        ends.push(peaks.len());
    }
    refiner.finish(&mut peaks);
    Candidates { peaks, ends }
}
