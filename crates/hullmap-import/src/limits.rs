//! Limits on the memory that a source file can take, each with its reason.
//!
//! Readers allocate memory for what a file contains, never for what its header claims. Limits are
//! necessary only where a few bytes stand for much more: an `o` line of two bytes becomes a hull,
//! and a node of twenty bytes repeats a whole mesh. With these limits an import takes at most
//! `MEMORY_FACTOR` times the bytes read, those bytes included, plus `MEMORY_BASE`, plus 64 bytes
//! for each vertex or corner that a glTF file repeats or compresses.

use crate::fault::Fault;

/// Peak memory of an import, as a multiple of the bytes read.
#[cfg(test)]
pub const MEMORY_FACTOR: u64 = 8;

/// Memory that an import may take beyond that, in bytes: the limited lists at their maximum
/// lengths. The largest holds 131,072 objects of one point each, at 560 bytes per object.
#[cfg(test)]
pub const MEMORY_BASE: u64 = 96 << 20;

/// Maximum number of entries of each list in a glTF file (nodes, meshes, accessors, …). Typical
/// files have some thousands. An entry can be as short as `{},` and takes up to 200 bytes of
/// memory, so a list takes at most 50 MiB.
pub const GLTF_LIST: usize = 1 << 18;

/// Limits that a user can raise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maximum size of a source file together with its buffers, in bytes. An import takes up to
    /// eight times as much memory.
    pub input_bytes: u64,
    /// Maximum number of objects (`o` lines, nodes with a mesh, solids) in a file that is split by
    /// object. Each becomes a hull, and packs are designed for up to about 100,000 hulls.
    pub objects: usize,
    /// Maximum number of vertices and corners that a glTF file contains only by repetition or
    /// compression: repeated instances, shared accessors, zeros, and what a compressed mesh has
    /// beyond its bytes. Each takes up to 64 bytes of memory. Every 32 decoded bytes of meshopt,
    /// primitives, and bytes of mesh names that name objects count, too.
    pub repeated_vertices: usize,
}

impl Limits {
    /// The default limits.
    pub const DEFAULT: Self = Self { input_bytes: 4 << 30, objects: 1 << 17, repeated_vertices: 1 << 22 };
}

impl Limits {
    pub(crate) fn too_much_repetition(&self) -> Fault {
        Fault::format(format!(
            "instances, zeros and compression add more than {} vertices and corners to the file; bake the meshes separately, or raise --set max_instanced",
            self.repeated_vertices
        ))
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}
