//! Entries of the fuzzing targets in `native/fuzz`: `decode_image` and `image_size` below Python.

use std::io::Cursor;

use super::samples::Samples;

/// Height, width, channels, samples, and bytes of each.
pub type Shape = (usize, usize, usize, usize, usize);

pub fn decoded(data: &[u8], limit: usize) -> Result<Shape, String> {
    let image = super::decode(data, limit)?;
    let (samples, bytes) = match &image.samples {
        Samples::Eight(samples) => (samples.len(), 1),
        Samples::Sixteen(samples) => (samples.len(), 2),
    };
    Ok((image.height, image.width, image.channels, samples, bytes))
}

/// Width and height, from the header alone.
pub fn declared(data: &[u8]) -> Result<(usize, usize), String> {
    super::size(Cursor::new(data))
}
