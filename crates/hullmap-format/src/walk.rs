//! One pass over a direction index: is it well formed, and what does a query cost at worst?
//!
//! The nodes of an index stand breadth first, without gaps ([`crate::slot`]). So the pass needs no recursion: it reads
//! the words from the front, and each slot that names a node must name the next free place. An index that passes is a
//! tree: no cycle, no shared node, no dead word, every leaf's blocks in range.

use std::collections::VecDeque;

use crate::{
    archive::LANES,
    cube::GRID_BITS,
    slot::{Slot, decode_normal},
};

/// Most nodes on a path: every bit of both grid numbers, then as many planes as halve all vertices, with room to spare.
pub const MAX_NODES: u32 = 2 * GRID_BITS + 64;

/// What a support query costs at worst, over all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Most nodes visited.
    pub nodes: u32,
    /// Most vertices multiplied with the direction.
    pub dots: u32,
}

/// Why an index is not one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IndexError {
    /// The array ends before the roots, or before a node.
    #[error("the direction index ends at word {at}, inside a node")]
    Short {
        /// Length of the array.
        at: usize,
    },
    /// Words are left over that no slot names.
    #[error("the direction index has words from {at} on that nothing refers to")]
    Unused {
        /// First unused word.
        at: usize,
    },
    /// A slot names another place than the next free one.
    #[error("slot {slot} of the direction index refers to word {found}, where {expected} comes next")]
    Order {
        /// Place of the slot.
        slot: usize,
        /// Place it names.
        found: u32,
        /// Next free place.
        expected: usize,
    },
    /// A leaf names a block that is not there, or no block.
    #[error("slot {slot} of the direction index refers to {count} blocks from {first} on, of {block_count}")]
    Blocks {
        /// Place of the slot.
        slot: usize,
        /// First block it names.
        first: u32,
        /// Number of blocks it names.
        count: u32,
        /// Blocks there are.
        block_count: u32,
    },
    /// A path is longer than any the baker writes.
    #[error("slot {slot} of the direction index lies deeper than {MAX_NODES} nodes")]
    Deep {
        /// Place of the slot.
        slot: usize,
    },
    /// A plane's normal is not finite.
    #[error("the plane at word {at} of the direction index is not finite")]
    Plane {
        /// Place of the plane node.
        at: usize,
    },
    /// An axis node below a plane node, or deeper than the grid has bits, or in a cube map.
    #[error("slot {slot} of the direction index is an axis node where none can stand")]
    Misplaced {
        /// Place of the slot.
        slot: usize,
    },
}

/// What kind of node comes next in the array, and how deep its children lie.
#[derive(Clone, Copy)]
struct Pending {
    slot: Slot,
    depth: u32,
    axis_depth: u32,
}

/// Checks an index of `len` words, read by `word`, whose first `root_count` words are its roots.
///
/// `axis_nodes` says whether roots may be axis nodes (trees) or not (cube maps).
///
/// # Errors
/// The first place at which the array is not an index.
///
/// # Complexity
/// O(len) time; memory for the widest level.
pub fn walk(
    root_count: usize,
    axis_nodes: bool,
    len: usize,
    word: impl Fn(usize) -> u32,
    block_count: u32,
) -> Result<Cost, IndexError> {
    if len < root_count {
        return Err(IndexError::Short { at: len });
    }
    let axis_limit = if axis_nodes { 2 * GRID_BITS } else { 0 };
    let mut walk = Walk { len, word, block_count, free: root_count, cost: Cost::default(), pending: VecDeque::new() };
    for root in 0..root_count {
        walk.slot(root, 0, axis_limit)?;
    }
    let mut at = root_count;
    while let Some(node) = walk.pending.pop_front() {
        match node.slot {
            Slot::Axis(_) => {
                walk.slot(at, node.depth, node.axis_depth)?;
                walk.slot(at + 1, node.depth, node.axis_depth)?;
            }
            Slot::Plane(_) => {
                let words = std::array::from_fn(|i| (walk.word)(at + i));
                if !decode_normal(words).iter().all(|n| n.is_finite()) {
                    return Err(IndexError::Plane { at });
                }
                walk.slot(at + 6, node.depth, 0)?;
                walk.slot(at + 7, node.depth, 0)?;
            }
            // A list's words were read when its slot was.
            Slot::List(_) | Slot::Block(_) => {}
        }
        at += node.slot.words() as usize;
    }
    if walk.free == len { Ok(walk.cost) } else { Err(IndexError::Unused { at: walk.free }) }
}

struct Walk<F> {
    len: usize,
    word: F,
    block_count: u32,
    /// Next place that no slot has named yet.
    free: usize,
    cost: Cost,
    pending: VecDeque<Pending>,
}

