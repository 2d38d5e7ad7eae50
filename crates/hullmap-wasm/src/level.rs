//! Levels, which keep their triangles: triangle meshes and height fields.

use std::sync::Arc;

use hullmap::compound::SharedSheet;
use hullmap::glam::Vec3;
use hullmap::{Cache, CastSettings, EdgeClass, HeightField, Motion, SharedGeometry, TriangleMesh};
use js_sys::{Float64Array, Uint32Array};
use wasm_bindgen::prelude::*;

use crate::input::{bytes_of, error};
use crate::object::{Plain, vector_from};
use crate::pack::wrong_kind;
use crate::pair::{pose_of, query};
use crate::shape::{Body, Shape, geometry_of};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Where the neighbour of a triangle beyond an edge is. */
export type EdgeClass = "border" | "flat" | "convex" | "concave" | "non-manifold" | "reversed";
"#;

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "EdgeClass")]
    pub type EdgeClassName;
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "Impact")]
    pub type ImpactAnswer;
}

/// A level or a terrain that keeps its triangles, and does not move: a triangle mesh or a height
/// field. In a pair it is A or B, and the parts of answers are indices of triangles.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Level {
    sheet: SharedSheet,
    drawn: Drawn,
}

/// Arrays to draw.
#[derive(Debug, Default)]
struct Drawn {
    vertices: Vec<f32>,
    triangles: Vec<u32>,
    /// Ends of the edges of each class, each edge once, in the order of [`EdgeClass::ALL`].
    edges: Vec<Vec<[u32; 2]>>,
}

impl Drawn {
    fn new(sheet: &SharedSheet) -> Self {
        match sheet {
            SharedSheet::Mesh(mesh) => {
                let vertices = (0..mesh.vertex_count()).filter_map(|vertex| mesh.vertex(vertex));
                let triangles = 0..mesh.triangle_count();
                Self::from_triangles(vertices, triangles.filter_map(|at| mesh.corners(at).zip(mesh.edge_classes(at))))
            }
            SharedSheet::Field(field) => {
                let layout = field.layout();
                let places = (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
                let vertices = places.filter_map(|(column, row)| field.vertex(column, row));
                let number = |[column, row]: [usize; 2]| layout.vertex(column, row) as u32;
                // Triangles in holes have no classes.
                let triangles = (0..field.triangle_count())
                    .filter_map(|at| Some((layout.corners(at).map(number), field.edge_classes(at)?)));
                Self::from_triangles(vertices.map(|vertex| vertex.as_vec3()), triangles)
            }
        }
    }

    fn from_triangles(
        vertices: impl Iterator<Item = Vec3>,
        triangles: impl Iterator<Item = ([u32; 3], [EdgeClass; 3])>,
    ) -> Self {
        let triangles: Vec<_> = triangles.collect();
        Self {
            vertices: vertices.flat_map(|vertex| vertex.to_array()).collect(),
            triangles: triangles.iter().flat_map(|(corners, _)| *corners).collect(),
            edges: EdgeClass::group(triangles),
        }
    }
}

#[wasm_bindgen]
impl Level {
    /// Opens the bytes of a `.hullmesh` or `.hullfield` file, after all checks.
    ///
    /// # Errors
    /// The bytes are no such file, or are damaged. The message states the remedy.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    ) -> Result<Level, JsError> {
        let bytes = &*bytes_of(bytes)?;
        let sheet = if bytes.starts_with(FIELD) {
            SharedSheet::Field(Arc::new(HeightField::from_bytes(bytes).map_err(wrong_kind)?))
        } else {
            SharedSheet::Mesh(Arc::new(TriangleMesh::from_bytes(bytes).map_err(wrong_kind)?))
        };
        Ok(Self { drawn: Drawn::new(&sheet), sheet })
    }

