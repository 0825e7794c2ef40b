//! Generalised least squares of a Gaussian line on many rays (see the Python module `_generalised`).

use super::breadth::width_of;
use super::lanes::{Lanes, LANES};
use super::settings::{Noise, MOST_SAMPLES};
use super::vectors::{vectorised, Vectors};
use super::windows::{Pattern, Windows, FOUR};

const SINGULAR: f64 = 1e-12;
const UNCORRELATED: f64 = 1e-9;
/// Room for the weights of a ray by whole groups.
const ROW: usize = MOST_SAMPLES.next_multiple_of(FOUR);
/// Patterns there are only where samples are clipped.
const MANY: usize = 256;
/// Rows below those of the samples: slope in place, height and background.
const BESIDE: usize = 3;

/// What makes a step of the samples of all rays that look alike.
#[derive(Clone)]
pub struct Functional {
    weight: [f64; ROW],
    /// Variance of the step for a line of the pattern's height; of that, by additive noise and by shot noise of variance one.
    variance: f64,
    additive: f64,
    shot: f64,
}

impl Functional {
    /// Step of the ray's `samples`, where the line is 1 / `low` high; NaN where they fix no place.
    #[inline(always)]
    pub fn step(&self, samples: &[f64], low: f64) -> f64 {
        let mut sums = [0.0; FOUR];
        for (weights, values) in self.weight.as_chunks::<FOUR>().0.iter().zip(samples.as_chunks::<FOUR>().0) {
            (0..FOUR).for_each(|k| sums[k] += weights[k] * values[k]);
        }
        ((sums[0] + sums[1]) + (sums[2] + sums[3])) * low
    }

    /// Standard uncertainty of such a step.
    #[inline(always)]
    pub fn doubt(&self, low: f64, pattern: &Pattern, noise: &Noise) -> f64 {
        let usual = 1.0 / pattern.height;
        let more = noise.additive * (low * low - usual * usual) * self.additive + noise.gain * (low - usual) * self.shot;
        let variance = self.variance + more;
        (if variance < 0.0 { 0.0 } else { variance }).sqrt()
    }
}

/// The functionals of the `patterns` of `windows` under one noise model, every ray looked at from `aside` of its standpoint.
pub fn functionals(windows: &Windows, patterns: &[Pattern], noise: &Noise, aside: f64, vectors: Vectors) -> Vec<Functional> {
    let mut fit = Elimination::new(windows, noise, aside);
    let mut found = Vec::with_capacity(patterns.len() + LANES);
    for patterns in patterns.chunk_by(|one, other| one.level == other.level).flat_map(|some| some.chunks(LANES)) {
        fit.inverse = 1.0 / width_of(noise, patterns[0].level).powi(2);
        eliminate(vectors, &mut fit, patterns);
        found.extend_from_slice(&fit.found[..patterns.len()]);
    }
    found
}

/// The same for the patterns of some `rays` only, where there are many.
pub fn functionals_of(
    windows: &Windows,
    rays: impl Iterator<Item = usize>,
    (noise, aside): (&Noise, f64),
    vectors: Vectors,
) -> Vec<Functional> {
    if windows.patterns.len() <= MANY {
        return functionals(windows, &windows.patterns, noise, aside, vectors);
    }
    let mut used: Vec<usize> = rays.map(|ray| windows.pattern[ray]).collect();
    used.sort_unstable();
    used.dedup();
    let patterns: Vec<Pattern> = used.iter().map(|number| windows.patterns[*number].clone()).collect();
    let nothing = Functional { weight: [f64::NAN; ROW], variance: f64::NAN, additive: f64::NAN, shot: f64::NAN };
    let mut found = vec![nothing; windows.patterns.len()];
    used.into_iter().zip(functionals(windows, &patterns, noise, aside, vectors)).for_each(|(number, one)| found[number] = one);
    found
}

fn eliminate(vectors: Vectors, fit: &mut Elimination, patterns: &[Pattern]) {
    vectorised!(vectors, together(fit: &mut Elimination, patterns: &[Pattern]))
}

#[inline(always)]
fn together(fit: &mut Elimination, patterns: &[Pattern]) {
    fit.border(patterns);
    fit.eliminate();
    fit.solve(patterns.len());
}

struct Elimination<'a> {
    count: usize,
    offset: Vec<f64>,
    apart: f64,
    inverse: f64,
    noise: &'a Noise,
    aside: f64,
    /// Speckle covariance at sample distances 0, 1, ... of a line of height one.
    shared: Vec<f64>,
    bell: [Lanes; MOST_SAMPLES],
    known: [Lanes; MOST_SAMPLES],
    /// Lower triangle of the covariance, row by row, and below it the rows beside.
    rows: Vec<Lanes>,
    column: Vec<Lanes>,
    found: Vec<Functional>,
}

impl<'a> Elimination<'a> {
    fn new(windows: &Windows, noise: &'a Noise, aside: f64) -> Self {
        let count = windows.count;
        let square = |d: usize| (d as f64 * windows.apart).powi(2);
        let correlation = |d: usize| (-square(d) / (4.0 * noise.grain * noise.grain)).exp();
        let shared = (0..count).map(correlation).map(|c| if c > UNCORRELATED { noise.contrast * c } else { 0.0 }).collect();
        let size = count + BESIDE;
        let nothing = Functional { weight: [0.0; ROW], variance: f64::NAN, additive: 0.0, shot: 0.0 };
        Elimination {
            count,
            offset: (0..count).map(|k| windows.offset(k)).collect(),
            apart: windows.apart,
            inverse: f64::NAN,
            noise,
            aside,
            shared,
            bell: [Lanes::ZERO; MOST_SAMPLES],
            known: [Lanes::ZERO; MOST_SAMPLES],
            rows: vec![Lanes::ZERO; size * (size + 1) / 2],
            column: vec![Lanes::ZERO; size],
            found: vec![nothing; LANES],
        }
    }

