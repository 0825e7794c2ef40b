//! Brightness along a ray: nearest pixel to find where a peak may be, bilinear there (see the Python module `_picture`).

use super::rays::{Track, ONE};

/// A grey value of 8 or 16 bits.
pub trait Grey: Copy + Into<f64> + Into<i64> + Into<u32> + TryFrom<u32> + Default + Send + Sync {
    const WHITE: u32;

    #[inline(always)]
    fn level(self) -> u32 {
        self.into()
    }
}

impl Grey for u8 {
    const WHITE: u32 = 255;
}

impl Grey for u16 {
    const WHITE: u32 = 65535;
}

/// One colour band of an image in memory: `data[(row * width + column) * bands + band]`.
pub struct Plane<'a, T> {
    pub data: &'a [T],
    pub width: usize,
    pub height: usize,
    pub bands: usize,
    pub band: usize,
}

impl<T: Grey> Plane<'_, T> {
    /// Where in `data` a pixel of the band lies.
    #[inline(always)]
    pub fn index(&self, column: usize, row: usize) -> usize {
        (row * self.width + column) * self.bands + self.band
    }

    /// Where in `data` the pixel nearest to a place in fixed point lies that is inside.
    #[inline(always)]
    pub fn nearest_index(&self, [column, row]: [i64; 2]) -> usize {
        const HALF: i64 = ONE / 2;
        self.index(((column + HALF) >> 32) as usize, ((row + HALF) >> 32) as usize)
    }

    /// Bilinear brightness at a place in fixed point that is inside, exact for places rounded down to 2^-16 px. Places on the last column
    /// or row need `EDGE`.
    #[inline(always)]
    fn bilinear<const EDGE: bool>(&self, [column, row]: [i64; 2]) -> f64 {
        const PART: i64 = 1 << 16;
        let (mut left, mut top) = (column >> 32, row >> 32);
        let (mut x, mut y) = (i64::from(column as u32 >> 16), i64::from(row as u32 >> 16));
        if EDGE && left == self.width as i64 - 1 {
            (left, x) = (left - 1, PART);
        }
        if EDGE && top == self.height as i64 - 1 {
            (top, y) = (top - 1, PART);
        }
        let at = self.index(left as usize, top as usize);
        let upper = &self.data[at..at + self.bands + 1];
        let at = at + self.width * self.bands;
        let lower = &self.data[at..at + self.bands + 1];
        let between = |pair: &[T]| -> i64 {
            let (a, b): (i64, i64) = (pair[0].into(), pair[self.bands].into());
            a * PART + x * (b - a)
        };
        let (upper, lower) = (between(upper), between(lower));
        (upper * PART + y * (lower - upper)) as f64 * (1.0 / ONE as f64)
    }

    /// The pixels that the samples from `first` on fall on, where a track runs along a row or down a column: the nearest and the
    /// bilinear brightness are theirs.
    #[inline(always)]
    fn aligned(&self, track: &Track, first: usize) -> Option<(&[T], usize)> {
        let pace = match track.step {
            [ONE, 0] => self.bands,
            [0, ONE] => self.bands * self.width,
            _ => return None,
        };
        let at = track.at(first);
        let whole = at.iter().all(|place| *place >= 0 && *place & (ONE - 1) == 0);
        whole.then(|| (self.data.get(self.index((at[0] >> 32) as usize, (at[1] >> 32) as usize)..).unwrap_or(&[]), pace))
    }

    /// Bilinear brightness of the samples from `first` on, all of which are inside.
    fn interpolate(&self, track: &Track, first: usize, values: &mut [f64]) {
        if let Some((pixels, pace)) = self.aligned(track, first) {
            values.iter_mut().zip(pixels.iter().step_by(pace)).for_each(|(value, pixel)| *value = (*pixel).into());
            return;
        }
        let ([mut column, mut row], [right, down]) = (track.at(first), track.step);
        let last = [(self.width as i64 - 1) * ONE, (self.height as i64 - 1) * ONE];
        let on_edge = |at: [i64; 2]| at[0] >= last[0] || at[1] >= last[1];
        if on_edge([column, row]) || on_edge(track.at(first + values.len())) {
            for value in values {
                *value = self.bilinear::<true>([column, row]);
                (column, row) = (column + right, row + down);
            }
        } else {
            for value in values {
                *value = self.bilinear::<false>([column, row]);
                (column, row) = (column + right, row + down);
            }
        }
    }
}

