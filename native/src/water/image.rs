//! Where a picture would show the mirror image, by its distance from its middle: it goes round that once.

use std::f64::consts::TAU;

use super::CLOSE;
use crate::rings::statistics::turned;

/// Azimuth, which rises, and distance of its points from the middle.
pub struct Image {
    middle: [f64; 2],
    places: Vec<(f64, f64)>,
}

impl Image {
    pub fn of(pixels: impl Iterator<Item = [f64; 2]>) -> Self {
        let pixels: Vec<[f64; 2]> = pixels.filter(|[u, _]| u.is_finite()).collect();
        let count = pixels.len() as f64;
        let middle = [0, 1].map(|k| pixels.iter().map(|pixel| pixel[k]).sum::<f64>() / count);
        let mut places: Vec<(f64, f64)> = pixels.into_iter().map(|pixel| polar(pixel, middle)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        Image { middle, places }
    }

    /// Whether a pixel lies on it, within a share of `size`.
    pub fn shows(&self, pixel: [f64; 2], size: f64) -> bool {
        let (Some(&first), Some(&last)) = (self.places.first(), self.places.last()) else { return false };
        let (at, own) = polar(pixel, self.middle);
        let after = self.places.partition_point(|place| place.0 <= at);
        let before = if after > 0 { self.places[after - 1] } else { (last.0 - TAU, last.1) };
        let after = self.places.get(after).copied().unwrap_or((first.0 + TAU, first.1));
        let width = after.0 - before.0;
        let share = if width > 0.0 { (at - before.0) / width } else { 0.0 };
        (own - (before.1 + (after.1 - before.1) * share)).abs() < CLOSE * size
    }
}

/// Azimuth in [0, 2 pi) and distance.
fn polar([u, v]: [f64; 2], [column, row]: [f64; 2]) -> (f64, f64) {
    let (across, down) = (u - column, v - row);
    (turned(down.atan2(across), TAU), across.hypot(down))
}
