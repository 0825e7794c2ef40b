//! Which samples of a ray may belong to a peak, and their brightness (see the Python module `_scan`).

use super::rays::{Ray, Rays, Track};
use super::sampling::{Grey, Plane, BLOCK, STRIDE};
use super::vectors::{vectorised, Vectors};
use super::walk::{lit, GROUP};

/// Samples whose brightness is noted together, one bit each.
const CHUNK: usize = u64::BITS as usize;
/// First and last sample of a bright stretch.
pub type Stretch = (usize, usize);

/// Where on a ray peaks are looked for: within a span (first, end sample), or at stretches that are known to be bright.
#[derive(Clone, Copy)]
pub enum Look<'a> {
    Within((usize, usize)),
    At(&'a [Stretch]),
}

/// The bright stretches of all rays in their full length.
pub struct Bright {
    stretches: Vec<Stretch>,
    /// Where each ray's stretches end.
    ends: Vec<usize>,
}

impl Bright {
    pub fn along<T: Grey>(plane: &Plane<T>, rays: &Rays, gate: u32) -> Bright {
        let (mut trace, mut bright) = (Trace::new(0), Bright { stretches: Vec::new(), ends: Vec::with_capacity(rays.rays.len()) });
        for track in rays.rays.iter().map(Ray::track) {
            trace.find_bright(plane, &track, track.inside(plane.width, plane.height, rays.samples), gate);
            bright.stretches.extend_from_slice(&trace.stretches);
            bright.ends.push(bright.stretches.len());
        }
        bright
    }

    pub fn of(&self, ray: usize) -> Look<'_> {
        let first = if ray == 0 { 0 } else { self.ends[ray - 1] };
        Look::At(&self.stretches[first..self.ends[ray]])
    }
}

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

    /// Reads `track` again into the same memory: stretches where `look` says, `margin` samples more on each side.
    pub fn read<T: Grey>(&mut self, plane: &Plane<T>, track: &Track, look: Look, gate: u32, margin: usize) {
        let samples = self.values().len();
        let (first, end) = track.inside(plane.width, plane.height, samples);
        match look {
            Look::Within((from, to)) => self.find_bright(plane, track, (first.max(from), end.min(to)), gate),
            Look::At(stretches) => {
                self.stretches.clear();
                self.stretches.extend_from_slice(stretches);
            }
        }
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
            let wanted = [(1, T::GREY_ROW), (3, T::COLOUR_ROW)].into_iter().find(|(bands, _)| pace == *bands && pace == plane.bands);
            if let Some((bands, wanted)) = wanted {
                let pixels = &pixels[..pixels.len().min(count * STRIDE * bands)];
                self.bright_in_row(plane.vectors, (pixels, wanted, STRIDE * bands), first, gate);
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

/// Number of whole blocks that begin `pixels` without a bright one where `wanted` is white.
fn dark_blocks<T: Grey>(vectors: Vectors, pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize {
    vectorised!(vectors, dark_blocks_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize)
}

#[inline(always)]
fn dark_blocks_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize {
    let blocks = pixels.as_chunks::<BLOCK>().0;
    blocks.iter().position(|block| any_bright(block, wanted, gate)).unwrap_or(blocks.len())
}

/// No loop that ends early: this one is a few vector instructions.
#[inline(always)]
fn any_bright<T: Grey>(block: &[T; BLOCK], wanted: &[T; BLOCK], gate: T) -> bool {
    let mut brightest = [T::default(); BLOCK / 3];
    for (values, wanted) in block.as_chunks::<{ BLOCK / 3 }>().0.iter().zip(wanted.as_chunks::<{ BLOCK / 3 }>().0) {
        for k in 0..BLOCK / 3 {
            let value: T = values[k] & wanted[k];
            brightest[k] = if value > brightest[k] { value } else { brightest[k] };
        }
    }
    brightest.iter().fold(false, |any, &value| any | (value >= gate))
}
