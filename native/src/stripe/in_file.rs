//! From a file to the lines in its picture, in one call: no array of the picture, no lock of Python in between, and the memory of the
//! thread's last picture used again. The lines are those of `decode_image` and then `detect_ring` or `detect_line`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::measure::Line;
use super::rays::Annulus;
use super::sampling::{Grey, Plane};
use super::settings::Estimator;
use super::vectors::Vectors;
use super::{arrays, estimator_of, numbers, on_band, ring, unsound, Arrays, NoiseNumbers};
use crate::decode::{with_picture, Pixels, Size, Source};

type Ring = (Line, [f64; 2]);
/// Band, centre, inner and outer radius.
type Place = (usize, (f64, f64), (f64, f64));

/// What `work` finds in the picture of `source`, if that can be read, and is `size` (columns, rows).
fn found<R: Send>(
    py: Python<'_>,
    source: &Source<'_>,
    (size, limit): ((usize, usize), usize),
    work: impl Fn(&Seen<'_>) -> Option<R> + Send + Sync,
) -> Option<R> {
    let look = |shape: Size, pixels: Pixels<'_>| match (shape.width, shape.height) == size {
        true => work(&Seen { shape, pixels }),
        false => None,
    };
    with_picture(py, source, limit, look).flatten()
}

/// A picture in the memory of a thread.
struct Seen<'a> {
    shape: Size,
    pixels: Pixels<'a>,
}

/// What is done with a band of either kind.
trait Work {
    type Found;
    fn on<T: Grey>(&self, plane: &Plane<T>) -> Self::Found;
}

impl Seen<'_> {
    /// A grey picture has one band, whichever is asked for.
    fn on_band<W: Work>(&self, band: usize, vectors: Vectors, work: &W) -> Option<W::Found> {
        let Size { height, width, channels } = self.shape;
        let band = if channels == 1 { 0 } else { band };
        match self.pixels {
            Pixels::Eight(data) => on_band(data, (height, width, channels), (band, vectors), |plane| work.on(plane)),
            Pixels::Sixteen(data) => on_band(data, (height, width, channels), (band, vectors), |plane| work.on(plane)),
        }
    }
}

struct RingWork<'a>(Annulus<'a>, Estimator);

impl Work for RingWork<'_> {
    type Found = Result<Ring, &'static str>;
    fn on<T: Grey>(&self, plane: &Plane<T>) -> Self::Found {
        ring::measure(plane, self.0, self.1)
    }
}

struct LineWork(Estimator, bool);

impl Work for LineWork {
    type Found = Result<Line, &'static str>;
    fn on<T: Grey>(&self, plane: &Plane<T>) -> Self::Found {
        ring::measure_line(plane, self.0, self.1)
    }
}

/// What `detect_ring` finds at each of the `places` of the picture in `source` (a path, or the bytes of a file). None where anything is in
/// the way: the file is unusable, the picture is not of `size` (columns, rows), or one of the rings is not in it.
#[pyfunction]
#[pyo3(signature = (source, size, places, direction, counted, estimator, *, limit, vectors = true))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn detect_rings_in<'py>(
    py: Python<'py>,
    source: Source<'py>,
    size: (usize, usize),
    places: Vec<Place>,
    direction: PyReadonlyArray2<'py, f64>,
    counted: PyReadonlyArray1<'py, bool>,
    estimator: u8,
    limit: usize,
    vectors: bool,
) -> PyResult<Option<Vec<(Arrays<'py>, NoiseNumbers, f64, (f64, f64))>>> {
    let (estimator, vectors) = (estimator_of(estimator)?, Vectors::detected(vectors));
    let (direction, counted) = (direction.as_slice()?.as_chunks().0, counted.as_slice()?);
    let annulus = |(band, centre, radii): Place| {
        let annulus = Annulus { centre: [centre.0, centre.1], inner: radii.0, outer: radii.1, direction, counted };
        annulus.is_sound().then_some((band, RingWork(annulus, estimator))).ok_or_else(unsound)
    };
    let rings = places.into_iter().map(annulus).collect::<PyResult<Vec<_>>>()?;
    let every = |seen: &Seen<'_>| rings.iter().map(|(band, ring)| seen.on_band(*band, vectors, ring)?.ok()).collect();
    let found: Option<Vec<Ring>> = found(py, &source, (size, limit), every);
    let told = |(line, centre): Ring| {
        let (noise, scale) = (numbers(&line.noise), line.scale);
        (arrays(py, line), noise, scale, (centre[0], centre[1]))
    };
    Ok(found.map(|rings| rings.into_iter().map(told).collect()))
}

/// What `detect_line` finds in `band` of the picture in `source`; None as for `detect_rings_in`.
#[pyfunction]
#[pyo3(signature = (source, size, band, estimator, down, *, limit, vectors = true))]
#[allow(clippy::too_many_arguments)]
pub fn detect_line_in<'py>(
    py: Python<'py>,
    source: Source<'py>,
    size: (usize, usize),
    band: usize,
    estimator: u8,
    down: bool,
    limit: usize,
    vectors: bool,
) -> PyResult<Option<(Arrays<'py>, NoiseNumbers, f64)>> {
    let (work, vectors) = (LineWork(estimator_of(estimator)?, down), Vectors::detected(vectors));
    let found = found(py, &source, (size, limit), |seen| seen.on_band(band, vectors, &work)?.ok());
    Ok(found.map(|line: Line| {
        let (noise, scale) = (numbers(&line.noise), line.scale);
        (arrays(py, line), noise, scale)
    }))
}
