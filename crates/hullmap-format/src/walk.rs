//! One pass over a direction index: is it well formed, and what does a query cost at worst?
//!
//! The nodes of an index stand breadth first, without gaps ([`crate::slot`]). So the pass needs no recursion: it reads
//! the words from the front, and each slot that names a node must name the next free place, or the same planes, fan or
//! list as an earlier slot of its own node. An index that passes has no cycle, no node below two others, no dead word, and every
//! leaf's blocks in range.

use std::collections::VecDeque;

use crate::{
    archive::LANES,
    cube::GRID_BITS,
    fan,
    slot::{
        BUNDLE_PARTS, BUNDLE_PLANES, BUNDLE_WORDS, Branch, HALVES_WORDS, LIST_WORDS, MAX_BRANCH_BITS, PLANE_WORDS,
        Slot, decode_f64,
    },
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

/// What an index is made of, beside its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Slots at the front.
    pub roots: usize,
    /// What a branch is.
    pub branches: Branches,
    /// Blocks of a plain leaf.
    pub leaf_blocks: u32,
    /// Blocks there are.
    pub block_count: u32,
}

impl Shape {
    /// What scanning all blocks costs.
    pub fn scan_cost(&self) -> Cost {
        Cost { nodes: 0, dots: self.block_count.saturating_mul(LANES as u32) }
    }
}

/// What a branch of an index is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branches {
    /// There are none (cube map).
    None,
    /// Halves, across u and v in turn (binary tree).
    Halves,
    /// Squares (tree).
    Squares,
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
    /// A path is longer than [`MAX_NODES`].
    #[error("slot {slot} of the direction index lies deeper than {MAX_NODES} nodes")]
    Deep {
        /// Place of the slot.
        slot: usize,
    },
    /// The normal of a plane, or of one of a bundle, or a number of a fan is not finite.
    #[error("the planes at word {at} of the direction index are not finite")]
    Plane {
        /// Place of the planes.
        at: usize,
    },
    /// A word that no slot is written as.
    #[error("slot {slot} of the direction index is of no known kind")]
    Unknown {
        /// Place of the slot.
        slot: usize,
    },
    /// A branch below planes or a fan, finer than the grid, or in a cube map; planes or a fan in a cube map.
    #[error("slot {slot} of the direction index is a node where none can stand")]
    Misplaced {
        /// Place of the slot.
        slot: usize,
    },
}

/// A node whose words come next in the array.
#[derive(Clone, Copy)]
struct Node {
    slot: Slot,
    place: u32,
    /// Nodes on the path, this one included.
    depth: u32,
    /// Bits of both grid numbers that branches below it may still consume.
    bits_left: u32,
}

/// Checks an index of `len` words, read by `word`.
///
/// # Errors
/// The first place at which the array is not an index.
///
/// # Complexity
/// O(len) time; memory for the widest level.
pub fn walk(shape: Shape, len: usize, word: impl Fn(usize) -> u32) -> Result<Cost, IndexError> {
    if len < shape.roots {
        return Err(IndexError::Short { at: len });
    }
    let bits_left = if shape.branches == Branches::None { 0 } else { 2 * GRID_BITS };
    let mut walk =
        Walk { shape, len, word, free: shape.roots, cost: Cost::default(), pending: VecDeque::new(), older: 0 };
    walk.slots(0, shape.roots, 0, bits_left)?;
    let mut at = shape.roots;
    while let Some(Node { slot, depth, bits_left, .. }) = walk.pending.pop_front() {
        match slot {
            Slot::Branch(payload) => {
                let count = walk.branch(payload).1 as usize;
                walk.slots(at, count, depth, bits_left)?;
            }
            Slot::Plane(_) => {
                walk.numbers(at, 3)?;
                walk.slots(at + 6, 2, depth, 0)?;
            }
            Slot::Bundle(_) => {
                walk.numbers(at, 3 * BUNDLE_PLANES)?;
                walk.slots(at + 6 * BUNDLE_PLANES, BUNDLE_PARTS, depth, 0)?;
            }
            Slot::Fan(_) => {
                walk.numbers(at, fan::HEAD_WORDS as usize / 2)?;
                let head = fan::HEAD_WORDS as usize;
                walk.slots(at + head, walk.words(slot) as usize - head, depth, 0)?;
            }
            // A list's words were read when its slot was.
            Slot::List(_) | Slot::Block(_) => {}
        }
        at += walk.words(slot) as usize;
    }
    if walk.free == len { Ok(walk.cost) } else { Err(IndexError::Unused { at: walk.free }) }
}

