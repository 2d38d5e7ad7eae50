//! Reads bytes as two shapes and their poses. Answers must not contain NaN or exceed a limit, and
//! intervals must agree with brute force.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| hullmap_tests::fuzzed::solver(data));
