//! Several PNG rows freed of their filters together. A byte's prediction waits for the byte on its left, so one row alone leaves a
//! processor idle; here every row is a pixel behind the row above it, which then has all that the prediction needs.

#[cfg(target_arch = "x86_64")]
use std::arch::is_x86_feature_detected;

/// Bytes in work: one pixel of each of the rows.
const BYTES: usize = 16;
/// Bytes after the rows that are read with their last pixels, and left as they are.
pub const MARGIN: usize = 8;
const PAETH: u8 = 4;
const WHOLE: i16 = 255;

/// How many rows of pixels of `step` bytes are unfiltered together; none where they are better unfiltered one by one.
pub fn rows_together(step: usize) -> Option<usize> {
    #[cfg(target_arch = "x86_64")]
    let wide = is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    let wide = false;
    wide.then(|| BYTES / step.next_power_of_two())
}

/// `rows` become their bytes: as many as `rows_together` says, each `width` pixels after a byte that names its filter, then `MARGIN` bytes.
/// False, and nothing done, where they are better unfiltered one by one, or a filter does not exist.
pub fn unfilter_together(step: usize, above: &[u8], rows: &mut [u8], width: usize) -> bool {
    let filters = || rows[..rows.len() - MARGIN].iter().step_by(width * step + 1);
    if filters().any(|&filter| filter > PAETH) || filters().all(|&filter| filter < PAETH) {
        return false;
    }
    match step {
        1 => wide::<1, 1>(above, rows, width),
        2 => wide::<2, 2>(above, rows, width),
        3 => wide::<3, 4>(above, rows, width),
        4 => wide::<4, 4>(above, rows, width),
        6 => wide::<6, 8>(above, rows, width),
        8 => wide::<8, 8>(above, rows, width),
        _ => return false,
    }
    true
}

/// In vector instructions where there are any.
fn wide<const STEP: usize, const LANES: usize>(above: &[u8], rows: &mut [u8], width: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn wider<const STEP: usize, const LANES: usize>(above: &[u8], rows: &mut [u8], width: usize) {
            together::<STEP, LANES>(above, rows, width);
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs
            return unsafe { wider::<STEP, LANES>(above, rows, width) };
        }
    }
    together::<STEP, LANES>(above, rows, width);
}

#[inline(always)]
fn together<const STEP: usize, const LANES: usize>(above: &[u8], rows: &mut [u8], width: usize) {
    let (count, stride) = (BYTES / LANES, width * STEP + 1);
    let mut filters = [[0; BYTES]; PAETH as usize];
    for row in 0..count {
        if let Some(filter) = usize::from(rows[row * stride]).checked_sub(1) {
            filters[filter][row * LANES..][..LANES].fill(-1);
        }
    }
    let mut wave = Wave::<STEP, LANES> { filters, left: [0; BYTES], corner: [0; BYTES], stride, width };
    let all_begun = (count - 1).min(width);
    for time in 0..all_begun {
        wave.advance::<true>(time, above, rows);
    }
    for time in all_begun..width {
        wave.advance::<false>(time, above, rows);
    }
    for time in width..width + count - 1 {
        wave.advance::<true>(time, above, rows);
    }
}

/// Where the rows are: row r at pixel time - r.
struct Wave<const STEP: usize, const LANES: usize> {
    /// All bits set for the bytes of rows with filter 1, 2, 3, 4.
    filters: [[i16; BYTES]; PAETH as usize],
    left: [i16; BYTES],
    corner: [i16; BYTES],
    stride: usize,
    width: usize,
}

impl<const STEP: usize, const LANES: usize> Wave<STEP, LANES> {
    /// One pixel of every row; on the `EDGE`, of those that have one then.
    #[inline(always)]
    fn advance<const EDGE: bool>(&mut self, time: usize, above: &[u8], rows: &mut [u8]) {
        let (width, stride) = (self.width, self.stride);
        let seen = |row: usize| !EDGE || (row..row + width).contains(&time);
        let place = |row: usize| row * stride + 1 + (time - row) * STEP;
        let (mut words, mut kept, mut top) = ([0u64; BYTES / 8], [if EDGE { 0 } else { WHOLE }; BYTES], [0; LANES]);
        for row in 0..BYTES / LANES {
            if seen(row) {
                let mut pixel = [0; 8];
                pixel[..LANES].copy_from_slice(&rows[place(row)..][..LANES]);
                words[row * LANES / 8] |= u64::from_le_bytes(pixel) << (8 * (row * LANES % 8));
                if EDGE {
                    kept[row * LANES..][..LANES].fill(WHOLE);
                }
            }
        }
        if seen(0) {
            top[..STEP].copy_from_slice(&above[time * STEP..][..STEP]);
        }
        self.unfilter(&mut words, &kept, &top);
        for row in 0..BYTES / LANES {
            if seen(row) {
                let pixel = (words[row * LANES / 8] >> (8 * (row * LANES % 8))).to_le_bytes();
                rows[place(row)..][..STEP].copy_from_slice(&pixel[..STEP]);
            }
        }
    }

    /// The bytes in `words` become those that they were stored for, `top` above those of the first row; zero where nothing is `kept`.
    #[inline(always)]
    fn unfilter(&mut self, words: &mut [u64; BYTES / 8], kept: &[i16; BYTES], top: &[u8; LANES]) {
        let (left, corner, mut up, mut values, mut bytes) = (self.left, self.corner, [0; BYTES], [0; BYTES], [0; BYTES]);
        for k in 0..BYTES {
            up[k] = if k < LANES { i16::from(top[k]) } else { left[k - LANES] };
        }
        for (eight, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(&*words) {
            *eight = word.to_le_bytes();
        }
        let [sub, above, average, by_paeth] = &self.filters;
        for k in 0..BYTES {
            let (a, b, c) = (left[k], up[k], corner[k]);
            let (from_left, from_up) = (b - c, a - c);
            let (from_left, from_up, from_corner) = (from_left.abs(), from_up.abs(), (from_left + from_up).abs());
            let nearer = if from_up <= from_corner { b } else { c };
            let paeth = if from_left <= from_up.min(from_corner) { a } else { nearer };
            let predicted = (a & sub[k]) | (b & above[k]) | (((a + b) >> 1) & average[k]) | (paeth & by_paeth[k]);
            values[k] = (i16::from(bytes[k]) + predicted) & kept[k];
        }
        for (byte, value) in bytes.iter_mut().zip(&values) {
            *byte = *value as u8;
        }
        (self.corner, self.left) = (up, values);
        for (word, eight) in words.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*eight);
        }
    }
}
