//! Reader of a hull's direction index: the leaf of a direction, by the rules of the runtime, but
//! slow and simple.
//!
//! The runtime does not expose its index, so this reads the same words from the bytes of the pack.
//! Directions are located as described in `docs/contributors/FORMAT.md`.

use hullmap::{Hull, Pack};
use hullmap_format::{
    IndexKind,
    archive::LANES,
    check, cube, descent,
    header::HEADER_LEN,
    node::{Node, Words},
    sections::Sections,
    slot::Slot,
    walk::MAX_NODES,
};
use rkyv::util::AlignedVec;

use crate::sizes::{Section, sections};

#[derive(Debug)]
pub struct Contents {
    /// The direction index of each hull.
    pub indices: Vec<IndexReader>,
    pub sections: Vec<Section>,
}

impl Contents {
    /// `None` if the pack is damaged, and was opened without its checks.
    pub fn of_pack(pack: &Pack) -> Option<Self> {
        // Aligned as the archive requires.
        let mut bytes = AlignedVec::<HEADER_LEN>::new();
        bytes.extend_from_slice(pack.bytes());
        let payload = bytes.get(HEADER_LEN..).unwrap_or_default();
        let archive = Sections::read(payload).ok()?;
        check::structure(&archive, payload).ok()?;
        let index = |(hull, ends): (usize, Vec<End>)| {
            let (start, end) = (&archive.spans[hull], &archive.spans[hull + 1]);
            let words = start.slot.to_native() as usize..end.slot.to_native() as usize;
            let blocks = start.block.to_native() as usize..end.block.to_native() as usize;
            let record = &archive.hulls[hull];
            IndexReader {
                kind: IndexKind::of_record(record).unwrap_or(IndexKind::None),
                leaf_blocks: record.leaf_blocks.to_native(),
                words: archive.slots[words].iter().map(|word| word.to_native()).collect(),
                blocks: archive.blocks[blocks].iter().map(|block| block.vertex.map(|v| v.to_native())).collect(),
                ends,
            }
        };
        if archive.hulls.len() != pack.hull_count() {
            return None;
        }
        let indices = pack.hulls().map(|hull| ends(&hull)).enumerate().map(index).collect();
        Some(Self { indices, sections: sections(&archive, bytes.len()) })
    }
}

#[derive(Clone, Debug)]
pub struct IndexReader {
    pub kind: IndexKind,
    /// Number of blocks of a plain leaf.
    pub leaf_blocks: u32,
    pub words: Vec<u32>,
    /// The vertex in each lane of each block.
    pub blocks: Vec<[u32; LANES]>,
    /// Vertices that unused lanes may hold.
    ends: Vec<End>,
}

#[derive(Clone, Debug)]
struct End {
    vertex: u32,
    /// The vertices that share an edge with it, ascending.
    neighbours: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Leaf {
    pub first: u32,
    pub count: u32,
    /// Number of nodes read on the way.
    pub nodes: u32,
}

impl Leaf {
    /// Dot products that a query takes in it.
    pub fn dots(self) -> u32 {
        self.count * LANES as u32
    }
}

impl IndexReader {
    /// The leaf of a direction, whose largest coordinate is about 1.
    pub fn leaf(&self, dir: [f32; 3]) -> Leaf {
        let cell = cube::locate(dir);
        let Some(root) = descent::root(self.kind, cell) else {
            return Leaf { first: 0, count: self.blocks.len() as u32, nodes: 0 };
        };
        let (mut slot, mut path, mut nodes) = (self.slot(root), descent::path(cell), 0);
        while nodes < MAX_NODES
            && let Some(node) = self.node(slot)
            && let Some((at, rest)) = descent::child(&self.words[..], node, path, dir.map(f64::from))
        {
            (slot, path) = (self.slot(at), rest);
            nodes += 1;
        }
        let (first, count) = match slot {
            Slot::Block(first) => (first, self.leaf_blocks),
            Slot::List(at) => (self.words[..].word(at as usize), self.words[..].word(at as usize + 1)),
            _ => (0, self.blocks.len() as u32),
        };
        Leaf { first, count, nodes }
    }

