//! PNG, JPEG, TIFF, BMP, PGM and PPM files to arrays. Files are untrusted: whatever they hold, the answer is a whole image or an error, within a
//! stated amount of memory. Alpha is dropped; orientation tags, gamma and colour profiles are ignored, for pixels are measurements here.

mod bmp;
#[cfg(fuzzing)]
pub mod entries;
mod jpeg;
mod lying;
mod picture;
mod png;
mod png_plain;
mod png_rows;
mod png_together;
mod pnm;
mod samples;
mod scratch;
mod tiff;
mod tiff_directory;

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::{Path, PathBuf};

use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIsADirectoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

pub use picture::{with_picture, Pixels, Size};
use samples::{Image, Samples};

/// Most bytes that an image may have by default, decoded or as a file.
const LIMIT: usize = 1_000_000_000;

/// Longest signature looked at.
const SIGNATURE: usize = 8;

/// Characters of a reason that people still read.
const LONGEST_REASON: usize = 200;

/// Why data is not a usable image: the middle of a sentence.
type Decoded<T> = Result<T, String>;

const TOO_LARGE: &str = "it needs more memory than the limit";
const TRUNCATED: &str = "it is truncated: the data end before the image is complete";

#[derive(Clone, Copy)]
enum Format {
    Png,
    Jpeg,
    Tiff,
    Bmp,
    Pnm,
}

impl Format {
    fn of(start: &[u8]) -> Decoded<Format> {
        match start {
            [] => Err("it is empty (0 bytes)".into()),
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Ok(Format::Png),
            [0xff, 0xd8, ..] => Ok(Format::Jpeg),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Ok(Format::Tiff),
            [b'B', b'M', ..] => Ok(Format::Bmp),
            [b'P', b'5' | b'6', b'#' | b' ' | b'\t'..=b'\r', ..] => Ok(Format::Pnm),
            _ => Err("it is not a PNG, JPEG, TIFF, BMP, PGM or PPM image".into()),
        }
    }
}

/// Bytes of `width` x `height` pixels, refused where they exceed `limit` or there are none.
fn checked_bytes(width: usize, height: usize, bytes_per_pixel: usize, limit: usize) -> Decoded<usize> {
    match width.checked_mul(height).and_then(|pixels| pixels.checked_mul(bytes_per_pixel)) {
        Some(0) => Err(format!("it declares {width} x {height} pixels")),
        Some(bytes) if bytes <= limit => Ok(bytes),
        _ => Err(format!("it declares {width} x {height} pixels, more than the limit of {limit} bytes")),
    }
}

/// A panic in a decoder is a defect of the decoder, met on data it did not expect: an error like any other.
fn guarded<T>(work: impl FnOnce() -> Decoded<T>) -> Decoded<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err("its data are corrupt (the decoder gave up)".into())).map_err(readable)
}

/// Decoders repeat what a file says, which may be long and no text.
fn readable(why: String) -> String {
    let mut kept: String = why.chars().take(LONGEST_REASON).map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    if kept.len() < why.len() {
        kept += "...";
    }
    kept
}

fn decode(data: &[u8], limit: usize) -> Decoded<Image> {
    simple(data, limit).map_or_else(|| of_any_kind(data, limit), Ok)
}

/// By the short ways for what most files are; none where they do not lead to a whole image.
fn simple(data: &[u8], limit: usize) -> Option<Image> {
    let format = Format::of(&data[..data.len().min(SIGNATURE)]).ok()?;
    guarded(|| match format {
        Format::Png => png_plain::decode(data, limit).ok_or_else(String::new),
        Format::Tiff => tiff::lying(data).ok_or_else(String::new)?.image(data, limit),
        _ => Err(String::new()),
    })
    .ok()
}

/// By the decoders that know every kind of file and what can be wrong with it.
fn of_any_kind(data: &[u8], limit: usize) -> Decoded<Image> {
    let format = Format::of(&data[..data.len().min(SIGNATURE)])?;
    guarded(|| match format {
        Format::Png => png::decode(data, limit),
        Format::Jpeg => jpeg::decode(data, limit),
        Format::Tiff => tiff::decode(data, limit),
        Format::Bmp => bmp::decode(data, limit),
        Format::Pnm => pnm::lying(data)?.image(data, limit),
    })
}

fn size(mut reader: impl BufRead + Seek) -> Decoded<(usize, usize)> {
    let start = reader.fill_buf().map_err(|error| error.to_string())?;
    let format = Format::of(&start[..start.len().min(SIGNATURE)])?;
    guarded(|| match format {
        Format::Png => png::size(reader),
        Format::Jpeg => jpeg::size(reader),
        Format::Tiff => tiff::size(reader),
        Format::Bmp => bmp::size(reader),
        Format::Pnm => pnm::size(reader),
    })
}

/// A picture's file: its path, or its bytes.
#[derive(FromPyObject)]
pub enum Source<'py> {
    #[pyo3(transparent, annotation = "bytes")]
    Data(Bound<'py, PyBytes>),
    #[pyo3(transparent, annotation = "str | os.PathLike[str]")]
    Path(PathBuf),
}

