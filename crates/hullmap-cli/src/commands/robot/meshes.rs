//! Mesh files of a robot: read once each, for what is drawn, and for what engines take in their
//! place, the convex hull.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use hullmap::Pack;
use hullmap_bake::fit::fits;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, hull, write_pack};
use hullmap_import::{self as import, Limits, ReadError};
use hullmap_report::DisplayMesh;

use crate::options::OptionLayer;
use crate::pack_file::shown_from;
use crate::source_mesh::display_mesh;

/// A mesh file.
pub struct Mesh {
    /// What is drawn.
    pub display: DisplayMesh,
    points: PointSet,
    hull: OnceLock<Result<Arc<Pack>, String>>,
    protrusion: OnceLock<Option<f64>>,
}

impl Mesh {
    /// The convex hull, as a pack of one.
    pub fn hull(&self) -> Result<&Arc<Pack>, &String> {
        let bake = || {
            let baked = bake_hull(&self.points, IndexKind::None).map_err(|error| error.to_string())?;
            let bytes = write_pack(&[baked], &SourceRecord::default()).map_err(|error| error.to_string())?;
            Pack::from_bytes(&bytes).map(Arc::new).map_err(|error| error.to_string())
        };
        self.hull.get_or_init(bake).as_ref()
    }

    /// Bound on how far the hull lies outside of the solid that the mesh bounds, in the unit of the
    /// mesh; `None` if it cannot be measured.
    pub fn protrusion(&self) -> Option<f64> {
        *self.protrusion.get_or_init(|| {
            let hull = hull::build(&self.points).ok()?;
            Some(fits(&self.points, &[&hull], None)?.first()?.protrusion)
        })
    }
}

/// The mesh files that were read.
pub struct Meshes {
    limits: Limits,
    known: BTreeMap<PathBuf, Option<Arc<Mesh>>>,
    /// Why files could not be read.
    pub faults: Vec<String>,
}

impl Meshes {
    /// No file yet.
    pub fn new(limits: Limits) -> Self {
        Self { limits, known: BTreeMap::new(), faults: Vec::new() }
    }

    /// The mesh of a file; `None` if it cannot be read, which is a fault.
    pub fn get(&mut self, file: &Path) -> Option<Arc<Mesh>> {
        if let Some(known) = self.known.get(file) {
            return known.clone();
        }
        let read = read(file, &self.limits).map_err(|fault| self.faults.push(fault)).ok().map(Arc::new);
        self.known.insert(file.to_owned(), read.clone());
        read
    }
}

fn read(file: &Path, limits: &Limits) -> Result<Mesh, String> {
    let path = if file.is_absolute() { shown_from(file, Path::new(".")) } else { file.to_owned() };
    let name = path.display().to_string();
    let source = import::read(&name, file, limits).map_err(|error| match error {
        ReadError::Io(error) => format!("{name}: cannot read: {error}"),
        ReadError::Import(error) => error.to_string(),
    })?;
    let options = OptionLayer::default().resolve().import();
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let mut imported =
        import::import(&name, &stem, file, &source, &options, limits).map_err(|error| error.to_string())?;
    imported.give_triangles();
    let (points, faces) = match (imported.point_sets.pop(), imported.faces.pop()) {
        (Some(points), Some(faces)) => (points, faces),
        _ => return Err(format!("{name}: it has no points")),
    };
    let display = display_mesh(&points.positions, &faces);
    Ok(Mesh { display, points, hull: OnceLock::new(), protrusion: OnceLock::new() })
}