    /// Candidates, ascending: the leaf's lanes without padding, which comes last, and is an extreme
    /// vertex on the hull's far side. A single such lane is a candidate if it shares an edge with
    /// another, because the normal cones of a cell's candidates are adjacent.
    pub fn candidates(&self, leaf: Leaf) -> Vec<u32> {
        let run = leaf.first as usize..(leaf.first + leaf.count) as usize;
        let mut lanes = self.blocks.get(run).unwrap_or_default().as_flattened().to_vec();
        let Some(&last) = lanes.last() else { return lanes };
        let filled = lanes.iter().rev().take_while(|&&lane| lane == last).count();
        lanes.truncate(lanes.len() - filled);
        let end = self.ends.iter().find(|end| end.vertex == last);
        let fills = match end {
            // The last one is padding only if all extreme vertices are candidates.
            _ if lanes.last().is_some_and(|&before| before > last) => true,
            Some(_) if filled > 1 => self.ends.iter().any(|end| end.vertex != last && !lanes.contains(&end.vertex)),
            Some(end) => !lanes.iter().any(|lane| end.neighbours.binary_search(lane).is_ok()),
            None => false,
        };
        if lanes.is_empty() || !fills {
            lanes.push(last);
        }
        lanes
    }

    pub fn slot(&self, at: usize) -> Slot {
        Slot::decode(self.words[..].word(at))
    }

    pub fn node(&self, slot: Slot) -> Option<Node> {
        Node::below(slot, self.kind.branches(), &self.words[..])
    }

    pub fn slots(&self, node: Node) -> &[u32] {
        self.words.get(node.slots()).unwrap_or_default()
    }
}

fn ends(hull: &Hull) -> Vec<End> {
    let coordinates = |axis: usize| hull.vertices().map(move |vertex| vertex[axis]).enumerate();
    let mut ends = Vec::new();
    for axis in 0..3 {
        ends.extend(coordinates(axis).min_by(|a, b| a.1.total_cmp(&b.1)));
        ends.extend(coordinates(axis).max_by(|a, b| a.1.total_cmp(&b.1)));
    }
    let mut ends: Vec<u32> = ends.into_iter().map(|(vertex, _)| vertex as u32).collect();
    ends.sort_unstable();
    ends.dedup();
    ends.into_iter().map(|vertex| End { vertex, neighbours: hull.neighbours(vertex).collect() }).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use hullmap_bake::IndexKind;
    use shapes::rng::SplitMix64;

    use super::*;
    use crate::test_packs::{KINDS, baked, cloud};

    #[test]
    fn leaves_match_the_runtime_and_hold_its_answer() {
        for kind in KINDS {
            let (pack, contents) = baked(cloud(600), kind);
            let (hull, index) = (pack.hull(0).unwrap(), &contents.indices[0]);
            let mut random = SplitMix64::new(2);
            let mut deepest = 0;
            for _ in 0..20_000 {
                let dir = Vec3::from_array(random.direction().map(|c| c as f32));
                let leaf = index.leaf(dir.to_array());
                let cost = hull.support_cost(dir);
                assert_eq!((leaf.nodes, leaf.dots()), (cost.nodes, cost.dots), "{kind:?} {dir}");
                let candidates = index.candidates(leaf);
                assert!(candidates.is_sorted() && candidates.contains(&hull.support(dir).index), "{kind:?} {dir}");
                deepest = deepest.max(leaf.nodes);
            }
            let is_flat = matches!(kind, IndexKind::CubeMap { .. } | IndexKind::None);
            assert_eq!(deepest == 0, is_flat, "{kind:?}");
        }
    }

    #[test]
    fn padding_is_not_a_candidate() {
        let index = |lanes: [u32; LANES]| IndexReader {
            kind: IndexKind::None,
            leaf_blocks: 1,
            words: Vec::new(),
            blocks: vec![lanes],
            ends: vec![End { vertex: 1, neighbours: vec![2] }, End { vertex: 9, neighbours: vec![8] }],
        };
        let leaf = Leaf { first: 0, count: 1, nodes: 0 };
        let candidates = |lanes| index(lanes).candidates(leaf);
        assert_eq!(candidates([2, 3, 9, 9, 9, 9, 9, 9]), [2, 3]);
        assert_eq!(candidates([2, 3, 4, 5, 6, 7, 8, 1]), [2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(candidates([0, 1, 9, 9, 9, 9, 9, 9]), [0, 1, 9], "all ends are candidates");
        assert_eq!(candidates([5; LANES]), [5]);
        assert_eq!(candidates([1, 2, 3, 4, 5, 6, 7, 8]), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(candidates([0, 2, 3, 4, 5, 6, 7, 9]), [0, 2, 3, 4, 5, 6, 7], "far from all others");
        assert_eq!(candidates([0, 2, 3, 4, 5, 6, 8, 9]), [0, 2, 3, 4, 5, 6, 8, 9], "beside 8");
    }
}
