//! What a file may take while it is in work, before it is read: by its length, its format and its options.
//!
//! Hulls are the most of it: a vertex that is on the hull takes some 940 bytes at its peak, one that is not about 100. So what
//! counts is how few bytes of a source can be a vertex on the hull. `interruptions.rs` of the tests measures that the bound
//! holds, on clouds all of whose points are.

use std::fs::metadata;
use std::path::Path;

use hullmap_bake::IndexKind;

use super::job::Job;

/// Memory for each byte of an OBJ file: 25 to 31 for 100,000 points that are all on the hull; with what the allocator keeps of files
/// that other threads baked before, up to 59 for those, and up to 105 for 15,000 points.
const PER_TEXT_BYTE: u64 = 128;

/// Memory for each byte of the other formats, and of their buffers, in which a point can be 12 bytes long: 78 for such a cloud, and
/// as with OBJ up to twice that with what the allocator keeps.
const PER_DENSE_BYTE: u64 = 320;

/// Memory of a file however short it is.
const PER_FILE: u64 = 256 << 10;

/// Memory of one voxel of a decomposition.
const PER_VOXEL: u64 = 64;

/// Memory of one cell of a cube map while it is made, 288 bytes, with what the allocator keeps; the pack has four bytes of them.
const PER_CELL: u64 = 480;

/// What baking this file may take, in bytes.
///
/// Two things are beyond it, as the file must be read to know them: instances of a glTF file, which `--max-instanced` bounds,
/// and hulls of a file with more than one, of which several cube maps can be in work at once.
pub fn estimate(job: &Job) -> u64 {
    let per_byte = if is_text(&job.source) { PER_TEXT_BYTE } else { PER_DENSE_BYTE };
    // A GLB file has its buffer in it, and would have to be read whole to be asked for others.
    let is_gltf = job.source.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    let buffers = if is_gltf { hullmap_import::buffers_of(&job.source).unwrap_or_default() } else { Vec::new() };
    let bytes: u64 = length(&job.source) + buffers.iter().map(|path| length(path)).sum::<u64>();
    let voxels = job.options.decompose.map_or(0, |parts| u64::from(parts.resolution).pow(3));
    let cells = match job.options.index {
        IndexKind::CubeMap { resolution } => 6 * u64::from(resolution).pow(2),
        _ => 0,
    };
    PER_FILE + per_byte * bytes + PER_VOXEL * voxels + PER_CELL * cells
}

/// Whether points are spelt in decimals. Text of other formats counts as dense: it is told apart by its bytes alone.
fn is_text(path: &Path) -> bool {
    path.extension().is_none_or(|extension| extension.eq_ignore_ascii_case("obj"))
}

/// A file that cannot be asked cannot be read either, which is told when it is tried.
fn length(path: &Path) -> u64 {
    metadata(path).map_or(0, |metadata| metadata.len())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::options::{BuildOptions, DecomposeOptions};

    fn job(source: PathBuf, options: BuildOptions) -> Job {
        Job { source, output: PathBuf::new(), options, config: None }
    }

    #[test]
    fn what_counts_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, text: &str, options| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            estimate(&job(path, options)) - PER_FILE
        };
        let usual = BuildOptions::DEFAULT;
        assert_eq!(of("a.obj", "12345", usual), 5 * PER_TEXT_BYTE);
        assert_eq!(of("a.ply", "12345", usual), 5 * PER_DENSE_BYTE);
        assert_eq!(of("a.bin", &"x".repeat(1000), usual), 1000 * PER_DENSE_BYTE);
        let text = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":1000}]}"#;
        assert_eq!(of("a.gltf", text, usual), (1000 + text.len() as u64) * PER_DENSE_BYTE, "with its buffer");
        let cube_map = BuildOptions { index: IndexKind::CubeMap { resolution: 10 }, ..usual };
        assert_eq!(of("a.obj", "", cube_map), 600 * PER_CELL);
        let parts = DecomposeOptions { resolution: 10, ..DecomposeOptions::DEFAULT };
        assert_eq!(of("a.obj", "", BuildOptions { decompose: Some(parts), ..usual }), 1000 * PER_VOXEL);
        assert_eq!(estimate(&job(folder.path().join("gone.obj"), usual)), PER_FILE);
    }
}
