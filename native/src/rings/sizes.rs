//! Means, sizes, extremes and the second harmonic of the estimated wall: the twin of `calibore.metrics._sizes`.

use std::f64::consts::{PI, TAU};

use super::grid::Grid;
use super::matrix::{dot, limits, sum, Matrix};
use super::statistics::turned;

const SIGNIFICANT: f64 = 2.0;
pub const EXTREMES: usize = 5;
pub const LINEAR: usize = 6;
/// Value and standard uncertainty.
pub type Pair = [f64; 2];

/// Standard normal numbers (half the draws, size), of the core exactly uncorrelated; the other half are their negatives.
pub struct Draws<'a> {
    pub core: &'a [f64],
    pub columns: usize,
    pub again: &'a [f64],
    pub possible: &'a [f64],
}

pub struct Extremes {
    pub values: [Pair; EXTREMES],
    /// Clock of the smallest and of the largest diameter, from the crown about the centre.
    pub clocks: [Pair; 2],
}

/// Largest and smallest diameter over some directions, ovalities, and where the extremes are.
struct Found {
    values: [f64; EXTREMES],
    places: [usize; 2],
}

impl Found {
    /// Over the `seen` directions; of all where there are none to leave out.
    fn of(diameters: &[f64], seen: Option<&[usize]>) -> Self {
        let mean = sum(diameters) / diameters.len() as f64;
        let some: Vec<f64> = seen.into_iter().flatten().map(|&i| diameters[i]).collect();
        let values = if seen.is_some() { &some[..] } else { diameters };
        let (least, most) = if values.is_empty() { (f64::NAN, f64::NAN) } else { limits(values) };
        let place = |extreme: f64| {
            let found = values.iter().position(|&value| value == extreme).unwrap_or(0);
            seen.map_or(found, |seen| seen.get(found).copied().unwrap_or(0))
        };
        let values = [least, most, 100.0 * (most / mean - 1.0), 100.0 * (1.0 - least / mean), 100.0 * (most - least) / mean];
        Found { values, places: [place(least), place(most)] }
    }
}

impl Grid {
    pub fn half(&self) -> usize {
        self.regular / 2
    }

    pub fn both(&self) -> Vec<bool> {
        (0..self.half()).map(|i| self.covered[i] && self.covered[i + self.half()]).collect()
    }

    fn diameters(&self, radii: &[f64]) -> Vec<f64> {
        (0..self.half()).map(|i| radii[i] + radii[i + self.half()]).collect()
    }

    /// Deviations (half the draws, half a turn) of the diameters.
    fn deviations(&self, maps: &Matrix, core: usize, draws: (&[f64], usize), plain: &[f64]) -> Matrix {
        let mut factors = Matrix { columns: self.half(), values: vec![] };
        (0..maps.rows()).for_each(|k| factors.values.extend(self.diameters(maps.row(k))));
        let (rows, more) = (draws.0.len() / draws.1, maps.rows() - core);
        let number = |i: usize, k: usize| if k < core { draws.0[i * draws.1 + k] } else { plain[i * more + k - core] };
        Matrix::of(rows, maps.rows(), number).times(&factors)
    }

    /// Value and uncertainty of every extreme of the diameters, noise bias removed, in units of the wall's scale, and their clocks.
    pub fn extremes(&self, both: &[bool], draws: &Draws) -> Extremes {
        let seen: Vec<usize> = (0..both.len()).filter(|&i| both[i]).collect();
        let seen = (seen.len() < both.len()).then_some(&seen[..]);
        let of = |diameters: &[f64]| Found::of(diameters, seen);
        let best = self.diameters(&self.best);
        let plug_in = of(&best);
        let again = self.deviations(&self.again, self.core[0], (draws.core, draws.columns), draws.again);
        let mut value = [0.0; EXTREMES];
        each_wall(&best, &again, |wall| of(wall).values.iter().zip(&mut value).for_each(|(one, value)| *value += one));
        let count = 2.0 * again.rows() as f64;
        for (k, value) in value.iter_mut().enumerate() {
            *value = plug_in.values[k] - (*value / count - plug_in.values[k]);
            if k >= 2 && *value < 0.0 {
                *value = 0.0;
            }
        }
        let possible = self.deviations(&self.possible, self.core[1], (draws.core, draws.columns), draws.possible);
        let peaks = [peak(&best, plug_in.places[0], -1.0), peak(&best, plug_in.places[1], 1.0)];
        let (mut spread, mut away) = ([0.0; EXTREMES], [0.0; 2]);
        let half = self.half() as f64;
        each_wall(&best, &possible, |wall| {
            let found = of(wall);
            (0..EXTREMES).for_each(|k| spread[k] += (found.values[k] - value[k]).powi(2));
            (0..2).for_each(|k| away[k] += (turned(found.places[k] as f64 - peaks[k] + half / 2.0, half) - half / 2.0).powi(2));
        });
        let bridged = Found::of(&best, None).values;
        let freed = of(&self.diameters(&self.freed)).values;
        let jumps = self.edges.iter().map(|edge| edge.1 * edge.1).sum::<f64>().sqrt();
        let u_mean = 2.0 * jumps / self.regular as f64 / (best.iter().sum::<f64>() / half);
        let through_mean = [0.0, 0.0, 100.0, 100.0, value[4]].map(|part| u_mean * part);
        let values = std::array::from_fn(|k| {
            let (hidden, taken) = (bridged[k] - plug_in.values[k], freed[k] - plug_in.values[k]);
            [value[k], (spread[k] / count + (hidden * hidden + taken * taken) + through_mean[k] * through_mean[k]).sqrt()]
        });
        let step = PI / half;
        let clocks = std::array::from_fn(|k| [peaks[k] * step, (away[k] / count + 1.0 / 12.0).sqrt() * step]);
        Extremes { values, clocks }
    }

