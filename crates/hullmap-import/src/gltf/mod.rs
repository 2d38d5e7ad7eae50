//! glTF 2.0, as text or GLB: the meshes of the default scene, with node transforms applied in
//! `f64`.
//!
//! 1. [`container`] parses the text and locates the buffers: in the GLB file, in data URIs, or in
//!    files beside this one.
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
//! requires the extension. Errors in materials, animations, cameras and the like are ignored.
//!
//! # Reference
//! Khronos, "glTF 2.0 Specification". The crate `gltf` has had no release since May 2024. It reads
//! accessors without a buffer view as empty (fixed since, but not released), subtracts without a
//! check where a GLB file claims to be shorter than its header, and holds the whole document at
//! some hundred bytes for a node of two. The tests compare with it.

mod accessor;
mod container;
mod document;
mod scene;

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::fault::{Fault, LineFault};
use super::limits::Limits;
use super::mesh::SourceMesh;
use accessor::Data;
use container::{BufferLocation, Container};
use scene::SceneReader;

/// Paths of the buffers beside a file, relative to it, without repetition, in the document's order.
///
/// # Errors
/// See [`container::open`]. Also a URI that leads out of the file's folder.
///
/// # Complexity
/// O(bytes).
pub fn buffer_paths(bytes: &[u8]) -> Result<Vec<String>, LineFault> {
    let container = container::open(bytes)?;
    let (mut paths, mut known) = (Vec::new(), HashSet::new());
    for (index, buffer) in container.document.buffers.iter().enumerate() {
        if let BufferLocation::Beside(path) = locate(index, buffer.uri.as_deref())?
            && known.insert(path.clone())
        {
            paths.push(path.into_owned());
        }
    }
    Ok(paths)
}

fn locate(index: usize, uri: Option<&str>) -> Result<BufferLocation<'_>, LineFault> {
    BufferLocation::of(uri).map_err(|text| Fault::format(format!("buffer {index} has {text}")).of_file())
}

/// Reads a glTF file. `beside` holds the files of [`buffer_paths`].
///
/// # Errors
/// The first fault, with its node, mesh, accessor or buffer.
///
/// # Complexity
/// O(bytes + vertices of all instances).
pub fn read(bytes: &[u8], beside: &[(String, Vec<u8>)], limits: &Limits) -> Result<SourceMesh, LineFault> {
    let container = container::open(bytes)?;
    let buffers = buffers(&container, beside)?;
    let data = Data { document: &container.document, buffers: buffers.iter().map(|buffer| &buffer[..]).collect() };
    let byte_count = bytes.len() + beside.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    SceneReader::new(data, byte_count, limits).read().map_err(Fault::of_file)
}

/// Bytes of every buffer.
fn buffers<'a>(container: &Container<'a>, beside: &'a [(String, Vec<u8>)]) -> Result<Vec<Cow<'a, [u8]>>, LineFault> {
    let beside: HashMap<&str, &[u8]> = beside.iter().map(|(path, bytes)| (&path[..], &bytes[..])).collect();
    let mut buffers: Vec<Cow<[u8]>> = Vec::with_capacity(container.document.buffers.len());
    for (index, buffer) in container.document.buffers.iter().enumerate() {
        let fault = |text: String| Fault::format(format!("buffer {index} {text}; export the file again")).of_file();
        let bytes: Cow<[u8]> = match locate(index, buffer.uri.as_deref())? {
            BufferLocation::Chunk => Cow::Borrowed(
                container.buffer.ok_or_else(|| fault("has no URI, and the file has no BIN chunk".to_owned()))?,
            ),
            BufferLocation::Data(data) => {
                Cow::Owned(STANDARD.decode(data).map_err(|error| fault(format!("has invalid base64 data: {error}")))?)
            }
            BufferLocation::Beside(path) => {
                Cow::Borrowed(beside.get(&path[..]).ok_or_else(|| fault(format!("({path}) is missing")))?)
            }
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let (claimed, have) = (buffer.byte_length, bytes.len());
            return Err(fault(format!("should have {claimed} bytes but has {have}: it was cut off")));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}
