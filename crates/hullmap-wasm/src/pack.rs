//! Packs and their hulls.

use std::sync::Arc;

use hullmap::SharedHull;
use hullmap::glam::Vec3;
use js_sys::Float64Array;
use wasm_bindgen::prelude::*;

use crate::input::{bytes_of, error, rows_of, text_of};
use crate::object::{Plain, vector_from, vector_of};
use crate::shape::Shape;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A support vertex: the farthest vertex of a hull in a direction. */
export interface SupportVertex {
    /** Index of the vertex. */
    index: number;
    /** Its position, three numbers, in the hull's frame. */
    point: Float64Array;
}

/** Mass properties of a rigid body of uniform density. */
export interface MassProperties {
    /** Density times volume. */
    mass: number;
    /** Centre of mass, three numbers. */
    centerOfMass: Float64Array;
    /** Inertia tensor about the centre of mass: nine numbers, column by column; symmetric. */
    inertia: Float64Array;
    /** Which solid has this mass: the mesh, or the hulls, whose overlaps count twice. */
    source: "mesh" | "hulls";
}

/** The share of a mesh's solid that is in none of its parts. */
export interface Voids {
    /** From 0 to 1, an estimate. */
    share: number;
    /** Its error, from 0 to 1. */
    error: number;
}

/** A primitive that may replace a part. */
export interface Primitive {
    /** What it is. */
    kind: "box" | "sphere" | "capsule" | "cylinder";
    /** Its centre, three numbers. */
    center: Float64Array;
    /** Rotation from its own axes: a unit quaternion x, y, z, w. The axis of capsules and cylinders is z. */
    rotation: Float64Array;
    /** Box: half extents. Sphere: radius. Capsule and cylinder: radius, and half the length of the axis. */
    sizes: Float64Array;
    /** Bound on how far it protrudes from the mesh's solid. */
    protrusion: number;
}
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "SupportVertex")]
    pub type SupportVertex;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "MassProperties")]
    pub type MassProperties;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Voids")]
    pub type Voids;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Primitive")]
    pub type Primitive;
}

/// Mass properties as a plain object.
fn mass(found: &hullmap::MassProperties) -> MassProperties {
    let inertia = found.inertia.to_cols_array();
    Plain::new()
        .with("mass", found.mass)
        .with("centerOfMass", vector_of(found.center_of_mass))
        .with("inertia", numbers(&inertia))
        .with("source", found.source.as_str())
        .done()
}

fn numbers(numbers: &[f64]) -> Float64Array {
    Float64Array::from(numbers)
}

/// The error about a file that cannot be opened, with the classes of JavaScript.
pub fn wrong_kind(fault: impl std::fmt::Display) -> JsError {
    let rust = "open it as one, or any kind with `Asset::open`";
    error(fault.to_string().replace(rust, "new Pack opens packs, new Level triangle meshes and height fields"))
}

/// A density, as in C.
fn checked_density(density: f64) -> Result<f64, JsError> {
    if (0.0..f64::INFINITY).contains(&density) {
        return Ok(density);
    }
    Err(error(format!("density: expected a finite number from 0, found {density}")))
}

/// An open pack.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Pack(Arc<hullmap::Pack>);

