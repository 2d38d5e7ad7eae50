//! Builds the direction index of a hull.
//!
//! 1. [`crate::gauss_map`] computes the normal cone of each vertex. [`cones`] clips the cones to
//!    the faces of a cube.
//! 2. [`subdivide`] (a tree that may contain [`fan`]s) or [`cube_map`] (a uniform grid) lists for
//!    each cell every vertex whose cone meets it.
//! 3. [`packing`] lets leaves of a tree share blocks, neighbouring leaves first.
//! 4. [`encode`] writes the lists as blocks and the cells as words.
//! 5. [`certify`] proves the result, independently of steps 1 to 4. An index that cannot be proven
//!    is replaced by one of the next simpler kind.

pub mod certify;
pub mod cones;
pub mod cube_map;
pub mod encode;
pub mod fan;
pub mod packing;
pub mod subdivide;

use hullmap_format::{
    IndexKind,
    archive::LANES,
    walk::{self, Branches, IndexShape},
};
use rayon::prelude::*;

use crate::{error::BakeError, gauss_map::GaussMap, hull::Hull};
use certify::{Proof, Unproven};
use encode::Encoded;
use subdivide::{Cuts, Tree};

/// Hulls of at most this many vertices are scanned if a `tree`, `medium` or `compact` index is
/// requested. Four blocks cost no more than a descent.
pub const SCAN_UP_TO: usize = 32;

/// Maximum number of vertices of a hull with an index other than a scan: the corners of all normal
/// cones are counted in 32 bits.
const MAX_INDEXED: usize = 1 << 28;

/// A hull's direction index and the worst-case cost of a query.
#[derive(Clone, Debug)]
pub struct Index {
    /// Kind of the index; [`IndexKind::None`] for a hull that is small enough to be scanned.
    pub kind: IndexKind,
    /// Maximum over all directions.
    pub cost: walk::Cost,
    /// Words and blocks.
    pub encoded: Encoded,
    /// The index that this one replaces, since it could not be proven, and the reason.
    pub replaces: Option<(IndexKind, Unproven)>,
}

impl Index {
    /// Size of the words and blocks in bytes.
    pub fn byte_len(&self) -> usize {
        size_of_val(self.encoded.slots.as_slice()) + size_of_val(self.encoded.blocks.as_slice())
    }

    /// Proves the index: see [`certify`].
    ///
    /// # Errors
    /// The first leaf that is not proven.
    pub fn prove(&self, hull: &Hull) -> Result<Proof, Unproven> {
        certify::certify(hull, self.kind, &self.encoded.slots[..], self.encoded.blocks.iter().copied())
    }

    /// A short description of the index, with its size in bytes per vertex.
    pub fn describe(&self, vertex_count: usize) -> String {
        let kind = match self.kind {
            IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => {
                format!("tree with leaves of {}", self.kind.leaf_size())
            }
            IndexKind::Binary => "binary tree".to_owned(),
            IndexKind::CubeMap { resolution } => format!("cube map of {resolution} x {resolution} cells per face"),
            IndexKind::None => "linear scan".to_owned(),
        };
        format!("{kind}, {:.1} bytes per vertex", self.byte_len() as f64 / vertex_count as f64)
    }
}

/// Builds and proves the direction index of `hull`.
///
/// # Errors
/// [`BakeError::IndexTooLarge`] if slots cannot address all words or blocks.
pub fn build(hull: &Hull, kind: IndexKind) -> Result<Index, BakeError> {
    first_proven(hull, kind, build_kind)
}

fn first_proven(
    hull: &Hull,
    kind: IndexKind,
    build: impl Fn(&Hull, IndexKind) -> Result<Index, BakeError>,
) -> Result<Index, BakeError> {
    let index = build(hull, kind)?;
    match (index.prove(hull), simpler(kind)) {
        (Ok(_), _) => Ok(index),
        (Err(reason), None) => Err(BakeError::Unproven(reason)),
        (Err(reason), Some(next)) => Ok(Index { replaces: Some((kind, reason)), ..first_proven(hull, next, build)? }),
    }
}

fn simpler(kind: IndexKind) -> Option<IndexKind> {
    match kind {
        IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => Some(IndexKind::Binary),
        IndexKind::Binary | IndexKind::CubeMap { .. } => Some(IndexKind::None),
        IndexKind::None => None,
    }
}

