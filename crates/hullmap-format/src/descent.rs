//! Descent through a direction index: from a direction's cell, node by node, to its leaf.
//!
//! The runtime, the report and tests follow the words of an index by a direction in f64 only here.
//! Every read is bounds-checked: unchecked words lead to some slot, or to 0.
//!
//! | function | step of a direction |
//! |---|---|
//! | [`root`] | to its first slot |
//! | [`square`], [`half`] | through a branch |
//! | [`plane`], [`bundle`], [`step`] | through planes and fans |
//! | [`child`] | through any node |

use crate::{
    cube::{self, Cell, GRID_BITS},
    fan,
    index_kind::IndexKind,
    node::{Node, Word, Words},
    slot::{
        BUNDLE_HEAD_WORDS, BUNDLE_PLANES, BUNDLE_WORDS, Branch, PLANE_HEAD_WORDS, PLANE_WORDS, decode_f64, normal_index,
    },
};

/// The remaining bits of a direction's cell, u and v, below the branches already passed; the next
/// bit is at the top. A branch of a binary tree swaps u and v.
pub type Path = [u32; 2];

/// Target of a node outside the words: an index past their end, where every word reads as 0.
const NOWHERE: usize = usize::MAX;

/// The path of a cell from its root.
#[inline(always)]
pub fn path(cell: Cell) -> Path {
    [cell.u, cell.v].map(|grid| grid << (u32::BITS - GRID_BITS))
}

/// Word of the slot where a cell's look-up starts; `None` without an index: one leaf of all blocks.
#[inline(always)]
pub fn root(kind: IndexKind, cell: Cell) -> Option<usize> {
    match kind {
        IndexKind::Tree | IndexKind::Medium | IndexKind::Compact | IndexKind::Binary => Some(cell.face as usize),
        // No index has more words than a usize counts.
        IndexKind::CubeMap { resolution } => Some(cube::uniform_cell(cell, resolution) as usize),
        IndexKind::None => None,
    }
}

/// Word of the slot to which a tree's branch leads, and the rest of the path.
#[inline(always)]
pub fn square(payload: u32, [u, v]: Path) -> (usize, Path) {
    let Branch { at, bits } = Branch::decode(payload);
    let top = |path: u32| (u64::from(path) << bits >> u32::BITS) as u32;
    ((at + (top(v) << bits | top(u))) as usize, [u << bits, v << bits])
}

/// Word of the slot to which a branch of a binary tree leads, and the rest of the path.
#[inline(always)]
pub fn half(at: u32, [path, other]: Path) -> (usize, Path) {
    ((at + (path >> (u32::BITS - 1))) as usize, [other, path << 1])
}

/// Word of the slot for the side of the plane node at `at` on which a direction lies.
#[inline]
pub fn plane<W: Words + ?Sized>(words: &W, at: usize, dir: [f64; 3]) -> usize {
    let Some(node) = words.chunk::<{ PLANE_WORDS as usize }>(at) else { return NOWHERE };
    at + PLANE_HEAD_WORDS as usize + usize::from(is_in_front(node, 1, 0, dir))
}

/// Word of the slot for the part of the plane bundle at `at` in which a direction lies.
#[inline]
#[expect(clippy::indexing_slicing, reason = "sides are 0 or 1, so that `front` is read below 7")]
pub fn bundle<W: Words + ?Sized>(words: &W, at: usize, dir: [f64; 3]) -> usize {
    let Some(node) = words.chunk::<{ BUNDLE_WORDS as usize }>(at) else { return NOWHERE };
    // Testing all planes at once is faster than three dependent tests.
    let mut front = [0; BUNDLE_PLANES];
    for (plane, front) in front.iter_mut().enumerate() {
        *front = usize::from(is_in_front(node, BUNDLE_PLANES, plane, dir));
    }
    let first = front[0];
    let second = front[1 + first];
    let third = front[3 + 2 * first + second];
    at + BUNDLE_HEAD_WORDS as usize + 4 * first + 2 * second + third
}

