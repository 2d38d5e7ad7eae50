//! From the bytes of a mesh file to a pack: import, hulls, indices, as the command `bake build`
//! does.

use std::path::Path;

use hullmap_bake::{SourceRecord, bake_hull, bake_simplified_hull, write_pack};
use hullmap_import::{Imported, Limits, SourceFile, import};
use wasm_bindgen::prelude::*;

use crate::object::error;
use crate::options::{BakeOptions, Options};

/// A baked mesh: the pack, the mesh to draw, and what the import noticed.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Baked {
    pack: Vec<u8>,
    positions: Vec<f32>,
    triangles: Vec<u32>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

#[wasm_bindgen]
impl Baked {
    /// Bytes of the pack, to open or to save as a `.hullmap` file.
    #[wasm_bindgen(getter)]
    pub fn pack(&self) -> Vec<u8> {
        self.pack.clone()
    }

    /// Points of the source mesh, three numbers each.
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
        self.notes.clone()
    }

    /// Findings to act on, a sentence each.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}

/// Bakes a mesh file: OBJ, STL, PLY, GLB, or glTF with its buffers inside.
///
/// `file` is the name of the file, whose extension selects the format. The pack has the same bytes
/// as that of `bake build` with the same options, saved in the folder of the mesh.
///
/// # Errors
/// An option is wrong, the file is faulty, or a hull cannot be built. The message names the fault
/// and the remedy.
#[wasm_bindgen]
pub fn bake(file: &str, bytes: Vec<u8>, options: Option<BakeOptions>) -> Result<Baked, JsError> {
    let options = Options::read(options.as_ref())?;
    let path = Path::new(file);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let source = SourceFile::alone(bytes);
    let mut imported = import(file, &stem, path, &source, &options.import(), &Limits::DEFAULT).map_err(error)?;
    let mut hulls = Vec::with_capacity(imported.point_sets.len());
    for points in &imported.point_sets {
        let baked = match options.limit() {
            None => bake_hull(points, options.index),
            Some(limit) => bake_simplified_hull(points, limit, options.index),
        };
        hulls.push(baked.map_err(|fault| error(format!("{file}: hull {}: {fault}", points.name)))?);
    }
    let record = SourceRecord { path: file.to_owned(), hash: source.hash, options: options.record() };
    let pack = write_pack(&hulls, &record).map_err(|fault| error(format!("{file}: {fault}")))?;
    imported.give_triangles();
    let (positions, triangles) = mesh(&imported);
    Ok(Baked { pack, positions, triangles, notes: imported.notes, warnings: imported.warnings })
}

/// The points and triangles of all point sets, one after the other.
fn mesh(imported: &Imported) -> (Vec<f32>, Vec<u32>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for set in &imported.point_sets {
        // A pack is below 2 GiB, so its points are fewer than 2^32.
        let first = (positions.len() / 3) as u32;
        positions.extend(set.positions.iter().flatten());
        triangles.extend(set.triangles.iter().flatten().map(|corner| first + corner));
    }
    (positions, triangles)
}
