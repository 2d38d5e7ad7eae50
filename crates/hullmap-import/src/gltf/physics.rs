//! glTF 2.0: colliders of nodes, as physics extensions describe them.
//!
//! | extension | collider of a node | shapes of the file |
//! |---|---|---|
//! | `KHR_physics_rigid_bodies` | `geometry`: a `shape`, `mesh` or `node` | `KHR_implicit_shapes` |
//! | `OMI_physics_body` | `shape` | `OMI_physics_shape` |
//!
//! A `node` stands for its mesh and those below it. Exporters write the same collider by both
//! extensions: it counts once. Triggers are not colliders.
//!
//! Implicit shapes become the points of a hull, for round shapes up to [`ROUND_ERROR`] of the
//! radius inside.
//!
//! # Deviations
//! The drafts of `KHR_physics_rigid_bodies` differ: the draft of October 2025 names a `node` with a
//! mesh, and the draft of June 2026 a `mesh`. Both are read. Negative scale factors of a node
//! mirror a shape, which changes only tapered shapes.
//!
//! # Reference
//! Khronos, "KHR_physics_rigid_bodies" and "KHR_implicit_shapes", drafts of commit ac5c413 of
//! October 2025; Open Metaverse Interoperability Group, "OMI_physics_body" and "OMI_physics_shape",
//! commit 89d328b of August 2026.

use std::collections::HashSet;
use std::f64::consts::TAU;

use serde::Deserialize;
use serde_json::value::RawValue;

use super::document::{Bounded, Document, Node};

/// Sides of the polygon that stands for a circle.
const SIDES: u32 = 32;

/// Steps from a pole to the equator of the polyhedron that stands for a sphere.
const STEPS: i32 = 8;

/// Maximum distance of a round shape from its hull, relative to its radius.
pub const ROUND_ERROR: f64 = 0.02;

#[derive(Debug, PartialEq)]
pub enum Geometry {
    Mesh(u32),
    /// The meshes of a node and of the nodes below it, in the frame of that node.
    Node(u32),
    /// Points whose hull is the shape.
    Points(Vec<[f64; 3]>),
    /// A shape without a hull, for messages.
    Unusable(String),
}

#[derive(Debug)]
pub struct Collider {
    pub geometry: Geometry,
    /// Whether the shape is a hull. Otherwise engines collide with the triangles of the mesh.
    pub is_convex: bool,
}

#[derive(Debug)]
pub struct Shapes {
    khr: Vec<Shape>,
    omi: Vec<Shape>,
}

#[derive(Debug, Deserialize)]
struct ShapeList {
    #[serde(default)]
    shapes: Bounded<Shape>,
}

