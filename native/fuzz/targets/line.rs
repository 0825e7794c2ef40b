#![no_main]

use calibore_fuzz::{lines, Counting};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fuzz_target!(|data: &[u8]| lines::lines(data));
