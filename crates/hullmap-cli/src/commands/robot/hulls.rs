//! The hulls of a pack, as meshes and as shapes.

use std::path::PathBuf;
use std::sync::Arc;

use hullmap::{MassProperties, Pack};
use hullmap_import::UpAxis;

use super::files::Output;
use crate::jobs::Job;
use crate::mesh_file::{body::Body, obj};
use crate::open::open_pack;
use crate::outcome::Failure;

/// The hulls of a pack.
pub struct Hulls {
    /// The pack's file.
    pub file: PathBuf,
    /// The pack.
    pub pack: Arc<Pack>,
    /// Absolute paths of the meshes, and their bytes.
    pub files: Vec<Output>,
    /// Number of vertices, over all hulls.
    pub vertices: usize,
    /// Whether the mesh was cut into parts.
    pub is_parts: bool,
    /// Bound on the protrusion of the parts, in units of the mesh.
    pub protrusion: Option<f64>,
    /// Bound on how far the surface lies outside of the parts, in units of the mesh.
    pub uncovered: Option<f64>,
    /// Whether a hull has no volume.
    pub is_flat: bool,
    /// Of the mesh, at density 1; `None` if it is not closed.
    pub mass: Option<MassProperties>,
}

/// Reads the pack of a job.
///
/// # Errors
/// The pack cannot be read.
pub fn read_hulls(job: &Job) -> Result<Hulls, Failure> {
    let pack = open_pack(&job.output)?;
    let stem = job.output.with_extension("");
    let stem = stem.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_parts = pack.hulls().any(|hull| hull.part_count() > 1);
    let (mut files, mut vertices, mut is_flat) = (Vec::new(), 0, false);
    for (index, hull) in pack.hulls().enumerate() {
        let name = if is_parts { format!("{stem}_part_{index:02}.obj") } else { format!("{stem}_hull.obj") };
        is_flat |= hull.rank() < 3;
        vertices += hull.vertex_count();
        let mut body = Body::new(&hull, UpAxis::Keep);
        body.name = name.trim_end_matches(".obj").to_owned();
        files.push(Output { path: job.output.with_file_name(name), bytes: obj::write(&[body], false) });
    }
    let worst = |bounds: Vec<Option<f64>>| {
        bounds.into_iter().collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max))
    };
    let protrusion = worst(pack.hulls().map(|hull| hull.protrusion()).collect());
    let uncovered = worst(pack.hulls().map(|hull| hull.uncovered()).collect());
    let mass = pack.hulls().next().and_then(|hull| hull.mesh_mass_properties(1.0));
    let file = job.output.clone();
    Ok(Hulls { file, pack: Arc::new(pack), files, vertices, is_parts, protrusion, uncovered, is_flat, mass })
}
