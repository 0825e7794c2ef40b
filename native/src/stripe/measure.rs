//! The line along a set of rays: candidates, choice by continuity, uncertainty from model and scatter.

use super::choice::{line_among, Choice, NO_PEAK, RESOLVED, SATURATED};
use super::rays::Rays;
use super::ridge::ridges;
use super::sampling::{Grey, Plane};
use super::scan::{scan, Candidates};
use super::scatter;
use super::settings::{Estimator, Noise, Settings};
use super::settle::{settle, Found};

/// The measured line (see the Python class `Stripe`).
pub struct Line {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub u_position: Vec<f64>,
    pub status: Vec<u8>,
    pub height: Vec<f64>,
    pub correlation: Vec<f64>,
    pub confidence: Vec<f64>,
    pub noise: Noise,
    pub scale: f64,
}

/// The candidates along a set of rays, and which of them is the line on each.
pub struct Sight {
    pub candidates: Candidates,
    pub chosen: Vec<Choice>,
}

impl Sight {
    /// Peaks of every ray are looked for within its `span` of samples.
    pub fn along<T: Grey>(plane: &Plane<T>, rays: &Rays, settings: &Settings, span: impl Fn(usize) -> (usize, usize)) -> Sight {
        Sight::among(plane, rays, scan(plane, rays, settings, span), settings.noise.width)
    }

    pub fn among<T: Grey>(plane: &Plane<T>, rays: &Rays, candidates: Candidates, width: f64) -> Sight {
        let chosen = line_among(plane, rays, &candidates, width);
        Sight { candidates, chosen }
    }

    /// The line in sight, looked at again, with its uncertainty.
    pub fn line<T: Grey>(self, plane: &Plane<T>, rays: &Rays, settings: Settings) -> Line {
        let count = rays.rays.len();
        let empty = || Vec::with_capacity(count);
        let mut samples = Vec::with_capacity(count);
        let (mut height, mut base, mut position, mut u_position, mut confidence, mut status) =
            (empty(), empty(), empty(), empty(), empty(), Vec::with_capacity(count));
        for chosen in self.chosen {
            let peak = self.candidates.peaks.get(chosen.pick).filter(|_| chosen.status <= RESOLVED);
            position.push(peak.map_or(f64::NAN, |peak| peak.position));
            u_position.push(peak.map_or(f64::NAN, |peak| peak.u));
            height.push(peak.map_or(f64::NAN, |peak| peak.height));
            base.push(peak.map_or(f64::NAN, |peak| peak.background));
            status.push(if peak.is_some_and(|peak| peak.saturated) { SATURATED } else { chosen.status });
            samples.push(peak.map_or(&[][..], |peak| self.candidates.samples(peak)));
            confidence.push(chosen.confidence);
        }
        if settings.estimator == Estimator::Steger {
            (position, u_position) = ridges(plane, rays, &position, &height, &settings).into_iter().unzip();
            lost(&position, &mut height, &mut status);
        }
        let saturated: Vec<bool> = status.iter().map(|&status| status == SATURATED).collect();
        let line =
            Found { position: &mut position, u: &mut u_position, height: &height, base: &base, saturated: &saturated, samples: &samples };
        let noise = settle(plane, rays, line, &settings);
        let (u, v) = rays.rays.iter().zip(&position).map(|(ray, &place)| ray.at(place).into()).unzip();
        let scatter = scatter::observe(&position, &u_position, noise.width, rays.spacing, rays.closed, settings.vectors);
        u_position.iter_mut().for_each(|u| *u *= scatter.scale);
        Line { u, v, u_position, status, height, correlation: scatter.correlation, confidence, noise, scale: scatter.scale }
    }
}

/// Where an estimator has found no place, there is no peak.
fn lost(position: &[f64], height: &mut [f64], status: &mut [u8]) {
    for ((position, height), status) in position.iter().zip(height).zip(status) {
        if position.is_nan() {
            *height = f64::NAN;
            if *status <= SATURATED {
                *status = NO_PEAK;
            }
        }
    }
}
