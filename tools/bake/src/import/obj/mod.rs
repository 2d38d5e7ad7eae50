//! Wavefront OBJ, the reference: read twice, by [`scan`] and by tobj.
//!
//! 1. [`scan`] reads every vertex and every reference, in parts side by side, and names the line of any fault.
//! 2. [`cross_check`] has tobj read the same words; the two must agree on every position and reference.

mod cross_check;
mod lines;
mod reference;
mod scan;

use super::fault::LineFault;
use super::limits::Limits;
use super::mesh::{Mesh, Positions};

/// Reads an OBJ file. Vertices are the `v` lines, objects what `o` lines open; the first is what stands before them.
///
/// `wants_double`: whether to keep the digits of f64.
///
/// # Errors
/// The first fault in the file, with its line; references that are too large come after all others.
///
/// # Complexity
/// O(bytes), shared by the threads of the pool.
pub fn read(bytes: &[u8], wants_double: bool, limits: &Limits) -> Result<Mesh, LineFault> {
    let scan = scan::scan(bytes, wants_double, limits)?;
    cross_check::cross_check(&scan, bytes).map_err(|fault| fault.of_file())?;
    let mut notes = Vec::new();
    if scan.short_face_count > 0 {
        let faces = super::count(scan.short_face_count, "face", "faces");
        notes.push(format!("{faces} with fewer than 3 vertices"));
    }
    if let Some(line) = scan.free_form_line {
        notes.push(format!(
            "line {line}: free-form curves and surfaces are not read; --vertices all takes their control points"
        ));
    }
    let is_grouped = scan.objects.len() == 1 && scan.group_count > 0;
    let positions = match scan.doubles {
        Some(doubles) => Positions::Double(doubles),
        None => Positions::Single(scan.positions),
    };
    Ok(Mesh {
        loose: scan.loose,
        objects: scan.objects,
        has_too_many_objects: scan.has_too_many_objects,
        notes,
        has_only_groups: is_grouped,
        ..Mesh::of(positions, scan.faces)
    })
}
