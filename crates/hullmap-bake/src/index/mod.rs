//! Hull → direction index.
//!
//! 1. [`crate::gauss_map`] gives each vertex its normal cone; [`cones`] cuts the cones to the faces of a cube.
//! 2. [`subdivide`] (a tree) or [`cube_map`] (a uniform grid) lists for each cell every vertex whose cone meets it.
//! 3. [`encode`] writes the lists as blocks and the cells as words.

pub mod cones;
pub mod cube_map;
pub mod encode;
pub mod subdivide;

use hullmap_format::{archive::LANES, archive::index_kind, walk};
use rayon::prelude::*;

use crate::{BakeError, IndexKind, gauss_map::GaussMap, hull::Hull};
use encode::Encoded;
use subdivide::Tree;

/// A hull's index with what it costs to ask it.
#[derive(Clone, Debug)]
pub struct Index {
    /// One of [`index_kind`].
    pub kind: u32,
    /// Cells along the edge of a face of a cube map; 0 for the other kinds.
    pub resolution: u32,
    /// Worst case over all directions.
    pub cost: walk::Cost,
    /// Words and blocks.
    pub encoded: Encoded,
}

/// Builds the index of `hull`.
///
/// # Errors
/// An index too large for 30-bit places.
pub fn build(hull: &Hull, kind: IndexKind) -> Result<Index, BakeError> {
    let vertices = &hull.vertices;
    let everything = || Tree::Leaf((0..vertices.len() as u32).collect());
    let small = vertices.len() <= LANES;
    let (kind, resolution, encoded) = match kind {
        IndexKind::None => {
            let encoded = encode::scan(vertices);
            let cost = walk::Cost { nodes: 0, dots: (encoded.blocks.len() * LANES) as u32 };
            return Ok(Index { kind: index_kind::SCAN, resolution: 0, cost, encoded });
        }
        IndexKind::Tree => {
            let roots: Vec<Tree> = if small {
                (0..6).map(|_| everything()).collect()
            } else {
                let map = GaussMap::new(hull);
                (0..6).into_par_iter().map(|face| subdivide::subdivide(&map, face)).collect()
            };
            (index_kind::TREE, 0, encode::trees(vertices, &roots)?)
        }
        IndexKind::CubeMap { resolution } => {
            let cells = 6 * (resolution as usize).pow(2);
            let roots: Vec<Tree> = if small {
                (0..cells).map(|_| everything()).collect()
            } else {
                cube_map::cells(&GaussMap::new(hull), resolution).into_iter().map(Tree::Leaf).collect()
            };
            (index_kind::CUBE_MAP, resolution, encode::trees(vertices, &roots)?)
        }
    };
    let root_count = if kind == index_kind::TREE { 6 } else { 6 * (resolution as usize).pow(2) };
    let slots = &encoded.slots;
    let cost =
        walk::walk(root_count, kind == index_kind::TREE, slots.len(), |i| slots[i], encoded.blocks.len() as u32)?;
    Ok(Index { kind, resolution, cost, encoded })
}
