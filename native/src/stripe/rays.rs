//! Where to look: straight rays of samples one pixel apart (see the Python module `_rays`).

use super::statistics::floor;

/// Largest coordinate or radius: small enough for fixed point.
pub const FARTHEST: f64 = 1048576.0;
/// One pixel in 32.32 fixed point.
pub const ONE: i64 = 1 << 32;

/// One ray: start and unit direction.
#[derive(Clone, Copy)]
pub struct Ray {
    pub start: [f64; 2],
    pub direction: [f64; 2],
}

impl Ray {
    #[inline(always)]
    pub fn at(&self, position: f64) -> [f64; 2] {
        [self.start[0] + position * self.direction[0], self.start[1] + position * self.direction[1]]
    }

    pub fn track(&self) -> Track {
        let fixed = |value: f64| floor(value * ONE as f64);
        Track { start: self.start.map(fixed), step: self.direction.map(fixed) }
    }
}

/// A ray in fixed point: column and row of its samples by integer steps, the same in both kernels.
pub struct Track {
    pub start: [i64; 2],
    pub step: [i64; 2],
}

impl Track {
    #[inline(always)]
    pub fn at(&self, sample: usize) -> [i64; 2] {
        [self.start[0] + sample as i64 * self.step[0], self.start[1] + sample as i64 * self.step[1]]
    }

    /// First and end sample within the outermost pixel centres of a picture; a picture is convex, so they are one run.
    pub fn inside(&self, width: usize, height: usize, samples: usize) -> (usize, usize) {
        let limit = [(width as i64 - 1) * ONE, (height as i64 - 1) * ONE];
        let contains = |at: [i64; 2]| at.iter().zip(limit).all(|(&a, l)| (0..=l).contains(&a));
        if contains(self.start) && contains(self.at(samples.saturating_sub(1))) {
            return (0, samples);
        }
        let (mut first, mut last) = (0, samples as i64 - 1);
        for (axis, limit) in limit.into_iter().enumerate() {
            let (start, step) = (self.start[axis], self.step[axis]);
            let (near, far) = if step >= 0 { (-start, limit - start) } else { (start - limit, start) };
            match step.abs() {
                0 if near > 0 || far < 0 => return (0, 0),
                0 => {}
                pace => {
                    first = first.max((near + pace - 1).div_euclid(pace));
                    last = last.min(far.div_euclid(pace));
                }
            }
        }
        if first <= last {
            (first as usize, last as usize + 1)
        } else {
            (0, 0)
        }
    }
}

/// A set of rays; `closed` go round a ring. `spacing` is the distance of neighbours where they should meet the line. Each ray stands for
/// `stride` rays of a denser set.
pub struct Rays {
    pub rays: Vec<Ray>,
    pub samples: usize,
    pub closed: bool,
    pub spacing: f64,
    pub stride: usize,
}

impl Rays {
    /// Every `stride`-th ray.
    pub fn every(&self, stride: usize) -> Rays {
        let rays = self.rays.iter().step_by(stride).copied().collect();
        Rays { rays, spacing: self.spacing * stride as f64, stride: self.stride * stride, ..*self }
    }

    /// One ray down every pixel column.
    pub fn columns(width: usize, height: usize) -> Rays {
        let rays = (0..width).map(|column| Ray { start: [column as f64, 0.0], direction: [0.0, 1.0] }).collect();
        Rays { rays, samples: height, closed: false, spacing: 1.0, stride: 1 }
    }

    /// One ray along every pixel row.
    pub fn rows(width: usize, height: usize) -> Rays {
        let rays = (0..height).map(|row| Ray { start: [0.0, row as f64], direction: [1.0, 0.0] }).collect();
        Rays { rays, samples: width, closed: false, spacing: 1.0, stride: 1 }
    }
}

/// Where a ring is looked for, and which of its rays count for centring.
#[derive(Clone, Copy)]
pub struct Annulus<'a> {
    pub centre: [f64; 2],
    pub inner: f64,
    pub outer: f64,
    pub direction: &'a [[f64; 2]],
    pub counted: &'a [bool],
}

impl Annulus<'_> {
    pub fn is_sound(&self) -> bool {
        let sizes = self.inner >= 0.0 && self.inner < self.outer && self.outer <= FARTHEST;
        let unit = |c: &f64| c.abs() <= 1.0;
        sizes && self.direction.len() >= 16 && self.centre.iter().all(|c| c.abs() <= FARTHEST) && self.direction.iter().flatten().all(unit)
    }

    /// Every `stride`-th ray.
    pub fn every(&self, stride: usize) -> Rays {
        let from = |d: &[f64; 2]| [self.centre[0] + self.inner * d[0], self.centre[1] + self.inner * d[1]];
        let rays = self.direction.iter().step_by(stride).map(|d| Ray { start: from(d), direction: *d }).collect();
        let spacing = 2.0 * std::f64::consts::PI * 0.5 * (self.inner + self.outer) / self.direction.len() as f64;
        Rays { rays, samples: (self.outer - self.inner).ceil() as usize + 1, closed: true, spacing: spacing * stride as f64, stride }
    }
}
