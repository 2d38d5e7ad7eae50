//! Hull → direction index.
//!
//! 1. [`crate::gauss_map`] gives each vertex its normal cone; [`cones`] cuts the cones to the faces of a cube.
//! 2. [`subdivide`] (a tree, with [`fan`]s in it) or [`cube_map`] (a uniform grid) lists for each cell every vertex whose cone
//!    meets it.
//! 3. [`packing`] lets leaves of a tree share blocks, neighbours first.
//! 4. [`encode`] writes the lists as blocks and the cells as words.

pub mod cones;
pub mod cube_map;
pub mod encode;
pub mod fan;
pub mod packing;
pub mod subdivide;

use hullmap_format::{
    archive::{LANES, index_kind},
    walk::{self, Branches, Shape},
};
use rayon::prelude::*;

use crate::{BakeError, IndexKind, LeafBlocks, gauss_map::GaussMap, hull::Hull};
use encode::Encoded;
use subdivide::{Cuts, Tree};

/// Hulls of up to this many vertices are scanned whatever tree is asked for: four blocks cost no more than a descent.
pub const SCAN_UP_TO: usize = 32;

/// A hull's index with what it costs to ask it.
#[derive(Clone, Debug)]
pub struct Index {
    /// One of [`index_kind`].
    pub kind: u32,
    /// Cells along the edge of a face of a cube map; 0 for the other kinds.
    pub resolution: u32,
    /// Blocks of a plain leaf.
    pub leaf_blocks: u32,
    /// Worst case over all directions.
    pub cost: walk::Cost,
    /// Words and blocks.
    pub encoded: Encoded,
}

impl Index {
    /// Bytes of words and blocks.
    pub fn byte_len(&self) -> usize {
        size_of_val(self.encoded.slots.as_slice()) + size_of_val(self.encoded.blocks.as_slice())
    }

    /// The index in a few words, with its price.
    pub fn describe(&self, vertex_count: usize) -> String {
        let kind = match self.kind {
            index_kind::TREE => format!("tree with leaves of {}", LANES as u32 * self.leaf_blocks),
            index_kind::BINARY => "binary tree".to_owned(),
            index_kind::CUBE_MAP => format!("cube map of {0} x {0} cells a face", self.resolution),
            _ => "linear scan".to_owned(),
        };
        format!("{kind}, {:.1} bytes a vertex", self.byte_len() as f64 / vertex_count as f64)
    }
}

/// Builds the index of `hull`.
///
/// # Errors
/// An index too large for the places that slots can name.
pub fn build(hull: &Hull, kind: IndexKind) -> Result<Index, BakeError> {
    let vertices = &hull.vertices;
    let tree = |leaf: usize, cuts: Cuts| -> Vec<Tree> {
        if vertices.len() <= leaf {
            return (0..6).map(|_| Tree::Leaf((0..vertices.len() as u32).collect())).collect();
        }
        let map = GaussMap::new(hull);
        (0..6).into_par_iter().map(|face| subdivide::subdivide(&map, face, leaf, cuts)).collect()
    };
    match kind {
        IndexKind::Tree { .. } if vertices.len() <= SCAN_UP_TO => Ok(scan(vertices)),
        IndexKind::Tree { leaf_blocks } => {
            let leaf = leaf_blocks.lanes();
            let mut roots = tree(fine_leaf(leaf), Cuts::FansAndPlanes);
            packing::share(&mut roots, leaf);
            finish(hull, index_kind::TREE, 0, leaf / LANES, &roots)
        }
        IndexKind::Budget { bytes_per_vertex } => {
            for leaf_blocks in [LeafBlocks::One, LeafBlocks::Two, LeafBlocks::Four] {
                let index = build(hull, IndexKind::Tree { leaf_blocks })?;
                if index.byte_len() <= bytes_per_vertex as usize * vertices.len() {
                    return Ok(index);
                }
            }
            Ok(scan(vertices))
        }
        IndexKind::Binary => finish(hull, index_kind::BINARY, 0, 1, &tree(LANES, Cuts::Planes)),
        IndexKind::CubeMap { resolution } => {
            let cells = if vertices.len() <= LANES {
                vec![(0..vertices.len() as u32).collect(); 6 * (resolution as usize).pow(2)]
            } else {
                cube_map::cells(&GaussMap::new(hull), resolution)
            };
            let roots: Vec<Tree> = cells.into_iter().map(Tree::Leaf).collect();
            finish(hull, index_kind::CUBE_MAP, resolution, 1, &roots)
        }
        IndexKind::None => Ok(scan(vertices)),
    }
}

