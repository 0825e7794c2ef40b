//! Stripe kernels, meetings of rays with surfaces of light, and image decoding for `calibore`; no domain logic. Every kernel has a NumPy twin in Python that is its specification.

use pyo3::prelude::*;

mod decode;
mod meeting;
mod stripe;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    decode::register(module)?;
    meeting::register(module)?;
    stripe::register(module)
}
