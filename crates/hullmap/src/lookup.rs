//! Direction → leaf of the direction index → support vertex.
//!
//! 1. [`cube::locate`] finds the cell of the finest grid that the direction falls into.
//! 2. A tree is descended from the face's root: an axis node by the next bit of u or v in turn, a plane node by the
//!    sign of n·d. A cube map is one read. Without an index, every block is the leaf.
//! 3. Of the leaf's candidates the one with the greatest dot product wins, the lowest vertex number among equals.
//!
//! Dot products are taken in f64 over the stored f32 coordinates: each product is exact, and the regret is that of two
//! sums, 2e-16 of the largest term.
//!
//! Indices from the file are followed with bounds checks and a step cap although an opened pack has passed
//! [`hullmap_format::check`]: they are never taken, cost nothing measurable, and keep this file free of unsafe code.

use hullmap_format::{
    archive::{ArchivedBlock, LANES},
    cube::{self, GRID_BITS},
    slot::{Slot, decode_normal},
    walk::{Cost, MAX_NODES},
};
use rkyv::rend::u32_le;

/// A hull's direction index, in place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Index<'a> {
    pub(crate) kind: Kind,
    pub(crate) slots: &'a [u32_le],
    pub(crate) blocks: &'a [ArchivedBlock],
}

/// How an index is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scan,
    CubeMap { resolution: u32 },
    Tree,
}

/// The candidates for a direction, and how they were found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<'a> {
    pub(crate) blocks: &'a [ArchivedBlock],
    pub(crate) nodes: u32,
}

impl Leaf<'_> {
    pub(crate) fn cost(&self) -> Cost {
        Cost { nodes: self.nodes, dots: (self.blocks.len() * LANES) as u32 }
    }

    /// Vertex number and position of the best candidate.
    #[inline]
    pub(crate) fn best(&self, dir: [f64; 3]) -> (u32, [f32; 3]) {
        let mut best = (f64::NEG_INFINITY, 0, 0);
        for (number, block) in self.blocks.iter().enumerate() {
            for lane in 0..LANES {
                let dot = f64::from(block.x[lane].to_native()) * dir[0]
                    + f64::from(block.y[lane].to_native()) * dir[1]
                    + f64::from(block.z[lane].to_native()) * dir[2];
                // False for NaN: then the first lane stays.
                if dot > best.0 {
                    best = (dot, number, lane);
                }
            }
        }
        let (_, number, lane) = best;
        match self.blocks.get(number) {
            Some(block) => (
                block.vertex[lane].to_native(),
                [block.x[lane].to_native(), block.y[lane].to_native(), block.z[lane].to_native()],
            ),
            None => (0, [0.0; 3]),
        }
    }
}

impl<'a> Index<'a> {
    /// The leaf that lists every vertex which can be the support point in direction `dir`.
    #[inline]
    pub(crate) fn leaf(&self, dir: [f64; 3]) -> Leaf<'a> {
        match self.kind {
            Kind::Scan => Leaf { blocks: self.blocks, nodes: 0 },
            Kind::CubeMap { resolution } => {
                let cell = cube::uniform_cell(cube::locate(dir), resolution);
                let slot = usize::try_from(cell).map_or(0, |cell| self.word(cell));
                self.leaf_at(Slot::decode(slot), 0)
            }
            Kind::Tree => self.descend(dir),
        }
    }

    #[inline]
    fn descend(&self, dir: [f64; 3]) -> Leaf<'a> {
        let cell = cube::locate(dir);
        // The next bit to branch on is the top one of `path`; u and v take turns.
        let (mut path, mut other) = (cell.u << (32 - GRID_BITS), cell.v << (32 - GRID_BITS));
        let mut slot = Slot::decode(self.word(cell.face as usize));
        for nodes in 0..MAX_NODES {
            slot = Slot::decode(match slot {
                Slot::Axis(at) => {
                    let upper = path >> 31;
                    (path, other) = (other, path << 1);
                    self.word((at + upper) as usize)
                }
                Slot::Plane(at) => self.beside_plane(at as usize, dir),
                Slot::Block(_) | Slot::List(_) => return self.leaf_at(slot, nodes),
            });
        }
        self.leaf_at(slot, MAX_NODES)
    }

    /// The slot on the side of the plane node at `at` on which `dir` lies.
    #[inline]
    fn beside_plane(&self, at: usize, dir: [f64; 3]) -> u32 {
        let Some(node) = self.slots.get(at..).and_then(|rest| rest.first_chunk::<8>()) else { return 0 };
        let words = node.map(|word| word.to_native());
        let normal = decode_normal([words[0], words[1], words[2], words[3], words[4], words[5]]);
        let height = normal[0] * dir[0] + normal[1] * dir[1] + normal[2] * dir[2];
        if height > 0.0 { words[7] } else { words[6] }
    }

    #[inline]
    fn leaf_at(&self, slot: Slot, nodes: u32) -> Leaf<'a> {
        let (first, count) = match slot {
            Slot::Block(block) => (block, 1),
            Slot::List(at) => (self.word(at as usize), self.word(at as usize + 1)),
            // Not in a pack that has been checked.
            Slot::Axis(_) | Slot::Plane(_) => (0, 1),
        };
        let range = first as usize..first as usize + count as usize;
        Leaf { blocks: self.blocks.get(range).unwrap_or(self.blocks), nodes }
    }

    #[inline]
    fn word(&self, at: usize) -> u32 {
        self.slots.get(at).map_or(0, |word| word.to_native())
    }
}
