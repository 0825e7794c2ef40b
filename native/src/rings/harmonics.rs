//! The smooth part of the wall: the twin of `calibore.metrics._harmonics`, which tells why.

use super::matrix::Matrix;
use super::noise::Noise;

const HARMONICS: usize = 16;
const POINTS_PER_HARMONIC: usize = 4;
const PRIOR_ODDS: f64 = 0.15;
const SMALLEST_SLAB: f64 = 3.0;
const LARGEST_EVIDENCE: f64 = 500.0;
const ROUNDS: usize = 4;
const FURTHER_ROUNDS: usize = 2;
const LEAST_KEPT: f64 = 1e-4;
const SMALLEST_VARIANCE: f64 = 1e-30;
const LEAST_PRIOR: f64 = 1e-10;
const RIDGE: f64 = 1e-9;
const WIDE_PRIOR: f64 = 0.05;

/// Covariances (p, p) of coefficients (p): as believed, and with nothing believed of the second harmonic.
#[derive(Clone)]
pub struct HarmonicFit {
    pub coefficients: Vec<f64>,
    pub precision: Matrix,
    pub prior: Vec<f64>,
    pub covariance: Matrix,
    pub doubt: Vec<f64>,
    pub free: Vec<f64>,
    pub free_covariance: Matrix,
}

pub fn harmonic_count(points: usize) -> usize {
    ((points / POINTS_PER_HARMONIC).saturating_sub(1) / 2).clamp(2, HARMONICS)
}

/// Rows (2 harmonics + 1, n): 1, cos, sin, cos 2, sin 2, ... at angles of these cosines and sines.
pub fn harmonic_basis(cosine: &[f64], sine: &[f64], harmonics: usize) -> Matrix {
    let n = cosine.len();
    let mut basis = Matrix::zeros(2 * harmonics + 1, n);
    basis.row_mut(0).fill(1.0);
    basis.row_mut(1).copy_from_slice(cosine);
    basis.row_mut(2).copy_from_slice(sine);
    for k in 2..=harmonics {
        let (before, rest) = basis.values.split_at_mut((2 * k - 1) * n);
        let (c, s) = before[(2 * k - 3) * n..].split_at(n);
        let (to_c, to_s) = rest[..2 * n].split_at_mut(n);
        for i in 0..n {
            to_c[i] = c[i] * cosine[i] - s[i] * sine[i];
            to_s[i] = c[i] * sine[i] + s[i] * cosine[i];
        }
    }
    basis
}

/// dr/dphi at the angles of `basis`.
pub fn harmonic_slope(basis: &Matrix, coefficients: &[f64]) -> Vec<f64> {
    let mut slope = vec![0.0; coefficients.len()];
    for k in 1..=coefficients.len() / 2 {
        slope[2 * k - 1] = k as f64 * coefficients[2 * k];
        slope[2 * k] = -(k as f64) * coefficients[2 * k - 1];
    }
    basis.combined(&slope)
}

