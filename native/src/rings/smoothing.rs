//! The line of a ring smoothed along itself, and how noisy it is here and there: the twin of `calibore.profiling._smoothing`.

use super::stripe::Stripe;

const REACH: usize = 10;
const WIDTH: usize = 2 * REACH + 1;
const LAG: usize = 8;
const SECOND_DIFFERENCE: f64 = 1.5;
const NOISE: f64 = 3.5;
const MEDIAN_OF_SQUARE: f64 = 0.4549;
const MEAN_OF_SQUARE: f64 = 0.9939;
const SECTOR: usize = 90;
const SECTORS: usize = 50;
const FEWEST: usize = 40;
const STEP: usize = 4;

/// `u`, `v` NaN where the ray has no peak; `off`: the peaks' distance from it; `noise` of the peaks; `smaller`: that of the line over it.
pub struct Smoothed {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub off: Vec<f64>,
    pub noise: Vec<f64>,
    pub smaller: f64,
}

pub fn smoothed(stripe: &Stripe) -> Smoothed {
    let (n, [column, row]) = (stripe.u.len(), stripe.centre.unwrap_or([0.0; 2]));
    let [du, dv] = stripe.direction;
    let position: Vec<f64> = (0..n).map(|i| (stripe.u[i] - column) * du[i] + (stripe.v[i] - row) * dv[i]).collect();
    let middle: Vec<f64> = (0..n).map(|i| if position[i].is_finite() { smooth_at(&position, i) } else { f64::NAN }).collect();
    let lag = LAG.max(stripe.correlation.len() + 1);
    let noise = local_scatter(&position, stripe.u_position, lag).iter().zip(stripe.u_position).map(|(local, u)| u * local).collect();
    Smoothed {
        u: (0..n).map(|i| column + middle[i] * du[i]).collect(),
        v: (0..n).map(|i| row + middle[i] * dv[i]).collect(),
        off: position.iter().zip(&middle).map(|(position, middle)| position - middle).collect(),
        noise,
        smaller: smaller(stripe.correlation),
    }
}

/// The median of the neighbours, moved to this ray along their local slope.
fn smooth_at(position: &[f64], i: usize) -> f64 {
    let n = position.len();
    let near: [f64; WIDTH] = std::array::from_fn(|k| position[(i + n + k - REACH) % n]);
    let mut steps: [f64; WIDTH - 2] = std::array::from_fn(|k| (near[k + 2] - near[k]) / 2.0);
    let slope = finite_median(&mut steps);
    let mut moved: [f64; WIDTH] = std::array::from_fn(|k| near[k] - slope * (k as f64 - REACH as f64));
    finite_median(&mut moved)
}

/// Median of the finite `values`, 0 where there is none.
fn finite_median(values: &mut [f64]) -> f64 {
    let mut known = 0;
    for i in 0..values.len() {
        if values[i].is_finite() {
            values.swap(known, i);
            known += 1;
        }
    }
    if known == 0 {
        0.0
    } else {
        super::statistics::median(&mut values[..known])
    }
}

/// Observed over stated scatter round a ring, from second differences at `lag`.
fn local_scatter(position: &[f64], u: &[f64], lag: usize) -> Vec<f64> {
    let n = position.len();
    let square = |i: usize| {
        let bend = position[i] - 0.5 * (position[(i + n - lag % n) % n] + position[(i + lag) % n]);
        bend * bend / (SECOND_DIFFERENCE * (u[i] * u[i]))
    };
    let squares: Vec<f64> = (0..n).map(square).collect();
    let places: Vec<usize> = (0..SECTORS).map(|k| (k as f64 * (n as f64 / SECTORS as f64)) as usize).collect();
    let mut known = Vec::with_capacity(2 * SECTOR + 1);
    let mut sector = |&place: &usize| {
        known.clear();
        known.extend(
            (0..=2 * SECTOR).map(|k| squares[(place + n * SECTOR.div_ceil(n) + k - SECTOR) % n]).filter(|square| square.is_finite()),
        );
        scatter_of(&mut known)
    };
    let local: Vec<f64> = places.iter().map(&mut sector).collect();
    let mut every = vec![0.0; n];
    for k in 0..SECTORS {
        let (from, low, high) = (places[k], local[k], local[(k + 1) % SECTORS]);
        let to = places.get(k + 1).copied().unwrap_or(n);
        (from..to).for_each(|i| every[i] = (high - low) / (to - from) as f64 * (i - from) as f64 + low);
    }
    every
}

fn scatter_of(squares: &mut [f64]) -> f64 {
    if squares.is_empty() {
        return 1.0;
    }
    let most = NOISE * NOISE * super::statistics::median(squares) / MEDIAN_OF_SQUARE;
    let (sum, count) = squares.iter().filter(|&&square| square <= most).fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
    let mean = sum / f64::from(count.max(1)) / MEAN_OF_SQUARE;
    if count as usize >= FEWEST && mean > 0.0 {
        mean.sqrt()
    } else {
        1.0
    }
}

/// Standard uncertainty of the running median over that of one peak, as the grid takes it.
fn smaller(correlation: &[f64]) -> f64 {
    let shared = |lag: usize| if lag == 0 { 1.0 } else { correlation.get(lag - 1).copied().unwrap_or(0.0) };
    let mean = |count: usize, of: &dyn Fn(f64) -> f64| {
        let pairs = (0..count).map(|lag| of(shared(lag)) * ((count - lag) * if lag == 0 { 1 } else { 2 }) as f64);
        pairs.sum::<f64>() / (count * count) as f64
    };
    (mean(WIDTH, &f64::asin) / mean(STEP, &|shared| shared)).sqrt()
}
