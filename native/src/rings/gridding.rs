//! From rays to regular clock positions: the twin of `calibore.profiling._grid`, which tells why.

use std::f64::consts::{PI, TAU};

use super::line::{has_value, status};
use super::statistics::{median, turned};

const SLOPE_REACH: usize = 4;
const SAME_WALL: f64 = 5.0;
const LAGS: usize = 3;
const LEAST_SIGMA: f64 = 1e-12;

/// n rays in order; `along`, `turn` and modes as in `Placed`.
pub struct Rays<'a> {
    pub clock: &'a [f64],
    pub radius: &'a [f64],
    pub axial: &'a [f64],
    pub along: &'a [f64],
    pub turn: &'a [f64],
    pub u_position: &'a [f64],
    pub enlargement: &'a [f64],
    pub status: &'a [u8],
    pub radial: &'a [Vec<f64>],
    pub turned: &'a [Vec<f64>],
}

/// Radius, axial and independent uncertainty at the positions, the modes there, status and correlation of neighbours.
pub struct Gridded {
    pub columns: [Vec<f64>; 3],
    pub modes: Vec<f64>,
    pub status: Vec<u8>,
    pub correlation: [f64; LAGS],
}

/// Rays sorted into clock steps: those of step p are `rays[starts[p]..starts[p + 1]]`.
struct Steps {
    rays: Vec<usize>,
    starts: Vec<usize>,
    home: Vec<usize>,
    offset: Vec<f64>,
    step: f64,
}

impl Steps {
    fn of(rays: &Rays, positions: usize) -> Self {
        let step = TAU / positions as f64;
        let home: Vec<usize> = rays.clock.iter().map(|clock| (clock / step).round_ties_even() as usize % positions).collect();
        let offset = rays.clock.iter().zip(&home).map(|(clock, &home)| turned(clock - home as f64 * step + PI, TAU) - PI).collect();
        let usable = |i: &usize| has_value(rays.status[*i]);
        let mut starts = vec![0; positions + 1];
        (0..home.len()).filter(usable).for_each(|i| starts[home[i] + 1] += 1);
        (0..positions).for_each(|p| starts[p + 1] += starts[p]);
        let (mut next, mut sorted) = (starts.clone(), vec![0; starts[positions]]);
        for i in (0..home.len()).filter(usable) {
            sorted[next[home[i]]] = i;
            next[home[i]] += 1;
        }
        Steps { rays: sorted, starts, home, offset, step }
    }

    fn positions(&self) -> usize {
        self.starts.len() - 1
    }

    fn range(&self, p: usize) -> std::ops::Range<usize> {
        self.starts[p]..self.starts[p + 1]
    }

    fn at(&self, p: usize) -> &[usize] {
        &self.rays[self.range(p)]
    }

    /// Local slope of the wall: median of the differences of neighbouring steps.
    fn slopes(&self, radius: &[f64]) -> Vec<f64> {
        let n = self.positions();
        let mean = |p: usize, values: &[f64]| self.at(p).iter().map(|&i| values[i]).sum::<f64>() / self.at(p).len().max(1) as f64;
        let level: Vec<f64> = (0..n).map(|p| if self.at(p).is_empty() { f64::NAN } else { mean(p, radius) }).collect();
        let place: Vec<f64> = (0..n).map(|p| mean(p, &self.offset)).collect();
        let after = |p: usize| (p + 1) % n;
        let difference: Vec<f64> = (0..n).map(|p| (level[after(p)] - level[p]) / (self.step + place[after(p)] - place[p])).collect();
        let slope = |p: usize| {
            let (mut known, mut count) = ([0.0; 2 * SLOPE_REACH], 0);
            for k in 0..2 * SLOPE_REACH {
                known[count] = difference[(p + n - SLOPE_REACH + k) % n];
                count += usize::from(known[count].is_finite());
            }
            if count > 1 {
                middle(&mut known[..count])
            } else {
                0.0
            }
        };
        (0..n).map(slope).collect()
    }
}

