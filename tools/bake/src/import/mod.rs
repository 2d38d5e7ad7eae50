//! OBJ bytes to the point sets that hulls are built of, with the number of each point's `v` line.
//!
//! 1. [`scan`] reads every vertex and every reference, and names the line of any fault.
//! 2. [`cross_check`] has tobj read the same words; the two must agree on every position and reference.
//! 3. [`point_sets`] chooses the points and cuts them into objects.

mod cross_check;
mod fault;
mod point_sets;
mod scan;

use std::collections::HashSet;

use hullmap_bake::PointSet;

pub use fault::ImportError;

use crate::options::{ImportOptions, Split, Vertices};
use fault::LineFault;

/// What came out of an OBJ file.
#[derive(Debug)]
pub struct Imported {
    /// One set for each hull, in file order, none of them empty, all with different names.
    pub point_sets: Vec<PointSet>,
    /// Number of `v` lines in the file.
    pub vertex_count: usize,
    /// Number of `v` lines that no element references.
    pub unreferenced_count: usize,
    /// Number of chosen points that an earlier one already equals. They are kept: hulls are of all points.
    pub duplicate_count: usize,
    /// What a user may want to know, a sentence each.
    pub notes: Vec<String>,
}

impl Imported {
    /// Points over all sets; a vertex that two objects reference counts twice.
    pub fn point_count(&self) -> usize {
        self.point_sets.iter().map(|set| set.positions.len()).sum()
    }
}

/// Imports an OBJ file from its bytes.
///
/// `file` is the name to use in messages; `stem` names the hull of what belongs to no named object.
/// Material files are neither needed nor read.
///
/// # Errors
/// The first fault in the file, with file, line, what was found and what to do about it.
///
/// # Complexity
/// O(bytes).
pub fn import_obj(file: &str, stem: &str, bytes: &[u8], options: ImportOptions) -> Result<Imported, ImportError> {
    let name = |LineFault { line, fault }| ImportError { file: file.to_owned(), line, fault };
    let scan = scan::scan(bytes).map_err(name)?;
    cross_check::cross_check(&scan).map_err(|fault| name(fault.of_file()))?;

    let mut referenced = vec![false; scan.positions.len()];
    for &vertex in &scan.references {
        referenced[vertex as usize] = true;
    }
    let unreferenced_count = referenced.iter().filter(|&&is| !is).count();
    let (point_sets, mut notes) = point_sets::point_sets(&scan, &referenced, stem, options);
    let duplicate_count = count_duplicates(&scan.positions, &point_sets);

    if scan.elements.is_empty() {
        notes.push("no elements, so every vertex counts (a point cloud)".to_owned());
    } else if unreferenced_count > 0 {
        let fate = match options.vertices {
            Vertices::Referenced => "left out (--vertices all takes them)",
            Vertices::All => "taken too",
        };
        notes.push(format!("{} that no element references, {fate}", count(unreferenced_count, "vertex", "vertices")));
    }
    if duplicate_count > 0 {
        notes.push(format!("{} an earlier one", count(duplicate_count, "point equals", "points equal")));
    }
    if scan.short_face_count > 0 {
        notes.push(format!("{} with fewer than 3 vertices", count(scan.short_face_count, "face", "faces")));
    }
    if let Some(line) = scan.free_form_line {
        notes.push(format!(
            "line {line}: free-form curves and surfaces are not read; --vertices all takes their control points"
        ));
    }
    if options.split == Split::Object && scan.objects.len() == 1 && scan.group_count > 0 {
        notes.push("the file has groups (g) but no objects (o), and is cut at objects only".to_owned());
    }
    let vertex_count = scan.positions.len();
    Ok(Imported { point_sets, vertex_count, unreferenced_count, duplicate_count, notes })
}

/// `1 vertex`, `2 vertices`.
fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// Chosen vertices whose position an earlier chosen vertex has; the two zeros count as equal.
fn count_duplicates(positions: &[[f32; 3]], sets: &[PointSet]) -> usize {
    let mut is_chosen = vec![false; positions.len()];
    for &vertex in sets.iter().flat_map(|set| &set.source_vertices) {
        is_chosen[vertex as usize] = true;
    }
    let mut seen = HashSet::with_capacity(positions.len());
    let chosen = positions.iter().zip(&is_chosen).filter(|&(_, &is)| is);
    // Adding +0 turns -0 into +0 and leaves every other number alone.
    chosen.filter(|(position, _)| !seen.insert(position.map(|x| (x + 0.0).to_bits()))).count()
}

#[cfg(test)]
mod tests;