/// Vertices of a leaf that is subdivided no further, where its blocks hold `capacity`.
///
/// Fewer than fit: neighbouring leaves then fill up each other's blocks. Subdividing down to 6 instead of 8 takes 5 %
/// off an index, down to 20 instead of 32 takes 10 %; any further, the slots outweigh the blocks.
fn fine_leaf(capacity: usize) -> usize {
    if capacity == LANES { capacity * 3 / 4 } else { capacity * 5 / 8 }
}

fn scan(vertices: &[[f32; 3]]) -> Index {
    let encoded = encode::scan(vertices);
    let shape = Shape { roots: 0, branches: Branches::None, leaf_blocks: 1, block_count: encoded.blocks.len() as u32 };
    Index { kind: index_kind::SCAN, resolution: 0, leaf_blocks: 1, cost: shape.scan_cost(), encoded }
}

/// Encodes and prices the trees below the roots.
fn finish(hull: &Hull, kind: u32, resolution: u32, leaf_blocks: usize, roots: &[Tree]) -> Result<Index, BakeError> {
    let branches = match kind {
        index_kind::TREE => Branches::Squares,
        index_kind::BINARY => Branches::Halves,
        _ => Branches::None,
    };
    let encoded = encode::trees(&hull.vertices, roots, branches, leaf_blocks)?;
    let leaf_blocks = leaf_blocks as u32;
    let shape = Shape { roots: roots.len(), branches, leaf_blocks, block_count: encoded.blocks.len() as u32 };
    let slots = &encoded.slots;
    let cost = walk::walk(shape, slots.len(), |i| slots[i])?;
    Ok(Index { kind, resolution, leaf_blocks, cost, encoded })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PointSet, hull};

    /// The paper's tree is what others are compared with: halves, planes where they stall, and no fans.
    #[test]
    fn the_binary_tree_has_no_fans() {
        let positions = shapes::families::prism(2_000, 0);
        let set =
            PointSet { name: String::new(), source_vertices: (0..2_000).collect(), positions, ..PointSet::default() };
        let hull = hull::build(&set).unwrap();
        let nodes = |kind| build(&hull, kind).unwrap().cost.nodes;
        let [fans, halves] = [IndexKind::TREE, IndexKind::Binary].map(nodes);
        println!("nodes: {fans} with fans, {halves} without");
        assert!(fans == 1 && halves > 2, "{fans} with fans, {halves} without");
    }

    #[test]
    fn budgets_are_kept_and_used() {
        let positions = shapes::families::rock(600, 3);
        let set =
            PointSet { name: String::new(), source_vertices: (0..600).collect(), positions, ..PointSet::default() };
        let hull = hull::build(&set).unwrap();
        let budget = |bytes_per_vertex| build(&hull, IndexKind::Budget { bytes_per_vertex }).unwrap();
        for (bytes, leaf_blocks) in [(100, 1), (50, 2), (40, 4)] {
            let index = budget(bytes);
            assert_eq!((index.kind, index.leaf_blocks), (index_kind::TREE, leaf_blocks), "{bytes}");
            assert!(index.byte_len() <= bytes as usize * 600, "{}", index.describe(600));
        }
        assert_eq!(budget(20).kind, index_kind::SCAN);
        assert_eq!(budget(20).describe(600), "linear scan, 16.0 bytes a vertex");
    }
}
