//! Support query of a hull: the choice between a scan and a look-up in the direction index (cube
//! map or quadtree over the Gauss map), which leads from the direction to a leaf and its support
//! vertex.
//!
//! 1. [`cube::locate`] finds the cell of the finest cube-map grid that contains the direction.
//! 2. A tree is descended from the root of the cell's cube face: a branch reads the next bits of u
//!    and v, a plane the sign of n·d, a fan an angle. A uniform cube map is a single read. Without
//!    an index, all blocks form one leaf.
//! 3. The support vertex is the leaf's candidate with the maximum dot product (`best_candidate`).
//!
//! [`Index::support`] chooses the path for one block, and [`Index::support_out_of_line`] for more.
//! Up to four blocks without an index are scanned at once, without a look-up. Otherwise
//! [`Index::root`] matches the kind of the index, and [`Index::leaf`] starts there. A batch
//! interrupts its look-ups ([`Index::start_lookup`], [`Index::continue_lookup`]), which visit the
//! same nodes.
//! Whether a query starts at a hint instead is decided in `hull/support_mapping.rs`.
//!
//! # Reference
//! B. Kenwright, "Generic Convex Collision Detection using Support Mapping", for the cube map and
//! the binary tree.
//!
//! Every index from the file is followed with a bounds check and a limit of steps, although
//! `hullmap_format::check` has already proved that they cannot fail in an opened pack. The checks
//! cost nothing measurable, and keep this file free of unsafe code and of endless loops for packs
//! that were opened unchecked.

use std::marker::PhantomData;

use hullmap_format::{
    IndexKind,
    archive::{ArchivedBlock, LANES},
    cube::{self, Cell},
    descent, fan,
    node::{Branches, Words},
    slot::{BUNDLE_WORDS, LIST_WORDS, PLANE_WORDS, Slot},
    walk::{Cost, MAX_NODES},
};
use rkyv::rend::u32_le;

use super::best_candidate::{self, best, best_of_blocks, exactly};
use super::candidate::Candidate;
use super::direction::Direction;
use super::paused_lookup::{Lookup, LookupKind};
use super::simd::{self, Dispatch, Kernel, Portable, Simd};

/// Maximum number of blocks of a leaf that are fetched ahead. The processor itself fetches what
/// follows when it reads them.
const FETCHED_BLOCKS: usize = 4;

/// Number of blocks of a hull that are fetched while another hull is queried: as many as arrive in
/// that time.
const PART_BLOCKS: usize = 8;

/// Slots at the front of a tree: one for each face of the cube.
const FACES: u32 = 6;

const LINE_WORDS: usize = 16;

/// A hull's direction index, read in place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Index<'a> {
    pub(crate) kind: IndexKind,
    /// Number of blocks in a leaf of the usual size ([`Slot::Block`]).
    pub(crate) leaf_blocks: u32,
    pub(crate) slots: &'a [u32_le],
    pub(crate) blocks: &'a [ArchivedBlock],
    /// Largest coordinate magnitude of the hull's vertices.
    pub(crate) reach: f32,
    pub(crate) dispatch: Dispatch,
}

/// Where the look-up of a direction starts.
enum Root {
    /// The slot of the cell's cube face, with branches into squares below it.
    Squares(Cell),
    /// The slot of the cell's cube face, with branches into halves below it.
    Halves(Cell),
    /// The slot of a cell of a cube map, at this word. There are no branches.
    Uniform(usize),
    /// All blocks: there is no index.
    Blocks,
}

/// Candidates for a direction, and the number of nodes visited to find them.
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

/// Kernel of a support query that finds the leaf first: through the index, or all blocks if there
/// is none.
struct WholeLookup<'i, 'a, T>(&'i Index<'a>, PhantomData<T>);

impl<T> Clone for WholeLookup<'_, '_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for WholeLookup<'_, '_, T> {}

impl<'a, T> Kernel for WholeLookup<'_, 'a, T>
where
    [T; 3]: Direction,
{
    type Scalar = T;
    type Output = Candidate<'a>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S, dir: [T; 3]) -> Candidate<'a> {
        let index = self.0;
        let size = cube::largest(dir.narrow());
        // NaN takes the failing branch.
        if !cube::IN_RANGE.contains(&size) {
            return index.support_out_of_range(dir.exact());
        }
        best(simd, index.leaf(dir).blocks, dir, index.reach)
    }
}

/// Kernel of a support query whose leaf is known.
#[derive(Clone, Copy)]
struct Pick<'a, T>(&'a [ArchivedBlock], f32, PhantomData<T>);

impl<'a, T> Kernel for Pick<'a, T>
where
    T: Copy,
    [T; 3]: Direction,
{
    type Scalar = T;
    type Output = Candidate<'a>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S, dir: [T; 3]) -> Candidate<'a> {
        best(simd, self.0, dir, self.1)
    }
}