/// `weights` 1 / u^2, zero where a point is not used.
pub fn fit_harmonics(basis: &Matrix, radii: &[f64], weights: &[f64], noise: &Noise, prior: Option<&[f64]>) -> Option<HarmonicFit> {
    let p = basis.rows();
    let weighted = basis.weighted(weights);
    let (mut precision, mut score) = (weighted.gram(basis), weighted.applied(radii));
    if !noise.correlation.is_empty() {
        let spread = noise.covariance_of(&weighted);
        let ridge: Vec<f64> = spread.diagonal().iter().map(|variance| variance * RIDGE).collect();
        // L^-1 precision: its square is precision spread^-1 precision
        let lower = spread.plus_diagonal(&ridge).cholesky()?;
        let mut right = Matrix::of(p, p + 1, |i, j| if j < p { precision.at(i, j) } else { score[i] });
        lower.forward(&mut right);
        let all = right.transposed().times(&right);
        precision = Matrix::of(p, p, |i, j| all.at(i, j));
        score = (0..p).map(|i| all.at(i, p)).collect();
    }
    let rounds = if prior.is_none() { ROUNDS } else { FURTHER_ROUNDS };
    let wide = |i: usize| if i < 3 { 0.0 } else { WIDE_PRIOR.powi(-2) };
    let mut prior: Vec<f64> = prior.map_or_else(|| (0..p).map(wide).collect(), <[f64]>::to_vec);
    let largest = precision.diagonal().into_iter().fold(f64::NEG_INFINITY, f64::max);
    let least: Vec<f64> = prior.iter().map(|&prior| if prior > 0.0 { LEAST_PRIOR * largest } else { 0.0 }).collect();
    let mut doubt = vec![0.0; p];
    for _ in 0..rounds {
        prior.iter_mut().zip(&least).for_each(|(prior, least)| *prior = prior.max(*least));
        let covariance = precision.clone().plus_diagonal(&prior).inverse()?;
        (prior, doubt) = judged(&covariance, &covariance.applied(&score), &prior);
    }
    let covariance = precision.clone().plus_diagonal(&prior).inverse()?;
    let mut without = prior.clone();
    without[3..5].fill(0.0);
    doubt[3..5].fill(0.0);
    let free_covariance = precision.clone().plus_diagonal(&without).inverse()?;
    let (coefficients, free) = (covariance.applied(&score), free_covariance.applied(&score));
    Some(HarmonicFit { coefficients, precision, prior, covariance, doubt, free, free_covariance })
}

/// New prior precision and doubt from the evidence of every harmonic given the others.
fn judged(covariance: &Matrix, coefficients: &[f64], prior: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut new_prior, mut doubt) = (vec![0.0; prior.len()], vec![0.0; prior.len()]);
    for k in 2..=prior.len() / 2 {
        let (even, odd) = (2 * k - 1, 2 * k);
        let p = covariance.at(even, even).max(SMALLEST_VARIANCE);
        let q = covariance.at(odd, odd).max(SMALLEST_VARIANCE);
        let cross = covariance.at(even, odd);
        let determinant = f64::max(p * q - cross * cross, RIDGE * p * q);
        let own = prior[even];
        let (s11, s22, s12) = (q / determinant - own, p / determinant - own, -cross / determinant);
        let (a, b) = (coefficients[even], coefficients[odd]);
        let (h1, h2) = ((q * a - cross * b) / determinant, (p * b - cross * a) / determinant);
        let scale = f64::max(0.5 * (s11 + s22), 1e-12);
        let inner = f64::max(s11 * s22 - s12 * s12, 1e-3 * scale * scale);
        let energy = f64::max(0.5 * (s22 * h1 * h1 - 2.0 * s12 * h1 * h2 + s11 * h2 * h2) / inner, 0.0);
        let ratio = f64::max(energy - 1.0, SMALLEST_SLAB);
        let shrink = ratio / (1.0 + ratio);
        let odds = PRIOR_ODDS * (2.0 / k as f64).powi(2);
        let bayes = odds * f64::min(energy * shrink, LARGEST_EVIDENCE).exp() / (1.0 + ratio);
        let present = bayes / (1.0 + bayes);
        let kept = f64::max(present * shrink.sqrt(), LEAST_KEPT);
        new_prior[even..=odd].fill(scale * (1.0 / kept - 1.0));
        doubt[even..=odd].fill(present * (1.0 - present) * shrink.sqrt().powi(2) * energy / scale);
    }
    (new_prior, doubt)
}

/// Weighted normal equations of a few rows: basis W basis^T and basis W radii.
pub fn normal_equations(basis: &Matrix, weights: &[f64], radii: &[f64]) -> (Matrix, Vec<f64>) {
    let weighted = basis.weighted(weights);
    (weighted.gram(basis), weighted.applied(radii))
}
