//! One breadth-first pass over a direction index. It checks that the index is well formed, and
//! finds the worst cost of a query.
//!
//! [`SlotWalk`] is an iterator over all slots, and checks each before it returns it. [`walk`] runs
//! it to its end.
//!
//! The nodes of an index are stored breadth first, without gaps ([`crate::slot`]). So the pass
//! needs no recursion: it reads the words from the front. Each slot that refers to a node must
//! refer to the next free word, or to the same planes, fan or list as an earlier slot of its own
//! node. An index that passes has no cycle, no node below two others and no unused word, and the
//! blocks of every leaf are in range.

use std::{collections::VecDeque, ops::Range};

pub use crate::node::Branches;
use crate::{
    archive::LANES,
    cube::GRID_BITS,
    fan,
    node::{Node, Words},
    slot::{MAX_BRANCH_BITS, Slot},
};

/// Maximum number of nodes on a path: one for each bit of both grid coordinates, then more planes
/// than halving the set of all vertices down to one takes.
pub const MAX_NODES: u32 = 2 * GRID_BITS + 64;

/// Worst cost of a support query over all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Maximum number of nodes visited.
    pub nodes: u32,
    /// Maximum number of dot products.
    pub dots: u32,
}

/// Facts about an index that are not in its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexShape {
    /// Number of slots at the front.
    pub roots: usize,
    /// How a branch divides its cell.
    pub branches: Branches,
    /// Number of blocks of a plain leaf.
    pub leaf_blocks: u32,
    /// Blocks of the hull.
    pub block_count: u32,
}

impl IndexShape {
    /// Cost of scanning all blocks.
    pub fn scan_cost(&self) -> Cost {
        Cost { nodes: 0, dots: self.block_count.saturating_mul(LANES as u32) }
    }
}

/// Why words are not a direction index.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum IndexError {
    /// The words end before the last root, or inside a node.
    #[error("the direction index ends at word {at}, inside a node")]
    Short { at: usize },
    /// Words are left over.
    #[error("no slot of the direction index refers to word {at} or to any word after it")]
    Unused { at: usize },
    /// A slot refers to a word that is not the next free one.
    #[error("slot {slot} of the direction index refers to word {found} (expected {expected}, the next free word)")]
    Order { slot: usize, found: usize, expected: usize },
    /// A leaf without blocks, or with blocks out of range.
    #[error(
        "slot {slot} of the direction index refers to {count} blocks from block {first} on (the hull has {block_count})"
    )]
    Blocks { slot: usize, first: u32, count: u32, block_count: u32 },
    /// A path is longer than [`MAX_NODES`].
    #[error("slot {slot} of the direction index is below more than {MAX_NODES} nodes")]
    Deep { slot: usize },
    /// A coordinate of a plane's normal, or a number before a fan's slots, is not finite.
    #[error("number {number} of the node at word {at} of the direction index is {found}, which is not finite")]
    NotFinite { at: usize, number: usize, found: f64 },
    /// A word is not the encoding of any slot.
    #[error("slot {slot} of the direction index has an unknown tag (word {found:#010x})")]
    Unknown { slot: usize, found: u32 },
    /// A branch or a fan has too many slots, or a fan has only one.
    #[error("slot {slot} of the direction index refers to a node of 2^{found} slots (expected 2^1 to 2^{max})")]
    Bits { slot: usize, found: u32, max: u32 },
    /// A branch is below planes or a fan, is finer than the grid, or is in a cube map; or planes or
    /// a fan are in a cube map.
    #[error("slot {slot} of the direction index refers to a node of a kind that is not allowed there")]
    Misplaced { slot: usize },
}

/// A slot of an index that has passed all checks so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Index of the slot's word.
    pub at: usize,
    /// Number of nodes on the path to it.
    pub depth: u32,
    /// The node or leaf below the slot.
    pub below: Below,
}

/// Node or leaf below a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum Below {
    /// A leaf, plain or list: its blocks.
    Leaf { first: u32, count: u32 },
    /// Any other node. Its own slots follow later.
    Node(Node),
}