struct Walk<F> {
    shape: Shape,
    len: usize,
    word: F,
    /// Next place that no slot has named yet.
    free: usize,
    cost: Cost,
    pending: VecDeque<Node>,
    /// How many of `pending` were there before the node being read.
    older: usize,
}

impl<F: Fn(usize) -> u32> Walk<F> {
    /// Place and number of slots of a branch. Bits past the limit make a node that cannot fit.
    fn branch(&self, payload: u32) -> (u32, u32) {
        match self.shape.branches {
            Branches::Squares => {
                let Branch { at, bits } = Branch::decode(payload);
                (at, if bits > MAX_BRANCH_BITS { u32::MAX } else { 1 << (2 * bits) })
            }
            Branches::Halves | Branches::None => (payload, HALVES_WORDS),
        }
    }

    /// Words that what lies below a slot takes; more than there can be where it is not one.
    fn words(&self, slot: Slot) -> u32 {
        match slot {
            Slot::Branch(payload) => self.branch(payload).1,
            Slot::Block(_) => 0,
            Slot::Plane(_) => PLANE_WORDS,
            Slot::Bundle(_) => BUNDLE_WORDS,
            Slot::Fan(place) => {
                let last = place as usize + fan::HEAD_WORDS as usize - 1;
                let bits = if last < self.len { (self.word)(last) } else { u32::MAX };
                if (1..=fan::MAX_BITS).contains(&bits) { fan::HEAD_WORDS + (1 << bits) } else { u32::MAX }
            }
            Slot::List(_) => LIST_WORDS,
        }
    }

    fn numbers(&self, at: usize, count: usize) -> Result<(), IndexError> {
        let finite = (0..count).all(|i| decode_f64((self.word)(at + 2 * i), (self.word)(at + 2 * i + 1)).is_finite());
        if finite { Ok(()) } else { Err(IndexError::Plane { at }) }
    }

    /// Reads the `count` slots of one node, `depth` nodes below the root.
    fn slots(&mut self, at: usize, count: usize, depth: u32, bits_left: u32) -> Result<(), IndexError> {
        self.older = self.pending.len();
        for at in at..at + count {
            self.slot(at, depth, bits_left)?;
        }
        Ok(())
    }

    fn slot(&mut self, at: usize, depth: u32, bits_left: u32) -> Result<(), IndexError> {
        let word = (self.word)(at);
        let slot = Slot::decode(word);
        if slot.encode() != word {
            return Err(IndexError::Unknown { slot: at });
        }
        if depth > MAX_NODES {
            return Err(IndexError::Deep { slot: at });
        }
        let (place, bits) = match slot {
            Slot::Block(first) => return self.leaf(at, depth, first, self.shape.leaf_blocks),
            Slot::Branch(payload) => {
                let (place, count) = self.branch(payload);
                if count < 2 {
                    // It would divide nothing.
                    return Err(IndexError::Misplaced { slot: at });
                }
                (place, count.ilog2())
            }
            Slot::Plane(place) | Slot::Bundle(place) | Slot::Fan(place) | Slot::List(place) => (place, 0),
        };
        let planes = matches!(slot, Slot::Plane(_) | Slot::Bundle(_) | Slot::Fan(_));
        if bits > bits_left || (planes && self.shape.branches == Branches::None) {
            return Err(IndexError::Misplaced { slot: at });
        }
        if (place as usize) < self.free && self.is_of_this_node(slot, place) {
            return Ok(());
        }
        if place as usize != self.free {
            return Err(IndexError::Order { slot: at, found: place, expected: self.free });
        }
        let end = self.free.saturating_add(self.words(slot) as usize);
        if end > self.len {
            return Err(IndexError::Short { at: self.len });
        }
        self.free = end;
        self.pending.push_back(Node { slot, place, depth: depth + 1, bits_left: bits_left - bits });
        if let Slot::List(_) = slot {
            let place = place as usize;
            return self.leaf(at, depth, (self.word)(place), (self.word)(place + 1));
        }
        Ok(())
    }

    /// Whether another slot of the node being read has named the same planes, fan or list. Pending nodes ascend by place.
    fn is_of_this_node(&self, slot: Slot, place: u32) -> bool {
        let found = self.pending.partition_point(|node| node.place < place);
        let is_same = self.pending.get(found).is_some_and(|node| node.slot == slot);
        found >= self.older && is_same && !matches!(slot, Slot::Branch(_))
    }

