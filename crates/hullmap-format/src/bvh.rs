//! BVH: the tree of bounding boxes over a pack's hulls, a binary tree with one hull per leaf, in
//! [`Pack::nodes`](crate::archive::Pack::nodes). Boxes are exact, in the common frame of the hulls.
//! Nodes are stored breadth first, the two children of a node adjacent, in the order of their
//! parents. So one pass checks the whole tree.
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, chapter 6.

use rkyv::rend::f32_le;

pub use crate::archive::MAX_LEVELS;
pub use crate::check_error::BvhError;
use crate::{archive::ArchivedBvhNode, sections::Sections};

/// Number of nodes over `hull_count` hulls, at least one.
pub const fn node_count(hull_count: usize) -> usize {
    2 * hull_count - 1
}

/// Checks the tree of a pack whose spans and hulls have been checked: O(hulls), no allocation.
pub(crate) fn check(pack: &Sections<'_>) -> Result<(), BvhError> {
    let (nodes, hulls) = (pack.nodes, pack.hulls);
    let expected = node_count(hulls.len());
    if nodes.len() != expected {
        return Err(BvhError::NodeCount { found: nodes.len(), expected });
    }
    // `free` is the first child of the next inner node: a level is followed by all its children.
    let mut free = 1;
    let (mut level_end, mut levels) = (1, 1);
    for (index, node) in nodes.iter().enumerate() {
        if index >= free {
            return Err(BvhError::NoParent { node: index });
        }
        if index == level_end {
            (level_end, levels) = (free, levels + 1);
        }
        if node.hull_count == 1 {
            check_leaf(pack, index, node)?;
        } else {
            check_inner(nodes, index, node, free)?;
            free += 2;
        }
    }
    // Every node except the root is a child, and no child is out of range, so all nodes are in the
    // tree. Each leaf is in its hull's record, so no two leaves share a hull, and there are as
    // many.
    if levels > MAX_LEVELS { Err(BvhError::Levels { found: levels }) } else { Ok(()) }
}

fn check_leaf(pack: &Sections<'_>, index: usize, node: &ArchivedBvhNode) -> Result<(), BvhError> {
    let target = node.target.to_native() as usize;
    let missing = BvhError::Hull { node: index, found: target, hull_count: pack.hulls.len() };
    let hull = pack.hulls.get(target).ok_or(missing)?;
    let found = hull.leaf.to_native() as usize;
    if found != index {
        return Err(BvhError::Leaf { node: index, hull: target, found });
    }
    // False if a coordinate is NaN.
    let is_equal = node.bounds_min == hull.bounds_min && node.bounds_max == hull.bounds_max;
    if is_equal { Ok(()) } else { Err(BvhError::LeafBox { node: index, hull: target }) }
}

/// Checks an inner node whose children must be `free` and the node after it.
fn check_inner(nodes: &[ArchivedBvhNode], index: usize, node: &ArchivedBvhNode, free: usize) -> Result<(), BvhError> {
    let target = node.target.to_native() as usize;
    if target != free {
        return Err(BvhError::ChildOrder { node: index, found: target, expected: free });
    }
    let [Some(first), Some(second)] = [free, free + 1].map(|child| nodes.get(child)) else {
        return Err(BvhError::ChildRange { node: index, first: free, node_count: nodes.len() });
    };
    let (found, expected) = (node.hull_count.to_native(), [first, second].map(|child| child.hull_count.to_native()));
    let [a, b] = expected;
    if a.checked_add(b) != Some(found) {
        return Err(BvhError::HullCount { node: index, found, expected });
    }
    if is_union(node, first, second) { Ok(()) } else { Err(BvhError::Box { node: index }) }
}

/// Whether a node's box is the union of its children's boxes. False if a coordinate is NaN.
fn is_union(node: &ArchivedBvhNode, first: &ArchivedBvhNode, second: &ArchivedBvhNode) -> bool {
    let same = |of: &[f32_le; 3], a: &[f32_le; 3], b: &[f32_le; 3], pick: fn(f32, f32) -> f32| {
        of.iter().zip(a.iter().zip(b)).all(|(of, (a, b))| of.to_native() == pick(a.to_native(), b.to_native()))
    };
    same(&node.bounds_min, &first.bounds_min, &second.bounds_min, f32::min)
        && same(&node.bounds_max, &first.bounds_max, &second.bounds_max, f32::max)
}

