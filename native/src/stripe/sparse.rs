//! A sparse sample of the search region, for a first idea of it (see `first_settings` of the Python module `_learn`).

use super::rays::{Ray, Rays, Track};
use super::row::brightest;
use super::sampling::{Grey, Plane};
use super::statistics::Histogram;
use super::walk::nearest;

/// Samples counted on a ray; on longer ones only every second, third, ... counts.
const COUNTED: usize = 256;

/// Brightness of the samples, its differences over two of them, and the brightest sample of each ray.
pub struct Sparse {
    pub values: Histogram,
    pub differences: Histogram,
    pub brightest: Vec<f64>,
    line: Vec<u32>,
}

impl Sparse {
    /// From every `stride`-th of the `rays`.
    pub fn of<T: Grey>(plane: &Plane<T>, rays: &Rays, stride: usize) -> Sparse {
        let (values, differences) = (Histogram::new(T::WHITE), Histogram::new(T::WHITE));
        let mut sparse = Sparse { values, differences, brightest: Vec::new(), line: Vec::new() };
        let (mut levels, pace) = (Vec::new(), (rays.samples / COUNTED).max(1));
        for track in rays.rays.iter().step_by(stride).map(Ray::track) {
            let (first, end) = track.inside(plane.width, plane.height, rays.samples);
            if first < end {
                let some = (first.next_multiple_of(pace), end, pace);
                let top = sparse.along(plane, &track, (first, some), &mut levels);
                sparse.brightest.push(f64::from(top));
            }
        }
        sparse
    }

    /// Adds every `pace`-th of the samples inside the picture on a track, from `begin` on; the brightest of all of them.
    fn along<T: Grey>(
        &mut self,
        plane: &Plane<T>,
        track: &Track,
        (first, some): (usize, (usize, usize, usize)),
        levels: &mut Vec<u32>,
    ) -> u32 {
        let count = some.1 - first;
        if let Some((pixels, pace)) = plane.aligned(track, first) {
            self.add(some, |k| pixels[(k - first) * pace].level());
            return match T::white_at_every(pace).filter(|_| pace == plane.bands) {
                Some(wanted) => brightest(plane.vectors, &pixels[..pixels.len().min(count * pace)], wanted).level(),
                None => pixels.iter().step_by(pace).take(count).map(|pixel| pixel.level()).max().unwrap_or(0),
            };
        }
        nearest(plane, (track.at(first), track.step), count, levels);
        self.add(some, |k| levels[k - first]);
        levels.iter().copied().max().unwrap_or(0)
    }

    fn add(&mut self, (begin, end, pace): (usize, usize, usize), level: impl Fn(usize) -> u32) {
        self.line.clear();
        self.line.extend((begin..end).step_by(pace).map(&level));
        self.values.add(&self.line);
        self.line.clear();
        self.line.extend((begin..end.saturating_sub(2)).step_by(pace).map(|k| level(k).abs_diff(level(k + 2))));
        self.differences.add(&self.line);
    }
}
