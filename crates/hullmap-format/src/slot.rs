//! The words of a direction index.
//!
//! An index is one array of u32. A *slot* is a word that refers to a node or a leaf. Its top two
//! bits are its tag:
//!
//! | tag | what is below the slot | the other 30 bits |
//! |---|---|---|
//! | 0 | branch: even division | tree: position · 16 + b, of 4ᵇ slots; binary: position, of 2 |
//! | 1 | plain leaf: fixed number of blocks | the first block |
//! | 2 | planes or a fan | position · 4 + (0: one plane, 1: seven planes, 2: a fan; 3: unused) |
//! | 3 | list leaf: any number of blocks | position, of 2 words: first block, number of blocks |
//!
//! A branch of a tree divides its cell into 2ᵇ × 2ᵇ squares, row by row (v), each row along u. A
//! branch of a binary tree halves its cell, across u and v in turn, starting with u. Below planes
//! and fans there are planes, fans and leaves, but no branches.
//!
//! All planes pass through the origin. One plane takes 8 words: the three f64 of its normal, each
//! low word first, then the slots behind it and in front of it. Seven planes take 50 words: the
//! first coordinates of their normals, the second ones, the third ones, then eight slots. The first
//! plane divides the cell into two parts, the next two planes divide these into four, and the last
//! four planes divide those into eight. The index of a direction's part is the index of its slot. A
//! direction `d` is in front of a plane with normal n if n·d > 0. The normal of an unused plane is
//! zero, so every direction is behind it.
//!
//! A fan takes 17 words and 2ᵇ slots: equal steps around an axis, see [`crate::fan`].
//!
//! Normals are f64: the planes around a facet separate its corners, and all pass through the
//! facet's normal. Rounded to f32, they would miss it by 6e-8, and separate nothing near it.
//!
//! *Positions*, indices of words, and blocks are counted in the hull's own runs.
//!
//! A tree starts with the slots of the six faces. A cube map starts with the slots of all its
//! cells, which are leaves. A hull without an index has no words. The nodes follow without gaps,
//! breadth first: in the order of the first slots that refer to them. Several slots may refer to
//! the same planes, fan or list only if they belong to one node. No two slots may refer to the same
//! branch. So one pass checks the whole index, and no node is below itself.

/// Words of a branch of a binary tree.
pub const HALVES_WORDS: u32 = 2;
/// Words of an f64, low word first.
pub const F64_WORDS: u32 = 2;
/// Words of one plane.
pub const PLANE_WORDS: u32 = 8;
/// Words of one plane before its two slots: its normal.
pub const PLANE_HEAD_WORDS: u32 = 3 * F64_WORDS;
/// Planes of a bundle.
pub const BUNDLE_PLANES: usize = 7;
/// Parts that a bundle of planes divides a cell into.
pub const BUNDLE_PARTS: usize = 8;
/// Words of a bundle of planes.
pub const BUNDLE_WORDS: u32 = 50;
/// Words of a bundle before the slots of its parts: its normals.
pub const BUNDLE_HEAD_WORDS: u32 = 3 * F64_WORDS * BUNDLE_PLANES as u32;
/// Words of a list leaf.
pub const LIST_WORDS: u32 = 2;
/// Maximum number of bits that one branch of a tree consumes along each axis.
pub const MAX_BRANCH_BITS: u32 = 12;

/// Upper limit, exclusive, of a block, and of the position of a list or of a binary tree's branch.
pub const PAYLOAD_LIMIT: u32 = 1 << 30;
/// Upper limit, exclusive, of the position of a tree's branch.
pub const BRANCH_LIMIT: u32 = 1 << 26;
/// Upper limit, exclusive, of the position of planes.
pub const PLANES_LIMIT: u32 = 1 << 28;

const TAG_SHIFT: u32 = 30;
const PAYLOAD_MASK: u32 = PAYLOAD_LIMIT - 1;

/// Node or leaf below a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// A branch: see [`Branch`]. In a binary tree, the position of its two slots.
    Branch(u32),
    /// A plain leaf, which starts at this block.
    Block(u32),
    /// One plane, at this position.
    Plane(u32),
    /// Seven planes, at this position.
    Bundle(u32),
    /// A fan, at this position.
    Fan(u32),
    /// A list leaf: its first block and its number of blocks are at this position.
    List(u32),
}

