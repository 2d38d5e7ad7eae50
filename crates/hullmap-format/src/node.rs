//! Nodes of a direction index, decoded from its words.
//!
//! [`crate::slot`] describes the meaning of a node's numbers and slots. [`crate::walk`] visits and
//! checks all nodes of an index, and [`crate::descent`] follows a direction through them.

use std::ops::Range;

use rkyv::rend::u32_le;

use crate::{
    fan,
    slot::{
        BUNDLE_HEAD_WORDS, BUNDLE_PARTS, BUNDLE_PLANES, Branch, F64_WORDS, HALVES_WORDS, LIST_WORDS, MAX_BRANCH_BITS,
        PLANE_HEAD_WORDS, Slot, decode_f64, normal_index,
    },
};

/// A word, in any byte order.
pub trait Word: Copy {
    /// Its value.
    fn value(self) -> u32;
}

impl Word for u32 {
    #[inline(always)]
    fn value(self) -> u32 {
        self
    }
}

impl Word for u32_le {
    #[inline(always)]
    fn value(self) -> u32 {
        self.to_native()
    }
}

/// The words of one hull's direction index.
pub trait Words {
    /// A word as it is stored.
    type Word: Word;

    /// Number of words.
    fn word_count(&self) -> usize;

    /// The word at index `at`; 0 past the end. No node of a checked index reaches past the end.
    fn word(&self, at: usize) -> u32;

    /// The `N` words from index `at` on; `None` if there are fewer.
    fn chunk<const N: usize>(&self, at: usize) -> Option<&[Self::Word; N]>;

    /// The f64 in the two words at index `at`.
    fn number(&self, at: usize) -> f64 {
        decode_f64(self.word(at), self.word(at + 1))
    }

    /// The f64 of index `index` at the front of the node at `at`; [`fan`] names these in a fan.
    fn node_number(&self, at: usize, index: usize) -> f64 {
        self.number(at + F64_WORDS as usize * index)
    }

    /// The vector of three f64 from index `index` on at the front of the node at `at`.
    fn node_vector(&self, at: usize, index: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.node_number(at, index + axis))
    }

    /// The normal of plane `plane` of the node at `at`, which has `count` planes.
    fn normal(&self, at: usize, count: usize, plane: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.node_number(at, normal_index(count, plane, axis)))
    }
}

impl<T: Word> Words for [T] {
    type Word = T;

    fn word_count(&self) -> usize {
        self.len()
    }

    #[inline]
    fn word(&self, at: usize) -> u32 {
        self.get(at).map_or(0, |word| word.value())
    }

    #[inline(always)]
    fn chunk<const N: usize>(&self, at: usize) -> Option<&[T; N]> {
        self.get(at..)?.first_chunk()
    }
}

/// How a branch of an index divides its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branches {
    /// The index has no branches (cube map, no index).
    None,
    /// Into two halves, across u and v in turn (binary tree).
    Halves,
    /// Into 2ᵇ × 2ᵇ squares (tree).
    Squares,
}

/// A node of a direction index. `at` is the index of its first word in the hull's run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "`at` and `bits` are explained above")]
pub enum Node {
    /// Two halves of the cell.
    Halves { at: usize },
    /// 2ᵇ × 2ᵇ squares of the cell, row by row.
    Squares { at: usize, bits: u32 },
    /// The two sides of a plane through the origin.
    Plane { at: usize },
    /// The eight parts that seven planes divide the cell into.
    Bundle { at: usize },
    /// 2ᵇ equal steps of the angle around an axis.
    Fan { at: usize, bits: u32 },
    /// A leaf that states its first block and its number of blocks.
    List { at: usize },
}

