//! The wall estimated from one ring: the twin of `calibore.metrics._wall`.

use super::centre::robust_centre;
use super::circle::robust_circle;
use super::features::{feature_between, Feature};
use super::harmonics::{fit_harmonics, harmonic_basis, harmonic_count, harmonic_slope, normal_equations, HarmonicFit};
use super::matrix::Matrix;
use super::noise::{possible, Noise};
use super::statistics::{spread, turned};
use super::stretches::{lone_points, sharp_jumps, split_runs, stretches};
use std::borrow::Cow;
use std::f64::consts::TAU;

const START_HARMONICS: usize = 6;
const START_ROUNDS: usize = 4;
const START_RIDGE: f64 = 1e-3;
const CAUCHY: f64 = 2.5;
const PASSES: usize = 5;
const LEAST_SIGMA: f64 = 1e-6;
const LEAST_PROJECTION: f64 = 0.2;
const LEAST_RADIUS: f64 = 0.1;
const FEWEST_PAIRS: usize = 20;
const FEWEST_PLAIN: f64 = 12.0;
const LEAST_PLAIN: f64 = 0.2;
const EXCESS_NOISE: f64 = 1.4;

/// `radius` NaN where nothing was measured; `sine`, `cosine` of the clock.
pub struct Ring<'a> {
    pub sine: &'a [f64],
    pub cosine: &'a [f64],
    pub radius: &'a [f64],
    pub u: &'a [f64],
    pub correlation: &'a [f64],
    pub drawn: &'a [[usize; 3]],
}

/// The points about the centre, in units of the scale; `cosine`, `sine` of the angle between the rays of rig and centre; `basis` of all
/// harmonics at their angles.
pub struct Polar {
    pub angle: Vec<f64>,
    pub radius: Vec<f64>,
    pub cosine: Vec<f64>,
    pub sine: Vec<f64>,
    pub basis: Matrix,
}

pub struct Wall {
    pub scale: f64,
    pub centre: [f64; 2],
    pub polar: Polar,
    pub fit: HarmonicFit,
    pub noise: Noise,
    pub featured: Vec<bool>,
    pub used: Vec<bool>,
    pub excess: f64,
}

/// What a pass starts from and the next one improves.
struct Guess {
    used: Vec<bool>,
    featured: Vec<bool>,
    slope: Vec<f64>,
    excess: Option<f64>,
    prior: Option<Vec<f64>>,
}

/// What does not change from pass to pass.
struct Stated {
    polar: Polar,
    measured: Vec<bool>,
    sigma: Vec<f64>,
    correlation: Vec<f64>,
}

struct Fitted {
    fit: HarmonicFit,
    noise: Noise,
    excess: f64,
}

pub fn estimate_wall(ring: &Ring) -> Option<Wall> {
    let measured: Vec<bool> = ring.radius.iter().map(|radius| radius.is_finite()).collect();
    let of = |values: Vec<f64>| values.into_iter().zip(&measured).filter(|(_, measured)| **measured).map(|(value, _)| value).collect();
    let x: Vec<f64> = of(ring.radius.iter().zip(ring.sine).map(|(radius, sine)| radius * sine).collect());
    let y: Vec<f64> = of(ring.radius.iter().zip(ring.cosine).map(|(radius, cosine)| -radius * cosine).collect());
    let circle = robust_circle(&x, &y, ring.drawn)?;
    let scale = circle.radius;
    let stated_u = ring.u.iter().zip(&measured).map(|(&u, &measured)| if measured { u / scale } else { 0.0 });
    let sigma: Vec<f64> = stated_u.map(|sigma| sigma.max(LEAST_SIGMA)).collect();
    let (unit_x, unit_y): (Vec<f64>, Vec<f64>) = (x.iter().map(|x| x / scale).collect(), y.iter().map(|y| y / scale).collect());
    let centre = robust_centre(&unit_x, &unit_y, &of(sigma.clone()), [circle.x / scale, circle.y / scale])?;
    let polar = Polar::about(centre, ring, scale);
    let correlation = possible(ring.correlation, ring.radius.len());
    let stated = Stated { polar, measured, sigma, correlation };
    let mut guess = stated.robust_start()?;
    let (mut fitted, mut better) = stated.pass(&guess)?;
    for _ in 1..PASSES {
        if guess.prior.is_some() && better.featured == guess.featured && better.used == guess.used {
            break;
        }
        guess = better;
        (fitted, better) = stated.pass(&guess)?;
    }
    let Fitted { fit, noise, excess } = fitted;
    let inside = fit.coefficients[0] > 0.5 && fit.coefficients[0] < 2.0 && fit.coefficients.iter().all(|c| c.is_finite());
    inside.then_some(Wall { scale, centre, polar: stated.polar, fit, noise, featured: guess.featured, used: guess.used, excess })
}

