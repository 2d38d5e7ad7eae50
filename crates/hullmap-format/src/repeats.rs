//! Whether what a file holds twice agrees: blocks repeat the coordinates of the vertices they name, and edges are the directions
//! between vertices.
//!
//! No query needs it: one that contradicts itself answers with numbers that are finite, in range, and wrong. That is what a file
//! whose checksum is right, and whose maker was not, may do in many ways; `bake verify` finds out all of them, this one too.

use rkyv::rend::{f32_le, i16_le, u32_le};

use crate::{
    archive::{ArchivedPack, ArchivedSpan},
    check::CheckError,
    edge,
};

/// Compares what an archive holds twice.
///
/// # Errors
/// The first hull that contradicts itself; in an archive that has not passed [`crate::check::contents`], also one whose runs or
/// neighbours are not there.
///
/// # Complexity
/// O(archive), with a square root an edge and a read at random a lane.
pub fn repeats(pack: &ArchivedPack) -> Result<(), CheckError> {
    for (hull, spans) in pack.spans.windows(2).enumerate() {
        let [start, end] = spans else { continue };
        if !blocks_agree(pack, start, end) {
            return Err(CheckError::Hull { hull, what: "a block of its index contradicts its vertices" });
        }
        if !edges_agree(pack, start, end) {
            return Err(CheckError::Hull { hull, what: "an edge contradicts its vertices" });
        }
    }
    Ok(())
}

/// A hull's run of a section, if it is there.
fn run<T>(section: &[T], start: u32_le, end: u32_le) -> Option<&[T]> {
    section.get(start.to_native() as usize..end.to_native() as usize)
}

fn blocks_agree(pack: &ArchivedPack, start: &ArchivedSpan, end: &ArchivedSpan) -> bool {
    let vertices = run(&pack.vertices, start.vertex, end.vertex);
    let (Some(vertices), Some(blocks)) = (vertices, run(&pack.blocks, start.block, end.block)) else { return false };
    blocks.iter().all(|block| {
        let mut lanes = block.vertex.iter().zip(block.x.iter().zip(block.y.iter().zip(&block.z)));
        lanes.all(|(vertex, (x, (y, z)))| vertices.get(vertex.to_native() as usize) == Some(&[*x, *y, *z]))
    })
}

fn edges_agree(pack: &ArchivedPack, start: &ArchivedSpan, end: &ArchivedSpan) -> bool {
    let starts = run(&pack.neighbour_starts, start.vertex, end.vertex);
    let (Some(starts), Some(vertices)) = (starts, run(&pack.vertices, start.vertex, end.vertex)) else { return false };
    let neighbours = run(&pack.neighbours, start.neighbour, end.neighbour);
    let (Some(neighbours), Some(edges)) = (neighbours, run(&pack.edges, start.edge, end.edge)) else { return false };
    if edges.is_empty() {
        return true;
    }
    let ends = starts.iter().skip(1).map(|s| s.to_native() as usize).chain([neighbours.len()]);
    vertices.iter().zip(starts.iter().zip(ends)).all(|(v, (start, end))| {
        let start = start.to_native() as usize;
        let Some(around) = neighbours.get(start..end) else { return false };
        let Some((x, yz)) = edges.get(3 * start..3 * end).and_then(|run| run.split_at_checked(around.len())) else {
            return false;
        };
        let Some((y, z)) = yz.split_at_checked(around.len()) else { return false };
        around.iter().zip(x.iter().zip(y.iter().zip(z))).all(|(w, (x, (y, z)))| {
            let Some(w) = vertices.get(w.to_native() as usize) else { return false };
            let edge = edge::quantise(v.map(f32_le::to_native), w.map(f32_le::to_native));
            edge == [*x, *y, *z].map(i16_le::to_native)
        })
    })
}