/// Only regular files: a pipe or a device would never end.
fn regular_file(path: &Path) -> PyResult<u64> {
    let metadata = fs::metadata(path)?;
    match metadata.is_file() {
        true => Ok(metadata.len()),
        false => Err(PyIsADirectoryError::new_err("it is not a regular file")),
    }
}

/// `work` with the bytes of the file, in memory that the thread uses again.
fn with_file<R>(path: &Path, limit: usize, work: impl FnOnce(&[u8]) -> PyResult<R>) -> PyResult<R> {
    let length = regular_file(path)?;
    if length > limit as u64 {
        return Err(PyValueError::new_err(format!("it has {length} bytes, more than the limit of {limit}")));
    }
    scratch::with_file(|buffer| {
        buffer.reserve(length as usize + 1);
        File::open(path)?.take(limit as u64).read_to_end(buffer)?;
        work(buffer)
    })
}

/// `work` with the bytes of `source`, the GIL released.
fn with_data<R: Send>(py: Python<'_>, source: &Source<'_>, limit: usize, work: impl FnOnce(&[u8]) -> PyResult<R> + Send) -> PyResult<R> {
    match source {
        Source::Data(data) => {
            let data = data.as_bytes();
            py.detach(|| work(data))
        }
        Source::Path(path) => py.detach(|| with_file(path, limit, work)),
    }
}

fn array<'py, T: Element>(py: Python<'py>, samples: Vec<T>, shape: (usize, usize, usize)) -> PyResult<Bound<'py, PyAny>> {
    let flat = PyArray1::from_vec(py, samples);
    match shape {
        (height, width, 1) => Ok(flat.reshape([height, width])?.into_any()),
        (height, width, channels) => Ok(flat.reshape([height, width, channels])?.into_any()),
    }
}

/// The image in `source` (a path, or the bytes of a file): an array (h, w) or (h, w, 3), uint8 or uint16.
///
/// Raises ValueError (the middle of a sentence: "it is truncated ...") for data that are not a whole image or need more than `limit`
/// bytes, OSError for a file that cannot be read. The GIL is released meanwhile. Not `simple`, the decoders for every kind of file are used
/// where shorter ways lead to the same.
#[pyfunction]
#[pyo3(signature = (source, *, limit = LIMIT, simple = true))]
fn decode_image<'py>(py: Python<'py>, source: Source<'py>, limit: usize, simple: bool) -> PyResult<Bound<'py, PyAny>> {
    let way = if simple { decode } else { of_any_kind };
    let image = with_data(py, &source, limit, |data| way(data, limit).map_err(PyValueError::new_err))?;
    let shape = (image.height, image.width, image.channels);
    match image.samples {
        Samples::Eight(samples) => array(py, samples, shape),
        Samples::Sixteen(samples) => array(py, samples, shape),
    }
}

/// Pixels (h, w, 3) of three planes (h, w), all of uint8 or all of uint16.
#[pyfunction]
fn interleave<'py>(py: Python<'py>, planes: [Bound<'py, PyAny>; 3]) -> PyResult<Bound<'py, PyAny>> {
    match of_planes::<u8>(py, &planes)? {
        Some(pixels) => Ok(pixels),
        None => of_planes::<u16>(py, &planes)?.ok_or_else(|| PyValueError::new_err("planes must be of one shape, uint8 or uint16")),
    }
}

/// None where one of the planes is not of `T`, or not as large as the first.
fn of_planes<'py, T: Element + Copy + Default + Send + Sync>(
    py: Python<'py>,
    planes: &[Bound<'py, PyAny>; 3],
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let planes = planes.each_ref().map(|plane| plane.extract::<PyReadonlyArray2<'py, T>>());
    let [Ok(red), Ok(green), Ok(blue)] = planes else { return Ok(None) };
    let [height, width] = *red.shape() else { return Ok(None) };
    if green.shape() != red.shape() || blue.shape() != red.shape() {
        return Ok(None);
    }
    let planes = [red.as_slice()?, green.as_slice()?, blue.as_slice()?];
    let samples = py.detach(|| samples::interleaved(planes));
    array(py, samples, (height, width, planes.len())).map(Some)
}

/// (width, height) in pixels from the header of `source` alone; errors as for `decode_image`.
#[pyfunction]
fn image_size(py: Python<'_>, source: Source<'_>) -> PyResult<(usize, usize)> {
    match &source {
        Source::Data(data) => size(Cursor::new(data.as_bytes())).map_err(PyValueError::new_err),
        Source::Path(path) => py.detach(|| {
            regular_file(path)?;
            size(BufReader::new(File::open(path)?)).map_err(PyValueError::new_err)
        }),
    }
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(decode_image, module)?)?;
    module.add_function(wrap_pyfunction!(interleave, module)?)?;
    module.add_function(wrap_pyfunction!(image_size, module)?)
}
