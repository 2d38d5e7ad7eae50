//! A source file's bytes to the point sets that hulls are built of, with the number of each point's vertex in the file.
//!
//! 1. [`read()`] takes the file, and the buffers beside a glTF file, into memory.
//! 2. `obj`, `gltf`, `stl` or `ply` makes a `mesh` of it: vertices, elements, objects. `limits` bounds them.
//! 3. `point_sets` chooses the points, cuts them into objects (by `conventions`, with `--split auto`), and has
//!    `placement` turn, scale and move them.
//! 4. `far` warns of points that f32 cannot tell apart where they are.
//!
//! | format | vertices, as they are numbered | objects |
//! |---|---|---|
//! | OBJ | `v` lines | what `o` lines open |
//! | glTF, GLB | instances of positions, node after node | nodes that show a mesh |
//! | STL | distinct positions, by first appearance | `solid`s |
//! | PLY | elements `vertex` | the file |

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]

mod conventions;
mod coordinate;
mod ears;
mod far;
mod fault;
mod format;
mod gltf;
mod limits;
mod mesh;
mod obj;
mod options;
mod placement;
mod ply;
mod point_sets;
mod read;
mod stl;
#[cfg(test)]
mod tests;
mod tokens;

use std::path::Path;

use hullmap_bake::PointSet;
use rayon::prelude::*;

pub use far::far_away;
pub use fault::ImportError;
pub use format::{EXTENSIONS, NAMES, is_buffer, is_source};
pub use limits::Limits;
pub use mesh::Polygons;
pub use options::{ImportOptions, Split, UpAxis, Vertices};
pub use read::{ReadError, SourceFile, buffers_of, read};

use fault::LineFault;
use format::Format;

/// What came out of a source file.
#[derive(Debug)]
pub struct Imported {
    /// One set for each hull, in file order, none of them empty, all with different names. Their origin is that of the
    /// points' frame in the source's frame, turned and scaled as the points are; 0 unless recentred.
    pub point_sets: Vec<PointSet>,
    /// For each set the faces over it, by the numbers of its own points; none in a point cloud.
    pub faces: Vec<Polygons>,
    /// Number of vertices in the file.
    pub vertex_count: usize,
    /// Number of vertices that no element references.
    pub unreferenced_count: usize,
    /// Number of chosen points that an earlier one already equals. They are kept: hulls are of all points.
    pub duplicate_count: usize,
    /// What a user may want to know, a sentence each.
    pub notes: Vec<String>,
    /// What a user should look at, a sentence each, with the remedy.
    pub warnings: Vec<String>,
}

impl Imported {
    /// Points over all sets; a vertex that two objects reference counts twice.
    pub fn point_count(&self) -> usize {
        self.point_sets.iter().map(|set| set.positions.len()).sum()
    }

    /// Gives each point set the triangles of its faces, for a decomposition.
    pub fn give_triangles(&mut self) {
        for (set, faces) in self.point_sets.iter_mut().zip(&self.faces) {
            set.triangles = faces.triangles(&set.positions);
        }
    }
}

/// Imports a source file.
///
/// `file` is the name to use in messages; `stem` names the hull of what belongs to no named object; `path` says the
/// format, by its extension. Material files are neither needed nor read.
///
/// # Errors
/// The first fault in the file, with file, line or object, what was found and what to do about it.
///
/// # Complexity
/// O(bytes).
#[expect(clippy::indexing_slicing, reason = "every reader lets through only references to vertices that are there")]
pub fn import(
    file: &str,
    stem: &str,
    path: &Path,
    source: &SourceFile,
    options: &ImportOptions,
    limits: &Limits,
) -> Result<Imported, ImportError> {
    let name = |LineFault { line, fault }| ImportError { file: file.to_owned(), line, fault };
    let wants_double = placement::wants_double(options);
    let mut mesh = match Format::of(path, &source.bytes) {
        Format::Obj => obj::read(&source.bytes, wants_double, limits),
        Format::Gltf => gltf::read(&source.bytes, &source.beside, limits),
        Format::Stl => stl::read(&source.bytes, wants_double, limits),
        Format::Ply => ply::read(&source.bytes, wants_double),
    }
    .map_err(name)?;

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
        notes.push("no elements, so every vertex counts (a point cloud)".to_owned());
    } else if unreferenced_count > 0 {
        let fate = match options.vertices {
            Vertices::Referenced => "left out (--vertices all takes them)",
            Vertices::All => "taken too",
        };
        notes.push(format!("{} that no element references, {fate}", count(unreferenced_count, "vertex", "vertices")));
    }
    if duplicate_count > 0 && mesh.may_share_vertices {
        notes.push(format!("{} an earlier one", count(duplicate_count, "point equals", "points equal")));
    }
    notes.append(&mut mesh.notes);
    let mut warnings = sets.warnings;
    warnings.append(&mut mesh.warnings);
    warnings.extend(sets.point_sets.iter().filter_map(|set| far_away(&set.name, &set.positions)));
    Ok(Imported {
        point_sets: sets.point_sets,
        faces: sets.faces,
        vertex_count,
        unreferenced_count,
        duplicate_count,
        notes,
        warnings,
    })
}

/// `1 vertex`, `2 vertices`.
fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// Chosen vertices whose point an earlier chosen vertex has; the two zeros count as equal. A vertex of two sets counts
/// once.
#[expect(clippy::indexing_slicing, reason = "points are taken by the numbers of vertices, below `vertex_count`")]
fn count_duplicates(vertex_count: usize, sets: &[PointSet]) -> usize {
    let mut is_counted = vec![false; vertex_count];
    let mut keys: Vec<[u32; 3]> = Vec::new();
    keys.reserve_exact(sets.iter().map(|set| set.positions.len()).sum::<usize>().min(vertex_count));
    for set in sets {
        for (position, &vertex) in set.positions.iter().zip(&set.source_vertices) {
            if !std::mem::replace(&mut is_counted[vertex as usize], true) {
                // Adding +0 turns -0 into +0 and leaves every other number alone.
                keys.push(position.map(|x| (x + 0.0).to_bits()));
            }
        }
    }
    keys.par_sort_unstable();
    let count = keys.len();
    keys.dedup();
    count - keys.len()
}
