//! The area centroid of the detected line (Swanbom 2007, eqs. 6-11 and 6-12; see the Python module `_centre`).

/// Least area that has a centroid.
const LEAST_AREA: f64 = 1e-9;

/// Centroid of the polygon through `points` in their order; none where they enclose no area.
pub fn area_centroid(points: &[[f64; 2]]) -> Option<[f64; 2]> {
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