/// Iterator over all slots of an index, breadth first. If several slots share a node, each of them
/// is visited, but the slots of the node only once.
///
/// The first error ends it.
///
/// ```
/// use hullmap_format::{
///     slot::Slot,
///     walk::{Below, Branches, IndexShape, SlotWalk},
/// };
///
/// // A cube map with one cell per face: six roots, all with the same leaf.
/// let words = [Slot::Block(0).encode(); 6];
/// let shape = IndexShape { roots: 6, branches: Branches::None, leaf_blocks: 1, block_count: 1 };
/// for visit in SlotWalk::new(shape, &words[..]) {
///     assert_eq!(visit?.below, Below::Leaf { first: 0, count: 1 });
/// }
/// # Ok::<(), hullmap_format::walk::IndexError>(())
/// ```
pub struct SlotWalk<'a, W: ?Sized> {
    shape: IndexShape,
    words: &'a W,
    /// Slots of the current node that have not been read yet.
    slots: Range<usize>,
    /// Nodes on the path to these slots.
    depth: u32,
    /// Bits of both grid coordinates that branches below these slots may still consume.
    bits_left: u32,
    /// Nodes whose slots have not been read yet, in the order of their words.
    pending: VecDeque<Pending>,
    /// Number of entries of `pending` to which nodes before the current one refer.
    older: usize,
    /// Next word that no slot has referred to yet.
    free: usize,
    is_done: bool,
}

/// A node whose slots have not been read yet.
#[derive(Clone, Copy)]
struct Pending {
    node: Node,
    /// Nodes on the path, this one included.
    depth: u32,
    bits_left: u32,
}

impl<'a, W: Words + ?Sized> SlotWalk<'a, W> {
    /// Starts at the first root.
    pub fn new(shape: IndexShape, words: &'a W) -> Self {
        let bits_left = if shape.branches == Branches::None { 0 } else { 2 * GRID_BITS };
        let (slots, pending) = (0..shape.roots, VecDeque::new());
        Self { shape, words, slots, depth: 0, bits_left, pending, older: 0, free: shape.roots, is_done: false }
    }

    /// The next slot; `None` after the last.
    fn advance(&mut self) -> Result<Option<Visit>, IndexError> {
        if self.free == self.shape.roots && self.words.word_count() < self.shape.roots {
            return Err(IndexError::Short { at: self.words.word_count() });
        }
        while self.slots.is_empty() {
            let Some(Pending { node, depth, bits_left }) = self.pending.pop_front() else {
                let is_whole = self.free == self.words.word_count();
                return if is_whole { Ok(None) } else { Err(IndexError::Unused { at: self.free }) };
            };
            self.check_numbers(node)?;
            (self.slots, self.depth, self.bits_left, self.older) = (node.slots(), depth, bits_left, self.pending.len());
        }
        let at = self.slots.start;
        self.slots.start += 1;
        self.visit(at).map(Some)
    }

    fn check_numbers(&self, node: Node) -> Result<(), IndexError> {
        let number = |i: usize| self.words.node_number(node.first_word(), i);
        match (0..node.number_count()).find(|&i| !number(i).is_finite()) {
            Some(i) => Err(IndexError::NotFinite { at: node.first_word(), number: i, found: number(i) }),
            None => Ok(()),
        }
    }

    fn visit(&mut self, at: usize) -> Result<Visit, IndexError> {
        let word = self.words.word(at);
        let slot = Slot::decode(word);
        if slot.encode() != word {
            return Err(IndexError::Unknown { slot: at, found: word });
        }
        if self.depth > MAX_NODES {
            return Err(IndexError::Deep { slot: at });
        }
        let node = match slot {
            Slot::Block(first) => return self.leaf(at, first, self.shape.leaf_blocks),
            _ => Node::below(slot, self.shape.branches, self.words),
        };
        // Only a plain leaf has no node.
        let Some(node) = node else { return Err(IndexError::Unknown { slot: at, found: word }) };
        let bits_left = self.check_place(at, node)?;
        if !(node.first_word() < self.free && self.is_of_this_node(node)) {
            self.claim(at, node)?;
            self.pending.push_back(Pending { node, depth: self.depth + 1, bits_left });
        }
        match node {
            Node::List { at: list } => self.leaf(at, self.words.word(list), self.words.word(list + 1)),
            _ => Ok(Visit { at, depth: self.depth, below: Below::Node(node) }),
        }
    }