#[wasm_bindgen]
impl Pack {
    /// Opens the bytes of a `.hullmap` file, after all checks.
    ///
    /// # Errors
    /// The bytes are not a pack, or are damaged. The message states the remedy.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    ) -> Result<Pack, JsError> {
        hullmap::Pack::from_bytes(&bytes_of(bytes)?).map(|pack| Self(Arc::new(pack))).map_err(wrong_kind)
    }

    /// Number of hulls.
    #[wasm_bindgen(getter, js_name = hullCount)]
    pub fn hull_count(&self) -> usize {
        self.0.hull_count()
    }

    /// Size in bytes.
    #[wasm_bindgen(getter, js_name = byteLength)]
    pub fn byte_len(&self) -> usize {
        self.0.byte_len()
    }

    /// Version of the file format.
    #[wasm_bindgen(getter, js_name = formatVersion)]
    pub fn format_version(&self) -> u32 {
        self.0.header().format_version
    }

    /// Recorded path of the source; empty if none was recorded.
    #[wasm_bindgen(getter)]
    pub fn source(&self) -> String {
        self.0.source_path().to_owned()
    }

    /// Recorded options of the bake.
    #[wasm_bindgen(getter)]
    pub fn options(&self) -> String {
        self.0.options().to_owned()
    }

    /// The hull with this index, from 0.
    ///
    /// # Errors
    /// There is no such hull.
    // As f64, because JavaScript would make an index out of −1, a name or nothing.
    pub fn hull(&self, index: f64) -> Result<Hull, JsError> {
        if !(index >= 0.0 && index.fract() == 0.0) {
            return Err(error("hull: expected the index of a hull, a whole number from 0; hullNamed takes a name"));
        }
        self.0.shared_hull(index as usize).map(Hull).map_err(error)
    }

    /// The first hull with this name.
    ///
    /// # Errors
    /// There is no such hull; the error names some that there are.
    #[wasm_bindgen(js_name = hullNamed)]
    pub fn hull_named(&self, #[wasm_bindgen(unchecked_param_type = "string")] name: &JsValue) -> Result<Hull, JsError> {
        let name = text_of(name, "the name of a hull; hull takes an index")?;
        self.0.shared_hull_named(&name).map(Hull).map_err(error)
    }

    /// Mass properties of all hulls as one rigid body of this density. Each object has the mass of
    /// its mesh, if the pack records it.
    ///
    /// # Errors
    /// The density is negative or not finite.
    #[wasm_bindgen(js_name = massProperties)]
    pub fn mass_properties(&self, density: f64) -> Result<MassProperties, JsError> {
        Ok(mass(&self.0.mass_properties(checked_density(density)?)))
    }

    /// The union of all hulls as a shape, for instance to cast rays at it.
    pub fn shape(&self) -> Shape {
        Shape(Arc::clone(&self.0).into())
    }
}

/// A hull of a pack. It keeps its pack alive.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Hull(pub(crate) SharedHull);

