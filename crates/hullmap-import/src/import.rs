//! Import of a file as point sets: chooses the reader, and collects counts, notes and warnings.

use std::path::Path;

use hullmap_geometry::PointSet;
use rayon::prelude::*;

use crate::{
    collada, far,
    fault::{ImportError, LineFault, counted},
    foreign,
    format::Format,
    gltf,
    limits::Limits,
    materials::Materials,
    mesh::{Polygons, SourceMesh},
    msh, obj,
    options::{ImportOptions, Split, Vertices},
    placement, ply, point_sets,
    read::SourceFile,
    stl,
};

/// Result of an import.
#[derive(Debug)]
pub struct Imported {
    /// One set for each hull, in file order, not empty, with different names. Its origin is its
    /// frame's in the rotated and scaled source frame; 0 unless recentred.
    pub point_sets: Vec<PointSet>,
    /// Faces of each set, as indices into its points. Empty for a point cloud.
    pub faces: Vec<Polygons>,
    /// Materials of the faces of the file. Without a split, these are the faces of the only set.
    pub materials: Materials,
    /// Number of vertices in the file.
    pub vertex_count: usize,
    /// Number of vertices that no element references.
    pub unreferenced_count: usize,
    /// Number of selected points that equal an earlier one. The point sets keep them.
    pub duplicate_count: usize,
    /// Information for the user, a sentence each.
    pub notes: Vec<String>,
    /// Warnings for the user, a sentence each, with the remedy.
    pub warnings: Vec<String>,
}

impl Imported {
    /// Number of points in all sets. A vertex of two objects counts twice.
    pub fn point_count(&self) -> usize {
        self.point_sets.iter().map(|set| set.positions.len()).sum()
    }

    /// Triangulates the faces of each point set and stores the triangles in it, for a convex
    /// decomposition.
    pub fn give_triangles(&mut self) {
        for (set, faces) in self.point_sets.iter_mut().zip(&self.faces) {
            set.triangles = faces.triangles(&set.positions);
        }
    }
}

/// Imports a source file.
///
/// `file` is the name of the file in messages. `stem` is the name of objects without one, and of
/// the hull of a whole file. The extension of `path` selects the format, or else the first bytes.
/// Material files are not read.
///
/// # Errors
/// The first fault in the file, with its line or object, and the remedy.
///
/// # Complexity
/// O(bytes) for a file that does not repeat vertices, plus a sort of the points.
pub fn import(
    file: &str,
    stem: &str,
    path: &Path,
    source: &SourceFile,
    options: &ImportOptions,
    limits: &Limits,
) -> Result<Imported, ImportError> {
    let name = |LineFault { line, fault }| ImportError { file: file.to_owned(), line, fault };
    let is_double = placement::requires_double(options);
    let format = foreign::format_of(path, &source.bytes).map_err(|fault| name(fault.of_file()))?;
    let mesh = match format {
        Format::Obj => obj::read(&source.bytes, is_double, limits),
        Format::Gltf => {
            let reads_colliders = options.split == Split::Auto;
            gltf::read(&source.bytes, &source.beside, reads_colliders, limits).map(|(mesh, _)| mesh)
        }
        Format::Stl => stl::read(&source.bytes, is_double, limits),
        Format::Ply => ply::read(&source.bytes, is_double),
        Format::Collada => collada::read(&source.bytes, limits),
        Format::Msh => msh::read(&source.bytes),
    }
    .map_err(name)?;
    imported(file, stem, mesh, options, limits)
}

#[expect(clippy::indexing_slicing, reason = "readers reject references out of range")]
pub(crate) fn imported(
    file: &str,
    stem: &str,
    mut mesh: SourceMesh,
    options: &ImportOptions,
    limits: &Limits,
) -> Result<Imported, ImportError> {
    let name = |LineFault { line, fault }| ImportError { file: file.to_owned(), line, fault };
    let vertex_count = mesh.positions.len();
    let has_elements = mesh.has_elements();
    let mut referenced = vec![false; vertex_count];
    for &vertex in mesh.faces.corners.iter().chain(&mesh.loose) {
        referenced[vertex as usize] = true;
    }
    let unreferenced_count = referenced.iter().filter(|&&is| !is).count();
    let sets = point_sets::point_sets(&mut mesh, &referenced, stem, options, limits);
    let sets = sets.map_err(|fault| name(fault.of_file()))?;
    drop((mesh.positions, referenced));
    let duplicate_count = count_duplicates(vertex_count, &sets.point_sets);

    let mut notes = sets.notes;
    if !has_elements {
        notes.push("the file has no elements, so all vertices are used (a point cloud)".to_owned());
    } else if unreferenced_count > 0 {
        let fate = match options.vertices {
            Vertices::Referenced => "left out (--set vertices=all includes them)",
            Vertices::All => "included",
        };
        notes.push(format!("{} that no element references, {fate}", counted(unreferenced_count, "vertex", "vertices")));
    }
    if duplicate_count > 0 && mesh.may_share_vertices {
        notes.push(format!("{} an earlier one", counted(duplicate_count, "point equals", "points equal")));
    }
    notes.append(&mut mesh.notes);
    let mut warnings = sets.warnings;
    warnings.append(&mut mesh.warnings);
    warnings.extend(far::far_away_warning(&sets.point_sets));
    Ok(Imported {
        point_sets: sets.point_sets,
        faces: sets.faces,
        materials: mesh.materials,
        vertex_count,
        unreferenced_count,
        duplicate_count,
        notes,
        warnings,
    })
}

/// Counts -0 as +0, and a vertex of two sets once.
#[expect(clippy::indexing_slicing, reason = "source vertices are indices below `vertex_count`")]
fn count_duplicates(vertex_count: usize, sets: &[PointSet]) -> usize {
    let mut is_counted = vec![false; vertex_count];
    let mut keys: Vec<[u32; 3]> = Vec::new();
    keys.reserve_exact(sets.iter().map(|set| set.positions.len()).sum::<usize>().min(vertex_count));
    for set in sets {
        for (position, &vertex) in set.positions.iter().zip(&set.source_vertices) {
            if !std::mem::replace(&mut is_counted[vertex as usize], true) {
                // Adding +0 turns -0 into +0 and changes no other number.
                keys.push(position.map(|x| (x + 0.0).to_bits()));
            }
        }
    }
    keys.par_sort_unstable();
    let count = keys.len();
    keys.dedup();
    count - keys.len()
}
