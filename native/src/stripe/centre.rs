//! The centre of the detected line: its area centroid (Swanbom 2007, eqs. 6-11 and 6-12), or of an open arc the centre
//! of its circle (see the Python module `_centre`).

/// Least area that has a centroid.
const LEAST_AREA: f64 = 1e-9;

/// Of the turn.
const WIDEST_GAP: f64 = 1.0 / 3.0;
/// Least determinant of the points' scatter, relative to its diagonal, that shows a bend.
const LEAST_BEND: f64 = 1e-9;

/// Centre of the ring whose `points` were seen on the rays `index`, of `count` rays in order round it; none where they
/// have no centre.
pub fn ring_centre(points: &[[f64; 2]], index: &[usize], count: usize) -> Option<[f64; 2]> {
    let next = index.iter().skip(1).copied().chain(index.first().map(|first| first + count));
    let widest = index.iter().zip(next).map(|(here, next)| next - here).max()?;
    if widest as f64 > WIDEST_GAP * count as f64 {
        circle_centre(points)
    } else {
        area_centroid(points)
    }
}

/// Centre of the circle through `points` by least squares of x^2 + y^2 (Kasa 1976); none where they show no bend.
fn circle_centre(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let (x0, y0) = (points.iter().map(|p| p[0]).sum::<f64>() / count, points.iter().map(|p| p[1]).sum::<f64>() / count);
    let (mut xx, mut xy, mut yy, mut xs, mut ys) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for p in points {
        let (x, y) = (p[0] - x0, p[1] - y0);
        let square = x * x + y * y;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xs += x * square;
        ys += y * square;
    }
    let determinant = xx * yy - xy * xy;
    (determinant > LEAST_BEND * xx * yy)
        .then(|| [x0 + (xs * yy - ys * xy) / (2.0 * determinant), y0 + (ys * xx - xs * xy) / (2.0 * determinant)])
}

/// Centroid of the polygon through `points` in their order; none where they enclose no area.
fn area_centroid(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let (x0, y0) = (points.iter().map(|p| p[0]).sum::<f64>() / count, points.iter().map(|p| p[1]).sum::<f64>() / count);
    let (mut area, mut moment_x, mut moment_y) = (0.0, 0.0, 0.0);
    for (p, next) in points.iter().zip(points.iter().cycle().skip(1)) {
        let (x, y, xn, yn) = (p[0] - x0, p[1] - y0, next[0] - x0, next[1] - y0);
        area += 0.5 * (y + yn) * (xn - x);
        moment_x -= (yn - y) * (x * x + x * xn + xn * xn) / 6.0;
        moment_y += (xn - x) * (y * y + y * yn + yn * yn) / 6.0;
    }
    (area.abs() >= LEAST_AREA).then(|| [x0 + moment_x / area, y0 + moment_y / area])
}
