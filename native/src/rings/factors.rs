//! Triangular factors of symmetric matrices, and what they solve.

use super::matrix::{add_rows, add_scaled, dot, Matrix};
use crate::meeting::dispatch::{widest, Work};

/// What is added to the diagonal of a covariance, of its mean, until it has a factor; see `calibore.metrics._noise.factor`.
const JITTERS: [f64; 4] = [0.0, 1e-13, 1e-10, 1e-7];

impl Matrix {
    /// The lower factor L of self = L L^T; none where self is not positive.
    pub fn cholesky(&self) -> Option<Matrix> {
        let mut lower = self.clone();
        let mut positive = true;
        widest(Cholesky { lower: &mut lower, positive: &mut positive });
        positive.then_some(lower)
    }

    /// The same of a covariance that is positive up to rounding.
    pub fn factor(&self) -> Option<Matrix> {
        let scale = self.diagonal().iter().sum::<f64>() / self.columns.max(1) as f64;
        JITTERS.iter().find_map(|jitter| self.clone().plus_diagonal(&vec![jitter * scale; self.columns]).cholesky())
    }

    /// L^-1 `right` for a lower triangle self, in place.
    pub fn forward(&self, right: &mut Matrix) {
        widest(Forward { lower: self, right, triangle: false });
    }

    /// self^-1 for a symmetric, positive self.
    pub fn inverse(&self) -> Option<Matrix> {
        let n = self.columns;
        let mut inner = Matrix::of(n, n, |i, j| f64::from(u8::from(i == j)));
        widest(Forward { lower: &self.cholesky()?, right: &mut inner, triangle: true });
        Some(inner.transposed().times(&inner))
    }

    /// self^-1 right for a symmetric, positive self.
    pub fn solved(&self, right: &[f64]) -> Option<Vec<f64>> {
        let lower = self.cholesky()?;
        let mut x = right.to_vec();
        for i in 0..x.len() {
            x[i] = (x[i] - dot(&lower.row(i)[..i], &x[..i])) / lower.at(i, i);
        }
        for i in (0..x.len()).rev() {
            x[i] /= lower.at(i, i);
            let (before, here) = x.split_at_mut(i);
            add_scaled(before, -here[0], &lower.row(i)[..i]);
        }
        Some(x)
    }
}

struct Cholesky<'a> {
    lower: &'a mut Matrix,
    positive: &'a mut bool,
}

impl Work for Cholesky<'_> {
    /// By rows of the upper triangle, which lie as they are needed; they become columns of the lower one in the end.
    #[inline(always)]
    fn run(self) {
        let n = self.lower.columns;
        for k in 0..n {
            let (done, rest) = self.lower.values.split_at_mut((k + 1) * n);
            let row = &mut done[k * n + k..];
            *self.positive &= row[0] > 0.0;
            let inverse = 1.0 / row[0].sqrt();
            row.iter_mut().for_each(|value| *value *= inverse);
            for (i, below) in rest.chunks_exact_mut(n).enumerate() {
                add_scaled(&mut below[k + 1 + i..], -row[1 + i], &row[1 + i..]);
            }
        }
        for i in 0..n {
            for j in 0..i {
                self.lower.values[i * n + j] = self.lower.values[j * n + i];
                self.lower.values[j * n + i] = 0.0;
            }
        }
    }
}

struct Forward<'a> {
    lower: &'a Matrix,
    right: &'a mut Matrix,
    /// Whether `right` is a lower triangle, too.
    triangle: bool,
}

impl Work for Forward<'_> {
    #[inline(always)]
    fn run(self) {
        let width = self.right.columns;
        for i in 0..self.lower.columns {
            let (above, rest) = self.right.values.split_at_mut(i * width);
            let row = &mut rest[..if self.triangle { i + 1 } else { width }];
            let inverse = 1.0 / self.lower.at(i, i);
            let scales = &self.lower.row(i)[..i];
            row.iter_mut().for_each(|value| *value = -*value);
            add_rows(row, scales, above, width);
            row.iter_mut().for_each(|value| *value *= -inverse);
        }
    }
}
