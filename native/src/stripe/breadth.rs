//! Width of the line, learnt from its mean profile (see the Python module `_breadth`).

use super::neighbours::Standpoint;
use super::pieces::{along, bridged, piece, smoothed, Pieces, PIECES};
use super::settings::{Noise, MOST_SAMPLES};
use super::statistics::floor;
use super::windows::{Pattern, Windows, PHASES};

const STEPS: usize = 3;
const LONGEST: f64 = 0.3;
const MOST: f64 = 1.6;
const BRIGHTEST: f64 = 4.0;
const FEWEST: f64 = 24.0;
const BEYOND: f64 = 3.0;
/// Factor between the widths that are told apart.
const LEVEL: f64 = 1.1;

/// Sum of the samples of some rays that have them at the same places, in units of the line's height, and how many rays.
type Sum = ([f64; MOST_SAMPLES], f64);
const NOTHING: Sum = ([0.0; MOST_SAMPLES], 0.0);

/// Width of the line of a `level`.
pub fn width_of(noise: &Noise, level: i8) -> f64 {
    noise.width * LEVEL.powi(i32::from(level))
}

/// `noise` with the width of a Gaussian fitted to the samples of one calm ray in `every`, over the height of the line.
pub fn breadth(windows: &Windows, stand: &Standpoint, every: usize, noise: Noise) -> Noise {
    let width = mean_width(windows, stand, &counted(stand, every), noise.width);
    Noise { width: width.unwrap_or(noise.width), ..noise }
}

/// The same, and by how many powers of `LEVEL` the line of each ray is wider, none where that does not differ along the line.
pub fn breadths(windows: &Windows, stand: &Standpoint, every: usize, noise: Noise, closed: bool) -> (Noise, Vec<i8>) {
    let counted = counted(stand, every);
    let Some(width) = mean_width(windows, stand, &counted, noise.width) else { return (noise, Vec::new()) };
    let levels = local(windows, stand, &counted, width, closed).map(|local| levels(&local, width, stand.calm.len(), closed));
    (Noise { width, ..noise }, levels.unwrap_or_default())
}

fn counted(stand: &Standpoint, every: usize) -> Vec<usize> {
    (0..stand.calm.len()).step_by(every).filter(|&ray| stand.calm[ray] && stand.height[ray] > 0.0).collect()
}

/// Width of the mean profile of the rays `counted`, none where they are too few.
fn mean_width(windows: &Windows, stand: &Standpoint, counted: &[usize], first: f64) -> Option<f64> {
    // rays with the same pattern have their samples at the same places
    let mut sums = vec![NOTHING; windows.patterns.len()];
    for &ray in counted {
        add(&mut sums[windows.pattern[ray]], windows.of(ray), stand.height[ray]);
    }
    let known = windows.patterns.iter().zip(sums).filter(|(_, (_, count))| *count > 0.0);
    let (patterns, sums): (Vec<Pattern>, Vec<Sum>) = known.map(|(pattern, sum)| (pattern.clone(), sum)).unzip();
    (counted.len() as f64 >= FEWEST).then(|| fitted(windows, (&patterns, &sums), first, STEPS))
}

#[inline(always)]
fn add((sum, count): &mut Sum, samples: &[f64], height: f64) {
    let (low, most) = (1.0 / height, BRIGHTEST * height);
    *count += 1.0;
    for (sum, value) in sum.iter_mut().zip(samples) {
        *sum += (if *value > most { most } else { *value }) * low;
    }
}

