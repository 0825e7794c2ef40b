//! Stripe kernels, meetings of rays with surfaces of light, quantities of rings, and image decoding for `calibore`. Every kernel has a NumPy twin in Python that is its specification.

use pyo3::prelude::*;

mod decode;
mod meeting;
mod rings;
mod stripe;
mod water;

/// What `native/fuzz` calls: the entries of Python's functions, below Python.
#[cfg(fuzzing)]
pub mod entries {
    pub use crate::{decode::entries as decode, meeting::entries as meeting, stripe::entries as stripe};
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    decode::register(module)?;
    meeting::register(module)?;
    rings::register(module)?;
    stripe::register(module)
}