/// Kernel of a support query that scans all `N` blocks of a small hull. It needs no index, no range
/// check other than the margin's, and few registers.
#[derive(Clone, Copy)]
struct Scan<'i, 'a, T, const N: usize>(&'a [ArchivedBlock; N], &'i Index<'a>, PhantomData<T>);

impl<'a, T, const N: usize> Kernel for Scan<'_, 'a, T, N>
where
    T: Copy,
    [T; 3]: Direction,
{
    type Scalar = T;
    type Output = Candidate<'a>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S, dir: [T; 3]) -> Candidate<'a> {
        match best_candidate::margin(dir.narrow(), self.1.reach) {
            Some(margin) => best_of_blocks(simd, self.0, dir, margin),
            None => self.1.support_out_of_range(dir.exact()),
        }
    }
}

impl<'a> Index<'a> {
    /// Index and position of the support vertex in direction `dir`.
    #[inline(always)]
    pub(crate) fn support<T>(&self, dir: [T; 3]) -> (u32, [f32; 3])
    where
        T: Copy,
        [T; 3]: Direction,
    {
        let [x, y, z] = dir;
        // Only hulls of one block are inlined here. Inlining more makes them slower.
        let found = match exactly::<1>(self.blocks) {
            Some(few) if self.has_no_index() => self.dispatch.run(Scan(few, self, PhantomData), [x, y, z]),
            _ => self.support_out_of_line(x, y, z),
        };
        found.read()
    }

    #[inline(never)]
    fn support_out_of_line<T>(&self, x: T, y: T, z: T) -> Candidate<'a>
    where
        T: Copy,
        [T; 3]: Direction,
    {
        let dir = [x, y, z];
        if self.has_no_index() {
            if let Some(few) = exactly::<2>(self.blocks) {
                return self.dispatch.run(Scan(few, self, PhantomData), dir);
            }
            if let Some(few) = exactly::<3>(self.blocks) {
                return self.dispatch.run(Scan(few, self, PhantomData), dir);
            }
            if let Some(few) = exactly::<4>(self.blocks) {
                return self.dispatch.run(Scan(few, self, PhantomData), dir);
            }
        }
        self.dispatch.run(WholeLookup(self, PhantomData), dir)
    }

    /// Whether there is no index: all blocks are one leaf.
    #[inline(always)]
    fn has_no_index(&self) -> bool {
        self.slots.is_empty()
    }

    /// Fetches what every look-up reads first: the slots of the six cube faces, or the blocks of a
    /// small hull. A cube map has no common slots.
    #[inline]
    pub(crate) fn fetch_ahead(&self) {
        if self.has_no_index() {
            self.fetch_leaf(self.blocks);
        } else if self.kind.branches() != Branches::None {
            self.fetch_words(0, FACES);
        }
    }

    /// Fetches a part of the index: [`PART_BLOCKS`] blocks, and as large a share of the words.
    /// Returns whether there is another part.
    pub(crate) fn fetch_part(&self, part: usize) -> bool {
        let parts = self.blocks.len().div_ceil(PART_BLOCKS);
        let words = self.slots.len().div_ceil(parts.max(1)).next_multiple_of(LINE_WORDS);
        self.blocks.iter().skip(part * PART_BLOCKS).take(PART_BLOCKS).for_each(simd::fetch);
        self.slots.iter().skip(part * words).take(words).step_by(LINE_WORDS).for_each(simd::fetch);
        part + 1 < parts
    }

    /// Starts a look-up of a direction, and fetches the word of the index that it reads next.
    ///
    /// It reads the slot of the cube face at once, which [`fetch_ahead`](Self::fetch_ahead) or an
    /// earlier look-up has fetched. The direction comes as three scalars so that it stays in
    /// registers.
    pub(crate) fn start_lookup(&self, x: f64, y: f64, z: f64) -> Lookup {
        let dir = [x, y, z];
        let narrow = Direction::narrow(dir);
        let in_range = cube::IN_RANGE.contains(&cube::largest(narrow));
        if !in_range || best_candidate::margin(narrow, self.reach).is_none() {
            return Lookup::WHOLE;
        }
        match self.root(dir) {
            // The slots of the cube faces have been fetched.
            Root::Squares(cell) => self.below(self.word(cell.face as usize), descent::path(cell), 0),
            Root::Uniform(at) => self.await_word(LookupKind::Uniform, at as u32, [0; 2], 0),
            Root::Halves(cell) => self.fetch_leaf(self.descend_halves(cell, x, y, z).blocks),
            Root::Blocks => self.fetch_leaf(self.blocks),
        }
    }

    /// Reads what a look-up waits for, and fetches what it reads next.
    pub(crate) fn continue_lookup(&self, dir: [f64; 3], lookup: Lookup) -> Lookup {
        let Lookup { path, at, nodes, kind } = lookup;
        if u32::from(nodes) == MAX_NODES {
            // Unreachable in a checked pack.
            return Lookup::WHOLE;
        }
        match kind {
            LookupKind::Square => self.below(self.word(at as usize), path, nodes),
            LookupKind::Uniform => self.await_node(self.word(at as usize), nodes),
            LookupKind::Node => {
                let slot = Slot::decode(at);
                match self.past_plane(slot, dir) {
                    Some(word) => self.await_node(word, nodes + 1),
                    None => self.fetch_leaf(self.leaf_at(slot, 0).blocks),
                }
            }
            LookupKind::Leaf | LookupKind::Whole => lookup,
        }
    }

    /// Fetches what is below a slot of a tree of squares, which no plane or fan has led to.
    #[inline(always)]
    fn below(&self, slot: u32, path: [u32; 2], nodes: u16) -> Lookup {
        match Slot::branch(slot) {
            Some(payload) => {
                let (at, path) = descent::square(payload, path);
                self.await_word(LookupKind::Square, at as u32, path, nodes + 1)
            }
            None => self.await_node(slot, nodes),
        }
    }

    /// Fetches the leaf of a slot, or the node that leads to one.
    #[inline(always)]
    fn await_node(&self, slot: u32, nodes: u16) -> Lookup {
        match Slot::block(slot) {
            Some(first) => self.fetch_leaf(self.run(first, self.leaf_blocks)),
            None => self.fetch_node(slot, nodes),
        }
    }

    #[inline(never)]
    fn fetch_node(&self, slot: u32, nodes: u16) -> Lookup {
        match Slot::decode(slot) {
            Slot::Plane(at) => self.fetch_words(at, PLANE_WORDS),
            Slot::Bundle(at) => self.fetch_words(at, BUNDLE_WORDS),
            Slot::Fan(at) => self.fetch_words(at, fan::HEAD_WORDS + 1),
            Slot::List(at) => self.fetch_words(at, LIST_WORDS),
            // Unreachable in a checked pack: all blocks are a valid leaf.
            Slot::Branch(_) | Slot::Block(_) => {}
        }
        Lookup { path: [0; 2], at: slot, nodes, kind: LookupKind::Node }
    }

    /// [`support`](Self::support) in direction `dir`, from a look-up that has reached its leaf.
    #[inline(always)]
    pub(crate) fn finish_lookup(&self, dir: [f64; 3], lookup: Lookup) -> (u32, [f32; 3]) {
        let [first, count] = [lookup.at, lookup.path[0]].map(|number| number as usize);
        if lookup.kind == LookupKind::Leaf
            && let Some(blocks) = self.blocks.get(first..first + count)
            && !blocks.is_empty()
        {
            return self.dispatch.run(Pick(blocks, self.reach, PhantomData), dir).read();
        }
        self.support(dir)
    }

    #[inline(always)]
    fn await_word(&self, kind: LookupKind, at: u32, path: [u32; 2], nodes: u16) -> Lookup {
        self.slots.get(at as usize).into_iter().for_each(simd::fetch);
        Lookup { path, at, nodes, kind }
    }

    /// Fetches `count` words from the word `at` on.
    #[inline]
    fn fetch_words(&self, at: u32, count: u32) {
        let words = self.slots.get(at as usize..at as usize + count as usize).unwrap_or_default();
        // They start anywhere in a cache line, so the last one may be in another.
        words.iter().step_by(LINE_WORDS).chain(words.last()).for_each(simd::fetch);
    }

    #[inline]
    fn fetch_leaf(&self, blocks: &[ArchivedBlock]) -> Lookup {
        blocks.iter().take(FETCHED_BLOCKS).for_each(simd::fetch);
        let first = (blocks.as_ptr().addr() - self.blocks.as_ptr().addr()) / size_of::<ArchivedBlock>();
        Lookup { path: [blocks.len() as u32, 0], at: first as u32, nodes: 0, kind: LookupKind::Leaf }
    }

    /// Support query for directions that would overflow or underflow in f32, and for zero and
    /// non-finite ones.
    #[cold]
    #[inline(never)]
    fn support_out_of_range(&self, dir: [f64; 3]) -> Candidate<'a> {
        let dir = crate::support::direction::normalise_range(dir);
        best(Portable, self.leaf(dir).blocks, dir, self.reach)
    }

    pub(crate) fn cost(&self, dir: [f32; 3]) -> Cost {
        if cube::IN_RANGE.contains(&cube::largest(dir)) {
            self.leaf(dir).cost()
        } else {
            self.leaf(crate::support::direction::normalise_range(dir.map(f64::from))).cost()
        }
    }

    /// The leaf that lists every vertex that can be the support vertex in direction `dir`.
    #[inline(always)]
    pub(crate) fn leaf(&self, dir: impl Direction) -> Leaf<'a> {
        match self.root(dir) {
            Root::Squares(cell) => self.descend_squares(cell, dir),
            Root::Blocks => Leaf { blocks: self.blocks, nodes: 0 },
            Root::Uniform(at) => self.leaf_at(Slot::decode(self.word(at)), 0),
            Root::Halves(cell) => {
                let [x, y, z] = dir.exact();
                self.descend_halves(cell, x, y, z)
            }
        }
    }

    /// Where the look-up of direction `dir` starts. Only here does it depend on the kind of the
    /// index.
    #[inline(always)]
    fn root(&self, dir: impl Direction) -> Root {
        let cell = || cube::locate(dir.narrow());
        match self.kind {
            IndexKind::Tree | IndexKind::Medium | IndexKind::Compact => Root::Squares(cell()),
            IndexKind::None => Root::Blocks,
            IndexKind::CubeMap { resolution } => Root::Uniform(cube::uniform_cell(cell(), resolution) as usize),
            IndexKind::Binary => Root::Halves(cell()),
        }
    }

    #[inline(always)]
    fn descend_squares(&self, cell: Cell, dir: impl Direction) -> Leaf<'a> {
        let [mut u, mut v] = descent::path(cell);
        let mut slot = self.word(cell.face as usize);
        for nodes in 0..MAX_NODES {
            // Tested without decoding the other kinds of slot, since nearly all queries end here.
            let Some(payload) = Slot::branch(slot) else { return self.past_branches(slot, nodes, dir) };
            let (at, path) = descent::square(payload, [u, v]);
            slot = self.word(at);
            [u, v] = path;
        }
        self.leaf_at(Slot::decode(slot), MAX_NODES)
    }

    /// Kenwright's binary search: one bit per step, from u and v alternately. The direction comes
    /// as three scalars so that it stays in registers.
    #[inline(never)]
    fn descend_halves(&self, cell: Cell, x: f64, y: f64, z: f64) -> Leaf<'a> {
        let [mut path, mut other] = descent::path(cell);
        let mut slot = self.word(cell.face as usize);
        for nodes in 0..MAX_NODES {
            let Some(at) = Slot::branch(slot) else { return self.past_branches(slot, nodes, [x, y, z]) };
            let (at, rest) = descent::half(at, [path, other]);
            slot = self.word(at);
            [path, other] = rest;
        }
        self.leaf_at(Slot::decode(slot), MAX_NODES)
    }

    /// Follows plane nodes, if any, to the leaf below `slot`.
    #[inline(always)]
    fn past_branches(&self, slot: u32, nodes: u32, dir: impl Direction) -> Leaf<'a> {
        if let Some(first) = Slot::block(slot) {
            return Leaf { blocks: self.run(first, self.leaf_blocks), nodes };
        }
        let [x, y, z] = dir.exact();
        self.past_planes(slot, nodes, x, y, z)
    }

    /// Takes the direction as three scalars so that it stays in registers. As an array, it would be
    /// stored in parts and read back as a vector at once; that store-forwarding stall costs as much
    /// as the rest.
    #[inline(never)]
    fn past_planes(&self, slot: u32, mut nodes: u32, x: f64, y: f64, z: f64) -> Leaf<'a> {
        let mut slot = Slot::decode(slot);
        let dir = [x, y, z];
        while nodes < MAX_NODES {
            let Some(word) = self.past_plane(slot, dir) else { break };
            slot = Slot::decode(word);
            nodes += 1;
        }
        self.leaf_at(slot, nodes)
    }

    /// The word to which planes or a fan lead; `None` for any other slot.
    #[inline(always)]
    fn past_plane(&self, slot: Slot, dir: [f64; 3]) -> Option<u32> {
        let at = match slot {
            Slot::Plane(at) => descent::plane(self.slots, at as usize, dir),
            Slot::Bundle(at) => descent::bundle(self.slots, at as usize, dir),
            Slot::Fan(at) => descent::step(self.slots, at as usize, dir),
            Slot::Block(_) | Slot::List(_) | Slot::Branch(_) => return None,
        };
        Some(self.word(at))
    }

    fn leaf_at(&self, slot: Slot, nodes: u32) -> Leaf<'a> {
        let blocks = match slot {
            Slot::Block(first) => self.run(first, self.leaf_blocks),
            Slot::List(at) => self.run(self.word(at as usize), self.word(at as usize + 1)),
            // Unreachable in a checked pack. All blocks are a valid leaf.
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
        Words::word(self.slots, at)
    }
}
