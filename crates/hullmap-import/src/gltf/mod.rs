//! glTF 2.0, as text or GLB: the meshes of the default scene, each node's transform applied in f64.
//!
//! 1. `container` parses the text, and finds the buffers: in the GLB file, in data URIs, or in files beside this one.
//! 2. From the roots of the default scene (of the first one where none is the default; of all nodes where there is no
//!    scene), depth first, every node with a mesh becomes an object, with the node's name, or else the mesh's.
//! 3. Each primitive's positions are read and transformed; several primitives of a node that share an accessor share
//!    its vertices.
//!
//! Vertices are numbered in that order: node after node, within it accessor after accessor as primitives first name
//! them, within those by element. A mesh that several nodes show is there several times.
//!
//! Only `POSITION` is read; skins and morph targets are left at rest. Triangles, strips and fans become faces, wound
//! the other way where a transform mirrors; points and lines count as elements.
//!
//! Deviations: positions may be of any type that `KHR_mesh_quantization` allows, required or not; what is wrong with
//! materials, animations, cameras and the like does not matter.
//!
//! # Reference
//! Khronos, "glTF 2.0 Specification". The crate `gltf` has had no release since May 2024: it reads accessors without a
//! buffer view as if they were empty (mended since, not released), subtracts without a check where a GLB file claims to
//! be shorter than its header, and holds the whole document, some hundred bytes for a node of two. It is a second
//! opinion in the tests.

mod accessor;
mod container;
mod document;

use std::borrow::Cow;
use std::collections::HashMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::fault::{Fault, LineFault, excerpt};
use super::limits::Limits;
use super::mesh::{Mesh, Polygons, Positions};
use accessor::{Data, Elements};
use container::{Place, remedy};
use document::{Document, Kind, Node, Primitive};

/// Primitive modes, by their numbers in OpenGL. Below are points and lines.
const TRIANGLES: u32 = 4;
const TRIANGLE_STRIP: u32 = 5;
const TRIANGLE_FAN: u32 = 6;

/// Bytes of the file that a vertex, a corner, and a corner of a strip or fan should have taken: at least what they take
/// as shorts, and enough for what they become in memory.
const VERTEX_BYTES: usize = 8;
const CORNER_BYTES: usize = 2;
const STRIP_CORNER_BYTES: usize = 4;

/// Paths of the buffers that lie beside a file, relative to it, each once, in the document's order.
///
/// # Errors
/// See [`container::open`]; and a URI that leads elsewhere.
pub fn buffer_paths(bytes: &[u8]) -> Result<Vec<String>, LineFault> {
    let container = container::open(bytes)?;
    let mut paths: Vec<String> = Vec::new();
    for (number, buffer) in container.document.buffers.iter().enumerate() {
        if let Place::Beside(path) = place(number, buffer.uri.as_deref())?
            && !paths.iter().any(|known| *known == path)
        {
            paths.push(path.into_owned());
        }
    }
    Ok(paths)
}

fn place(number: usize, uri: Option<&str>) -> Result<Place<'_>, LineFault> {
    Place::of(uri).map_err(|text| Fault::format(format!("buffer {number} has {text}")).of_file())
}

/// Reads a glTF file; `beside` holds the files of [`buffer_paths`].
///
/// # Errors
/// The first fault, with node, mesh, accessor or buffer.
///
/// # Complexity
/// O(bytes + vertices of all instances).
pub fn read(bytes: &[u8], beside: &[(String, Vec<u8>)], limits: &Limits) -> Result<Mesh, LineFault> {
    let container = container::open(bytes)?;
    let document = &container.document;
    let mut buffers: Vec<Cow<[u8]>> = Vec::with_capacity(document.buffers.len());
    for (number, buffer) in document.buffers.iter().enumerate() {
        let fault = |text: String| Fault::format(format!("buffer {number} {text}; export the file again")).of_file();
        let bytes: Cow<[u8]> = match place(number, buffer.uri.as_deref())? {
            Place::Chunk => Cow::Borrowed(
                container.buffer.ok_or_else(|| fault("has no URI, and no BIN chunk is there".to_owned()))?,
            ),
            Place::Data(data) => {
                Cow::Owned(STANDARD.decode(data).map_err(|error| fault(format!("is no base64: {error}")))?)
            }
            Place::Beside(path) => {
                let found = beside.iter().find(|(known, _)| *known == path);
                Cow::Borrowed(&found.ok_or_else(|| fault(format!("({path}) is missing")))?.1[..])
            }
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let (claimed, have) = (buffer.byte_length, bytes.len());
            return Err(fault(format!("should have {claimed} bytes and has {have}: it was cut off")));
        }
        buffers.push(bytes);
    }
    let data = Data { document, buffers: buffers.iter().map(|buffer| &buffer[..]).collect() };
    let mut scene = Scene {
        data,
        limits,
        positions: Vec::new(),
        mesh: Mesh::of(Positions::Double(Vec::new()), Polygons::default()),
        shown: vec![false; document.meshes.len()],
        spelling: bytes.len() + beside.iter().map(|(_, bytes)| bytes.len()).sum::<usize>(),
        repeated: 0,
        object_count: 0,
        moving_count: 0,
    };
    scene.walk().map_err(Fault::of_file)?;
    scene.finish().map_err(Fault::of_file)
}