/// Width of each piece of the line, None where it does not differ.
fn local(windows: &Windows, stand: &Standpoint, counted: &[usize], width: f64, closed: bool) -> Option<Pieces> {
    const PLACES: usize = PHASES as usize + 1;
    let place = |fraction: f64| ((fraction + 0.5) * PHASES) as usize;
    let patterns: [Pattern; PLACES] =
        std::array::from_fn(|k| Pattern { fraction: k as f64 / PHASES - 0.5, height: 1.0, missing: 0, level: 0 });
    let mut sums = vec![[NOTHING; PLACES]; PIECES];
    for &ray in counted.iter().filter(|&&ray| windows.patterns[windows.pattern[ray]].missing == 0) {
        add(&mut sums[piece(ray, stand.calm.len())][place(windows.fraction[ray])], windows.of(ray), stand.height[ray]);
    }
    let of = |sums: &[Sum; PLACES], fit: &dyn Fn(&[Sum]) -> f64| match sums.iter().map(|(_, count)| count).sum::<f64>()
        >= super::pieces::FEWEST
    {
        true => fit(sums),
        false => f64::NAN,
    };
    let whole = Bells::of(windows, &patterns, width);
    let once = |sums: &[Sum]| match whole.step(sums) {
        step if step.is_finite() => stepped(width, step, width),
        _ => width,
    };
    let first = bridged(std::array::from_fn(|k| of(&sums[k], &once)), closed)?;
    let mean = first.iter().sum::<f64>() / PIECES as f64;
    let off = first.iter().map(|width| (width - mean).powi(2)).sum::<f64>() / PIECES as f64;
    let pairs = if closed { PIECES } else { PIECES - 1 };
    let beside = (0..pairs).map(|k| (first[(k + 1) % PIECES] - first[k]).powi(2)).sum::<f64>() / pairs as f64;
    if off > BEYOND * beside / 2.0 {
        let often = |sums: &[Sum]| fitted(windows, (&patterns, sums), width, STEPS);
        bridged(std::array::from_fn(|k| of(&sums[k], &often)), closed).map(|widths| smoothed(widths, closed))
    } else {
        None
    }
}

fn levels(local: &Pieces, width: f64, count: usize, closed: bool) -> Vec<i8> {
    let level = |ray: usize| floor((along(local, ray, count, closed) / width).ln() / LEVEL.ln() + 0.5) as i8;
    (0..count).map(level).collect()
}

/// Width of the profile after so many steps from the `first`, which stays where the samples do not tell.
fn fitted(windows: &Windows, (patterns, sums): (&[Pattern], &[Sum]), first: f64, steps: usize) -> f64 {
    let mut width = first;
    for _ in 0..steps {
        width = match Bells::of(windows, patterns, width).step(sums) {
            step if step.is_finite() => stepped(width, step, first),
            _ => return first,
        };
    }
    width
}

fn stepped(width: f64, step: f64, first: f64) -> f64 {
    (width + step.clamp(-LONGEST * width, LONGEST * width)).clamp(first / MOST, first * MOST)
}

/// Profiles of a `width` with the samples of some patterns: derivatives of height bell + background by height, width and background, and the
/// sums of their products.
struct Bells {
    rows: Vec<[[f64; 3]; MOST_SAMPLES]>,
    normal: Vec<[[f64; 3]; 3]>,
    count: usize,
}

impl Bells {
    fn of(windows: &Windows, patterns: &[Pattern], width: f64) -> Bells {
        let mut bells = Bells {
            rows: vec![[[0.0; 3]; MOST_SAMPLES]; patterns.len()],
            normal: vec![[[0.0; 3]; 3]; patterns.len()],
            count: windows.count,
        };
        for ((rows, normal), pattern) in bells.rows.iter_mut().zip(&mut bells.normal).zip(patterns) {
            for k in (0..windows.count).filter(|k| pattern.missing >> k & 1 == 0) {
                let square = (windows.offset(k) + pattern.fraction).powi(2) / (width * width);
                let bell = (-0.5 * square).exp();
                let row = [bell, bell * square / width, 1.0];
                (0..3).for_each(|i| (0..3).for_each(|j| normal[i][j] += row[i] * row[j]));
                rows[k] = row;
            }
        }
        bells
    }

    /// One Gauss-Newton step of the width to the profile that `sums` show; NaN where they do not tell.
    fn step(&self, sums: &[Sum]) -> f64 {
        let (mut normal, mut target) = ([[0.0; 3]; 3], [0.0; 3]);
        for ((rows, own), (sum, count)) in self.rows.iter().zip(&self.normal).zip(sums).filter(|(_, (_, count))| *count > 0.0) {
            (0..3).for_each(|i| (0..3).for_each(|j| normal[i][j] += count * own[i][j]));
            for (row, value) in rows[..self.count].iter().zip(sum) {
                (0..3).for_each(|i| target[i] += row[i] * value);
            }
        }
        let solved = |column: usize| {
            let mut other = normal;
            (0..3).for_each(|i| other[i][column] = target[i]);
            determinant(&other)
        };
        solved(1) / solved(0)
    }
}

fn determinant([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}
