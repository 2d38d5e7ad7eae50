//! glTF 2.0: the nodes, meshes and primitives of a scene, read into a source mesh.
//!
//! # Primitive restart
//! In strips, fans and connected lines, the largest index of its type (255, 65,535 or
//! 4,294,967,295) starts a new primitive for most viewers: in WebGL 2, Direct3D and Metal. glTF 2.0
//! forbids that index, and `KHR_mesh_primitive_restart` allows it again. Here it restarts a
//! primitive if the extension is used, or if no vertex has that index. Otherwise readers disagree,
//! and the file is rejected. In lists, it is an index like any other.

mod colliders;
mod findings;

use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::accessor::{AccessorReader, Data};
use super::document::{Document, Draco, Kind, MeshRecord, Node, Primitive};
use super::draco::{self, DracoFault, DracoMesh};
use super::extensions::{INSTANCING, allows_restart, remedy};
use super::physics::{self, Shapes};
use crate::fault::{Fault, counted, excerpt};
use crate::limits::Limits;
use crate::materials::Materials;
use crate::mesh::{Polygons, Positions, SourceMesh};
use findings::Findings;

/// Primitive modes, as OpenGL numbers them. Modes below `TRIANGLES` are points and lines.
const LINE_LOOP: u32 = 2;
const LINE_STRIP: u32 = 3;
const TRIANGLES: u32 = 4;
const TRIANGLE_STRIP: u32 = 5;
const TRIANGLE_FAN: u32 = 6;

/// Bytes of the file that a vertex, a corner, and a corner of a strip or fan should have taken: at
/// least their size as shorts, and enough for the memory that they take.
const VERTEX_BYTES: usize = 8;
const CORNER_BYTES: usize = 2;
const STRIP_CORNER_BYTES: usize = 4;

/// Bytes of the file that a primitive should have taken: at least `{},`.
const PRIMITIVE_BYTES: usize = 3;

pub struct SceneReader<'a> {
    data: Data<'a>,
    limits: &'a Limits,
    positions: Vec<[f64; 3]>,
    mesh: SourceMesh,
    shapes: Option<Rc<Shapes>>,
    findings: Findings,
    is_shown: Vec<bool>,
    /// Bytes of the file that no vertex, corner, primitive or name has claimed yet.
    unclaimed_bytes: usize,
    /// Number of vertices, corners, primitives and bytes of names beyond those spelled in the file.
    repeated_count: usize,
    object_count: usize,
    /// Node of each object, and its transform to the scene.
    places: Vec<(u32, DAffine3)>,
    deformed_count: usize,
    /// Decoded primitives, by buffer view and by the id of their positions.
    decoded: HashMap<(u32, u32), Rc<DracoMesh>>,
    decoded_bytes: usize,
    byte_count: usize,
    allows_restart: bool,
    restart_count: usize,
    /// Number of accessors whose count differs from the count of their compressed data.
    miscounts: usize,
    /// The first of them, its count, and the count of its data.
    first_miscount: Option<(u32, u64, usize)>,
}

impl<'a> SceneReader<'a> {
    /// `byte_count` is the size of the file with its buffers. Decoded views count as
    /// `repeated_count` against the limit on repetition. With `shapes`, colliders are objects too.
    pub fn new(
        data: Data<'a>,
        byte_count: usize,
        repeated_count: usize,
        shapes: Option<Shapes>,
        limits: &'a Limits,
    ) -> Self {
        Self {
            limits,
            shapes: shapes.map(Rc::new),
            findings: Findings::default(),
            positions: Vec::new(),
            mesh: SourceMesh {
                materials: Materials::with_names(data.document.material_names()),
                ..SourceMesh::new(Positions::Double(Vec::new()), Polygons::default())
            },
            is_shown: vec![false; data.document.meshes.len()],
            unclaimed_bytes: byte_count,
            repeated_count,
            object_count: 0,
            places: Vec::new(),
            deformed_count: 0,
            decoded: HashMap::new(),
            decoded_bytes: 0,
            byte_count,
            allows_restart: data.document.extensions_used.iter().any(|name| allows_restart(name)),
            restart_count: 0,
            miscounts: 0,
            first_miscount: None,
            data,
        }
    }

