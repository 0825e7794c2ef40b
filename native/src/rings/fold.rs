//! What is left to measure where camera rays graze a cone of light: the twin of `calibore.profiling._fold`, which tells why.

use super::line::status;
use super::path::follow;
use super::smoothing::smoothed;
use super::stripe::{Rig, Stripe};
use crate::meeting::fold::{candidates, margins, Folding};

const NEAR_FOLD: f64 = 25.0;
const NOISE: f64 = 4.0;
const MEASURABLE: f64 = 1.0;

/// Margins that rise by equal steps, and the enlargement of the uncertainty at each.
#[derive(Clone, Copy)]
pub struct Enlargements<'a> {
    pub margin: &'a [f64],
    pub by: &'a [f64],
}

impl Enlargements<'_> {
    /// As at the ends below the first; 1 above the last and where there is no margin.
    fn at(&self, margin: f64) -> f64 {
        let last = self.margin.len() - 1;
        if !margin.is_finite() || margin > self.margin[last] {
            return 1.0;
        }
        let before = self.margin.partition_point(|&at| at <= margin).saturating_sub(1).min(last - 1);
        let (from, to) = (self.margin[before], self.margin[before + 1]);
        let slope = (self.by[before + 1] - self.by[before]) / (to - from);
        slope * (margin.max(from) - from) + self.by[before]
    }
}

/// What is placed of a closed stripe: pixels on `branch` of uncertainty `u_position` but for the `enlargement`; rays that graze the cone.
pub struct OnCone {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub branch: Vec<f64>,
    pub u_position: Vec<f64>,
    pub enlargement: Vec<f64>,
    pub grazing: Vec<bool>,
}

pub fn line_on_cone(stripe: &Stripe, rig: &Rig, (prior, enlargements): (f64, Enlargements)) -> OnCone {
    let (line, n) = (smoothed(stripe), stripe.u.len());
    let branch = follow(&candidates(rig.make, rig.parameters, &line.u, &line.v), prior);
    let noise: Vec<f64> = line.noise.iter().map(|noise| rig.stated.unwrap_or(noise * line.smaller)).collect();
    let rays = Folding { u: &line.u, v: &line.v, direction: stripe.direction, noise: &noise, branch: &branch };
    let margin = margins(rig.make, rig.parameters, rig.modes, &rays);
    let smooth: Vec<bool> = (0..n).map(|i| margin[i] < NEAR_FOLD && line.off[i].abs() <= NOISE * line.noise[i]).collect();
    let either = |ours: &[f64], theirs: &[f64]| (0..n).map(|i| if smooth[i] { ours[i] } else { theirs[i] }).collect();
    let narrowed: Vec<f64> = line.noise.iter().map(|noise| noise * line.smaller).collect();
    OnCone {
        u: either(&line.u, stripe.u),
        v: either(&line.v, stripe.v),
        u_position: either(&narrowed, &line.noise),
        enlargement: margin.iter().map(|&margin| enlargements.at(margin)).collect(),
        grazing: (0..n).map(|i| stripe.status[i] <= status::SATURATED && (margin[i].is_nan() || margin[i] <= MEASURABLE)).collect(),
        branch,
    }
}