    /// Checks that a node of this kind may be below the current node. Returns the bits of the grid
    /// that are left below it.
    fn check_place(&self, slot: usize, node: Node) -> Result<u32, IndexError> {
        let is_allowed = self.shape.branches != Branches::None;
        let (is_allowed, bits) = match node {
            Node::List { .. } => (true, 0),
            // Below planes and fans no branch is allowed, so no bits are left.
            Node::Plane { .. } | Node::Bundle { .. } | Node::Fan { .. } => (is_allowed, self.bits_left),
            Node::Halves { .. } => (is_allowed, 1),
            Node::Squares { bits, .. } if bits > MAX_BRANCH_BITS => {
                return Err(IndexError::Bits { slot, found: bits, max: MAX_BRANCH_BITS });
            }
            // A branch of one square divides nothing.
            Node::Squares { bits, .. } => (is_allowed && bits > 0, 2 * bits),
        };
        let left = self.bits_left.checked_sub(bits).filter(|_| is_allowed);
        left.ok_or(IndexError::Misplaced { slot })
    }

    /// Assigns the next free words to `node`. All of its words must exist.
    fn claim(&mut self, slot: usize, node: Node) -> Result<(), IndexError> {
        if node.first_word() != self.free {
            return Err(IndexError::Order { slot, found: node.first_word(), expected: self.free });
        }
        let len = self.words.word_count();
        if let Node::Fan { at, bits } = node {
            if at + fan::HEAD_WORDS as usize > len {
                return Err(IndexError::Short { at: len });
            }
            if !(1..=fan::MAX_BITS).contains(&bits) {
                return Err(IndexError::Bits { slot, found: bits, max: fan::MAX_BITS });
            }
        }
        if node.end() > len {
            return Err(IndexError::Short { at: len });
        }
        self.free = node.end();
        Ok(())
    }

    /// Whether an earlier slot of the current node refers to the same planes, fan or list. Pending
    /// nodes are in ascending order of their words.
    fn is_of_this_node(&self, node: Node) -> bool {
        let found = self.pending.partition_point(|pending| pending.node.first_word() < node.first_word());
        let is_same = self.pending.get(found).is_some_and(|pending| pending.node == node);
        found >= self.older && is_same && !matches!(node, Node::Halves { .. } | Node::Squares { .. })
    }

    fn leaf(&self, at: usize, first: u32, count: u32) -> Result<Visit, IndexError> {
        let block_count = self.shape.block_count;
        let in_range = count > 0 && first.checked_add(count).is_some_and(|end| end <= block_count);
        if !in_range {
            return Err(IndexError::Blocks { slot: at, first, count, block_count });
        }
        Ok(Visit { at, depth: self.depth, below: Below::Leaf { first, count } })
    }
}

impl<W: Words + ?Sized> Iterator for SlotWalk<'_, W> {
    type Item = Result<Visit, IndexError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_done {
            return None;
        }
        let next = self.advance();
        self.is_done = !matches!(next, Ok(Some(_)));
        next.transpose()
    }
}

