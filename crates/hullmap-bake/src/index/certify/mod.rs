//! Certificate of a direction index: a proof that every direction leads to a leaf that lists its
//! support vertex. It is computed only from the hull and the stored index.
//!
//! The normal cones of the vertices tile the sphere of directions (the Gauss map). Their borders
//! are the arcs of the edges: along the arc of an edge, its two ends are support vertices. So a
//! leaf is exact if, and only if, it lists
//! - both ends of every edge whose arc crosses the leaf's region, and
//! - if no arc crosses the region, the vertex whose cone contains it.
//!
//! # Steps
//! 1. Each lane of each block must hold a vertex and its position.
//! 2. `arcs` computes the arcs from the faces, and clips them to the faces of the cube. There,
//!    arcs are straight segments, and regions are convex polygons.
//! 3. `descent` follows all arcs through all nodes at once.
//! 4. In each leaf, both conditions are checked (`Certifier::leaf`).
//!
//! # Rounding
//! A direction near the border of a region may be located on either side of it. Around a cell of
//! the grid, that is less than [`cube::CELL_SLACK`], and the arcs are followed through the cell
//! widened by nearly as much: nothing more is needed.
//!
//! At a plane or a fan's step, the error is a few 1e-15, and cones that reach no farther are not
//! listed beyond. There, a region has a *core*, in which the conditions must hold, and a *reach*,
//! from which directions may lead to the leaf (`region`). The regret is at most the diameter times
//! the greatest distance of the reach from the core, and must be at most `REGRET_LIMIT`.
//!
//! Where two planes meet at a very small angle, the reach has a spike beyond the core, and between
//! planes that nearly coincide there is no core at all. Both are slivers, and the regret is bounded
//! along the sliver's axis (`Certifier::sliver`).
//!
//! # Premises
//! The hull is proven ([`crate::hull::certify`]). A query finds the best of a leaf's candidates.
//!
//! # Complexity
//! O(arcs · regions that an arc crosses). It is bounded for any index (`WORK`).
//!
//! [`cube::CELL_SLACK`]: hullmap_format::cube::CELL_SLACK

mod arcs;
mod certifier;
mod descent;
pub(crate) mod proof;
mod region;

use hullmap_format::{
    IndexKind,
    archive::{Block, LANES},
    node::Words,
};
use rayon::prelude::*;

pub use crate::error::Unproven;
use crate::hull::Hull;
use arcs::Arcs;
use certifier::Certifier;
pub use proof::Proof;
use region::cube_slack;

/// Proves the index of `hull`, stored as these words and blocks. The words must have passed the
/// checks of [`hullmap_format::walk`].
///
/// # Errors
/// A leaf that is not proven; always the same for the same index.
pub fn certify<W: Words + Sync + ?Sized>(
    hull: &Hull,
    kind: IndexKind,
    words: &W,
    blocks: impl IntoIterator<Item = Block>,
) -> Result<Proof, Unproven> {
    let lanes = lanes(hull, blocks)?;
    let certifier = Certifier::new(hull, kind, words, &lanes);
    if kind == IndexKind::None || hull.rank < 2 {
        return certifier.everywhere();
    }
    let arcs = Arcs::new(hull);
    let faces: Vec<Result<Proof, Unproven>> =
        (0..6).into_par_iter().map(|face| certifier.descend(face, arcs.on_face(face, cube_slack()))).collect();
    faces.into_iter().try_fold(Proof::default(), |all, face| Ok(all.and(face?)))
}

fn lanes(hull: &Hull, blocks: impl IntoIterator<Item = Block>) -> Result<Vec<[u32; LANES]>, Unproven> {
    let mut all = Vec::new();
    for (index, block) in blocks.into_iter().enumerate() {
        for lane in 0..LANES {
            let position = [block.x[lane], block.y[lane], block.z[lane]];
            // Bit by bit: a NaN differs.
            let vertex = hull.vertices.get(block.vertex[lane] as usize);
            if vertex.is_none_or(|vertex| vertex.map(f32::to_bits) != position.map(f32::to_bits)) {
                return Err(Unproven::Lane { block: index, lane });
            }
        }
        all.push(block.vertex);
    }
    Ok(all)
}

#[cfg(test)]
mod tests;
