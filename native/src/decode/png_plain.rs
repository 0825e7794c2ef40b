//! PNG of 8 or 16 bit, grey or colour, not interlaced: nearly all there are, inflated at once. Whatever is unusual or damaged is left to
//! the decoder for all kinds, which says what is wrong; what is decoded here is what it would give.

use super::png_rows::unfilter;
use super::png_together::{rows_together, unfilter_together, MARGIN};
use super::samples::{Image, Samples};
use super::scratch::{with_inflation, Inflation};

const SIGNATURE: usize = 8;
/// Bytes of length, name and checksum around those of a chunk.
const FRAME: usize = 12;
/// Chunks that say nothing about the values of pixels.
const SILENT: [&[u8; 4]; 11] = [b"gAMA", b"cHRM", b"sRGB", b"pHYs", b"sBIT", b"bKGD", b"tIME", b"tEXt", b"zTXt", b"iTXt", b"iCCP"];
/// Bytes that one byte of deflated data can stand for, at most.
const LARGEST_RATIO: usize = 1032;
const WIDEST: usize = 1 << 20;

struct Header {
    width: usize,
    height: usize,
    /// Samples of a pixel as stored, alpha among them.
    stored: usize,
    bytes_per_sample: usize,
}

impl Header {
    fn of(body: &[u8]) -> Option<Header> {
        let &[w0, w1, w2, w3, h0, h1, h2, h3, bits, colour, 0, 0, 0] = body else { return None };
        let side = |bytes| usize::try_from(u32::from_be_bytes(bytes)).ok();
        let (width, height) = (side([w0, w1, w2, w3])?, side([h0, h1, h2, h3])?);
        let stored = match colour {
            0 => 1,
            2 => 3,
            4 => 2,
            6 => 4,
            _ => return None,
        };
        let known = matches!(bits, 8 | 16) && (1..=WIDEST).contains(&width) && height > 0;
        known.then_some(Header { width, height, stored, bytes_per_sample: usize::from(bits / 8) })
    }

    /// Bytes between a byte and that of the pixel on its left.
    fn step(&self) -> usize {
        self.stored * self.bytes_per_sample
    }

    fn row(&self) -> usize {
        self.width * self.step()
    }
}

/// None where it is not such a PNG, is damaged, or needs more than `limit` bytes.
pub fn decode(data: &[u8], limit: usize) -> Option<Image> {
    with_inflation(|Inflation { packed, rows, inflater }| {
        let header = unpacked(data, packed)?;
        let pixels = header.row().checked_mul(header.height).filter(|bytes| *bytes <= limit)?;
        let stored = pixels + header.height;
        if stored > packed.len().saturating_mul(LARGEST_RATIO) {
            return None;
        }
        rows.resize(stored + MARGIN, 0);
        if inflater.zlib_decompress(packed, &mut rows[..stored]).ok()? != stored {
            return None;
        }
        pixels_of(&header, rows)
    })
}

/// The chunks taken apart: the header, and in `packed` what the pixels are inflated from. None where a chunk is unusual or damaged.
fn unpacked(data: &[u8], packed: &mut Vec<u8>) -> Option<Header> {
    packed.clear();
    let (mut rest, mut header, mut ended) = (data.get(SIGNATURE..)?, None, false);
    loop {
        let length = usize::try_from(u32::from_be_bytes(*rest.first_chunk()?)).ok()?;
        let (chunk, after) = rest.split_at_checked(length.checked_add(FRAME)?)?;
        let (named, checksum) = chunk[4..].split_last_chunk()?;
        if crc32fast::hash(named) != u32::from_be_bytes(*checksum) {
            return None;
        }
        let (name, body) = named.split_first_chunk::<4>()?;
        match name {
            b"IHDR" if header.is_none() => header = Some(Header::of(body)?),
            b"IDAT" if header.is_some() && !ended => packed.extend_from_slice(body),
            b"IEND" if body.is_empty() && !packed.is_empty() => return header,
            name if header.is_some() && SILENT.contains(&name) => ended = !packed.is_empty(),
            _ => return None,
        }
        rest = after;
    }
}

/// From `rows` as stored, each after a byte that names its filter, and a margin after the last.
fn pixels_of(header: &Header, rows: &mut [u8]) -> Option<Image> {
    let (row, step) = (header.row(), header.step());
    let mut samples = match header.bytes_per_sample {
        1 => Samples::eight(row * header.height),
        _ => Samples::sixteen(row / 2 * header.height),
    };
    let together = rows_together(step);
    let (mut above, mut start, mut number) = (vec![0; row], 0, 0);
    while number < header.height {
        let count = together.filter(|count| number + count <= header.height).unwrap_or(1);
        let group = rows.get_mut(start..start + count * (row + 1) + MARGIN)?;
        if count == 1 || !unfilter_together(step, &above, group, header.width) {
            one_by_one(step, &above, &mut group[..count * (row + 1)])?;
        }
        for stored in group.chunks_exact(row + 1).take(count) {
            put(&mut samples, number * row, &stored[1..]);
            number += 1;
        }
        above.copy_from_slice(&group[count * (row + 1) - row..][..row]);
        start += count * (row + 1);
    }
    Some(Image::without_alpha((header.width, header.height), header.stored, samples))
}

fn one_by_one(step: usize, above: &[u8], rows: &mut [u8]) -> Option<()> {
    let mut above = above;
    for stored in rows.chunks_exact_mut(above.len() + 1) {
        let (filter, bytes) = stored.split_first_mut()?;
        if !unfilter(*filter, step, above, bytes) {
            return None;
        }
        above = bytes;
    }
    Some(())
}

/// `bytes` where they belong, `at` bytes from the first.
fn put(samples: &mut Samples, at: usize, bytes: &[u8]) {
    match samples {
        Samples::Eight(samples) => samples[at..at + bytes.len()].copy_from_slice(bytes),
        Samples::Sixteen(samples) => {
            let target = samples[at / 2..].iter_mut();
            target.zip(bytes.as_chunks().0).for_each(|(sample, pair)| *sample = u16::from_be_bytes(*pair));
        }
    }
}