/// Checks an index and returns the worst cost of a query.
///
/// # Errors
/// The first word that is not part of an index, and why.
///
/// # Complexity
/// O(words) time; memory for the widest level.
pub fn walk<W: Words + ?Sized>(shape: IndexShape, words: &W) -> Result<Cost, IndexError> {
    let mut cost = Cost::default();
    for visit in SlotWalk::new(shape, words) {
        let Visit { depth, below, .. } = visit?;
        if let Below::Leaf { count, .. } = below {
            cost.nodes = cost.nodes.max(depth);
            cost.dots = cost.dots.max(count.saturating_mul(LANES as u32));
        }
    }
    Ok(cost)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slot::{BRANCH_LIMIT, Branch, encode_f64};

    fn check(words: &[u32], roots: usize, block_count: u32, branches: Branches) -> Result<Cost, IndexError> {
        walk(IndexShape { roots, branches, leaf_blocks: 1, block_count }, words)
    }

    fn normal(n: [f64; 3]) -> Vec<u32> {
        n.into_iter().flat_map(encode_f64).collect()
    }

    /// One root: a fan of four steps. The first two share one plane; the others are a block and a
    /// fan of two blocks.
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
    fn damaged_fans_are_reported() {
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
            assert_eq!(with(17, bits), Err(IndexError::Bits { slot: 0, found: bits, max: fan::MAX_BITS }));
        }
        assert!(matches!(with(17, 1), Err(IndexError::Order { slot: 18, .. })), "fewer steps");
        assert!(matches!(with(17, fan::MAX_BITS), Err(IndexError::Short { .. })), "more steps than there are");
        for number in 0..8 {
            for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(
                    matches!(with(2 + 2 * number, encode_f64(odd)[1]), Err(IndexError::NotFinite { at: 1, .. })),
                    "{odd}"
                );
            }
        }
        assert!(matches!(check(&all[..10]), Err(IndexError::Short { .. })), "head cut short");
        assert!(matches!(check(&all[..17]), Err(IndexError::Short { .. })), "head without its bits");
        assert!(matches!(check(&all[..20]), Err(IndexError::Short { .. })), "slots cut short");
        assert!(matches!(check(&all[..48]), Err(IndexError::Short { .. })), "slots of the inner fan cut short");
        assert!(matches!(with(0, Slot::Fan(1).encode() | 3), Err(IndexError::Unknown { slot: 0, .. })));
        assert!(matches!(with(20, Slot::Fan(22).encode() | 3), Err(IndexError::Unknown { slot: 20, .. })));
        let branch = Slot::Branch(Branch { at: 30, bits: 1 }.encode()).encode();
        assert!(matches!(with(21, branch), Err(IndexError::Misplaced { slot: 21 })), "a branch below a fan");
        assert!(matches!(with(21, Slot::Fan(1).encode()), Err(IndexError::Order { slot: 21, .. })), "its own parent");
        assert!(matches!(with(19, Slot::Fan(22).encode()), Err(IndexError::Order { slot: 19, .. })), "another kind");
        assert!(matches!(with(47, Slot::Block(3).encode()), Err(IndexError::Blocks { slot: 47, .. })));
        assert!(matches!(super::tests::check(&all, 1, 3, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        assert!(super::tests::check(&all, 1, 3, Branches::Halves).is_ok());
    }

    /// One root: four squares. Two of them share a plane node over a block and a list; the other
    /// two are a bundle and a block.
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
    fn a_sample_passes_with_its_cost() {
        assert_eq!(check(&sample(), 1, 5, Branches::Squares), Ok(Cost { nodes: 2, dots: 24 }));
        let halves =
            [Slot::Branch(1), Slot::Block(0), Slot::Branch(3), Slot::Block(1), Slot::Block(0)].map(Slot::encode);
        assert_eq!(check(&halves, 1, 2, Branches::Halves), Ok(Cost { nodes: 2, dots: 8 }));
    }

    #[test]
    fn damaged_indexes_are_reported() {
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
        assert!(matches!(with(6, u32::MAX), Err(IndexError::NotFinite { at: 5, .. })), "NaN");
        let misplaced = Slot::Branch(Branch { at: 63, bits: 1 }.encode()).encode();
        assert!(matches!(with(11, misplaced), Err(IndexError::Misplaced { slot: 11 })));
        assert!(matches!(check(&sample(), 1, 5, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        let mut planes = vec![Slot::Plane(1).encode()];
        planes.extend(normal([1.0; 3]));
        planes.extend([Slot::Block(0).encode(); 2]);
        assert!(check(&planes, 1, 1, Branches::Squares).is_ok());
        assert!(matches!(check(&planes, 1, 1, Branches::None), Err(IndexError::Misplaced { slot: 0 })));
        let huge = Slot::Branch(Branch { at: 1, bits: 12 }.encode() | 15).encode();
        assert_eq!(squares(&[huge, 0, 0], 5), Err(IndexError::Bits { slot: 0, found: 15, max: MAX_BRANCH_BITS }));
        let far = Slot::Branch(Branch { at: BRANCH_LIMIT - 1, bits: 1 }.encode()).encode();
        assert!(matches!(squares(&[far, 0, 0], 5), Err(IndexError::Order { .. })));
        assert!(matches!(squares(&sample()[..64], 5), Err(IndexError::Short { .. })));
        let mut longer = sample();
        longer.push(0);
        assert!(matches!(squares(&longer, 5), Err(IndexError::Unused { at: 65 })));
        assert!(matches!(squares(&[], 5), Err(IndexError::Short { .. })));
    }

    #[test]
    fn endless_chains_of_planes_are_rejected() {
        let mut words = vec![Slot::Plane(1).encode()];
        for i in 0..200 {
            words.extend([0; 6]);
            words.extend([Slot::Block(0).encode(), Slot::Plane(1 + 8 * (i + 1)).encode()]);
        }
        assert!(matches!(check(&words, 1, 1, Branches::Squares), Err(IndexError::Deep { .. })));
        // A branch of one square divides nothing.
        let chain: Vec<u32> = (1..200).map(|at| Slot::Branch(Branch { at, bits: 0 }.encode()).encode()).collect();
        assert!(check(&chain, 1, 1, Branches::Squares).is_err());
    }
}
