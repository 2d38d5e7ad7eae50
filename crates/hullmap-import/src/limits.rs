//! How much a source file may ask for: the numbers, each with its reason, in one place.
//!
//! Every reader takes memory for what is there, never for what a header claims, so that most files need no limit at
//! all. What is left are bytes that stand for much more than themselves: an `o` line of two bytes becomes a hull, a
//! node of twenty bytes repeats a whole mesh. With these limits, importing takes at most `MEMORY_FACTOR` times the
//! file, its own bytes included, and `MEMORY_BASE`, and 64 bytes for each vertex or corner that a glTF file repeats.

/// Peak memory of an import, in multiples of the bytes read.
#[cfg(test)]
pub const MEMORY_FACTOR: u64 = 8;

/// What an import may take beyond that: what limited lists come to at their longest, 131,072 objects of a point each at
/// 560 bytes before all.
#[cfg(test)]
pub const MEMORY_BASE: u64 = 96 << 20;

/// Most entries of each list in a glTF file (nodes, meshes, accessors, …): some thousands are usual. An entry can be as
/// short as `{},` and takes up to 200 bytes in memory, so that a list comes to 50 MiB at most.
pub const GLTF_LIST: usize = 1 << 18;

/// Corners that are handed to the second reader of OBJ files at a time. It keeps up to 80 bytes for each.
pub const CORNERS_AT_A_TIME: usize = 1 << 16;

/// Limits that a user may raise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most bytes of a source file and its buffers together. Importing takes up to eight times as much memory.
    pub input_bytes: u64,
    /// Most objects (`o` lines, nodes with a mesh, solids) of a file that is cut at objects: each becomes a hull, and a
    /// pack of 100,000 hulls is what the format is made for.
    pub objects: usize,
    /// Most vertices and corners that a glTF file may have without spelling them out: by instances beyond a mesh's
    /// first, by accessors that share bytes, and as zeros. They take up to 64 bytes each.
    pub repeated_vertices: usize,
}

impl Limits {
    /// What holds where nothing else is asked for.
    pub const DEFAULT: Self = Self { input_bytes: 4 << 30, objects: 1 << 17, repeated_vertices: 1 << 22 };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}
