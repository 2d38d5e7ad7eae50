//! Mesh files of a robot, each read once: the mesh is drawn, and engines use its convex hull.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use hullmap::Pack;
use hullmap_bake::fit::fits;
use hullmap_bake::{IndexKind, PointSet, hull};
use hullmap_import::Limits;
use hullmap_planning::{MeshPoints, hull_of, imported, read_file};
use hullmap_report::DisplayMesh;
use hullmap_robot::{MeshUse, Submesh};

use crate::source_mesh::display_mesh;
use hullmap_pipeline::pack_file::shown_from;

pub struct Mesh {
    pub display: DisplayMesh,
    /// The point of the file that became the origin: the centre of a submesh.
    pub moved: DVec3,
    points: PointSet,
    hull: OnceLock<Result<Arc<Pack>, String>>,
    protrusion: OnceLock<Option<f64>>,
}

impl Mesh {
    pub fn hull(&self) -> Result<&Arc<Pack>, &String> {
        self.hull.get_or_init(|| hull_of(&self.points, IndexKind::None)).as_ref()
    }

    /// Diagonal of its bounds, in the unit of the mesh.
    pub fn diagonal(&self) -> f64 {
        self.points.diagonal()
    }

    /// Bound on how far the hull lies outside of the solid that the mesh bounds, in the unit of the
    /// mesh; `None` if it cannot be measured.
    pub fn protrusion(&self) -> Option<f64> {
        *self.protrusion.get_or_init(|| {
            let hull = hull::build(&self.points).ok()?;
            Some(fits(&self.points, &[&hull], None)?.first()?.protrusion)
        })
    }

    pub fn is_concave(&self) -> bool {
        self.protrusion().is_some_and(|protrusion| protrusion > CONCAVE * self.points.diagonal())
    }
}

/// Protrusion of a hull, relative to the diagonal of its mesh, above which the mesh is concave.
const CONCAVE: f64 = 0.02;

pub struct Meshes {
    limits: Limits,
    known: BTreeMap<(PathBuf, Option<Submesh>), Option<Arc<Mesh>>>,
    pub faults: Vec<String>,
}

impl Meshes {
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
    let source = read_file(&name, file, limits)?;
    let MeshPoints { points, faces, moved } = imported(&name, file, &source, submesh, limits)?;
    let display = display_mesh(&points.positions, &faces);
    Ok(Mesh { display, moved, points, hull: OnceLock::new(), protrusion: OnceLock::new() })
}
