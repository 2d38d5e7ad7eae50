//! Checks that redundant values of a file agree: blocks repeat the positions of their vertices,
//! edges are the directions between vertices, and quads follow from their faces.
//!
//! Queries are safe without this check: answers are finite and in range, but wrong. `bake verify`
//! finds the many other wrong values that a correct checksum allows.

use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    archive::ArchivedSpan,
    check::{CheckError, HullError},
    edge, quad,
    sections::Sections,
};

/// Compares the redundant values of an archive: one square root per edge, one random read per lane.
/// One bit of memory per vertex.
///
/// # Errors
/// The first lane, edge or quad that contradicts its vertices. In an archive that has not passed
/// [`contents`](crate::check::contents), also a run or an index that is out of range.
pub fn repeats(pack: &Sections<'_>) -> Result<(), CheckError> {
    for (hull, (start, end)) in pack.spans.iter().zip(pack.spans.iter().skip(1)).enumerate() {
        let checked = blocks_agree(pack, start, end)
            .and_then(|()| edges_agree(pack, start, end))
            .and_then(|()| quads_agree(pack, start, end));
        checked.map_err(|source| CheckError::Hull { hull, source })?;
    }
    Ok(())
}

fn run<'a, T>(name: &'static str, section: &'a [T], start: u32_le, end: u32_le) -> Result<&'a [T], HullError> {
    let found = section.get(start.to_native() as usize..end.to_native() as usize);
    found.ok_or(HullError::OutOfRange { section: name })
}

fn blocks_agree(pack: &Sections<'_>, start: &ArchivedSpan, end: &ArchivedSpan) -> Result<(), HullError> {
    let vertices = run("vertices", pack.vertices, start.vertex, end.vertex)?;
    let blocks = run("blocks", pack.blocks, start.block, end.block)?;
    for (index, block) in blocks.iter().enumerate() {
        let lanes = block.vertex.iter().zip(block.x.iter().zip(block.y.iter().zip(&block.z)));
        for (lane, (vertex, (x, (y, z)))) in lanes.enumerate() {
            let (vertex, found) = (vertex.to_native(), [*x, *y, *z]);
            let expected = vertices.get(vertex as usize).ok_or(HullError::OutOfRange { section: "blocks" })?;
            if found != *expected {
                let [found, expected] = [found, *expected].map(|p| p.map(f32_le::to_native));
                return Err(HullError::BlockPosition { block: index, lane, vertex, found, expected });
            }
        }
    }
    Ok(())
}

fn edges_agree(pack: &Sections<'_>, start: &ArchivedSpan, end: &ArchivedSpan) -> Result<(), HullError> {
    let edges = run("edges", pack.edges, start.edge, end.edge)?;
    if edges.is_empty() {
        return Ok(());
    }
    let starts = run("neighbour starts", pack.neighbour_starts, start.vertex, end.vertex)?;
    let vertices = run("vertices", pack.vertices, start.vertex, end.vertex)?;
    let neighbours = run("neighbours", pack.neighbours, start.neighbour, end.neighbour)?;
    let ends = starts.iter().skip(1).map(|s| s.to_native() as usize).chain([neighbours.len()]);
    for (vertex, (v, (start, end))) in vertices.iter().zip(starts.iter().zip(ends)).enumerate() {
        let start = start.to_native() as usize;
        let around = neighbours.get(start..end).ok_or(HullError::OutOfRange { section: "neighbours" })?;
        let coordinates = edges.get(3 * start..3 * end).and_then(|run| {
            let (x, yz) = run.split_at_checked(around.len())?;
            let (y, z) = yz.split_at_checked(around.len())?;
            Some(x.iter().zip(y.iter().zip(z)))
        });
        let coordinates = coordinates.ok_or(HullError::OutOfRange { section: "edges" })?;
        for (neighbour, (x, (y, z))) in around.iter().zip(coordinates) {
            let neighbour = neighbour.to_native();
            let w = vertices.get(neighbour as usize).ok_or(HullError::OutOfRange { section: "neighbours" })?;
            let expected = edge::quantise(v.map(f32_le::to_native), w.map(f32_le::to_native));
            let found = [*x, *y, *z].map(i16_le::to_native);
            if found != expected {
                return Err(HullError::Edge { vertex, neighbour, found, expected });
            }
        }
    }
    Ok(())
}

