//! Estimate of the peak memory of a file before it is read, from its length, format and options.
//!
//! Hulls dominate: a vertex on the hull takes about 620 bytes at the peak, other vertices about
//! 100. So the estimate depends on the minimum bytes of source per hull vertex. A test in
//! `interruptions.rs` measures that the bound holds for clouds whose points all lie on the hull.

use std::path::Path;

use hullmap_bake::IndexKind;

use crate::jobs::Job;

/// Memory per byte of an OBJ file. Measured: 17 to 20 for 100,000 points on the hull; earlier, up
/// to 59 with what the allocator retains of other threads' files, and up to 105 for 15,000 points.
const PER_TEXT_BYTE: u64 = 128;

/// Memory per byte of the other formats and their buffers, where a point takes as little as 12
/// bytes. Measured: 78, and up to twice that including retained memory.
const PER_DENSE_BYTE: u64 = 320;

const PER_FILE: u64 = 256 << 10;

/// Memory per cell of a cube map while it is built and proven: 288 bytes, and up to as much that
/// the allocator retains. In the pack, a cell takes 4 bytes.
const PER_CELL: u64 = 640;

/// Maximum estimate, more than any machine has. A plan may state any size, and estimates are added.
const MAX: u64 = 1 << 42;

/// Estimated peak memory in bytes. It excludes what only reading the file reveals: glTF instances,
/// which `max_instanced` limits, images of terrains that compress to less than a tenth, and
/// several cube maps that are built at the same time.
pub fn estimate(job: &Job) -> u64 {
    let per_byte = if is_text(&job.source) { PER_TEXT_BYTE } else { PER_DENSE_BYTE };
    let cells = match job.options.index() {
        kind @ IndexKind::CubeMap { .. } => kind.root_count(),
        _ => 0,
    };
    let estimate = PER_FILE + PER_CELL * cells;
    per_byte.saturating_mul(job.source_bytes()).saturating_add(estimate).min(MAX)
}

/// Text in other formats counts as dense.
fn is_text(path: &Path) -> bool {
    path.extension().is_none_or(|extension| extension.eq_ignore_ascii_case("obj"))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::jobs::job::Input;
    use crate::options::BuildOptions;
    use crate::options::resolved::tests::options;

    fn job(source: PathBuf, options: BuildOptions) -> Job {
        Job {
            source,
            place: String::new(),
            output: PathBuf::new(),
            options,
            config: None,
            name: Default::default(),
            records: None,
            inputs: Vec::new(),
            key: String::new(),
        }
    }

    #[test]
    fn estimates_depend_on_length_format_and_options() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, text: &str, options: &BuildOptions| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            estimate(&job(path, options.clone())) - PER_FILE
        };
        let usual = &BuildOptions::default();
        assert_eq!(of("a.obj", "12345", usual), 5 * PER_TEXT_BYTE);
        assert_eq!(of("a.ply", "12345", usual), 5 * PER_DENSE_BYTE);
        assert_eq!(of("a.bin", &"x".repeat(1000), usual), 1000 * PER_DENSE_BYTE);
        let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[{"uri":"a.bin","byteLength":1000}]}"#;
        assert_eq!(of("a.gltf", text, usual), (1000 + text.len() as u64) * PER_DENSE_BYTE, "with its buffer");
        let cube_map = options(&[("index", "cubemap")]);
        assert_eq!(of("a.obj", "", &cube_map), 6 * 64 * 64 * PER_CELL);
        assert_eq!(estimate(&job(folder.path().join("gone.obj"), usual.clone())), PER_FILE);

        // The glTF file was read before it was compared with its plan, and sums of sizes
        // overflowed.
        let mut planned = job(folder.path().join("a.gltf"), usual.clone());
        let input = |bytes| Input { path: String::new(), bytes, sha256: String::new() };
        planned.inputs = vec![input(3), input(4)];
        assert_eq!(estimate(&planned), PER_FILE + 7 * PER_DENSE_BYTE);
        planned.inputs = vec![input(u64::MAX), input(u64::MAX)];
        assert_eq!(estimate(&planned), MAX);
    }
}
