//! Subdivided cells → the words and blocks of an index, as [`hullmap_format::slot`] lays them out.
//!
//! Leaves that list the same vertices share their blocks. Halvings become branches of one or more
//! levels, planes become bundles of three levels, and the steps of a fan become one row of slots.

use std::collections::{HashMap, VecDeque};

use hullmap_format::{
    archive::{Block, LANES},
    fan,
    slot::{
        BRANCH_LIMIT, BUNDLE_HEAD_WORDS, BUNDLE_PARTS, BUNDLE_PLANES, BUNDLE_WORDS, Branch, F64_WORDS, MAX_BRANCH_BITS,
        PAYLOAD_LIMIT, PLANE_HEAD_WORDS, PLANES_LIMIT, Slot, encode_f64, normal_index,
    },
    walk::Branches,
};

use super::{fan::Frame, subdivide::Tree};
use crate::error::BakeError;

/// Minimum fraction of distinct slots in a branch, which gets the most bits that satisfy it. A
/// greater fraction means fewer bits: more hops and fewer bytes.
const MIN_DISTINCT: f64 = 0.4;

/// Three levels of planes become one bundle if they divide the cell into at least this many parts.
const BUNDLE_FROM: usize = 5;

type Queue<'a> = VecDeque<(Vec<usize>, &'a Tree, Option<Frame>)>;

/// An encoded index.
#[derive(Clone, Debug, Default)]
pub struct Encoded {
    /// Roots, then nodes, breadth first.
    pub slots: Vec<u32>,
    /// Candidate blocks.
    pub blocks: Vec<Block>,
}

/// Encodes a hull without an index: all vertices in order, in blocks.
pub fn scan(vertices: &[[f32; 3]]) -> Encoded {
    let mut encoder = Encoder::new(vertices, 1);
    encoder.push_blocks(&(0..vertices.len() as u32).collect::<Vec<_>>(), 1);
    encoder.out
}

/// Encodes trees, one per root, with `leaf_blocks` blocks per plain leaf.
///
/// # Errors
/// [`BakeError::IndexTooLarge`] if slots cannot address all words or blocks.
pub fn trees(
    vertices: &[[f32; 3]],
    roots: &[Tree],
    branches: Branches,
    leaf_blocks: usize,
) -> Result<Encoded, BakeError> {
    let mut encoder = Encoder::new(vertices, leaf_blocks);
    encoder.out.slots = vec![0; roots.len()];
    // The slots that refer to each tree. Neighbouring slots with the same tree share one entry.
    let mut queue: Queue = roots.iter().enumerate().map(|(at, tree)| (vec![at], tree, None)).collect();
    while let Some((targets, tree, frame)) = queue.pop_front() {
        let slot = match tree {
            Tree::Leaf(list) => encoder.leaf(list),
            Tree::Axis(halves) if branches == Branches::Halves => encoder.halving(halves, &mut queue)?,
            Tree::Axis(_) => encoder.branch(tree, &mut queue)?,
            Tree::Plane(normal, halves) if part_count(tree, 3) < BUNDLE_FROM => {
                encoder.plane(**normal, halves, &mut queue)?
            }
            Tree::Plane(..) => encoder.bundle(tree, &mut queue)?,
            Tree::Fan(frame, wedges) => encoder.fan(**frame, wedges, &mut queue)?,
            Tree::Wedges(_) => encoder.fan(frame.expect("wedges stand below a fan"), tree, &mut queue)?,
        };
        for target in targets {
            encoder.out.slots[target] = slot.encode();
        }
        checked(encoder.out.slots.len().max(encoder.out.blocks.len()), PAYLOAD_LIMIT)?;
    }
    Ok(encoder.out)
}

fn checked(at: usize, limit: u32) -> Result<u32, BakeError> {
    u32::try_from(at).ok().filter(|at| *at < limit).ok_or(BakeError::IndexTooLarge)
}

/// Queues the trees of a node's slots, the first of which is `first`. A tree that fills several
/// slots is queued once.
fn enqueue<'a>(queue: &mut Queue<'a>, first: usize, slots: &[&'a Tree], frame: impl Fn(usize) -> Option<Frame>) {
    let start = queue.len();
    let mut known: HashMap<*const Tree, usize> = HashMap::new();
    for (index, &tree) in slots.iter().enumerate() {
        let at = *known.entry(std::ptr::from_ref(tree)).or_insert_with(|| {
            queue.push_back((Vec::new(), tree, frame(index)));
            queue.len() - 1
        });
        debug_assert!(at >= start);
        queue[at].0.push(first + index);
    }
}

fn branch_bits(tree: &Tree) -> u32 {
    let enough = |bits: &u32| cell_count(tree, 2 * bits) as f64 >= MIN_DISTINCT * f64::from(1 << (2 * bits));
    (1..=MAX_BRANCH_BITS).rev().find(enough).unwrap_or(1)
}

