//! Decoded pixels and the few rearrangements that several formats share.

use super::{scratch, Decoded};

pub enum Samples {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

impl Samples {
    /// For `count` samples that are all to be written: they may hold those of an earlier picture.
    pub fn eight(count: usize) -> Samples {
        let Some(Samples::Eight(mut samples)) = scratch::samples() else { return Samples::Eight(vec![0; count]) };
        samples.resize(count, 0);
        Samples::Eight(samples)
    }

    /// As `eight`.
    pub fn sixteen(count: usize) -> Samples {
        let Some(Samples::Sixteen(mut samples)) = scratch::samples() else { return Samples::Sixteen(vec![0; count]) };
        samples.resize(count, 0);
        Samples::Sixteen(samples)
    }
}

/// Pixels in rows from the top, `channels` (1 or 3) samples each.
pub struct Image {
    pub height: usize,
    pub width: usize,
    pub channels: usize,
    pub samples: Samples,
}

impl Image {
    /// From pixels of `stored` samples: one or two are grey (+ alpha), three or four colour (+ alpha). Alpha is dropped.
    pub fn without_alpha((width, height): (usize, usize), stored: usize, samples: Samples) -> Image {
        let channels = if stored < 3 { 1 } else { 3 };
        let samples = match samples {
            Samples::Eight(samples) => Samples::Eight(first_channels(samples, stored, channels)),
            Samples::Sixteen(samples) => Samples::Sixteen(first_channels(samples, stored, channels)),
        };
        Image { height, width, channels, samples }
    }

    /// From one palette index per pixel: colour, or grey where the whole palette is grey.
    pub fn from_palette((width, height): (usize, usize), indices: &[u8], palette: &[[u8; 3]]) -> Decoded<Image> {
        if indices.iter().any(|&index| usize::from(index) >= palette.len()) {
            return Err("its data are corrupt (a pixel names a colour that is not in the palette)".into());
        }
        let grey = palette.iter().all(|colour| colour[0] == colour[1] && colour[1] == colour[2]);
        let colour_of = |index: &u8| palette[usize::from(*index)];
        let (channels, samples) = match grey {
            true => (1, indices.iter().map(|index| colour_of(index)[0]).collect()),
            false => (3, indices.iter().map(colour_of).collect::<Vec<_>>().into_flattened()),
        };
        Ok(Image { height, width, channels, samples: Samples::Eight(samples) })
    }
}

/// Three planes of one colour each as pixels.
pub fn interleaved<T: Copy + Default>(planes: [&[T]; 3]) -> Vec<T> {
    let mut samples = vec![T::default(); 3 * planes[0].len()];
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn wide<T: Copy>(planes: [&[T]; 3], samples: &mut [T]) {
            interleave(planes, samples);
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs
            unsafe { wide(planes, &mut samples) };
            return samples;
        }
    }
    interleave(planes, &mut samples);
    samples
}

#[inline(always)]
fn interleave<T: Copy>([red, green, blue]: [&[T]; 3], samples: &mut [T]) {
    for (((pixel, red), green), blue) in samples.as_chunks_mut().0.iter_mut().zip(red).zip(green).zip(blue) {
        *pixel = [*red, *green, *blue];
    }
}

fn first_channels<T: Copy>(mut samples: Vec<T>, stored: usize, kept: usize) -> Vec<T> {
    if stored == kept {
        return samples;
    }
    let pixels = samples.len() / stored;
    for pixel in 0..pixels {
        samples.copy_within(pixel * stored..pixel * stored + kept, pixel * kept);
    }
    samples.truncate(pixels * kept);
    samples
}

/// Samples of `bits` (1, 2, 4 or 8) bits, most significant first, one byte each; every row starts on a byte, `stride` bytes apart.
pub fn unpacked(packed: &[u8], width: usize, bits: usize, stride: usize) -> Vec<u8> {
    let (per_byte, mask) = (8 / bits, ((1u16 << bits) - 1) as u8);
    let sample = |row: &[u8], column: usize| row[column / per_byte] >> (8 - bits * (column % per_byte + 1)) & mask;
    let mut samples = vec![0; packed.len() / stride * width];
    for (row, target) in packed.chunks_exact(stride).zip(samples.chunks_exact_mut(width)) {
        for (column, target) in target.iter_mut().enumerate() {
            *target = sample(row, column);
        }
    }
    samples
}
