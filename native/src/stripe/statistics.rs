//! Medians as NumPy computes them, and whole-number floors without a library call.

/// Median; the mean of the middle two for an even count; NaN of nothing. Reorders `values`.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let count = values.len();
    let (below, &mut upper, _) = values.select_nth_unstable_by(count / 2, f64::total_cmp);
    0.5 * (before(below, upper, count) + upper)
}

/// The middle two of the `known` smallest of some values that are not negative, which are the same one for an odd count. Reorders `values`.
pub fn middle_two(values: &mut [f64], known: usize) -> (f64, f64) {
    // such numbers are in the order of their bits, which are compared faster
    let (below, &mut upper, _) = values.select_nth_unstable_by_key(known / 2, |value| value.to_bits());
    (before(below, upper, known), upper)
}

/// The value before the `upper` middle one of `count`, or that one where it is the only middle.
fn before(below: &[f64], upper: f64, count: usize) -> f64 {
    if count.is_multiple_of(2) {
        below.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    } else {
        upper
    }
}

/// Largest whole number not above `value`; saturates like a cast.
#[inline(always)]
pub fn floor(value: f64) -> i64 {
    let whole = value as i64;
    whole - i64::from((whole as f64) > value)
}

/// Nearest whole number, the even one of two; for values of less than 2^51.
#[inline(always)]
pub fn nearest_even(value: f64) -> i64 {
    const SHIFT: f64 = 6755399441055744.0;
    (value + SHIFT - SHIFT) as i64
}

/// How often each whole number occurs.
pub struct Histogram {
    /// In turns, because a counter just written is slow to read again.
    counts: Vec<[u32; TURNS]>,
    total: usize,
}

const TURNS: usize = 8;

impl Histogram {
    /// For the numbers 0 to `largest`.
    pub fn new(largest: u32) -> Self {
        Histogram { counts: vec![[0; TURNS]; largest as usize + 1], total: 0 }
    }

    /// Counts all `values`, none of which is larger than the largest.
    pub fn add(&mut self, values: &[u32]) {
        let (whole, rest) = values.as_chunks::<TURNS>();
        for some in whole {
            (0..TURNS).for_each(|turn| self.counts[some[turn] as usize][turn] += 1);
        }
        rest.iter().for_each(|&value| self.counts[value as usize][0] += 1);
        self.total += values.len();
    }

    /// The number at place total / `part` in ascending order; 0 of nothing.
    pub fn ranked(&self, part: usize) -> f64 {
        let rank = self.total / part;
        let mut below = 0;
        let found = self.counts.iter().position(|counts| {
            below += counts.iter().sum::<u32>() as usize;
            below > rank
        });
        found.unwrap_or(0) as f64
    }
}
