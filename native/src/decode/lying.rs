//! Pixels that lie uncompressed in a file, row after row without gaps.

use super::samples::{Image, Samples};
use super::{checked_bytes, Decoded, TRUNCATED};

const WHITE: [u32; 2] = [u8::MAX as u32, u16::MAX as u32];

/// Where and how. `white` is the level that counts as white, the largest there may be.
#[derive(Clone, Copy)]
pub struct Lying {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub start: usize,
    pub white: u32,
    pub big_endian: bool,
}

impl Lying {
    fn sixteen(&self) -> bool {
        self.white > WHITE[0]
    }

    /// The bytes of all pixels, refused where they exceed `limit` or the data end before them.
    fn bytes<'a>(&self, data: &'a [u8], limit: usize) -> Decoded<&'a [u8]> {
        let per_pixel = self.channels * if self.sixteen() { 2 } else { 1 };
        let count = checked_bytes(self.width, self.height, per_pixel, limit)?;
        Ok(data.get(self.start..).and_then(|rest| rest.get(..count)).ok_or(TRUNCATED)?)
    }

    /// Pixels that can be used where they are: 8 bit, white is white.
    pub fn ready<'a>(&self, data: &'a [u8], limit: usize) -> Option<&'a [u8]> {
        if self.white == WHITE[0] {
            self.bytes(data, limit).ok()
        } else {
            None
        }
    }

    pub fn image(&self, data: &[u8], limit: usize) -> Decoded<Image> {
        let bytes = self.bytes(data, limit)?;
        let samples = match (self.sixteen(), self.white) {
            (false, white) if white == WHITE[0] => Samples::Eight(bytes.to_vec()),
            (false, white) => Samples::Eight(scaled(bytes.iter().map(|&byte| byte.into()), white, WHITE[0])?),
            (true, white) => {
                let order = if self.big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
                let levels = bytes.as_chunks().0.iter().map(|&pair| order(pair));
                Samples::Sixteen(match white == WHITE[1] {
                    true => levels.collect(),
                    false => scaled(levels.map(u32::from), white, WHITE[1])?,
                })
            }
        };
        Ok(Image { height: self.height, width: self.width, channels: self.channels, samples })
    }
}

/// Levels of 0 to `white` on the scale of 0 to `full`, rounded half up.
fn scaled<T: TryFrom<u32>>(levels: impl Iterator<Item = u32>, white: u32, full: u32) -> Decoded<Vec<T>> {
    let brighter = || format!("its data are corrupt (a pixel is brighter than the white of {white})");
    let scale = |level: u32| T::try_from((level * full + white / 2) / white).map_err(|_| brighter());
    levels.map(scale).collect()
}
