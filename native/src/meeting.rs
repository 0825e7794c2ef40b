//! Camera rays meet surfaces of light, for millions of rays: the compiled form of `calibore.rigs.triangulate`, which is its specification.

mod camera;
mod cone;
pub mod dispatch;
mod drawing;
mod draws;
#[cfg(fuzzing)]
pub mod entries;
mod flat;
pub mod fold;
mod frontier;
mod functions;
mod intervals;
mod lanes;
mod lens;
pub mod measure;
pub mod modes;
mod mount;
pub mod placing;
mod points;
pub mod projecting;
mod random;
pub mod rig;
pub mod surface;

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use drawing::Plan;
use draws::SUMMARY;
use measure::{Choice, Pixels, Shared, COLUMNS};
use modes::{Mode, MODE};
use rig::Make;

pub type Numbers<'py> = PyReadonlyArray1<'py, f64>;
/// Kind of surface, whether the camera faces sideways, lens law, half image height, whether the lens has a residual.
pub type Makes = (u8, bool, u8, f64, bool);

pub fn make_of(make: Makes) -> PyResult<Make> {
    let (kind, side_facing, law, half_height, residual) = make;
    Make::new(kind, side_facing, law, half_height, residual).ok_or_else(|| PyValueError::new_err("no such surface or lens law"))
}

pub fn fits(length: usize, points: usize) -> PyResult<()> {
    if length == 1 || length == points {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{length} numbers do not fit {points} points")))
}

pub type Directions<'py> = Option<(Numbers<'py>, Numbers<'py>)>;

pub fn directions<'a>(direction: &'a Directions, points: usize) -> PyResult<Option<[&'a [f64]; 2]>> {
    match direction {
        Some((u, v)) if u.len() == points && v.len() == points => Ok(Some([u.as_slice()?, v.as_slice()?])),
        Some(_) => Err(PyValueError::new_err(format!("{points} points need as many directions"))),
        None => Ok(None),
    }
}

/// See `calibore.rigs.measure`: fills rows of radius, axial, clock and uncertainties, and the status.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn measure_points<'py>(
    py: Python<'py>,
    make: Makes,
    parameters: Numbers<'py>,
    modes: PyReadonlyArray2<'py, f64>,
    u: Numbers<'py>,
    v: Numbers<'py>,
    choice: (bool, Numbers<'py>),
    noise: Numbers<'py>,
    direction: Directions<'py>,
    threads: usize,
    mut columns: PyReadwriteArray2<'py, f64>,
    mut status: PyReadwriteArray1<'py, u8>,
) -> PyResult<()> {
    let make = make_of(make)?;
    let (numbered, choice) = (choice.0, choice.1);
    let points = u.len();
    for length in [v.len(), choice.len(), noise.len()] {
        fits(length, points)?;
    }
    let directions = directions(&direction, points)?;
    if parameters.len() != make.parameters() || modes.shape()[1] != MODE || v.len() != points {
        return Err(PyValueError::new_err("numbers do not fit the rig"));
    }
    let modes: Vec<Mode> = modes.as_slice()?.as_chunks::<MODE>().0.iter().map(Mode::of).collect();
    let parameters = parameters.as_slice()?;
    let choice = Shared(choice.as_slice()?);
    let pixels = Pixels {
        u: u.as_slice()?,
        v: v.as_slice()?,
        choice: if numbered { Choice::Numbered(choice) } else { Choice::Nearest(choice) },
        noise: Shared(noise.as_slice()?),
        direction: directions,
    };
    let (columns, status) = (columns.as_slice_mut()?, status.as_slice_mut()?);
    if columns.len() != COLUMNS * points || status.len() != points {
        return Err(PyValueError::new_err(format!("there is no room for {points} points")));
    }
    py.detach(|| points::measure_all(&make, parameters, &modes, &pixels, columns, status, threads));
    Ok(())
}

/// See `calibore.rigs.monte_carlo`: fills a row of `SUMMARY` numbers for each pixel, from `rigs`, one row of parameters per draw.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn draw_points<'py>(
    py: Python<'py>,
    make: Makes,
    parameters: Numbers<'py>,
    rigs: PyReadonlyArray2<'py, f64>,
    u: Numbers<'py>,
    v: Numbers<'py>,
    branch: Numbers<'py>,
    noise: Numbers<'py>,
    direction: Directions<'py>,
    seed: u64,
    probability: Option<f64>,
    threads: usize,
    mut summaries: PyReadwriteArray2<'py, f64>,
    mut kept: PyReadwriteArray1<'py, f64>,
) -> PyResult<()> {
    let make = make_of(make)?;
    let points = u.len();
    for length in [branch.len(), noise.len()] {
        fits(length, points)?;
    }
    if parameters.len() != make.parameters() || rigs.shape()[1] != make.parameters() || v.len() != points {
        return Err(PyValueError::new_err("numbers do not fit the rig"));
    }
    let plan = Plan {
        parameters: parameters.as_slice()?,
        rigs: rigs.as_slice()?,
        make,
        seed,
        probability,
        u: u.as_slice()?,
        v: v.as_slice()?,
        branch: branch.as_slice()?,
        noise: noise.as_slice()?,
        direction: directions(&direction, points)?,
    };
    let summaries = summaries.as_slice_mut()?.as_chunks_mut::<SUMMARY>().0;
    let kept = kept.as_slice_mut()?;
    if summaries.len() != points || !(kept.is_empty() || kept.len() == 2 * points * plan.draws()) {
        return Err(PyValueError::new_err(format!("there is no room for {points} points")));
    }
    py.detach(|| drawing::draw_all(&plan, summaries, kept, threads));
    Ok(())
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure_points, module)?)?;
    module.add_function(wrap_pyfunction!(draw_points, module)?)
}