/// Median of a few numbers.
fn middle(values: &mut [f64]) -> f64 {
    for i in 1..values.len() {
        let mut k = i;
        while k > 0 && values[k - 1] > values[k] {
            values.swap(k - 1, k);
            k -= 1;
        }
    }
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

/// As `f64::hypot`, for numbers whose squares are numbers.
#[inline(always)]
pub fn root_of_squares(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

pub fn grid(rays: &Rays, correlation: &[f64], stated: Option<f64>, positions: usize) -> Gridded {
    let steps = Steps::of(rays, positions);
    let slopes = steps.slopes(rays.radius);
    let of = |value: &dyn Fn(usize, f64) -> f64| -> Vec<f64> { steps.rays.iter().map(|&i| value(i, slopes[steps.home[i]])).collect() };
    let spread = of(&|i, slope| (rays.along[i] - slope * rays.turn[i]).abs() * rays.enlargement[i]);
    let sigma: Vec<f64> = spread.iter().zip(&steps.rays).map(|(spread, &i)| spread * rays.u_position[i]).collect();
    let level = of(&|i, slope| rays.radius[i] - slope * steps.offset[i]);
    let weight = weights(&steps, &level, &sigma);
    let sum = |p: usize, values: &[f64]| {
        let range = steps.range(p);
        weight[range.clone()]
            .iter()
            .zip(&values[range])
            .filter(|(weight, _)| **weight > 0.0)
            .map(|(weight, value)| weight * value)
            .sum::<f64>()
    };
    let found: Vec<bool> = (0..positions).map(|p| steps.range(p).any(|k| weight[k] > 0.0)).collect();
    let mean = |values: &[f64]| -> Vec<f64> { (0..positions).map(|p| if found[p] { sum(p, values) } else { f64::NAN }).collect() };
    let (mut u, correlation) = noise(&steps, &weight, &sigma, correlation);
    if let Some(stated) = stated {
        u = (0..positions).map(|p| sum(p, &spread) * stated).collect();
    }
    u.iter_mut().zip(&found).filter(|(_, found)| !**found).for_each(|(u, _)| *u = f64::NAN);
    let moved = rays.radial.iter().zip(rays.turned).map(|(radial, turned)| of(&|i, slope| radial[i] - slope * turned[i]));
    let modes = moved.flat_map(|mode| mean(&mode)).collect();
    let axial = of(&|i, _| rays.axial[i]);
    Gridded { columns: [mean(&level), mean(&axial), u], modes, status: statuses(&steps, rays, &found), correlation }
}

/// Weights, summing to one in each step, of the points on the same piece of wall as the nearest one; 0 elsewhere.
fn weights(steps: &Steps, level: &[f64], sigma: &[f64]) -> Vec<f64> {
    let mut weight = vec![0.0; level.len()];
    for p in 0..steps.positions() {
        let range = steps.range(p);
        let away = |k: usize| steps.offset[steps.rays[k]].abs();
        let known = range.clone().filter(|&k| level[k].is_finite());
        let Some(nearest) = known.min_by(|&a, &b| away(a).total_cmp(&away(b))) else { continue };
        let mut total = 0.0;
        for k in range.clone() {
            if (level[k] - level[nearest]).abs() <= SAME_WALL * root_of_squares(sigma[k], sigma[nearest]) {
                weight[k] = sigma[k].max(LEAST_SIGMA).powi(-2);
                total += weight[k];
            }
        }
        weight[range].iter_mut().filter(|_| total > 0.0).for_each(|weight| *weight /= total);
    }
    weight
}

/// Standard uncertainty of the weighted means, and the correlation of neighbouring ones.
fn noise(steps: &Steps, weight: &[f64], sigma: &[f64], correlation: &[f64]) -> (Vec<f64>, [f64; LAGS]) {
    let (n, count) = (steps.positions(), steps.rays.iter().max().map_or(0, |most| most + 1));
    let shared: Vec<f64> = [1.0].iter().chain(correlation).copied().collect();
    let part: Vec<f64> = weight.iter().zip(sigma).map(|(&w, &sigma)| if w > 0.0 && sigma.is_finite() { w * sigma } else { 0.0 }).collect();
    let covariance = |p: usize, q: usize| {
        let mut sum = 0.0;
        for a in steps.range(p) {
            for b in steps.range(q) {
                let apart = steps.rays[a].abs_diff(steps.rays[b]);
                if let Some(shared) = shared.get(apart.min(count - apart)) {
                    sum += part[a] * shared * part[b];
                }
            }
        }
        sum
    };
    let u: Vec<f64> = (0..n).map(|p| covariance(p, p).max(0.0).sqrt()).collect();
    let correlation = std::array::from_fn(|k| {
        let pairs = (0..n).map(|p| (p, (p + k + 1) % n)).filter(|&(p, q)| u[p] > 0.0 && u[q] > 0.0);
        let mut lags: Vec<f64> = pairs.map(|(p, q)| covariance(p, q) / (u[p] * u[q])).collect();
        if lags.is_empty() {
            0.0
        } else {
            median(&mut lags)
        }
    });
    (u, correlation)
}

/// Status of each step: that of its nearest ray, of its nearest usable ray where the step has a value.
fn statuses(steps: &Steps, rays: &Rays, found: &[bool]) -> Vec<u8> {
    let mut nearest = vec![(f64::INFINITY, status::NO_PEAK); found.len()];
    for (i, &home) in steps.home.iter().enumerate() {
        let unlike = has_value(rays.status[i]) != found[home];
        let away = steps.offset[i].abs() + if unlike { 10.0 } else { 0.0 };
        if away < nearest[home].0 {
            nearest[home] = (away, rays.status[i]);
        }
    }
    let told = |(&(_, status), &found): (&(f64, u8), &bool)| if !found && has_value(status) { status::NO_PEAK } else { status };
    nearest.iter().zip(found).map(told).collect()
}