fn fan_bits(wedges: &Tree) -> u32 {
    let enough = |bits: &u32| wedge_count(wedges, *bits) as f64 >= MIN_DISTINCT * f64::from(1 << bits);
    (0..=fan::MAX_BITS).rev().find(enough).unwrap_or(0)
}

fn wedge_count(tree: &Tree, levels: u32) -> usize {
    match tree {
        Tree::Wedges(halves) if levels > 0 => halves.iter().map(|half| wedge_count(half, levels - 1)).sum(),
        _ => 1,
    }
}

/// The trees in 2ᵇ equal parts of a fan. A tree that covers several parts is repeated.
fn parts(tree: &Tree, bits: u32) -> Vec<&Tree> {
    match tree {
        Tree::Wedges(halves) if bits > 0 => halves.iter().flat_map(|half| parts(half, bits - 1)).collect(),
        _ => vec![tree; 1 << bits],
    }
}

fn cell_count(tree: &Tree, levels: u32) -> usize {
    match tree {
        Tree::Axis(halves) if levels > 0 => halves.iter().map(|half| cell_count(half, levels - 1)).sum(),
        _ => 1,
    }
}

/// The trees in 2ᵇ × 2ᵇ squares of a cell, row by row, with repetitions.
fn squares(tree: &Tree, bits: u32) -> Vec<&Tree> {
    let mut out = vec![tree; 1 << (2 * bits)];
    fill(tree, [0, 0], [1 << bits; 2], 0, 1 << bits, &mut out);
    out
}

fn fill<'a>(tree: &'a Tree, at: [usize; 2], size: [usize; 2], axis: usize, row: usize, out: &mut [&'a Tree]) {
    match tree {
        Tree::Axis(halves) if size[axis] > 1 => {
            let mut half = size;
            half[axis] /= 2;
            let mut upper = at;
            upper[axis] += half[axis];
            fill(&halves[0], at, half, 1 - axis, row, out);
            fill(&halves[1], upper, half, 1 - axis, row, out);
        }
        _ => {
            for v in at[1]..at[1] + size[1] {
                out[v * row + at[0]..v * row + at[0] + size[0]].fill(tree);
            }
        }
    }
}

fn part_count(tree: &Tree, levels: u32) -> usize {
    match tree {
        Tree::Plane(_, halves) if levels > 0 => halves.iter().map(|half| part_count(half, levels - 1)).sum(),
        _ => 1,
    }
}

/// The normals of three levels of planes, and the trees in their eight parts. A missing plane has a
/// zero normal, so that every direction lies behind it.
fn bundle(tree: &Tree) -> ([[f64; 3]; BUNDLE_PLANES], [&Tree; BUNDLE_PARTS]) {
    let mut normals = [[0.0; 3]; BUNDLE_PLANES];
    let mut level = vec![tree];
    let mut first = 0;
    for _ in 0..BUNDLE_PARTS.ilog2() {
        let mut below = Vec::with_capacity(2 * level.len());
        for (index, &cell) in level.iter().enumerate() {
            match cell {
                Tree::Plane(normal, halves) => {
                    normals[first + index] = **normal;
                    below.extend([&halves[0], &halves[1]]);
                }
                // No direction lies in front of a missing plane.
                _ => below.extend([cell, cell]),
            }
        }
        first += level.len();
        level = below;
    }
    (normals, std::array::from_fn(|part| level[part]))
}

struct Encoder<'a> {
    vertices: &'a [[f32; 3]],
    leaf_blocks: usize,
    out: Encoded,
    /// First block of each list already written. Never iterated, because its order is not fixed.
    known: HashMap<Vec<u32>, u32>,
    /// Vertices with an extreme coordinate. They fill unused lanes.
    ends: Vec<u32>,
}

impl<'a> Encoder<'a> {
    fn new(vertices: &'a [[f32; 3]], leaf_blocks: usize) -> Self {
        Self { vertices, leaf_blocks, out: Encoded::default(), known: HashMap::new(), ends: ends(vertices) }
    }

    /// The slot of a leaf that lists these vertices. The two words of a list leaf are appended.
    fn leaf(&mut self, list: &[u32]) -> Slot {
        // No leaf is empty. If one were, an unproven index would be better than a panic.
        let list = if list.is_empty() { &[0][..] } else { list };
        let first = match self.known.get(list) {
            Some(&first) => first,
            None => {
                let first = self.push_blocks(list, self.leaf_blocks);
                self.known.insert(list.to_vec(), first);
                first
            }
        };
        if list.len() <= LANES * self.leaf_blocks {
            return Slot::Block(first);
        }
        let at = self.out.slots.len() as u32;
        self.out.slots.extend([first, list.len().div_ceil(LANES) as u32]);
        Slot::List(at)
    }

