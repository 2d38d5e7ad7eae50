//! glTF 2.0, as text or GLB: the meshes of the default scene, with node transforms applied in
//! `f64`.
//!
//! 1. [`container`] parses the text. [`buffers`] finds the buffers with positions or indices of the
//!    scene: in the GLB file, in data URIs, or in files beside this one.
//! 2. [`scene`] visits the nodes of the default scene depth first. Without a default scene it takes
//!    the first one, and without any scene all nodes. Each node with a mesh becomes an object with
//!    the name of the node, or else of the mesh.
//! 3. [`accessor`] reads the positions of each primitive, which are then transformed. Primitives of
//!    a node that share an accessor share its vertices.
//!
//! Vertices are indexed in that order: by node, then by accessor in order of first use, then by
//! element. A mesh that several nodes reference is there several times.
//!
//! Only `POSITION` is read. Skins and morph targets stay at rest. Triangles, strips and fans become
//! faces, with reversed winding where a transform mirrors; points and lines are elements without
//! faces.
//!
//! # Deviations
//! Positions may have any type that `KHR_mesh_quantization` allows, whether or not the file
//! requires the extension. Integers may be written as `1.0`. In strips, fans and connected lines
//! the largest index of its type starts a new one, see [`scene`]. Errors in materials, animations,
//! cameras and the like are ignored.
//!
//! # Reference
//! Khronos, "glTF 2.0 Specification". The crate `gltf` has had no release since May 2024. It reads
//! accessors without a buffer view as empty (fixed since, but not released), underflows if a GLB
//! file claims to be shorter than its header, and takes some hundred bytes of memory for a node of
//! two bytes. The tests compare with it.

mod accessor;
mod buffers;
mod container;
mod document;
pub mod draco;
mod extensions;
mod meshopt;
mod physics;
mod scene;
mod version_1;

use glam::DAffine3;

use super::fault::{Fault, LineFault};
use super::limits::Limits;
use super::mesh::SourceMesh;
use accessor::Data;
use physics::Shapes;
use scene::SceneReader;

/// Relative paths of the required buffers beside a file, each once, in the document's order.
pub fn buffer_paths(bytes: &[u8]) -> Result<Vec<String>, LineFault> {
    buffers::paths(&container::open(bytes)?)
}

/// The mesh of the scene, and the node of each object with its transform to the scene. `beside`
/// holds the files of [`buffer_paths`]. With `reads_colliders`, colliders of physics extensions are
/// objects too, see [`physics`], but have no entry in that list. Complexity: O(bytes + vertices of
/// all instances).
pub fn read(
    bytes: &[u8],
    beside: &[(String, Vec<u8>)],
    reads_colliders: bool,
    limits: &Limits,
) -> Result<(SourceMesh, Vec<(u32, DAffine3)>), LineFault> {
    let container = container::open(bytes)?;
    let buffers = buffers::read(&container, beside)?;
    let buffers: Vec<Option<&[u8]>> = buffers.iter().map(|bytes| bytes.as_deref()).collect();
    let document = &container.document;
    let decoded = meshopt::decode(&container, &buffers, &buffers::views(document), limits)?;
    let data = Data { document, buffers, decoded: &decoded.views };
    let byte_count = bytes.len() + beside.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    let shapes = reads_colliders.then(|| Shapes::new(document)).transpose();
    let shapes = shapes.map_err(LineFault::of_file)?;
    SceneReader::new(data, byte_count, decoded.repeated_count, shapes, limits).read().map_err(Fault::of_file)
}

#[cfg(test)]
pub fn decoded_view(bytes: &[u8], view: u32, limits: &Limits) -> Result<Vec<u8>, LineFault> {
    let container = container::open(bytes)?;
    let buffers = buffers::read(&container, &[])?;
    let buffers: Vec<Option<&[u8]>> = buffers.iter().map(|bytes| bytes.as_deref()).collect();
    let mut decoded = meshopt::decode(&container, &buffers, &[view], limits)?;
    Ok(decoded.views.remove(&view).unwrap_or_default())
}