/// The scene, as it is being read.
struct Scene<'a> {
    data: Data<'a>,
    limits: &'a Limits,
    positions: Vec<[f64; 3]>,
    mesh: Mesh,
    /// For each mesh whether a node has shown it.
    shown: Vec<bool>,
    /// Bytes that are there to spell out vertices and corners.
    spelling: usize,
    /// Vertices and corners beyond those.
    repeated: usize,
    object_count: usize,
    /// Nodes with a skin, and primitives with morph targets.
    moving_count: usize,
}

impl<'a> Scene<'a> {
    fn walk(&mut self) -> Result<(), Fault> {
        let document = self.data.document;
        let nodes = &document.nodes;
        if nodes.is_empty() {
            // A library of meshes without a scene.
            for (number, mesh) in document.meshes.iter().enumerate() {
                let name = mesh.name.as_deref().unwrap_or_default();
                self.show(name, &format!("mesh {number}"), number as u32, DAffine3::IDENTITY)?;
            }
            return Ok(());
        }
        let mut visited = vec![false; nodes.len()];
        // Depth first without recursion: a chain of nodes may be as long as the list.
        let mut stack: Vec<(u32, DAffine3)> = Vec::new();
        for root in roots(document)?.into_iter().rev() {
            stack.push((root, DAffine3::IDENTITY));
        }
        while let Some((number, parent)) = stack.pop() {
            let (Some(node), Some(visited)) = (nodes.get(number as usize), visited.get_mut(number as usize)) else {
                let count = nodes.len();
                return Err(Fault::format(format!(
                    "node {number} does not exist: there are {count}; export the file again"
                )));
            };
            if std::mem::replace(visited, true) {
                return Err(Fault::format(format!(
                    "node {number}{} has two parents, or is its own ancestor; expected a tree: export the file again",
                    quoted(node.name.as_deref())
                )));
            }
            let place = || format!("node {number}{}", quoted(node.name.as_deref()));
            let transform = parent * local(node).map_err(|text| Fault::format(format!("{} {text}", place())))?;
            if let Some(mesh) = node.mesh {
                let record = document.meshes.get(mesh as usize);
                let name = node.name.as_deref().filter(|name| !name.is_empty());
                let name = name.or(record.and_then(|record| record.name.as_deref())).unwrap_or_default();
                self.moving_count += usize::from(node.skin.is_some());
                self.show(name, &place(), mesh, transform)?;
            }
            stack.extend(node.children.iter().rev().map(|&child| (child, transform)));
        }
        Ok(())
    }

