//! Lines brighter than the picture can show: which samples are clipped, and where a plateau has its middle (see the Python module `_plateau`).

use super::neighbours::reach_of;
use super::rays::{Ray, Rays};
use super::sampling::{Grey, Plane};
use super::settings::Settings;
use super::settle::Found;
use super::statistics::floor;
use super::walk::GROUP;
use super::windows::Windows;

const FEW: f64 = 0.05;
const NEARBY: f64 = 24.0;
const MOST: f64 = 0.5;
const BRIGHT: f64 = 0.7;
const WIDEST_PLATEAU: i64 = 48;
const HALF: f64 = 0.5;

/// Rays whose peaks may have clipped samples; none where few peaks are clipped, and nowhere most.
pub fn bright_rays(line: &Found, settings: &Settings, rays: &Rays) -> Option<Vec<bool>> {
    let white = settings.saturated_from();
    let tops = || line.height.iter().zip(line.base).map(|(height, base)| height + base);
    let bright = |(top, saturated): (f64, &bool)| *saturated || top >= BRIGHT * settings.white;
    let clipped = || tops().zip(line.saturated).map(|(top, saturated)| *saturated || top >= white);
    let (count, total) = (line.height.len(), clipped().filter(|clipped| *clipped).count());
    if total == 0 {
        return None;
    }
    let many = || {
        let reach = reach_of(count, NEARBY * settings.noise.width, rays.spacing);
        most_nearby(&clipped().collect::<Vec<bool>>(), reach, rays.closed) as f64 > MOST * (2 * reach + 1) as f64
    };
    (total as f64 > FEW * count as f64 || many()).then(|| tops().zip(line.saturated).map(bright).collect())
}

/// Most of the rays `within` of any that are `clipped`.
fn most_nearby(clipped: &[bool], reach: usize, closed: bool) -> usize {
    let (count, reach) = (clipped.len() as i64, reach as i64);
    let at = |ray: i64| {
        let seen =
            if closed { clipped.get(ray.rem_euclid(count) as usize) } else { usize::try_from(ray).ok().and_then(|ray| clipped.get(ray)) };
        usize::from(seen == Some(&true))
    };
    let mut near: usize = (-reach..=reach).map(at).sum();
    let mut most = near;
    for ray in 1..count {
        near = near + at(ray + reach) - at(ray - 1 - reach);
        most = most.max(near);
    }
    most
}

/// Puts the saturated peaks of `line` in the middle of their plateaus; the samples about all peaks.
pub fn on_plateaus<T: Grey>(plane: &Plane<T>, rays: &Rays, line: &mut Found, settings: &Settings) -> Vec<Vec<f64>> {
    let mut samples: Vec<Vec<f64>> = line.samples.iter().map(|samples| samples.to_vec()).collect();
    let (side, mut values) = (settings.side() as i64, vec![f64::NAN; rays.samples + GROUP]);
    let plateaus: Vec<usize> = (0..samples.len()).filter(|&ray| line.saturated[ray] && line.position[ray].is_finite()).collect();
    for ray in plateaus {
        let values = plane.whole(&rays.rays[ray], &mut values);
        let (middle, level) = (floor(line.position[ray] + 0.5), line.base[ray] + HALF * line.height[ray]);
        if let (Some(rise), Some(fall)) = (edge(values, middle, level, -1), edge(values, middle, level, 1)) {
            line.position[ray] = 0.5 * (rise + fall);
            let first = floor(line.position[ray] + 0.5) - side;
            samples[ray] = (first..=first + 2 * side).map(|at| at_or_none(values, at)).collect();
        }
    }
    samples
}

fn at_or_none(values: &[f64], at: i64) -> f64 {
    usize::try_from(at).ok().and_then(|at| values.get(at)).copied().unwrap_or(f64::NAN)
}

/// Where `values` fall below `level` on one `side` of the sample `middle`; none where they do not nearby.
fn edge(values: &[f64], middle: i64, level: f64, side: i64) -> Option<f64> {
    for step in 0..WIDEST_PLATEAU {
        let at = middle + side * step;
        let (here, beyond) = (at_or_none(values, at), at_or_none(values, at + side));
        if !(here >= level) {
            return None;
        }
        if beyond < level {
            return Some(at as f64 + side as f64 * ((here - level) / (here - beyond)));
        }
    }
    None
}

impl<T: Grey> Plane<'_, T> {
    /// Whether a pixel from `white` on has part in the sample at a place in fixed point that is inside.
    pub fn is_clipped(&self, [column, row]: [i64; 2], white: f64) -> bool {
        let parts = |place: i64, count: usize| {
            let whole = (place >> 32) as usize;
            let between = place as u32 >> 16 > 0 && whole + 1 < count;
            whole..=whole + usize::from(between)
        };
        parts(row, self.height).any(|row| {
            parts(column, self.width).any(|column| {
                let value: f64 = self.data[self.index(column, row)].into();
                value >= white
            })
        })
    }
}

impl Windows {
    pub fn is_bright(&self, number: usize) -> bool {
        self.bright.as_ref().is_some_and(|bright| bright[number])
    }

    /// Notes which samples of the window from `low` on, looked at from `start`, are clipped.
    pub fn note_clipped<T: Grey>(&mut self, plane: &Plane<T>, ray: &Ray, (low, start): (i64, f64), number: usize) {
        (self.white_bits[number], self.clipped[number]) = (0, -1.0);
        if !self.is_bright(number) {
            return;
        }
        let (track, group) = (ray.track(), self.window.len() / self.count);
        let fraction = floor(start + 0.5) as f64 - start;
        for k in 0..self.window.len() {
            if !self.window[k].is_nan() && plane.is_clipped(track.at((low + k as i64) as usize), self.white) {
                self.white_bits[number] |= 1 << (k / group);
                self.clipped[number] = self.clipped[number].max((self.offset(k / group) + fraction).abs());
            }
        }
    }
}