    /// Lays out the covariance of the samples and the rows beside it, in units of the line's height.
    #[inline(always)]
    fn border(&mut self, patterns: &[Pattern]) {
        let (count, unit) = (self.count, Lanes::all(1.0));
        let (mut fraction, mut height) = (Lanes::ZERO, unit);
        for (lane, pattern) in patterns.iter().enumerate() {
            (fraction.0[lane], height.0[lane]) = (pattern.fraction + self.aside, pattern.height);
        }
        let inverse = Lanes::all(self.inverse);
        let decay = (Lanes::all(-self.apart) * fraction * inverse).exponential();
        // exp(-offset fraction / width^2) at the first sample, by way of the middle one
        let middle = Lanes::all(self.offset[count / 2]);
        let mut share = (Lanes::all(-0.5) * (fraction + middle + middle) * fraction * inverse).exponential();
        let growth = unit / decay;
        (0..count / 2).for_each(|_| share *= growth);
        let low = unit / height;
        let (additive, gain) = (Lanes::all(self.noise.additive) * low * low, Lanes::all(self.noise.gain) * low);
        for k in 0..count {
            let mut known = Lanes::ZERO;
            for (lane, pattern) in patterns.iter().enumerate() {
                known.0[lane] = f64::from(u8::from(pattern.missing >> k & 1 == 0));
            }
            let offset = self.offset[k];
            let bell = Lanes::all((-0.5 * offset * offset * self.inverse).exp()) * share * known;
            share *= decay;
            (self.bell[k], self.known[k]) = (bell, known);
            let row = &mut self.rows[k * (k + 1) / 2..][..=k];
            for (other, value) in row.iter_mut().enumerate() {
                *value = Lanes::all(self.shared[k - other]) * bell * self.bell[other];
            }
            row[k] += (additive + gain * bell) * known + (unit - known);
            let distance = (Lanes::all(offset) + fraction) * inverse;
            for (number, value) in [bell * distance, bell, known].into_iter().enumerate() {
                let row = count + number;
                self.rows[row * (row + 1) / 2 + k] = value;
            }
        }
        for number in 0..BESIDE {
            let row = count + number;
            self.rows[row * (row + 1) / 2 + count..][..=number].fill(Lanes::ZERO);
        }
    }

    /// Eliminates the samples: what is left beside them are the negatives of sums weighted by the inverse of the covariance.
    #[inline(always)]
    fn eliminate(&mut self) {
        for pivot in 0..self.count {
            let inverse = Lanes::all(1.0) / self.rows[pivot * (pivot + 1) / 2 + pivot];
            let mut at = (pivot + 1) * (pivot + 2) / 2;
            for row in pivot + 1..self.count + BESIDE {
                let values = &mut self.rows[at..at + row + 1];
                at += row + 1;
                let own = values[pivot];
                self.column[row] = own;
                let factor = own * inverse;
                for (value, other) in values[pivot + 1..].iter_mut().zip(&self.column[pivot + 1..=row]) {
                    *value = *value - factor * *other;
                }
            }
        }
    }

    /// The functionals, by going the way of the elimination back.
    #[inline(always)]
    fn solve(&mut self, filled: usize) {
        let (count, first) = (self.count, |row: usize| row * (row + 1) / 2);
        let beside = |row: usize, column: usize| self.rows[first(count + row) + count + column];
        let [a, b, c] = inverse_row([beside(0, 0), beside(1, 0), beside(2, 0), beside(1, 1), beside(2, 1), beside(2, 2)]);
        let mut weight = [Lanes::ZERO; MOST_SAMPLES];
        let (mut additive, mut shot) = (Lanes::ZERO, Lanes::ZERO);
        for k in (0..count).rev() {
            let below = |row: usize| self.rows[first(row) + k];
            // the inverse is of the negative sums
            let mut value = Lanes::ZERO;
            for (factor, row) in [a, b, c].into_iter().zip(count..) {
                value = value - factor * below(row);
            }
            for (row, later) in (k + 1..count).zip(&weight[k + 1..count]) {
                value = value - below(row) * *later;
            }
            let value = value / self.rows[first(k) + k];
            weight[k] = value;
            let square = value * value * self.known[k];
            additive += square;
            shot += square * self.bell[k];
        }
        for (lane, found) in self.found.iter_mut().take(filled).enumerate() {
            (0..count).for_each(|k| found.weight[k] = weight[k].0[lane]);
            (found.variance, found.additive, found.shot) = (-a.0[lane], additive.0[lane], shot.0[lane]);
        }
    }
}

/// First row of the inverse of a symmetric 3 x 3 matrix, given as (aa, ab, ac, bb, bc, cc), whose negative is positive definite; NaN where it
/// is singular.
#[inline(always)]
fn inverse_row([aa, ab, ac, bb, bc, cc]: [Lanes; 6]) -> [Lanes; 3] {
    let row = [bb * cc - bc * bc, ac * bc - ab * cc, ab * bc - ac * bb];
    let mut determinant = aa * row[0] + ab * row[1] + ac * row[2];
    for (k, value) in determinant.0.iter_mut().enumerate() {
        if !(-*value > -SINGULAR * aa.0[k] * bb.0[k] * cc.0[k]) {
            *value = f64::NAN;
        }
    }
    row.map(|cofactor| cofactor / determinant)
}