/// An implicit shape. Lengths are named as in the extensions, which agree except for defaults.
#[derive(Debug, Default, Deserialize)]
struct Shape {
    #[serde(rename = "type", default)]
    kind: String,
    #[serde(rename = "box")]
    cuboid: Option<Lengths>,
    sphere: Option<Lengths>,
    capsule: Option<Lengths>,
    cylinder: Option<Lengths>,
    plane: Option<Lengths>,
    convex: Option<MeshReference>,
    trimesh: Option<MeshReference>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Lengths {
    size: Option<[f64; 3]>,
    radius: Option<f64>,
    height: Option<f64>,
    radius_bottom: Option<f64>,
    radius_top: Option<f64>,
    size_x: Option<f64>,
    size_z: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct MeshReference {
    mesh: u32,
}

#[derive(Debug, Deserialize)]
struct KhrBody {
    collider: Option<KhrCollider>,
}

#[derive(Debug, Deserialize)]
struct KhrCollider {
    geometry: KhrGeometry,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct KhrGeometry {
    shape: Option<u32>,
    node: Option<u32>,
    mesh: Option<u32>,
    #[serde(default)]
    convex_hull: bool,
}

#[derive(Debug, Deserialize)]
struct OmiBody {
    collider: Option<OmiCollider>,
}

#[derive(Debug, Deserialize)]
struct OmiCollider {
    /// -1: none, if the node only joins the colliders below it.
    #[serde(default = "no_shape")]
    shape: i64,
}

fn no_shape() -> i64 {
    -1
}

struct Defaults {
    capsule: [f64; 2],
    cylinder: [f64; 2],
}

/// Radius and height.
const KHR: Defaults = Defaults { capsule: [0.25, 0.5], cylinder: [0.25, 0.5] };
const OMI: Defaults = Defaults { capsule: [0.5, 1.0], cylinder: [0.5, 2.0] };

impl Shapes {
    /// The shapes of a file. Fails if one of the lists has another form.
    pub fn new(document: &Document) -> Result<Self, String> {
        let list = |raw: Option<&RawValue>, name: &str| match raw {
            None => Ok(Vec::new()),
            Some(raw) => match serde_json::from_str::<ShapeList>(raw.get()) {
                Ok(list) => Ok(list.shapes.0),
                Err(error) => Err(format!("the shapes of {name} cannot be read: {error}; export the file again")),
            },
        };
        let extensions = document.extensions.as_deref();
        Ok(Self {
            khr: list(extensions.and_then(|extensions| extensions.khr_shapes), "KHR_implicit_shapes")?,
            omi: list(extensions.and_then(|extensions| extensions.omi_shapes), "OMI_physics_shape")?,
        })
    }

    /// Fails if the extension has another form, or names a missing shape.
    pub fn collider(&self, node: &Node) -> Result<Option<Collider>, String> {
        let Some(extensions) = node.extensions.as_deref() else {
            return Ok(None);
        };
        if let Some(raw) = extensions.khr_body {
            let body: KhrBody = parse(raw, "KHR_physics_rigid_bodies")?;
            if let Some(collider) = body.collider {
                return self.khr(&collider.geometry).map(Some);
            }
        }
        if let Some(raw) = extensions.omi_body {
            let body: OmiBody = parse(raw, "OMI_physics_body")?;
            if let Some(collider) = body.collider.filter(|collider| collider.shape >= 0) {
                let shape = usize::try_from(collider.shape).ok().and_then(|index| self.omi.get(index));
                let shape = shape.ok_or_else(|| missing(collider.shape, "OMI_physics_shape", self.omi.len()))?;
                return Ok(Some(shape.collider(&OMI)));
            }
        }
        Ok(None)
    }

    fn khr(&self, geometry: &KhrGeometry) -> Result<Collider, String> {
        let is_convex = geometry.convex_hull;
        match *geometry {
            KhrGeometry { mesh: Some(mesh), .. } => Ok(Collider { geometry: Geometry::Mesh(mesh), is_convex }),
            KhrGeometry { node: Some(node), .. } => Ok(Collider { geometry: Geometry::Node(node), is_convex }),
            KhrGeometry { shape: Some(index), .. } => {
                let shape = self.khr.get(index as usize);
                let shape = shape.ok_or_else(|| missing(index.into(), "KHR_implicit_shapes", self.khr.len()))?;
                Ok(shape.collider(&KHR))
            }
            _ => Err("has a collider without a shape, a mesh or a node; export the file again".to_owned()),
        }
    }
}

fn parse<'a, T: Deserialize<'a>>(raw: &'a RawValue, name: &str) -> Result<T, String> {
    serde_json::from_str(raw.get())
        .map_err(|error| format!("has a {name} that cannot be read: {error}; export the file again"))
}

fn missing(index: i64, name: &str, count: usize) -> String {
    format!("has the collider shape {index}, which does not exist ({name} has {count}); export the file again")
}

impl Shape {
    fn collider(&self, defaults: &Defaults) -> Collider {
        let geometry = match self.kind.as_str() {
            "convex" | "trimesh" => match self.convex.or(self.trimesh) {
                Some(reference) => Geometry::Mesh(reference.mesh),
                None => Geometry::Unusable(format!("a shape of type {} without a mesh", self.kind)),
            },
            _ => self.points(defaults),
        };
        Collider { geometry, is_convex: self.kind != "trimesh" }
    }

    fn points(&self, defaults: &Defaults) -> Geometry {
        let round = |lengths: Option<Lengths>, [radius, height]: [f64; 2]| {
            let lengths = lengths.unwrap_or_default();
            let radius = |own: Option<f64>| own.or(lengths.radius).unwrap_or(radius);
            (radius(lengths.radius_bottom), radius(lengths.radius_top), lengths.height.unwrap_or(height))
        };
        let points = match self.kind.as_str() {
            "box" => cuboid(self.cuboid.and_then(|lengths| lengths.size).unwrap_or([1.0; 3])),
            "sphere" => sphere(self.sphere.and_then(|lengths| lengths.radius).unwrap_or(0.5), 0.0),
            "capsule" => {
                let (bottom, top, height) = round(self.capsule, defaults.capsule);
                [sphere(bottom, -0.5 * height), sphere(top, 0.5 * height)].concat()
            }
            "cylinder" => {
                let (bottom, top, height) = round(self.cylinder, defaults.cylinder);
                [circle(bottom, -0.5 * height), circle(top, 0.5 * height)].concat()
            }
            "plane" => match self.plane.map(|lengths| (lengths.size_x, lengths.size_z)) {
                Some((Some(x), Some(z))) => cuboid([x, 0.0, z]),
                _ => return Geometry::Unusable("a plane without end".to_owned()),
            },
            kind => return Geometry::Unusable(format!("a shape of the unknown type {kind:?}")),
        };
        if points.iter().flatten().all(|x| x.is_finite()) {
            Geometry::Points(points)
        } else {
            Geometry::Unusable("a shape that is not finite".to_owned())
        }
    }
}

fn cuboid(size: [f64; 3]) -> Vec<[f64; 3]> {
    let sign = |corner: u8, axis: u8| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 };
    let [x, y, z] = size;
    (0..8_u8).map(|corner| [x * sign(corner, 0), y * sign(corner, 1), z * sign(corner, 2)]).collect()
}

/// Points of a circle around the y axis; its centre if the radius is 0.
fn circle(radius: f64, y: f64) -> Vec<[f64; 3]> {
    let count = if radius == 0.0 { 1 } else { SIDES };
    (0..count)
        .map(|side| {
            let (sine, cosine) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            [radius * cosine, y, radius * sine]
        })
        .collect()
}

/// Points of a sphere with its centre on the y axis: the points of an octahedron whose edges are
/// divided into [`STEPS`], moved to the sphere. The six corners lie on the axes.
fn sphere(radius: f64, y: f64) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for i in -STEPS..=STEPS {
        let rest = STEPS - i.abs();
        for j in -rest..=rest {
            let k = rest - j.abs();
            for k in if k == 0 { vec![0] } else { vec![-k, k] } {
                let [a, b, c] = [i, j, k].map(f64::from);
                let factor = radius / (a * a + b * b + c * c).sqrt();
                points.push([a * factor, b * factor + y, c * factor]);
            }
        }
    }
    points
}

/// The meshes that colliders refer to, as far as the extensions can be read.
pub fn meshes(document: &Document) -> HashSet<u32> {
    let mut meshes = HashSet::new();
    let Ok(shapes) = Shapes::new(document) else {
        return meshes;
    };
    let mut is_visited = vec![false; document.nodes.len()];
    let mut stack = Vec::new();
    for node in document.nodes.iter() {
        match shapes.collider(node) {
            Ok(Some(Collider { geometry: Geometry::Mesh(mesh), .. })) => drop(meshes.insert(mesh)),
            Ok(Some(Collider { geometry: Geometry::Node(node), .. })) => stack.push(node),
            _ => {}
        }
    }
    while let Some(index) = stack.pop() {
        let (Some(node), Some(is_visited)) = (document.nodes.get(index as usize), is_visited.get_mut(index as usize))
        else {
            continue;
        };
        if !std::mem::replace(is_visited, true) {
            meshes.extend(node.mesh);
            stack.extend(node.children.iter());
        }
    }
    meshes
}

/// Whether any node has a collider, as far as the extensions can be read. Complexity: O(document).
pub fn is_present(document: &Document) -> bool {
    let has_collider = |shapes: Shapes| document.nodes.iter().any(|node| matches!(shapes.collider(node), Ok(Some(_))));
    Shapes::new(document).is_ok_and(has_collider)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measured by the planes of the octahedron's triangles.
    #[test]
    fn the_hull_of_a_sphere_is_close_to_it() {
        let points = sphere(1.0, 0.0);
        assert_eq!(points.len(), 4 * (STEPS * STEPS) as usize + 2);
        for axis in 0..3 {
            assert!(points.iter().any(|point| point[axis] == 1.0) && points.iter().any(|point| point[axis] == -1.0));
        }
        let mut worst = 1.0_f64;
        for step in 0..20_000 {
            let y = 1.0 - 2.0 * (f64::from(step) + 0.5) / 20_000.0;
            let (sine, cosine) = (f64::from(step) * 2.399_963).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            let direction = [radius * cosine, y, radius * sine];
            let dot = |point: &[f64; 3]| point.iter().zip(direction).map(|(a, b)| a * b).sum::<f64>();
            worst = worst.min(points.iter().map(dot).fold(0.0, f64::max));
        }
        assert!((1.0 - ROUND_ERROR..0.999).contains(&worst), "{worst}");
        assert!(1.0 - (TAU / f64::from(2 * SIDES)).cos() < ROUND_ERROR);
    }
}
