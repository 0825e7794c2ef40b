//! Which points leave the smooth wall: the first half of the twin of `calibore.metrics._features`.

use super::noise::Noise;
use super::statistics::median;

const WINDOWS: [usize; 3] = [3, 7, 15];
const FOUND: f64 = 5.2;
const BELONGS: f64 = 2.5;
const LONGEST: usize = 240;
const BESIDE: usize = 4;
const EDGE: f64 = 3.0;
const ALONE: f64 = 6.0;
const SUPPORTED: f64 = 3.5;

/// Points far off the wall whose neighbours are both on it.
pub fn lone_points(standardised: &[f64], used: &[bool]) -> Vec<bool> {
    let n = used.len();
    let near = |i: usize| if used[i] { standardised[i].abs() } else { 0.0 };
    let lone = |i: usize| used[i] && near(i) > ALONE && near((i + n - 1) % n).max(near((i + 1) % n)) < SUPPORTED;
    (0..n).map(lone).collect()
}

/// Points of stretches whose residuals, in units of their own noise, cannot be noise.
pub fn stretches(standardised: &[f64], used: &[bool], noise: &Noise) -> Vec<bool> {
    let values: Vec<f64> = standardised.iter().zip(used).map(|(&value, &used)| if used { value } else { 0.0 }).collect();
    let mut seeds: Vec<bool> = values.iter().map(|value| value.abs() > FOUND).collect();
    let mut candidates: Vec<bool> = values.iter().map(|value| value.abs() > BELONGS).collect();
    let doubtful: Vec<f64> = values.iter().zip(&seeds).map(|(&value, &seed)| if seed { 0.0 } else { value }).collect();
    for width in WINDOWS {
        let unit = noise.sum_variance(width).sqrt();
        for (i, sum) in window_sums(&doubtful, width).into_iter().enumerate() {
            let strength = sum.abs() / unit;
            seeds[i] |= strength > FOUND;
            candidates[i] |= width == WINDOWS[0] && strength > BELONGS;
        }
    }
    seeds.iter_mut().zip(used).for_each(|(seed, used)| *seed &= used);
    let members: Vec<bool> = (0..used.len()).map(|i| candidates[i] && used[i] || seeds[i]).collect();
    let mut found = vec![false; used.len()];
    for run in runs(&members) {
        if run.iter().any(|&i| seeds[i]) {
            run.iter().for_each(|&i| found[i] = true);
        }
    }
    found
}

/// Where `values` round the ring step to the next one as an edge does, not as a slope.
pub fn sharp_jumps(values: &[f64], sigma: &[f64]) -> Vec<bool> {
    let n = values.len();
    let jumps: Vec<f64> = (0..n).map(|i| (values[(i + 1) % n] - values[i]).abs()).collect();
    let sharp = |i: usize| {
        let beside = || (0..=2 * BESIDE).map(|k| jumps[(i + k + BESIDE * (n - 1)) % n]);
        jumps[i] > 2.0 * EDGE * sigma[i] && jumps[i] > EDGE * median(&mut beside().collect::<Vec<_>>())
    };
    (0..n).map(sharp).collect()
}

/// Indices of the runs of `mask` round the ring, cut after `edges`, none longer than `LONGEST`.
pub fn split_runs(mask: &[bool], edges: &[bool]) -> Vec<Vec<usize>> {
    let mut parts = vec![];
    for run in runs(mask) {
        for run in run.split_inclusive(|&i| edges[i]) {
            let (count, mut rest) = (run.len().div_ceil(LONGEST), run);
            for part in 0..count {
                let (first, others) = rest.split_at(run.len() / count + usize::from(part < run.len() % count));
                parts.push(first.to_vec());
                rest = others;
            }
        }
    }
    parts
}

fn runs(mask: &[bool]) -> Vec<Vec<usize>> {
    let n = mask.len();
    let offset = mask.iter().position(|&on| !on).unwrap_or(0);
    let around: Vec<usize> = (0..n).map(|i| (i + offset) % n).collect();
    around.chunk_by(|&a, &b| mask[a] && mask[b]).filter(|run| mask[run[0]]).map(<[usize]>::to_vec).collect()
}

fn window_sums(values: &[f64], width: usize) -> Vec<f64> {
    let (n, half) = (values.len(), width / 2);
    let mut total = vec![0.0];
    for i in 0..n + 2 * half {
        total.push(total[i] + values[(i + n - half % n) % n]);
    }
    (0..n).map(|i| total[i + width] - total[i]).collect()
}
