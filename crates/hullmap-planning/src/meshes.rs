//! The hulls of the meshes that a description names: from packs, or built from the mesh files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use hullmap::Pack;
use hullmap_bake::{IndexKind, PointSet};
use hullmap_import::{self as import, ImportOptions, Imported, Limits, ReadError, SourceFile, Split};
use hullmap_robot::{MeshUse, Submesh, Unresolved};

use crate::PlanningError;
use crate::convex::hull_of;

/// The source of the hulls of meshes.
///
/// The pack of `meshes/hand.stl` is the file `hand.hullmap` in one of the folders, baked from that
/// mesh. Otherwise, the mesh is read, and replaced by its convex hull.
#[derive(Default)]
pub struct Packs {
    /// Folders of packs, the first one first.
    pub folders: Vec<PathBuf>,
    /// Limits of the meshes that are read.
    pub limits: Limits,
    known: BTreeMap<(PathBuf, Option<Submesh>), Arc<Pack>>,
}

impl Packs {
    /// Packs in these folders.
    ///
    /// # Errors
    /// A folder does not exist: [`PlanningError::NoSuchFolder`].
    pub fn in_folders(folders: Vec<PathBuf>) -> Result<Self, PlanningError> {
        match folders.iter().find(|folder| !folder.is_dir()) {
            Some(missing) => Err(PlanningError::NoSuchFolder { folder: missing.clone() }),
            None => Ok(Self { folders, ..Self::default() }),
        }
    }

    /// The hulls of a mesh.
    ///
    /// # Errors
    /// The file of the mesh or its pack cannot be read, or the pack is of another mesh.
    pub fn hulls(&mut self, mesh: &MeshUse) -> Result<Arc<Pack>, String> {
        let file = match &mesh.file {
            Ok(file) => file,
            Err(Unresolved::Inline(own)) => {
                let points = PointSet::of_positions(own.vertices.clone());
                return hull_of(&points, IndexKind::Tree).map_err(|error| format!("mesh `{}`: {error}", own.name));
            }
            Err(Unresolved::Remote) => {
                return Err(format!("`{}` is on another machine; copy it beside the description", mesh.written));
            }
            Err(Unresolved::Failed(cause)) => return Err(cause.clone()),
        };
        let key = (file.clone(), mesh.submesh.clone());
        if let Some(known) = self.known.get(&key) {
            return Ok(Arc::clone(known));
        }
        let name = file.display().to_string();
        let source = read_file(&name, file, &self.limits)?;
        let pack = match self.pack_of(file).filter(|_| mesh.submesh.is_none()) {
            Some(path) => open(&path, &name, &source)?,
            None => {
                let points = imported(&name, file, &source, mesh.submesh.as_ref(), &self.limits)?.points;
                hull_of(&points, IndexKind::Tree).map_err(|error| format!("{name}: {error}"))?
            }
        };
        self.known.insert(key, Arc::clone(&pack));
        Ok(pack)
    }

    fn pack_of(&self, file: &Path) -> Option<PathBuf> {
        let name = Path::new(file.file_stem()?).with_extension("hullmap");
        self.folders.iter().map(|folder| folder.join(&name)).find(|path| path.is_file())
    }
}

fn open(path: &Path, name: &str, source: &SourceFile) -> Result<Arc<Pack>, String> {
    let pack = Pack::open(path).map_err(|error| error.to_string())?;
    if pack.header().source_hash != source.hash {
        let pack = path.display();
        return Err(format!("{pack} was not baked from {name}, or the mesh has changed since; bake it again"));
    }
    Ok(Arc::new(pack))
}

/// The bytes of a mesh file, and of the files that it refers to. `name` is its name in messages.
///
/// # Errors
/// It cannot be read.
pub fn read_file(name: &str, file: &Path, limits: &Limits) -> Result<SourceFile, String> {
    import::read(name, file, limits).map_err(|error| match error {
        ReadError::Io(error) => format!("{name}: cannot read: {error}"),
        ReadError::Import(error) => error.to_string(),
    })
}

/// A mesh of a file.
pub struct MeshPoints {
    /// Its points.
    pub points: PointSet,
    /// Its faces.
    pub faces: import::Polygons,
    /// The point of the file that became the origin: the centre of a submesh.
    pub moved: DVec3,
}

/// The mesh of a file, or the requested submesh of it.
///
/// # Errors
/// The file is invalid, or has no such submesh.
pub fn imported(
    name: &str,
    file: &Path,
    source: &SourceFile,
    submesh: Option<&Submesh>,
    limits: &Limits,
) -> Result<MeshPoints, String> {
    let split = if submesh.is_some() { Split::Object } else { Split::None };
    let options = ImportOptions { split, ..ImportOptions::DEFAULT };
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let mut imported: Imported =
        import::import(name, &stem, file, source, &options, limits).map_err(|error| error.to_string())?;
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
    Ok(MeshPoints { points, faces, moved })
}