    fn leaf(&mut self, at: usize, depth: u32, first: u32, count: u32) -> Result<(), IndexError> {
        let block_count = self.shape.block_count;
        let in_range = count > 0 && first.checked_add(count).is_some_and(|end| end <= block_count);
        if !in_range {
            return Err(IndexError::Blocks { slot: at, first, count, block_count });
        }
        self.cost.nodes = self.cost.nodes.max(depth);
        self.cost.dots = self.cost.dots.max(count.saturating_mul(LANES as u32));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slot::{BRANCH_LIMIT, encode_f64};

    fn check(words: &[u32], roots: usize, block_count: u32, branches: Branches) -> Result<Cost, IndexError> {
        walk(Shape { roots, branches, leaf_blocks: 1, block_count }, words.len(), |i| words[i])
    }

    fn normal(n: [f64; 3]) -> Vec<u32> {
        n.into_iter().flat_map(encode_f64).collect()
    }

    /// One root: a fan of four steps, of which the first two are one plane, the others a block and a fan of two blocks.
    fn fans() -> Vec<u32> {
        let head = |bits: u32| {
            let mut words = normal([1.0, 0.0, 0.0]);
            words.extend(normal([0.0, 1.0, 0.0]));
            words.extend([-1.0, 0.5].into_iter().flat_map(encode_f64));
            words.push(bits);
            words
        };
        let mut words = vec![Slot::Fan(1).encode()];
        words.extend(head(2));
        words.extend([Slot::Plane(22), Slot::Plane(22), Slot::Block(0), Slot::Fan(30)].map(Slot::encode));
        words.extend(normal([0.0, 0.0, 1.0]));
        words.extend([Slot::Block(1).encode(); 2]);
        words.extend(head(1));
        words.extend([Slot::Block(2).encode(); 2]);
        words
    }

    #[test]
    fn every_damage_of_a_fan_is_named() {
        let check = |words: &[u32]| check(words, 1, 3, Branches::Squares);
        let with = |at: usize, word: u32| {
            let mut words = fans();
            words[at] = word;
            check(&words)
        };
        let all = fans();
        assert_eq!(all.len(), 49);
        assert_eq!(check(&all), Ok(Cost { nodes: 2, dots: 8 }));
        for bits in [0, fan::MAX_BITS + 1, 31, 32, u32::MAX] {
            assert!(matches!(with(17, bits), Err(IndexError::Short { at: 49 })), "{bits} bits");
        }
        assert!(matches!(with(17, 1), Err(IndexError::Order { slot: 18, .. })), "fewer steps");
        assert!(matches!(with(17, fan::MAX_BITS), Err(IndexError::Short { .. })), "more steps than there are");
        for number in 0..8 {
            for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(matches!(with(2 + 2 * number, encode_f64(odd)[1]), Err(IndexError::Plane { at: 1 })), "{odd}");
            }
        }
        assert!(matches!(check(&all[..10]), Err(IndexError::Short { .. })), "head cut short");
        assert!(matches!(check(&all[..17]), Err(IndexError::Short { .. })), "head without its bits");
        assert!(matches!(check(&all[..20]), Err(IndexError::Short { .. })), "slots cut short");
        assert!(matches!(check(&all[..48]), Err(IndexError::Short { .. })), "slots of the inner fan cut short");
        assert!(matches!(with(0, Slot::Fan(1).encode() | 3), Err(IndexError::Unknown { slot: 0 })));
        assert!(matches!(with(20, Slot::Fan(22).encode() | 3), Err(IndexError::Unknown { slot: 20 })));
        let branch = Slot::Branch(Branch { at: 30, bits: 1 }.encode()).encode();
        assert!(matches!(with(21, branch), Err(IndexError::Misplaced { slot: 21 })), "a branch below a fan");
        assert!(matches!(with(21, Slot::Fan(1).encode()), Err(IndexError::Order { slot: 21, .. })), "its own parent");
        assert!(matches!(with(19, Slot::Fan(22).encode()), Err(IndexError::Order { slot: 19, .. })), "another kind");
        assert!(matches!(with(47, Slot::Block(3).encode()), Err(IndexError::Blocks { slot: 47, .. })));
        assert!(matches!(super::tests::check(&all, 1, 3, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        assert!(super::tests::check(&all, 1, 3, Branches::Halves).is_ok());
    }

    /// One root: four squares, of which two share a plane node over a block and a list; the last are a bundle and a block.
    fn sample() -> Vec<u32> {
        let mut words = vec![Slot::Branch(Branch { at: 1, bits: 1 }.encode()).encode()];
        words.extend([Slot::Plane(5), Slot::Plane(5), Slot::Bundle(13), Slot::Block(0)].map(Slot::encode));
        words.extend(normal([1.0, 0.0, -1.0]));
        words.extend([Slot::Block(1), Slot::List(63)].map(Slot::encode));
        for i in 0..7 {
            words.extend(normal([0.0, f64::from(i), 1.0]));
        }
        words.extend([Slot::Block(2).encode(); 8]);
        words.extend([2, 3]);
        words
    }

    #[test]
    fn a_sample_passes_and_is_priced() {
        assert_eq!(check(&sample(), 1, 5, Branches::Squares), Ok(Cost { nodes: 2, dots: 24 }));
        let halves =
            [Slot::Branch(1), Slot::Block(0), Slot::Branch(3), Slot::Block(1), Slot::Block(0)].map(Slot::encode);
        assert_eq!(check(&halves, 1, 2, Branches::Halves), Ok(Cost { nodes: 2, dots: 8 }));
    }

    #[test]
    fn every_damage_is_named() {
        let squares = |words: &[u32], block_count| check(words, 1, block_count, Branches::Squares);
        let with = |at: usize, word: u32| {
            let mut words = sample();
            words[at] = word;
            squares(&words, 5)
        };
        assert!(matches!(squares(&sample(), 4), Err(IndexError::Blocks { slot: 12, .. })), "list past the end");
        assert!(matches!(with(64, 0), Err(IndexError::Blocks { .. })), "empty list");
        assert!(matches!(with(64, u32::MAX), Err(IndexError::Blocks { .. })), "overflow");
        let own_root = Slot::Branch(Branch { at: 1, bits: 1 }.encode()).encode();
        assert!(matches!(with(4, own_root), Err(IndexError::Order { .. })), "cycle");
        assert!(matches!(with(11, Slot::Plane(5).encode()), Err(IndexError::Order { .. })), "own parent");
        assert!(matches!(with(2, Slot::Bundle(5).encode()), Err(IndexError::Order { .. })), "another kind");
        assert!(matches!(with(6, u32::MAX), Err(IndexError::Plane { at: 5 })), "NaN");
        let misplaced = Slot::Branch(Branch { at: 63, bits: 1 }.encode()).encode();
        assert!(matches!(with(11, misplaced), Err(IndexError::Misplaced { slot: 11 })));
        assert!(matches!(check(&sample(), 1, 5, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        let mut planes = vec![Slot::Plane(1).encode()];
        planes.extend(normal([1.0; 3]));
        planes.extend([Slot::Block(0).encode(); 2]);
        assert!(check(&planes, 1, 1, Branches::Squares).is_ok());
        assert!(matches!(check(&planes, 1, 1, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        let huge = Slot::Branch(Branch { at: 1, bits: 12 }.encode() | 15).encode();
        assert!(squares(&[huge, 0, 0], 5).is_err());
        let far = Slot::Branch(Branch { at: BRANCH_LIMIT - 1, bits: 1 }.encode()).encode();
        assert!(matches!(squares(&[far, 0, 0], 5), Err(IndexError::Order { .. })));
        assert!(matches!(squares(&sample()[..64], 5), Err(IndexError::Short { .. })));
        let mut longer = sample();
        longer.push(0);
        assert!(matches!(squares(&longer, 5), Err(IndexError::Unused { at: 65 })));
        assert!(matches!(squares(&[], 5), Err(IndexError::Short { .. })));
    }

    #[test]
    fn endless_chains_of_planes_are_refused() {
        let mut words = vec![Slot::Plane(1).encode()];
        for i in 0..200 {
            words.extend([0; 6]);
            words.extend([Slot::Block(0).encode(), Slot::Plane(1 + 8 * (i + 1)).encode()]);
        }
        assert!(matches!(check(&words, 1, 1, Branches::Squares), Err(IndexError::Deep { .. })));
        // Branches of one square, which divide nothing.
        let chain: Vec<u32> = (1..200).map(|at| Slot::Branch(Branch { at, bits: 0 }.encode()).encode()).collect();
        assert!(check(&chain, 1, 1, Branches::Squares).is_err());
    }
}
