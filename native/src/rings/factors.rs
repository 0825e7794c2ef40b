//! Triangular factors of symmetric matrices, and what they solve.

use super::matrix::{add_scaled, dot, Matrix};
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
        widest(Forward { lower: self, right });
    }

    /// self^-1 for a symmetric, positive self.
    pub fn inverse(&self) -> Option<Matrix> {
        let n = self.columns;
        let mut inner = Matrix::of(n, n, |i, j| f64::from(u8::from(i == j)));
        self.cholesky()?.forward(&mut inner);
        let inner = inner.transposed();
        Some(inner.gram(&inner))
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
    #[inline(always)]
    fn run(self) {
        let n = self.lower.columns;
        for i in 0..n {
            let (above, rest) = self.lower.values.split_at_mut(i * n);
            let row = &mut rest[..n];
            for j in 0..i {
                let before = &above[j * n..][..n];
                row[j] = (row[j] - dot(&row[..j], &before[..j])) / before[j];
            }
            let square = row[i] - dot(&row[..i], &row[..i]);
            *self.positive &= square > 0.0;
            row[i] = square.sqrt();
            row[i + 1..].fill(0.0);
        }
    }
}

struct Forward<'a> {
    lower: &'a Matrix,
    right: &'a mut Matrix,
}

impl Work for Forward<'_> {
    #[inline(always)]
    fn run(self) {
        let width = self.right.columns;
        for i in 0..self.lower.columns {
            let (above, rest) = self.right.values.split_at_mut(i * width);
            let row = &mut rest[..width];
            for j in 0..i {
                add_scaled(row, -self.lower.at(i, j), &above[j * width..][..width]);
            }
            row.iter_mut().for_each(|value| *value /= self.lower.at(i, i));
        }
    }
}
