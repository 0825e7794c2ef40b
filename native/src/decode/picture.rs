//! A picture in the memory of the thread that reads it, for as long as something is done with it.

use pyo3::prelude::*;

use super::lying::Lying;
use super::samples::{Image, Samples};
use super::{decode, guarded, pnm, scratch, tiff, with_data, Format, Source, SIGNATURE};

/// Rows, columns and samples per pixel.
#[derive(Clone, Copy)]
pub struct Size {
    pub height: usize,
    pub width: usize,
    pub channels: usize,
}

#[derive(Clone, Copy)]
pub enum Pixels<'a> {
    Eight(&'a [u8]),
    Sixteen(&'a [u16]),
}

/// `work` on the picture in `source`, the GIL released; none where it cannot be read, needs more than `limit` bytes or is no picture.
pub fn with_picture<R: Send>(py: Python<'_>, source: &Source<'_>, limit: usize, work: impl FnOnce(Size, Pixels) -> R + Send) -> Option<R> {
    with_data(py, source, limit, |data| Ok(on_pixels(data, limit, work))).ok().flatten()
}

fn on_pixels<R>(data: &[u8], limit: usize, work: impl FnOnce(Size, Pixels) -> R) -> Option<R> {
    if let Some((lying, pixels)) = lying(data).and_then(|lying| Some((lying, lying.ready(data, limit)?))) {
        return Some(work(Size { height: lying.height, width: lying.width, channels: lying.channels }, Pixels::Eight(pixels)));
    }
    let Image { height, width, channels, samples } = decode(data, limit).ok()?;
    let pixels = match &samples {
        Samples::Eight(samples) => Pixels::Eight(samples),
        Samples::Sixteen(samples) => Pixels::Sixteen(samples),
    };
    let result = work(Size { height, width, channels }, pixels);
    scratch::give_back(samples);
    Some(result)
}

/// Where the pixels lie in the file, if they do.
fn lying(data: &[u8]) -> Option<Lying> {
    let format = Format::of(&data[..data.len().min(SIGNATURE)]).ok()?;
    guarded(|| match format {
        Format::Tiff => tiff::lying(data).ok_or_else(String::new),
        Format::Pnm => pnm::lying(data),
        _ => Err(String::new()),
    })
    .ok()
}
