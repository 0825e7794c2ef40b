//! Brightness along a ray: bilinear where a peak may be, nearest pixel to find where that is.

/// One colour band of an image in memory: `data[(row * width + column) * step + band]`.
pub struct Plane<'a, T> {
    pub data: &'a [T],
    pub width: usize,
    pub height: usize,
    pub step: usize,
    pub band: usize,
}

impl<T: Copy + Into<f64>> Plane<'_, T> {
    #[inline(always)]
    fn pixel(&self, column: usize, row: usize) -> f64 {
        self.data[(row * self.width + column) * self.step + self.band].into()
    }

    #[inline(always)]
    fn contains(&self, column: f64, row: f64) -> bool {
        column >= 0.0 && row >= 0.0 && column <= (self.width - 1) as f64 && row <= (self.height - 1) as f64
    }

    /// Bilinear brightness, NaN outside.
    #[inline(always)]
    pub fn bilinear(&self, column: f64, row: f64) -> f64 {
        if !self.contains(column, row) {
            return f64::NAN;
        }
        let (left, top) = ((column as usize).min(self.width - 2), (row as usize).min(self.height - 2));
        let (x, y) = (column - left as f64, row - top as f64);
        let (a, b) = (self.pixel(left, top), self.pixel(left + 1, top));
        let (c, d) = (self.pixel(left, top + 1), self.pixel(left + 1, top + 1));
        let (upper, lower) = (a + x * (b - a), c + x * (d - c));
        upper + y * (lower - upper)
    }
}

/// One ray: start, unit direction, samples one pixel apart.
#[derive(Clone, Copy)]
pub struct Ray {
    pub start: [f64; 2],
    pub direction: [f64; 2],
}

impl Ray {
    #[inline(always)]
    pub fn at(&self, sample: usize) -> (f64, f64) {
        let s = sample as f64;
        (self.start[0] + s * self.direction[0], self.start[1] + s * self.direction[1])
    }

    /// The samples that lie inside `plane`: from first to before last. A picture is convex, so they are one run.
    fn inside<T: Copy + Into<f64>>(&self, plane: &Plane<T>, samples: usize) -> (usize, usize) {
        let contains = |sample: &usize| {
            let (column, row) = self.at(*sample);
            plane.contains(column, row)
        };
        match (0..samples).find(contains) {
            Some(first) => (first, (first..samples).rfind(contains).map_or(first, |last| last + 1)),
            None => (0, 0),
        }
    }
}

/// Pixel coordinates in 32.32 fixed point: the nearest pixel of every sample for two additions.
const ONE: f64 = 4294967296.0;

fn fixed(value: f64) -> i64 {
    (value * ONE).floor() as i64
}

/// Which samples of a ray are bright enough for a peak, and the bilinear brightness of those and their surroundings.
pub struct Trace {
    pub bright: Vec<bool>,
    pub value: Vec<f64>,
    /// Stretches of samples, first and last, in whose middle a peak may lie.
    pub stretches: Vec<(usize, usize)>,
}

impl Trace {
    pub fn new(samples: usize) -> Self {
        Trace { bright: vec![false; samples], value: vec![f64::NAN; samples], stretches: Vec::new() }
    }

    /// Reads `ray` again into the same memory; `margin` samples are added on each side of every bright stretch.
    pub fn read<T: Copy + Into<f64>>(&mut self, plane: &Plane<T>, ray: &Ray, gate: f64, margin: usize) {
        let samples = self.bright.len();
        self.stretches.clear();
        let mut end_of_read = 0;
        let (first, end) = ray.inside(plane, samples);
        self.bright[..first].fill(false);
        self.bright[end..].fill(false);
        let (mut column, mut row) = (fixed(ray.start[0] + 0.5), fixed(ray.start[1] + 0.5));
        let (right, down) = (fixed(ray.direction[0]), fixed(ray.direction[1]));
        column += first as i64 * right;
        row += first as i64 * down;
        for bright in &mut self.bright[first..end] {
            let (c, r) = (((column >> 32) as usize).min(plane.width - 1), ((row >> 32) as usize).min(plane.height - 1));
            *bright = plane.pixel(c, r) >= gate;
            column += right;
            row += down;
        }
        let mut sample = first;
        while let Some(begin) = (sample..end).find(|&k| self.bright[k]) {
            sample = (begin..end).find(|&k| !self.bright[k]).unwrap_or(end);
            self.stretches.push((begin, sample - 1));
        }
        for &(first, last) in &self.stretches {
            let from = first.saturating_sub(margin).max(end_of_read);
            let to = (last + margin + 1).min(samples);
            for sample in from..to {
                let (column, row) = ray.at(sample);
                self.value[sample] = plane.bilinear(column, row);
            }
            end_of_read = end_of_read.max(to);
        }
    }
}
