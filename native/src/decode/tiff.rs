//! TIFF, first page: 1 to 16 bit grey, palette, 8 and 16 bit colour, in strips or tiles, uncompressed, PackBits, LZW or deflate.

use std::io::{BufRead, Cursor, ErrorKind, Seek};

use ::tiff::decoder::{BufferLayoutPreference, Decoder, DecodingResult, Limits};
use ::tiff::tags::{ByteOrder, PhotometricInterpretation, Tag};
use ::tiff::{ColorType, TiffError};

use super::samples::{unpacked, Image, Samples};
use super::{checked_bytes, tiff_directory, Decoded, LIMIT, TOO_LARGE, TRUNCATED};

fn refusal(error: TiffError) -> String {
    match error {
        TiffError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => TRUNCATED.into(),
        TiffError::LimitsExceeded => TOO_LARGE.into(),
        error => format!("its TIFF data are corrupt or of an unsupported kind ({error})"),
    }
}

fn dimensions<R: BufRead + Seek>(decoder: &mut Decoder<R>) -> Decoded<(usize, usize)> {
    let (width, height) = decoder.dimensions().map_err(refusal)?;
    Ok((width as usize, height as usize))
}

fn opened<R: BufRead + Seek>(mut source: R, limit: usize) -> Decoded<Decoder<R>> {
    tiff_directory::check(&mut source, limit)?;
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (limit, limit);
    Ok(Decoder::new(source).map_err(refusal)?.with_limits(limits))
}

pub fn size(source: impl BufRead + Seek) -> Decoded<(usize, usize)> {
    dimensions(&mut opened(source, LIMIT)?)
}

pub fn decode(data: &[u8], limit: usize) -> Decoded<Image> {
    let mut decoder = opened(Cursor::new(data), limit)?;
    if decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(refusal)?
        == Some(PhotometricInterpretation::RGBPalette.to_u16())
    {
        let palette = palette(&mut decoder)?;
        let mut indices = opened(Cursor::new(as_grey(data, &mut decoder)?), limit)?;
        return match decoded(&mut indices, limit, false)? {
            Image { width, height, channels: 1, samples: Samples::Eight(indices) } => {
                Image::from_palette((width, height), &indices, &palette)
            }
            _ => Err("its palette has more than 256 colours".into()),
        };
    }
    decoded(&mut decoder, limit, true)
}

fn decoded<R: BufRead + Seek>(decoder: &mut Decoder<R>, limit: usize, full_scale: bool) -> Decoded<Image> {
    let (width, height) = dimensions(decoder)?;
    let (stored, bits) = match decoder.colortype().map_err(refusal)? {
        ColorType::Gray(bits) => (1, bits),
        ColorType::RGB(bits) => (3, bits),
        ColorType::RGBA(bits) => (4, bits),
        ColorType::Multiband { bit_depth, num_samples: 2 } => (2, bit_depth),
        other => return Err(format!("its TIFF colour type {other:?} is not supported; grey, palette or RGB is expected")),
    };
    checked_bytes(width, height, stored * usize::from(bits).div_ceil(8), limit)?;
    let mut result = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut result).map_err(refusal)?;
    let samples = match (result, bits) {
        (DecodingResult::U8(packed), 1 | 2 | 4) if stored == 1 => {
            let scale = if full_scale { 255 / ((1u16 << bits) - 1) as u8 } else { 1 };
            let stride = (width * usize::from(bits)).div_ceil(8);
            Samples::Eight(unpacked(&packed, width, bits.into(), stride).into_iter().map(|sample| sample * scale).collect())
        }
        (DecodingResult::U8(samples), 8) => Samples::Eight(interleaved(samples, &layout)),
        (DecodingResult::U16(samples), 16) => Samples::Sixteen(interleaved(samples, &layout)),
        _ => return Err(format!("its TIFF samples ({bits} bit) are not supported; 8 or 16 bit unsigned integers are expected")),
    };
    Ok(Image::without_alpha((width, height), stored, samples))
}

/// Planes stored one after the other become pixels.
fn interleaved<T: Copy>(samples: Vec<T>, layout: &BufferLayoutPreference) -> Vec<T> {
    if layout.planes < 2 {
        return samples;
    }
    let plane = samples.len() / layout.planes;
    (0..plane).flat_map(|pixel| (0..layout.planes).map(move |band| band * plane + pixel)).map(|index| samples[index]).collect()
}

fn palette(decoder: &mut Decoder<Cursor<&[u8]>>) -> Decoded<Vec<[u8; 3]>> {
    let map = decoder.get_tag_u16_vec(Tag::ColorMap).map_err(refusal)?;
    let colours = map.len() / 3;
    let shift = if map.iter().all(|&level| level < 256) { 0 } else { 8 }; // some writers forget that the map has 16 bits
    let channel = |index: usize| (map[index] >> shift) as u8;
    Ok((0..colours).map(|index| [channel(index), channel(colours + index), channel(2 * colours + index)]).collect())
}

/// A copy of the file that calls its palette indices grey levels: the decoder knows no palettes.
fn as_grey(data: &[u8], decoder: &mut Decoder<Cursor<&[u8]>>) -> Decoded<Vec<u8>> {
    let big_endian = decoder.byte_order() == ByteOrder::BigEndian;
    let number = |bytes: &[u8]| match big_endian {
        true => u16::from_be_bytes([bytes[0], bytes[1]]),
        false => u16::from_le_bytes([bytes[0], bytes[1]]),
    };
    let big_tiff = data.get(2..4).map(number) == Some(43);
    let (count_bytes, entry_bytes, value_at) = if big_tiff { (8, 20, 12) } else { (2, 12, 8) };
    let start = decoder.ifd_pointer().ok_or(TRUNCATED)?.0 as usize + count_bytes;
    let mut copy = data.to_vec();
    let entry = copy.get_mut(start..).ok_or(TRUNCATED)?.chunks_exact_mut(entry_bytes);
    let entry = entry.into_iter().find(|entry| number(entry) == Tag::PhotometricInterpretation.to_u16()).ok_or(TRUNCATED)?;
    let grey = PhotometricInterpretation::BlackIsZero.to_u16();
    entry[value_at..value_at + 2].copy_from_slice(&if big_endian { grey.to_be_bytes() } else { grey.to_le_bytes() });
    Ok(copy)
}
