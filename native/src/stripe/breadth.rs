//! Width of the line, learnt from its mean profile (see the Python module `_breadth`).

use super::neighbours::Standpoint;
use super::settings::{Noise, MOST_SAMPLES};
use super::windows::Windows;

const STEPS: usize = 3;
const LONGEST: f64 = 0.3;
const MOST: f64 = 1.6;
const BRIGHTEST: f64 = 4.0;
const FEWEST: f64 = 24.0;

/// `noise` with the width of a Gaussian fitted to the samples of one calm ray in `every`, over the height of the line.
pub fn breadth(windows: &Windows, stand: &Standpoint, every: usize, noise: Noise) -> Noise {
    // rays with the same pattern have their samples at the same places
    let mut sums = vec![([0.0; MOST_SAMPLES], 0.0); windows.patterns.len()];
    for ray in (0..stand.calm.len()).step_by(every).filter(|&ray| stand.calm[ray] && stand.height[ray] > 0.0) {
        let (sum, count) = &mut sums[windows.pattern[ray]];
        let (low, most) = (1.0 / stand.height[ray], BRIGHTEST * stand.height[ray]);
        *count += 1.0;
        for (sum, value) in sum.iter_mut().zip(windows.of(ray)) {
            *sum += (if *value > most { most } else { *value }) * low;
        }
    }
    if sums.iter().map(|(_, count)| count).sum::<f64>() < FEWEST {
        return noise;
    }
    let mut width = noise.width;
    for _ in 0..STEPS {
        let step = step(windows, &sums, width);
        if !step.is_finite() {
            return noise;
        }
        width = (width + step.clamp(-LONGEST * width, LONGEST * width)).clamp(noise.width / MOST, noise.width * MOST);
    }
    Noise { width, ..noise }
}

/// One Gauss-Newton step of `width` for a profile height bell + background, both free; NaN where the samples do not tell.
fn step(windows: &Windows, sums: &[([f64; MOST_SAMPLES], f64)], width: f64) -> f64 {
    let (mut normal, mut target) = ([[0.0; 3]; 3], [0.0; 3]);
    for (pattern, (sum, count)) in windows.patterns.iter().zip(sums).filter(|(_, (_, count))| *count > 0.0) {
        for k in (0..windows.count).filter(|k| pattern.missing >> k & 1 == 0) {
            let square = (windows.offset(k) + pattern.fraction).powi(2) / (width * width);
            let bell = (-0.5 * square).exp();
            let row = [bell, bell * square / width, 1.0];
            for i in 0..3 {
                (0..3).for_each(|j| normal[i][j] += count * row[i] * row[j]);
                target[i] += row[i] * sum[k];
            }
        }
    }
    let solved = |column: usize| {
        let mut other = normal;
        (0..3).for_each(|i| other[i][column] = target[i]);
        determinant(&other)
    };
    solved(1) / solved(0)
}

fn determinant([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}
