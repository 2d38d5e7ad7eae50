//! glTF 2.0: the buffers with positions and vertex indices. Others have no effect on a hull, are
//! not read, and may be missing.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::container::{BufferLocation, Container};
use super::document::{Accessor, Document};
use super::{physics, scene};
use crate::fault::{LineFault, counted};
use crate::foreign::{LFS_REMEDY, is_lfs_pointer};

/// Paths of the buffers beside a file that are required, relative to it, without repetition, in the
/// document's order. Fails if a URI leads out of the file's folder. Complexity: O(document).
pub fn paths(container: &Container) -> Result<Vec<String>, LineFault> {
    let (mut paths, mut known) = (Vec::new(), HashSet::new());
    for (index, uri) in required(container) {
        if let BufferLocation::Beside(path) = locate(index, uri)?
            && known.insert(path.clone())
        {
            paths.push(path.into_owned());
        }
    }
    Ok(paths)
}

/// Bytes of every buffer. `None` for a buffer without bytes, and for one that is not required. The
/// error is the first buffer that is required, and missing or too short. Complexity: O(bytes).
pub fn read<'a>(
    container: &'a Container,
    beside: &'a [(String, Vec<u8>)],
) -> Result<Vec<Option<Cow<'a, [u8]>>>, LineFault> {
    let beside: HashMap<&str, &[u8]> = beside.iter().map(|(path, bytes)| (&path[..], &bytes[..])).collect();
    let records = &container.document.buffers;
    let mut buffers: Vec<Option<Cow<[u8]>>> = records.iter().map(|_| None).collect();
    for (index, uri) in required(container) {
        let fault = |text: String| LineFault::of_file(format!("buffer {index} {text}; export the file again"));
        let bytes: Cow<[u8]> = match locate(index, uri)? {
            // Only the first buffer can be the BIN chunk.
            BufferLocation::Chunk => match container.buffer {
                Some(chunk) if index == 0 => Cow::Borrowed(chunk),
                _ => continue,
            },
            BufferLocation::Data(data) => {
                Cow::Owned(STANDARD.decode(data).map_err(|error| fault(format!("has invalid base64 data: {error}")))?)
            }
            BufferLocation::Beside(path) => {
                // `read` reports what is missing on disk.
                let bytes = *beside.get(&path[..]).ok_or_else(|| {
                    let remedy = "export it as GLB, or with its buffers inside";
                    LineFault::of_file(format!(
                        "buffer {index} ({path}) is missing, since the file is read alone: {remedy}"
                    ))
                })?;
                if is_lfs_pointer(bytes) {
                    let text =
                        format!("buffer {index} ({path}) is a Git LFS pointer, not the buffer itself: {LFS_REMEDY}");
                    return Err(LineFault::of_file(text));
                }
                Cow::Borrowed(bytes)
            }
        };
        let claimed = records.get(index).map_or(0, |record| record.byte_length);
        if (bytes.len() as u64) < claimed {
            let claimed = counted(claimed, "byte", "bytes");
            return Err(fault(format!("should have {claimed} but has {}: it was cut off", bytes.len())));
        }
        if let Some(entry) = buffers.get_mut(index) {
            *entry = Some(bytes);
        }
    }
    Ok(buffers)
}

fn locate(index: usize, uri: Option<&str>) -> Result<BufferLocation<'_>, LineFault> {
    BufferLocation::from_uri(uri).map_err(|text| LineFault::of_file(format!("buffer {index} has {text}")))
}

/// Indices and URIs of the buffers with positions or vertex indices of the scene, and of its
/// colliders, even if these are not read: the files of a source do not depend on options.
/// References out of range are left to the reader of the scene, which reports them.
fn required<'a>(container: &'a Container) -> impl Iterator<Item = (usize, Option<&'a str>)> {
    let document = &container.document;
    let mut is_required = vec![false; document.buffers.len()];
    for view in views(document) {
        let view = document.buffer_views.get(view as usize);
        let buffer = view.map(|view| container.compression(view).map_or(view.buffer, |(_, data)| data.buffer));
        if let Some(entry) = buffer.and_then(|buffer| is_required.get_mut(buffer as usize)) {
            *entry = true;
        }
    }
    let buffers = document.buffers.iter().enumerate().zip(is_required);
    buffers.filter(|(_, is_required)| *is_required).map(|((index, buffer), _)| (index, buffer.uri.as_deref()))
}

/// Indices of the buffer views with positions or vertex indices of the scene and of its colliders,
/// with repetition. Complexity: O(document).
pub fn views(document: &Document) -> Vec<u32> {
    let mut views = Vec::new();
    let mut mark = |accessor: &Accessor| {
        let sparse = accessor.sparse.iter().flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
        views.extend(accessor.buffer_view.into_iter().chain(sparse));
    };
    let (is_shown, colliders) = (scene::shown_meshes(document), physics::meshes(document));
    let meshes = (0..).zip(document.meshes.iter()).zip(is_shown);
    let shown = meshes
        .filter(|((index, _), is_shown)| *is_shown || colliders.contains(index))
        .map(|((_, mesh), is_shown)| (mesh, is_shown));
    let mut draco_views = Vec::new();
    for primitive in shown.flat_map(|(mesh, _)| mesh.primitives.iter()) {
        let positions = primitive.attributes.position;
        let accessors = positions.into_iter().chain(positions.and(primitive.indices));
        let mut accessors = accessors.filter_map(|accessor| document.accessors.get(accessor as usize));
        match primitive.extensions.draco {
            Some(draco) if accessors.clone().any(|accessor| accessor.buffer_view.is_none()) => {
                draco_views.push(draco.buffer_view);
            }
            _ => accessors.by_ref().for_each(&mut mark),
        }
    }
    views.append(&mut draco_views);
    views
}
