//! All quantities of one ring, each with its standard uncertainty: the compiled form of `calibore.metrics`, which is its specification.

mod centre;
mod circle;
mod factors;
mod features;
mod fold;
mod grid;
pub mod gridding;
mod harmonics;
mod line;
pub mod matrix;
mod noise;
mod of_line;
mod path;
mod sizes;
mod smoothing;
pub mod statistics;
mod stretches;
mod stripe;
mod wall;

use numpy::{PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::meeting::Numbers;
use grid::{wall_grid, Grid};
use sizes::Draws;
use wall::{estimate_wall, Ring, Wall};

type Table<'py> = PyReadonlyArray2<'py, f64>;

/// A wall estimated from a ring, and that wall on a regular grid.
#[pyclass(frozen)]
struct RingEstimate {
    wall: Wall,
    grid: Grid,
}

/// None where the ring is no ordinary one: the twin then says what it is.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn estimate_ring<'py>(
    py: Python<'py>,
    sine: Numbers<'py>,
    cosine: Numbers<'py>,
    radius: Numbers<'py>,
    u: Numbers<'py>,
    modes: Table<'py>,
    correlation: Numbers<'py>,
    drawn: PyReadonlyArray2<'py, i64>,
    angles: Numbers<'py>,
    regular: usize,
) -> PyResult<Option<RingEstimate>> {
    let (n, measured) = (radius.len(), radius.as_slice()?.iter().filter(|radius| radius.is_finite()).count());
    let drawn: Vec<[usize; 3]> = drawn.as_slice()?.as_chunks::<3>().0.iter().map(|triple| triple.map(|i| i as usize)).collect();
    let fits = [sine.len(), cosine.len(), u.len(), modes.shape()[1]] == [n; 4] && drawn.as_flattened().iter().all(|&i| i < measured);
    if !fits || measured < 8 || angles.len() != regular + 4 || regular % 2 != 0 {
        return Err(PyValueError::new_err("numbers do not fit the ring"));
    }
    let ring = Ring {
        sine: sine.as_slice()?,
        cosine: cosine.as_slice()?,
        radius: radius.as_slice()?,
        u: u.as_slice()?,
        correlation: correlation.as_slice()?,
        drawn: &drawn,
    };
    let (modes, angles) = (modes.as_slice()?, angles.as_slice()?);
    Ok(py.detach(|| {
        let wall = estimate_wall(&ring)?;
        let grid = wall_grid(&wall, modes, angles, regular)?;
        Some(RingEstimate { wall, grid })
    }))
}

#[pymethods]
impl RingEstimate {
    /// How many numbers are drawn for a wall: of the core, and further ones of walls measured again and of possible walls.
    fn sizes(&self) -> [usize; 3] {
        let [again, possible] = self.grid.core;
        [possible, self.grid.again.rows() - again, self.grid.possible.rows() - possible]
    }

    /// Values and uncertainties, in units of the scale: see `calibore.metrics._engine`.
    fn quantities<'py>(
        &self,
        py: Python<'py>,
        core: Table<'py>,
        again: Table<'py>,
        possible: Table<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let [size, more_again, more_possible] = self.sizes();
        let rows = core.shape()[0];
        if core.shape()[1] != size || *again.shape() != [rows, more_again] || *possible.shape() != [rows, more_possible] {
            return Err(PyValueError::new_err("draws do not fit the wall"));
        }
        let draws = Draws { core: core.as_slice()?, columns: size, again: again.as_slice()?, possible: possible.as_slice()? };
        let numbers = py.detach(|| self.numbers(&draws));
        Ok(PyArray1::from_vec(py, numbers))
    }

    /// Directions with both ends measured, ends of the axes that are measured, points that count, and: any gap, any feature.
    fn counts(&self) -> (usize, [bool; 4], usize, bool, bool) {
        let ends = &self.grid.covered[self.grid.regular..];
        (
            self.grid.both().iter().filter(|&&both| both).count(),
            std::array::from_fn(|k| ends[k]),
            self.wall.order().len(),
            self.grid.covered.iter().any(|covered| !covered),
            self.wall.featured.iter().any(|&featured| featured),
        )
    }
}

impl RingEstimate {
    fn numbers(&self, draws: &Draws) -> Vec<f64> {
        let (wall, grid) = (&self.wall, &self.grid);
        let extremes = grid.extremes(&grid.both(), draws);
        let common = |k: usize| grid.centre_modes.iter().map(|motion| motion[k] * motion[k]).sum::<f64>();
        let level = |k: usize| grid.modes.row(k)[..grid.regular].iter().sum::<f64>() / grid.regular as f64;
        let levels = (0..grid.modes.rows()).map(|k| level(k) * level(k)).sum::<f64>();
        let u = |k: usize, common: f64| (wall.fit.covariance.at(k, k).max(0.0) + common).sqrt();
        let circle = [[wall.centre[0], u(2, common(0))], [wall.centre[1], u(1, common(1))], [wall.fit.coefficients[0], u(0, levels)]];
        let pairs = grid.linear_sizes().into_iter().chain(extremes.values).chain([grid.second_harmonic()]);
        let pairs = pairs.chain(circle).chain(extremes.clocks);
        pairs.flatten().chain([wall.scale, wall.excess]).collect()
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<RingEstimate>()?;
    module.add_function(wrap_pyfunction!(of_line::ring_of_line, module)?)?;
    module.add_function(wrap_pyfunction!(estimate_ring, module)?)
}
