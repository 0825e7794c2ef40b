//! The independent part of the noise: the twin of `calibore.metrics._noise`.

use std::f64::consts::TAU;

use super::matrix::{add_scaled, Matrix};

const LEAST_SPECTRUM: f64 = 0.02;

/// `correlation` as some noise on `n` clock positions can have it.
pub fn possible(correlation: &[f64], n: usize) -> Vec<f64> {
    let lags = &correlation[..correlation.len().min((n - 1) / 2)];
    let power =
        |k: usize| 1.0 + 2.0 * lags.iter().enumerate().map(|(i, rho)| rho * (TAU * (k * (i + 1)) as f64 / n as f64).cos()).sum::<f64>();
    let least = (0..=n / 2).map(power).fold(f64::INFINITY, f64::min);
    let shrink = if least < LEAST_SPECTRUM { (1.0 - LEAST_SPECTRUM) / (1.0 - least) } else { 1.0 };
    correlation.iter().map(|rho| rho * shrink).collect()
}

#[derive(Clone)]
pub struct Noise {
    pub sigma: Vec<f64>,
    /// Autocorrelation at lags 1, 2, ... that is `possible`.
    pub correlation: Vec<f64>,
}

impl Noise {
    /// Covariance (p, p) of the linear functionals (p, n) of the radii.
    pub fn covariance_of(&self, functionals: &Matrix) -> Matrix {
        let n = functionals.columns;
        let scaled = functionals.weighted(&self.sigma);
        let mut shared = scaled.clone();
        for i in 0..scaled.rows() {
            let (row, to) = (scaled.row(i), shared.row_mut(i));
            for (lag, &rho) in self.correlation.iter().enumerate().map(|(i, rho)| (i + 1, rho)) {
                add_scaled(&mut to[..n - lag], rho, &row[lag..]);
                add_scaled(&mut to[n - lag..], rho, &row[..lag]);
                add_scaled(&mut to[lag..], rho, &row[..n - lag]);
                add_scaled(&mut to[..lag], rho, &row[n - lag..]);
            }
        }
        scaled.gram(&shared)
    }

    /// Covariance (q, q) of the points `index`.
    pub fn block(&self, index: &[usize]) -> Matrix {
        let n = self.sigma.len();
        let shared = |a: usize, b: usize| match a.abs_diff(b).min(n - a.abs_diff(b)) {
            0 => 1.0,
            lag => self.correlation.get(lag - 1).copied().unwrap_or(0.0),
        };
        Matrix::of(index.len(), index.len(), |i, j| shared(index[i], index[j]) * (self.sigma[index[i]] * self.sigma[index[j]]))
    }

    /// Variance of the sum of `width` neighbours in units of sigma^2.
    pub fn sum_variance(&self, width: usize) -> f64 {
        let shared = self.correlation.iter().zip(1..width).map(|(rho, lag)| (width - lag) as f64 * rho).sum::<f64>();
        f64::max(width as f64 + 2.0 * shared, 0.5 * width as f64)
    }
}
