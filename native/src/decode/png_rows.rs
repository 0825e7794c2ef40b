//! PNG rows freed of their filters (PNG specification, section 9): every byte was written as its difference to a prediction.

/// `row` of filter type `filter` becomes its bytes; `above` holds those of the row above, zeros above the first. `step` bytes to the
/// pixel on the left. False for a filter that does not exist.
pub fn unfilter(filter: u8, step: usize, above: &[u8], row: &mut [u8]) -> bool {
    match step {
        1 => unfiltered::<1>(filter, above, row),
        2 => unfiltered::<2>(filter, above, row),
        3 => unfiltered::<3>(filter, above, row),
        4 => unfiltered::<4>(filter, above, row),
        6 => unfiltered::<6>(filter, above, row),
        8 => unfiltered::<8>(filter, above, row),
        _ => false,
    }
}

fn unfiltered<const STEP: usize>(filter: u8, above: &[u8], row: &mut [u8]) -> bool {
    match filter {
        0 => {}
        1 => predicted::<STEP>(above, row, |left, _, _| left),
        2 => row.iter_mut().zip(above).for_each(|(byte, up)| *byte = byte.wrapping_add(*up)),
        3 => predicted::<STEP>(above, row, |left, up, _| ((u16::from(left) + u16::from(up)) / 2) as u8),
        4 => predicted::<STEP>(above, row, paeth),
        _ => return false,
    }
    true
}

/// Pixel after pixel, each byte predicted from those on the left, above, and above on the left.
#[inline(always)]
fn predicted<const STEP: usize>(above: &[u8], row: &mut [u8], predict: impl Fn(u8, u8, u8) -> u8) {
    let (mut left, mut corner) = ([0; STEP], [0; STEP]);
    for (pixel, up) in row.as_chunks_mut::<STEP>().0.iter_mut().zip(above.as_chunks::<STEP>().0) {
        for k in 0..STEP {
            left[k] = pixel[k].wrapping_add(predict(left[k], up[k], corner[k]));
        }
        (*pixel, corner) = (left, *up);
    }
}

/// Whichever of the three is nearest to left + up - corner; in this order where two are as near.
#[inline(always)]
fn paeth(left: u8, up: u8, corner: u8) -> u8 {
    let (a, b, c) = (i16::from(left), i16::from(up), i16::from(corner));
    let (from_left, from_up, from_corner) = ((b - c).abs(), (a - c).abs(), (a + b - 2 * c).abs());
    let nearer = if from_up <= from_corner { up } else { corner };
    if from_left <= from_up && from_left <= from_corner {
        left
    } else {
        nearer
    }
}