    /// Adds a mesh as an object.
    fn show(&mut self, name: &str, place: &str, number: u32, transform: DAffine3) -> Result<(), Fault> {
        let document = self.data.document;
        let place_in_list = number as usize;
        let (Some(record), Some(shown)) = (document.meshes.get(place_in_list), self.shown.get_mut(place_in_list))
        else {
            return Err(Fault::format(format!(
                "{place} shows mesh {number}, which does not exist: there are {}; export the file again",
                document.meshes.len()
            )));
        };
        *shown = true;
        self.begin_object(name);
        // First vertex and number of vertices of each accessor that this node has read.
        let mut read: HashMap<u32, (u32, usize)> = HashMap::new();
        for primitive in record.primitives.iter() {
            self.moving_count += usize::from(primitive.targets.is_some());
            // Without positions there is nothing to show, by the specification.
            let Some(accessor) = primitive.attributes.position else {
                continue;
            };
            let within = |fault: Fault| match fault {
                Fault::Format(text) => Fault::Format(format!("{place}, mesh {number}: {text}")),
                other => other,
            };
            let (first, count) = match read.get(&accessor) {
                Some(&known) => known,
                None => {
                    let elements = self.data.elements(accessor, Kind::Vec3).map_err(within)?;
                    if primitive.extensions.draco.is_some() && elements.has_no_bytes() {
                        let name = "KHR_draco_mesh_compression";
                        return Err(within(Fault::format(format!("compressed by {name}; {}", remedy(name)))));
                    }
                    let first = self.add_vertices(&elements, transform).map_err(within)?;
                    read.insert(accessor, (first, elements.count));
                    (first, elements.count)
                }
            };
            self.add_elements(primitive, first, count, transform).map_err(within)?;
        }
        Ok(())
    }

    fn begin_object(&mut self, name: &str) {
        self.object_count += 1;
        if self.object_count == 1 {
            if let Some(first) = self.mesh.objects.first_mut() {
                first.name = name.to_owned();
            }
            return;
        }
        // As the limit is for objects, and the first one has no line of its own.
        if self.mesh.objects.len() >= self.limits.objects {
            self.mesh.has_too_many_objects = true;
            return;
        }
        self.mesh.begin_object(name.to_owned(), self.limits.objects);
        if let Some(object) = self.mesh.objects.last_mut() {
            object.first_vertex = self.positions.len() as u32;
        }
    }

    /// Counts vertices or corners, of which each should have taken so many bytes of the file. Instances, accessors that
    /// share bytes, and those without bytes take more than there are.
    fn count(&mut self, count: usize, bytes_each: usize) -> Result<(), Fault> {
        let spelt = count.min(self.spelling / bytes_each);
        self.spelling -= spelt * bytes_each;
        self.repeated += count - spelt;
        if self.repeated > self.limits.repeated_vertices {
            return Err(Fault::format(format!(
                "more than {} vertices and corners that the file only repeats, by instances or as zeros; bake the meshes by themselves, or raise --max-instanced",
                self.limits.repeated_vertices
            )));
        }
        Ok(())
    }

    fn add_vertices(&mut self, elements: &Elements, transform: DAffine3) -> Result<u32, Fault> {
        let first = self.positions.len();
        if first + elements.count > (u32::MAX - 1) as usize {
            return Err(Fault::TooManyVertices);
        }
        self.count(elements.count, VERTEX_BYTES)?;
        self.positions.reserve(elements.count);
        for at in 0..elements.count {
            let position = elements.position(at)?;
            let placed = if transform == DAffine3::IDENTITY {
                position
            } else {
                transform.transform_point3(DVec3::from_array(position)).to_array()
            };
            if !placed.iter().all(|x| x.is_finite()) {
                return Err(Fault::format(format!(
                    "vertex {at} is at {position:?}, {placed:?} in the scene; a hull needs finite points: mend the mesh where it was made"
                )));
            }
            self.positions.push(placed);
        }
        Ok(first as u32)
    }

