//! Direction → leaf of the direction index → support vertex.
//!
//! 1. [`cube::locate`] finds the cell of the finest grid that the direction falls into.
//! 2. A tree is descended from the face's root: a branch by the next bits of u and v, planes by the signs of n·d, a fan
//!    by an angle. A cube map is one read. Without an index, every block is the leaf.
//! 3. Of the leaf's candidates the one with the greatest dot product wins, the lowest vertex number among equals
//!    ([`crate::candidates`]).
//!
//! Indices from the file are followed with bounds checks and a step cap although an opened pack has passed
//! [`hullmap_format::check`], so that none can fail: they cost nothing measurable, and keep this file free of unsafe code.

use std::marker::PhantomData;

use hullmap_format::{
    archive::{ArchivedBlock, LANES},
    cube::{self, Cell, GRID_BITS},
    fan,
    slot::{BUNDLE_PLANES, BUNDLE_WORDS, Branch, PLANE_WORDS, Slot, decode_f64},
    walk::{Cost, MAX_NODES},
};
use rkyv::rend::u32_le;

use crate::{
    candidates::{self, Candidate},
    direction::Direction,
    simd::{Level, Portable, Simd, Work},
};

/// A hull's direction index, in place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Index<'a> {
    pub(crate) kind: Kind,
    /// Blocks of a plain leaf.
    pub(crate) leaf_blocks: u32,
    pub(crate) slots: &'a [u32_le],
    pub(crate) blocks: &'a [ArchivedBlock],
    /// Greatest magnitude of any coordinate of the hull's vertices.
    pub(crate) reach: f32,
    pub(crate) level: Level,
}

/// How an index is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scan,
    CubeMap { resolution: u32 },
    Binary,
    Tree,
}

/// The candidates for a direction, and how many nodes led to them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<'a> {
    blocks: &'a [ArchivedBlock],
    nodes: u32,
}

impl Leaf<'_> {
    pub(crate) fn cost(&self) -> Cost {
        Cost { nodes: self.nodes, dots: (self.blocks.len() * LANES) as u32 }
    }
}

/// A support query in a direction of these numbers.
struct Query<'i, 'a, T>(&'i Index<'a>, PhantomData<T>);

impl<T> Clone for Query<'_, '_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Query<'_, '_, T> {}

impl<'a, T> Work for Query<'_, 'a, T>
where
    [T; 3]: Direction,
{
    type Scalar = T;
    type Answer = Candidate<'a>;

    #[inline(always)]
    fn with<S: Simd>(self, simd: S, dir: [T; 3]) -> Candidate<'a> {
        let index = self.0;
        let size = cube::largest(dir.narrow());
        // NaN takes the failing branch.
        if !cube::IN_RANGE.contains(&size) {
            return index.support_out_of_range(dir.exact());
        }
        candidates::best(simd, index.leaf(dir).blocks, dir, index.reach)
    }
}

/// A support query of a hull of few vertices: no index, no range but that of the margin, and few registers.
#[derive(Clone, Copy)]
struct Few<'i, 'a, T, const N: usize>(&'a [ArchivedBlock; N], &'i Index<'a>, PhantomData<T>);

impl<'a, T, const N: usize> Work for Few<'_, 'a, T, N>
where
    T: Copy,
    [T; 3]: Direction,
{
    type Scalar = T;
    type Answer = Candidate<'a>;

    #[inline(always)]
    fn with<S: Simd>(self, simd: S, dir: [T; 3]) -> Candidate<'a> {
        match candidates::margin(dir.narrow(), self.1.reach) {
            Some(margin) => candidates::best_of_few(simd, self.0, dir, margin),
            None => self.1.support_out_of_range(dir.exact()),
        }
    }
}

impl<'a> Index<'a> {
    /// Vertex number and position of the support vertex in direction `dir`.
    #[inline(always)]
    pub(crate) fn support<T>(&self, dir: [T; 3]) -> (u32, [f32; 3])
    where
        T: Copy,
        [T; 3]: Direction,
    {
        let [x, y, z] = dir;
        // The smallest hulls are asked in place; more than that in place makes these slower.
        let found = match (self.kind, self.blocks.as_array::<1>()) {
            (Kind::Scan, Some(few)) => self.level.run(Few(few, self, PhantomData), [x, y, z]),
            _ => self.support_of_many(x, y, z),
        };
        found.read()
    }