/// Rounding error of a share of an area.
const AREA_ERROR: f64 = 1e-6;

fn quads_agree(pack: &Sections<'_>, start: &ArchivedSpan, end: &ArchivedSpan) -> Result<(), HullError> {
    let quads = run("quads", pack.quads, start.quad, end.quad)?;
    if quads.is_empty() {
        return Ok(());
    }
    let vertices = run("vertices", pack.vertices, start.vertex, end.vertex)?;
    let face_starts = run("face starts", pack.face_starts, start.face, end.face)?;
    let face_vertices = run("face vertices", pack.face_vertices, start.face_vertex, end.face_vertex)?;
    let neighbour_starts = run("neighbour starts", pack.neighbour_starts, start.vertex, end.vertex)?;
    let neighbours = run("neighbours", pack.neighbours, start.neighbour, end.neighbour)?;
    let neighbour_faces = run("neighbour faces", pack.neighbour_faces, start.neighbour, end.neighbour)?;
    // Runs that overlap, and faces that repeat, would take quadratic time.
    if !face_starts.is_sorted_by_key(|start| start.to_native()) {
        return Err(HullError::OutOfRange { section: "face starts" });
    }
    if !quads.is_sorted_by(|a, b| a.face.to_native() < b.face.to_native()) {
        return Err(HullError::OutOfRange { section: "quads" });
    }
    let positions: Vec<[f64; 3]> = vertices.iter().map(|v| v.map(|c| f64::from(c.to_native()))).collect();
    let corners: Vec<u32> = face_vertices.iter().map(|v| v.to_native()).collect();
    let faces: Vec<&[u32]> = (0..face_starts.len())
        .map(|face| corners.get(range(face_starts, face, corners.len())).unwrap_or_default())
        .collect();
    let left_of = |v: u32, w: u32| {
        let range = range(neighbour_starts, v as usize, neighbours.len());
        let at = neighbours.get(range.clone())?.binary_search_by_key(&w, |w| w.to_native()).ok()?;
        neighbour_faces.get(range)?.get(at).map(|face| face.to_native())
    };
    // Only solids have edges. A polygon has no edges that leave its face.
    let is_solid = end.edge != start.edge;
    let falls = if is_solid { quad::falls(&positions, &faces, left_of) } else { vec![quad::STEEPEST; faces.len()] };
    for (index, entry) in quads.iter().enumerate() {
        let of_face = faces.get(entry.face.to_native() as usize).zip(falls.get(entry.face.to_native() as usize));
        let (face, expected) = of_face.ok_or(HullError::OutOfRange { section: "quads" })?;
        let corner = |at: u32| positions.get(*face.get(at as usize)? as usize).copied();
        let [Some(a), Some(b), Some(c), Some(d)] = entry.corners.map(|at| corner(at.to_native())) else {
            return Err(HullError::OutOfRange { section: "quads" });
        };
        let outline: Vec<[f64; 3]> = face.iter().filter_map(|v| positions.get(*v as usize).copied()).collect();
        let area = quad::double_area(&outline);
        let share = quad::dot(quad::double_quad_area([a, b, c, d]), area) / quad::dot(area, area);
        // NaN takes the failing branch.
        if !(share >= 0.5 - AREA_ERROR) {
            return Err(HullError::QuadArea { quad: index, share });
        }
        let found = entry.fall.to_native();
        if found != *expected {
            return Err(HullError::QuadFallDiffers { quad: index, found, expected: *expected });
        }
    }
    Ok(())
}

fn range(starts: &[u32_le], index: usize, count: usize) -> std::ops::Range<usize> {
    let at = |index: usize| starts.get(index).map_or(count, |start| start.to_native() as usize);
    at(index)..at(index.saturating_add(1))
}
