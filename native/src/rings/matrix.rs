//! Dense matrices row by row, sums in an order that no processor changes.

use crate::meeting::dispatch::{widest, Work};

#[derive(Clone, Default)]
pub struct Matrix {
    pub columns: usize,
    pub values: Vec<f64>,
}

/// Sums that are added up side by side: of short rows, and so many times as many of long ones.
const FEW: usize = 8;
const TIMES: usize = 4;

#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [[0.0; FEW]; TIMES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<FEW>(), b.as_chunks::<FEW>());
    let ((a, a_few), (b, b_few)) = (a.as_chunks::<TIMES>(), b.as_chunks::<TIMES>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..TIMES {
            (0..FEW).for_each(|i| sums[k][i] += a[k][i] * b[k][i]);
        }
    }
    let [mut first, second, third, fourth] = sums;
    for (a, b) in a_few.iter().zip(b_few) {
        (0..FEW).for_each(|i| first[i] += a[i] * b[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let [a, b, c, d, e, f, g, h] = std::array::from_fn(|i| (first[i] + third[i]) + (second[i] + fourth[i]));
    (((a + e) + (c + g)) + ((b + f) + (d + h))) + rest
}

#[inline(always)]
pub fn sum(values: &[f64]) -> f64 {
    let (chunks, rest) = values.as_chunks::<FEW>();
    let sums = chunks.iter().fold([0.0; FEW], |sums, chunk| std::array::from_fn(|k| sums[k] + chunk[k]));
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + b) + (c + d)) + ((e + f) + (g + h)) + rest.iter().sum::<f64>()
}

/// The smallest and the largest of finite `values`.
#[inline(always)]
pub fn limits(values: &[f64]) -> (f64, f64) {
    let (chunks, rest) = values.as_chunks::<FEW>();
    let (mut least, mut most) = ([f64::INFINITY; FEW], [f64::NEG_INFINITY; FEW]);
    for chunk in chunks {
        for k in 0..FEW {
            least[k] = if chunk[k] < least[k] { chunk[k] } else { least[k] };
            most[k] = if chunk[k] > most[k] { chunk[k] } else { most[k] };
        }
    }
    let least = least.iter().chain(rest).copied().fold(f64::INFINITY, f64::min);
    (least, most.iter().chain(rest).copied().fold(f64::NEG_INFINITY, f64::max))
}

/// `to` += `scale` x `row`.
#[inline(always)]
pub fn add_scaled(to: &mut [f64], scale: f64, row: &[f64]) {
    for (to, value) in to.iter_mut().zip(row) {
        *to += scale * value;
    }
}

/// Rows that are added up before the sum is stored.
const TOGETHER: usize = 4;

/// `to` += `scales` x `rows`, one row after the other: `rows` lie one behind the other, `width` apart, their first numbers count.
#[inline(always)]
pub fn add_rows(to: &mut [f64], scales: &[f64], rows: &[f64], width: usize) {
    if to.is_empty() {
        return;
    }
    let (scales, rest) = scales.as_chunks::<TOGETHER>();
    let (blocks, last) = rows.split_at(scales.len() * TOGETHER * width);
    for (scales, block) in scales.iter().zip(blocks.chunks_exact(TOGETHER * width)) {
        let [a, b, c, d] = std::array::from_fn(|k| &block[k * width..][..to.len()]);
        for (i, to) in to.iter_mut().enumerate() {
            *to = (((*to + scales[0] * a[i]) + scales[1] * b[i]) + scales[2] * c[i]) + scales[3] * d[i];
        }
    }
    for (scale, row) in rest.iter().zip(last.chunks_exact(width)) {
        add_scaled(to, *scale, &row[..to.len()]);
    }
}

impl Matrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Matrix { columns, values: vec![0.0; rows * columns] }
    }

    pub fn of(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let mut values = Vec::with_capacity(rows * columns);
        for i in 0..rows {
            values.extend((0..columns).map(|j| value(i, j)));
        }
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

    /// self vector; a shorter vector meets the first columns.
    pub fn applied(&self, vector: &[f64]) -> Vec<f64> {
        let mut to = vec![0.0; self.rows()];
        widest(Application { rows: self, vector, to: &mut to });
        to
    }

    /// Every column times a number.
    pub fn weighted(&self, by: &[f64]) -> Matrix {
        let mut values = Vec::with_capacity(self.values.len());
        for row in self.values.chunks_exact(self.columns.max(1)) {
            values.extend(row.iter().zip(by).map(|(value, by)| value * by));
        }
        Matrix { columns: self.columns, values }
    }

    /// self^T vector
    pub fn combined(&self, vector: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.columns];
        widest(Combination { rows: self, scales: vector, to: &mut sum });
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
            add_rows(self.to.row_mut(i), self.a.row(i), &self.b.values, self.b.columns);
        }
    }
}

struct Combination<'a> {
    rows: &'a Matrix,
    scales: &'a [f64],
    to: &'a mut [f64],
}

impl Work for Combination<'_> {
    #[inline(always)]
    fn run(self) {
        add_rows(self.to, self.scales, &self.rows.values, self.rows.columns);
    }
}

struct Application<'a> {
    rows: &'a Matrix,
    vector: &'a [f64],
    to: &'a mut [f64],
}

impl Work for Application<'_> {
    #[inline(always)]
    fn run(self) {
        for (i, to) in self.to.iter_mut().enumerate() {
            *to = dot(&self.rows.row(i)[..self.vector.len()], self.vector);
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
