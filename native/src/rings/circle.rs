//! The circle that foreign points do not pull: the twin of `calibore.geometry._robust_circle`.

use super::matrix::{dot, Matrix};
use super::statistics::{median, upper_median};

const TUKEY_TUNING: f64 = 4.685;
const MEDIAN_TO_DEVIATION: f64 = 1.4826;
const SCALE_STEPS: usize = 5;
const STEPS: usize = 40;
const CONVERGED: f64 = 1e-13;
const ROBUST_CONVERGED: f64 = 1e-9;
const COLLINEAR: f64 = 1e-14;
const LARGEST_RADIUS: f64 = 1e7;
const SCORED_POINTS: usize = 150;
const SPREADS: [(f64, f64); 4] = [(1.0 / 3.0, 2.0 / 3.0), (0.25, 0.5), (0.25, 0.75), (1.0 / 6.0, 0.5)];
const TRIPLES_PER_SPREAD: usize = 16;

#[derive(Clone, Copy)]
pub struct Circle {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
}

/// None where the points do not tell one. `drawn`: further triples of points.
pub fn robust_circle(x: &[f64], y: &[f64], drawn: &[[usize; 3]]) -> Option<Circle> {
    let n = x.len() as f64;
    let mean = [x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n];
    let mut x: Vec<f64> = x.iter().map(|x| x - mean[0]).collect();
    let mut y: Vec<f64> = y.iter().map(|y| y - mean[1]).collect();
    let (xx, xy, yy) = (dot(&x, &x), dot(&x, &y), dot(&y, &y));
    let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    if middle - half <= COLLINEAR * (middle + half) {
        return None;
    }
    let extent = x.iter().chain(&y).fold(0.0_f64, |most, value| most.max(value.abs()));
    x.iter_mut().chain(&mut y).for_each(|value| *value /= extent);
    let circle = descended(&x, &y, least_median(&x, &y, drawn)?)?;
    Some(Circle { x: circle.x * extent + mean[0], y: circle.y * extent + mean[1], radius: circle.radius * extent })
}

fn descended(x: &[f64], y: &[f64], start: Circle) -> Option<Circle> {
    let (mut circle, mut scale) = (start, 0.0);
    let mut sizes = vec![0.0; x.len()];
    for iteration in 0..STEPS {
        let points = || x.iter().zip(y).map(|(x, y)| (x - circle.x, y - circle.y)).map(|(x, y)| (x, y, (x * x + y * y).sqrt()));
        if iteration < SCALE_STEPS {
            sizes.iter_mut().zip(points()).for_each(|(size, (_, _, length))| *size = (length - circle.radius).abs());
            scale = f64::max(MEDIAN_TO_DEVIATION * median(&mut sizes), CONVERGED);
        }
        let (mut normal, mut slope, mut carried) = ([[0.0; 3]; 3], [0.0; 3], 0);
        for (x, y, length) in points() {
            let off = length - circle.radius;
            let weight = f64::max(1.0 - (off / scale / TUKEY_TUNING).powi(2), 0.0).powi(2);
            let inverse = 1.0 / length.max(f64::MIN_POSITIVE);
            let row = [-x * inverse, -y * inverse, -1.0];
            carried += usize::from(weight > 0.0);
            for i in 0..3 {
                slope[i] -= weight * row[i] * off;
                (0..3).for_each(|j| normal[i][j] += weight * row[i] * row[j]);
            }
        }
        let step = Matrix { columns: 3, values: normal.concat() }.solved(&slope)?;
        circle = Circle { x: circle.x + step[0], y: circle.y + step[1], radius: circle.radius + step[2] };
        if carried < 3 || !(circle.radius > 0.0 && circle.radius < LARGEST_RADIUS) {
            return None;
        }
        if iteration >= SCALE_STEPS && step.iter().all(|step| step.abs() <= ROBUST_CONVERGED) {
            break;
        }
    }
    Some(circle)
}

/// The circle through three points with the least median distance of some of the others.
fn least_median(x: &[f64], y: &[f64], drawn: &[[usize; 3]]) -> Option<Circle> {
    let scored = x.len().min(SCORED_POINTS);
    let step = (x.len() - 1) as f64 / (scored - 1) as f64;
    let some = |i: usize| if i + 1 == scored { x.len() - 1 } else { (i as f64 * step) as usize };
    let points: Vec<(f64, f64)> = (0..scored).map(|i| (x[some(i)], y[some(i)])).collect();
    let (mut best, mut least) = (None, f64::INFINITY);
    let mut apart = vec![0.0; scored];
    for triple in triples(x, y, drawn) {
        let Some(circle) = through(triple.map(|i| (x[i], y[i]))) else { continue };
        for (apart, (x, y)) in apart.iter_mut().zip(&points) {
            let (x, y) = (x - circle.x, y - circle.y);
            *apart = ((x * x + y * y).sqrt() - circle.radius).abs();
        }
        let nearer = apart.iter().map(|&apart| usize::from(apart < least)).sum::<usize>();
        if nearer > scored / 2 {
            least = upper_median(&mut apart);
            best = Some(circle);
        }
    }
    best
}

/// Evenly spread round the ring, and the `drawn` ones.
fn triples(x: &[f64], y: &[f64], drawn: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let n = x.len();
    let centre = (median(&mut x.to_vec()), median(&mut y.to_vec()));
    let angles: Vec<f64> = x.iter().zip(y).map(|(x, y)| (x - centre.0).atan2(centre.1 - y)).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| angles[a].total_cmp(&angles[b]));
    let step = n as f64 / TRIPLES_PER_SPREAD as f64;
    let spread = SPREADS
        .iter()
        .flat_map(|&(b, c)| (0..TRIPLES_PER_SPREAD).map(move |i| [0.0, b, c].map(|part| (i as f64 * step + part * n as f64) as usize % n)));
    spread.chain(drawn.iter().copied()).map(|triple| triple.map(|i| order[i])).collect()
}

fn through([origin, b, c]: [(f64, f64); 3]) -> Option<Circle> {
    let (bx, by, cx, cy) = (b.0 - origin.0, b.1 - origin.1, c.0 - origin.0, c.1 - origin.1);
    let doubled_area = 2.0 * (bx * cy - by * cx);
    if doubled_area.abs() <= f64::EPSILON {
        return None;
    }
    let (b_square, c_square) = (bx * bx + by * by, cx * cx + cy * cy);
    let (x, y) = ((cy * b_square - by * c_square) / doubled_area, (bx * c_square - cx * b_square) / doubled_area);
    Some(Circle { x: x + origin.0, y: y + origin.1, radius: (x * x + y * y).sqrt() })
}