    /// The mesh, and the node of each object with its transform. Complexity: O(bytes + repetition).
    pub fn read(mut self) -> Result<(SourceMesh, Vec<(u32, DAffine3)>), Fault> {
        if self.data.document.nodes.is_empty() {
            // A library of meshes without a scene.
            for (index, mesh) in self.data.document.meshes.iter().enumerate() {
                let name = mesh.name.as_deref().unwrap_or_default();
                self.add_mesh(name, "", index as u32, DAffine3::IDENTITY)?;
            }
        } else {
            self.add_nodes()?;
        }
        let places = std::mem::take(&mut self.places);
        Ok((self.finish()?, places))
    }

    /// Visits the nodes depth first. Not recursive: a chain of nodes can be as long as the list.
    fn add_nodes(&mut self) -> Result<(), Fault> {
        let document = self.data.document;
        let nodes = &document.nodes;
        let mut is_visited = vec![false; nodes.len()];
        // With the object of the nearest node above that has a mesh.
        let mut stack: Vec<(u32, DAffine3, Option<usize>)> =
            roots(document)?.into_iter().rev().map(|root| (root, DAffine3::IDENTITY, None)).collect();
        while let Some((index, parent, mut nearest)) = stack.pop() {
            let (Some(node), Some(is_visited)) = (nodes.get(index as usize), is_visited.get_mut(index as usize)) else {
                let nodes = counted(nodes.len(), "node", "nodes");
                return Err(Fault::format(format!(
                    "node index {index} is out of range (the file has {nodes}); export the file again"
                )));
            };
            let label = || format!("node {index}{}", quoted(node.name.as_deref()));
            if std::mem::replace(is_visited, true) {
                return Err(Fault::format(format!(
                    "{} has two parents or is its own ancestor; expected a tree: export the file again",
                    label()
                )));
            }
            let transform = parent * local(node).map_err(|text| Fault::format(format!("{} {text}", label())))?;
            if let Some(mesh) = node.mesh {
                let record = document.meshes.get(mesh as usize);
                let name = node.name.as_deref().filter(|name| !name.is_empty());
                let name = name.or(record.and_then(|record| record.name.as_deref())).unwrap_or_default();
                self.deformed_count += usize::from(node.skin.is_some());
                self.add_mesh(name, &label(), mesh, transform)?;
                self.places.push((index, transform));
                nearest = self.mesh.objects.len().checked_sub(1);
            }
            self.add_collider(node, &label(), transform, nearest)?;
            stack.extend(node.children.iter().rev().map(|&child| (child, transform, nearest)));
        }
        Ok(())
    }

    /// Adds a mesh as an object. `label` names its node in messages; it is empty if there is none.
    fn add_mesh(&mut self, name: &str, label: &str, mesh_index: u32, transform: DAffine3) -> Result<(), Fault> {
        let document = self.data.document;
        let at = mesh_index as usize;
        let (Some(record), Some(is_shown)) = (document.meshes.get(at), self.is_shown.get_mut(at)) else {
            return Err(Fault::format(format!(
                "{label} has the mesh index {mesh_index}, which is out of range (the file has {}); export the file again",
                counted(document.meshes.len(), "mesh", "meshes")
            )));
        };
        *is_shown = true;
        // Many nodes may repeat one mesh with a long name and many short primitives.
        self.claim(name.len(), 1)?;
        self.begin_object(name);
        self.add_primitives(record, label, mesh_index, transform)
    }

