//! TIFF, first page: 1 to 16 bit grey, palette, 8 and 16 bit colour, in strips or tiles, uncompressed, PackBits, LZW or deflate.

use std::io::{BufRead, Cursor, ErrorKind, Seek};

use ::tiff::decoder::{BufferLayoutPreference, Decoder, DecodingResult, Limits};
use ::tiff::tags::{ByteOrder, PhotometricInterpretation, Tag};
use ::tiff::{ColorType, TiffError};

use super::lying::Lying;
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

/// Where the pixels lie if they are uncompressed grey or colour of 8 or 16 bit in strips one after the other; none where they are not, or
/// the file is unusual in any way.
pub fn lying(data: &[u8]) -> Option<Lying> {
    let mut decoder = opened(Cursor::new(data), 0).ok()?;
    let (width, height) = dimensions(&mut decoder).ok()?;
    let (channels, bits, light) = match decoder.colortype().ok()? {
        ColorType::Gray(bits @ (8 | 16)) => (1, bits, PhotometricInterpretation::BlackIsZero),
        ColorType::RGB(bits @ (8 | 16)) => (3, bits, PhotometricInterpretation::RGB),
        _ => return None,
    };
    let mut number = |tag| decoder.find_tag_unsigned::<u16>(tag).ok();
    let plain = [(Tag::Compression, 1), (Tag::Predictor, 1), (Tag::PlanarConfiguration, 1), (Tag::FillOrder, 1), (Tag::SampleFormat, 1)];
    for (tag, usual) in plain {
        if number(tag)?.is_some_and(|value| value != usual) {
            return None;
        }
    }
    if number(Tag::PhotometricInterpretation)? != Some(light.to_u16()) || number(Tag::TileWidth)?.is_some() {
        return None;
    }
    let places = decoder.get_tag_u64_vec(Tag::StripOffsets).ok()?;
    let counts = decoder.get_tag_u64_vec(Tag::StripByteCounts).ok()?;
    let row = (width * channels * usize::from(bits / 8)) as u64;
    let rows = decoder.find_tag_unsigned::<u32>(Tag::RowsPerStrip).ok()?.map_or(height as u64, |rows| u64::from(rows).min(height as u64));
    let (mut next, mut left) = (*places.first()?, height as u64);
    for (place, count) in places.iter().zip(&counts) {
        if *place != next || left == 0 || *count != rows.min(left) * row {
            return None;
        }
        (next, left) = (place.checked_add(*count)?, left - rows.min(left));
    }
    let big_endian = decoder.byte_order() == ByteOrder::BigEndian;
    let white = if bits == 8 { u8::MAX.into() } else { u16::MAX.into() };
    let lying = Lying { width, height, channels, start: places[0] as usize, white, big_endian };
    (left == 0 && places.len() == counts.len()).then_some(lying)
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
