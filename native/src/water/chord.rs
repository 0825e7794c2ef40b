//! Level chords that may be water, and what speaks for each.

use std::f64::consts::{PI, TAU};

use super::curve::{Curve, Sample, OFF};
use super::image::Image;
use crate::meeting::projecting::Projector;
use crate::rings::statistics::turned;

const LEVEL: f64 = 0.015;
const LOOSE: f64 = 2.0;
const BINS: usize = 360;
const STEEPEST: f64 = 25.0 * PI / 180.0;
const NARROWEST: f64 = 24.0 * PI / 180.0;
const MOST_MIRRORED: usize = 60;
const FEWEST: f64 = 0.012;
const DENSE: f64 = 0.6;
const MOST_WALL: f64 = 0.25;
const TURNS: [f64; 7] = [-12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0];
const FINE_TURNS: [f64; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];
const FINE_RAISES: [f64; 5] = [-0.02, -0.01, 0.0, 0.01, 0.02];
const RAISES: usize = 19;

/// Water below x . (sin turn, cos turn) = `depth`.
#[derive(Clone, Copy)]
pub struct Chord {
    turn: f64,
    depth: f64,
    normal: [f64; 2],
}

impl Chord {
    fn at(turn: f64, depth: f64) -> Self {
        let (sine, cosine) = turn.sin_cos();
        Chord { turn, depth, normal: [sine, cosine] }
    }

    /// How far a point lies under it.
    pub fn below(&self, [x, y, _]: [f64; 3]) -> f64 {
        x * self.normal[0] + y * self.normal[1] - self.depth
    }

    fn mirrored(&self, [x, y, z]: [f64; 3], depth: f64) -> [f64; 3] {
        [x - 2.0 * depth * self.normal[0], y - 2.0 * depth * self.normal[1], z]
    }
}

/// Some points of the ring and which of them lie `off` the wall of `radius`; on how many `rays` they were looked for; whether `glints`
/// count.
pub struct Seen<'a> {
    sample: &'a Sample,
    off: Vec<bool>,
    radius: f64,
    rays: f64,
    glints: bool,
}

/// The pixels of the points, the size of the ring in the picture, and its camera.
struct Look<'a> {
    pixel: &'a [[f64; 2]],
    size: f64,
    camera: &'a Projector,
}

impl<'a> Seen<'a> {
    pub fn of(sample: &'a Sample, wall: &Curve, (rays, glints): (f64, bool)) -> Self {
        let radius = wall.radius();
        let off = sample.off(wall).map(|off| off.abs() > OFF * radius).collect();
        Seen { sample, off, radius, rays, glints }
    }

    /// Whether as many points lie off the wall as water shows.
    pub fn leaves_the_wall(&self) -> bool {
        self.enough(self.off.iter().filter(|&&off| off).count())
    }

    fn enough(&self, count: usize) -> bool {
        count as f64 >= FEWEST * self.sample.len() as f64
    }

    /// The chord that explains what lies round the invert best, and how much better than the wall does.
    pub fn water(&self, pixel: &[[f64; 2]], size: f64, camera: &Projector) -> Option<(f64, Chord)> {
        let (look, start) = (Look { pixel, size, camera }, self.between_ends()?);
        let raises: [f64; RAISES] = std::array::from_fn(|i| -0.14 + 0.03 * i as f64);
        let (_, coarse) = self.best(&look, start, (&TURNS, &raises), LOOSE);
        Some(self.best(&look, coarse, (&FINE_TURNS, &FINE_RAISES), 1.0))
    }

    /// Where the line leaves the wall on both sides of the lowest place.
    fn between_ends(&self) -> Option<Chord> {
        let mut balance = [0_i32; BINS];
        for ([x, y, _], &off) in self.sample.points.iter().zip(&self.off) {
            let step = ((x.atan2(*y) + PI) * (BINS as f64 / TAU)) as usize % BINS;
            balance[step] += if off { -1 } else { 1 };
        }
        let lit: Vec<usize> = (0..BINS).filter(|&step| balance[step] > 0).collect();
        let last = lit.first()? + BINS;
        let ends = lit.iter().skip(1).copied().chain([last]);
        let mut gaps: Vec<(usize, usize)> = lit.iter().zip(ends).map(|(&from, to)| (to - from, from)).collect();
        gaps.sort_by_key(|&(gap, _)| std::cmp::Reverse(gap));
        gaps.into_iter().take(2).find_map(|(gap, from)| {
            let step = TAU / BINS as f64;
            let (begin, width) = ((from + 1) as f64 * step - PI, (gap - 1) as f64 * step);
            let middle = turned(begin + width / 2.0 + PI, TAU) - PI;
            let fits = width >= NARROWEST && middle.abs() < STEEPEST;
            fits.then(|| Chord::at(middle, self.radius * (width / 2.0).cos()))
        })
    }

    /// The first of the best chords turned [deg] and raised from this one, with its score.
    fn best(&self, look: &Look, from: Chord, (turns, raises): (&[f64], &[f64]), slack: f64) -> (f64, Chord) {
        let (mut most, mut best) = (f64::NEG_INFINITY, from);
        for turn in turns {
            for raise in raises {
                let chord = Chord::at(from.turn + turn.to_radians(), from.depth - raise * self.radius);
                let score = self.score(look, &chord, slack * self.radius);
                if score > most {
                    (most, best) = (score, chord);
                }
            }
        }
        (most, best)
    }

    /// Points that water explains and the wall does not, less three times as many under the chord that it does not explain; 0 where it
    /// is none.
    fn score(&self, look: &Look, chord: &Chord, unit: f64) -> f64 {
        let (mut under, mut under_off, mut on_it, mut glints) = (vec![], 0, 0, 0);
        for (i, point) in self.sample.points.iter().enumerate() {
            let depth = chord.below(*point);
            if depth > LEVEL * unit {
                under.push(i);
                under_off += usize::from(self.off[i]);
            } else if depth.abs() <= LEVEL * unit {
                on_it += 1;
                glints += usize::from(self.off[i]);
            }
        }
        if !self.glints || on_it as f64 > DENSE * self.rays_to(chord) {
            glints = 0;
        }
        if !self.enough(under_off + glints) {
            return 0.0;
        }
        let image = Image::of(self.mirrored(look, chord));
        let (mut told, mut other) = (glints, 0);
        for i in under {
            if image.shows(look.pixel[i], look.size) {
                told += usize::from(self.off[i]);
            } else {
                other += 1;
            }
        }
        let is_water = self.enough(told) && other as f64 <= MOST_WALL * told as f64;
        if is_water {
            told as f64 - 3.0 * other as f64
        } else {
            0.0
        }
    }

    /// Pixels of what the chord would mirror.
    fn mirrored<'b>(&'b self, look: &'b Look, chord: &'b Chord) -> impl Iterator<Item = [f64; 2]> + 'b {
        let some = self.sample.points.iter().step_by((self.sample.len() / MOST_MIRRORED).max(1));
        let above = some.map(|&point| (point, chord.below(point))).filter(|&(_, depth)| depth < 0.0);
        above.map(|(point, depth)| look.camera.pixel(chord.mirrored(point, depth)))
    }

    /// How many of the rays that were looked at meet the water.
    fn rays_to(&self, chord: &Chord) -> f64 {
        self.rays * (chord.depth / self.radius).clamp(-1.0, 1.0).acos() / PI
    }
}
