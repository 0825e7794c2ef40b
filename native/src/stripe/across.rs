//! Speckle across the line, learnt from the line itself (see the Python module `_across`).

use super::breadth::width_of;
use super::neighbours::Standpoint;
use super::noise::MOST_CONTRAST;
use super::settings::Noise;
use super::statistics::median;
use super::windows::{Pattern, Windows};

const CORE: f64 = 1.5;
const BRIGHTEST: f64 = 4.0;
const FEWEST: f64 = 50.0;
const SHORTEST_GRAIN: f64 = 0.5;
const LONGEST_GRAIN: f64 = 1e3;
const LEAST_CONTRAST: f64 = 1e-6;

/// `noise` with contrast and grain from samples one and two apart; from one ray in `every`; `base` is the background of every ray's peak.
/// `flank`: how far from the middle samples are clipped near every ray.
pub fn speckle_across(windows: &Windows, stand: &Standpoint, (base, flank, every): (&[f64], Option<&[f64]>, usize), noise: Noise) -> Noise {
    let (middle, apart) = (windows.count / 2, windows.apart);
    let calm = || (0..stand.calm.len()).step_by(every).filter(|&ray| stand.calm[ray]);
    let mut known: Vec<f64> = calm().map(|ray| base[ray]).collect();
    if known.is_empty() {
        return noise;
    }
    let background = median(&mut known);
    let hidden = flank.map_or(0.0, |flank| median(&mut calm().map(|ray| flank[ray]).collect::<Vec<f64>>()).max(0.0));
    let core = (((CORE * noise.width + hidden) / apart + 0.5) as usize).clamp(1, middle);
    let columns = 2 * core + 1;
    // 1 / bell where there is a sample
    let over = |pattern: &Pattern, k: usize| match pattern.missing >> k & 1 {
        0 => (0.5 * ((windows.offset(k) + pattern.fraction) / width_of(&noise, pattern.level)).powi(2)).exp(),
        _ => f64::NAN,
    };
    let over: Vec<f64> = windows.patterns.iter().flat_map(|pattern| (middle - core..=middle + core).map(|k| over(pattern, k))).collect();
    let mut shares = Vec::with_capacity(columns * known.len());
    for ray in calm().filter(|&ray| stand.height[ray] > 0.0) {
        let (samples, scale) = (&windows.of(ray)[middle - core..], 1.0 / stand.height[ray]);
        for (sample, over) in samples.iter().zip(&over[windows.pattern[ray] * columns..][..columns]) {
            let share = (sample - background) * (over * scale);
            shares.push(if share > BRIGHTEST { BRIGHTEST } else { share });
        }
    }
    let (near, far) = (relative_covariance(&shares, columns, 1), relative_covariance(&shares, columns, 2));
    if (near + far).is_nan() {
        return noise;
    }
    let grain = grain(near, far, apart);
    let contrast = (near * (apart * apart / (4.0 * grain * grain)).exp()).min(noise.contrast);
    Noise { contrast: contrast.clamp(LEAST_CONTRAST, MOST_CONTRAST), grain, ..noise }
}

/// Grain of a speckle correlation exp(-d^2 / 4 grain^2) from its values at d = `apart` and twice that.
fn grain(near: f64, far: f64, apart: f64) -> f64 {
    if !(0.0 < far && far < near) {
        return if far >= near && near > 0.0 { LONGEST_GRAIN } else { SHORTEST_GRAIN };
    }
    (apart * (0.75 / (near / far).ln()).sqrt()).clamp(SHORTEST_GRAIN, LONGEST_GRAIN)
}

/// Of columns that are `lag` apart in rows of `columns`, over their means: mean by number of pairs; NaN of none.
fn relative_covariance(shares: &[f64], columns: usize, lag: usize) -> f64 {
    let (mut total, mut pairs) = (0.0, 0.0);
    for first in 0..columns - lag {
        let (mut count, mut one, mut other, mut both) = (0.0, 0.0, 0.0, 0.0);
        for row in shares.chunks_exact(columns) {
            let (a, b) = (row[first], row[first + lag]);
            if (a + b).is_finite() {
                count += 1.0;
                one += a;
                other += b;
                both += a * b;
            }
        }
        if count >= FEWEST {
            total += count * (both * count / (one * other) - 1.0);
            pairs += count;
        }
    }
    total / pairs
}
