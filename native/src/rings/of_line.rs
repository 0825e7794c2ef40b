//! Python's way to `stripe_on_wall`.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::fold::Enlargements;
use super::line::{OnWall, Valid};
use super::stripe::{stripe_on_wall, Rig, Stripe};
use super::Table;
use crate::meeting::modes::{Mode, MODE};
use crate::meeting::surface::Kind;
use crate::meeting::{make_of, Makes, Numbers};

/// u, v, their uncertainty, status, direction of the rays, correlation of neighbours, centre.
type Lines<'py> = (Numbers<'py>, Numbers<'py>, Numbers<'py>, PyReadonlyArray1<'py, u8>, Table<'py>, Numbers<'py>, Option<[f64; 2]>);
/// Make, parameters, and what moves them together.
type Form<'py> = (Makes, Numbers<'py>, Table<'py>);
/// Zenith and radius from, to.
type Limits = Option<([f64; 2], [f64; 2])>;
/// What the radius is roughly, and the enlargement of its uncertainty by margin.
type OfCone<'py> = Option<(f64, Numbers<'py>, Numbers<'py>)>;
type Column<'py> = Bound<'py, PyArray1<f64>>;
type Codes<'py> = Bound<'py, PyArray1<u8>>;
type Rays<'py> = (Bound<'py, PyArray2<f64>>, Column<'py>, Column<'py>, Column<'py>, Codes<'py>);
type Ring<'py> = ([Column<'py>; 3], Column<'py>, Column<'py>, Codes<'py>);

/// See `calibore.profiling._line_ring`: of the rays points, radius, clock, uncertainty and status; of the ring radius, axial and
/// uncertainty, modes, correlation and status; and which rays show water. None where no ray meets the light.
#[pyfunction]
pub fn ring_of_line<'py>(
    py: Python<'py>,
    form: Form<'py>,
    line: Lines<'py>,
    stated: Option<f64>,
    valid: Limits,
    cone: OfCone<'py>,
    positions: usize,
) -> PyResult<Option<(Rays<'py>, Ring<'py>, Vec<usize>)>> {
    let (make, parameters, modes) = (make_of(form.0)?, form.1.as_slice()?, &form.2);
    let (u, v, u_position, status, direction, correlation, centre) = &line;
    let n = u.len();
    let full = [v.len(), u_position.len(), status.len(), direction.shape()[0]] == [n; 4] && direction.shape()[1] == 2;
    let known = !make.side_facing && parameters.len() == make.parameters() && modes.shape()[1] == MODE;
    let table = cone.as_ref().is_none_or(|(_, margin, by)| margin.len() == by.len() && margin.len() > 1);
    if !full || !known || !table || n == 0 || positions == 0 || cone.is_some() != (make.kind == Kind::Cone) {
        return Err(PyValueError::new_err("numbers do not fit the line or the rig"));
    }
    let modes: Vec<Mode> = modes.as_slice()?.as_chunks::<MODE>().0.iter().map(Mode::of).collect();
    let (du, dv): (Vec<f64>, Vec<f64>) = direction.as_slice()?.as_chunks::<2>().0.iter().map(|&[u, v]| (u, v)).unzip();
    let stripe = Stripe {
        u: u.as_slice()?,
        v: v.as_slice()?,
        direction: [&du, &dv],
        u_position: u_position.as_slice()?,
        status: status.as_slice()?,
        correlation: correlation.as_slice()?,
        centre: *centre,
    };
    let cone = match &cone {
        Some((prior, margin, by)) => Some((*prior, Enlargements { margin: margin.as_slice()?, by: by.as_slice()? })),
        None => None,
    };
    let valid = valid.map(|(zenith, radius)| Valid { zenith, radius });
    let rig = Rig { make: &make, parameters, modes: &modes, stated, valid, cone, positions };
    let found = py.detach(|| stripe_on_wall(&stripe, &rig));
    found.map(|(found, wet)| arrays(py, found).map(|(rays, ring)| (rays, ring, wet))).transpose()
}

fn arrays(py: Python<'_>, found: OnWall) -> PyResult<(Rays<'_>, Ring<'_>)> {
    let column = |values| PyArray1::from_vec(py, values);
    let [x, y, z, radius, clock, u_radius] = found.rays;
    let mut points = vec![0.0; 3 * x.len()];
    let rows = points.as_chunks_mut().0.iter_mut().zip(&x).zip(&y).zip(&z);
    rows.for_each(|(((row, &x), &y), &z)| *row = [x, y, z]);
    let points = column(points).reshape([x.len(), 3])?;
    let rays = (points, column(radius), column(clock), column(u_radius), PyArray1::from_vec(py, found.status));
    let status = PyArray1::from_vec(py, found.ring.status);
    Ok((rays, (found.ring.columns.map(column), column(found.ring.modes), column(found.ring.correlation.to_vec()), status)))
}