impl Node {
    /// The node that `slot` refers to; `None` for a plain leaf, which has no words.
    #[inline]
    pub fn below<W: Words + ?Sized>(slot: Slot, branches: Branches, words: &W) -> Option<Self> {
        Some(match slot {
            Slot::Block(_) => return None,
            Slot::Branch(payload) if branches == Branches::Squares => {
                let Branch { at, bits } = Branch::decode(payload);
                Self::Squares { at: at as usize, bits }
            }
            Slot::Branch(at) => Self::Halves { at: at as usize },
            Slot::Plane(at) => Self::Plane { at: at as usize },
            Slot::Bundle(at) => Self::Bundle { at: at as usize },
            Slot::Fan(at) => Self::Fan { at: at as usize, bits: words.word(at as usize + fan::BITS_WORD as usize) },
            Slot::List(at) => Self::List { at: at as usize },
        })
    }

    /// Index of its first word.
    #[inline]
    pub fn first_word(self) -> usize {
        match self {
            Self::Halves { at }
            | Self::Squares { at, .. }
            | Self::Plane { at }
            | Self::Bundle { at }
            | Self::Fan { at, .. }
            | Self::List { at } => at,
        }
    }

    /// Number of f64 values at its start, two words each.
    #[inline]
    pub fn number_count(self) -> usize {
        match self {
            Self::Halves { .. } | Self::Squares { .. } | Self::List { .. } => 0,
            Self::Plane { .. } => 3,
            Self::Bundle { .. } => 3 * BUNDLE_PLANES,
            Self::Fan { .. } => fan::HEAD_WORDS as usize / 2,
        }
    }

    /// Indices of the words that are its slots; empty for a list, and where bits are out of range.
    #[inline]
    pub fn slots(self) -> Range<usize> {
        let (first, count) = match self {
            Self::Halves { at } => (at, HALVES_WORDS as usize),
            Self::Squares { at, bits } => (at, if bits <= MAX_BRANCH_BITS { 1 << (2 * bits) } else { 0 }),
            Self::Plane { at } => (at + PLANE_HEAD_WORDS as usize, 2),
            Self::Bundle { at } => (at + BUNDLE_HEAD_WORDS as usize, BUNDLE_PARTS),
            Self::Fan { at, bits } => {
                (at + fan::HEAD_WORDS as usize, if bits <= fan::MAX_BITS { 1 << bits } else { 0 })
            }
            Self::List { at } => (at + LIST_WORDS as usize, 0),
        };
        first..first + count
    }

    /// Index of the first word after it.
    #[inline]
    pub fn end(self) -> usize {
        self.slots().end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slot::{BUNDLE_WORDS, PLANE_WORDS};

    #[test]
    fn slots_are_the_last_words_of_a_node() {
        let words: Vec<u32> = vec![3; 100];
        let below = |slot| Node::below(slot, Branches::Squares, &words[..]).unwrap();
        let branch = Slot::Branch(Branch { at: 9, bits: 2 }.encode());
        assert_eq!(below(branch).slots(), 9..25);
        assert_eq!(Node::below(Slot::Branch(9), Branches::Halves, &words[..]).unwrap().slots(), 9..11);
        assert_eq!(below(Slot::Plane(9)).end() - 9, PLANE_WORDS as usize);
        assert_eq!(below(Slot::Bundle(9)).end() - 9, BUNDLE_WORDS as usize);
        assert_eq!(below(Slot::Fan(9)), Node::Fan { at: 9, bits: 3 });
        assert_eq!(below(Slot::Fan(9)).slots(), 26..34);
        assert_eq!(below(Slot::List(9)).end(), 11);
        assert_eq!(Node::below(Slot::Block(9), Branches::Squares, &words[..]), None);
    }

    #[test]
    fn words_past_the_end_are_zero() {
        let words = [7_u32];
        assert_eq!((words[..].word(0), words[..].word(1), words[..].number(5)), (7, 0, 0.0));
        assert_eq!(Node::below(Slot::Fan(90), Branches::Squares, &words[..]), Some(Node::Fan { at: 90, bits: 0 }));
    }

    #[test]
    fn bits_out_of_range_have_no_slots() {
        assert!(Node::Squares { at: 5, bits: 13 }.slots().is_empty());
        assert!(Node::Fan { at: 5, bits: u32::MAX }.slots().is_empty());
    }
}
