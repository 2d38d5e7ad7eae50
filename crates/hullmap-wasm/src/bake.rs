//! From a mesh to a pack or a level: the bytes of a mesh file, or arrays. The command's own code
//! bakes.

use std::path::Path;

use hullmap_import::{Imported, MeshArrays, Polygons, SourceFile};
use hullmap_pipeline::triangle_mesh::BakedTriangles;
use hullmap_pipeline::{BakedPack, InMemoryError, Progress, bake_arrays, bake_source};
use js_sys::{Function, JSON};
use wasm_bindgen::prelude::*;

use crate::input::{bytes_of, error, rows_of, text_of};
use crate::options::{BakeOptions, Options, in_javascript};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** The part of a `BufferAttribute` or an `InterleavedBufferAttribute` of three.js that is read. */
export interface Attribute {
    readonly count: number;
    /** 3 for positions, 1 for indices. */
    readonly itemSize: number;
    getX(index: number): number;
    getY(index: number): number;
    getZ(index: number): number;
}
"#;

/// A baked mesh: the pack, the mesh to draw, and the findings of the import and the bake.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Baked {
    pack: BakedPack,
    positions: Vec<f32>,
    triangles: Vec<u32>,
}

#[wasm_bindgen]
impl Baked {
    /// Bytes of the pack, to open or to save as a `.hullmap` file.
    #[wasm_bindgen(getter, unchecked_return_type = "Bytes")]
    pub fn pack(&self) -> Vec<u8> {
        self.pack.bytes.clone()
    }

    /// Points of the source mesh, three numbers each, in the frame of the hulls.
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f32> {
        self.positions.clone()
    }

    /// Triangles of the source mesh: three indices of points each. Empty for a point cloud.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> Vec<u32> {
        self.triangles.clone()
    }

    /// Findings of interest, a sentence each.
    #[wasm_bindgen(getter)]
    pub fn notes(&self) -> Vec<String> {
        sentences(&self.pack.notes)
    }

    /// Findings to act on, a sentence each.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        sentences(&self.pack.warnings)
    }
}

/// Bakes a mesh file: OBJ, STL, PLY, COLLADA, MSH, GLB, or glTF with its buffers inside.
///
/// `file` is the name of the file, whose extension selects the format. The pack has the same bytes
/// as the pack that `bake build` saves in the folder of the mesh, with the same options.
///
/// `onProgress` is called with the share that is done, from 0 to 1, at most at each hundredth, and
/// a few seconds apart in long searches. If it returns `false` or throws, the bake then ends with
/// an error whose message ends with `cancelled`.
///
/// # Errors
/// An option is wrong, the file is faulty, or a hull cannot be built. The message names the fault
/// and the remedy.
#[wasm_bindgen]
pub fn bake(
    #[wasm_bindgen(unchecked_param_type = "string")] file: &JsValue,
    #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    #[wasm_bindgen(unchecked_optional_param_type = "BakeOptions | null")] options: Option<BakeOptions>,
    #[wasm_bindgen(js_name = onProgress, unchecked_optional_param_type = "OnProgress | null")] listener: Option<
        Function,
    >,
) -> Result<Baked, JsError> {
    let options = Options::read(options.as_ref())?;
    if options.name().is_some() {
        return Err(error("option name: the hulls of a file have its names; leave out the option"));
    }
    let progress = progress_for(listener);
    let (file, source) = source_of(file, bytes)?;
    baked(bake_source(Path::new(&file), &source, &options.pairs(), progress.whole()))
}

/// Bakes a mesh from arrays, or from the attributes of a geometry of three.js, for instance
/// `bakeMesh(geometry.attributes.position, geometry.index)`. Pass attributes themselves: their
/// arrays may be normalised, or interleave normals.
///
/// `positions` has three numbers for each vertex; they are rounded to 32-bit floats once. `indices`
/// has three indices of vertices for each triangle. Without it, the mesh is a point cloud, which
/// cannot be decomposed: of a geometry without an index, pass 0, 1, 2 and so on. The option `name`
/// is the name of the hull, "mesh" by default. `onProgress` is described at `bake`.
///
/// # Errors
/// An array or an option is wrong, or a hull cannot be built. The message names the fault and the
/// remedy.
#[wasm_bindgen(js_name = bakeMesh)]
pub fn bake_mesh(
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number> | Attribute")] positions: &[f64],
    // As f64, because a typed array of u32 would make an index out of −1, 0.5 or NaN.
    #[wasm_bindgen(unchecked_optional_param_type = "ArrayLike<number> | Attribute | null")] indices: Option<Vec<f64>>,
    #[wasm_bindgen(unchecked_optional_param_type = "BakeOptions | null")] options: Option<BakeOptions>,
    #[wasm_bindgen(js_name = onProgress, unchecked_optional_param_type = "OnProgress | null")] listener: Option<
        Function,
    >,
) -> Result<Baked, JsError> {
    let options = Options::read(options.as_ref())?;
    let name = options.name().unwrap_or("mesh");
    let faces = match indices {
        Some(indices) => triangles(&indices, positions.len() / 3)?,
        None => Polygons::default(),
    };
    let mesh = MeshArrays { name: String::new(), positions: rows_of("positions", positions)?.to_vec(), faces };
    let progress = progress_for(listener);
    baked(bake_arrays(name, vec![mesh], &options.pairs(), progress.whole()))
}

