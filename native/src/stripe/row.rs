//! Brightness of pixels that lie side by side in a row of the picture: many at a time, by the vector instructions of any machine.

use super::sampling::{Grey, BLOCK};
use super::vectors::{vectorised, Vectors};

/// Values compared at once: short enough for registers.
const PART: usize = BLOCK / 3;

/// Number of whole blocks that begin `pixels` without one of `gate` or brighter where `wanted` is white.
pub fn dark_blocks<T: Grey>(vectors: Vectors, pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize {
    vectorised!(vectors, dark_blocks_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize)
}

#[inline(always)]
fn dark_blocks_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK], gate: T) -> usize {
    // a closure given to `position` would be compiled without the vector instructions
    let mut dark = 0;
    for block in pixels.as_chunks::<BLOCK>().0 {
        if any_bright(block, wanted, gate) {
            break;
        }
        dark += 1;
    }
    dark
}

/// No loop that ends early: this one is a few vector instructions.
#[inline(always)]
fn any_bright<T: Grey>(block: &[T; BLOCK], wanted: &[T; BLOCK], gate: T) -> bool {
    let mut top = [T::default(); PART];
    raise(&mut top, block, wanted);
    top.iter().fold(false, |any, &value| any | (value >= gate))
}

/// Brightest of the `pixels` where `wanted`, over and over, is white.
pub fn brightest<T: Grey>(vectors: Vectors, pixels: &[T], wanted: &[T; BLOCK]) -> T {
    vectorised!(vectors, brightest_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK]) -> T)
}

#[inline(always)]
fn brightest_of<T: Grey>(pixels: &[T], wanted: &[T; BLOCK]) -> T {
    let (blocks, rest) = pixels.as_chunks::<BLOCK>();
    let mut top = [T::default(); PART];
    blocks.iter().for_each(|block| raise(&mut top, block, wanted));
    let rest = rest.iter().zip(wanted).map(|(&value, &wanted)| value & wanted);
    top.into_iter().chain(rest).fold(T::default(), higher)
}

/// Raises the `top` to the values of a block where `wanted` is white.
#[inline(always)]
fn raise<T: Grey>(top: &mut [T; PART], block: &[T; BLOCK], wanted: &[T; BLOCK]) {
    for (values, wanted) in block.as_chunks::<PART>().0.iter().zip(wanted.as_chunks::<PART>().0) {
        for k in 0..PART {
            top[k] = higher(values[k] & wanted[k], top[k]);
        }
    }
}

#[inline(always)]
fn higher<T: Grey>(value: T, other: T) -> T {
    if value > other {
        value
    } else {
        other
    }
}