impl Polar {
    fn about(centre: [f64; 2], ring: &Ring, scale: f64) -> Self {
        let n = ring.radius.len();
        let [mut angle, mut radius, mut cosine, mut sine, mut c, mut s] = [const { Vec::new() }; 6];
        for i in 0..n {
            let measured = ring.radius[i].is_finite();
            let length = if measured { ring.radius[i] / scale } else { 0.0 };
            let (x, y) = (length * ring.sine[i] - centre[0], -length * ring.cosine[i] - centre[1]);
            let away = x.hypot(y);
            let (across, along) = if away > 0.0 { (x / away, -y / away) } else { (0.0, 1.0) };
            angle.push(super::statistics::clock_of(x, y));
            radius.push(if measured { away } else { 0.0 });
            cosine.push(ring.cosine[i] * along + ring.sine[i] * across);
            sine.push(ring.sine[i] * along - ring.cosine[i] * across);
            c.push(along);
            s.push(across);
        }
        let basis = harmonic_basis(&c, &s, harmonic_count(n).max(START_HARMONICS));
        Polar { angle, radius, cosine, sine, basis }
    }

    fn basis_of(&self, harmonics: usize) -> Cow<'_, Matrix> {
        let (n, rows) = (self.basis.columns, 2 * harmonics + 1);
        if rows == self.basis.rows() {
            return Cow::Borrowed(&self.basis);
        }
        Cow::Owned(Matrix { columns: n, values: self.basis.values[..rows * n].to_vec() })
    }
}

impl Stated {
    /// The wall fitted with what `guess` believes of features, and the better guess it leads to.
    fn pass(&self, guess: &Guess) -> Option<(Fitted, Guess)> {
        let (polar, n) = (&self.polar, guess.used.len());
        let mut plain: Vec<bool> = guess.used.iter().zip(&guess.featured).map(|(&used, &featured)| used && !featured).collect();
        if (count(&plain) as f64) < f64::max(FEWEST_PLAIN, LEAST_PLAIN * count(&guess.used) as f64) {
            plain.clone_from(&guess.used);
        }
        let basis = polar.basis_of(harmonic_count(count(&plain)));
        let noisy = |i: usize| {
            let projection = f64::max((polar.cosine[i] - guess.slope[i] * polar.sine[i]).abs(), LEAST_PROJECTION);
            self.sigma[i] * projection * guess.excess.unwrap_or(1.0)
        };
        let sigma: Vec<f64> = (0..n).map(|i| if self.measured[i] { noisy(i) } else { 0.0 }).collect();
        let noise = Noise { sigma, correlation: self.correlation.clone() };
        let weights: Vec<f64> = (0..n).map(|i| if plain[i] { noise.sigma[i].powi(-2) } else { 0.0 }).collect();
        let prior = guess.prior.as_deref().filter(|prior| prior.len() == basis.rows());
        let fit = fit_harmonics(&basis, &polar.radius, &weights, &noise, prior)?;
        let smooth = basis.combined(&fit.coefficients);
        let standardised = |i: usize| if guess.used[i] { (polar.radius[i] - smooth[i]) / noise.sigma[i] } else { 0.0 };
        let mut off: Vec<f64> = (0..n).map(standardised).collect();
        let excess = guess.excess.unwrap_or_else(|| excess_of(&off, &plain, &noise.correlation));
        off.iter_mut().for_each(|off| *off *= guess.excess.unwrap_or(1.0) / excess);
        let lone = lone_points(&off, &guess.used);
        let used: Vec<bool> = guess.used.iter().zip(&lone).map(|(&used, &lone)| used && !lone).collect();
        let mut slope = harmonic_slope(&basis, &fit.coefficients);
        slope.iter_mut().zip(&smooth).for_each(|(slope, smooth)| *slope /= smooth.max(LEAST_RADIUS));
        let featured = stretches(&off, &used, &noise);
        let better = Guess { used, featured, slope, excess: Some(excess), prior: Some(fit.prior.clone()) };
        Some((Fitted { fit, noise, excess }, better))
    }

