//! Eight peaks with the samples about them, one in each lane, to be described and fitted together.

use super::lanes::{Lanes, LANES};
use super::learn::LARGEST_WINDOW;
use super::settings::{Settings, WIDEST_FIT};

/// Most samples on each side of a peak.
const FARTHEST: usize = if LARGEST_WINDOW as usize + 2 > WIDEST_FIT { LARGEST_WINDOW as usize + 2 } else { WIDEST_FIT };

/// Most samples in a Gauss-Newton window.
pub const MOST: usize = 2 * WIDEST_FIT + 1;
static NOTHING: [Lanes; MOST] = [Lanes::ZERO; MOST];

pub struct Batch {
    pub filled: usize,
    /// The ray of each.
    pub rays: [usize; LANES],
    /// Zero crossing of the slope, the part of it between two windows, and the sample in the middle.
    pub position: Lanes,
    pub fraction: Lanes,
    pub middle: Lanes,
    /// Middle sample minus position.
    pub offset: Lanes,
    /// Brightness at the position.
    pub top: Lanes,
    pub shape: Shape,
    /// Samples on each side of the middle one.
    side: usize,
    /// NaN outside the picture and the ray; longer than wanted, because what reads a known number of samples is compiled better.
    window: [Lanes; 2 * FARTHEST + 1 + MOST],
}

/// How peaks stand out, if they do; `base` is the higher background of their two sides, `rise` and `fall` are the places of half height.
#[derive(Clone, Copy)]
pub struct Shape {
    pub height: Lanes,
    pub background: Lanes,
    pub base: Lanes,
    pub rise: Lanes,
    pub fall: Lanes,
    pub stands: [bool; LANES],
    pub saturated: [bool; LANES],
}

impl Batch {
    pub fn new(settings: &Settings) -> Self {
        let (none, no) = (Lanes::ZERO, [false; LANES]);
        Batch {
            filled: 0,
            rays: [0; LANES],
            position: none,
            fraction: none,
            middle: none,
            offset: none,
            top: none,
            shape: Shape { height: none, background: none, base: none, rise: none, fall: none, stands: no, saturated: no },
            side: settings.side(),
            window: [none; 2 * FARTHEST + 1 + MOST],
        }
    }

    /// Adds the peak at `position` on a ray of samples `y`; true once the batch is full.
    #[inline(always)]
    pub fn add(&mut self, y: &[f64], (position, fraction): (f64, f64), ray: usize) -> bool {
        let (lane, middle, whole) = (self.filled, (position + 0.5) as usize, position as usize);
        self.rays[lane] = ray;
        (self.position.0[lane], self.fraction.0[lane], self.middle.0[lane]) = (position, fraction, middle as f64);
        self.offset.0[lane] = middle as f64 - position;
        self.top.0[lane] = y[whole] + (y[whole + 1] - y[whole]) * (position - whole as f64);
        let window = &mut self.window[..2 * self.side + 1];
        match middle.checked_sub(self.side).and_then(|low| y.get(low..=middle + self.side)) {
            Some(samples) => window.iter_mut().zip(samples).for_each(|(lanes, sample)| lanes.0[lane] = *sample),
            None => {
                for (k, lanes) in window.iter_mut().enumerate() {
                    lanes.0[lane] = (middle + k).checked_sub(self.side).and_then(|at| y.get(at)).copied().unwrap_or(f64::NAN);
                }
            }
        }
        self.filled += 1;
        self.filled == LANES
    }

    /// Samples from `reach` before the middle ones to as many after.
    #[inline(always)]
    pub fn about(&self, reach: usize) -> &[Lanes] {
        &self.window[self.side - reach..=self.side + reach]
    }

    /// Samples from `half` before the middle ones on, in as many places as any fit may ask for.
    #[inline(always)]
    pub fn to_fit(&self, half: usize) -> &[Lanes; MOST] {
        self.window[self.side - half..].first_chunk().unwrap_or(&NOTHING)
    }

    /// Adds all samples about one peak to `kept`.
    pub fn keep(&self, lane: usize, kept: &mut Vec<f64>) {
        kept.extend(self.window[..2 * self.side + 1].iter().map(|lanes| lanes.0[lane]));
    }

    /// The same of one peak, and where on its ray they begin.
    pub fn samples(&self, lane: usize, reach: usize) -> (f64, Vec<f64>) {
        (self.middle.0[lane] - reach as f64, self.about(reach).iter().map(|lanes| lanes.0[lane]).collect())
    }
}
