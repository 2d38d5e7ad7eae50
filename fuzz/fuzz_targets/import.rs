//! Bytes as a source file of any format: points with their numbers in range, or a fault that names
//! the file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::import(data));
