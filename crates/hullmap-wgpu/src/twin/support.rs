//! The support query: `kernels/support.wgsl` in Rust.
//!
//! # Steps
//! 1. The direction's cell, and the branches above its leaf. A direction is placed up to rounding
//!    error, which the baker's margin covers.
//! 2. Planes and fans have no margin. Wherever f32 cannot distinguish their sides, both are
//!    visited, from a small stack.
//! 3. The candidate with the maximum dot product, of all leaves visited.

use hullmap_format::{
    cube::{self, Cell},
    descent, fan,
    slot::{BUNDLE_HEAD_WORDS, BUNDLE_PARTS, BUNDLE_PLANES, Branch, F64_WORDS, PLANE_HEAD_WORDS, Slot, normal_index},
};

use super::vector::{EPSILON, LOWEST, Vector, dot, l1, mad, sub};
use crate::records::{HullRecord, Tables, kind};

/// Entries of the stack of a support query.
const STACK: usize = 24;

/// Rounding to a grid number, see `hullmap_format::cube`.
const GRID_MASK: u32 = (1 << cube::GRID_BITS) - 1;
const GRID_SCALE: f32 = 4194303.0;
const ROUND_BY: f32 = 12582912.0;

/// Width of the slab around a plane in which its side is uncertain, relative to |d|₁.
const PLANE_DOUBT: f32 = 16.0 * EPSILON;

/// Error of a coordinate in the frame of a fan, relative to |d|₁.
const FAN_DOUBT: f32 = 8.0 * EPSILON;

/// Rounding error of an angle.
const ANGLE_DOUBT: f32 = 32.0 * EPSILON;

/// The result of a support query.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Index of the vertex.
    pub vertex: u32,
    /// Word of the section `blocks` that holds its x.
    pub at: u32,
    /// Its position relative to the hull's centre.
    pub offset: [f32; 3],
    /// Whether everything was read that can hold the support vertex.
    pub is_certain: bool,
}

/// One run of a kernel for one pair or one direction.
pub(super) struct Run<'t> {
    pub(super) tables: &'t Tables<'t>,
    /// Nodes and blocks that may still be read.
    pub(super) fuel: u32,
}

/// An f64 of two words, truncated to f32.
fn decode(low: u32, high: u32) -> f32 {
    let exponent = (high >> 20 & 0x7ff) as i32 - 896;
    if exponent <= 0 {
        return 0.0;
    }
    let magnitude =
        if exponent >= 255 { 0x7f00_0000 } else { (exponent as u32) << 23 | (high & 0xf_ffff) << 3 | low >> 29 };
    f32::from_bits(high & 0x8000_0000 | magnitude)
}

/// The cell of a direction, up to the rounding error of a device.
fn cell<const FUSED: bool>(dir: Vector) -> Cell {
    let mut axis = 0;
    for other in [1, 2] {
        if dir[other].abs() > dir[axis].abs() {
            axis = other;
        }
    }
    let inverse = 1.0 / dir[axis].abs();
    let grid = |c: f32| {
        let t = (c * inverse).clamp(-1.0, 1.0);
        mad::<FUSED>(t, GRID_SCALE, ROUND_BY).to_bits() & GRID_MASK
    };
    let (u, v) = (grid(dir[(axis + 1) % 3]), grid(dir[(axis + 2) % 3]));
    Cell { face: 2 * axis as u32 + (dir[axis].to_bits() >> 31), u, v }
}

