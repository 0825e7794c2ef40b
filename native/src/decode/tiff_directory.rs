//! What a TIFF file says about itself before a decoder believes it: no entry of its first directory may claim more values than the file
//! holds, for memory is set aside for them. Nor may one of a BigTIFF be of an unknown type: the decoder would skip half of it, and take for
//! entries what lies between them.

use std::io::{Read, Seek, SeekFrom};

use super::{Decoded, TOO_LARGE, TRUNCATED};

/// Bytes of a value of each type: BYTE, ASCII, SHORT, LONG, RATIONAL, SBYTE, ... IFD8.
const TYPES: [u64; 19] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8];
/// Bytes that the decoder keeps of one value, and that it may in any case.
const KEPT: u64 = 32;
const ALWAYS: u64 = 1 << 20;
const BIG: u64 = 43;

struct Source<R> {
    source: R,
    big_endian: bool,
}

impl<R: Read + Seek> Source<R> {
    fn number(&mut self, bytes: usize) -> Decoded<u64> {
        let mut buffer = [0; 8];
        let part = if self.big_endian { &mut buffer[8 - bytes..] } else { &mut buffer[..bytes] };
        self.source.read_exact(part).map_err(|_| TRUNCATED)?;
        Ok(if self.big_endian { u64::from_be_bytes(buffer) } else { u64::from_le_bytes(buffer) })
    }

    fn go(&mut self, place: SeekFrom) -> Decoded<u64> {
        self.source.seek(place).map_err(|_| TRUNCATED.into())
    }
}

/// Leaves `source` at its beginning; refuses it where the values of an entry are not in it, or need more than `limit` bytes.
pub fn check<R: Read + Seek>(source: R, limit: usize) -> Decoded<()> {
    let mut source = Source { source, big_endian: false };
    let length = source.go(SeekFrom::End(0))?;
    source.go(SeekFrom::Start(0))?;
    source.big_endian = source.number(2)? == u64::from(u16::from_le_bytes(*b"MM"));
    let big = source.number(2)? == BIG;
    let (many, wide) = if big { (8, 8) } else { (2, 4) };
    source.go(SeekFrom::Start(if big { 8 } else { 4 }))?;
    let directory = source.number(wide)?;
    source.go(SeekFrom::Start(directory))?;
    for _ in 0..source.number(many)? {
        let tag = source.number(2)?;
        let (kind, count) = (source.number(2)?, source.number(wide)?);
        source.number(wide)?;
        let each = usize::try_from(kind).ok().and_then(|kind| TYPES.get(kind)).map_or(0, |bytes| *bytes);
        if big && each == 0 {
            return Err(format!("the entry {tag} of its directory is of the type {kind}, which TIFF does not know"));
        }
        if count.saturating_mul(each) > length {
            return Err(TRUNCATED.into());
        }
        if count.saturating_mul(KEPT) > ALWAYS.max(limit as u64) && each > 0 {
            return Err(TOO_LARGE.into());
        }
    }
    source.go(SeekFrom::Start(0)).map(|_| ())
}
