//! The tree of bounding boxes over a pack's hulls: which hulls may meet a box, without a look at all of them.
//!
//! A binary tree with one hull a leaf, in [`Pack::nodes`](crate::archive::Pack::nodes). A box is that of the hulls' vertices,
//! exactly, in the frame that all hulls of a pack share. Nodes stand breadth first, the two children of a node side by side, in
//! the order of their parents: so one pass tells whether it is a tree.
//!
//! # Reference
//! Ericson, "Real-Time Collision Detection", 2005, chapter 6.

use rkyv::rend::f32_le;

use crate::archive::{ArchivedBvhNode, ArchivedPack};

/// Most levels of nodes, the root's included: a reader's stack need not grow.
pub const MAX_LEVELS: u32 = 32;

/// Number of nodes over `hull_count` hulls, of which there is at least one.
pub const fn node_count(hull_count: usize) -> usize {
    2 * hull_count - 1
}

/// Checks the tree of a pack whose spans and hulls have been checked.
///
/// # Errors
/// What is wrong with it.
///
/// # Complexity
/// O(number of hulls), no allocation.
pub(crate) fn check(pack: &ArchivedPack) -> Result<(), &'static str> {
    let (nodes, hulls) = (&pack.nodes, &pack.hulls);
    if nodes.len() != node_count(hulls.len()) {
        return Err("it has not one leaf a hull");
    }
    // First child of the next inner node; nodes of a level are followed by all of their children.
    let mut free = 1;
    let (mut level_end, mut levels) = (1, 1);
    for (number, node) in nodes.iter().enumerate() {
        if number >= free {
            return Err("a node is nobody's child");
        }
        if number == level_end {
            (level_end, levels) = (free, levels + 1);
        }
        let target = node.target.to_native() as usize;
        if node.hull_count == 1 {
            let hull = hulls.get(target).ok_or("a leaf names a hull that is not there")?;
            if hull.leaf.to_native() as usize != number {
                return Err("a leaf and its hull do not name each other");
            }
            if node.bounds_min != hull.bounds_min || node.bounds_max != hull.bounds_max {
                return Err("a leaf's box is not that of its hull");
            }
            continue;
        }
        if target != free {
            return Err("children do not stand in the order of their parents");
        }
        let [first, second] = [free, free + 1].map(|child| nodes.get(child));
        let (Some(first), Some(second)) = (first, second) else { return Err("a child is not there") };
        free += 2;
        let below = first.hull_count.to_native().checked_add(second.hull_count.to_native());
        if below != Some(node.hull_count.to_native()) {
            return Err("a node counts other hulls than its children");
        }
        if !is_union(node, first, second) {
            return Err("a box is not that of the boxes below");
        }
    }
    // Each leaf is named by its hull alone, and there are as many leaves as hulls: each hull has one.
    if free != nodes.len() {
        return Err("a child is not there");
    }
    if levels > MAX_LEVELS { Err("it is too deep") } else { Ok(()) }
}

/// Whether a node's box is the least around those of its children. False where a number is NaN.
fn is_union(node: &ArchivedBvhNode, first: &ArchivedBvhNode, second: &ArchivedBvhNode) -> bool {
    let same = |of: &[f32_le; 3], a: &[f32_le; 3], b: &[f32_le; 3], pick: fn(f32, f32) -> f32| {
        of.iter().zip(a.iter().zip(b)).all(|(of, (a, b))| of.to_native() == pick(a.to_native(), b.to_native()))
    };
    same(&node.bounds_min, &first.bounds_min, &second.bounds_min, f32::min)
        && same(&node.bounds_max, &first.bounds_max, &second.bounds_max, f32::max)
}