    /// A low series fitted with weights that let features go.
    fn robust_start(&self) -> Option<Guess> {
        let (polar, used, n) = (&self.polar, &self.measured, self.measured.len());
        let basis = polar.basis_of(harmonic_count(count(used)).min(START_HARMONICS));
        let ridge: Vec<f64> = (0..basis.rows()).map(|i| if i < 3 { 0.0 } else { START_RIDGE * count(used) as f64 }).collect();
        let mut weights: Vec<f64> = used.iter().map(|&used| f64::from(u8::from(used))).collect();
        let mut off = vec![0.0; n];
        for _ in 0..START_ROUNDS {
            let (normal, right) = normal_equations(&basis, &weights, &polar.radius);
            let fitted = basis.combined(&normal.plus_diagonal(&ridge).solved(&right)?);
            off = (0..n).map(|i| if used[i] { polar.radius[i] - fitted[i] } else { 0.0 }).collect();
            let scatter = self.spread_of_used(&off) + LEAST_SIGMA;
            let weight = |i: usize| if used[i] { (1.0 + (off[i] / (CAUCHY * scatter)).powi(2)).powi(-2) } else { 0.0 };
            weights = (0..n).map(weight).collect();
        }
        off.iter_mut().zip(&self.sigma).for_each(|(off, sigma)| *off /= sigma);
        let scatter = self.spread_of_used(&off).max(1.0);
        off.iter_mut().for_each(|off| *off /= scatter);
        let noise = Noise { sigma: self.sigma.clone(), correlation: self.correlation.clone() };
        let featured = stretches(&off, used, &noise);
        Some(Guess { used: used.clone(), featured, slope: vec![0.0; n], excess: None, prior: None })
    }

    fn spread_of_used(&self, values: &[f64]) -> f64 {
        spread(values.iter().zip(&self.measured).filter(|(_, used)| **used).map(|(value, _)| *value))
    }
}

impl Wall {
    pub fn basis(&self) -> Cow<'_, Matrix> {
        self.polar.basis_of(self.fit.coefficients.len() / 2)
    }

    /// An edge lies between this point and the next measured one.
    pub fn edges(&self) -> Vec<bool> {
        let order = self.order();
        let pick = |values: &[f64]| order.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let sharp = sharp_jumps(&pick(&self.polar.radius), &pick(&self.noise.sigma));
        let mut edges = vec![false; self.used.len()];
        order.iter().zip(sharp).for_each(|(&i, sharp)| edges[i] = sharp);
        edges
    }

    /// The points that count.
    pub fn order(&self) -> Vec<usize> {
        (0..self.used.len()).filter(|&i| self.used[i]).collect()
    }

    /// The features with the columns of `grid` that belong to them: to half a step beyond their ends.
    pub fn features(&self, grid: &[f64], residuals: &[f64]) -> Option<Vec<Feature>> {
        let (angle, n) = (&self.polar.angle, self.used.len());
        let between =
            |from: usize, to: usize, end: usize| if self.used[end] { turned(angle[to] - angle[from], TAU) } else { TAU / n as f64 };
        let mut found = vec![];
        for points in split_runs(&self.featured, &self.edges()) {
            let (first, last) = (points[0], points[points.len() - 1]);
            let (before, after) = ((first + n - 1) % n, (last + 1) % n);
            let start = angle[first] - between(before, first, before) / 2.0;
            let stop = angle[last] + between(last, after, after) / 2.0;
            let extent = if points.len() < n { turned(stop - start, TAU) } else { f64::INFINITY };
            let columns = (0..grid.len()).filter(|&i| turned(grid[i] - start, TAU) < extent).collect();
            found.push(feature_between(points, columns, (angle, grid), residuals, &self.noise)?);
        }
        Some(found)
    }
}

fn count(mask: &[bool]) -> usize {
    mask.iter().filter(|&&on| on).count()
}

/// How far the differences of neighbours exceed the stated noise; 1 where they do not exceed it clearly.
fn excess_of(off: &[f64], plain: &[bool], correlation: &[f64]) -> f64 {
    let n = off.len();
    let pairs: Vec<usize> = (0..n).filter(|&i| plain[i] && plain[(i + 1) % n]).collect();
    if pairs.len() < FEWEST_PAIRS {
        return 1.0;
    }
    let expected = (2.0 * f64::max(1.0 - correlation.first().copied().unwrap_or(0.0), 0.05)).sqrt();
    let excess = spread(pairs.iter().map(|&i| off[(i + 1) % n] - off[i])) / expected;
    if excess > EXCESS_NOISE {
        excess
    } else {
        1.0
    }
}