impl<F: Fn(usize) -> u32> Walk<F> {
    /// Reads the slot at `at`, `depth` nodes below its root, of which `axis_left` more may be axis nodes.
    fn slot(&mut self, at: usize, depth: u32, axis_left: u32) -> Result<(), IndexError> {
        let slot = Slot::decode((self.word)(at));
        if depth > MAX_NODES {
            return Err(IndexError::Deep { slot: at });
        }
        match slot {
            Slot::Block(block) => self.leaf(at, depth, block, 1),
            Slot::List(place) => {
                let place = self.node(at, place, slot)?;
                let (first, count) = ((self.word)(place), (self.word)(place + 1));
                self.pending.push_back(Pending { slot, depth, axis_depth: 0 });
                self.leaf(at, depth, first, count)
            }
            Slot::Axis(place) => {
                let axis_depth = axis_left.checked_sub(1).ok_or(IndexError::Misplaced { slot: at })?;
                self.node(at, place, slot)?;
                self.pending.push_back(Pending { slot, depth: depth + 1, axis_depth });
                Ok(())
            }
            Slot::Plane(place) => {
                self.node(at, place, slot)?;
                self.pending.push_back(Pending { slot, depth: depth + 1, axis_depth: 0 });
                Ok(())
            }
        }
    }

    /// Claims the words of the node that the slot at `at` names.
    fn node(&mut self, at: usize, place: u32, slot: Slot) -> Result<usize, IndexError> {
        if place as usize != self.free {
            return Err(IndexError::Order { slot: at, found: place, expected: self.free });
        }
        let end = self.free + slot.words() as usize;
        if end > self.len {
            return Err(IndexError::Short { at: self.len });
        }
        Ok(std::mem::replace(&mut self.free, end))
    }

    fn leaf(&mut self, at: usize, depth: u32, first: u32, count: u32) -> Result<(), IndexError> {
        let in_range = count > 0 && first.checked_add(count).is_some_and(|end| end <= self.block_count);
        if !in_range {
            return Err(IndexError::Blocks { slot: at, first, count, block_count: self.block_count });
        }
        self.cost.nodes = self.cost.nodes.max(depth);
        self.cost.dots = self.cost.dots.max(count.saturating_mul(LANES as u32));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slot::encode_normal;

    fn check(words: &[u32], roots: usize, blocks: u32) -> Result<Cost, IndexError> {
        walk(roots, true, words.len(), |i| words[i], blocks)
    }

    /// One root: an axis node over a block and a plane node over a block and a list.
    fn sample() -> Vec<u32> {
        let mut words = vec![Slot::Axis(1).encode(), Slot::Block(0).encode(), Slot::Plane(3).encode()];
        words.extend(encode_normal([1.0, 0.0, -1.0]));
        words.extend([Slot::Block(1).encode(), Slot::List(11).encode(), 2, 3]);
        words
    }

    #[test]
    fn a_sample_passes_and_is_priced() {
        assert_eq!(check(&sample(), 1, 5), Ok(Cost { nodes: 2, dots: 24 }));
    }

    #[test]
    fn every_damage_is_named() {
        let with = |at: usize, word: u32| {
            let mut words = sample();
            words[at] = word;
            words
        };
        assert!(matches!(check(&sample(), 1, 4), Err(IndexError::Blocks { slot: 10, .. })), "list past the end");
        assert!(matches!(check(&with(12, 0), 1, 5), Err(IndexError::Blocks { .. })), "empty list");
        assert!(matches!(check(&with(12, u32::MAX), 1, 5), Err(IndexError::Blocks { .. })), "overflow");
        assert!(matches!(check(&with(1, Slot::Axis(1).encode()), 1, 5), Err(IndexError::Order { .. })), "cycle");
        assert!(matches!(check(&with(9, Slot::Plane(3).encode()), 1, 5), Err(IndexError::Order { .. })), "own parent");
        assert!(matches!(check(&with(4, u32::MAX), 1, 5), Err(IndexError::Plane { at: 3 })), "NaN");
        assert!(matches!(check(&with(9, Slot::Axis(11).encode()), 1, 5), Err(IndexError::Misplaced { slot: 9 })));
        assert!(matches!(check(&sample()[..12], 1, 5), Err(IndexError::Short { .. })));
        let mut longer = sample();
        longer.push(0);
        assert!(matches!(check(&longer, 1, 5), Err(IndexError::Unused { at: 13 })));
        assert!(matches!(check(&[], 6, 5), Err(IndexError::Short { .. })));
    }

    #[test]
    fn endless_chains_of_planes_are_refused() {
        let mut words = vec![Slot::Plane(1).encode()];
        for i in 0..200 {
            words.extend([0; 6]);
            words.extend([Slot::Block(0).encode(), Slot::Plane(1 + 8 * (i + 1)).encode()]);
        }
        assert!(matches!(check(&words, 1, 1), Err(IndexError::Deep { .. })));
    }
}
