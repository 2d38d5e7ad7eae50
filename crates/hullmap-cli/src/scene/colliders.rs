//! Hulls as colliders in a glTF file, by `KHR_physics_rigid_bodies` and `OMI_physics_body`.
//!
//! 1. Each hull becomes a mesh, with its positions and triangles at the end of the file's buffer,
//!    or in a buffer of its own if the file is text or has no such buffer.
//! 2. A new node below the node of its object has the collider. So the hull moves with the object,
//!    and is not drawn: no node of the scene has its mesh, except with `is_visible`.
//! 3. The node of the object has the mass, the centre of mass and the inertia.
//!
//! The hull keeps its positions, in the frame of the pack, if the node of its object is not
//! distorted: the new node then has the transform from that frame. Otherwise, since a node may not
//! shear, the positions are transformed and rounded.
//!
//! A primitive that may replace the hull is written as a shape of `KHR_implicit_shapes` or
//! `OMI_physics_shape`, with the axis y, unless hulls are drawn or the node is distorted.
//!
//! # Reference
//! Khronos, "KHR_physics_rigid_bodies" and "KHR_implicit_shapes", the drafts of [`Draft`]; Open
//! Metaverse Interoperability Group, "OMI_physics_body" and "OMI_physics_shape", commit 89d328b of
//! August 2026.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use clap::ValueEnum;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use hullmap::PrimitiveKind;
use serde_json::json;
use serde_json::value::RawValue;

use super::container::GltfFile;
use super::edit::{Edits, Members, elements, members};
use hullmap_pipeline::mesh_file::body::{Body, BodyPrimitive};
use hullmap_pipeline::mesh_file::glb::bounds;
use hullmap_pipeline::mesh_file::seal::{SEAL, sealed};

const KHR_BODY: &str = "KHR_physics_rigid_bodies";
const OMI_BODY: &str = "OMI_physics_body";
const OMI_SHAPE: &str = "OMI_physics_shape";
const KHR_SHAPE: &str = "KHR_implicit_shapes";

/// Maximum difference of a matrix from a rotation with a uniform scale, relative to the scale.
/// Files have about seven digits, and readers accept a few thousandths.
const DISTORTION: f64 = 1e-5;

const U32: u32 = 5125;
const F32: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Draft of `KHR_physics_rigid_bodies`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Draft {
    /// Commit ac5c413 of October 2025: a collider names a node that has the mesh.
    #[default]
    #[value(name = "2025-10")]
    October2025,
    /// Draft of June 2026: a collider names the mesh. fastgltf reads it since August 2026.
    #[value(name = "2026-06")]
    June2026,
}

#[derive(Clone, Copy, Debug)]
pub struct Form {
    pub khr: Option<Draft>,
    /// Whether `OMI_physics_body` is written.
    pub is_omi: bool,
    pub is_visible: bool,
    /// Whether positions are in the frame of the node, so that the new node needs no transform.
    pub is_in_node: bool,
}

#[derive(Debug)]
pub struct Collider {
    /// The hull, in the frame of its pack.
    pub body: Body,
    /// Name of its mesh; `None`: the name of the hull.
    pub mesh_name: Option<String>,
    /// Node below which it is added; `None`: at the root of the scene.
    pub node: Option<usize>,
    pub pack_in_node: DAffine3,
}

#[derive(Debug)]
pub struct Motion {
    pub node: usize,
    /// In kilograms.
    pub mass: f64,
    /// Centre of mass in the frame of the node.
    pub center: DVec3,
    /// Principal moments of inertia, in kg·m².
    pub moments: DVec3,
    pub orientation: DQuat,
}

/// The file with colliders and masses. Fails if it is not a glTF document, has colliders already,
/// or a number does not fit into the 32 bits of glTF. Complexity: O(bytes).
pub fn add(file: &GltfFile, colliders: &[Collider], motions: &[Motion], form: &Form) -> Result<Vec<u8>, String> {
    let root = members(&file.text)?;
    let mut writer = Writer::new(&root, &file.text)?;
    writer.check_no_colliders(form)?;
    let mut buffer = writer.buffer(file)?;
    for collider in colliders {
        writer.add_collider(collider, form, &mut buffer)?;
    }
    for motion in motions {
        writer.add_motion(motion, form)?;
    }
    let added = writer.add_buffer(buffer)?;
    let text = writer.finish(form)?;
    file.with(text, &added).map(sealed)
}