    fn halving<'t>(&mut self, halves: &'t [Tree; 2], queue: &mut Queue<'t>) -> Result<Slot, BakeError> {
        let at = self.out.slots.len();
        self.out.slots.extend([0; 2]);
        queue.extend([(vec![at], &halves[0], None), (vec![at + 1], &halves[1], None)]);
        Ok(Slot::Branch(checked(at, PAYLOAD_LIMIT)?))
    }

    fn branch<'t>(&mut self, tree: &'t Tree, queue: &mut Queue<'t>) -> Result<Slot, BakeError> {
        let at = self.out.slots.len();
        let bits = branch_bits(tree);
        let squares = squares(tree, bits);
        self.out.slots.resize(at + squares.len(), 0);
        enqueue(queue, at, &squares, |_| None);
        Ok(Slot::Branch(Branch { at: checked(at, BRANCH_LIMIT)?, bits }.encode()))
    }

    fn plane<'t>(&mut self, normal: [f64; 3], halves: &'t [Tree; 2], queue: &mut Queue<'t>) -> Result<Slot, BakeError> {
        let at = self.out.slots.len();
        self.out.slots.extend(normal.into_iter().flat_map(encode_f64));
        self.out.slots.extend([0; 2]);
        enqueue(queue, at + PLANE_HEAD_WORDS as usize, &[&halves[0], &halves[1]], |_| None);
        Ok(Slot::Plane(checked(at, PLANES_LIMIT)?))
    }

    fn bundle<'t>(&mut self, tree: &'t Tree, queue: &mut Queue<'t>) -> Result<Slot, BakeError> {
        let at = self.out.slots.len();
        let (normals, parts) = bundle(tree);
        self.out.slots.resize(at + BUNDLE_WORDS as usize, 0);
        for (plane, normal) in normals.iter().enumerate() {
            for (axis, n) in normal.iter().enumerate() {
                let word = at + F64_WORDS as usize * normal_index(BUNDLE_PLANES, plane, axis);
                self.out.slots[word..word + 2].copy_from_slice(&encode_f64(*n));
            }
        }
        enqueue(queue, at + BUNDLE_HEAD_WORDS as usize, &parts, |_| None);
        Ok(Slot::Bundle(checked(at, PLANES_LIMIT)?))
    }

    fn fan<'t>(&mut self, frame: Frame, wedges: &'t Tree, queue: &mut Queue<'t>) -> Result<Slot, BakeError> {
        let at = self.out.slots.len();
        let bits = fan_bits(wedges);
        let parts = parts(wedges, bits);
        let Frame { x, y, start, span } = frame;
        let numbers = [x.x, x.y, x.z, y.x, y.y, y.z, start, f64::from(1 << bits) / span];
        self.out.slots.extend(numbers.into_iter().flat_map(encode_f64));
        self.out.slots.push(bits);
        let first = at + fan::HEAD_WORDS as usize;
        self.out.slots.resize(first + parts.len(), 0);
        enqueue(queue, first, &parts, |part| Some(frame.part(part, bits)));
        Ok(Slot::Fan(checked(at, PLANES_LIMIT)?))
    }

    /// Appends at least `least` blocks of these vertices, and returns the index of the first.
    fn push_blocks(&mut self, list: &[u32], least: usize) -> u32 {
        let first = self.out.blocks.len() as u32;
        let lanes = LANES * list.len().div_ceil(LANES).max(least);
        let lanes = padded(list, lanes, &self.ends, self.vertices);
        for vertex in lanes.as_chunks::<LANES>().0 {
            let component = |i: usize| vertex.map(|v| self.vertices[v as usize][i]);
            self.out.blocks.push(Block { x: component(0), y: component(1), z: component(2), vertex: *vertex });
        }
        first
    }
}

/// A list padded to `lanes` entries with an extreme vertex from the hull's far side, which ties
/// with none of the list; its last vertex if there is none.
fn padded(list: &[u32], lanes: usize, ends: &[u32], vertices: &[[f32; 3]]) -> Vec<u32> {
    let distance_sq = |a: u32, b: u32| -> f64 {
        let (a, b) = (vertices[a as usize], vertices[b as usize]);
        a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(b)).powi(2)).sum()
    };
    let mut out = list.to_vec();
    let mut far: Vec<u32> = ends.iter().copied().filter(|end| !list.contains(end)).collect();
    far.sort_by(|a, b| distance_sq(list[0], *b).total_cmp(&distance_sq(list[0], *a)).then(a.cmp(b)));
    let fill = far.first().or(list.last()).copied().unwrap_or(0);
    out.resize(lanes, fill);
    out
}

fn ends(vertices: &[[f32; 3]]) -> Vec<u32> {
    let mut ends = Vec::new();
    for axis in 0..3 {
        let by_axis = |a: &u32, b: &u32| vertices[*a as usize][axis].total_cmp(&vertices[*b as usize][axis]);
        let all = 0..vertices.len() as u32;
        ends.extend(all.clone().min_by(by_axis).into_iter().chain(all.max_by(by_axis)));
    }
    ends.sort_unstable();
    ends.dedup();
    ends
}
