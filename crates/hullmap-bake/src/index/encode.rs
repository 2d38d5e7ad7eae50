//! Subdivided cells → the words and blocks of an index, as [`hullmap_format::slot`] lays them out.
//!
//! Leaves that list the same vertices share their blocks.

use std::collections::{HashMap, VecDeque};

use hullmap_format::{
    archive::{Block, LANES},
    slot::{PAYLOAD_LIMIT, Slot, encode_normal},
};

use super::subdivide::Tree;
use crate::BakeError;

/// An index, ready to be written.
#[derive(Clone, Debug, Default)]
pub struct Encoded {
    /// Roots, then nodes, breadth first.
    pub slots: Vec<u32>,
    /// Candidate blocks.
    pub blocks: Vec<Block>,
}

/// Encodes a hull without an index: all vertices in order, in blocks.
pub fn scan(vertices: &[[f32; 3]]) -> Encoded {
    let mut encoder = Encoder::new(vertices);
    encoder.push_blocks(&(0..vertices.len() as u32).collect::<Vec<_>>());
    encoder.out
}

/// Encodes trees, one for each root.
///
/// # Errors
/// An index of more than 2³⁰ words or blocks.
pub fn trees(vertices: &[[f32; 3]], roots: &[Tree]) -> Result<Encoded, BakeError> {
    let mut encoder = Encoder::new(vertices);
    encoder.out.slots = vec![0; roots.len()];
    let mut queue: VecDeque<(usize, &Tree)> = roots.iter().enumerate().collect();
    while let Some((at, tree)) = queue.pop_front() {
        let free = encoder.out.slots.len();
        let slot = match tree {
            Tree::Leaf(list) => encoder.leaf(list),
            Tree::Axis(halves) => {
                encoder.out.slots.extend([0; 2]);
                queue.extend([(free, &halves[0]), (free + 1, &halves[1])]);
                Slot::Axis(free as u32)
            }
            Tree::Plane(normal, halves) => {
                encoder.out.slots.extend(encode_normal(*normal));
                encoder.out.slots.extend([0; 2]);
                queue.extend([(free + 6, &halves[0]), (free + 7, &halves[1])]);
                Slot::Plane(free as u32)
            }
        };
        encoder.out.slots[at] = slot.encode();
        if encoder.out.slots.len().max(encoder.out.blocks.len()) >= PAYLOAD_LIMIT as usize {
            return Err(BakeError::IndexTooLarge);
        }
    }
    Ok(encoder.out)
}

struct Encoder<'a> {
    vertices: &'a [[f32; 3]],
    out: Encoded,
    /// First block of each list already written. Never iterated: its order is not fixed.
    known: HashMap<Vec<u32>, u32>,
}

impl<'a> Encoder<'a> {
    fn new(vertices: &'a [[f32; 3]]) -> Self {
        Self { vertices, out: Encoded::default(), known: HashMap::new() }
    }

    /// A slot for the leaf that lists these vertices; a list leaf's two words are appended.
    fn leaf(&mut self, list: &[u32]) -> Slot {
        // The cones cover every cell; should rounding ever leave one empty, any vertex is as good.
        let list = if list.is_empty() { &[0][..] } else { list };
        let first = match self.known.get(list) {
            Some(&first) => first,
            None => {
                let first = self.push_blocks(list);
                self.known.insert(list.to_vec(), first);
                first
            }
        };
        if list.len() <= LANES {
            return Slot::Block(first);
        }
        let at = self.out.slots.len() as u32;
        self.out.slots.extend([first, list.len().div_ceil(LANES) as u32]);
        Slot::List(at)
    }

    /// Appends blocks of these vertices and returns the first one's number.
    fn push_blocks(&mut self, list: &[u32]) -> u32 {
        let first = self.out.blocks.len() as u32;
        self.out.blocks.extend(list.chunks(LANES).map(|chunk| block(self.vertices, chunk)));
        first
    }
}

fn block(vertices: &[[f32; 3]], chunk: &[u32]) -> Block {
    let vertex: [u32; LANES] = std::array::from_fn(|lane| *chunk.get(lane).unwrap_or(&chunk[0]));
    let component = |i: usize| vertex.map(|v| vertices[v as usize][i]);
    Block { x: component(0), y: component(1), z: component(2), vertex }
}