    #[inline(never)]
    fn support_of_many<T>(&self, x: T, y: T, z: T) -> Candidate<'a>
    where
        T: Copy,
        [T; 3]: Direction,
    {
        let dir = [x, y, z];
        if self.kind == Kind::Scan {
            if let Some(few) = self.blocks.as_array::<2>() {
                return self.level.run(Few(few, self, PhantomData), dir);
            }
            if let Some(few) = self.blocks.as_array::<3>() {
                return self.level.run(Few(few, self, PhantomData), dir);
            }
            if let Some(few) = self.blocks.as_array::<4>() {
                return self.level.run(Few(few, self, PhantomData), dir);
            }
        }
        self.level.run(Query(self, PhantomData), dir)
    }

    /// The same for directions so long or short that f32 would overflow, and for those that are none.
    #[cold]
    #[inline(never)]
    fn support_out_of_range(&self, dir: [f64; 3]) -> Candidate<'a> {
        let dir = crate::direction::in_range(dir);
        candidates::best(Portable, self.leaf(dir).blocks, dir, self.reach)
    }

    /// What the support query in direction `dir` costs.
    pub(crate) fn cost(&self, dir: [f32; 3]) -> Cost {
        if cube::IN_RANGE.contains(&cube::largest(dir)) {
            self.leaf(dir).cost()
        } else {
            self.leaf(crate::direction::in_range(dir.map(f64::from))).cost()
        }
    }

    /// The leaf that lists every vertex which can be the support point in direction `dir`.
    #[inline(always)]
    pub(crate) fn leaf(&self, dir: impl Direction) -> Leaf<'a> {
        let cell = || cube::locate(dir.narrow());
        match self.kind {
            Kind::Tree => self.descend_squares(cell(), dir),
            Kind::Scan => Leaf { blocks: self.blocks, nodes: 0 },
            Kind::CubeMap { resolution } => {
                let cell = cube::uniform_cell(cell(), resolution);
                let slot = usize::try_from(cell).map_or(0, |cell| self.word(cell));
                self.leaf_at(Slot::decode(slot), 0)
            }
            Kind::Binary => self.descend_halves(cell(), dir),
        }
    }

    #[inline(always)]
    fn descend_squares(&self, cell: Cell, dir: impl Direction) -> Leaf<'a> {
        // The next bits to branch on are the top ones.
        let (mut u, mut v) = (cell.u << (32 - GRID_BITS), cell.v << (32 - GRID_BITS));
        let mut slot = self.word(cell.face as usize);
        for nodes in 0..MAX_NODES {
            // Told apart by hand, as nearly all queries end here.
            let Some(payload) = Slot::branch(slot) else { return self.past_branches(slot, nodes, dir) };
            let Branch { at, bits } = Branch::decode(payload);
            let top = |path: u32| (u64::from(path) << bits >> 32) as u32;
            slot = self.word((at + (top(v) << bits | top(u))) as usize);
            (u, v) = (u << bits, v << bits);
        }
        self.leaf_at(Slot::decode(slot), MAX_NODES)
    }

    /// The paper's binary search: one bit a step, u and v in turn.
    #[inline(never)]
    fn descend_halves(&self, cell: Cell, dir: impl Direction) -> Leaf<'a> {
        let (mut path, mut other) = (cell.u << (32 - GRID_BITS), cell.v << (32 - GRID_BITS));
        let mut slot = self.word(cell.face as usize);
        for nodes in 0..MAX_NODES {
            let Some(at) = Slot::branch(slot) else { return self.past_branches(slot, nodes, dir) };
            slot = self.word((at + (path >> 31)) as usize);
            (path, other) = (other, path << 1);
        }
        self.leaf_at(Slot::decode(slot), MAX_NODES)
    }

    /// Follows planes, if there are any, to the leaf below `slot`.
    #[inline(always)]
    fn past_branches(&self, slot: u32, nodes: u32, dir: impl Direction) -> Leaf<'a> {
        if let Some(first) = Slot::block(slot) {
            return Leaf { blocks: self.run(first, self.leaf_blocks), nodes };
        }
        let [x, y, z] = dir.exact();
        self.past_planes(slot, nodes, x, y, z)
    }

    /// The direction comes as three numbers, in registers: read back from memory as a vector just after it was stored by
    /// parts, it would stall the processor for as long as all the rest takes.
    #[inline(never)]
    fn past_planes(&self, slot: u32, mut nodes: u32, x: f64, y: f64, z: f64) -> Leaf<'a> {
        let mut slot = Slot::decode(slot);
        let dir = [x, y, z];
        while nodes < MAX_NODES {
            slot = Slot::decode(match slot {
                Slot::Plane(at) => self.beside_plane(at as usize, dir),
                Slot::Bundle(at) => self.in_bundle(at as usize, dir),
                Slot::Fan(at) => self.in_fan(at as usize, dir),
                Slot::Block(_) | Slot::List(_) | Slot::Branch(_) => break,
            });
            nodes += 1;
        }
        self.leaf_at(slot, nodes)
    }

    /// The slot on the side of the plane at `at` on which `dir` lies.
    #[inline]
    #[expect(
        clippy::indexing_slicing,
        reason = "three numbers of two words each, then two slots, are a node's 8 words"
    )]
    fn beside_plane(&self, at: usize, dir: [f64; 3]) -> u32 {
        let Some(node) = self.words::<{ PLANE_WORDS as usize }>(at) else { return 0 };
        let n = |axis: usize| decode_f64(node[2 * axis].to_native(), node[2 * axis + 1].to_native());
        let height = n(0) * dir[0] + n(1) * dir[1] + n(2) * dir[2];
        node[6 + usize::from(height > 0.0)].to_native()
    }

    /// The slot of the part of the bundle at `at` in which `dir` lies.
    #[inline]
    #[expect(
        clippy::indexing_slicing,
        reason = "three numbers a plane, of two words each, then eight slots, are a node's words; sides are 0 or 1, so that `front` \
                  is read below 7 and slots below 8"
    )]
    fn in_bundle(&self, at: usize, dir: [f64; 3]) -> u32 {
        let Some(node) = self.words::<{ BUNDLE_WORDS as usize }>(at) else { return 0 };
        let mut front = [0; BUNDLE_PLANES];
        for (plane, front) in front.iter_mut().enumerate() {
            let n = |axis: usize| {
                let word = 2 * (axis * BUNDLE_PLANES + plane);
                decode_f64(node[word].to_native(), node[word + 1].to_native())
            };
            *front = usize::from(n(0) * dir[0] + n(1) * dir[1] + n(2) * dir[2] > 0.0);
        }
        let first = front[0];
        let second = front[1 + first];
        let third = front[3 + 2 * first + second];
        node[6 * BUNDLE_PLANES + 4 * first + 2 * second + third].to_native()
    }

    /// The slot of the part of the fan at `at` in which `dir` lies.
    #[inline]
    #[expect(clippy::indexing_slicing, reason = "`fan::slot` asks for the numbers of the head, of two words each")]
    fn in_fan(&self, at: usize, dir: [f64; 3]) -> u32 {
        const HEAD: usize = fan::HEAD_WORDS as usize;
        let Some(head) = self.words::<HEAD>(at) else { return 0 };
        let number = |i: usize| decode_f64(head[2 * i].to_native(), head[2 * i + 1].to_native());
        self.word(at + HEAD + fan::slot(number, head[HEAD - 1].to_native(), dir) as usize)
    }

    fn leaf_at(&self, slot: Slot, nodes: u32) -> Leaf<'a> {
        let blocks = match slot {
            Slot::Block(first) => self.run(first, self.leaf_blocks),
            Slot::List(at) => self.run(self.word(at as usize), self.word(at as usize + 1)),
            // Not in a pack that has been checked.
            Slot::Branch(_) | Slot::Plane(_) | Slot::Bundle(_) | Slot::Fan(_) => self.blocks,
        };
        Leaf { blocks, nodes }
    }

    #[inline]
    fn run(&self, first: u32, count: u32) -> &'a [ArchivedBlock] {
        self.blocks.get(first as usize..first as usize + count as usize).unwrap_or(self.blocks)
    }

    #[inline]
    fn word(&self, at: usize) -> u32 {
        self.slots.get(at).map_or(0, |word| word.to_native())
    }

    #[inline]
    fn words<const N: usize>(&self, at: usize) -> Option<&'a [u32_le; N]> {
        self.slots.get(at..)?.first_chunk()
    }
}
