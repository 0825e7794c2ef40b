//! What interpolating between pixels does to a bright line (see the Python module `_smear`).

use super::rays::{Ray, Rays, ONE};
use super::windows::Windows;

const USUAL: f64 = 1.0 / 6.0;
const CORNERS: [[bool; 2]; 4] = [[false, false], [true, false], [false, true], [true, true]];

impl Windows {
    /// As if those rays of a ring on which the top of the line is `hidden`, and itself `height` and `width`, were sampled
    /// everywhere with the usual smear; rows and columns are not interpolated.
    pub fn unsmeared(mut self, rays: &Rays, hidden: &[bool], height: &[f64], width: f64) -> Windows {
        for number in (0..hidden.len()).filter(|&number| rays.closed && hidden[number]) {
            self.unsmear(&rays.rays[number], number, (height[number], width));
        }
        self
    }

    /// The same of one ray.
    pub fn unsmear(&mut self, ray: &Ray, number: usize, (height, width): (f64, f64)) {
        if !(height > 0.0) {
            return;
        }
        let (group, track) = (self.apart as usize, ray.track());
        let narrow = (width * width - USUAL).max(0.5 * width * width).sqrt();
        let (inverse, usual, lift) = (-0.5 / (narrow * narrow), -0.5 / (width * width), width / narrow);
        let begin = self.offset(0) + self.fraction[number] - (group - 1) as f64 / 2.0;
        for k in 0..self.count {
            let more = |sample: usize| {
                let place = |axis: usize| track.start[axis] + (self.first[number] + sample as i64) * track.step[axis];
                let part = [place(0), place(1)].map(|place| place.rem_euclid(ONE) as f64 / ONE as f64);
                let distance = begin + sample as f64;
                let seen = CORNERS.map(|far| {
                    let of = |axis: usize| if far[axis] { part[axis] } else { 1.0 - part[axis] };
                    let aside = |axis: usize| (f64::from(u8::from(far[axis])) - part[axis]) * ray.direction[axis];
                    of(0) * of(1) * (inverse * (distance + (aside(0) + aside(1))).powi(2)).exp()
                });
                seen.iter().sum::<f64>() * lift - (usual * distance * distance).exp()
            };
            let mean = (k * group..(k + 1) * group).map(more).sum::<f64>() / group as f64;
            self.darken(number, k, height * mean);
        }
    }
}