/// A baked level, which keeps its triangles.
#[wasm_bindgen]
#[derive(Debug)]
pub struct BakedLevel(BakedTriangles);

#[wasm_bindgen]
impl BakedLevel {
    /// Bytes of the level, to open as a `Level` or to save as a `.hullmesh` file.
    #[wasm_bindgen(getter, unchecked_return_type = "Bytes")]
    pub fn bytes(&self) -> Vec<u8> {
        self.0.bytes.clone()
    }

    /// Findings of interest, a sentence each.
    #[wasm_bindgen(getter)]
    pub fn notes(&self) -> Vec<String> {
        sentences(&self.0.notes)
    }

    /// Findings to act on, a sentence each. The file keeps them.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        sentences(&self.0.warnings)
    }
}

/// Bakes a mesh file, and keeps its triangles: OBJ, STL, PLY, COLLADA, MSH, GLB, or glTF with its
/// buffers inside. The options are `unitScale`, `upAxis` and `recentre`.
///
/// The level has the bytes that `bake build --keep-triangles` writes into the folder of the mesh.
///
/// # Errors
/// An option is wrong, the file is faulty, or it has no triangles.
#[wasm_bindgen(js_name = bakeLevel)]
pub fn bake_level(
    #[wasm_bindgen(unchecked_param_type = "string")] file: &JsValue,
    #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    #[wasm_bindgen(unchecked_optional_param_type = "Pick<BakeOptions, 'unitScale' | 'upAxis' | 'recentre'> | null")]
    options: Option<BakeOptions>,
) -> Result<BakedLevel, JsError> {
    let options = Options::read(options.as_ref())?;
    let (file, source) = source_of(file, bytes)?;
    let baked = hullmap_pipeline::bake_level(Path::new(&file), &source, &options.pairs());
    baked.map(BakedLevel).map_err(fault)
}

/// The Gauss map of a hull of a pack with the cells of its index, as the script of hullmap's pages
/// draws it: `faces`, the layout of the cube's faces, and `map`. `resolution` is the number of
/// pixels along a face's edge, 32 to 256.
///
/// # Errors
/// The bytes are not a pack, or it has no such hull.
#[wasm_bindgen(js_name = gaussMap)]
pub fn gauss_map(
    #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] pack: &JsValue,
    hull: usize,
    resolution: u32,
) -> Result<JsValue, JsError> {
    let pack = hullmap::Pack::from_bytes(&bytes_of(pack)?).map_err(error)?;
    let text = hullmap_report::gauss_map_json(&pack, hull, resolution);
    let text = text.ok_or_else(|| error(format!("there is no hull {hull}: the pack has {}", pack.hull_count())))?;
    JSON::parse(&text).map_err(|_| error("internal error: invalid JSON; please report it"))
}

/// The name of a mesh file and its contents.
fn source_of(file: &JsValue, bytes: &JsValue) -> Result<(String, SourceFile), JsError> {
    let file = text_of(file, "the name of a mesh file, such as \"rock.obj\", and then its bytes")?;
    Ok((file, SourceFile::alone(bytes_of(bytes)?)))
}

/// A progress that calls a listener.
fn progress_for(listener: Option<Function>) -> Progress {
    listener.map_or_else(Progress::default, |listener| {
        Progress::reported_to(move |share| {
            listener.call1(&JsValue::NULL, &share.into()).is_ok_and(|answer| answer != JsValue::FALSE)
        })
    })
}

/// Faces of a triangle mesh, whose indices are checked.
fn triangles(indices: &[f64], vertex_count: usize) -> Result<Polygons, JsError> {
    if !indices.len().is_multiple_of(3) {
        let found = indices.len();
        return Err(error(format!(
            "indices: a triangle has three indices, found {found} in all: pass whole triangles"
        )));
    }
    let corner = |(at, &index): (usize, &f64)| {
        if index >= 0.0 && index < vertex_count as f64 && index.fract() == 0.0 {
            return Ok(index as u32);
        }
        let expected = format!("a whole number from 0, below the number of vertices, {vertex_count}");
        Err(error(format!("indices[{at}]: expected {expected}, found {index}")))
    };
    let corners = indices.iter().enumerate().map(corner).collect::<Result<Vec<u32>, JsError>>()?;
    // A mesh has fewer than 2^32 corners: WebAssembly has no room for more.
    let ends = (3..=corners.len() as u32).step_by(3).collect();
    Ok(Polygons { corners, ends })
}

fn baked(result: Result<(BakedPack, Imported), InMemoryError>) -> Result<Baked, JsError> {
    let (pack, mut imported) = result.map_err(fault)?;
    imported.give_triangles();
    // The points and triangles of all point sets, one after the other.
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for set in &imported.point_sets {
        // A pack is below 2 GiB, so its points are fewer than 2^32.
        let first = (positions.len() / 3) as u32;
        positions.extend(set.positions.iter().flatten());
        triangles.extend(set.triangles.iter().flatten().map(|corner| first + corner));
    }
    Ok(Baked { pack, positions, triangles })
}

/// Messages with the options by their names in JavaScript.
fn sentences(messages: &[String]) -> Vec<String> {
    messages.iter().map(|message| in_javascript(message, false)).collect()
}

fn fault(fault: InMemoryError) -> JsError {
    error(in_javascript(&fault.to_string(), matches!(fault, InMemoryError::Option(_))))
}
