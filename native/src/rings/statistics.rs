//! Medians, turns and lines between points, as NumPy has them.

use std::f64::consts::TAU;

/// The middle value, the upper one of two.
pub fn upper_median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// `numpy.median`
pub fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    let odd = values.len() % 2 == 1;
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if odd {
        return *upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + *upper)
}

/// Standard deviation by the median absolute value.
pub fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    1.4826 * upper_median(&mut sizes)
}

/// `numpy.mod` for a positive `turn`.
#[inline(always)]
pub fn turned(angle: f64, turn: f64) -> f64 {
    if (0.0..turn).contains(&angle) {
        return angle;
    }
    let rest = angle % turn;
    if rest < 0.0 {
        rest + turn
    } else {
        rest
    }
}

/// Clock of a point, in [0, 2 pi).
#[inline(always)]
pub fn clock_of(x: f64, y: f64) -> f64 {
    let clock = turned(x.atan2(-y), TAU);
    if clock >= TAU {
        0.0
    } else {
        clock
    }
}

/// Where places `to` lie between places that increase: what `numpy.interp` finds for any values there.
pub struct Between {
    before: Vec<usize>,
    into: Vec<f64>,
    width: Vec<f64>,
    /// First and last value are repeated a turn away.
    closed: bool,
}

impl Between {
    /// Round the turn, with a period of 2 pi; `places` in [0, 2 pi).
    pub fn closed(to: &[f64], places: &[f64]) -> Self {
        let (first, last) = (places[0], places[places.len() - 1]);
        let around: Vec<f64> = [last - TAU].into_iter().chain(places.iter().copied()).chain([first + TAU]).collect();
        let to: Vec<f64> = to.iter().map(|&to| turned(to, TAU)).collect();
        Between { closed: true, ..Between::open(&to, &around) }
    }

    /// The first value before the first place, the last one beyond the last.
    pub fn open(to: &[f64], places: &[f64]) -> Self {
        let most = places.len().saturating_sub(2);
        let mut between = Between { before: vec![], into: vec![], width: vec![], closed: false };
        for &to in to {
            let before = places.partition_point(|&place| place <= to).saturating_sub(1).min(most);
            let after = (before + 1).min(places.len() - 1);
            let width = places[after] - places[before];
            between.before.push(before);
            between.width.push(if width > 0.0 { width } else { 1.0 });
            between.into.push((to - places[before]).clamp(0.0, width));
        }
        between
    }

    pub fn values(&self, values: &[f64]) -> Vec<f64> {
        let n = values.len();
        let at = |i: usize| match (self.closed, i) {
            (false, _) => values[i.min(n - 1)],
            (true, 0) => values[n - 1],
            (true, i) if i == n + 1 => values[0],
            (true, _) => values[i - 1],
        };
        let steps = self.before.iter().zip(&self.into).zip(&self.width);
        steps.map(|((&k, into), width)| (at(k + 1) - at(k)) / width * into + at(k)).collect()
    }
}
