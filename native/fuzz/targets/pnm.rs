#![no_main]

use calibore_fuzz::{images, Counting};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fuzz_target!(|data: &[u8]| images::read(data, if data.len() % 2 == 0 { b"P5" } else { b"P6" }));
