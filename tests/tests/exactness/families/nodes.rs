//! The nodes of a pack's index: the positions of its fans, and the nodes that a direction visits on
//! its way to a leaf.

use glam::DVec3;
use hullmap_format::{
    IndexKind,
    archive::ArchivedPack,
    cube::{self, GRID_BITS},
    edge, fan,
    slot::{BUNDLE_PLANES, Branch, Slot, decode_f64},
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
        decode_f64(self.slots[at], self.slots[at + 1])
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
            let mut below = |first: usize, count: usize| {
                let mut words = self.slots[first..first + count].to_vec();
                words.dedup();
                pending.extend(words.into_iter().map(|word| (word, face, at, bits)));
            };
            match Slot::decode(word) {
                Slot::Branch(payload) => {
                    counts.branches += 1;
                    let branch = Branch::decode(payload);
                    let (side, taken) = (1_u32 << branch.bits, bits + branch.bits);
                    for square in 0..side * side {
                        let offset = [square % side, square / side].map(|step| step << (GRID_BITS - taken));
                        let corner = [at[0] + offset[0], at[1] + offset[1]];
                        pending.push((self.slots[(branch.at + square) as usize], face, corner, taken));
                    }
                }
                Slot::Plane(first) => {
                    counts.planes += 1;
                    below(first as usize + 6, 2);
                }
                Slot::Bundle(first) => {
                    counts.bundles += 1;
                    below(first as usize + 6 * BUNDLE_PLANES, 8);
                }
                Slot::Fan(first) => {
                    counts.fans += 1;
                    let first = first as usize;
                    let steps = 1 << self.slots[first + 16];
                    fans.push(Fan {
                        face,
                        corner: at.map(cube::grid_to_uv),
                        size: 2.0 / f64::from(1 << bits),
                        x: self.vector(first),
                        y: self.vector(first + 6),
                        start: self.number(first + 12),
                        rate: self.number(first + 14),
                        steps,
                    });
                    below(first + fan::HEAD_WORDS as usize, steps as usize);
                }
                Slot::List(_) => counts.lists += 1,
                Slot::Block(_) => counts.blocks += 1,
            }
        }
        (counts, fans)
    }

    /// Adds the nodes that the direction visits to `counts`. Returns false if there is no tree.
    pub fn follow(&self, d: DVec3, counts: &mut Counts) -> bool {
        if !self.kind.is_tree() {
            return false;
        }
        let cell = cube::locate(d.as_vec3().to_array());
        let (mut u, mut v) = (u64::from(cell.u), u64::from(cell.v));
        let mut slot = self.slots[cell.face as usize];
        let mask = (1 << GRID_BITS) - 1;
        loop {
            counts.lists += usize::from(matches!(Slot::decode(slot), Slot::List(_)));
            counts.blocks += usize::from(matches!(Slot::decode(slot), Slot::Block(_)));
            let dot = |n: DVec3| n.x * d.x + n.y * d.y + n.z * d.z > 0.0;
            slot = match Slot::decode(slot) {
                Slot::Branch(payload) => {
                    counts.branches += 1;
                    let Branch { at, bits } = Branch::decode(payload);
                    let top = |path: u64| path >> (GRID_BITS - bits);
                    let word = at as usize + ((top(v) << bits) + top(u)) as usize;
                    (u, v) = (u << bits & mask, v << bits & mask);
                    self.slots[word]
                }
                Slot::Plane(at) => {
                    counts.planes += 1;
                    self.slots[at as usize + 6 + usize::from(dot(self.vector(at as usize)))]
                }
                Slot::Bundle(at) => {
                    counts.bundles += 1;
                    let normal = |plane: usize| {
                        let number = |axis: usize| self.number(at as usize + 2 * (axis * BUNDLE_PLANES + plane));
                        DVec3::new(number(0), number(1), number(2))
                    };
                    let mut plane = 0;
                    while plane < BUNDLE_PLANES {
                        plane = 2 * plane + 1 + usize::from(dot(normal(plane)));
                    }
                    self.slots[at as usize + 6 * BUNDLE_PLANES + plane - BUNDLE_PLANES]
                }
                Slot::Fan(at) => {
                    counts.fans += 1;
                    let at = at as usize;
                    let step = fan::slot(|i| self.number(at + 2 * i), self.slots[at + 16], d.to_array());
                    self.slots[at + fan::HEAD_WORDS as usize + step as usize]
                }
                Slot::List(_) | Slot::Block(_) => break,
            };
        }
        true
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