/// Luma of interleaved red, green, blue in thousandths (ITU-R BT.601), rounded half up.
pub fn luma<T: Grey>(data: &[T]) -> Vec<T> {
    let weigh = |p: &[T]| {
        let (red, green, blue) = (p[0].level(), p[1].level(), p[2].level());
        T::try_from((299 * red + 587 * green + 114 * blue + 500) / 1000).unwrap_or_default()
    };
    data.chunks_exact(3).map(weigh).collect()
}

/// Only every second sample is looked at to find bright ones: of the three that can make a peak lit, one is among them.
const STRIDE: usize = 2;
/// Samples whose brightness is noted together, one bit each.
const CHUNK: usize = u64::BITS as usize;

/// Which samples of a ray are bright enough for a peak, and the bilinear brightness of those and their surroundings.
pub struct Trace {
    /// Brightness, NaN outside the picture; of no meaning beyond the margin of every stretch.
    pub value: Vec<f64>,
    /// Stretches of bright samples, first and last.
    pub stretches: Vec<(usize, usize)>,
}

impl Trace {
    pub fn new(samples: usize) -> Self {
        Trace { value: vec![f64::NAN; samples], stretches: Vec::new() }
    }

    /// Reads `track` again into the same memory: stretches within `span` (first, end sample), `margin` samples more on each side.
    pub fn read<T: Grey>(&mut self, plane: &Plane<T>, track: &Track, span: (usize, usize), gate: u32, margin: usize) {
        let samples = self.value.len();
        let (first, end) = track.inside(plane.width, plane.height, samples);
        self.find_bright(plane, track, (first.max(span.0), end.min(span.1)), gate);
        let mut next = 0;
        for &(begin, last) in &self.stretches {
            let (from, to) = (begin.saturating_sub(margin).max(next), (last + margin + 1).min(samples));
            next = next.max(to);
            let (known, unknown) = (from.max(first), to.min(end));
            if from < known {
                self.value[from..known.min(to)].fill(f64::NAN);
            }
            plane.interpolate(track, known, &mut self.value[known..unknown.max(known)]);
            if unknown < to {
                self.value[unknown.max(from)..to].fill(f64::NAN);
            }
        }
    }

    fn find_bright<T: Grey>(&mut self, plane: &Plane<T>, track: &Track, (first, end): (usize, usize), gate: u32) {
        self.stretches.clear();
        let first = first.next_multiple_of(STRIDE);
        let count = end.saturating_sub(first).div_ceil(STRIDE);
        if let Some((pixels, pace)) = plane.aligned(track, first) {
            let mut pixels = pixels.iter().step_by(STRIDE * pace);
            for begin in (0..count).step_by(CHUNK) {
                let chunk = pixels.by_ref().take(CHUNK.min(count - begin)).enumerate();
                let bright = chunk.fold(0u64, |bright, (k, pixel)| bright | u64::from(pixel.level() >= gate) << k);
                self.stretches_of(bright, first + begin * STRIDE);
            }
            return;
        }
        let ([mut column, mut row], [right, down]) = (track.at(first), track.step.map(|step| step * STRIDE as i64));
        for begin in (0..count).step_by(CHUNK) {
            let mut bright = 0u64;
            for k in 0..CHUNK.min(count - begin) {
                let pixel = plane.data[plane.nearest_index([column, row])].level();
                bright |= u64::from(pixel >= gate) << k;
                (column, row) = (column + right, row + down);
            }
            self.stretches_of(bright, first + begin * STRIDE);
        }
    }

    /// Notes the bright stretches of a chunk whose first sample is `first`.
    fn stretches_of(&mut self, mut bright: u64, first: usize) {
        while bright != 0 {
            let skipped = bright.trailing_zeros() as usize;
            let length = (bright >> skipped).trailing_ones() as usize;
            bright &= u64::MAX.checked_shl((skipped + length) as u32).unwrap_or(0);
            self.stretch(first + skipped * STRIDE, first + (skipped + length - 1) * STRIDE);
        }
    }

    /// Notes a bright stretch, as part of the last one if it continues it.
    fn stretch(&mut self, begin: usize, last: usize) {
        match self.stretches.last_mut() {
            Some(before) if before.1 + STRIDE == begin => before.1 = last,
            _ => self.stretches.push((begin, last)),
        }
    }
}
