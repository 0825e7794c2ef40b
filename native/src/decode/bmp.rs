//! BMP, uncompressed: 1, 4 and 8 bit palettes, 16, 24 and 32 bit colour.

use std::io::{Read, Seek};

use super::samples::{unpacked, Image, Samples};
use super::{checked_bytes, Decoded, TRUNCATED};

const FILE_HEADER: usize = 14;
const CORE_HEADER: usize = 12;
const INFO_HEADER: usize = 40;
const UNCOMPRESSED: u32 = 0;
const BIT_FIELDS: [u32; 2] = [3, 6];

struct Header {
    width: usize,
    height: usize,
    top_down: bool,
    bits: usize,
    compression: u32,
    /// Length of the information header, which ends where masks or the palette begin.
    length: usize,
    /// Where the pixels begin.
    pixels_at: usize,
    colours: usize,
}

fn u16_at(data: &[u8], at: usize) -> Decoded<u16> {
    let bytes = data.get(at..at + 2).ok_or(TRUNCATED)?;
    Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn u32_at(data: &[u8], at: usize) -> Decoded<u32> {
    Ok(u32::from(u16_at(data, at)?) | u32::from(u16_at(data, at + 2)?) << 16)
}

fn header(data: &[u8]) -> Decoded<Header> {
    let (pixels_at, length) = (u32_at(data, 10)? as usize, u32_at(data, FILE_HEADER)? as usize);
    if length == CORE_HEADER {
        let (width, height) = (u16_at(data, 18)?.into(), u16_at(data, 20)?.into());
        let bits = u16_at(data, 24)?.into();
        return Ok(Header { width, height, top_down: false, bits, compression: UNCOMPRESSED, length, pixels_at, colours: 0 });
    }
    if length < INFO_HEADER {
        return Err(format!("its BMP header of {length} bytes is of an unsupported kind"));
    }
    let (width, height) = (u32_at(data, 18)? as i32, u32_at(data, 22)? as i32);
    if width < 0 || height == i32::MIN {
        return Err(format!("it declares {width} x {height} pixels"));
    }
    let (bits, compression, colours) = (u16_at(data, 28)?.into(), u32_at(data, 30)?, u32_at(data, 46)? as usize);
    let (top_down, height) = (height < 0, height.unsigned_abs() as usize);
    Ok(Header { width: width as usize, height, top_down, bits, compression, length, pixels_at, colours })
}

pub fn size(source: impl Read + Seek) -> Decoded<(usize, usize)> {
    let mut start = Vec::new();
    source.take((FILE_HEADER + INFO_HEADER) as u64).read_to_end(&mut start).map_err(|_| TRUNCATED)?;
    let header = header(&start)?;
    Ok((header.width, header.height))
}

pub fn decode(data: &[u8], limit: usize) -> Decoded<Image> {
    let header = header(data)?;
    let known = match header.bits {
        1 | 4 | 8 | 24 => header.compression == UNCOMPRESSED,
        16 | 32 => header.compression == UNCOMPRESSED || BIT_FIELDS.contains(&header.compression),
        _ => false,
    };
    if !known {
        let (bits, compression) = (header.bits, header.compression);
        return Err(format!("it is a BMP of an unsupported kind ({bits} bit, compression {compression}); save it uncompressed"));
    }
    checked_bytes(header.width, header.height, 3, limit)?;
    let stride = (header.width * header.bits).div_ceil(32) * 4;
    let pixels = data.get(header.pixels_at..).and_then(|rest| rest.get(..stride * header.height)).ok_or(TRUNCATED)?;
    let mut rows: Vec<&[u8]> = pixels.chunks_exact(stride).collect();
    if !header.top_down {
        rows.reverse();
    }
    let size = (header.width, header.height);
    match header.bits {
        24 => Ok(colour(size, &rows, 3, |pixel| [pixel[2], pixel[1], pixel[0]])),
        16 | 32 => masked(data, &header, &rows),
        bits => Image::from_palette(size, &unpacked(&rows.concat(), size.0, bits, stride), &palette(data, &header)?),
    }
}

fn colour((width, height): (usize, usize), rows: &[&[u8]], bytes: usize, colour_of: impl Fn(&[u8]) -> [u8; 3]) -> Image {
    let mut samples = vec![0; width * height * 3];
    for (row, target) in rows.iter().zip(samples.chunks_exact_mut(width * 3)) {
        for (pixel, target) in row.chunks_exact(bytes).zip(target.chunks_exact_mut(3)) {
            target.copy_from_slice(&colour_of(pixel));
        }
    }
    Image { height, width, channels: 3, samples: Samples::Eight(samples) }
}

fn palette(data: &[u8], header: &Header) -> Decoded<Vec<[u8; 3]>> {
    let entry = if header.length == CORE_HEADER { 3 } else { 4 };
    let colours = if header.colours == 0 { 1 << header.bits } else { header.colours.min(1 << header.bits) };
    let start = FILE_HEADER.saturating_add(header.length);
    let entries = data.get(start..).and_then(|rest| rest.get(..colours * entry)).ok_or(TRUNCATED)?;
    Ok(entries.chunks_exact(entry).map(|colour| [colour[2], colour[1], colour[0]]).collect())
}

/// Red, green and blue as fields of 16 or 32 bit numbers, scaled to 8 bits.
fn masked(data: &[u8], header: &Header, rows: &[&[u8]]) -> Decoded<Image> {
    let masks = masks(data, header)?;
    let level = |number: u32, mask: u32| {
        let (shift, largest) = (mask.trailing_zeros(), u64::from(mask >> mask.trailing_zeros()));
        ((u64::from((number & mask) >> shift) * 255 + largest / 2) / largest) as u8
    };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte));
    let colour_of = |pixel: &[u8]| masks.map(|mask| level(number(pixel), mask));
    Ok(colour((header.width, header.height), rows, header.bits / 8, colour_of))
}

fn masks(data: &[u8], header: &Header) -> Decoded<[u32; 3]> {
    if header.compression == UNCOMPRESSED {
        return Ok(if header.bits == 16 { [0x7c00, 0x03e0, 0x001f] } else { [0x00ff_0000, 0x0000_ff00, 0x0000_00ff] });
    }
    let at = FILE_HEADER + INFO_HEADER;
    let masks = [u32_at(data, at)?, u32_at(data, at + 4)?, u32_at(data, at + 8)?];
    match masks.contains(&0) {
        true => Err("its data are corrupt (a colour without bits)".into()),
        false => Ok(masks),
    }
}