    /// The bytes of the file, to save or to open again.
    #[wasm_bindgen(getter, unchecked_return_type = "Bytes")]
    pub fn bytes(&self) -> Vec<u8> {
        match &self.sheet {
            SharedSheet::Mesh(mesh) => mesh.bytes().to_vec(),
            SharedSheet::Field(field) => field.bytes().to_vec(),
        }
    }

    /// Kind of level: "mesh" or "field".
    #[wasm_bindgen(getter)]
    pub fn kind(&self) -> String {
        match &self.sheet {
            SharedSheet::Mesh(_) => "mesh".to_owned(),
            SharedSheet::Field(_) => "field".to_owned(),
        }
    }

    /// Number of triangles, including the triangles of a field's holes.
    #[wasm_bindgen(getter, js_name = triangleCount)]
    pub fn triangle_count(&self) -> usize {
        self.sheet.triangle_count()
    }

    /// Minimum x, y, z and maximum x, y, z of the vertices.
    #[wasm_bindgen(getter)]
    pub fn bounds(&self) -> Float64Array {
        let corners = match &self.sheet {
            SharedSheet::Mesh(mesh) => mesh.bounds().map(|corner| corner.as_dvec3()),
            SharedSheet::Field(field) => field.bounds(),
        };
        Float64Array::from(corners.map(|corner| corner.to_array()).concat().as_slice())
    }

    /// Findings of its bake to act on, a sentence each, as the file records them.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        match &self.sheet {
            SharedSheet::Mesh(mesh) => mesh.warnings().map(str::to_owned).collect(),
            SharedSheet::Field(field) => field.warnings().map(str::to_owned).collect(),
        }
    }

    /// Vertices to draw, three numbers each.
    pub fn vertices(&self) -> Vec<f32> {
        self.drawn.vertices.clone()
    }

    /// Triangles to draw: three indices of vertices each, without holes.
    pub fn triangles(&self) -> Vec<u32> {
        self.drawn.triangles.clone()
    }

    /// Edges of a class: two indices of vertices each. An edge that triangles share is listed once.
    ///
    /// # Errors
    /// There is no such class.
    pub fn edges(&self, class: &EdgeClassName) -> Result<Uint32Array, JsError> {
        let name = AsRef::<JsValue>::as_ref(class).as_string().unwrap_or_default();
        let edges = EdgeClass::ALL.iter().zip(&self.drawn.edges).find(|(class, _)| class.as_str() == name);
        let (_, edges) = edges.ok_or_else(|| {
            let known: Vec<&str> = EdgeClass::ALL.iter().map(|class| class.as_str()).collect();
            error(format!("there is no class {name} of edges: the classes are {}", known.join(", ")))
        })?;
        Ok(Uint32Array::from(edges.as_flattened()))
    }

    /// The level as a shape: for rays.
    pub fn shape(&self) -> Shape {
        Shape(SharedGeometry::Sheet(self.sheet.clone()))
    }

    /// When a body that starts at a pose and moves by `velocity` first meets the level, for t from
    /// 0 to `maxT`, infinite by default.
    ///
    /// # Errors
    /// Numbers are not finite.
    pub fn cast(
        &self,
        body: &Body,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] pose: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] velocity: &[f64],
        #[wasm_bindgen(js_name = maxT)] max_t: Option<f64>,
    ) -> Result<ImpactAnswer, JsError> {
        let (body, pose) = (geometry_of("body", body)?, pose_of(pose)?);
        let motion = Motion::new(vector_from("velocity", velocity)?).map_err(error)?;
        let usual = CastSettings::default();
        let settings = CastSettings { max_t: max_t.unwrap_or(usual.max_t), ..usual };
        let level = SharedGeometry::Sheet(self.sheet.clone());
        let found = query!(&level, &body, |a, b| hullmap::cast(&a, &b, pose, motion, &settings, &mut Cache::new()));
        Ok(Plain::from_answer(&found).done())
    }
}

/// First bytes of a height field.
const FIELD: &[u8] = b"hullfld";
