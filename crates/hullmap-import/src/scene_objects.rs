//! The objects of a glTF file with their nodes, for programs that write into the file.

use glam::DAffine3;

use crate::fault::{ImportError, LineFault};
use crate::gltf;
use crate::limits::Limits;
use crate::point_sets::object_names;
use crate::read::SourceFile;

/// A node with a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Name of its hull in a pack that is split by object.
    pub name: String,
    /// Index of the node in the file.
    pub node: usize,
    /// Transform from the frame of the node to the frame of the scene.
    pub node_in_scene: DAffine3,
}

/// The nodes with meshes in the default scene of a glTF file, in the order and with the names of a
/// pack's hulls that is split by object. `file` is the name of the file in messages, and `stem` the
/// name of objects without one.
///
/// # Errors
/// The first fault in the file, as for [`import`](crate::import).
///
/// ```
/// use hullmap_import::{Limits, SourceFile, scene_objects};
///
/// let file = r#"{"asset":{"version":"2.0"},"nodes":[{"children":[1]},{"name":"box","mesh":0}],
///     "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}],
///     "accessors":[{"componentType":5126,"type":"VEC3","count":1}]}"#;
/// let source = SourceFile::alone(file.as_bytes().to_vec());
/// let objects = scene_objects("a.gltf", "a", &source, &Limits::DEFAULT)?;
/// assert_eq!((objects[0].name.as_str(), objects[0].node), ("box", 1));
/// # Ok::<(), hullmap_import::ImportError>(())
/// ```
pub fn scene_objects(
    file: &str,
    stem: &str,
    source: &SourceFile,
    limits: &Limits,
) -> Result<Vec<SceneObject>, ImportError> {
    let name = |LineFault { line, fault }| ImportError { file: file.to_owned(), line, fault };
    let (mesh, places) = gltf::read(&source.bytes, &source.beside, false, limits).map_err(name)?;
    let objects = object_names(&mesh, stem).into_iter().filter_map(|(object, name)| {
        let &(node, node_in_scene) = places.get(object)?;
        Some(SceneObject { name, node: node as usize, node_in_scene })
    });
    Ok(objects.collect())
}
