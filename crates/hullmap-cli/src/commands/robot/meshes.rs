//! Mesh files of a robot: read once each, for what is drawn, and for what engines take in their
//! place, the convex hull.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use hullmap::Pack;
use hullmap_bake::fit::fits;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, hull, write_pack};
use hullmap_import::{self as import, ImportOptions, Limits, ReadError, Split};
use hullmap_report::DisplayMesh;
use hullmap_robot::{MeshUse, Submesh};

use crate::options::OptionLayer;
use crate::pack_file::shown_from;
use crate::source_mesh::display_mesh;

/// A mesh file.
pub struct Mesh {
    /// What is drawn.
    pub display: DisplayMesh,
    /// The point of the file that became the origin: the centre of a submesh.
    pub moved: DVec3,
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
    known: BTreeMap<(PathBuf, Option<Submesh>), Option<Arc<Mesh>>>,
    /// Why files could not be read.
    pub faults: Vec<String>,
}

impl Meshes {
    /// No file yet.
    pub fn new(limits: Limits) -> Self {
        Self { limits, known: BTreeMap::new(), faults: Vec::new() }
    }

    /// A mesh; `None` if it cannot be read, which is a fault.
    pub fn get(&mut self, mesh: &MeshUse) -> Option<Arc<Mesh>> {
        let file = mesh.file.as_ref().ok()?;
        let key = (file.clone(), mesh.submesh.clone());
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let read = read(file, mesh.submesh.as_ref(), &self.limits);
        let read = read.map_err(|fault| self.faults.push(fault)).ok().map(Arc::new);
        self.known.insert(key, read.clone());
        read
    }
}

fn read(file: &Path, submesh: Option<&Submesh>, limits: &Limits) -> Result<Mesh, String> {
    let path = if file.is_absolute() { shown_from(file, Path::new(".")) } else { file.to_owned() };
    let name = path.display().to_string();
    let source = import::read(&name, file, limits).map_err(|error| match error {
        ReadError::Io(error) => format!("{name}: cannot read: {error}"),
        ReadError::Import(error) => error.to_string(),
    })?;
    let split = if submesh.is_some() { Split::Object } else { Split::None };
    let options = ImportOptions { split, ..OptionLayer::default().resolve().import() };
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let mut imported =
        import::import(&name, &stem, file, &source, &options, limits).map_err(|error| error.to_string())?;
    imported.give_triangles();
    let sets = imported.point_sets.into_iter().zip(imported.faces);
    let meant = sets.into_iter().find(|(set, _)| submesh.is_none_or(|submesh| submesh.name == set.name));
    let Some((mut points, faces)) = meant else {
        return Err(format!("{name}: it has no mesh `{}`", submesh.map_or("", |submesh| submesh.name.as_str())));
    };
    let mut moved = DVec3::ZERO;
    if submesh.is_some_and(|submesh| submesh.is_centered) {
        let corner = |fold: fn(f64, f64) -> f64, start: f64| {
            let axis = |axis: usize| points.positions.iter().map(|p| f64::from(p[axis])).fold(start, fold);
            DVec3::from_array([0, 1, 2].map(axis))
        };
        moved = (corner(f64::min, f64::INFINITY) + corner(f64::max, f64::NEG_INFINITY)) / 2.0;
        for position in &mut points.positions {
            *position = (DVec3::from_array(position.map(f64::from)) - moved).as_vec3().to_array();
        }
    }
    let display = display_mesh(&points.positions, &faces);
    Ok(Mesh { display, moved, points, hull: OnceLock::new(), protrusion: OnceLock::new() })
}
