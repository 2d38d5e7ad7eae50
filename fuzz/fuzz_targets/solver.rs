//! Bytes as two shapes and how they lie: no NaN, caps held, intervals true by brute force.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::solver(data));