    fn add_primitives(
        &mut self,
        record: &MeshRecord,
        label: &str,
        mesh_index: u32,
        transform: DAffine3,
    ) -> Result<(), Fault> {
        self.claim(record.primitives.len(), PRIMITIVE_BYTES)?;
        // First vertex and vertex count of each accessor that this node has read.
        let mut known: HashMap<u32, (u32, usize)> = HashMap::new();
        for primitive in record.primitives.iter() {
            self.deformed_count += usize::from(primitive.targets.is_some());
            // By the specification, a primitive without positions is not drawn.
            let Some(accessor) = primitive.attributes.position else {
                continue;
            };
            let within = |fault: Fault| match fault {
                Fault::Format(text) if label.is_empty() => Fault::Format(format!("mesh {mesh_index}: {text}")),
                Fault::Format(text) => Fault::Format(format!("{label}, mesh {mesh_index}: {text}")),
                other => other,
            };
            self.mesh.materials.begin_index(self.mesh.faces.len(), primitive.material_index());
            if let Some(draco) = self.only_compressed(primitive, accessor).map_err(within)? {
                self.add_compressed(draco, primitive, accessor, transform).map_err(within)?;
                continue;
            }
            let vertices = match known.get(&accessor) {
                Some(&vertices) => vertices,
                None => self.add_vertices(accessor, transform).map_err(within)?,
            };
            known.insert(accessor, vertices);
            self.add_elements(primitive, vertices, transform).map_err(within)?;
        }
        self.mesh.materials.begin(self.mesh.faces.len(), 0);
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
        // The limit counts objects, and here the first one is an object like the others.
        if self.mesh.objects.len() >= self.limits.objects {
            self.mesh.has_too_many_objects = true;
            return;
        }
        self.mesh.begin_object(name.to_owned(), self.limits.objects);
        if let Some(object) = self.mesh.objects.last_mut() {
            object.first_vertex = self.positions.len() as u32;
        }
    }

    /// Accounts for `count` items of at least `bytes_each` bytes. Instances, shared accessors, and
    /// accessors without bytes claim more than the file has.
    fn claim(&mut self, count: usize, bytes_each: usize) -> Result<(), Fault> {
        let spelt_out = count.min(self.unclaimed_bytes / bytes_each);
        self.unclaimed_bytes -= spelt_out * bytes_each;
        self.repeated_count = self.repeated_count.saturating_add(count - spelt_out);
        if self.repeated_count > self.limits.repeated_vertices {
            return Err(self.limits.too_much_repetition());
        }
        Ok(())
    }

    /// Adds the vertices of an accessor, and returns the index of the first one and their count.
    fn add_vertices(&mut self, accessor: u32, transform: DAffine3) -> Result<(u32, usize), Fault> {
        let elements = self.data.accessor(accessor, Kind::Vec3)?;
        self.place(elements.count, |at| elements.position(at), transform)
    }

    fn only_compressed(&self, primitive: &Primitive, accessor: u32) -> Result<Option<Draco>, Fault> {
        let Some(draco) = primitive.extensions.draco else {
            return Ok(None);
        };
        let has_no_bytes = self.data.accessor(accessor, Kind::Vec3)?.has_no_bytes()
            || match primitive.indices {
                Some(indices) => self.data.accessor(indices, Kind::Scalar)?.has_no_bytes(),
                None => false,
            };
        Ok(has_no_bytes.then_some(draco))
    }

