//! Reads bytes as a triangle mesh and as a height field. Each must be rejected, or every query on
//! it must end without a panic.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::open_sheets(data));

// Two out of three mutations change words and keep the length. The others are libFuzzer's own.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    if seed % 3 == 0 {
        fuzzer_mutate(data, size, max_size)
    } else {
        hullmap_tests::fuzzed::change_pack(&mut data[..size], seed);
        size
    }
});
