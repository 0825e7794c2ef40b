//! Which samples of a ray may belong to a peak, and their brightness (see the Python module `_scan`).

use super::rays::Track;
use super::row::dark_blocks;
use super::sampling::{Grey, Plane, BLOCK, STRIDE};
use super::vectors::Vectors;
use super::walk::{lit, CHUNK, GROUP};

/// First and last sample of a bright stretch.
pub type Stretch = (usize, usize);

/// Which samples of a ray are bright enough for a peak, and the bilinear brightness of those and their surroundings.
pub struct Trace {
    /// Brightness of the samples, and room for a group behind them.
    value: Vec<f64>,
    /// Stretches of bright samples, first and last.
    pub stretches: Vec<Stretch>,
}

impl Trace {
    pub fn new(samples: usize) -> Self {
        Trace { value: vec![f64::NAN; samples + GROUP], stretches: Vec::new() }
    }

    /// Brightness of the samples, NaN outside the picture; of no meaning beyond the margin of every stretch.
    pub fn values(&self) -> &[f64] {
        &self.value[..self.value.len() - GROUP]
    }

    /// Reads `track` again into the same memory: stretches within a span (first, end sample), `margin` samples more on each side.
    pub fn read<T: Grey>(&mut self, plane: &Plane<T>, track: &Track, span: (usize, usize), gate: u32, margin: usize) {
        let samples = self.values().len();
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
            plane.interpolate(track, (known, unknown.max(known)), &mut self.value);
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
            if let Some(wanted) = T::white_at_every(STRIDE * pace).filter(|_| pace == plane.bands) {
                let pixels = &pixels[..pixels.len().min(count * STRIDE * pace)];
                self.bright_in_row(plane.vectors, (pixels, wanted, STRIDE * pace), first, gate);
                return;
            }
            let mut pixels = pixels.iter().step_by(STRIDE * pace);
            for begin in (0..count).step_by(CHUNK) {
                let chunk = pixels.by_ref().take(CHUNK.min(count - begin)).enumerate();
                let bright = chunk.fold(0u64, |bright, (k, pixel)| bright | u64::from(pixel.level() >= gate) << k);
                self.stretches_of(bright, first + begin * STRIDE);
            }
            return;
        }
        let step = track.step.map(|step| step * STRIDE as i64);
        for begin in (0..count).step_by(CHUNK) {
            let (from, count) = (track.at(first + begin * STRIDE), CHUNK.min(count - begin));
            let bright = lit(plane, (from, step), count, gate);
            self.stretches_of(bright, first + begin * STRIDE);
        }
    }

    /// Notes the bright ones of the samples from `first` on, which lie `pace` values apart in the `pixels` of a row, where `wanted` is white:
    /// block by block, because most blocks have none.
    fn bright_in_row<T: Grey>(&mut self, vectors: Vectors, (pixels, wanted, pace): (&[T], &[T; BLOCK], usize), first: usize, gate: u32) {
        let Ok(gate) = T::try_from(gate) else { return };
        let (mut number, whole) = (0, pixels.len() / BLOCK);
        while number <= whole {
            number += dark_blocks(vectors, &pixels[number * BLOCK..], wanted, gate);
            let Some(block) = pixels.get(number * BLOCK..) else { return };
            let samples = block[..block.len().min(BLOCK)].iter().step_by(pace).enumerate();
            let bright = samples.fold(0u64, |bright, (k, pixel)| bright | u64::from(*pixel >= gate) << k);
            self.stretches_of(bright, first + number * (BLOCK / pace) * STRIDE);
            number += 1;
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