    fn add_compressed(
        &mut self,
        draco: Draco,
        primitive: &Primitive,
        accessor: u32,
        transform: DAffine3,
    ) -> Result<(), Fault> {
        let elements = self.data.accessor(accessor, Kind::Vec3)?;
        let view = draco.buffer_view;
        let fault = |text: String| {
            Fault::format(format!("the mesh compressed by KHR_draco_mesh_compression in buffer view {view} {text}"))
        };
        let Some(position) = draco.attributes.position else {
            return Err(fault("has no attribute POSITION; export the file again".to_owned()));
        };
        let mesh = match self.decoded.get(&(view, position)) {
            Some(mesh) => mesh.clone(),
            None => {
                let bytes = self.data.view_bytes(view).map_err(fault)?;
                // Views may overlap, so that few bytes would be decoded many times.
                self.decoded_bytes += bytes.len();
                if self.decoded_bytes > self.byte_count {
                    return Err(fault("shares its bytes with another one; export the file again".to_owned()));
                }
                let limits = self.limits;
                let rejected = |error| match error {
                    DracoFault::TooLarge => limits.too_much_repetition(),
                    DracoFault::Damaged(text) => fault(format!("is damaged ({text}); export the file again")),
                };
                let claim = draco::claim(bytes).map_err(rejected)?;
                self.check_claims(claim)?;
                let mesh = Rc::new(draco::decode(bytes, position, claim).map_err(rejected)?);
                self.check_count(accessor, mesh.positions.len());
                // The data is a list of triangles, but the accessor may be of a strip.
                if let (Some(indices), None | Some(TRIANGLES)) = (primitive.indices, primitive.mode) {
                    self.check_count(indices, 3 * mesh.triangles.len());
                }
                self.decoded.insert((view, position), mesh.clone());
                mesh
            }
        };
        self.claim(3 * mesh.triangles.len(), CORNER_BYTES)?;
        let stored = |at: usize| mesh.positions.get(at).copied().unwrap_or_default().map(f64::from);
        let (first, _) = self.place(mesh.positions.len(), |at| elements.normalized(stored(at)), transform)?;
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [first + a, first + b, first + c];
            self.mesh.faces.push(&if is_mirrored { [b, a, c] } else { [a, b, c] });
        }
        if self.mesh.faces.corners.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        Ok(())
    }

    /// Rejects compressed data that [`claim`](Self::claim) would reject once it was decoded.
    fn check_claims(&mut self, of: draco::Claim) -> Result<(), Fault> {
        let before = (self.unclaimed_bytes, self.repeated_count);
        self.claim(of.triangles.saturating_mul(3), CORNER_BYTES)?;
        self.claim(of.vertices, VERTEX_BYTES)?;
        (self.unclaimed_bytes, self.repeated_count) = before;
        Ok(())
    }

    fn check_count(&mut self, accessor: u32, found: usize) {
        let declared = self.data.document.accessors.get(accessor as usize).map_or(0, |accessor| accessor.count);
        if declared != found as u64 {
            self.miscounts += 1;
            self.first_miscount.get_or_insert((accessor, declared, found));
        }
    }

    /// Adds `vertex_count` vertices, and returns the index of the first one and their count.
    fn place(
        &mut self,
        vertex_count: usize,
        position: impl Fn(usize) -> [f64; 3],
        transform: DAffine3,
    ) -> Result<(u32, usize), Fault> {
        let first = self.positions.len();
        if first + vertex_count > (u32::MAX - 1) as usize {
            return Err(Fault::TooManyVertices);
        }
        self.claim(vertex_count, VERTEX_BYTES)?;
        self.positions.reserve(vertex_count);
        for at in 0..vertex_count {
            let position = position(at);
            let placed = if transform == DAffine3::IDENTITY {
                position
            } else {
                transform.transform_point3(DVec3::from_array(position)).to_array()
            };
            if !placed.iter().all(|x| x.is_finite()) {
                return Err(Fault::format(format!(
                    "vertex {at} is at {position:?}, and at {placed:?} in the scene, but a hull requires finite points: repair the mesh in its editor"
                )));
            }
            self.positions.push(placed);
        }
        Ok((first as u32, vertex_count))
    }

    fn add_elements(
        &mut self,
        primitive: &Primitive,
        (first, vertex_count): (u32, usize),
        transform: DAffine3,
    ) -> Result<(), Fault> {
        let indices = primitive.indices.map(|index| self.data.accessor(index, Kind::Scalar)).transpose()?;
        let count = indices.as_ref().map_or(vertex_count, |indices| indices.count);
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        self.claim(count, if mode > TRIANGLES { STRIP_CORNER_BYTES } else { CORNER_BYTES })?;
        let runs = self.runs(mode, indices.as_ref(), count, vertex_count)?;
        let corner = |at| corner(indices.as_ref(), at, first, vertex_count);
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        let faces = &mut self.mesh.faces;
        let mut triangle = |a: u32, b: u32, c: u32| faces.push(&if is_mirrored { [b, a, c] } else { [a, b, c] });
        match mode {
            TRIANGLES => {
                for start in (0..count / 3).map(|index| 3 * index) {
                    triangle(corner(start)?, corner(start + 1)?, corner(start + 2)?);
                }
            }
            TRIANGLE_STRIP => {
                for run in runs {
                    for (step, start) in (run.start..run.end.saturating_sub(2)).enumerate() {
                        let (a, b, c) = (corner(start)?, corner(start + 1)?, corner(start + 2)?);
                        if step % 2 == 0 { triangle(a, b, c) } else { triangle(b, a, c) }
                    }
                }
            }
            TRIANGLE_FAN => {
                for run in runs {
                    for start in run.start + 1..run.end.saturating_sub(1) {
                        triangle(corner(run.start)?, corner(start)?, corner(start + 1)?);
                    }
                }
            }
            0..TRIANGLES => {
                for at in runs.into_iter().flatten() {
                    self.mesh.loose.push(corner(at)?);
                }
            }
            mode => {
                return Err(Fault::format(format!("a primitive has the unknown mode {mode}; export the file again")));
            }
        }
        if self.mesh.faces.corners.len() > u32::MAX as usize || self.mesh.loose.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        Ok(())
    }

    /// Ranges of corners that are not interrupted by a restart. Most primitives have one.
    fn runs(
        &mut self,
        mode: u32,
        indices: Option<&AccessorReader>,
        count: usize,
        vertex_count: usize,
    ) -> Result<Vec<Range<usize>>, Fault> {
        let is_connected = matches!(mode, LINE_LOOP | LINE_STRIP | TRIANGLE_STRIP | TRIANGLE_FAN);
        let Some(indices) = indices.filter(|_| is_connected) else {
            return Ok(std::iter::once(0..count).collect());
        };
        let restart = indices.restart_index();
        let (mut runs, mut start) = (Vec::new(), 0);
        for at in (0..count).filter(|&at| indices.index(at) == restart) {
            if (restart as usize) < vertex_count && !self.allows_restart {
                return Err(Fault::format(format!(
                    "corner {at} has the index {restart}: some readers take it for vertex {restart}, others start a new strip; export the file again with triangles, or with larger indices"
                )));
            }
            self.restart_count += 1;
            runs.push(start..at);
            start = at + 1;
        }
        runs.push(start..count);
        Ok(runs)
    }

    fn finish(self) -> Result<SourceMesh, Fault> {
        let (miscounts, first_miscount) = (self.miscounts, self.first_miscount);
        let reads_colliders = self.shapes.is_some();
        let Self { data, positions, mut mesh, is_shown, object_count, deformed_count, restart_count, findings, .. } =
            self;
        let document = data.document;
        if positions.is_empty() {
            let meshes = counted(document.meshes.len(), "mesh", "meshes");
            let reason = if document.meshes.is_empty() && (reads_colliders || !physics::is_present(document)) {
                "the file has no meshes: export objects with a mesh".to_owned()
            } else if !reads_colliders && physics::is_present(document) {
                "the scene shows no mesh, but has colliders: add --split auto to bake those".to_owned()
            } else if !is_shown.contains(&true) {
                format!(
                    "the scene shows no mesh (the file has {meshes}): check that the objects were visible on export"
                )
            } else {
                format!("the scene shows no vertices (the file has {meshes}): check that the meshes are not empty")
            };
            return Err(Fault::format(reason));
        }
        mesh.positions = Positions::Double(positions);
        // Exporters write a vertex once for each normal or texture coordinate that it has.
        mesh.may_share_vertices = false;
        let unseen = (0..).zip(&is_shown).filter(|&(_, &is_shown)| !is_shown);
        let unused = unseen.clone().filter(|(mesh, _)| !findings.meshes.contains(mesh)).count();
        let unseen = unseen.count();
        if unused > 0 {
            mesh.notes.push(format!("meshes outside the scene, left out: {unused}"));
        }
        let repeats = object_count - findings.count - (is_shown.len() - unseen);
        if repeats > 0 {
            mesh.notes.push(format!("repeated instances of a mesh, all included: {repeats}"));
        }
        if deformed_count > 0 {
            mesh.notes.push(format!("skins and morph targets, left at rest: {deformed_count}"));
        }
        mesh.notes.append(&mut findings.notes());
        mesh.warnings.append(&mut findings.warnings());
        if restart_count > 0 {
            mesh.notes.push(format!("primitives divided by the primitive restart index: {restart_count}"));
        }
        if let Some((accessor, declared, found)) = first_miscount {
            let more = if miscounts > 1 { format!(", and {} more like it", miscounts - 1) } else { String::new() };
            mesh.warnings.push(format!(
                "accessor {accessor} declares {}, but its compressed data has {found}{more}; all data is used: if the hull is wrong, export the file again",
                counted(declared, "element", "elements")
            ));
        }
        if let Some(name) = document.extensions_used.iter().find(|name| *name == INSTANCING) {
            mesh.warnings
                .push(format!("{name} is not supported, so only one instance of the mesh is baked; {}", remedy(name)));
        }
        Ok(mesh)
    }
}

