//! Entries of the fuzzing targets in `native/fuzz`: `detect_ring` and `detect_line` below Python.

use super::measure::Line;
use super::rays::Annulus;
use super::ring;
use super::sampling::{luma, Grey, Plane};
use super::settings::Estimator;
use super::vectors::Vectors;
use super::LUMA_BAND;

/// Pixels (h, w, bands) and the band looked at.
#[derive(Clone, Copy)]
pub struct Picture<'a, T> {
    pub data: &'a [T],
    pub width: usize,
    pub height: usize,
    pub bands: usize,
    pub band: usize,
}

/// Where the ring is expected: centre, inner and outer radius, and which of the rays along `direction` count.
#[derive(Clone, Copy)]
pub struct Region<'a> {
    pub centre: [f64; 2],
    pub radii: (f64, f64),
    pub direction: &'a [[f64; 2]],
    pub counted: &'a [bool],
}

/// All numbers of a line, row by row, and its status.
pub type Found = Result<(Vec<f64>, Vec<u8>), &'static str>;

impl<T: Grey> Picture<'_, T> {
    fn looked_at<R>(&self, vectors: bool, work: impl FnOnce(&Plane<T>) -> R) -> R {
        let (width, height, vectors) = (self.width, self.height, Vectors::detected(vectors));
        if self.band == LUMA_BAND {
            return work(&Plane { data: &luma(self.data), width, height, bands: 1, band: 0, vectors });
        }
        work(&Plane { data: self.data, width, height, bands: self.bands, band: self.band, vectors })
    }
}

fn numbers(line: Line) -> (Vec<f64>, Vec<u8>) {
    let noise = super::numbers(&line.noise);
    let noise = [noise.0, noise.1, noise.2, noise.3, noise.4, line.scale];
    ([line.u, line.v, line.u_position, line.height, line.correlation, noise.to_vec()].concat(), line.status)
}

/// None where the region is refused.
pub fn ring<T: Grey>(picture: Picture<T>, region: Region, estimator: u8, vectors: bool) -> Option<Found> {
    let annulus = Annulus {
        centre: region.centre,
        inner: region.radii.0,
        outer: region.radii.1,
        direction: region.direction,
        counted: region.counted,
    };
    let estimator = Estimator::numbered(estimator)?;
    if !annulus.is_sound() {
        return None;
    }
    Some(picture.looked_at(vectors, |plane| ring::measure(plane, annulus, estimator)).map(|(line, centre)| {
        let (mut found, status) = numbers(line);
        found.extend(centre);
        (found, status)
    }))
}

pub fn line<T: Grey>(picture: Picture<T>, estimator: u8, down: bool, vectors: bool) -> Option<Found> {
    let estimator = Estimator::numbered(estimator)?;
    Some(picture.looked_at(vectors, |plane| ring::measure_line(plane, estimator, down)).map(numbers))
}
