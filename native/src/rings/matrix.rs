//! Dense matrices row by row, sums in an order that no processor changes.

use crate::meeting::dispatch::{widest, Work};

#[derive(Clone, Default)]
pub struct Matrix {
    pub columns: usize,
    pub values: Vec<f64>,
}

/// Sums that are added up side by side, of long and of short rows.
const MANY: usize = 32;
const FEW: usize = 8;
/// What is added to the diagonal of a covariance, of its mean, until it has a factor; see `calibore.metrics._noise.factor`.
const JITTERS: [f64; 4] = [0.0, 1e-13, 1e-10, 1e-7];

#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; MANY];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<MANY>(), b.as_chunks::<MANY>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..MANY {
            sums[k] += a[k] * b[k];
        }
    }
    let ((a, a_rest), (b, b_rest)) = (a_rest.as_chunks::<FEW>(), b_rest.as_chunks::<FEW>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..FEW {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let mut width = MANY;
    while width > 1 {
        width /= 2;
        for k in 0..width {
            sums[k] += sums[k + width];
        }
    }
    sums[0] + rest
}

/// `to` += `scale` x `row`.
#[inline(always)]
pub fn add_scaled(to: &mut [f64], scale: f64, row: &[f64]) {
    for (to, value) in to.iter_mut().zip(row) {
        *to += scale * value;
    }
}

impl Matrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Matrix { columns, values: vec![0.0; rows * columns] }
    }

    pub fn of(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| value(i, j)).collect();
        Matrix { columns, values }
    }

    pub fn rows(&self) -> usize {
        if self.columns == 0 {
            0
        } else {
            self.values.len() / self.columns
        }
    }

    #[inline(always)]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.columns..][..self.columns]
    }

    #[inline(always)]
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.columns..][..self.columns]
    }

    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.columns + j]
    }

    pub fn push(&mut self, row: &[f64]) {
        self.columns = row.len();
        self.values.extend_from_slice(row);
    }

    pub fn transposed(&self) -> Matrix {
        Matrix::of(self.columns, self.rows(), |i, j| self.at(j, i))
    }

    /// self other
    pub fn times(&self, other: &Matrix) -> Matrix {
        let mut product = Matrix::zeros(self.rows(), other.columns);
        widest(Product { a: self, b: other, to: &mut product });
        product
    }

    /// self other^T
    pub fn times_transposed(&self, other: &Matrix) -> Matrix {
        let mut product = Matrix::zeros(self.rows(), other.rows());
        widest(Dots { a: self, b: other, to: &mut product, symmetric: false });
        product
    }

    /// self other^T, where that is symmetric.
    pub fn gram(&self, other: &Matrix) -> Matrix {
        let mut product = Matrix::zeros(self.rows(), other.rows());
        widest(Dots { a: self, b: other, to: &mut product, symmetric: true });
        product
    }

    pub fn applied(&self, vector: &[f64]) -> Vec<f64> {
        (0..self.rows()).map(|i| dot(self.row(i), vector)).collect()
    }

    /// self^T vector
    pub fn combined(&self, vector: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.columns];
        for (i, &scale) in vector.iter().enumerate() {
            add_scaled(&mut sum, scale, self.row(i));
        }
        sum
    }

    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows()).map(|i| self.at(i, i)).collect()
    }

    pub fn plus_diagonal(mut self, diagonal: &[f64]) -> Matrix {
        for (i, value) in diagonal.iter().enumerate() {
            self.values[i * self.columns + i] += value;
        }
        self
    }

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

struct Product<'a> {
    a: &'a Matrix,
    b: &'a Matrix,
    to: &'a mut Matrix,
}

impl Work for Product<'_> {
    #[inline(always)]
    fn run(self) {
        for i in 0..self.a.rows() {
            for k in 0..self.a.columns {
                add_scaled(self.to.row_mut(i), self.a.at(i, k), self.b.row(k));
            }
        }
    }
}

struct Dots<'a> {
    a: &'a Matrix,
    b: &'a Matrix,
    to: &'a mut Matrix,
    symmetric: bool,
}

impl Work for Dots<'_> {
    #[inline(always)]
    fn run(self) {
        for i in 0..self.a.rows() {
            let count = if self.symmetric { i + 1 } else { self.b.rows() };
            for j in 0..count {
                let value = dot(self.a.row(i), self.b.row(j));
                self.to.row_mut(i)[j] = value;
                if self.symmetric {
                    self.to.row_mut(j)[i] = value;
                }
            }
        }
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
