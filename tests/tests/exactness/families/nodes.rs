//! The nodes of a pack's index: the positions of its fans, and the nodes that a direction visits on
//! its way to a leaf.

use glam::DVec3;
use hullmap_format::{
    IndexKind,
    archive::ArchivedPack,
    cube::{self, GRID_BITS},
    descent, edge,
    node::{Node, Words as _},
    slot::{Branch, Slot},
};
use rkyv::util::AlignedVec;

/// A fan, and the cell that it divides.
#[derive(Clone, Debug)]
pub struct Fan {
    pub face: u32,
    /// Least u and v of the cell, and its width in both.
    pub corner: [f64; 2],
    pub size: f64,
    pub x: DVec3,
    pub y: DVec3,
    pub start: f64,
    /// Steps in a unit of the angle.
    pub rate: f64,
    pub steps: u32,
}

/// Slots or steps of each kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    pub branches: usize,
    pub planes: usize,
    pub bundles: usize,
    pub fans: usize,
    pub lists: usize,
    pub blocks: usize,
}

impl Counts {
    /// The count of this kind of slot.
    fn count_mut(&mut self, slot: Slot) -> &mut usize {
        match slot {
            Slot::Branch(_) => &mut self.branches,
            Slot::Plane(_) => &mut self.planes,
            Slot::Bundle(_) => &mut self.bundles,
            Slot::Fan(_) => &mut self.fans,
            Slot::List(_) => &mut self.lists,
            Slot::Block(_) => &mut self.blocks,
        }
    }
}

/// The first hull of a pack, its words copied out.
pub struct Words {
    kind: IndexKind,
    slots: Vec<u32>,
    edges: Vec<[f64; 3]>,
    neighbour_starts: Vec<usize>,
}

impl Words {
    pub fn new(file: &[u8]) -> Self {
        let mut payload: AlignedVec<64> = AlignedVec::new();
        payload.extend_from_slice(&file[64..]);
        let pack = rkyv::access::<ArchivedPack, rkyv::rancor::Error>(&payload).unwrap();
        let mut neighbour_starts: Vec<usize> = pack.neighbour_starts.iter().map(|s| s.to_native() as usize).collect();
        neighbour_starts.push(pack.neighbours.len());
        let mut edges = Vec::new();
        if !pack.edges.is_empty() {
            for vertex in neighbour_starts.windows(2) {
                let count = vertex[1] - vertex[0];
                let number = |i: usize| f64::from(pack.edges[3 * vertex[0] + i].to_native());
                edges.extend((0..count).map(|i| [number(i), number(count + i), number(2 * count + i)]));
            }
        }
        let slots = pack.slots.iter().map(|word| word.to_native()).collect();
        Self { kind: IndexKind::of_record(&pack.hulls[0]).unwrap(), slots, edges, neighbour_starts }
    }

    fn number(&self, at: usize) -> f64 {
        self.slots[..].number(at)
    }

    fn vector(&self, at: usize) -> DVec3 {
        DVec3::new(self.number(at), self.number(at + 2), self.number(at + 4))
    }

    /// Numbers of slots of each kind, and all fans. A fan below a plane or another fan has the cell
    /// that this one divides.
    pub fn nodes(&self) -> (Counts, Vec<Fan>) {
        let (mut counts, mut fans) = (Counts::default(), Vec::new());
        if !self.kind.is_tree() {
            return (counts, fans);
        }
        // Slot, face, least u and v in grid numbers, bits taken.
        let mut pending: Vec<(u32, u32, [u32; 2], u32)> =
            (0..6).map(|face| (self.slots[face], face as u32, [0; 2], 0)).collect();
        while let Some((word, face, at, bits)) = pending.pop() {
            let slot = Slot::decode(word);
            *counts.count_mut(slot) += 1;
            if let Slot::Branch(payload) = slot {
                let branch = Branch::decode(payload);
                let (side, taken) = (1_u32 << branch.bits, bits + branch.bits);
                for square in 0..side * side {
                    let offset = [square % side, square / side].map(|step| step << (GRID_BITS - taken));
                    let corner = [at[0] + offset[0], at[1] + offset[1]];
                    pending.push((self.slots[(branch.at + square) as usize], face, corner, taken));
                }
                continue;
            }
            let Some(node) = Node::below(slot, self.kind.branches(), &self.slots[..]) else { continue };
            if let Node::Fan { at: first, bits: steps } = node {
                fans.push(Fan {
                    face,
                    corner: at.map(cube::grid_to_uv),
                    size: 2.0 / f64::from(1 << bits),
                    x: self.vector(first),
                    y: self.vector(first + 6),
                    start: self.number(first + 12),
                    rate: self.number(first + 14),
                    steps: 1 << steps,
                });
            }
            let mut words = self.slots[node.slots()].to_vec();
            words.dedup();
            pending.extend(words.into_iter().map(|word| (word, face, at, bits)));
        }
        (counts, fans)
    }

    /// Adds the nodes that the direction visits to `counts`. Returns false if there is no tree.
    pub fn follow(&self, d: DVec3, counts: &mut Counts) -> bool {
        if !self.kind.is_tree() {
            return false;
        }
        let cell = cube::locate(d.as_vec3().to_array());
        let (mut at, mut path) = (cell.face as usize, descent::path(cell));
        loop {
            let slot = Slot::decode(self.slots[at]);
            *counts.count_mut(slot) += 1;
            let node = Node::below(slot, self.kind.branches(), &self.slots[..]);
            match node.and_then(|node| descent::child(&self.slots[..], node, path, d.to_array())) {
                Some(next) => (at, path) = next,
                None => return true,
            }
        }
    }

    /// Whether the edges of `vertex` certify that it is the support point in direction `d`.
    pub fn is_certain(&self, vertex: u32, d: DVec3) -> bool {
        let at = vertex as usize;
        let run = self.neighbour_starts[at]..self.neighbour_starts[at + 1];
        let least = -f64::from(edge::DOUBT) * d.abs().element_sum();
        !self.edges.is_empty()
            && run.len() <= 16
            && self.edges[run].iter().all(|e| DVec3::from_array(*e).dot(d) < least)
    }
}