/// Word of the slot for the step of the fan at `at` in which a direction lies.
#[inline]
pub fn step<W: Words + ?Sized>(words: &W, at: usize, dir: [f64; 3]) -> usize {
    const HEAD: usize = fan::HEAD_WORDS as usize;
    const BITS: usize = fan::BITS_WORD as usize;
    let Some(head) = words.chunk::<HEAD>(at) else { return NOWHERE };
    at + HEAD + fan::slot(|i| number(head, i), head[BITS].value(), dir) as usize
}

/// Word of the slot to which a node leads, and the rest of the path; `None` for a list.
#[inline]
pub fn child<W: Words + ?Sized>(words: &W, node: Node, path: Path, dir: [f64; 3]) -> Option<(usize, Path)> {
    Some(match node {
        Node::Halves { at } => half(at as u32, path),
        Node::Squares { at, bits } => square(Branch { at: at as u32, bits }.encode(), path),
        Node::Plane { at } => (plane(words, at, dir), path),
        Node::Bundle { at } => (bundle(words, at, dir), path),
        Node::Fan { at, .. } => (step(words, at, dir), path),
        Node::List { .. } => return None,
    })
}

/// Whether a direction is in front of a node's plane `plane`, of `count`: n·d > 0. NaN is behind.
#[inline(always)]
fn is_in_front<T: Word, const N: usize>(node: &[T; N], count: usize, plane: usize, dir: [f64; 3]) -> bool {
    let n = |axis: usize| number(node, normal_index(count, plane, axis));
    n(0) * dir[0] + n(1) * dir[1] + n(2) * dir[2] > 0.0
}

#[inline(always)]
#[expect(
    clippy::indexing_slicing,
    reason = "a plane starts with 3 numbers, a bundle with 21 and a fan with 8; no index is greater"
)]
fn number<T: Word, const N: usize>(node: &[T; N], index: usize) -> f64 {
    decode_f64(node[2 * index].value(), node[2 * index + 1].value())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        node::Branches,
        slot::{Slot, encode_f64},
    };

    #[test]
    fn halves_take_bits_of_u_and_v_in_turn() {
        let path = path(Cell { face: 0, u: 0b10 << (GRID_BITS - 2), v: 0b01 << (GRID_BITS - 2) });
        let mut way = (0, path);
        let mut taken = Vec::new();
        for _ in 0..4 {
            way = half(10, way.1);
            taken.push(way.0 - 10);
        }
        assert_eq!(taken, [1, 0, 0, 1]);
    }

    #[test]
    fn squares_are_stored_row_by_row() {
        let path = path(Cell { face: 0, u: 0b101 << (GRID_BITS - 3), v: 0b011 << (GRID_BITS - 3) });
        let (word, rest) = square(Branch { at: 7, bits: 2 }.encode(), path);
        assert_eq!(word, 7 + 0b0110);
        let (word, _) = square(Branch { at: 0, bits: 1 }.encode(), rest);
        assert_eq!(word, 2 + 1);
    }

    #[test]
    fn bundles_lead_to_their_parts() {
        let normals = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
        let normal = |plane: usize| normals.get(plane).copied().unwrap_or([0.0, 0.0, 1.0]);
        let mut words: Vec<u32> =
            (0..3).flat_map(|axis| (0..BUNDLE_PLANES).flat_map(move |plane| encode_f64(normal(plane)[axis]))).collect();
        words.extend([0; 8]);
        for part in 0..8 {
            let sign = |bit: usize| if part >> bit & 1 == 1 { 1.0 } else { -1.0 };
            assert_eq!(bundle(&words[..], 0, [sign(2), sign(1), sign(0)]), 42 + part);
        }
        let sides = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f64::NAN; 3]];
        assert_eq!(sides.map(|dir| plane(&words[..], 0, dir)), [7, 6, 6, 6], "0 and NaN are behind");
    }

    #[test]
    fn any_words_lead_somewhere() {
        let words = [0x8000_0003_u32; 4];
        for slot in [Slot::Plane(2), Slot::Bundle(9), Slot::Fan(1 << 20)] {
            let node = Node::below(slot, Branches::Squares, &words[..]).unwrap();
            let (at, _) = child(&words[..], node, [u32::MAX; 2], [f64::NAN; 3]).unwrap();
            assert_eq!(words[..].word(at), 0, "past the end");
        }
    }
}
