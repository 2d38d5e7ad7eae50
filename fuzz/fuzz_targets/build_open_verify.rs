//! Bytes as point sets: what is baked of them opens and is exact.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::build_open_verify(data));
