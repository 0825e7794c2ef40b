//! Candidates on every ray, highest first (see the Python module `_scan`).

use super::peak::{margin, Finder};
use super::rays::Rays;
use super::refine::Refiner;
use super::sampling::{Grey, Plane};
use super::settings::Settings;
use super::trace::Trace;

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
    /// Number of its samples among those that are kept.
    pub row: usize,
}

/// The candidates of all rays in one row.
pub struct Candidates {
    pub peaks: Vec<Peak>,
    /// Where each ray's candidates end.
    ends: Vec<usize>,
    /// Samples on each side of a peak that are kept, and those of all that were found.
    pub side: usize,
    pub kept: Vec<f64>,
    pub rows: usize,
}

impl Candidates {
    /// Of none of so many rays yet.
    fn new(rays: usize, side: usize) -> Self {
        let samples = if side > 0 { rays * (2 * side + 1) } else { 0 };
        Candidates { peaks: Vec::with_capacity(rays), ends: Vec::with_capacity(rays), side, kept: Vec::with_capacity(samples), rows: 0 }
    }

    pub fn of(&self, ray: usize) -> std::ops::Range<usize> {
        let first = if ray == 0 { 0 } else { self.ends[ray - 1] };
        first..self.ends[ray]
    }

    /// Adds one of a ray whose others are the last ones.
    #[inline(always)]
    pub fn add(&mut self, ray: usize, peak: Peak) {
        self.close(ray);
        self.peaks.push(peak);
    }

    /// The samples about a peak; none if they were not kept.
    pub fn samples(&self, peak: &Peak) -> &[f64] {
        let long = 2 * self.side + 1;
        self.kept.get(peak.row * long..(peak.row + 1) * long).unwrap_or(&[])
    }

    /// No more are to come of the rays before `ray`: of each the highest ones are kept, highest first.
    fn close(&mut self, ray: usize) {
        while self.ends.len() < ray {
            let first = self.ends.last().copied().unwrap_or(0);
            if self.peaks.len() > first + 1 {
                self.peaks[first..].sort_by(|a, b| b.height.total_cmp(&a.height));
                self.peaks.truncate(first + MOST_PEAKS);
            }
            self.ends.push(self.peaks.len());
        }
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

/// Candidates of every ray, looked for within its `span` of samples (first, end).
pub fn scan<T: Grey>(plane: &Plane<T>, rays: &Rays, settings: &Settings, span: impl Fn(usize) -> (usize, usize)) -> Candidates {
    let count = rays.rays.len();
    let (mut found, mut trace) = (Candidates::new(count, if settings.keeps { settings.side() } else { 0 }), Trace::new(rays.samples));
    let (mut finder, mut refiner) = (Finder::new(settings), Refiner::new(settings));
    let (gate, margin) = (gate_of(settings), margin(settings));
    for (index, ray) in rays.rays.iter().enumerate() {
        trace.read(plane, &ray.track(), span(index), gate, margin);
        finder.crossings(&trace, |position| refiner.add(trace.values(), position, index, &mut found));
    }
    refiner.finish(&mut found);
    found.close(count);
    found
}
