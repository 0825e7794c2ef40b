//! The centre of a ring without its features: the twin of `calibore.metrics._centre`.

use super::harmonics::{harmonic_basis, normal_equations};
use super::statistics::{median, spread};

const HARMONICS: usize = 2;
const TUKEY: f64 = 4.685;
const ROUNDS: usize = 12;
const TUKEY_ROUNDS: usize = 8;
const SETTLED: f64 = 1e-7;
const RIDGE: f64 = 1e-9;

/// The centre reached from `start`, of points with standard uncertainties `sigma`, mean radius about 1.
pub fn robust_centre(x: &[f64], y: &[f64], sigma: &[f64], start: [f64; 2]) -> Option<[f64; 2]> {
    let (mut centre, mut coefficients) = (start, vec![0.0; 2 * HARMONICS + 1]);
    for _ in 0..ROUNDS {
        let away: Vec<(f64, f64)> = x.iter().zip(y).map(|(x, y)| (x - centre[0], y - centre[1])).collect();
        let radius: Vec<f64> = away.iter().map(|(x, y)| x.hypot(*y)).collect();
        let cosine: Vec<f64> = away.iter().zip(&radius).map(|((_, y), radius)| -y / radius).collect();
        let sine: Vec<f64> = away.iter().zip(&radius).map(|((x, _), radius)| x / radius).collect();
        if coefficients[0] == 0.0 {
            coefficients[0] = median(&mut radius.clone());
        }
        let basis = harmonic_basis(&cosine, &sine, HARMONICS);
        for _ in 0..TUKEY_ROUNDS {
            let fitted = basis.combined(&coefficients);
            let off: Vec<f64> = radius.iter().zip(&fitted).map(|(radius, fitted)| radius - fitted).collect();
            let scatter = spread(off.iter().copied());
            let weight = |(off, sigma): (&f64, &f64)| f64::max(1.0 - (off / (TUKEY * (scatter + sigma))).powi(2), 0.0).powi(2);
            let weights: Vec<f64> = off.iter().zip(sigma).map(weight).collect();
            let (normal, right) = normal_equations(&basis, &weights, &off);
            let step = normal.plus_diagonal(&[RIDGE * radius.len() as f64; 2 * HARMONICS + 1]).solved(&right)?;
            coefficients.iter_mut().zip(&step).for_each(|(value, step)| *value += step);
            if step.iter().all(|step| step.abs() < SETTLED) {
                break;
            }
        }
        let shift = [coefficients[2], -coefficients[1]];
        centre = [centre[0] + shift[0], centre[1] + shift[1]];
        coefficients[1..3].fill(0.0);
        if shift.iter().all(|shift| shift.abs() < SETTLED) {
            break;
        }
    }
    (centre[0].hypot(centre[1]) < 1.0).then_some(centre)
}
