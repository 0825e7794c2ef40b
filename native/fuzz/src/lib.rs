//! What every fuzzing target shares: how much memory a call took, whose panic it was, and how bytes become arguments.
//! Run them with `python -m fuzzing`, which knows the flags.

mod bytes;
mod guard;
mod pictures;

pub mod images;
pub mod lines;
pub mod meetings;

pub use bytes::Bytes;
pub use guard::{guarded, Counting};
