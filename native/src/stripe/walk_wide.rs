//! Samples along a track, four at a time by AVX2: the same numbers as in `walk`.

use std::arch::x86_64::*;

use super::rays::ONE;
use super::sampling::{Grey, Plane};
use super::walk::{Steps, GROUP, PARTS};

/// Samples computed together.
const TOGETHER: usize = 4;

/// Columns and rows of four samples, and where their pixels lie in the picture.
struct Walk {
    place: [__m256i; 2],
    step: [__m256i; 2],
    pace: [__m256i; 2],
    band: __m256i,
    last: __m256i,
}

impl Walk {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn new<T: Grey>(plane: &Plane<T>, (from, step): Steps, last: usize) -> Walk {
        let side = |k: usize| _mm256_setr_epi64x(from[k], from[k] + step[k], from[k] + 2 * step[k], from[k] + 3 * step[k]);
        let all = |value: i64| _mm256_set1_epi64x(value);
        Walk {
            place: [side(0), side(1)],
            step: [all(4 * step[0]), all(4 * step[1])],
            pace: [all(plane.bands as i64), all((plane.bands * plane.width) as i64)],
            band: all(plane.band as i64),
            last: all(last as i64),
        }
    }

    /// Of the pixels whose columns and rows are those of the samples rounded down; at most `last`, because samples beyond the end of a
    /// track may lie outside.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn index(&self) -> [usize; TOGETHER] {
        let along = |k: usize| _mm256_mul_epu32(_mm256_srli_epi64::<32>(self.place[k]), self.pace[k]);
        let at = _mm256_min_epu32(_mm256_add_epi64(_mm256_add_epi64(along(0), along(1)), self.band), self.last);
        let (low, high) = (_mm256_castsi256_si128(at), _mm256_extracti128_si256::<1>(at));
        let at = [_mm_cvtsi128_si64(low), _mm_extract_epi64::<1>(low), _mm_cvtsi128_si64(high), _mm_extract_epi64::<1>(high)];
        at.map(|at| at as usize)
    }

    /// How far right of (0) or below (1) those pixels the samples lie, in `PARTS`.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn part(&self, axis: usize) -> __m256d {
        let low = _mm256_permutevar8x32_epi32(self.place[axis], _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
        _mm256_cvtepi32_pd(_mm_srli_epi32::<16>(_mm256_castsi256_si128(low)))
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn advance(&mut self) {
        self.place = [_mm256_add_epi64(self.place[0], self.step[0]), _mm256_add_epi64(self.place[1], self.step[1])];
    }
}

#[target_feature(enable = "avx2")]
pub fn lit<T: Grey>(plane: &Plane<T>, steps: Steps, groups: usize, gate: u32) -> u64 {
    let (mut walk, mut lit) = (Walk::new(plane, steps, plane.data.len() - 1), 0);
    let below = _mm_set1_epi32(gate.min(1 << 20) as i32 - 1);
    for group in 0..groups * (GROUP / TOGETHER) {
        // SAFETY: the last place given is that of the last value
        let level = walk.index().map(|at| unsafe { plane.data.get_unchecked(at) }.level() as i32);
        let bright = _mm_cmpgt_epi32(_mm_setr_epi32(level[0], level[1], level[2], level[3]), below);
        lit |= (_mm_movemask_ps(_mm_castsi128_ps(bright)) as u64) << (TOGETHER * group);
        walk.advance();
    }
    lit
}

#[target_feature(enable = "avx2")]
pub fn nearest<T: Grey>(plane: &Plane<T>, steps: Steps, groups: usize, levels: &mut Vec<u32>) {
    let mut walk = Walk::new(plane, steps, plane.data.len() - 1);
    for _ in 0..groups * (GROUP / TOGETHER) {
        levels.extend(walk.index().map(|at| plane.data[at].level()));
        walk.advance();
    }
}

#[target_feature(enable = "avx2")]
pub fn bilinear<T: Grey, const BANDS: usize>(plane: &Plane<T>, steps: Steps, values: &mut [f64]) {
    let (pace, bands) = (plane.bands * plane.width, if BANDS > 0 { BANDS } else { plane.bands });
    assert!(plane.data.len() > pace + bands, "a picture has at least two rows");
    let mut walk = Walk::new(plane, steps, plane.data.len() - 1 - pace - bands);
    let (white, shift) = (_mm_set1_epi32(T::WHITE as i32), _mm_cvtsi32_si128(T::WHITE.leading_zeros() as i32));
    let (parts, whole) = (_mm256_set1_pd(PARTS), _mm256_set1_pd(1.0 / ONE as f64));
    for values in values.as_chunks_mut::<TOGETHER>().0 {
        let index = walk.index();
        let (x, y) = (walk.part(0), walk.part(1));
        let across = |below: usize| {
            let pair = index.map(|at| {
                let from = at + below;
                // SAFETY: `at` is at most the last place given, and there are one row, the bands between two pixels and one value more behind that
                T::pair::<BANDS>(unsafe { plane.data.get_unchecked(from..=from + bands) }, bands) as i32
            });
            let pair = _mm_setr_epi32(pair[0], pair[1], pair[2], pair[3]);
            let (a, b) = (_mm_and_si128(pair, white), _mm_srl_epi32(pair, shift));
            let rise = _mm256_mul_pd(x, _mm256_cvtepi32_pd(_mm_sub_epi32(b, a)));
            _mm256_add_pd(_mm256_mul_pd(_mm256_cvtepi32_pd(a), parts), rise)
        };
        let (upper, lower) = (across(0), across(pace));
        let sum = _mm256_add_pd(_mm256_mul_pd(upper, parts), _mm256_mul_pd(y, _mm256_sub_pd(lower, upper)));
        // SAFETY: the values are as many as the vector has lanes
        unsafe { _mm256_storeu_pd(values.as_mut_ptr(), _mm256_mul_pd(sum, whole)) };
        walk.advance();
    }
}
