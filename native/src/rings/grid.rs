//! The wall on a regular grid about the centre, and linear maps from standard normal numbers to walls: the twin of `calibore.metrics._draws`.

use std::f64::consts::TAU;

use super::harmonics::harmonic_basis;
use super::matrix::{add_scaled, dot, Matrix};
use super::statistics::{median, turned, Between};
use super::wall::Wall;

const BRIDGED: f64 = 3.5;
const SECOND_HARMONIC: usize = 5;

/// Names as in `WallGrid`; maps have a row over the g angles for each number drawn: first the core, then those of the features.
pub struct Grid {
    pub regular: usize,
    pub best: Vec<f64>,
    pub freed: Vec<f64>,
    pub covered: Vec<bool>,
    pub again: Matrix,
    pub possible: Matrix,
    /// Rows of the core: of `again` without the blank ones, and of `possible`.
    pub core: [usize; 2],
    pub modes: Matrix,
    pub centre_modes: Vec<[f64; 2]>,
    /// Nearest angle of each edge, and what it does there.
    pub edges: Vec<(usize, f64)>,
}

pub fn wall_grid(wall: &Wall, ring_modes: &[f64], angles: &[f64], regular: usize) -> Option<Grid> {
    let fit = &wall.fit;
    let (sine, cosine): (Vec<f64>, Vec<f64>) = angles.iter().map(|angle| angle.sin_cos()).unzip();
    let basis = harmonic_basis(&cosine, &sine, fit.coefficients.len() / 2);
    let points = wall.basis();
    let smooth = points.combined(&fit.coefficients);
    let residuals: Vec<f64> = wall.polar.radius.iter().zip(&smooth).map(|(radius, smooth)| radius - smooth).collect();
    let (mut best, mut response) = (basis.combined(&fit.coefficients), basis.clone());
    let (mut again, mut possible) = (Matrix { columns: angles.len(), values: vec![] }, Matrix { columns: angles.len(), values: vec![] });
    for feature in wall.features(angles, &residuals)? {
        let values: Vec<f64> = feature.points.iter().map(|&i| residuals[i]).collect();
        for (i, &column) in feature.columns.iter().enumerate() {
            best[column] += dot(feature.smoother.row(i), &values);
        }
        let basis_there = Matrix::of(feature.points.len(), basis.rows(), |i, k| points.at(k, feature.points[i]));
        let smoothed = feature.smoother.times(&basis_there);
        for (i, &column) in feature.columns.iter().enumerate() {
            (0..basis.rows()).for_each(|k| response.row_mut(k)[column] -= smoothed.at(i, k));
        }
        let noisy = (feature.smoother.rows() > 0).then(|| feature.smoother.times(&feature.noise));
        place(&mut again, &feature.columns, feature.points.len(), |i, k| noisy.as_ref().map_or(0.0, |noisy| noisy.at(i, k)));
        place(&mut possible, &feature.columns, feature.columns.len(), |i, k| feature.spread.at(i, k));
    }
    let (modes, centre_modes) = common_modes(wall, ring_modes, angles, &sine, &cosine, &best[..regular])?;
    let mut in_use: Vec<f64> = wall.order().into_iter().map(|i| wall.polar.angle[i]).collect();
    in_use.sort_by(f64::total_cmp);
    let covered = covered_at(angles, &in_use);
    let bend = basis.combined(&[&fit.coefficients[..SECOND_HARMONIC], &vec![0.0; basis.rows() - SECOND_HARMONIC]].concat());
    let gap = gap_spread(&best, &bend, &covered)?;
    let believed = fit.free_covariance.clone().plus_diagonal(&fit.doubt).factor()?;
    let smoothing = fit.covariance.times(&fit.precision.factor()?);
    let mut core_again = smoothing.transposed().times(&response);
    let mut core_possible = believed.transposed().times(&response);
    core_possible.values.extend(&modes.values);
    core_possible.push(&gap);
    let core = [core_again.rows(), core_possible.rows()];
    core_again.values.extend(again.values);
    core_possible.values.extend(possible.values);
    let mut freed = best.clone();
    (3..5).for_each(|k| add_scaled(&mut freed, fit.free[k] - fit.coefficients[k], basis.row(k)));
    let edges = edges(wall, regular);
    Some(Grid { regular, best, freed, covered, again: core_again, possible: core_possible, core, modes, centre_modes, edges })
}

/// Rows of `count` numbers for the angles of `columns`, zero elsewhere.
fn place(to: &mut Matrix, columns: &[usize], count: usize, value: impl Fn(usize, usize) -> f64) {
    for k in 0..count {
        let mut row = vec![0.0; to.columns];
        columns.iter().enumerate().for_each(|(i, &column)| row[column] = value(i, k));
        to.push(&row);
    }
}

