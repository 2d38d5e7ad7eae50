//! Proof of the direction indices of a pack, from its bytes: see [`hullmap_bake::index::certify`].

use hullmap::Pack;
use hullmap_bake::index::certify::{Proof, certify};
use hullmap_bake::{IndexKind, PointSet, hull};
use hullmap_format::{
    archive::{ArchivedBlock, Block},
    header::HEADER_LEN,
    sections::Sections,
};
use rayon::prelude::*;

use crate::geometry::positions;

/// Proves the index of each hull, built again from the stored vertices alone. Complexity: the cost
/// of baking the hulls without their indices, plus the cost of the proofs.
pub fn prove(pack: &Pack) -> Vec<Result<Proof, String>> {
    let sections = match Sections::read(pack.bytes().get(HEADER_LEN..).unwrap_or_default()) {
        Ok(sections) => sections,
        Err(error) => return pack.hulls().map(|_| Err(error.to_string())).collect(),
    };
    (0..pack.hull_count()).into_par_iter().map(|index| prove_hull(pack, &sections, index)).collect()
}

fn prove_hull(pack: &Pack, sections: &Sections, index: usize) -> Result<Proof, String> {
    let stored = pack.hull(index).map_err(|error| error.to_string())?;
    let points = positions(&stored);
    let set = PointSet::of_positions(points);
    let hull = hull::build(&set).map_err(|error| error.to_string())?;
    if hull.vertices != set.positions {
        return Err("some of its vertices are not vertices of their convex hull".to_owned());
    }
    let [start, end] = [index, index + 1].map(|at| &sections.spans[at]);
    let words = &sections.slots[start.slot.to_native() as usize..end.slot.to_native() as usize];
    let blocks = &sections.blocks[start.block.to_native() as usize..end.block.to_native() as usize];
    let kind = IndexKind::of_record(&sections.hulls[index]).map_err(|error| error.to_string())?;
    certify(&hull, kind, words, blocks.iter().map(read)).map_err(|error| error.to_string())
}

fn read(block: &ArchivedBlock) -> Block {
    let [x, y, z] = [&block.x, &block.y, &block.z].map(|lanes| lanes.map(|lane| lane.to_native()));
    Block { x, y, z, vertex: block.vertex.map(|vertex| vertex.to_native()) }
}