fn is_in_range(number: f64) -> bool {
    number.abs() <= f64::from(f32::MAX)
}

fn check_range(collider: &Collider) -> Result<(), String> {
    let place =
        |position: &[f32; 3]| collider.pack_in_node.transform_point3(DVec3::from_array(position.map(f64::from)));
    let placed = collider.body.positions.iter().flat_map(|position| place(position).to_array());
    let Some(found) = placed.chain(collider.pack_in_node.to_cols_array()).find(|number| !is_in_range(*number)) else {
        return Ok(());
    };
    let node = collider.node.map_or_else(|| "the scene".to_owned(), |node| format!("node {node}"));
    Err(format!(
        "hull {}: a coordinate in {node} is {found:e}, too large for 32 bits; the node is scaled by too little: apply \
         its scale to its mesh",
        collider.body.name
    ))
}

struct Buffer {
    index: usize,
    base: usize,
    is_chunk: bool,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy)]
enum List {
    Nodes,
    Meshes,
    Accessors,
    Views,
    Buffers,
}

const LISTS: [&str; 5] = ["nodes", "meshes", "accessors", "bufferViews", "buffers"];

struct Writer<'a> {
    text: &'a str,
    root: &'a Members<'a>,
    edits: Edits<'a>,
    old: [Vec<&'a RawValue>; 5],
    new: [Vec<String>; 5],
    children: BTreeMap<usize, Vec<usize>>,
    roots: Vec<usize>,
    extensions: BTreeMap<usize, Vec<(&'static str, String)>>,
    /// For each list of shapes, the number that the file had, and the new ones.
    shapes: [(usize, Vec<String>); 2],
}

const SHAPE_LISTS: [&str; 2] = [KHR_SHAPE, OMI_SHAPE];
const KHR_LIST: usize = 0;
const OMI_LIST: usize = 1;

impl<'a> Writer<'a> {
    fn new(root: &'a Members<'a>, text: &'a str) -> Result<Self, String> {
        let mut old: [Vec<&RawValue>; 5] = Default::default();
        for (list, name) in old.iter_mut().zip(LISTS) {
            if let Some(raw) = root.get(name) {
                *list = elements(raw.get()).map_err(|error| format!("{name}: {error}"))?;
            }
        }
        let mut shapes: [(usize, Vec<String>); 2] = Default::default();
        for ((count, _), name) in shapes.iter_mut().zip(SHAPE_LISTS) {
            if let Some(list) = shapes_of(root, name)? {
                *count = elements(list.get())?.len();
            }
        }
        let (edits, new) = (Edits::new(text), Default::default());
        let (children, roots, extensions) = (BTreeMap::new(), Vec::new(), BTreeMap::new());
        Ok(Self { text, root, edits, old, new, children, roots, extensions, shapes })
    }

    fn check_no_colliders(&self, form: &Form) -> Result<(), String> {
        for (index, node) in self.old[List::Nodes as usize].iter().enumerate() {
            let fault = |error: String| format!("node {index}: {error}");
            let Some(extensions) = members(node.get()).map_err(fault)?.get("extensions").copied() else {
                continue;
            };
            let extensions = members(extensions.get()).map_err(|error| fault(format!("extensions: {error}")))?;
            for (name, is_written) in [(KHR_BODY, form.khr.is_some()), (OMI_BODY, form.is_omi)] {
                if is_written && extensions.contains_key(name) {
                    return Err(format!("node {index} already has {name}; export into the file without colliders"));
                }
            }
        }
        Ok(())
    }

    /// Place of new bytes: the end of the BIN chunk, if it is or may become the first buffer.
    fn buffer(&self, file: &GltfFile) -> Result<Buffer, String> {
        let buffers = &self.old[List::Buffers as usize];
        let is_chunk = match buffers.first() {
            Some(first) => file.buffer().is_some() && !members(first.get())?.contains_key("uri"),
            None => file.is_glb(),
        };
        let base = if is_chunk { file.buffer().map_or(0, <[u8]>::len) } else { 0 };
        let index = if is_chunk { 0 } else { buffers.len() };
        Ok(Buffer { index, base, is_chunk, bytes: Vec::new() })
    }

    fn push(&mut self, list: List, element: String) -> usize {
        let (old, new) = (self.old[list as usize].len(), &mut self.new[list as usize]);
        new.push(element);
        old + new.len() - 1
    }

    fn add_view(&mut self, buffer: &mut Buffer, numbers: impl Iterator<Item = [u8; 4]>, target: u32) -> usize {
        let start = buffer.bytes.len();
        buffer.bytes.extend(numbers.flatten());
        let view = json!({
            "buffer": buffer.index, "byteOffset": buffer.base + start, "byteLength": buffer.bytes.len() - start,
            "target": target,
        });
        self.push(List::Views, view.to_string())
    }

    fn add_collider(&mut self, collider: &Collider, form: &Form, buffer: &mut Buffer) -> Result<(), String> {
        let body = &collider.body;
        check_range(collider)?;
        let keeps_positions = !form.is_in_node && is_similarity(&collider.pack_in_node);
        if let Some(primitive) = body.primitive.filter(|_| keeps_positions && !form.is_visible) {
            self.add_primitive(collider, &primitive, form);
            return Ok(());
        }
        let positions: Vec<[f32; 3]> = if keeps_positions {
            body.positions.clone()
        } else {
            let place = |position: &[f32; 3]| {
                let position = DVec3::from_array(position.map(f64::from));
                collider.pack_in_node.transform_point3(position).to_array().map(|x| x as f32)
            };
            body.positions.iter().map(place).collect()
        };
        let index_count = 3 * body.triangles().count();
        let vertices = self.add_view(buffer, positions.iter().flatten().map(|x| x.to_le_bytes()), VERTICES);
        // A frame that mirrors would turn the triangles inside out.
        let is_mirrored = !keeps_positions && collider.pack_in_node.matrix3.determinant() < 0.0;
        let turn = |[a, b, c]: [u32; 3]| if is_mirrored { [b, a, c] } else { [a, b, c] };
        let indices = self.add_view(buffer, body.triangles().flat_map(turn).map(u32::to_le_bytes), INDICES);
        let [low, high] = bounds(&positions);
        let vertices = json!({
            "bufferView": vertices, "componentType": F32, "count": positions.len(), "type": "VEC3",
            "min": low, "max": high,
        });
        let indices = json!({ "bufferView": indices, "componentType": U32, "count": index_count, "type": "SCALAR" });
        let vertices = self.push(List::Accessors, vertices.to_string());
        let indices = self.push(List::Accessors, indices.to_string());
        let primitive = json!({ "attributes": { "POSITION": vertices }, "indices": indices });
        let mesh_name = collider.mesh_name.as_ref().unwrap_or(&body.name);
        let mesh = self.push(List::Meshes, json!({ "name": mesh_name, "primitives": [primitive] }).to_string());

        let mut extensions = serde_json::Map::new();
        if let Some(draft) = form.khr {
            let geometry = match draft {
                Draft::October2025 => {
                    // Outside of the scene, so that it is not drawn.
                    let holder = json!({ "name": format!("{}_mesh", body.name), "mesh": mesh });
                    json!({ "node": self.push(List::Nodes, holder.to_string()), "convexHull": true })
                }
                Draft::June2026 => json!({ "mesh": mesh, "convexHull": true }),
            };
            extensions.insert(KHR_BODY.to_owned(), json!({ "collider": { "geometry": geometry } }));
        }
        if form.is_omi {
            let shape = self.add_shape(OMI_LIST, &json!({ "type": "convex", "convex": { "mesh": mesh } }));
            extensions.insert(OMI_BODY.to_owned(), json!({ "collider": { "shape": shape } }));
        }
        let mut node = json!({ "name": body.name });
        if !extensions.is_empty() {
            node["extensions"] = extensions.into();
        }
        if form.is_visible {
            node["mesh"] = mesh.into();
        }
        if keeps_positions && collider.pack_in_node != DAffine3::IDENTITY {
            node["matrix"] = json!(DMat4::from(collider.pack_in_node).to_cols_array());
        }
        self.add_node(collider, node);
        Ok(())
    }

    fn add_node(&mut self, collider: &Collider, mut node: serde_json::Value) {
        // A body of the scene has its mass.
        if let Some(extras) = collider.body.extras().filter(|_| collider.node.is_none()) {
            node["extras"] = extras;
        }
        let node = self.push(List::Nodes, node.to_string());
        match collider.node {
            Some(parent) => self.children.entry(parent).or_default().push(node),
            None => self.roots.push(node),
        }
    }

    fn add_shape(&mut self, list: usize, shape: &serde_json::Value) -> usize {
        let (before, new) = &mut self.shapes[list];
        new.push(shape.to_string());
        *before + new.len() - 1
    }

    fn add_primitive(&mut self, collider: &Collider, primitive: &BodyPrimitive, form: &Form) {
        let ([a, b, c], kind) = (primitive.sizes, primitive.kind.as_str());
        let sizes = match primitive.kind {
            PrimitiveKind::Box => json!({ "size": [2.0 * a, 2.0 * b, 2.0 * c] }),
            PrimitiveKind::Sphere => json!({ "radius": a }),
            PrimitiveKind::Capsule | PrimitiveKind::Cylinder => {
                json!({ "radiusTop": a, "radiusBottom": a, "height": 2.0 * b })
            }
        };
        let shape = json!({ "type": kind, kind: sizes });
        let mut extensions = serde_json::Map::new();
        if form.khr.is_some() {
            let geometry = json!({ "shape": self.add_shape(KHR_LIST, &shape) });
            extensions.insert(KHR_BODY.to_owned(), json!({ "collider": { "geometry": geometry } }));
        }
        if form.is_omi {
            let round = json!({ "type": kind, kind: { "radius": a, "height": 2.0 * b } });
            let is_long = matches!(primitive.kind, PrimitiveKind::Capsule | PrimitiveKind::Cylinder);
            let shape = self.add_shape(OMI_LIST, if is_long { &round } else { &shape });
            extensions.insert(OMI_BODY.to_owned(), json!({ "collider": { "shape": shape } }));
        }
        let is_box = primitive.kind == PrimitiveKind::Box;
        // From y to z.
        let upright = if is_box { DQuat::IDENTITY } else { DQuat::from_rotation_x(FRAC_PI_2) };
        let in_pack =
            DAffine3::from_rotation_translation(primitive.turn() * upright, DVec3::from_array(primitive.center));
        let matrix = DMat4::from(collider.pack_in_node * in_pack).to_cols_array();
        let node = json!({ "name": collider.body.name, "extensions": extensions, "matrix": matrix });
        self.add_node(collider, node);
    }

    fn add_motion(&mut self, motion: &Motion, form: &Form) -> Result<(), String> {
        let numbers = [motion.mass].into_iter().chain(motion.center.to_array()).chain(motion.moments.to_array());
        if let Some(found) = numbers.into_iter().find(|number| !is_in_range(*number)) {
            let fault = format!("its mass, centre or inertia is {found:e}, too large for 32 bits");
            return Err(format!("node {}: {fault}; scale the node less, or pass --static", motion.node));
        }
        let mut described = json!({
            "mass": motion.mass,
            "centerOfMass": motion.center.to_array(),
            "inertiaDiagonal": motion.moments.to_array(),
            "inertiaOrientation": motion.orientation.to_array(),
        });
        let extensions = self.extensions.entry(motion.node).or_default();
        if form.khr.is_some() {
            extensions.push((KHR_BODY, json!({ "motion": described }).to_string()));
        }
        if form.is_omi {
            described["type"] = "dynamic".into();
            extensions.push((OMI_BODY, json!({ "motion": described }).to_string()));
        }
        Ok(())
    }

    /// Adds the new bytes to the document, and returns those for the BIN chunk.
    fn add_buffer(&mut self, buffer: Buffer) -> Result<Vec<u8>, String> {
        let length = buffer.base + buffer.bytes.len();
        if buffer.bytes.is_empty() {
            return Ok(Vec::new());
        }
        if !buffer.is_chunk {
            let data = STANDARD.encode(&buffer.bytes);
            let uri = format!("data:application/octet-stream;base64,{data}");
            self.push(List::Buffers, json!({ "byteLength": length, "uri": uri }).to_string());
            return Ok(Vec::new());
        }
        match self.old[List::Buffers as usize].first() {
            None => drop(self.push(List::Buffers, json!({ "byteLength": length }).to_string())),
            Some(first) => {
                let length_before = members(first.get())?.get("byteLength").copied();
                let length_before = length_before.ok_or("the first buffer has no byteLength")?;
                self.edits.replace(length_before.get(), length.to_string());
            }
        }
        Ok(buffer.bytes)
    }

    fn finish(mut self, form: &Form) -> Result<String, String> {
        self.add_to_nodes()?;
        let mut new_members: Vec<(&str, String)> = Vec::new();
        for (name, new) in LISTS.into_iter().zip(std::mem::take(&mut self.new)) {
            self.append_or_add(name, &new, &mut new_members)?;
        }
        self.add_to_scene()?;
        let used: Vec<String> = match self.root.get("extensionsUsed") {
            Some(used) => serde_json::from_str::<Vec<String>>(used.get())
                .map_err(|error| format!("extensionsUsed: {error}; expected a list of names"))?,
            None => Vec::new(),
        };
        let has_shapes = !self.shapes[KHR_LIST].1.is_empty();
        let written = [
            (KHR_BODY, form.khr.is_some()),
            (KHR_SHAPE, has_shapes),
            (OMI_BODY, form.is_omi),
            (OMI_SHAPE, form.is_omi),
        ];
        let names = written.iter().filter(|(name, is_written)| *is_written && !used.iter().any(|used| used == name));
        let names: Vec<String> = names.map(|(name, _)| format!("\"{name}\"")).collect();
        self.append_or_add("extensionsUsed", &names, &mut new_members)?;
        self.add_shapes(&mut new_members)?;
        self.add_seal()?;
        self.edits.add(self.text, &new_members)?;
        Ok(self.edits.apply())
    }

    fn append_or_add(
        &mut self,
        name: &'static str,
        new: &[String],
        members: &mut Vec<(&'static str, String)>,
    ) -> Result<(), String> {
        match self.root.get(name) {
            Some(list) => self.edits.append(list.get(), new)?,
            None if new.is_empty() => {}
            None => members.push((name, format!("[{}]", new.join(",")))),
        }
        Ok(())
    }

    /// Appends to the name of the program that made the file.
    fn add_seal(&mut self) -> Result<(), String> {
        let Some(asset) = self.root.get("asset") else { return Ok(()) };
        match members(asset.get())?.get("generator").map(|own| own.get()) {
            Some(own) if own.len() > 2 && own.ends_with('"') => {
                self.edits.replace(own, format!("{}, {SEAL}\"", &own[..own.len() - 1]));
            }
            Some(own) => self.edits.replace(own, format!("\"{SEAL}\"")),
            None => self.edits.add(asset.get(), &[("generator", format!("\"{SEAL}\""))])?,
        }
        Ok(())
    }

    fn add_to_nodes(&mut self) -> Result<(), String> {
        let changed: Vec<usize> = self.children.keys().chain(self.extensions.keys()).copied().collect();
        for index in std::collections::BTreeSet::from_iter(changed) {
            let node = *self.old[List::Nodes as usize].get(index).ok_or("a node is missing")?;
            let old = members(node.get())?;
            let mut new: Vec<(&str, String)> = Vec::new();
            let children = self.children.remove(&index).unwrap_or_default();
            let children: Vec<String> = children.iter().map(usize::to_string).collect();
            match old.get("children") {
                Some(list) => self.edits.append(list.get(), &children)?,
                None if children.is_empty() => {}
                None => new.push(("children", format!("[{}]", children.join(",")))),
            }
            let extensions = self.extensions.remove(&index).unwrap_or_default();
            match old.get("extensions") {
                Some(object) => self.edits.add(object.get(), &extensions)?,
                None if extensions.is_empty() => {}
                None => new.push(("extensions", object(&extensions))),
            }
            self.edits.add(node.get(), &new)?;
        }
        Ok(())
    }

    fn add_to_scene(&mut self) -> Result<(), String> {
        let Some(scenes) = self.root.get("scenes").filter(|_| !self.roots.is_empty()) else {
            // Without scenes, nodes without parents are the roots.
            return Ok(());
        };
        let index = self.root.get("scene").map_or(Ok(0), |index| index.get().parse::<usize>());
        let index = index.map_err(|_| "scene is not an index".to_owned())?;
        let scene = *elements(scenes.get())?.get(index).ok_or("the default scene does not exist")?;
        let roots: Vec<String> = self.roots.iter().map(usize::to_string).collect();
        match members(scene.get())?.get("nodes") {
            Some(list) => self.edits.append(list.get(), &roots),
            None => self.edits.add(scene.get(), &[("nodes", format!("[{}]", roots.join(",")))]),
        }
    }

    fn add_shapes(&mut self, new_members: &mut Vec<(&'static str, String)>) -> Result<(), String> {
        let mut new_lists = Vec::new();
        for (name, (_, new)) in SHAPE_LISTS.into_iter().zip(&self.shapes).filter(|(_, (_, new))| !new.is_empty()) {
            let shapes = || format!("[{}]", new.join(","));
            let extensions = self.root.get("extensions").map(|extensions| members(extensions.get())).transpose()?;
            match (extensions.as_ref().and_then(|extensions| extensions.get(name)), shapes_of(self.root, name)?) {
                (_, Some(list)) => self.edits.append(list.get(), new)?,
                (Some(object), None) => self.edits.add(object.get(), &[("shapes", shapes())])?,
                (None, None) => new_lists.push((name, object(&[("shapes", shapes())]))),
            }
        }
        match self.root.get("extensions") {
            _ if new_lists.is_empty() => {}
            Some(extensions) => self.edits.add(extensions.get(), &new_lists)?,
            None => new_members.push(("extensions", object(&new_lists))),
        }
        Ok(())
    }
}

fn shapes_of<'a>(root: &Members<'a>, name: &str) -> Result<Option<&'a RawValue>, String> {
    let Some(extensions) = root.get("extensions") else {
        return Ok(None);
    };
    match members(extensions.get())?.get(name) {
        Some(shapes) => Ok(members(shapes.get())?.get("shapes").copied()),
        None => Ok(None),
    }
}

fn object(members: &[(&str, String)]) -> String {
    let members: Vec<String> = members.iter().map(|(name, value)| format!("\"{name}\":{value}")).collect();
    format!("{{{}}}", members.join(","))
}

/// Whether a transform is a rotation, a uniform scale and a translation, as a collider's node
/// requires. NaN takes the failing branch.
fn is_similarity(transform: &DAffine3) -> bool {
    let product = transform.matrix3.transpose() * transform.matrix3;
    let scale_sq = product.x_axis.x;
    let rest = (product - glam::DMat3::from_diagonal(DVec3::splat(scale_sq))).to_cols_array();
    scale_sq > 0.0 && scale_sq < f64::INFINITY && rest.iter().all(|x| x.abs() <= DISTORTION * scale_sq)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distorted_frames_are_recognised() {
        let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.5);
        let with = |scale: DVec3| DAffine3::from_scale_rotation_translation(scale, turned, DVec3::ONE);
        assert!(is_similarity(&with(DVec3::splat(0.01))) && is_similarity(&with(DVec3::new(-2.0, 2.0, 2.0))));
        assert!(!is_similarity(&with(DVec3::new(1.0, 1.0, 1.01))) && !is_similarity(&with(DVec3::ZERO)));
        assert!(!is_similarity(&with(DVec3::splat(f64::NAN))));
    }

    #[test]
    fn what_32_bits_do_not_hold_is_an_error() {
        let body = || Body {
            name: "stone".to_owned(),
            rank: 3,
            part: 0,
            origin: [0.0; 3],
            positions: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
            polygons: vec![vec![0, 1, 2], vec![0, 2, 3], vec![0, 3, 1], vec![1, 3, 2]],
            mesh: None,
            primitive: None,
        };
        let form = Form { khr: None, is_omi: true, is_visible: false, is_in_node: false };
        let add = |scale: DVec3, mass: f64| {
            let collider =
                Collider { body: body(), mesh_name: None, node: None, pack_in_node: DAffine3::from_scale(scale) };
            let motion =
                Motion { node: 0, mass, center: DVec3::ZERO, moments: DVec3::ONE, orientation: DQuat::IDENTITY };
            super::add(
                &GltfFile::empty(),
                &[collider],
                if mass > 0.0 { vec![motion] } else { Vec::new() }.as_slice(),
                &form,
            )
        };
        assert!(add(DVec3::splat(1e38), 0.0).is_ok() && add(DVec3::new(1e38, 1.0, 1.0), 0.0).is_ok());
        for scale in [DVec3::splat(1e39), DVec3::new(1.0, 1e39, 1.0), DVec3::NAN] {
            let error = add(scale, 0.0).unwrap_err();
            assert!(error.starts_with("hull stone: a coordinate in the scene is "), "{error}");
        }
        assert!(add(DVec3::ONE, 1e39).unwrap_err().contains("too large for 32 bits"));
    }
}