#[wasm_bindgen]
impl Hull {
    /// Its name.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.0.hull().name().to_owned()
    }

    /// 3 for a solid, 2 for a polygon, 1 for a segment, 0 for a point.
    #[wasm_bindgen(getter)]
    pub fn rank(&self) -> u32 {
        self.0.hull().rank()
    }

    /// Number of vertices.
    #[wasm_bindgen(getter, js_name = vertexCount)]
    pub fn vertex_count(&self) -> usize {
        self.0.hull().vertex_count()
    }

    /// Number of faces.
    #[wasm_bindgen(getter, js_name = faceCount)]
    pub fn face_count(&self) -> usize {
        self.0.hull().face_count()
    }

    /// Number of source points that the hull was built from.
    #[wasm_bindgen(getter, js_name = sourcePointCount)]
    pub fn source_point_count(&self) -> u32 {
        self.0.hull().source_point_count()
    }

    /// Volume; 0 below rank 3.
    #[wasm_bindgen(getter)]
    pub fn volume(&self) -> f64 {
        self.0.hull().volume()
    }

    /// Surface area; 0 below rank 2.
    #[wasm_bindgen(getter, js_name = surfaceArea)]
    pub fn surface_area(&self) -> f64 {
        self.0.hull().surface_area()
    }

    /// Maximum distance between two vertices.
    #[wasm_bindgen(getter)]
    pub fn diameter(&self) -> f64 {
        self.0.hull().diameter()
    }

    /// Centre of mass at uniform density: three numbers.
    #[wasm_bindgen(getter)]
    pub fn centroid(&self) -> Vec<f64> {
        self.0.hull().centroid().to_array().to_vec()
    }

    /// Inertia tensor about the centroid at density 1: nine numbers, column by column.
    #[wasm_bindgen(getter)]
    pub fn inertia(&self) -> Vec<f64> {
        self.0.hull().inertia_tensor().to_cols_array().to_vec()
    }

    /// Mass properties of the mesh that the hull, or the part, was baked from, at this density;
    /// undefined if the pack does not record them.
    ///
    /// # Errors
    /// The density is negative or not finite.
    #[wasm_bindgen(js_name = meshMassProperties)]
    pub fn mesh_mass_properties(&self, density: f64) -> Result<Option<MassProperties>, JsError> {
        Ok(self.0.hull().mesh_mass_properties(checked_density(density)?).as_ref().map(mass))
    }

    /// The share of the mesh's solid that is in none of its parts; undefined if the pack does not
    /// record it.
    #[wasm_bindgen(getter)]
    pub fn voids(&self) -> Option<Voids> {
        let found = self.0.hull().voids()?;
        Some(Plain::new().with("share", found.share).with("error", found.error).done())
    }

    /// The primitive that may replace this part; undefined if the pack records none.
    #[wasm_bindgen(getter)]
    pub fn primitive(&self) -> Option<Primitive> {
        let found = self.0.hull().primitive()?;
        let plain = Plain::new()
            .with("kind", found.kind.as_str())
            .with("center", vector_of(found.center))
            .with("rotation", numbers(&found.rotation.to_array()))
            .with("sizes", numbers(&found.sizes))
            .with("protrusion", found.protrusion);
        Some(plain.done())
    }

    /// Minimum and maximum coordinates: six numbers.
    #[wasm_bindgen(getter)]
    pub fn bounds(&self) -> Vec<f32> {
        self.0.hull().bounds().iter().flat_map(|corner| corner.to_array()).collect()
    }

    /// Maximum distance by which a simplified hull exceeds the exact one; 0 for an exact hull.
    #[wasm_bindgen(getter, js_name = outerError)]
    pub fn outer_error(&self) -> f64 {
        self.0.hull().outer_error()
    }

    /// Origin of the hull's frame in the frame of the source: three numbers, which added to a point
    /// of the hull give the source's coordinates. Zero unless the bake recentred.
    #[wasm_bindgen(getter)]
    pub fn origin(&self) -> Vec<f64> {
        self.0.hull().origin().to_array().to_vec()
    }

    /// Index among the convex parts of its mesh.
    #[wasm_bindgen(getter)]
    pub fn part(&self) -> u32 {
        self.0.hull().part()
    }

    /// Number of convex parts of its mesh; 0 for a hull that is not a part.
    #[wasm_bindgen(getter, js_name = partCount)]
    pub fn part_count(&self) -> u32 {
        self.0.hull().part_count()
    }

    /// Kind of solid that the part was measured against: `watertight`, `closed` (holes were closed)
    /// or `walls` (its triangles alone); undefined if the part was not measured.
    #[wasm_bindgen(getter)]
    pub fn solid(&self) -> Option<String> {
        self.0.hull().solid().map(|kind| kind.to_string())
    }

    /// Bound on how far a point of the mesh's surface lies outside all of its parts; undefined if
    /// that was not measured.
    #[wasm_bindgen(getter)]
    pub fn uncovered(&self) -> Option<f64> {
        self.0.hull().uncovered()
    }

    /// Bound on how far a point of this part lies outside the mesh's solid; undefined if that was
    /// not measured.
    #[wasm_bindgen(getter)]
    pub fn protrusion(&self) -> Option<f64> {
        self.0.hull().protrusion()
    }

    /// The point of this part that protrudes most: three numbers; undefined if that was not
    /// measured.
    #[wasm_bindgen(getter, js_name = protrusionAt)]
    pub fn protrusion_at(&self) -> Option<Vec<f64>> {
        self.0.hull().protrusion_at().map(|at| at.to_array().to_vec())
    }

    /// Kind of the direction index.
    #[wasm_bindgen(getter, js_name = indexKind)]
    pub fn index_kind(&self) -> String {
        self.0.hull().index_kind().to_string()
    }

    /// Size of the direction index in bytes.
    #[wasm_bindgen(getter, js_name = indexBytes)]
    pub fn index_byte_len(&self) -> usize {
        self.0.hull().index_byte_len()
    }

    /// The hull as a shape, for instance to cast rays at it.
    pub fn shape(&self) -> Shape {
        Shape(self.0.clone().into())
    }

    /// Positions of the vertices, three numbers each, in the hull's frame.
    pub fn vertices(&self) -> Vec<f32> {
        self.0.hull().vertices().flat_map(|vertex| vertex.to_array()).collect()
    }

    /// For each vertex, its index in the source file; 4294967295 for a vertex that the bake
    /// created.
    #[wasm_bindgen(js_name = sourceVertices)]
    pub fn source_vertices(&self) -> Vec<u32> {
        self.0.hull().arrays().map(|arrays| arrays.source_vertices.to_vec()).unwrap_or_default()
    }

    /// For each face, the position in `faceVertices` at which its vertices start.
    #[wasm_bindgen(js_name = faceStarts)]
    pub fn face_starts(&self) -> Vec<u32> {
        self.0.hull().arrays().map(|arrays| arrays.face_starts.to_vec()).unwrap_or_default()
    }

    /// Vertices of the faces, counter-clockwise seen from outside.
    #[wasm_bindgen(js_name = faceVertices)]
    pub fn face_vertices(&self) -> Vec<u32> {
        self.0.hull().arrays().map(|arrays| arrays.face_vertices.to_vec()).unwrap_or_default()
    }

    /// For each vertex, the position in `neighbours` at which its neighbours start.
    #[wasm_bindgen(js_name = neighbourStarts)]
    pub fn neighbour_starts(&self) -> Vec<u32> {
        self.0.hull().arrays().map(|arrays| arrays.neighbour_starts.to_vec()).unwrap_or_default()
    }

    /// Vertices that share an edge with each vertex, ascending.
    pub fn neighbours(&self) -> Vec<u32> {
        self.0.hull().arrays().map(|arrays| arrays.neighbours.to_vec()).unwrap_or_default()
    }

    /// Triangles of the faces: three vertices each, to draw.
    pub fn triangles(&self) -> Vec<u32> {
        let mut out = Vec::new();
        for mut face in self.0.hull().faces() {
            let (Some(first), Some(mut last)) = (face.next(), face.next()) else { continue };
            for next in face {
                out.extend([first, last, next]);
                last = next;
            }
        }
        out
    }

    /// Edges: two vertices each, to draw.
    pub fn edges(&self) -> Vec<u32> {
        let hull = self.0.hull();
        let count = u32::try_from(hull.vertex_count()).unwrap_or(u32::MAX);
        (0..count)
            .flat_map(|from| hull.neighbours(from).filter(move |&to| to > from).flat_map(move |to| [from, to]))
            .collect()
    }

    /// Support vertex in a direction: three numbers in the hull's frame, of any length.
    ///
    /// # Errors
    /// `direction` is not three finite numbers.
    pub fn support(
        &self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] direction: &[f64],
    ) -> Result<SupportVertex, JsError> {
        let direction = vector_from("direction", direction)?;
        if !direction.is_finite() {
            return Err(error(format!("direction: {direction} is not finite")));
        }
        let found = self.0.hull().support(direction.as_vec3());
        Ok(Plain::new().with("index", found.index).with("point", vector_of(found.point.as_dvec3())).done())
    }

    /// Index of the support vertex in each of many directions, three numbers each.
    ///
    /// # Errors
    /// The length of `directions` is not a multiple of three, or a number is not finite.
    pub fn supports(
        &self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] directions: &[f32],
    ) -> Result<Vec<u32>, JsError> {
        if let Some(number) = directions.iter().find(|number| !number.is_finite()) {
            return Err(error(format!("directions: {number} is not a finite number")));
        }
        let directions = rows_of("directions", directions)?;
        let hull = self.0.hull();
        Ok(directions.iter().map(|&dir| hull.support(Vec3::from_array(dir)).index).collect())
    }
}
