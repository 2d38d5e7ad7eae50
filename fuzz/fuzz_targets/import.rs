//! Reads bytes as a source file of any format. The result must be points with indices in range, or
//! an error that names the file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::import(data));
