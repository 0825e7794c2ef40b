//! Dents, rails, openings as Gaussian processes: the second half of the twin of `calibore.metrics._features`.

use std::f64::consts::{PI, TAU};

use super::matrix::Matrix;
use super::noise::Noise;
use super::statistics::{turned, Between};

const LENGTHS: [f64; 3] = [2.0, 5.0, 12.0];
const LOCAL: usize = 5;
const LEAST_SIZE: f64 = 0.3;

/// One stretch: `points` (q) of the ring, `columns` (g) of the wall grid; smoother (g, q); factors of what it leaves open (g, g) and of the
/// noise (q, q).
pub struct Feature {
    pub points: Vec<usize>,
    pub columns: Vec<usize>,
    pub smoother: Matrix,
    pub spread: Matrix,
    pub noise: Matrix,
}

/// The process with the best evidence for `residuals` at `points`, evaluated at `grid` of `columns`.
pub fn feature_between(
    points: Vec<usize>,
    columns: Vec<usize>,
    (angles, grid): (&[f64], &[f64]),
    residuals: &[f64],
    noise: &Noise,
) -> Option<Feature> {
    let middle = angles[points[points.len() / 2]];
    let from_middle = |angle: f64| turned(angle - middle + PI, TAU) - PI;
    let at: Vec<f64> = points.iter().map(|&i| from_middle(angles[i])).collect();
    let to: Vec<f64> = columns.iter().map(|&i| from_middle(grid[i])).collect();
    let covariance = noise.block(&points);
    let values: Vec<f64> = points.iter().map(|&i| residuals[i]).collect();
    let size = local_size(&values, &covariance.diagonal());
    let size_at_grid = if to.is_empty() { vec![] } else { Between::open(&to, &at).values(&size) };
    let step = TAU / noise.sigma.len() as f64;
    let (mut best, mut length, mut inverse) = (f64::NEG_INFINITY, step * LENGTHS[0], None);
    for steps in LENGTHS {
        let total = sum(itself((&at, &size), step * steps), &covariance);
        let lower = total.factor()?;
        let evidence = evidence(&lower, &values);
        if evidence > best || inverse.is_none() {
            (best, length, inverse) = (evidence.max(best), step * steps, Some(total));
        }
    }
    let inverse = inverse?.inverse()?;
    let to_points = process((&to, &size_at_grid), (&at, &size), length);
    let smoother = to_points.times_transposed(&inverse);
    let noise = covariance.factor()?;
    if to.is_empty() {
        return Some(Feature { points, columns, smoother, spread: Matrix::default(), noise });
    }
    let known = smoother.times_transposed(&to_points);
    let prior = itself((&to, &size_at_grid), length);
    let least = 1e-12 * size.iter().copied().fold(0.0, f64::max).powi(2);
    let left = Matrix::of(to.len(), to.len(), |i, j| prior.at(i, j) - 0.5 * (known.at(i, j) + known.at(j, i)));
    let spread = left.plus_diagonal(&vec![least; to.len()]).factor()?;
    Some(Feature { points, columns, smoother, spread, noise })
}

/// Covariance of the process between places of these sizes: Matern 3/2.
fn process(of: (&[f64], &[f64]), with: (&[f64], &[f64]), length: f64) -> Matrix {
    Matrix::of(of.0.len(), with.0.len(), |i, j| of.1[i] * with.1[j] * matern(of.0[i] - with.0[j], length))
}

/// The same between all places of one set.
fn itself((places, sizes): (&[f64], &[f64]), length: f64) -> Matrix {
    let n = places.len();
    let mut kernel = Matrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = sizes[i] * sizes[j] * matern(places[i] - places[j], length);
            kernel.values[i * n + j] = value;
            kernel.values[j * n + i] = value;
        }
    }
    kernel
}

fn matern(apart: f64, length: f64) -> f64 {
    let scaled = 3.0_f64.sqrt() * apart.abs() / length;
    (1.0 + scaled) * (-scaled).exp()
}

fn sum(mut a: Matrix, b: &Matrix) -> Matrix {
    a.values.iter_mut().zip(&b.values).for_each(|(a, b)| *a += b);
    a
}

/// Of the factor of the covariance of `values`.
fn evidence(lower: &Matrix, values: &[f64]) -> f64 {
    let mut white = Matrix { columns: 1, values: values.to_vec() };
    lower.forward(&mut white);
    let square: f64 = white.values.iter().map(|value| value * value).sum();
    -0.5 * square - lower.diagonal().iter().map(|pivot| pivot.abs().ln()).sum::<f64>()
}

/// Prior standard deviation of the process: what the neighbourhood shows beyond noise.
fn local_size(values: &[f64], noise_variance: &[f64]) -> Vec<f64> {
    let beyond = |(i, variance): (usize, &f64)| {
        let near = &values[i.saturating_sub(LOCAL / 2)..(i + LOCAL / 2 + 1).min(values.len())];
        let power = near.iter().map(|value| value * value).sum::<f64>() / near.len() as f64;
        f64::max(power - variance, LEAST_SIZE * LEAST_SIZE * variance).sqrt()
    };
    noise_variance.iter().enumerate().map(beyond).collect()
}