#[cfg(test)]
mod tests {
    use rkyv::util::AlignedVec;

    use super::*;
    use crate::archive::{BvhNode, HullRecord, Pack};

    fn leaf(hull: u32) -> BvhNode {
        BvhNode { target: hull, hull_count: 1, ..BvhNode::default() }
    }

    fn inner(first_child: u32, hull_count: u32) -> BvhNode {
        BvhNode { target: first_child, hull_count, ..BvhNode::default() }
    }

    fn checked(nodes: Vec<BvhNode>, leaves: &[u32]) -> Result<(), BvhError> {
        let hulls = leaves.iter().map(|&leaf| HullRecord { leaf, ..HullRecord::default() }).collect();
        let pack = Pack { nodes, hulls, ..Pack::default() };
        let bytes = rkyv::api::high::to_bytes_in::<_, rkyv::rancor::Error>(&pack, AlignedVec::<64>::new()).unwrap();
        check(&Sections::read(&bytes).unwrap())
    }

    #[test]
    fn valid_trees_pass() {
        assert_eq!(checked(vec![leaf(0)], &[0]), Ok(()));
        assert_eq!(checked(vec![inner(1, 3), inner(3, 2), leaf(2), leaf(1), leaf(0)], &[4, 3, 2]), Ok(()));
    }

    #[test]
    fn trees_with_too_few_or_stray_nodes_are_rejected() {
        assert_eq!(checked(vec![leaf(0)], &[0, 0]), Err(BvhError::NodeCount { found: 1, expected: 3 }));
        assert_eq!(checked(vec![leaf(0), leaf(1), leaf(1)], &[0, 1]), Err(BvhError::NoParent { node: 1 }));
        let childless = checked(vec![inner(1, 2), leaf(0), inner(3, 1 << 31)], &[1, 1]);
        assert_eq!(childless, Err(BvhError::HullCount { node: 0, found: 2, expected: [1, 1 << 31] }));
        let range = checked(vec![inner(1, 3), leaf(0), inner(3, 2)], &[1, 2]);
        assert_eq!(range, Err(BvhError::ChildRange { node: 2, first: 3, node_count: 3 }));
    }

    #[test]
    fn leaves_that_contradict_their_hulls_are_rejected() {
        assert_eq!(checked(vec![leaf(1)], &[0]), Err(BvhError::Hull { node: 0, found: 1, hull_count: 1 }));
        assert_eq!(checked(vec![leaf(0)], &[7]), Err(BvhError::Leaf { node: 0, hull: 0, found: 7 }));
        let far = BvhNode { bounds_max: [1.0; 3], ..leaf(0) };
        assert_eq!(checked(vec![far], &[0]), Err(BvhError::LeafBox { node: 0, hull: 0 }));
        let nan = BvhNode { bounds_min: [f32::NAN; 3], ..leaf(0) };
        assert_eq!(checked(vec![nan], &[0]), Err(BvhError::LeafBox { node: 0, hull: 0 }));
    }

    /// Every inner node has one leaf and one inner node as children, except the last.
    #[test]
    fn trees_with_too_many_levels_are_rejected() {
        let chain = |levels: u32| {
            let hull_count = levels;
            let (mut nodes, mut leaves) = (vec![], vec![]);
            for level in 0..levels - 1 {
                nodes.push(inner(2 * level + 1, hull_count - level));
                nodes.push(leaf(level));
                leaves.push(2 * level + 1);
            }
            // Breadth first, the leaf comes first: root, leaf 0, inner, leaf 1, …
            nodes.push(leaf(levels - 1));
            leaves.push(2 * (levels - 1));
            checked(nodes, &leaves)
        };
        assert_eq!(chain(MAX_LEVELS), Ok(()));
        assert_eq!(chain(MAX_LEVELS + 1), Err(BvhError::Levels { found: MAX_LEVELS + 1 }));
    }
}
