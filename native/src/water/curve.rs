//! The wall's curve about the rig axis: a series in the clock.

use std::f64::consts::{PI, TAU};

use super::FEWEST_OF_WALL;
use crate::rings::gridding::root_of_squares;
use crate::rings::matrix::Matrix;
use crate::rings::statistics::{median, turned};

pub const OFF: f64 = 0.05;
const CROWN: f64 = 75.0 * PI / 180.0;
const DRY: f64 = 115.0 * PI / 180.0;
const ROUNDS: usize = 5;
const OVAL: f64 = 0.0035;
const MOST_TERMS: usize = 5;
const CIRCLE: usize = 3;

/// Some points of the ring, with the terms of the series at their clocks and how far they lie from the axis and from the crown.
pub struct Sample {
    pub points: Vec<[f64; 3]>,
    terms: Vec<[f64; MOST_TERMS]>,
    reach: Vec<f64>,
    from_crown: Vec<f64>,
}

impl Sample {
    pub fn of(points: impl Iterator<Item = ([f64; 3], f64)>) -> Self {
        let (points, clock): (Vec<_>, Vec<f64>) = points.unzip();
        let reach = points.iter().map(|[x, y, _]| root_of_squares(*x, *y)).collect();
        let from_crown = clock.iter().map(|clock| (turned(clock + PI, TAU) - PI).abs()).collect();
        Sample { terms: clock.into_iter().map(terms).collect(), points, reach, from_crown }
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// How far the points lie outside the `wall`.
    pub fn off<'a>(&'a self, wall: &'a Curve) -> impl Iterator<Item = f64> + 'a {
        self.reach.iter().zip(&self.terms).map(|(reach, terms)| reach - wall.at(terms))
    }
}

/// 1, cos, sin, cos 2, sin 2.
fn terms(clock: f64) -> [f64; MOST_TERMS] {
    let (sine, cosine) = clock.sin_cos();
    let (twice_sine, twice_cosine) = (2.0 * clock).sin_cos();
    [1.0, cosine, sine, twice_cosine, twice_sine]
}

/// Its terms, those that it does not have 0.
#[derive(Clone, Copy)]
pub struct Curve([f64; MOST_TERMS]);

impl Curve {
    pub fn radius(&self) -> f64 {
        self.0[0]
    }

    fn at(&self, terms: &[f64; MOST_TERMS]) -> f64 {
        self.0.iter().zip(terms).map(|(a, b)| a * b).sum()
    }

    pub fn off(&self, [x, y, _]: [f64; 3], clock: f64) -> f64 {
        root_of_squares(x, y) - self.at(&terms(clock))
    }

    /// Drawn first from the crown, then from what is near of the points that `may` be wall.
    fn through(sample: &Sample, may: impl Fn(usize) -> bool, most: usize) -> Option<Curve> {
        let mut near: Vec<usize> = (0..sample.len()).filter(|&i| sample.from_crown[i] < CROWN).collect();
        let mut wall = None;
        for round in 0..ROUNDS {
            if near.len() < FEWEST_OF_WALL {
                return None;
            }
            let curve = Curve::fitted(sample, &near, if round < 2 { CIRCLE } else { most })?;
            let reach = OFF * curve.radius();
            near = sample.off(&curve).enumerate().filter(|&(i, off)| may(i) && off.abs() < reach).map(|(i, _)| i).collect();
            wall = Some(curve);
        }
        wall
    }

    fn fitted(sample: &Sample, some: &[usize], count: usize) -> Option<Curve> {
        let (mut normal, mut right) = ([[0.0; MOST_TERMS]; MOST_TERMS], [0.0; MOST_TERMS]);
        for &i in some {
            let terms = &sample.terms[i];
            for j in 0..MOST_TERMS {
                right[j] += terms[j] * sample.reach[i];
                (0..=j).for_each(|k| normal[j][k] += terms[j] * terms[k]);
            }
        }
        let normal = Matrix::of(count, count, |j, k| normal[j.max(k)][j.min(k)]);
        let solved = normal.solved(&right[..count])?;
        let mut series = [0.0; MOST_TERMS];
        series[..count].copy_from_slice(&solved);
        Some(Curve(series))
    }
}

/// An oval through most of the ring; and, where it does not describe the ring as well as one describes a pipe, the circle of the upper
/// half. Whether glints can be told by each.
pub fn walls(sample: &Sample) -> Vec<(bool, Curve)> {
    let Some(oval) = Curve::through(sample, |_| true, MOST_TERMS) else { return vec![] };
    let mut off: Vec<f64> = sample.off(&oval).map(f64::abs).collect();
    let mut found = vec![(true, oval)];
    if median(&mut off) >= OVAL * oval.radius() {
        found.extend(Curve::through(sample, |i| sample.from_crown[i] < DRY, CIRCLE).map(|upper| (false, upper)));
    }
    found
}
