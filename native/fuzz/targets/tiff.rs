#![no_main]

use calibore_fuzz::{images, Counting};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    let signatures = [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"];
    let known = signatures.iter().any(|signature| data.starts_with(*signature));
    images::read(data, if known { b"" } else { signatures[data.len() % signatures.len()] });
});
