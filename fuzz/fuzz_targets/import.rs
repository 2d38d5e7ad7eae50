//! Bytes as a source file of any format: a mesh whose points are finite and whose numbers are in range, or a fault that names
//! the file.
#![no_main]

use std::path::Path;

use bake::import::{EXTENSIONS, Limits, SourceFile, import};
use bake::options::ImportOptions;
use libfuzzer_sys::fuzz_target;

// The first byte says the format.
fuzz_target!(|data: &[u8]| {
    let Some((format, bytes)) = data.split_first() else { return };
    let extension = EXTENSIONS[usize::from(*format) % EXTENSIONS.len()];
    let file = format!("fuzzed.{extension}");
    // Small, so that what a few bytes may ask for does not take the fuzzer's memory.
    let limits = Limits { objects: 1 << 10, repeated_vertices: 1 << 16, ..Limits::DEFAULT };
    let source = SourceFile::alone(bytes.to_vec());
    match import(&file, "fuzzed", Path::new(&file), &source, &ImportOptions::DEFAULT, &limits) {
        Ok(imported) => {
            for set in &imported.point_sets {
                assert!(!set.positions.is_empty() && set.positions.len() == set.source_vertices.len());
                assert!(set.positions.iter().flatten().all(|c| c.is_finite()));
                assert!(set.source_vertices.iter().all(|v| (*v as usize) < imported.vertex_count));
            }
        }
        Err(error) => assert!(error.to_string().contains(&file), "{error}"),
    }
});
