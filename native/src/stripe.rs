//! Stripe kernels: peaks along rays, and their linking into chains. Specified by their NumPy twins in `calibore.stripe`.

mod chain;
mod peak;
mod refine;
mod sampling;
mod scatter;

use numpy::{PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use sampling::{Plane, Ray, Trace};

/// Candidates kept per ray.
const MOST_PEAKS: usize = 4;
/// Numbers reported per candidate.
const COLUMNS: usize = 6;

pub struct Noise {
    additive: f64,
    gain: f64,
    contrast: f64,
    width: f64,
    /// exp(-1 / width^2), the ratio of ratios of a sampled Gaussian.
    step: f64,
    /// Speckle correlation at sample distances 0, 1, 2, ...
    correlation: Vec<f64>,
}

impl Noise {
    fn variance(&self, brightness: f64) -> f64 {
        self.additive + self.gain * brightness + self.contrast * brightness * brightness
    }
}

#[derive(Clone, Copy)]
pub enum Estimator {
    ZeroCrossing,
    Parabola,
    Maximum,
    Threshold,
    Centroid,
    Correlation,
    Crossing,
}

pub struct Settings {
    estimator: Estimator,
    gate: f64,
    prominence: f64,
    threshold: f64,
    saturation: f64,
    window: usize,
    reach: usize,
    half_fit: usize,
    noise: Noise,
}

#[derive(Clone, Copy)]
pub struct Peak {
    position: f64,
    height: f64,
    background: f64,
    width: f64,
    u: f64,
    saturated: bool,
}

type Levels = (f64, f64, f64, f64);
type Sizes = (usize, usize, usize);
type NoiseNumbers = (f64, f64, f64, f64, f64);

fn settings(estimator: u8, levels: Levels, sizes: Sizes, noise: NoiseNumbers) -> PyResult<Settings> {
    use Estimator::*;
    let named = [ZeroCrossing, Parabola, Maximum, Threshold, Centroid, Correlation, Crossing];
    let Some(&estimator) = named.get(estimator as usize) else {
        return Err(PyValueError::new_err(format!("estimator number must be 0 to 6, got {estimator}")));
    };
    let (gate, prominence, threshold, saturation) = levels;
    let (window, reach, half_fit) = sizes;
    if !(3..=64).contains(&window) || half_fit > 24 || !(noise.3 > 0.0) || !(noise.4 > 0.0) {
        return Err(PyValueError::new_err("window must be 3 to 64, half_fit up to 24, width and grain positive"));
    }
    let (additive, gain, contrast, width, grain) = noise;
    let correlation = (0..=2 * half_fit).map(|d| (-((d * d) as f64) / (4.0 * grain * grain)).exp()).collect();
    let step = (-1.0 / (width * width)).exp();
    let noise = Noise { additive, gain, contrast, width, step, correlation };
    Ok(Settings { estimator, gate, prominence, threshold, saturation, window, reach, half_fit, noise })
}

/// All candidates of all rays as COLUMNS tables of (rays, MOST_PEAKS), highest first.
fn scan<T: Copy + Into<f64>>(plane: &Plane<T>, rays: &[Ray], samples: usize, settings: &Settings) -> Vec<f64> {
    let mut table = vec![f64::NAN; COLUMNS * rays.len() * MOST_PEAKS];
    let mut trace = Trace::new(samples);
    let mut found = Vec::with_capacity(16);
    let margin = settings.reach.max(settings.half_fit).max(settings.window) + 3;
    for (index, ray) in rays.iter().enumerate() {
        trace.read(plane, ray, settings.gate, margin);
        peak::peaks(&trace, settings, &mut found);
        found.sort_by(|a, b| b.height.total_cmp(&a.height));
        for (rank, p) in found.iter().take(MOST_PEAKS).enumerate() {
            let row = [p.position, p.height, p.background, p.width, p.u, f64::from(u8::from(p.saturated))];
            for (column, value) in row.into_iter().enumerate() {
                table[(column * rays.len() + index) * MOST_PEAKS + rank] = value;
            }
        }
    }
    table
}

fn scan_image<T: Copy + Into<f64> + numpy::Element + Sync>(
    py: Python<'_>,
    image: &PyReadonlyArrayDyn<'_, T>,
    band: usize,
    rays: &[Ray],
    samples: usize,
    settings: &Settings,
) -> PyResult<Vec<f64>> {
    let shape = image.shape();
    let step = if shape.len() == 3 { shape[2] } else { 1 };
    if !(2..=3).contains(&shape.len()) || band >= step || shape[0] < 2 || shape[1] < 2 {
        return Err(PyValueError::new_err(format!("an image must be (h, w) or (h, w, bands), at least 2 x 2, got {shape:?}")));
    }
    let plane = Plane { data: image.as_slice()?, width: shape[1], height: shape[0], step, band };
    Ok(py.detach(|| scan(&plane, rays, samples, settings)))
}

/// Candidates along rays; see `calibore.stripe._twin.scan_numpy`.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn scan_rays<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    band: usize,
    start: PyReadonlyArray2<'py, f64>,
    direction: PyReadonlyArray2<'py, f64>,
    samples: usize,
    estimator: u8,
    levels: Levels,
    sizes: Sizes,
    noise: NoiseNumbers,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let settings = settings(estimator, levels, sizes, noise)?;
    let (start, direction) = (start.as_array(), direction.as_array());
    if start.ncols() != 2 || start.shape() != direction.shape() || samples > 1 << 20 {
        return Err(PyValueError::new_err("start and direction must both be (rays, 2), samples at most 2^20"));
    }
    let rays: Vec<Ray> = (0..start.nrows())
        .map(|i| Ray { start: [start[[i, 0]], start[[i, 1]]], direction: [direction[[i, 0]], direction[[i, 1]]] })
        .collect();
    let table = if let Ok(image) = image.extract::<PyReadonlyArrayDyn<'py, u8>>() {
        scan_image(py, &image, band, &rays, samples, &settings)?
    } else {
        scan_image(py, &image.extract::<PyReadonlyArrayDyn<'py, u16>>()?, band, &rays, samples, &settings)?
    };
    numpy::PyArray1::from_vec(py, table).reshape([COLUMNS, rays.len(), MOST_PEAKS])
}

/// Lengths of the chains candidates belong to; see `calibore.stripe._chain.link_numpy`.
#[pyfunction]
fn link_chains<'py>(
    py: Python<'py>,
    position: PyReadonlyArray2<'py, f64>,
    spacing: f64,
    closed: bool,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let shape = position.shape().to_vec();
    let places = position.as_slice()?;
    let lengths = py.detach(|| chain::chain_lengths(places, shape[1], spacing, closed));
    numpy::PyArray1::from_vec(py, lengths).reshape([shape[0], shape[1]])
}

/// Scatter ratios at several lags; see `calibore.stripe._scatter.scatter_ratio`.
#[pyfunction]
fn scatter_ratios(
    py: Python<'_>,
    position: PyReadonlyArray1<'_, f64>,
    u: PyReadonlyArray1<'_, f64>,
    lags: Vec<usize>,
    closed: bool,
) -> PyResult<Vec<f64>> {
    let (position, u) = (position.as_slice()?, u.as_slice()?);
    if position.len() != u.len() {
        return Err(PyValueError::new_err("position and u must have the same length"));
    }
    Ok(py.detach(|| lags.iter().map(|&lag| scatter::ratio(position, u, lag, closed)).collect()))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(scan_rays, module)?)?;
    module.add_function(wrap_pyfunction!(link_chains, module)?)?;
    module.add_function(wrap_pyfunction!(scatter_ratios, module)?)
}
