//! Checks that redundant values of a file agree: blocks repeat the positions of their vertices, and
//! edges are the directions between vertices.
//!
//! Queries are safe without this check. If it fails, answers are finite and in range, but wrong. A
//! file with a correct checksum can contain many other wrong values. `bake verify` finds all of
//! them.

use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    archive::ArchivedSpan,
    check::{CheckError, HullError},
    edge,
    sections::Sections,
};

/// Compares the redundant values of an archive.
///
/// # Errors
/// The first lane or edge that contradicts its vertices. In an archive that has not passed
/// [`contents`](crate::check::contents), also a run or an index that is out of range.
///
/// # Complexity
/// O(archive): one square root per edge, one random read per lane.
pub fn repeats(pack: &Sections<'_>) -> Result<(), CheckError> {
    for (hull, (start, end)) in pack.spans.iter().zip(pack.spans.iter().skip(1)).enumerate() {
        let checked = blocks_agree(pack, start, end).and_then(|()| edges_agree(pack, start, end));
        checked.map_err(|source| CheckError::Hull { hull, source })?;
    }
    Ok(())
}

/// A hull's run of a section, if it is in range.
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
    let starts = run("neighbour starts", pack.neighbour_starts, start.vertex, end.vertex)?;
    let vertices = run("vertices", pack.vertices, start.vertex, end.vertex)?;
    let neighbours = run("neighbours", pack.neighbours, start.neighbour, end.neighbour)?;
    let edges = run("edges", pack.edges, start.edge, end.edge)?;
    if edges.is_empty() {
        return Ok(());
    }
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
