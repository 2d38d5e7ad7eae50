//! The words of a direction index.
//!
//! An index is one array of u32. A *slot* is a word that says what lies below it, by its top two bits:
//!
//! | tag | below it | the other 30 bits |
//! |---|---|---|
//! | 0 | branch: the cell is divided evenly | tree: place · 16 + b, of 4ᵇ slots; binary tree: place, of 2 slots |
//! | 1 | leaf of the usual number of blocks | the first block |
//! | 2 | planes through the origin, or a fan of them | place · 4 + (0 for one plane, 1 for seven, 2 for a fan; 3 is none) |
//! | 3 | leaf of any number of blocks | place, of 2 words: first block, number of blocks |
//!
//! A branch of a tree divides its cell into 2ᵇ × 2ᵇ squares, row by row (v), each row along u. One of a binary tree halves
//! it, across u first, then v, in turn. Below planes and fans there are planes, fans and leaves, but no branches.
//!
//! One plane takes 8 words: the normal's three f64, each low word first, then the slots behind and in front of it. Seven
//! planes take 50: the normals' first coordinates, second ones, third ones, then eight slots. The first plane parts
//! the cell; the next two part what lies behind and in front of it; the last four the four parts; a direction's slot is
//! the number of its part. A direction `d` is in front where n·d > 0. Unused planes are zero: all is behind them.
//!
//! A fan takes 17 words and 2ᵇ slots: equal steps around an axis, see [`crate::fan`].
//!
//! Normals are f64 because the planes around a facet all pass through one direction, the normal of the facet whose corners they
//! part: rounded to f32 they would miss it by 6e-8, and around it no plane would part anything.
//!
//! A *place* is the number of a word in the hull's own run of words; blocks are numbered in the hull's own run too.
//!
//! A tree starts with the slots of the six faces; a cube map with those of all its cells, which are leaves; a hull without
//! an index has no words. Nodes follow in the order in which the slots that name them first stand (breadth first), without
//! gaps. Only slots of one node may name the same planes, fan or list, and no two the same branch. So a reader can check the
//! whole in one pass, and no node lies below itself.

/// Words of a halving.
pub const HALVES_WORDS: u32 = 2;
/// Words of one plane.
pub const PLANE_WORDS: u32 = 8;
/// Planes of a bundle.
pub const BUNDLE_PLANES: usize = 7;
/// Parts that a bundle of planes divides a cell into.
pub const BUNDLE_PARTS: usize = 8;
/// Words of a bundle of planes.
pub const BUNDLE_WORDS: u32 = 50;
/// Words of a list leaf.
pub const LIST_WORDS: u32 = 2;
/// Most bits that one branch of a tree consumes along each axis.
pub const MAX_BRANCH_BITS: u32 = 12;

/// Greatest block, or place of a list or halving, that a slot can name, plus one.
pub const PAYLOAD_LIMIT: u32 = 1 << 30;
/// Greatest place of a tree's branch, plus one.
pub const BRANCH_LIMIT: u32 = 1 << 26;
/// Greatest place of planes, plus one.
pub const PLANES_LIMIT: u32 = 1 << 28;

const TAG_SHIFT: u32 = 30;
const PAYLOAD_MASK: u32 = PAYLOAD_LIMIT - 1;

/// What lies below a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// A branch: see [`Branch`]; in a binary tree the place of its two slots.
    Branch(u32),
    /// A leaf of the usual number of blocks, from this one on.
    Block(u32),
    /// One plane, at this place.
    Plane(u32),
    /// Seven planes, at this place.
    Bundle(u32),
    /// A fan, at this place.
    Fan(u32),
    /// A leaf of any number of blocks, described at this place.
    List(u32),
}

/// A branch of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branch {
    /// Place of its first slot.
    pub at: u32,
    /// It has 2ᵇ × 2ᵇ slots.
    pub bits: u32,
}

impl Branch {
    /// Reads the payload of a tree's branch slot.
    #[inline]
    pub fn decode(payload: u32) -> Self {
        Self { at: payload >> 4, bits: payload & 15 }
    }

    /// The payload. The place is below [`BRANCH_LIMIT`], the bits at most [`MAX_BRANCH_BITS`].
    pub fn encode(self) -> u32 {
        debug_assert!(self.at < BRANCH_LIMIT && self.bits <= MAX_BRANCH_BITS);
        self.at << 4 | self.bits
    }
}

impl Slot {
    /// Reads a word. Every word is read as some slot; one that is none is not what the slot is written as.
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

    /// The first block, if the word is a leaf of the usual number of blocks.
    #[inline]
    pub fn block(word: u32) -> Option<u32> {
        (word >> TAG_SHIFT == 1).then_some(word & PAYLOAD_MASK)
    }

    /// The word. Payloads are below their limits.
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
            for slot in [
                Slot::Branch(payload),
                Slot::Block(payload),
                Slot::Plane(payload),
                Slot::Bundle(payload),
                Slot::Fan(payload),
                Slot::List(payload),
            ] {
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
