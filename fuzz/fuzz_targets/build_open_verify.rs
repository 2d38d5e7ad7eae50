//! Reads bytes as point sets. The baked pack must open and be exact.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::build_open_verify(data));