    /// Amplitude of the second harmonic of the radii over their mean, percent.
    pub fn second_harmonic(&self) -> Pair {
        let n = self.regular;
        let part = |turn: fn(f64) -> f64| (0..n).map(|i| 2.0 / n as f64 * turn(2.0 * TAU * i as f64 / n as f64)).collect::<Vec<f64>>();
        let project = [part(f64::cos), part(f64::sin)];
        let of = |row: &[f64]| project.each_ref().map(|project| dot(project, &row[..n]));
        let [x, y] = project.each_ref().map(|project| self.possible.applied(project));
        let levels = self.possible.applied(&vec![1.0; n]);
        let (free, best) = (of(&self.freed), of(&self.best));
        let value = best[0].hypot(best[1]);
        let mean = self.best[..n].iter().sum::<f64>() / n as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        let mut add = |part: [f64; 2], level: f64| {
            let [x, y] = [part[0] - free[0] * level / mean, part[1] - free[1] * level / mean];
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        };
        for k in 0..self.possible.rows() {
            add([x[k], y[k]], levels[k] / n as f64);
        }
        for &(place, jump) in &self.edges {
            add(project.each_ref().map(|project| project[place] * jump), jump / n as f64);
        }
        let largest = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
        let size = free[0].hypot(free[1]);
        let along = if size > SIGNIFICANT * largest.sqrt() {
            (free[0] * (xx * free[0] + xy * free[1]) + free[1] * (xy * free[0] + yy * free[1])) / (size * size)
        } else {
            largest
        };
        let unit = 100.0 / mean;
        [value * unit, (along + (size - value).powi(2)).sqrt() * unit]
    }

    /// Mean diameter, area, diameter of the same area, perimeter, horizontal and vertical diameter.
    pub fn linear_sizes(&self) -> [Pair; LINEAR] {
        let n = self.regular;
        let (turn, count) = (&self.best[..n], n as f64);
        let area = PI * dot(turn, turn) / count;
        let equivalent = 2.0 * (area / PI).sqrt();
        let (length, gradient) = perimeter(turn);
        let mean = turn.iter().sum::<f64>() / count;
        let values = [2.0 * mean, area, equivalent, length, self.best[n] + self.best[n + 1], self.best[n + 2] + self.best[n + 3]];
        let mut squares = [0.0; LINEAR];
        let mut add = |level: f64, by_area: f64, by_length: f64, axes: [f64; 2]| {
            let by_area = TAU / count * by_area;
            let changes = [2.0 / count * level, by_area, by_area * equivalent / (2.0 * area), by_length, axes[0], axes[1]];
            squares.iter_mut().zip(changes).for_each(|(square, change)| *square += change * change);
        };
        let [levels, by_area, by_length] = [&vec![1.0; n], turn, &gradient].map(|by| self.possible.applied(by));
        for k in 0..self.possible.rows() {
            let row = self.possible.row(k);
            let axes = [row[n] + row[n + 1], row[n + 2] + row[n + 3]];
            add(levels[k], by_area[k], by_length[k], axes);
        }
        for &(place, jump) in &self.edges {
            add(jump, turn[place] * jump, gradient[place] * jump, [0.0; 2]);
        }
        std::array::from_fn(|k| [values[k], squares[k].sqrt()])
    }
}

/// Every wall that a draw or its negative makes of `best`.
#[inline(always)]
fn each_wall(best: &[f64], deviations: &Matrix, mut with: impl FnMut(&[f64])) {
    let mut wall = vec![0.0; best.len()];
    for sign in [1.0, -1.0] {
        for i in 0..deviations.rows() {
            wall.iter_mut().zip(best).zip(deviations.row(i)).for_each(|((wall, best), off)| *wall = best + sign * off);
            with(&wall);
        }
    }
}

/// The extreme of a parabola through the extreme direction and its neighbours, in directions.
fn peak(curve: &[f64], place: usize, sign: f64) -> f64 {
    let n = curve.len();
    let (before, here, after) = (sign * curve[(place + n - 1) % n], sign * curve[place], sign * curve[(place + 1) % n]);
    let bend = 2.0 * here - before - after;
    let aside = if bend > 0.0 && before.max(after) <= here { 0.5 * (after - before) / bend } else { 0.0 };
    place as f64 + aside
}

/// Length of the wall and its derivatives by the radii.
fn perimeter(radii: &[f64]) -> (f64, Vec<f64>) {
    let n = radii.len();
    let square = (TAU / n as f64).powi(2);
    let (mut length, mut gradient) = (0.0, vec![0.0; n]);
    for i in 0..n {
        let (here, next) = (radii[i], radii[(i + 1) % n]);
        let step = next - here;
        let side = (step * step + here * next * square).sqrt();
        length += side;
        gradient[i] += (0.5 * next * square - step) / side;
        gradient[(i + 1) % n] += (0.5 * here * square + step) / side;
    }
    (length, gradient)
}
