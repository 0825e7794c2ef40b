//! PGM and PPM, binary ("P5", "P6"), 8 and 16 bit: a few words of text, then the pixels.

use std::io::Read;

use super::lying::Lying;
use super::{Decoded, TRUNCATED};

/// Longest text, with its comments, before the pixels.
const LONGEST: usize = 4096;
const UNREADABLE: &str = "its data are corrupt (width, height and white do not stand at its beginning)";

pub fn size(source: impl Read) -> Decoded<(usize, usize)> {
    let mut start = Vec::new();
    source.take(LONGEST as u64).read_to_end(&mut start).map_err(|error| error.to_string())?;
    lying(&start).map(|lying| (lying.width, lying.height))
}

pub fn lying(data: &[u8]) -> Decoded<Lying> {
    let channels = if data.starts_with(b"P5") { 1 } else { 3 };
    let text = &data[..data.len().min(LONGEST)];
    let (width, at) = number(text, 2)?;
    let (height, at) = number(text, at)?;
    let (white, at) = number(text, at)?;
    let white = u32::try_from(white).ok().filter(|white| (1..=u32::from(u16::MAX)).contains(white)).ok_or(UNREADABLE)?;
    match text.get(at) {
        Some(byte) if byte.is_ascii_whitespace() => Ok(Lying { width, height, channels, start: at + 1, white, big_endian: true }),
        Some(_) => Err(UNREADABLE.into()),
        None => Err(TRUNCATED.into()),
    }
}

/// The number after white space and comments from `at` on, and where it ends.
fn number(text: &[u8], mut at: usize) -> Decoded<(usize, usize)> {
    let start = at;
    loop {
        match *text.get(at).ok_or(TRUNCATED)? {
            b'#' => at += text[at..].iter().position(|byte| b"\r\n".contains(byte)).ok_or(TRUNCATED)?,
            byte if byte.is_ascii_whitespace() => at += 1,
            _ => break,
        }
    }
    let digits = text[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number = std::str::from_utf8(&text[at..at + digits]).ok().and_then(|digits| digits.parse::<u32>().ok());
    match number {
        Some(number) if at > start => Ok((number as usize, at + digits)),
        _ => Err(UNREADABLE.into()),
    }
}