fn corner(indices: Option<&AccessorReader>, at: usize, first: u32, vertex_count: usize) -> Result<u32, Fault> {
    let index = match indices {
        Some(indices) => indices.index(at),
        None => at as u32,
    };
    if index as usize >= vertex_count {
        return Err(Fault::format(format!(
            "corner {at} has the vertex index {index}, which is out of range (the primitive has {}); export the file again",
            counted(vertex_count, "vertex", "vertices")
        )));
    }
    Ok(first + index)
}

/// As far as the references are valid.
pub fn shown_meshes(document: &Document) -> Vec<bool> {
    let mut is_shown = vec![document.nodes.is_empty(); document.meshes.len()];
    let mut is_visited = vec![false; document.nodes.len()];
    let mut stack = roots(document).unwrap_or_default();
    while let Some(index) = stack.pop() {
        let (Some(node), Some(is_visited)) = (document.nodes.get(index as usize), is_visited.get_mut(index as usize))
        else {
            continue;
        };
        if std::mem::replace(is_visited, true) {
            continue;
        }
        if let Some(is_shown) = node.mesh.and_then(|mesh| is_shown.get_mut(mesh as usize)) {
            *is_shown = true;
        }
        stack.extend(node.children.iter());
    }
    is_shown
}

fn roots(document: &Document) -> Result<Vec<u32>, Fault> {
    let index = document.scene.unwrap_or(0);
    match document.scenes.get(index as usize) {
        Some(scene) => Ok(scene.nodes.to_vec()),
        None if document.scene.is_some() => {
            let scenes = counted(document.scenes.len(), "scene", "scenes");
            Err(Fault::format(format!(
                "scene index {index} is out of range (the file has {scenes}); export the file again"
            )))
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

/// Transform of a node, from its own frame to its parent's.
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
                // Files give about seven digits. Without this, parts would shrink with their depth
                // in the tree.
                Some(rotation) => DQuat::from_array(rotation).normalize(),
            };
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    if transform.is_finite() { Ok(transform) } else { Err("has a transform that is not finite: correct it".to_owned()) }
}

fn quoted(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!(" ({})", excerpt(name)))
}