impl Run<'_> {
    /// Position of the vertex whose x is at word `at` of `blocks`, relative to the hull's centre.
    pub(super) fn offset(&self, hull: &HullRecord, at: usize) -> Vector {
        let read = |at: usize| f32::from_bits(self.tables.blocks[at]);
        sub([read(at), read(at + 8), read(at + 16)], hull.center)
    }

    fn slot(&self, hull: &HullRecord, at: u32) -> u32 {
        // 0 is a branch, which no leaf, plane or fan leads to: then the query is not certain.
        if at < hull.slot_count { self.tables.slots[(hull.slot_start + at) as usize] } else { 0 }
    }

    /// The f64 of index `index` at the front of the node at `at`, as f32.
    fn number(&self, hull: &HullRecord, at: u32, index: usize) -> f32 {
        let word = at + F64_WORDS * index as u32;
        decode(self.slot(hull, word), self.slot(hull, word + 1))
    }

    /// Possible sides of a plane of the node at `at`, which has `count` planes: 1 behind, 2 in
    /// front, 3 both.
    fn sides<const FUSED: bool>(&self, search: &SupportSearch<'_>, at: u32, [count, plane]: [usize; 2]) -> u32 {
        let SupportSearch { hull, dir, doubt, .. } = *search;
        let normal = [0, 1, 2].map(|axis| self.number(hull, at, normal_index(count, plane, axis)));
        let height = dot::<FUSED>(normal, dir);
        if height > doubt {
            2
        } else if height < -doubt {
            1
        } else if l1(normal) == 0.0 {
            // An unused plane.
            1
        } else {
            3
        }
    }

    /// First and last step of a fan in which the direction may be.
    fn steps<const FUSED: bool>(&self, hull: &HullRecord, at: u32, dir: Vector) -> [u32; 2] {
        let last = (1 << (self.slot(hull, at + fan::BITS_WORD) & 31)) - 1;
        let axis = |first: usize| [0, 1, 2].map(|axis| self.number(hull, at, first + axis));
        let x = dot::<FUSED>(axis(fan::X_AXIS), dir);
        let y = dot::<FUSED>(axis(fan::Y_AXIS), dir);
        let doubt = FAN_DOUBT * l1(dir);
        let steep = y.abs() > x.abs();
        let rise = if steep { -x } else { y };
        let run = if steep { y } else { x };
        let size = run.abs();
        if !(size > 64.0 * doubt) {
            return [0, last];
        }
        let mut turns = 0.0;
        if steep {
            turns += 2.0;
        }
        if run < 0.0 {
            turns += 4.0;
        }
        let angle = rise * (1.0 / run) + turns;
        let error = 4.0 * doubt * (1.0 / size) + ANGLE_DOUBT;
        if !(angle - error > -1.0 && angle + error < 7.0) {
            return [0, last];
        }
        let rate = self.number(hull, at, fan::RATE);
        let from = (angle - self.number(hull, at, fan::START)) * rate;
        let spread = mad::<FUSED>(error, rate, 8.0 * EPSILON * last as f32);
        let step = |at: f32| {
            if !(at > 0.0) {
                0
            } else if at >= last as f32 {
                last
            } else {
                at as u32
            }
        };
        [step(from - spread), step(from + spread)]
    }

    /// The word to which the branches above `dir` lead.
    fn descend<const FUSED: bool>(&mut self, hull: &HullRecord, dir: Vector) -> u32 {
        let cell = cell::<FUSED>(dir);
        if hull.kind == kind::CUBE_MAP {
            let at = cube::uniform_cell(cell, hull.resolution);
            return u32::try_from(at).map_or(0, |at| self.slot(hull, at));
        }
        let mut word = self.slot(hull, cell.face);
        let mut path = descent::path(cell);
        for _ in 0..2 * cube::GRID_BITS {
            let Some(payload) = Slot::branch(word).filter(|_| self.fuel > 0) else { break };
            self.fuel -= 1;
            let (at, rest) = if hull.kind == kind::BINARY {
                descent::half(payload, path)
            } else if Branch::decode(payload).bits > 0 {
                descent::square(payload, path)
            } else {
                break;
            };
            // A checked pack leads to fewer than 2^32 words.
            (word, path) = (self.slot(hull, at as u32), rest);
        }
        word
    }

    /// Support point of hull `index` in direction `dir`, which is of about unit length.
    pub(super) fn support<const FUSED: bool>(&mut self, index: u32, dir: Vector) -> Found {
        let hull = &self.tables.hulls[index as usize];
        let mut search = SupportSearch {
            hull,
            dir,
            doubt: PLANE_DOUBT * l1(dir),
            found: Found { at: u32::MAX, is_certain: true, ..Found::default() },
            greatest: LOWEST,
            stack: [[0; 2]; STACK],
            height: 0,
        };
        let mut leaf = Leaf { first: 0, count: hull.block_count };
        if hull.kind != kind::SCAN {
            leaf = Leaf::NONE;
            search.push([self.descend::<FUSED>(hull, dir), 0]);
        }
        let mut last_word = u32::MAX;
        loop {
            self.scan::<FUSED>(&mut search, leaf);
            leaf = Leaf::NONE;
            if search.height == 0 {
                break;
            }
            if self.fuel == 0 {
                search.found.is_certain = false;
                break;
            }
            self.fuel -= 1;
            let word = self.pop(&mut search);
            if word == last_word {
                // What is below it is visited already, or on the stack.
                continue;
            }
            last_word = word;
            leaf = self.visit::<FUSED>(&mut search, word);
        }
        let mut found = search.found;
        if search.greatest > LOWEST {
            found.vertex = self.tables.blocks[found.at as usize + 24];
        }
        found
    }

    /// Step 3: the candidates of a leaf.
    fn scan<const FUSED: bool>(&mut self, search: &mut SupportSearch<'_>, leaf: Leaf) {
        let hull = search.hull;
        let Leaf { first, mut count } = leaf;
        if first >= hull.block_count || count > hull.block_count - first {
            search.found.is_certain = false;
            count = 0;
        }
        for block in 0..count {
            if self.fuel == 0 {
                search.found.is_certain = false;
                break;
            }
            self.fuel -= 1;
            let at = ((hull.block_start + first + block) * 32) as usize;
            for lane in 0..8 {
                let at = at + lane;
                let offset = self.offset(hull, at);
                let along = dot::<FUSED>(offset, search.dir);
                if along > search.greatest {
                    search.greatest = along;
                    search.found.offset = offset;
                    search.found.at = at as u32;
                }
            }
        }
    }

    /// Takes the next word from the stack.
    fn pop(&self, search: &mut SupportSearch<'_>) -> u32 {
        let [word, end] = search.stack[search.height - 1];
        if end == 0 {
            search.height -= 1;
            return word;
        }
        search.stack[search.height - 1][0] = word + 1;
        if word + 1 >= end {
            search.height -= 1;
        }
        self.slot(search.hull, word)
    }

    /// Step 2: returns the leaf to which a word leads, or puts words below it on the stack.
    fn visit<const FUSED: bool>(&self, search: &mut SupportSearch<'_>, word: u32) -> Leaf {
        let hull = search.hull;
        match Slot::decode(word) {
            Slot::Block(block) => return Leaf { first: block, count: hull.leaf_blocks },
            Slot::List(at) => {
                let leaf = Leaf { first: self.slot(hull, at), count: self.slot(hull, at + 1) };
                search.found.is_certain &= leaf.count > 0;
                return leaf;
            }
            // A branch below planes: not in a checked pack. Or no room for eight parts.
            Slot::Branch(_) => search.found.is_certain = false,
            _ if search.height + BUNDLE_PARTS > STACK => search.found.is_certain = false,
            Slot::Fan(at) => {
                let [from, to] = self.steps::<FUSED>(hull, at, search.dir);
                search.push([at + fan::HEAD_WORDS + from, at + fan::HEAD_WORDS + 1 + to]);
            }
            Slot::Plane(at) => {
                let sides = self.sides::<FUSED>(search, at, [1, 0]);
                for side in 0..2 {
                    if sides >> side & 1 != 0 {
                        search.push([self.slot(hull, at + PLANE_HEAD_WORDS + side), 0]);
                    }
                }
            }
            Slot::Bundle(at) => self.push_parts::<FUSED>(search, at),
        }
        Leaf::NONE
    }

    /// Puts the parts of a bundle in which the direction may be on the stack.
    fn push_parts<const FUSED: bool>(&self, search: &mut SupportSearch<'_>, at: u32) {
        let mut sides = 0;
        for plane in 0..BUNDLE_PLANES {
            sides |= self.sides::<FUSED>(search, at, [BUNDLE_PLANES, plane]) << (2 * plane);
        }
        let mut previous = u32::MAX;
        for part in 0..BUNDLE_PARTS as u32 {
            let (top, middle, low) = (part >> 2, part >> 1 & 1, part & 1);
            let possible =
                sides >> top & sides >> (2 + 2 * top + middle) & sides >> (6 + 4 * top + 2 * middle + low) & 1;
            let word = self.slot(search.hull, at + BUNDLE_HEAD_WORDS + part);
            if possible != 0 && word != previous {
                search.push([word, 0]);
                previous = word;
            }
        }
    }
}

/// State of a support query.
struct SupportSearch<'t> {
    hull: &'t HullRecord,
    dir: Vector,
    /// Half the width of the slab around a plane in which its side is uncertain.
    doubt: f32,
    found: Found,
    /// The greatest dot product.
    greatest: f32,
    /// A word, or the range of a fan's slots from the first number up to the second.
    stack: [[u32; 2]; STACK],
    /// Entries on the stack.
    height: usize,
}

impl SupportSearch<'_> {
    fn push(&mut self, entry: [u32; 2]) {
        self.stack[self.height] = entry;
        self.height += 1;
    }
}

/// Blocks of a leaf.
#[derive(Clone, Copy)]
struct Leaf {
    first: u32,
    count: u32,
}

impl Leaf {
    const NONE: Self = Self { first: 0, count: 0 };
}