    fn add_elements(
        &mut self,
        primitive: &Primitive,
        first: u32,
        vertex_count: usize,
        transform: DAffine3,
    ) -> Result<(), Fault> {
        let indices = primitive.indices.map(|number| self.data.elements(number, Kind::Scalar)).transpose()?;
        let count = indices.as_ref().map_or(vertex_count, |indices| indices.count);
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        self.count(count, if mode > TRIANGLES { STRIP_CORNER_BYTES } else { CORNER_BYTES })?;
        let corner = |at: usize| -> Result<u32, Fault> {
            let index = match &indices {
                Some(indices) => indices.index(at)?,
                None => at as u32,
            };
            if index as usize >= vertex_count {
                return Err(Fault::format(format!(
                    "corner {at} is vertex {index}, but vertices are numbered from 0 to {}; export the file again",
                    vertex_count as i64 - 1
                )));
            }
            Ok(first + index)
        };
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        let faces = &mut self.mesh.faces;
        let mut triangle = |a: u32, b: u32, c: u32| faces.push(&if is_mirrored { [b, a, c] } else { [a, b, c] });
        match mode {
            TRIANGLES => {
                for start in (0..count / 3).map(|number| 3 * number) {
                    triangle(corner(start)?, corner(start + 1)?, corner(start + 2)?);
                }
            }
            TRIANGLE_STRIP => {
                for start in 0..count.saturating_sub(2) {
                    let (a, b, c) = (corner(start)?, corner(start + 1)?, corner(start + 2)?);
                    if start % 2 == 0 { triangle(a, b, c) } else { triangle(b, a, c) }
                }
            }
            TRIANGLE_FAN => {
                for start in 1..count.saturating_sub(1) {
                    triangle(corner(0)?, corner(start)?, corner(start + 1)?);
                }
            }
            0..TRIANGLES => {
                for at in 0..count {
                    let vertex = corner(at)?;
                    self.mesh.loose.push(vertex);
                }
            }
            mode => {
                return Err(Fault::format(format!("has the unknown mode {mode}; export the file again")));
            }
        }
        if self.mesh.faces.corners.len() > u32::MAX as usize || self.mesh.loose.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        Ok(())
    }

    fn finish(self) -> Result<Mesh, Fault> {
        let Self { data, positions, mut mesh, shown, object_count, moving_count, .. } = self;
        let document = data.document;
        if positions.is_empty() {
            let nodes = document.nodes.len();
            let meshes = document.meshes.len();
            return Err(Fault::format(format!(
                "the scene shows no vertices ({nodes} nodes, {meshes} meshes); a hull needs at least one point: were the objects hidden on export?"
            )));
        }
        mesh.positions = Positions::Double(positions);
        // Exporters write a vertex once for each normal or texture coordinate that it has.
        mesh.may_share_vertices = false;
        let unseen = shown.iter().filter(|&&is| !is).count();
        if unseen > 0 {
            mesh.notes.push(format!("meshes that the scene does not show, left out: {unseen}"));
        }
        let repeats = object_count - (shown.len() - unseen);
        if repeats > 0 {
            mesh.notes.push(format!("meshes shown more than once, each time taken: {repeats}"));
        }
        if moving_count > 0 {
            mesh.notes.push(format!("skins and morph targets, left at rest: {moving_count}"));
        }
        if let Some(name) = document.extensions_used.iter().find(|name| *name == "EXT_mesh_gpu_instancing") {
            mesh.warnings.push(format!("{name} is not read: only one instance counts; {}", remedy(name)));
        }
        Ok(mesh)
    }
}

/// Roots of the default scene.
fn roots(document: &Document) -> Result<Vec<u32>, Fault> {
    let number = document.scene.unwrap_or(0);
    match document.scenes.get(number as usize) {
        Some(scene) => Ok(scene.nodes.to_vec()),
        None if document.scene.is_some() => {
            let count = document.scenes.len();
            Err(Fault::format(format!("scene {number} does not exist: there are {count}; export the file again")))
        }
        None => {
            let mut has_parent = vec![false; document.nodes.len()];
            for &child in document.nodes.iter().flat_map(|node| node.children.iter()) {
                if let Some(has) = has_parent.get_mut(child as usize) {
                    *has = true;
                }
            }
            Ok((0..).zip(has_parent).filter(|(_, has_parent)| !has_parent).map(|(node, _)| node).collect())
        }
    }
}

/// A node's transform in its parent.
fn local(node: &Node) -> Result<DAffine3, String> {
    let transform = match &node.matrix {
        Some(matrix) => {
            let matrix = DMat4::from_cols_array(matrix);
            if matrix.row(3) != DVec4::W {
                return Err(
                    "has a matrix whose last row is not 0 0 0 1; expected translation, rotation and scale".to_owned()
                );
            }
            DAffine3::from_mat4(matrix)
        }
        None => {
            let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
            let translation = DVec3::from_array(node.translation.unwrap_or_default());
            let rotation = match node.rotation {
                None => DQuat::IDENTITY,
                // As it is written it has seven digits; without this, scenes would shrink with their depth.
                Some(rotation) => DQuat::from_array(rotation).normalize(),
            };
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    if transform.is_finite() { Ok(transform) } else { Err("has a transform that is not finite; mend it".to_owned()) }
}

/// A name in a message.
fn quoted(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!(" ({})", excerpt(name)))
}
