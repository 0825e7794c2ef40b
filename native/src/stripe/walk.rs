//! Samples along a track, many at a time: with AVX2 where the processor has it; else first where their pixels lie, then these, then what
//! they make together. The numbers are the same.

use super::rays::ONE;
use super::sampling::{Grey, Plane};
#[cfg(target_arch = "x86_64")]
use super::walk_wide as wide;

/// Parts of a pixel between which brightness is interpolated.
pub const PARTS: f64 = 65536.0;
/// Samples followed at once.
pub const CHUNK: usize = u64::BITS as usize;
/// Samples are read by whole groups: a loop that is always as long is foreseen, and that is worth more than a few samples.
pub const GROUP: usize = 4;

/// Where samples lie in fixed point: the first one, and how far the next is.
pub type Steps = ([i64; 2], [i64; 2]);

/// Whether samples are read by AVX2: places of values must fit into half a lane.
#[cfg(target_arch = "x86_64")]
fn in_vectors<T: Grey>(plane: &Plane<T>) -> bool {
    plane.vectors.allowed() && u32::try_from(plane.data.len()).is_ok()
}

/// Which of up to `CHUNK` samples, all inside, have a nearest pixel of `gate` or brighter: one bit each.
pub fn lit<T: Grey>(plane: &Plane<T>, steps: Steps, count: usize, gate: u32) -> u64 {
    let steps = half_on(steps);
    #[cfg(target_arch = "x86_64")]
    if in_vectors(plane) {
        // SAFETY: the processor has AVX2
        return u64::MAX >> (CHUNK - count) & unsafe { wide::lit(plane, steps, count.div_ceil(GROUP), gate) };
    }
    let mut offset = [0; CHUNK];
    let level = levels(plane, steps, &mut offset[..count]);
    level.rev().fold(0, |lit, level| lit << 1 | u64::from(level >= gate))
}

/// Brightness of the pixels nearest to `count` samples that are inside, in place of what was in `line`.
pub fn nearest<T: Grey>(plane: &Plane<T>, steps: Steps, count: usize, line: &mut Vec<u32>) {
    let steps = half_on(steps);
    line.clear();
    #[cfg(target_arch = "x86_64")]
    if in_vectors(plane) {
        // SAFETY: the processor has AVX2
        unsafe { wide::nearest(plane, steps, count.div_ceil(GROUP), line) };
        return line.truncate(count);
    }
    let mut offset = [0; CHUNK];
    for begin in (0..count).step_by(CHUNK) {
        line.extend(levels(plane, (at(steps, begin), steps.1), &mut offset[..CHUNK.min(count - begin)]));
    }
}

/// Samples half a pixel on, which are in the pixels nearest to these.
fn half_on((from, step): Steps) -> Steps {
    (from.map(|place| place + ONE / 2), step)
}

fn at((from, step): Steps, sample: usize) -> [i64; 2] {
    std::array::from_fn(|axis| from[axis] + sample as i64 * step[axis])
}

/// Brightness of the pixels that hold as many samples as there is room for `offset`s.
fn levels<'a, T: Grey>(plane: &'a Plane<T>, steps: Steps, offset: &'a mut [i32]) -> impl DoubleEndedIterator<Item = u32> + 'a {
    let start = first_pixel(plane, steps);
    offsets(plane, steps, offset);
    offset.iter().map(move |&offset| plane.data[start.wrapping_add_signed(offset as isize)].level())
}

/// Where the pixel that holds the first sample lies in the picture.
fn first_pixel<T: Grey>(plane: &Plane<T>, (from, _): Steps) -> usize {
    plane.index((from[0] >> 32) as usize, (from[1] >> 32) as usize)
}

/// How far the pixels that hold samples lie from that of the first one.
fn offsets<T: Grey>(plane: &Plane<T>, ([column, row], [right, down]): Steps, offset: &mut [i32]) {
    let (mut column, mut row) = (column & (ONE - 1), row & (ONE - 1));
    let (across, below) = (plane.bands as i32, (plane.bands * plane.width) as i32);
    for offset in offset {
        *offset = ((row >> 32) as i32).wrapping_mul(below).wrapping_add(((column >> 32) as i32).wrapping_mul(across));
        (column, row) = (column + right, row + down);
    }
}

/// Bilinear brightness of `count` samples that are inside and not on the last column or row, as the first of `values`; values up to a
/// whole group are of no meaning after them.
pub fn bilinear<T: Grey>(plane: &Plane<T>, steps: Steps, count: usize, values: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if in_vectors(plane) {
        let values = &mut values[..count.next_multiple_of(GROUP)];
        // SAFETY: the processor has AVX2
        return match plane.bands {
            3 => unsafe { wide::bilinear::<T, 3>(plane, steps, values) },
            _ => unsafe { wide::bilinear::<T, 0>(plane, steps, values) },
        };
    }
    for (number, values) in values[..count].chunks_mut(CHUNK).enumerate() {
        let steps = (at(steps, number * CHUNK), steps.1);
        let mut pairs = [[0; CHUNK]; 2];
        let [upper, lower] = pairs.each_mut().map(|pairs| &mut pairs[..values.len()]);
        match plane.bands {
            3 => fetch::<T, 3>(plane, steps, upper, lower),
            _ => fetch::<T, 0>(plane, steps, upper, lower),
        }
        interpolate::<T>(steps, upper, lower, values);
    }
}

/// The pairs of pixels about samples: those of the `upper` row, and those of the `lower` one.
fn fetch<T: Grey, const BANDS: usize>(plane: &Plane<T>, steps: Steps, upper: &mut [u32], lower: &mut [u32]) {
    let (mut offset, bands) = ([0; CHUNK], if BANDS > 0 { BANDS } else { plane.bands });
    let (start, offset) = (first_pixel(plane, steps), &mut offset[..upper.len()]);
    offsets(plane, steps, offset);
    let below = plane.data.get(plane.bands * plane.width..).unwrap_or(&[]);
    for ((offset, upper), lower) in offset.iter().zip(upper).zip(lower) {
        let at = start.wrapping_add_signed(*offset as isize);
        *upper = T::pair::<BANDS>(&plane.data[at..=at + bands], bands);
        *lower = T::pair::<BANDS>(&below[at..=at + bands], bands);
    }
}

fn interpolate<T: Grey>(([mut column, mut row], [right, down]): Steps, upper: &[u32], lower: &[u32], values: &mut [f64]) {
    let (white, shift) = (T::WHITE, T::WHITE.leading_zeros());
    for ((value, &upper), &lower) in values.iter_mut().zip(upper).zip(lower) {
        let part = |place: i64| f64::from((place as u32 >> 16) as i32);
        // whole numbers below 2^53: as exact as in fixed point
        let across = |pair: u32| {
            let (a, b) = ((pair & white) as i32, (pair >> shift) as i32);
            f64::from(a) * PARTS + part(column) * f64::from(b - a)
        };
        let (upper, lower) = (across(upper), across(lower));
        *value = (upper * PARTS + part(row) * (lower - upper)) * (1.0 / ONE as f64);
        (column, row) = (column + right, row + down);
    }
}
