#![no_main]

use calibore_fuzz::{meetings, Counting};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fuzz_target!(|data: &[u8]| meetings::measures(data));
