//! Brightness along a ray: nearest pixel to find where a peak may be, bilinear there (see the Python module `_picture`).

use std::ops::BitAnd;

use super::rays::{Ray, Track, ONE};
use super::vectors::Vectors;
use super::walk::{bilinear, GROUP};

/// A grey value of 8 or 16 bits.
pub trait Grey:
    Copy + PartialOrd + BitAnd<Output = Self> + Into<f64> + Into<i64> + Into<u32> + TryFrom<u32> + Default + Send + Sync + 'static
{
    const WHITE: u32;
    /// White at every `pace`-th value, black between: those of one band in a row of one or three, or the samples of it that are looked at.
    fn white_at_every(pace: usize) -> Option<&'static [Self; BLOCK]>;

    #[inline(always)]
    fn level(self) -> u32 {
        self.into()
    }

    /// The first of some values in the lowest bits, that `bands` (= `BANDS` unless 0) after it in the highest.
    fn pair<const BANDS: usize>(values: &[Self], bands: usize) -> u32;
}

/// Only every second sample is looked at to find bright ones: of the three that can make a peak lit, one is among them.
pub const STRIDE: usize = 2;
/// Values of a picture row looked at together: a whole number of vectors, and of strides over one or three bands.
pub const BLOCK: usize = 96;

macro_rules! white_at_every {
    ($kind:ident, $pace:expr) => {{
        let (mut row, mut at) = ([0; BLOCK], 0);
        while at < BLOCK {
            row[at] = $kind::MAX;
            at += $pace;
        }
        row
    }};
}

macro_rules! grey {
    ($($kind:ident $pair:item),*) => {$(
        impl Grey for $kind {
            const WHITE: u32 = $kind::MAX as u32;
            fn white_at_every(pace: usize) -> Option<&'static [Self; BLOCK]> {
                static ROWS: [[$kind; BLOCK]; 4] =
                    [white_at_every!($kind, 1), white_at_every!($kind, STRIDE), white_at_every!($kind, 3), white_at_every!($kind, 3 * STRIDE)];
                [1, STRIDE, 3, 3 * STRIDE].iter().position(|known| *known == pace).map(|which| &ROWS[which])
            }
            #[inline(always)]
            $pair
        }
    )*};
}

grey!(
    u8
    fn pair<const BANDS: usize>(values: &[u8], bands: usize) -> u32 {
        if BANDS == 3 {
            values.first_chunk().map_or(0, |four| u32::from_le_bytes(*four))
        } else {
            u32::from(values[0]) | u32::from(values[bands]) << 24
        }
    },
    u16
    fn pair<const BANDS: usize>(values: &[u16], bands: usize) -> u32 {
        u32::from(values[0]) | u32::from(values[bands]) << 16
    }
);

/// One colour band of an image in memory: `data[(row * width + column) * bands + band]`.
pub struct Plane<'a, T> {
    pub data: &'a [T],
    pub width: usize,
    pub height: usize,
    pub bands: usize,
    pub band: usize,
    pub vectors: Vectors,
}

impl<T: Grey> Plane<'_, T> {
    /// Where in `data` a pixel of the band lies.
    #[inline(always)]
    pub fn index(&self, column: usize, row: usize) -> usize {
        (row * self.width + column) * self.bands + self.band
    }

    /// Bilinear brightness at a place in fixed point that is inside, exact for places rounded down to 2^-16 px.
    fn bilinear_at(&self, [column, row]: [i64; 2]) -> f64 {
        const PART: i64 = 1 << 16;
        let (mut left, mut top) = (column >> 32, row >> 32);
        let (mut x, mut y) = (i64::from(column as u32 >> 16), i64::from(row as u32 >> 16));
        if left == self.width as i64 - 1 {
            (left, x) = (left - 1, PART);
        }
        if top == self.height as i64 - 1 {
            (top, y) = (top - 1, PART);
        }
        let at = self.index(left as usize, top as usize);
        let upper = &self.data[at..at + self.bands + 1];
        let at = at + self.width * self.bands;
        let lower = &self.data[at..at + self.bands + 1];
        let between = |pair: &[T]| -> i64 {
            let (a, b): (i64, i64) = (pair[0].into(), pair[self.bands].into());
            a * PART + x * (b - a)
        };
        let (upper, lower) = (between(upper), between(lower));
        (upper * PART + y * (lower - upper)) as f64 * (1.0 / ONE as f64)
    }

    /// The pixels that the samples from `first` on fall on, where a track runs along a row or down a column: the nearest and the
    /// bilinear brightness are theirs.
    #[inline(always)]
    pub fn aligned(&self, track: &Track, first: usize) -> Option<(&[T], usize)> {
        let pace = match track.step {
            [ONE, 0] => self.bands,
            [0, ONE] => self.bands * self.width,
            _ => return None,
        };
        let at = track.at(first);
        let whole = at.iter().all(|place| *place >= 0 && *place & (ONE - 1) == 0);
        whole.then(|| (self.data.get(self.index((at[0] >> 32) as usize, (at[1] >> 32) as usize)..).unwrap_or(&[]), pace))
    }

    /// Bilinear brightness of all samples of a ray, NaN outside the picture, in `values` with room for a group behind them.
    pub fn whole<'a>(&self, ray: &Ray, values: &'a mut [f64]) -> &'a [f64] {
        let (track, samples) = (ray.track(), values.len() - GROUP);
        let (first, end) = track.inside(self.width, self.height, samples);
        values.fill(f64::NAN);
        if first < end {
            self.interpolate(&track, (first, end), values);
            values[end..].fill(f64::NAN);
        }
        &values[..samples]
    }

    /// Bilinear brightness of the samples from `first` to before `end`, all of which are inside, at their places among the `values`.
    pub fn interpolate(&self, track: &Track, (first, end): (usize, usize), values: &mut [f64]) {
        if let Some((pixels, pace)) = self.aligned(track, first) {
            values[first..end].iter_mut().zip(pixels.iter().step_by(pace)).for_each(|(value, pixel)| *value = (*pixel).into());
            return;
        }
        let last = [(self.width as i64 - 1) * ONE, (self.height as i64 - 1) * ONE];
        let on_edge = |at: [i64; 2]| at[0] >= last[0] || at[1] >= last[1];
        if on_edge(track.at(first)) || on_edge(track.at(end)) {
            values[first..end].iter_mut().zip(first..).for_each(|(value, sample)| *value = self.bilinear_at(track.at(sample)));
        } else {
            bilinear(self, (track.at(first), track.step), end - first, &mut values[first..]);
        }
    }
}

/// Luma of interleaved red, green, blue in thousandths (ITU-R BT.601), rounded half up.
pub fn luma<T: Grey>(data: &[T]) -> Vec<T> {
    let weigh = |p: &[T]| {
        let (red, green, blue) = (p[0].level(), p[1].level(), p[2].level());
        T::try_from((299 * red + 587 * green + 114 * blue + 500) / 1000).unwrap_or_default()
    };
    data.chunks_exact(3).map(weigh).collect()
}
