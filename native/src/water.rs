//! Told by the ring's shape: light that a water surface mirrors, or that glints on it. The twin of `calibore.profiling._water`, which
//! tells why.

mod chord;
mod curve;
mod image;

use crate::meeting::projecting::Projector;
use crate::rings::statistics::median;
use chord::Seen;
use curve::{walls, Sample};

const CLOSE: f64 = 0.03;
const MOST_RAYS: usize = 300;
const FEWEST_OF_WALL: usize = 40;

/// The rays of a line with their wall points; `found`: those that show something.
pub struct Ring<'a> {
    pub points: [&'a [f64]; 3],
    pub clock: &'a [f64],
    pub pixel: [&'a [f64]; 2],
    pub found: &'a [usize],
    /// Where the rays start, in the picture.
    pub centre: [f64; 2],
}

impl Ring<'_> {
    fn point(&self, i: usize) -> [f64; 3] {
        self.points.map(|row| row[i])
    }

    fn pixel(&self, i: usize) -> [f64; 2] {
        self.pixel.map(|row| row[i])
    }
}

/// Which of the `found` rays show what lies under a water surface, or a glint on it; none where the pipe is dry.
pub fn wet_rays(ring: &Ring, camera: &Projector) -> Vec<usize> {
    let (rays, found) = (ring.clock.len(), ring.found);
    let stride = (rays / MOST_RAYS).max(1);
    let some: Vec<usize> = found.iter().copied().step_by(stride).collect();
    let mut wet = vec![];
    if some.len() < FEWEST_OF_WALL {
        return wet;
    }
    let sample = Sample::of(some.iter().map(|&i| (ring.point(i), ring.clock[i])));
    let mut most = 0.0;
    for (glints, wall) in walls(&sample) {
        let seen = Seen::of(&sample, &wall, (rays as f64 / stride as f64, glints));
        if !seen.leaves_the_wall() {
            continue;
        }
        let pixel: Vec<[f64; 2]> = some.iter().map(|&i| ring.pixel(i)).collect();
        let mut distances: Vec<f64> = pixel.iter().map(|[u, v]| (u - ring.centre[0]).hypot(v - ring.centre[1])).collect();
        let Some((score, chord)) = seen.water(&pixel, median(&mut distances), camera) else { continue };
        if score > most {
            most = score;
            let close = CLOSE * wall.radius();
            let covers = |&i: &usize| {
                let depth = chord.below(ring.point(i));
                depth > 0.0 || (depth > -close && wall.off(ring.point(i), ring.clock[i]).abs() > close)
            };
            wet = found.iter().copied().filter(covers).collect();
        }
    }
    wet
}
