//! Memory that a thread keeps from one picture to the next: fresh megabytes cost the system a page fault for every 4 kB. What is in it
//! is what earlier pictures have left.

use std::cell::Cell;

use libdeflater::Decompressor;

use super::samples::Samples;

/// Most bytes that one buffer of a thread keeps between pictures.
const KEPT: usize = 1 << 26;

/// What deflated rows are inflated with.
pub struct Inflation {
    pub packed: Vec<u8>,
    pub rows: Vec<u8>,
    pub inflater: Decompressor,
}

thread_local! {
    static FILE: Cell<Vec<u8>> = const { Cell::new(Vec::new()) };
    static INFLATION: Cell<Option<Inflation>> = const { Cell::new(None) };
    static SAMPLES: Cell<Option<Samples>> = const { Cell::new(None) };
}

/// `work` with an empty buffer for a file.
pub fn with_file<R>(work: impl FnOnce(&mut Vec<u8>) -> R) -> R {
    let mut file = FILE.take();
    file.clear();
    let result = work(&mut file);
    if file.capacity() <= KEPT {
        FILE.set(file);
    }
    result
}

pub fn with_inflation<R>(work: impl FnOnce(&mut Inflation) -> R) -> R {
    let empty = || Inflation { packed: Vec::new(), rows: Vec::new(), inflater: Decompressor::new() };
    let mut inflation = INFLATION.take().unwrap_or_else(empty);
    let result = work(&mut inflation);
    if inflation.packed.capacity().max(inflation.rows.capacity()) <= KEPT {
        INFLATION.set(Some(inflation));
    }
    result
}

/// The samples of a picture that was given back.
pub fn samples() -> Option<Samples> {
    SAMPLES.take()
}

/// For the next picture of this thread.
pub fn give_back(samples: Samples) {
    let bytes = match &samples {
        Samples::Eight(samples) => samples.capacity(),
        Samples::Sixteen(samples) => 2 * samples.capacity(),
    };
    if bytes <= KEPT {
        SAMPLES.set(Some(samples));
    }
}
