//! The lit line in an image: the compiled form of `calibore.stripe._twin`, which is its specification. Every file here is the twin
//! of a Python module and carries its reasons there.

// comparisons are negated where NaN must fall on the cautious side
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod across;
mod alone;
mod anchor;
mod batch;
mod breadth;
mod centre;
mod chain;
mod choice;
mod describe;
#[cfg(fuzzing)]
pub mod entries;
mod features;
mod fit;
mod flanks;
mod generalised;
mod guide;
mod in_file;
mod lanes;
mod learn;
mod light;
mod literature;
mod measure;
mod neighbours;
mod noise;
mod path;
mod peak;
mod pieces;
mod plateau;
mod rays;
mod refine;
mod ridge;
mod ring;
mod row;
mod sampling;
mod scan;
mod scatter;
mod second;
mod settings;
mod settle;
mod smear;
mod sparse;
mod statistics;
mod trace;
mod vectors;
mod walk;
#[cfg(target_arch = "x86_64")]
mod walk_wide;
mod windows;

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use measure::Line;
use rays::{Annulus, FARTHEST};
use sampling::{luma, Grey, Plane};
use settings::{Estimator, Noise};
use vectors::Vectors;

/// Number of the band that is the luma of all three colours.
const LUMA_BAND: usize = 3;

type Column<'py> = Bound<'py, PyArray1<f64>>;
/// u, v, u_position, status, height, correlation, confidence.
type Arrays<'py> = (Column<'py>, Column<'py>, Column<'py>, Bound<'py, PyArray1<u8>>, Column<'py>, Column<'py>, Column<'py>);
type NoiseNumbers = (f64, f64, f64, f64, f64);

fn estimator_of(number: u8) -> PyResult<Estimator> {
    Estimator::numbered(number).ok_or_else(|| PyValueError::new_err(format!("estimator number must be 0 to 7, got {number}")))
}

fn numbers(noise: &Noise) -> NoiseNumbers {
    (noise.additive, noise.gain, noise.contrast, noise.width, noise.grain)
}

fn arrays(py: Python<'_>, line: Line) -> Arrays<'_> {
    let column = |values| PyArray1::from_vec(py, values);
    let status = PyArray1::from_vec(py, line.status);
    let (height, correlation, confidence) = (column(line.height), column(line.correlation), column(line.confidence));
    (column(line.u), column(line.v), column(line.u_position), status, height, correlation, confidence)
}

/// `work` on the chosen band of an image of `T`, the GIL released; none where the image is not one of `T`.
fn on_plane<T: Grey + numpy::Element, R: Send>(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    source: (usize, Vectors),
    work: impl FnOnce(&Plane<T>) -> R + Send,
) -> PyResult<Option<R>> {
    let Ok(image) = image.extract::<PyReadonlyArrayDyn<'_, T>>() else { return Ok(None) };
    let (shape, data) = (image.shape(), image.as_slice()?);
    let looked = match *shape {
        [height, width] => py.detach(|| on_band(data, (height, width, 1), source, work)),
        [height, width, bands] => py.detach(|| on_band(data, (height, width, bands), source, work)),
        _ => None,
    };
    match looked {
        None => Err(PyValueError::new_err(format!("an image must be (h, w) or (h, w, 3), at least 8 x 8, got {shape:?}"))),
        looked => Ok(looked),
    }
}

/// `work` on one band of the pixels `data`, as many rows, columns and bands as told; none where there is no such band or too few pixels.
fn on_band<T: Grey, R>(
    data: &[T],
    (height, width, bands): (usize, usize, usize),
    (band, vectors): (usize, Vectors),
    work: impl FnOnce(&Plane<T>) -> R,
) -> Option<R> {
    let known = band < bands || (band == LUMA_BAND && bands == 3);
    if !known || ![height, width].iter().all(|side| (8..1 << 20).contains(side)) {
        return None;
    }
    Some(if band == LUMA_BAND {
        work(&Plane { data: &luma(data), width, height, bands: 1, band: 0, vectors })
    } else {
        work(&Plane { data, width, height, bands, band, vectors })
    })
}

fn not_an_image() -> PyErr {
    PyValueError::new_err("an image must be a C-contiguous array of uint8 or uint16")
}

fn unsound() -> PyErr {
    PyValueError::new_err(format!("no rays can be laid into that annulus; lengths must stay below {FARTHEST} px"))
}

/// See `calibore.stripe._twin.ring_numpy`. ValueError with a sentence where there is no ring. Without `vectors` in scalar instructions
/// only, with the same results.
#[pyfunction]
#[pyo3(signature = (image, band, centre, radii, direction, counted, estimator, vectors = true))]
#[allow(clippy::too_many_arguments)]
fn detect_ring<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    band: usize,
    centre: (f64, f64),
    radii: (f64, f64),
    direction: PyReadonlyArray2<'py, f64>,
    counted: PyReadonlyArray1<'py, bool>,
    estimator: u8,
    vectors: bool,
) -> PyResult<(Arrays<'py>, NoiseNumbers, f64, (f64, f64))> {
    let (estimator, source) = (estimator_of(estimator)?, (band, Vectors::detected(vectors)));
    let (direction, counted) = (direction.as_slice()?, counted.as_slice()?);
    let annulus = Annulus { centre: [centre.0, centre.1], inner: radii.0, outer: radii.1, direction: direction.as_chunks().0, counted };
    if !annulus.is_sound() {
        return Err(unsound());
    }
    let measured = match on_plane::<u8, _>(py, image, source, |plane| ring::measure(plane, annulus, estimator))? {
        Some(measured) => measured,
        None => on_plane::<u16, _>(py, image, source, |plane| ring::measure(plane, annulus, estimator))?.ok_or_else(not_an_image)?,
    };
    let (line, centre) = measured.map_err(PyValueError::new_err)?;
    let (noise, scale) = (numbers(&line.noise), line.scale);
    Ok((arrays(py, line), noise, scale, (centre[0], centre[1])))
}

/// See `calibore.stripe._twin.line_numpy`, and `detect_ring` for `vectors`.
#[pyfunction]
#[pyo3(signature = (image, band, estimator, down, vectors = true))]
fn detect_line<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    band: usize,
    estimator: u8,
    down: bool,
    vectors: bool,
) -> PyResult<(Arrays<'py>, NoiseNumbers, f64)> {
    let (estimator, source) = (estimator_of(estimator)?, (band, Vectors::detected(vectors)));
    let measured = match on_plane::<u8, _>(py, image, source, |plane| ring::measure_line(plane, estimator, down))? {
        Some(measured) => measured,
        None => on_plane::<u16, _>(py, image, source, |plane| ring::measure_line(plane, estimator, down))?.ok_or_else(not_an_image)?,
    };
    let line = measured.map_err(PyValueError::new_err)?;
    let (noise, scale) = (numbers(&line.noise), line.scale);
    Ok((arrays(py, line), noise, scale))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(detect_ring, module)?)?;
    module.add_function(wrap_pyfunction!(detect_line, module)?)?;
    module.add_function(wrap_pyfunction!(in_file::detect_rings_in, module)?)?;
    module.add_function(wrap_pyfunction!(in_file::detect_line_in, module)?)
}
