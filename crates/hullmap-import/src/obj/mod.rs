//! Wavefront OBJ: points and polygons of a text file.
//!
//! # Reference
//! "Object Files (.obj)", Appendix B1 of the Wavefront Advanced Visualizer manual, version 3.0.
//!
//! 1. [`lines`] cuts the text into parts and counts their lines and vertices.
//! 2. [`scan`] reads the elements and objects of each part and names the line of any fault.
//! 3. [`positions`] has the crate `tobj` read the coordinates.
//! 4. Only if step 2 or 3 failed, [`scan`] runs again and parses the coordinates too, to find the
//!    first fault.
//!
//! # Division of work with tobj
//! tobj reads the numbers. The scan keeps what tobj does not provide:
//! - *References.* A hull records the `v` line of each vertex. tobj indexes each object's vertices
//!   by first use, drops the way back, and resolves references when an object ends, so that
//!   references ahead fail.
//! - *Vertices without an element*, for `vertices=all` and point clouds, and *`p` elements*.
//! - *Lines.* tobj's errors have no line number, and tobj accepts NaN and infinity.
//! - *Continued lines, comments behind numbers, lone CRs, byte order marks, UTF-16.*
//! - *Weights*, by which tobj divides: see the deviations of [`scan`].
//!
//! The tests compare the result with tobj's own reading of whole files, elements included.

mod lines;
mod named_materials;
mod positions;
mod reference;
mod scan;
#[cfg(test)]
mod tests;
mod vertex_line;

use std::borrow::Cow;

use super::encoding;
use super::fault::{Fault, LineFault, counted};
use super::limits::Limits;
use super::mesh::{Positions, SourceMesh};
use lines::Parts;
use scan::{Scan, VertexCheck};

/// Bytes of a part: some milliseconds of work.
pub const PART_BYTES: usize = 4 << 20;

/// Vertices are the `v` lines. Objects are the `o` lines; the first object is what precedes them.
///
/// `is_double` selects `f64` positions instead of `f32`. The error is the first fault in the file;
/// references beyond the last vertex come last. Complexity: O(bytes), in parallel.
pub fn read(bytes: &[u8], is_double: bool, limits: &Limits) -> Result<SourceMesh, LineFault> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = encoding::from_utf16(text).map_or(Cow::Borrowed(text), Cow::Owned);
    let text = text.as_ref();
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::Empty.of_file());
    }
    read_parts(&Parts::new(text, PART_BYTES).map_err(Fault::of_file)?, is_double, limits)
}

fn read_parts(parts: &Parts, is_double: bool, limits: &Limits) -> Result<SourceMesh, LineFault> {
    let scanned = scan::scan(parts, limits, |_| Ok(())).and_then(|scan| {
        let positions = if is_double {
            positions::doubles(parts).map(Positions::Double)
        } else {
            positions::singles(parts).map(Positions::Single)
        };
        Ok((scan, positions.map_err(Fault::of_file)?))
    });
    match scanned {
        Ok((scan, positions)) => Ok(source_mesh(scan, positions)),
        Err(fault) => {
            let check: VertexCheck = if is_double {
                |vertex| vertex.point::<f64>().map(drop)
            } else {
                |vertex| vertex.point::<f32>().map(drop)
            };
            Err(scan::scan(parts, limits, check).err().unwrap_or(fault))
        }
    }
}

fn source_mesh(scan: Scan, positions: Positions) -> SourceMesh {
    let mut notes = Vec::new();
    if scan.short_face_count > 0 {
        let faces = counted(scan.short_face_count, "face", "faces");
        notes.push(format!("{faces} with fewer than 3 vertices"));
    }
    if let Some(line) = scan.free_form_line {
        notes.push(format!(
            "line {line}: free-form curves and surfaces are not read; --set vertices=all takes their control points"
        ));
    }
    let mut warnings = Vec::new();
    if let Some(line) = scan.weight_line {
        let vertices = counted(scan.weight_count, "vertex has", "vertices have");
        warnings.push(format!(
            "line {line}: {vertices} a weight w other than 1 (`v x y z w`), which is ignored; write x/w y/w z/w if you mean those"
        ));
    }
    SourceMesh {
        loose: scan.loose,
        materials: scan.materials.finish(),
        has_only_groups: scan.objects.len() == 1 && scan.group_count > 0,
        objects: scan.objects,
        has_too_many_objects: scan.has_too_many_objects,
        notes,
        warnings,
        ..SourceMesh::new(positions, scan.faces)
    }
}
