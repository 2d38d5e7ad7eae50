//! Whether what a file holds twice agrees: blocks repeat the coordinates of the vertices they name, and edges are the directions
//! between vertices.
//!
//! No query needs it: one that contradicts itself answers with numbers that are finite, in range, and wrong. That is what a file
//! whose checksum is right, and whose maker was not, may do in many ways; `bake verify` finds out all of them, this one too.

use rkyv::rend::f32_le;

use crate::{
    archive::{ArchivedPack, ArchivedSpan, LANES},
    check::CheckError,
    edge,
};

/// Compares what an archive holds twice. It must have passed [`crate::check::contents`].
///
/// # Errors
/// The first hull that contradicts itself.
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

fn blocks_agree(pack: &ArchivedPack, start: &ArchivedSpan, end: &ArchivedSpan) -> bool {
    let vertices = &pack.vertices[start.vertex.to_native() as usize..end.vertex.to_native() as usize];
    let blocks = &pack.blocks[start.block.to_native() as usize..end.block.to_native() as usize];
    blocks.iter().all(|block| {
        (0..LANES).all(|lane| {
            vertices
                .get(block.vertex[lane].to_native() as usize)
                .is_some_and(|v| block.x[lane] == v[0] && block.y[lane] == v[1] && block.z[lane] == v[2])
        })
    })
}

fn edges_agree(pack: &ArchivedPack, start: &ArchivedSpan, end: &ArchivedSpan) -> bool {
    let vertices = start.vertex.to_native() as usize..end.vertex.to_native() as usize;
    let (starts, vertices) = (&pack.neighbour_starts[vertices.clone()], &pack.vertices[vertices]);
    let neighbours = &pack.neighbours[start.neighbour.to_native() as usize..end.neighbour.to_native() as usize];
    let edges = &pack.edges[start.edge.to_native() as usize..end.edge.to_native() as usize];
    if edges.is_empty() {
        return true;
    }
    let ends = starts.iter().skip(1).map(|s| s.to_native() as usize).chain([neighbours.len()]);
    vertices.iter().zip(starts.iter().zip(ends)).all(|(v, (start, end))| {
        let start = start.to_native() as usize;
        let (run, around) = (&edges[3 * start..3 * end], &neighbours[start..end]);
        around.iter().enumerate().all(|(place, w)| {
            let w = vertices[w.to_native() as usize];
            let edge = edge::quantise(v.map(f32_le::to_native), w.map(f32_le::to_native));
            (0..3).all(|axis| run[axis * around.len() + place] == edge[axis])
        })
    })
}