/// A branch of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branch {
    /// Position of its first slot.
    pub at: u32,
    /// The exponent b: it has 2ᵇ × 2ᵇ slots.
    pub bits: u32,
}

impl Branch {
    /// Reads the payload of a tree's branch slot.
    #[inline]
    pub fn decode(payload: u32) -> Self {
        Self { at: payload >> 4, bits: payload & 15 }
    }

    /// The payload. `at` must be below [`BRANCH_LIMIT`], and `bits` at most [`MAX_BRANCH_BITS`].
    pub fn encode(self) -> u32 {
        debug_assert!(self.at < BRANCH_LIMIT && self.bits <= MAX_BRANCH_BITS);
        self.at << 4 | self.bits
    }
}

impl Slot {
    /// Reads a word. Every word decodes to some slot. If the word is not the encoding of any slot,
    /// [`encode`](Self::encode) of the result differs from it.
    #[inline]
    pub fn decode(word: u32) -> Self {
        let payload = word & PAYLOAD_MASK;
        match word >> TAG_SHIFT {
            0 => Self::Branch(payload),
            1 => Self::Block(payload),
            2 => match payload & 3 {
                0 => Self::Plane(payload >> 2),
                1 => Self::Bundle(payload >> 2),
                _ => Self::Fan(payload >> 2),
            },
            _ => Self::List(payload),
        }
    }

    /// The payload, if the word is a branch.
    #[inline]
    pub fn branch(word: u32) -> Option<u32> {
        (word >> TAG_SHIFT == 0).then_some(word)
    }

    /// The first block, if the word is a plain leaf.
    #[inline]
    pub fn block(word: u32) -> Option<u32> {
        (word >> TAG_SHIFT == 1).then_some(word & PAYLOAD_MASK)
    }

    /// The word. Payloads must be below their limits.
    #[inline]
    pub fn encode(self) -> u32 {
        let (tag, payload) = match self {
            Self::Branch(payload) => (0, payload),
            Self::Block(block) => (1, block),
            Self::Plane(at) => (2, at << 2),
            Self::Bundle(at) => (2, at << 2 | 1),
            Self::Fan(at) => (2, at << 2 | 2),
            Self::List(at) => (3, at),
        };
        debug_assert!(payload < PAYLOAD_LIMIT);
        tag << TAG_SHIFT | payload
    }
}

/// Index of a coordinate of a normal among the f64 values at the front of `count` planes: 1, or
/// [`BUNDLE_PLANES`]. `axis` is 0 for x, 1 for y and 2 for z.
#[inline(always)]
pub const fn normal_index(count: usize, plane: usize, axis: usize) -> usize {
    axis * count + plane
}

/// The two words of an f64.
pub fn encode_f64(value: f64) -> [u32; 2] {
    let bits = value.to_bits();
    [bits as u32, (bits >> 32) as u32]
}

/// The f64 of two words.
#[inline]
pub fn decode_f64(low: u32, high: u32) -> f64 {
    f64::from_bits(u64::from(low) | u64::from(high) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_round_trip() {
        for payload in [0, 1, 5, PLANES_LIMIT - 1] {
            let kinds = [Slot::Branch, Slot::Block, Slot::Plane, Slot::Bundle, Slot::Fan, Slot::List];
            for slot in kinds.map(|kind: fn(u32) -> Slot| kind(payload)) {
                assert_eq!(Slot::decode(slot.encode()), slot);
            }
        }
        let none = Slot::Fan(5).encode() | 3;
        assert_ne!(Slot::decode(none).encode(), none);
        let branch = Branch { at: BRANCH_LIMIT - 1, bits: MAX_BRANCH_BITS };
        assert_eq!(Branch::decode(branch.encode()), branch);
        for value in [1.0 / 3.0, -2e-300, 5e200, 0.0] {
            let [low, high] = encode_f64(value);
            assert_eq!(decode_f64(low, high), value);
        }
    }
}
