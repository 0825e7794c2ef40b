//! How a rig's numbers move together: one mode for each column of a factor of the covariance, of one standard uncertainty.

use super::camera::{Sight, MOUNT};
use super::lanes::{dot, vector, Lanes, Vector};
use super::surface::{Contact, Surface, SURFACE};

/// Numbers of one mode: of the surface, of the mount, and of k, c1, c2, aspect and principal point.
pub const MODE: usize = SURFACE + MOUNT + 6;

/// A motion; parts that do not move are none.
pub struct Mode {
    surface: Option<[f64; SURFACE]>,
    mount: Option<[f64; MOUNT]>,
    lens: Option<[f64; 3]>,
    pixel: Option<[f64; 3]>,
}

/// What a mode does to the meeting: what the ray leaves of the surface, how far it turns by zenith and azimuth, how it shifts.
pub struct Motion {
    pub surface: Lanes,
    pub turns: [Lanes; 2],
    pub shift: Vector,
}

impl Mode {
    pub fn of(numbers: &[f64; MODE]) -> Self {
        fn part<const N: usize>(numbers: &[f64], from: usize) -> Option<[f64; N]> {
            let part: [f64; N] = std::array::from_fn(|i| numbers[from + i]);
            part.iter().any(|&x| x != 0.0).then_some(part)
        }
        let camera = SURFACE + MOUNT;
        Mode { surface: part(numbers, 0), mount: part(numbers, SURFACE), lens: part(numbers, camera), pixel: part(numbers, camera + 3) }
    }

    #[inline(always)]
    pub fn motion<S: Surface>(&self, surface: &S, contact: &Contact, sight: &Sight, distance: Lanes) -> Motion {
        let mut motion = Motion { surface: Lanes::ZERO, turns: [Lanes::ZERO; 2], shift: [Lanes::ZERO; 3] };
        if let Some(numbers) = &self.surface {
            motion.surface = surface.moved(contact, numbers);
        }
        if let Some([k, c1, c2]) = self.lens {
            motion.turns[0] = sight.by_lens[0] * Lanes::all(k);
            if c1 != 0.0 || c2 != 0.0 {
                motion.turns[0] = motion.turns[0] + sight.by_lens[1] * Lanes::all(c1) + sight.by_lens[2] * Lanes::all(c2);
            }
        }
        if let Some([aspect, u, v]) = self.pixel {
            let x = Lanes::all(-u);
            let y = -(sight.y * Lanes::all(aspect) + Lanes::all(v)) * sight.per_aspect;
            let (c, s) = (sight.cos_azimuth, sight.sin_azimuth);
            motion.turns[0] = motion.turns[0] + sight.by_radius * (c * x + s * y);
            motion.turns[1] = sight.across * (c * y - s * x);
        }
        if let Some(m) = &self.mount {
            for i in 0..3 {
                let turned = dot(vector([m[3 * i], m[3 * i + 1], m[3 * i + 2]]), sight.direction);
                motion.shift[i] = turned * distance + Lanes::all(m[9 + i]);
            }
        }
        motion
    }

    /// Whether the ray's origin and frame move.
    pub fn moves_mount(&self) -> bool {
        self.mount.is_some()
    }
}