/// Whether each of `grid` lies between two neighbours of `angles`, which rise, closer than `BRIDGED` median steps.
fn covered_at(grid: &[f64], angles: &[f64]) -> Vec<bool> {
    let n = angles.len();
    let steps: Vec<f64> = (0..n).map(|i| if i + 1 < n { angles[i + 1] - angles[i] } else { angles[0] + TAU - angles[i] }).collect();
    let widest = BRIDGED * median(&mut steps.clone());
    let near = |&at: &f64| {
        let at = turned(at, TAU);
        let before = (angles.partition_point(|&angle| angle <= at + 1e-9) + n - 1) % n;
        steps[before] <= widest || (at - angles[before]).abs() < 2e-9
    };
    grid.iter().map(near).collect()
}

/// A jump J between points dphi apart lies anywhere between them: J dphi / sqrt(12), given to the nearest angle.
fn edges(wall: &Wall, regular: usize) -> Vec<(usize, f64)> {
    let order = wall.order();
    let n = order.len();
    let step = |k: usize| turned(wall.polar.angle[order[(k + 1) % n]] - wall.polar.angle[order[k]], TAU);
    let steps: Vec<f64> = (0..n).map(step).collect();
    let widest = BRIDGED * median(&mut steps.clone());
    let sharp = wall.edges();
    let edge = |k: usize| {
        let place = ((wall.polar.angle[order[k]] + steps[k] / 2.0) * regular as f64 / TAU).round_ties_even() as usize % regular;
        let jump = wall.polar.radius[order[(k + 1) % n]] - wall.polar.radius[order[k]];
        (place, jump * steps[k] / 12.0_f64.sqrt() * regular as f64 / TAU)
    };
    (0..n).filter(|&k| sharp[order[k]] && steps[k] < widest).map(edge).collect()
}

/// Common modes as radii (m, g) about the centre that moves with them, and that motion; see `_modes` of the twin.
fn common_modes(
    wall: &Wall,
    ring_modes: &[f64],
    grid: &[f64],
    sine: &[f64],
    cosine: &[f64],
    best: &[f64],
) -> Option<(Matrix, Vec<[f64; 2]>)> {
    let (n, g, regular) = (wall.used.len(), grid.len(), best.len());
    let mut modes = Matrix { columns: g, values: vec![] };
    if ring_modes.is_empty() {
        return Some((modes, vec![]));
    }
    let step = TAU / regular as f64;
    let steep = |i: usize| (best[(i + 1) % regular] - best[(i + regular - 1) % regular]) / (2.0 * step * best[i]);
    let steepness: Vec<f64> = (0..regular).map(steep).collect();
    let mut order = wall.order();
    order.sort_by(|&a, &b| wall.polar.angle[a].total_cmp(&wall.polar.angle[b]));
    let angles: Vec<f64> = order.iter().map(|&i| wall.polar.angle[i]).collect();
    let slopes = Between::closed(&angles, &grid[..regular]).values(&steepness);
    let onto = |(&i, slope): (&usize, &f64)| (wall.polar.cosine[i] - slope * wall.polar.sine[i]) / wall.scale;
    let projection: Vec<f64> = order.iter().zip(&slopes).map(onto).collect();
    let between = Between::closed(grid, &angles);
    for mode in ring_modes.chunks_exact(n) {
        let along: Vec<f64> = order.iter().zip(&projection).map(|(&i, projection)| mode[i] * projection).collect();
        modes.push(&between.values(&along));
    }
    let slope = Between::closed(grid, &grid[..regular]).values(&steepness);
    let across: Vec<f64> = (0..g).map(|i| sine[i] - slope[i] * cosine[i]).collect();
    let down: Vec<f64> = (0..g).map(|i| -cosine[i] - slope[i] * sine[i]).collect();
    let first = [sine[..regular].to_vec(), cosine[..regular].iter().map(|c| -c).collect()];
    let [[a, b], [c, d]] = first.each_ref().map(|first| [dot(first, &across[..regular]), dot(first, &down[..regular])]);
    let determinant = a * d - b * c;
    let mut motions = vec![];
    for k in 0..modes.rows() {
        let [right_x, right_y] = first.each_ref().map(|first| dot(first, &modes.row(k)[..regular]));
        let motion = [(d * right_x - b * right_y) / determinant, (a * right_y - c * right_x) / determinant];
        add_scaled(modes.row_mut(k), -motion[0], &across);
        add_scaled(modes.row_mut(k), -motion[1], &down);
        motions.push(motion);
    }
    (determinant.abs() > 0.0).then_some((modes, motions))
}

/// Extra standard uncertainty in gaps: the wall may do there what it does elsewhere beyond an ellipse.
fn gap_spread(best: &[f64], bend: &[f64], covered: &[bool]) -> Option<Vec<f64>> {
    let seen = || best.iter().zip(bend).zip(covered).filter(|(_, covered)| **covered);
    let count = seen().count();
    let mean = seen().map(|((best, bend), _)| (best - bend).powi(2)).sum::<f64>() / count as f64;
    (count > 0).then(|| covered.iter().map(|&covered| if covered { 0.0 } else { mean.sqrt() }).collect())
}
