//! The words of a direction index.
//!
//! An index is one array of u32. A *slot* is a word that says what lies below it, by its top two bits:
//!
//! | tag | below it | the other 30 bits |
//! |---|---|---|
//! | 0 | axis node: the cell is halved, across u first, then v, in turn | place of its 2 words: lower and upper half's slot |
//! | 1 | leaf of one block | the block |
//! | 2 | plane node: the cell is cut by a plane through the origin | place of its 8 words: the normal's three f64, each low word first, the slot behind, the slot in front |
//! | 3 | leaf of several blocks | place of its 2 words: first block, number of blocks |
//!
//! A *place* is the number of a word in the hull's own run of words; blocks are numbered in the hull's own run too.
//!
//! A tree starts with the slots of the six faces; a cube map with those of all its cells, which are leaves; a hull
//! without an index has no words. What slots name, nodes and the two words of a list, follows in the order in which
//! those slots stand (breadth first), without gaps: a reader can check the whole in one pass, and a node can have
//! neither two parents nor itself below it.
//!
//! An axis node takes the next bit of the direction's grid numbers ([`crate::cube`]), the highest first: 0 is the lower
//! half, 1 the upper. Planes use up no bits.
//!
//! A direction `d` goes in front of a plane where n·d > 0. Below a plane node there are no axis nodes. Normals are f64
//! because the planes of a fan all pass through one direction, the normal of the facet whose corners they part: rounded
//! to f32 they would miss it by 6e-8, and around it no plane would part anything.

/// Words of an axis node.
pub const AXIS_WORDS: u32 = 2;
/// Words of a plane node.
pub const PLANE_WORDS: u32 = 8;
/// Words of a list leaf.
pub const LIST_WORDS: u32 = 2;

/// Greatest place or block that a slot can name, plus one.
pub const PAYLOAD_LIMIT: u32 = 1 << 30;

const TAG_SHIFT: u32 = 30;
const PAYLOAD_MASK: u32 = PAYLOAD_LIMIT - 1;

/// What lies below a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// An axis node at this place.
    Axis(u32),
    /// A leaf of this one block.
    Block(u32),
    /// A plane node at this place.
    Plane(u32),
    /// A leaf of several blocks, described at this place.
    List(u32),
}

impl Slot {
    /// Reads a word. Every word is some slot.
    #[inline]
    pub fn decode(word: u32) -> Self {
        let payload = word & PAYLOAD_MASK;
        match word >> TAG_SHIFT {
            0 => Self::Axis(payload),
            1 => Self::Block(payload),
            2 => Self::Plane(payload),
            _ => Self::List(payload),
        }
    }

    /// The word. Payloads are below [`PAYLOAD_LIMIT`].
    #[inline]
    pub fn encode(self) -> u32 {
        let (tag, payload) = match self {
            Self::Axis(at) => (0, at),
            Self::Block(block) => (1, block),
            Self::Plane(at) => (2, at),
            Self::List(at) => (3, at),
        };
        debug_assert!(payload < PAYLOAD_LIMIT);
        tag << TAG_SHIFT | payload
    }

    /// Words that what lies below the slot takes.
    #[inline]
    pub fn words(self) -> u32 {
        match self {
            Self::Axis(_) => AXIS_WORDS,
            Self::Block(_) => 0,
            Self::Plane(_) => PLANE_WORDS,
            Self::List(_) => LIST_WORDS,
        }
    }
}

/// The six words of a plane's normal.
pub fn encode_normal(normal: [f64; 3]) -> [u32; 6] {
    let mut words = [0; 6];
    for (pair, n) in words.chunks_exact_mut(2).zip(normal) {
        let bits = n.to_bits();
        pair.copy_from_slice(&[bits as u32, (bits >> 32) as u32]);
    }
    words
}

/// The normal of a plane node, from its first six words.
#[inline]
pub fn decode_normal(words: [u32; 6]) -> [f64; 3] {
    let [a, b, c, d, e, f] = words.map(u64::from);
    [f64::from_bits(a | b << 32), f64::from_bits(c | d << 32), f64::from_bits(e | f << 32)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_round_trip() {
        for payload in [0, 1, 5, PAYLOAD_LIMIT - 1] {
            for slot in [Slot::Axis(payload), Slot::Block(payload), Slot::Plane(payload), Slot::List(payload)] {
                assert_eq!(Slot::decode(slot.encode()), slot);
            }
        }
        let normal = [1.0 / 3.0, -2e-300, 5e200];
        assert_eq!(decode_normal(encode_normal(normal)), normal);
    }
}
