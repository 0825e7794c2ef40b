//! JPEG, baseline and progressive, grey or colour, 8 bit.

use std::io::{BufRead, Seek};

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::JpegDecoder;

use super::samples::{Image, Samples};
use super::{checked_bytes, Decoded, TRUNCATED};

const LARGEST_SIDE: usize = 65535;
const PROGRESSIVE: u8 = 0xc2;
const END_OF_IMAGE: u8 = 0xd9;

fn refusal(error: DecodeErrors) -> String {
    match error {
        DecodeErrors::ExhaustedData | DecodeErrors::IoErrors(_) => TRUNCATED.into(),
        error => format!("its JPEG data are corrupt or of an unsupported kind ({error})"),
    }
}

fn options() -> DecoderOptions {
    DecoderOptions::default().set_strict_mode(true).set_max_width(LARGEST_SIDE).set_max_height(LARGEST_SIDE)
}

pub fn size(source: impl BufRead + Seek) -> Decoded<(usize, usize)> {
    let mut decoder = JpegDecoder::new_with_options(source, options());
    decoder.decode_headers().map_err(refusal)?;
    let info = decoder.info().ok_or(TRUNCATED)?;
    Ok((info.width.into(), info.height.into()))
}

pub fn decode(data: &[u8], limit: usize) -> Decoded<Image> {
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(stopped(data)?), options());
    decoder.decode_headers().map_err(refusal)?;
    let info = decoder.info().ok_or(TRUNCATED)?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let (colour, channels) = if grey { (ColorSpace::Luma, 1) } else { (ColorSpace::RGB, 3) };
    let mut samples = Samples::eight(checked_bytes(width, height, channels, limit)?);
    decoder.set_options(options().jpeg_set_out_colorspace(colour));
    if let Samples::Eight(samples) = &mut samples {
        decoder.decode_into(samples).map_err(refusal)?;
    }
    Ok(Image { height, width, channels, samples })
}

/// Bytes of 1-bits, stuffed, that end entropy-coded data too early for the pixels declared: no Huffman code consists of ones alone.
const STOPPER: [u8; 64] = {
    let mut bytes = [0; 64];
    let mut at = 0;
    while at < bytes.len() {
        bytes[at] = 0xff;
        at += 2;
    }
    bytes
};

/// The image with a stopper before its end: the decoder fills what is missing before that marker with grey, and must not.
/// Progressive images are left as they are: their coarse first scan covers the whole picture.
fn stopped(data: &[u8]) -> Decoded<Vec<u8>> {
    let (end, progressive) = end_of_image(data)?;
    let stopper: &[u8] = if progressive { &[] } else { &STOPPER };
    Ok([&data[..end], stopper, &[0xff, END_OF_IMAGE]].concat())
}

/// Where the end-of-image marker is, following the markers from the start, and whether the image is progressive.
fn end_of_image(data: &[u8]) -> Decoded<(usize, bool)> {
    let (mut at, mut progressive) = (2, false);
    loop {
        at = next_marker(data, at).ok_or(TRUNCATED)?;
        match *data.get(at + 1).ok_or(TRUNCATED)? {
            END_OF_IMAGE => return Ok((at, progressive)),
            0xff => at += 1,
            0x00 | 0x01 | 0xd0..=0xd8 => at += 2,
            marker => {
                progressive |= marker == PROGRESSIVE;
                let length = data.get(at + 2..at + 4).ok_or(TRUNCATED)?;
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
        if at > data.len() {
            return Err(TRUNCATED.into());
        }
    }
}

/// The next byte of ones from `at` on, looked for in many at once.
fn next_marker(data: &[u8], at: usize) -> Option<usize> {
    const MANY: usize = 32;
    let (blocks, rest) = data.get(at..)?.as_chunks::<MANY>();
    let before = blocks.iter().position(|block| block.iter().fold(false, |found, &byte| found | (byte == 0xff)));
    let from = before.map_or(data.len() - rest.len(), |block| at + block * MANY);
    Some(from + data[from..].iter().position(|&byte| byte == 0xff)?)
}
