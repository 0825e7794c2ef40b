//! The line along a set of rays: candidates, choice by continuity, uncertainty from model and scatter.

use super::choice::{line_among, Choice, NO_PEAK, RESOLVED, SATURATED};
use super::rays::Rays;
use super::ridge::ridges;
use super::sampling::{Grey, Plane};
use super::scan::{scan, Candidates};
use super::scatter;
use super::settings::{Estimator, Noise, Settings};

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

    /// The line in sight with its uncertainty.
    pub fn line<T: Grey>(self, plane: &Plane<T>, rays: &Rays, settings: Settings) -> Line {
        let count = rays.rays.len();
        let empty = || Vec::with_capacity(count);
        let (mut height, mut position, mut u_position, mut confidence, mut status) =
            (empty(), empty(), empty(), empty(), Vec::with_capacity(count));
        for chosen in self.chosen {
            let peak = self.candidates.peaks.get(chosen.pick).filter(|_| chosen.status <= RESOLVED);
            position.push(peak.map_or(f64::NAN, |peak| peak.position));
            u_position.push(peak.map_or(f64::NAN, |peak| peak.u));
            height.push(peak.map_or(f64::NAN, |peak| peak.height));
            status.push(if peak.is_some_and(|peak| peak.saturated) { SATURATED } else { chosen.status });
            confidence.push(chosen.confidence);
        }
        if settings.estimator == Estimator::Steger {
            (position, u_position) = ridges(plane, rays, &position, &height, &settings).into_iter().unzip();
            lost(&position, &mut height, &mut status);
        }
        let (u, v) = rays.rays.iter().zip(&position).map(|(ray, &place)| ray.at(place).into()).unzip();
        let scatter = scatter::observe(&position, &u_position, settings.noise.width, rays.spacing, rays.closed, settings.vectors);
        u_position.iter_mut().for_each(|u| *u *= scatter.scale);
        Line { u, v, u_position, status, height, correlation: scatter.correlation, confidence, noise: settings.noise, scale: scatter.scale }
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