fn build_kind(hull: &Hull, kind: IndexKind) -> Result<Index, BakeError> {
    let vertices = &hull.vertices;
    if kind != IndexKind::None && vertices.len() > MAX_INDEXED {
        return Err(BakeError::IndexTooLarge);
    }
    let tree = |leaf: usize, cuts: Cuts| -> Vec<Tree> {
        if vertices.len() <= leaf {
            return (0..6).map(|_| Tree::Leaf((0..vertices.len() as u32).collect())).collect();
        }
        let map = GaussMap::new(hull);
        (0..6).into_par_iter().map(|face| subdivide::subdivide(&map, face, leaf, cuts)).collect()
    };
    match kind {
        IndexKind::Tree | IndexKind::Medium | IndexKind::Compact if vertices.len() <= SCAN_UP_TO => Ok(scan(vertices)),
        IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => {
            let leaf = kind.leaf_size() as usize;
            let mut roots = tree(fine_leaf(leaf), Cuts::FansAndPlanes);
            packing::share(&mut roots, leaf);
            finish(hull, kind, &roots)
        }
        IndexKind::Binary => finish(hull, kind, &tree(LANES, Cuts::Planes)),
        IndexKind::CubeMap { resolution } => {
            let cells = if vertices.len() <= LANES {
                vec![(0..vertices.len() as u32).collect(); 6 * (resolution as usize).pow(2)]
            } else {
                cube_map::cells(&GaussMap::new(hull), resolution)
            };
            let roots: Vec<Tree> = cells.into_iter().map(Tree::Leaf).collect();
            finish(hull, kind, &roots)
        }
        IndexKind::None => Ok(scan(vertices)),
    }
}

/// Maximum number of vertices of a leaf that is not subdivided, below its `capacity` so that
/// neighbours can share blocks. Going down to 6 instead of 8 makes an index 5 % smaller, and to 20
/// instead of 32, 10 %. Below that, slots cost more than blocks save.
fn fine_leaf(capacity: usize) -> usize {
    if capacity == LANES { capacity * 3 / 4 } else { capacity * 5 / 8 }
}

fn scan(vertices: &[[f32; 3]]) -> Index {
    let encoded = encode::scan(vertices);
    let shape =
        IndexShape { roots: 0, branches: Branches::None, leaf_blocks: 1, block_count: encoded.blocks.len() as u32 };
    Index { kind: IndexKind::None, cost: shape.scan_cost(), encoded, replaces: None }
}

fn finish(hull: &Hull, kind: IndexKind, roots: &[Tree]) -> Result<Index, BakeError> {
    let (branches, leaf_blocks) = (kind.branches(), kind.leaf_blocks());
    let encoded = encode::trees(&hull.vertices, roots, branches, leaf_blocks as usize)?;
    let shape = IndexShape { roots: roots.len(), branches, leaf_blocks, block_count: encoded.blocks.len() as u32 };
    let cost = walk::walk(shape, &encoded.slots[..])?;
    Ok(Index { kind, cost, encoded, replaces: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::hull_of;
    use shapes::families;

    #[test]
    fn the_binary_tree_has_no_fans() {
        let hull = hull_of(families::prism(2_000, 0));
        let nodes = |kind: IndexKind| build(&hull, kind).unwrap().cost.nodes;
        let [fans, halves] = [IndexKind::Tree, IndexKind::Binary].map(nodes);
        println!("nodes: {fans} with fans, {halves} without");
        assert!(fans == 1 && halves > 2, "{fans} with fans, {halves} without");
    }

    #[test]
    fn an_unproven_index_is_replaced_by_a_simpler_one() {
        let hull = hull_of(families::rock(200, 3));
        // Every lane of block 1 holds the same vertex.
        let damaged = |kinds: &'static [IndexKind]| {
            move |hull: &Hull, kind: IndexKind| {
                let mut index = build_kind(hull, kind)?;
                if kinds.contains(&kind) {
                    let block = &mut index.encoded.blocks[1];
                    for lanes in [&mut block.x, &mut block.y, &mut block.z] {
                        *lanes = [lanes[0]; LANES];
                    }
                    block.vertex = [block.vertex[0]; LANES];
                }
                Ok(index)
            }
        };
        let build = |kind, damaged| first_proven(&hull, kind, damaged);
        let index = build(IndexKind::Tree, damaged(&[IndexKind::Tree])).unwrap();
        assert_eq!(index.kind, IndexKind::Binary);
        assert!(matches!(index.replaces, Some((IndexKind::Tree, Unproven::Missing { .. }))));
        let index = build(IndexKind::Compact, damaged(&[IndexKind::Compact, IndexKind::Binary])).unwrap();
        assert_eq!((index.kind, index.replaces.map(|(kind, _)| kind)), (IndexKind::None, Some(IndexKind::Compact)));
        let index = build(IndexKind::Tree, damaged(&[])).unwrap();
        assert_eq!((index.kind, index.replaces), (IndexKind::Tree, None));
    }
}
