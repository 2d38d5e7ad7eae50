//! Scalar twin of the kernels in plain f32: GJK and EPA on the Minkowski difference, and the support
//! query.
//!
//! `kernels.wgsl` does the same, operation by operation and function by function, so that both
//! return the same bits on a device that rounds to nearest and does not fuse operations. Tests
//! compare them. `FUSED` makes the twin fuse every product with the sum that follows, as other
//! devices may; docs/intervals.md, section 13, bounds the errors of both.
//!
//! # Reference
//! Kenwright, section 3. E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for
//! computing the distance between complex objects in three-dimensional space", 1988.
//!
//! # Steps of a pair
//! 1. The balls around and inside the hulls decide, or not.
//! 2. A support call in the direction of the origin. Its plane is a lower bound of the distance.
//! 3. The point of the simplex closest to the origin is the next upper bound.
//! 4. A tetrahedron that holds the origin by more than the rounding error proves an overlap. If it
//!    holds it by less, the search continues across its closest face.
//!
//! 5. For a depth, EPA: the tetrahedron grows by the support point beyond its closest face. Its plane
//!    is an upper bound of the depth. A surface all of whose volumes with the origin are certainly
//!    positive gives a lower bound.
//! 6. If GJK finds no such tetrahedron, EPA starts from the support points along the axes.
//!
//! # Steps of a support query
//! 1. The direction's cell, and the branches above its leaf. A direction is placed up to rounding
//!    error, which the baker's margin covers.
//! 2. Planes and fans have no margin. Wherever f32 cannot distinguish their sides, both are
//!    visited, from a small stack.
//! 3. The candidate with the maximum dot product, of all leaves visited.

use crate::records::{AnswerRecord, HullRecord, Pair, PairRecord, Tables, code, kind};

/// Which question a pair is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Yes or no: stop at the first proof.
    Intersects,
    /// The distance, until the interval is within the tolerance.
    Distance,
    /// The penetration depth, until the interval is within the tolerance.
    Contact,
}

/// Support calls of a pair. About 10 are usual.
pub const MAX_STEPS: u32 = 64;

/// Nodes and blocks that a pair may read.
pub const MAX_READS: u32 = 1 << 17;

/// Entries of the stack of a support query.
const STACK: usize = 32;

/// Vertices of the polytope of EPA. A closed surface of them has 124 faces.
const MAX_VERTICES: usize = 64;
const MAX_FACES: usize = 124;

/// Edges of the horizon that a new vertex sees.
const MAX_EDGES: usize = 64;

/// Bits of a grid number, see `hullmap_format::cube`.
const GRID_BITS: u32 = 23;
const GRID_MASK: u32 = (1 << GRID_BITS) - 1;
const GRID_SCALE: f32 = 4194303.0;
const ROUND_BY: f32 = 12582912.0;

/// Twice the largest possible f32 would be infinite; every dot product is above this.
const LOWEST: f32 = -3.0e38;

/// 2⁻²³: bound on the relative error of one operation.
const EPSILON: f32 = f32::EPSILON;

/// Width of the slab around a plane in which its side is uncertain, relative to |d|₁.
const PLANE_DOUBT: f32 = 16.0 * EPSILON;

/// Error of a coordinate in the frame of a fan, relative to |d|₁.
const FAN_DOUBT: f32 = 8.0 * EPSILON;

/// Rounding error of an angle.
const ANGLE_DOUBT: f32 = 32.0 * EPSILON;

/// A volume above this many times the product of the lengths of two edges and a corner is positive.
const CERTAIN: f32 = 16.0 * EPSILON;

/// Squared length below which a normal has no direction.
const NO_NORMAL: f32 = 1e-30;

type Vector = [f32; 3];

fn mad<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { libm::fmaf(a, b, c) } else { a * b + c }
}

fn dot<const FUSED: bool>(a: Vector, b: Vector) -> f32 {
    mad::<FUSED>(a[2], b[2], mad::<FUSED>(a[1], b[1], a[0] * b[0]))
}

fn cross<const FUSED: bool>(a: Vector, b: Vector) -> Vector {
    [
        mad::<FUSED>(a[1], b[2], -(a[2] * b[1])),
        mad::<FUSED>(a[2], b[0], -(a[0] * b[2])),
        mad::<FUSED>(a[0], b[1], -(a[1] * b[0])),
    ]
}

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scaled(a: Vector, by: f32) -> Vector {
    [a[0] * by, a[1] * by, a[2] * by]
}

fn l1(a: Vector) -> f32 {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// The result of a support query.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Index of the vertex.
    pub vertex: u32,
    /// Its position relative to the hull's centre.
    pub offset: [f32; 3],
    /// Whether everything was read that can hold the support vertex.
    pub is_certain: bool,
}

/// One run of a kernel for one pair or one direction.
struct Run<'t> {
    tables: &'t Tables<'t>,
    /// Nodes and blocks that may still be read.
    fuel: u32,
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

impl Run<'_> {
    fn slot(&self, hull: &HullRecord, at: u32) -> u32 {
        // 0 is a branch, which no leaf, plane or fan leads to: then the query is not certain.
        if at < hull.slot_count { self.tables.slots[(hull.slot_start + at) as usize] } else { 0 }
    }

    /// An f64 in the slots, as f32.
    fn number(&self, hull: &HullRecord, at: u32) -> f32 {
        decode(self.slot(hull, at), self.slot(hull, at + 1))
    }

    /// Possible sides of a plane: 1 behind, 2 in front, 3 both.
    fn sides<const FUSED: bool>(&self, hull: &HullRecord, at: u32, stride: u32, dir: Vector, doubt: f32) -> u32 {
        let normal = [self.number(hull, at), self.number(hull, at + stride), self.number(hull, at + 2 * stride)];
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
        let last = (1 << (self.slot(hull, at + 16) & 31)) - 1;
        let axis = |from: u32| [self.number(hull, from), self.number(hull, from + 2), self.number(hull, from + 4)];
        let x = dot::<FUSED>(axis(at), dir);
        let y = dot::<FUSED>(axis(at + 6), dir);
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
        let rate = self.number(hull, at + 14);
        let from = (angle - self.number(hull, at + 12)) * rate;
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
        let (ax, ay, az) = (dir[0].abs(), dir[1].abs(), dir[2].abs());
        let mut axis = 0;
        let mut size = ax;
        if ay > size {
            axis = 1;
            size = ay;
        }
        if az > size {
            axis = 2;
            size = az;
        }
        let inverse = 1.0 / size;
        let grid = |c: f32| {
            let t = (c * inverse).clamp(-1.0, 1.0);
            mad::<FUSED>(t, GRID_SCALE, ROUND_BY).to_bits() & GRID_MASK
        };
        let mut u = grid(dir[(axis + 1) % 3]);
        let mut v = grid(dir[(axis + 2) % 3]);
        let face = 2 * axis as u32 + (dir[axis].to_bits() >> 31);
        if hull.kind == kind::CUBE_MAP {
            let r = hull.resolution;
            // ⌊u r / 2²³⌋ without 64 bits: r is below 2²⁰.
            let column = ((u >> 11) * r + (((u & 2047) * r) >> 11)) >> 12;
            let row = ((v >> 11) * r + (((v & 2047) * r) >> 11)) >> 12;
            return self.slot(hull, face.wrapping_mul(r).wrapping_add(row).wrapping_mul(r).wrapping_add(column));
        }
        let mut word = self.slot(hull, face);
        u <<= 32 - GRID_BITS;
        v <<= 32 - GRID_BITS;
        for _ in 0..2 * GRID_BITS {
            if word >> 30 != 0 || self.fuel == 0 {
                break;
            }
            self.fuel -= 1;
            if hull.kind == kind::BINARY {
                word = self.slot(hull, word + (u >> 31));
                let halved = u << 1;
                u = v;
                v = halved;
            } else {
                let bits = word & 15;
                if bits == 0 {
                    break;
                }
                word = self.slot(hull, (word >> 4) + (v >> (32 - bits) << bits | u >> (32 - bits)));
                u <<= bits;
                v <<= bits;
            }
        }
        word
    }

    /// Support point of hull `index` in direction `dir`, which is of about unit length.
    fn support<const FUSED: bool>(&mut self, index: u32, dir: Vector) -> Found {
        let hull = &self.tables.hulls[index as usize];
        let mut found = Found { is_certain: true, ..Found::default() };
        let mut greatest = LOWEST;
        let doubt = PLANE_DOUBT * l1(dir);
        // A word, or the range of a fan's slots from the first number up to the second.
        let mut stack = [[0_u32; 2]; STACK];
        let mut height = 0;
        let mut first = 0;
        let mut count = hull.block_count;
        let mut last_word = u32::MAX;
        if hull.kind != kind::SCAN {
            count = 0;
            stack[0] = [self.descend::<FUSED>(hull, dir), 0];
            height = 1;
        }
        loop {
            // The leaf, if there is one.
            if first >= hull.block_count || count > hull.block_count - first {
                found.is_certain = false;
                count = 0;
            }
            for block in 0..count {
                if self.fuel == 0 {
                    found.is_certain = false;
                    break;
                }
                self.fuel -= 1;
                let at = ((hull.block_start + first + block) * 32) as usize;
                for lane in 0..8 {
                    let at = at + lane;
                    let read = |at: usize| f32::from_bits(self.tables.blocks[at]);
                    let offset = sub([read(at), read(at + 8), read(at + 16)], hull.center);
                    let along = dot::<FUSED>(offset, dir);
                    if along > greatest {
                        greatest = along;
                        found.offset = offset;
                        found.vertex = self.tables.blocks[at + 24];
                    }
                }
            }
            count = 0;
            first = 0;
            if height == 0 {
                break;
            }
            if self.fuel == 0 {
                found.is_certain = false;
                break;
            }
            self.fuel -= 1;
            let [mut word, end] = stack[height - 1];
            if end == 0 {
                height -= 1;
            } else {
                let at = word;
                word = self.slot(hull, at);
                stack[height - 1][0] = at + 1;
                if at + 1 >= end {
                    height -= 1;
                }
            }
            if word == last_word {
                // What is below it is visited already, or on the stack.
                continue;
            }
            last_word = word;
            let payload = word & 0x3fff_ffff;
            let at = payload >> 2;
            match word >> 30 {
                1 => {
                    first = payload;
                    count = hull.leaf_blocks;
                }
                3 => {
                    first = self.slot(hull, payload);
                    count = self.slot(hull, payload + 1);
                    found.is_certain &= count > 0;
                }
                2 if height + 8 > STACK => found.is_certain = false,
                2 if payload & 2 != 0 => {
                    let [from, to] = self.steps::<FUSED>(hull, at, dir);
                    stack[height] = [at + 17 + from, at + 18 + to];
                    height += 1;
                }
                2 if payload & 1 == 0 => {
                    let sides = self.sides::<FUSED>(hull, at, 2, dir, doubt);
                    for side in 0..2 {
                        if sides >> side & 1 != 0 {
                            stack[height] = [self.slot(hull, at + 6 + side), 0];
                            height += 1;
                        }
                    }
                }
                2 => {
                    let mut sides = 0;
                    for plane in 0..7 {
                        sides |= self.sides::<FUSED>(hull, at + 2 * plane, 14, dir, doubt) << (2 * plane);
                    }
                    let mut previous = u32::MAX;
                    for part in 0..8 {
                        let (top, middle, low) = (part >> 2, part >> 1 & 1, part & 1);
                        let possible = sides >> top
                            & sides >> (2 + 2 * top + middle)
                            & sides >> (6 + 4 * top + 2 * middle + low)
                            & 1;
                        let word = self.slot(hull, at + 42 + part);
                        if possible != 0 && word != previous {
                            stack[height] = [word, 0];
                            height += 1;
                            previous = word;
                        }
                    }
                }
                // A branch below planes: not in a checked pack.
                _ => found.is_certain = false,
            }
        }
        found
    }
}

/// A corner of the simplex: a point of the Minkowski difference, and A's part of it.
#[derive(Clone, Copy, Default)]
struct Corner {
    w: Vector,
    offset: Vector,
}

/// The closest point of a segment or a triangle, as weights of the corners.
#[derive(Clone, Copy)]
struct Closest {
    weights: [f32; 4],
    y: Vector,
    square: f32,
}

/// Corners of the faces of a tetrahedron, in the same order as seen from outside.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

fn on_segment<const FUSED: bool>(simplex: &[Corner; 4], i: usize, j: usize) -> Closest {
    let (a, b) = (simplex[i].w, simplex[j].w);
    let edge = sub(b, a);
    let of_a = dot::<FUSED>(b, edge);
    let of_b = -dot::<FUSED>(a, edge);
    let mut weights = [0.0; 4];
    let mut y = a;
    // NaN takes the first branch.
    if !(of_b > 0.0) {
        weights[i] = 1.0;
    } else if !(of_a > 0.0) {
        weights[j] = 1.0;
        y = b;
    } else {
        let inverse = 1.0 / (of_a + of_b);
        let (r, s) = (of_a * inverse, of_b * inverse);
        weights[i] = r;
        weights[j] = s;
        y = [mad::<FUSED>(b[0], s, a[0] * r), mad::<FUSED>(b[1], s, a[1] * r), mad::<FUSED>(b[2], s, a[2] * r)];
    }
    Closest { weights, y, square: dot::<FUSED>(y, y) }
}

fn on_triangle<const FUSED: bool>(simplex: &[Corner; 4], i: usize, j: usize, k: usize) -> Closest {
    let (a, b, c) = (simplex[i].w, simplex[j].w, simplex[k].w);
    let (ab, ac, bc) = (sub(b, a), sub(c, a), sub(c, b));
    let normal = cross::<FUSED>(ab, ac);
    // Areas from differences of corners, so that those of slivers keep their digits.
    let of_a = dot::<FUSED>(cross::<FUSED>(b, bc), normal);
    let of_b = -dot::<FUSED>(cross::<FUSED>(c, ac), normal);
    let of_c = dot::<FUSED>(cross::<FUSED>(a, ab), normal);
    if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
        let inverse = 1.0 / (of_a + of_b + of_c);
        let (r, s, t) = (of_a * inverse, of_b * inverse, of_c * inverse);
        let y = [
            mad::<FUSED>(c[0], t, mad::<FUSED>(b[0], s, a[0] * r)),
            mad::<FUSED>(c[1], t, mad::<FUSED>(b[1], s, a[1] * r)),
            mad::<FUSED>(c[2], t, mad::<FUSED>(b[2], s, a[2] * r)),
        ];
        let mut weights = [0.0; 4];
        weights[i] = r;
        weights[j] = s;
        weights[k] = t;
        return Closest { weights, y, square: dot::<FUSED>(y, y) };
    }
    // NaN takes the failing branch.
    let mut best = Closest { weights: [0.0; 4], y: a, square: -LOWEST };
    best.weights[i] = 1.0;
    if !(of_a > 0.0) {
        best = nearer(best, on_segment::<FUSED>(simplex, j, k));
    }
    if !(of_b > 0.0) {
        best = nearer(best, on_segment::<FUSED>(simplex, i, k));
    }
    if !(of_c > 0.0) {
        best = nearer(best, on_segment::<FUSED>(simplex, i, j));
    }
    best
}

/// A face of the polytope of EPA.
#[derive(Clone, Copy, Default)]
struct Face {
    /// Outward normal of unit length, if the face is certain.
    normal: Vector,
    /// Height of its lowest corner along the normal; −1 if its volume with the origin may be
    /// negative.
    height: f32,
    corners: [usize; 3],
}

/// The polytope of EPA: a closed surface.
struct Polytope {
    corners: [Corner; MAX_VERTICES],
    corner_count: usize,
    faces: [Face; MAX_FACES],
    face_count: usize,
    /// The face with the lowest height.
    lowest: usize,
    height: f32,
}

impl Polytope {
    fn add_face<const FUSED: bool>(&mut self, i: usize, j: usize, k: usize) {
        let p = self.corners[i].w;
        let (e, f) = (sub(self.corners[j].w, p), sub(self.corners[k].w, p));
        let normal = cross::<FUSED>(e, f);
        let volume = dot::<FUSED>(normal, p);
        let long = dot::<FUSED>(e, e) + dot::<FUSED>(f, f);
        let mut face = Face { normal, height: -1.0, corners: [i, j, k] };
        if volume > CERTAIN * 0.5 * long * l1(p) {
            let inverse = 1.0 / dot::<FUSED>(normal, normal).sqrt();
            let mut least = volume;
            let at_j = dot::<FUSED>(normal, self.corners[j].w);
            let at_k = dot::<FUSED>(normal, self.corners[k].w);
            if at_j < least {
                least = at_j;
            }
            if at_k < least {
                least = at_k;
            }
            face.normal = scaled(normal, inverse);
            face.height = least * inverse;
        }
        self.faces[self.face_count] = face;
        self.face_count += 1;
    }

    fn find_lowest(&mut self) {
        self.lowest = 0;
        self.height = self.faces[0].height;
        for face in 1..self.face_count {
            if self.faces[face].height < self.height {
                self.lowest = face;
                self.height = self.faces[face].height;
            }
        }
    }

    /// Replaces the faces that see the last corner by the fan over their border. False if there is
    /// no room; the polytope is of no use then.
    fn insert<const FUSED: bool>(&mut self, error: f32) -> bool {
        let apex = self.corner_count - 1;
        let w = self.corners[apex].w;
        let mut edges = [[0; 2]; MAX_EDGES];
        let mut edge_count = 0;
        let mut face = 0;
        while face < self.face_count {
            let Face { normal, height, corners } = self.faces[face];
            if !(dot::<FUSED>(normal, w) > height + error) {
                face += 1;
                continue;
            }
            for side in 0..3 {
                let (from, to) = (corners[side], corners[(side + 1) % 3]);
                // An edge between two of these faces occurs twice, in opposite directions.
                let mut at = 0;
                while at < edge_count && !(edges[at][0] == to && edges[at][1] == from) {
                    at += 1;
                }
                if at < edge_count {
                    edge_count -= 1;
                    edges[at] = edges[edge_count];
                } else if edge_count == MAX_EDGES {
                    return false;
                } else {
                    edges[edge_count] = [from, to];
                    edge_count += 1;
                }
            }
            self.face_count -= 1;
            self.faces[face] = self.faces[self.face_count];
        }
        if self.face_count + edge_count > MAX_FACES {
            return false;
        }
        for at in 0..edge_count {
            self.add_face::<FUSED>(edges[at][0], edges[at][1], apex);
        }
        true
    }
}

fn nearer(a: Closest, b: Closest) -> Closest {
    if b.square < a.square { b } else { a }
}

/// What a pair does with the next support point.
#[derive(Clone, Copy, PartialEq)]
enum Phase {
    Gjk,
    Axes,
    Expand,
}

/// Plus and minus x, y and z.
fn axis_direction(index: usize) -> Vector {
    let mut dir = [0.0; 3];
    dir[index >> 1] = if index & 1 == 0 { 1.0 } else { -1.0 };
    dir
}

/// What the kernel reads about `pair`.
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{Pair, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let pair = Pair { a: 0, b: 0, b_in_a: Pose::from_translation(DVec3::X * 9.0).expect("finite") };
/// let record = twin::prepare(&Tables::of(&pack)?, &pair);
/// // The reach is about 11, and lengths are multiplied by a power of two that makes it about 1.
/// assert_eq!(record.scale, 1.0 / 16.0);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn prepare(tables: &Tables<'_>, pair: &Pair) -> PairRecord {
    PairRecord::of(pair, &tables.hulls)
}

/// Answer of the kernel for one pair.
///
/// `tolerance` is relative, of the width of the interval.
///
/// # Complexity
/// At most `max_steps` support calls, which read at most [`MAX_READS`] nodes and blocks.
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{MAX_STEPS, Pair, Query, Status, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let tables = Tables::of(&pack)?;
/// let pair = Pair { a: 0, b: 0, b_in_a: Pose::from_translation(DVec3::X * 9.0).expect("finite") };
/// let record = twin::prepare(&tables, &pair);
/// let answer = twin::solve::<false>(&tables, &record, Query::Intersects, 1e-5, MAX_STEPS);
/// assert_eq!(answer.status(), Status::Separated);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
#[expect(clippy::needless_range_loop, reason = "the loops are those of the kernel")]
pub fn solve<const FUSED: bool>(
    tables: &Tables<'_>,
    pair: &PairRecord,
    query: Query,
    tolerance: f32,
    max_steps: u32,
) -> AnswerRecord {
    let mut out = AnswerRecord { normal: [1.0, 0.0, 0.0], status: code::REJECTED, ..AnswerRecord::default() };
    out.upper = -LOWEST;
    if pair.a == PairRecord::REJECTED {
        return out;
    }
    let mut run = Run { tables, fuel: MAX_READS };
    let (a, b) = (&tables.hulls[pair.a as usize], &tables.hulls[pair.b as usize]);
    let r = pair.rows;
    let center = [r[0][3], r[1][3], r[2][3]];
    let error = pair.rounding;
    let far = dot::<FUSED>(center, center).sqrt();
    let mut upper = far;
    let mut lower = far - (a.outer + b.outer) * pair.scale;
    let mut dir = [1.0, 0.0, 0.0];
    if far > 0.0 {
        dir = scaled(center, -(1.0 / far));
    }
    out.normal = dir;
    out.between = center;
    out.status = code::BUDGET;
    let mut simplex = [Corner { w: center, offset: [0.0; 3] }, Corner::default(), Corner::default(), Corner::default()];
    let mut size = 1;
    let mut square = far * far;
    // Whether the tetrahedron holds the origin, and the direction is across its closest face.
    let mut outward = false;
    let deep = (a.inner + b.inner) * pair.scale - far;
    if query != Query::Contact && deep > error {
        out.status = code::OVERLAPPING;
    } else if query != Query::Distance && lower > error {
        out.status = code::SEPARATED;
    }
    let mut depth_upper = -lower;
    let mut depth_lower = 0.0;
    if deep > error {
        depth_lower = deep - error;
    }
    // The phase: GJK, then EPA from a tetrahedron; or GJK, the axes, then EPA from an octahedron.
    let mut phase = Phase::Gjk;
    let mut polytope = Polytope {
        corners: [Corner::default(); MAX_VERTICES],
        corner_count: 0,
        faces: [Face::default(); MAX_FACES],
        face_count: 0,
        lowest: 0,
        height: 0.0,
    };
    while out.status == code::BUDGET && out.steps < max_steps {
        out.steps += 1;
        let mut along_b = [0.0; 3];
        for axis in 0..3 {
            along_b[axis] = -mad::<FUSED>(r[2][axis], dir[2], mad::<FUSED>(r[1][axis], dir[1], r[0][axis] * dir[0]));
        }
        let on_a = run.support::<FUSED>(pair.a, dir);
        let on_b = run.support::<FUSED>(pair.b, along_b);
        if !(on_a.is_certain && on_b.is_certain) {
            break;
        }
        let offset = scaled(on_a.offset, pair.scale);
        let of_b = scaled(on_b.offset, pair.scale);
        let mut w = [0.0; 3];
        for axis in 0..3 {
            let turned = mad::<FUSED>(r[axis][2], of_b[2], mad::<FUSED>(r[axis][1], of_b[1], r[axis][0] * of_b[0]));
            w[axis] = center[axis] + (offset[axis] - turned);
        }
        // The plane at the support point. `dir` is of unit length within the error.
        let along = dot::<FUSED>(w, dir);
        if -along > lower {
            lower = -along;
            out.normal = dir;
        }
        if along < depth_upper {
            depth_upper = along;
            if query == Query::Contact {
                out.normal = dir;
            }
        }
        let apart = lower > error;
        if apart && (query != Query::Distance || upper - lower <= tolerance * upper + 2.0 * error) {
            out.status = code::SEPARATED;
            break;
        }
        if phase != Phase::Gjk {
            if phase == Phase::Expand {
                if depth_upper - polytope.height <= tolerance * depth_upper + 2.0 * error {
                    out.status = code::OVERLAPPING;
                    break;
                }
                if polytope.corner_count == MAX_VERTICES {
                    break;
                }
                let mut known = false;
                for corner in 0..polytope.corner_count {
                    if polytope.corners[corner].w == w {
                        known = true;
                    }
                }
                if known {
                    out.status = code::STALLED;
                    break;
                }
            }
            polytope.corners[polytope.corner_count] = Corner { w, offset };
            polytope.corner_count += 1;
            if phase == Phase::Axes {
                if polytope.corner_count < 6 {
                    dir = axis_direction(polytope.corner_count);
                    continue;
                }
                for face in 0..8 {
                    let (i, j, k) = (face & 1, 2 + (face >> 1 & 1), 4 + (face >> 2));
                    if (face ^ face >> 1 ^ face >> 2) & 1 == 0 {
                        polytope.add_face::<FUSED>(i, j, k);
                    } else {
                        polytope.add_face::<FUSED>(i, k, j);
                    }
                }
                phase = Phase::Expand;
            } else if !polytope.insert::<FUSED>(error) {
                polytope.face_count = 0;
                out.status = code::STALLED;
                break;
            }
            polytope.find_lowest();
            if !(polytope.height > 0.0) {
                out.status = code::STALLED;
                break;
            }
            if polytope.height - error > depth_lower {
                depth_lower = polytope.height - error;
            }
            dir = polytope.faces[polytope.lowest].normal;
            continue;
        }
        let mut stuck = outward && !(along > 2.0 * error);
        for corner in 0..size {
            if simplex[corner].w == w {
                stuck = true;
            }
        }
        if stuck {
            if query == Query::Contact {
                (phase, dir) = (Phase::Axes, axis_direction(0));
                continue;
            }
            out.status = if apart { code::STALLED } else { code::OPEN };
            break;
        }
        simplex[size] = Corner { w, offset };
        size += 1;

        // The point of the simplex closest to the origin.
        let mut closest = Closest { weights: [1.0, 0.0, 0.0, 0.0], y: center, square: -LOWEST };
        let mut inside = false;
        if size == 2 {
            closest = on_segment::<FUSED>(&simplex, 0, 1);
        } else if size == 3 {
            closest = on_triangle::<FUSED>(&simplex, 0, 1, 2);
        } else {
            inside = true;
            let mut certain = true;
            let mut least = -LOWEST;
            let mut through = 0;
            // The faces are oriented alike, outwards by this factor.
            let (e, f) = (sub(simplex[1].w, simplex[0].w), sub(simplex[2].w, simplex[0].w));
            let mut outwards = 1.0;
            if dot::<FUSED>(cross::<FUSED>(e, f), sub(simplex[3].w, simplex[0].w)) > 0.0 {
                outwards = -1.0;
            }
            for face in 0..4 {
                let [i, j, k] = FACES[face];
                let (p, e, f) = (simplex[i].w, sub(simplex[j].w, simplex[i].w), sub(simplex[k].w, simplex[i].w));
                let normal = scaled(cross::<FUSED>(e, f), outwards);
                let volume = dot::<FUSED>(normal, p);
                let long = dot::<FUSED>(e, e) + dot::<FUSED>(f, f);
                let length = dot::<FUSED>(normal, normal).sqrt();
                if volume > CERTAIN * 0.5 * long * l1(p) {
                    let mut height = volume;
                    let at_j = dot::<FUSED>(normal, simplex[j].w);
                    let at_k = dot::<FUSED>(normal, simplex[k].w);
                    if at_j < height {
                        height = at_j;
                    }
                    if at_k < height {
                        height = at_k;
                    }
                    if !(height > error * length) {
                        certain = false;
                    }
                    let clearance = volume * (1.0 / length);
                    if clearance < least {
                        least = clearance;
                        through = face;
                        dir = scaled(normal, 1.0 / length);
                    }
                } else {
                    inside = false;
                    closest = nearer(closest, on_triangle::<FUSED>(&simplex, i, j, k));
                }
            }
            if inside && query == Query::Contact {
                for face in 0..4 {
                    polytope.corners[face] = simplex[face];
                }
                polytope.corner_count = 4;
                for [i, j, k] in FACES {
                    if outwards > 0.0 {
                        polytope.add_face::<FUSED>(i, j, k);
                    } else {
                        polytope.add_face::<FUSED>(i, k, j);
                    }
                }
                phase = Phase::Expand;
                polytope.find_lowest();
                if !(polytope.height > 0.0) {
                    out.status = code::STALLED;
                    break;
                }
                if polytope.height - error > depth_lower {
                    depth_lower = polytope.height - error;
                }
                dir = polytope.faces[polytope.lowest].normal;
                continue;
            }
            if inside && certain {
                out.status = code::OVERLAPPING;
                break;
            }
            if inside {
                let [i, j, k] = FACES[through];
                simplex = [simplex[i], simplex[j], simplex[k], Corner::default()];
                size = 3;
            }
        }
        outward = inside;
        if inside {
            continue;
        }
        if !(closest.square < square) || (query == Query::Contact && !(closest.square > 0.0)) {
            if query == Query::Contact {
                (phase, dir) = (Phase::Axes, axis_direction(0));
                continue;
            }
            out.status = if apart { code::STALLED } else { code::OPEN };
            break;
        }
        square = closest.square;
        upper = square.sqrt();
        out.between = closest.y;
        out.offset = [0.0; 3];
        let mut kept = 0;
        for corner in 0..size {
            let weight = closest.weights[corner];
            if weight > 0.0 {
                let from = simplex[corner];
                for axis in 0..3 {
                    out.offset[axis] = mad::<FUSED>(from.offset[axis], weight, out.offset[axis]);
                }
                simplex[kept] = from;
                kept += 1;
            }
        }
        size = kept;
        if !(upper > 0.0) {
            out.status = code::OPEN;
            break;
        }
        dir = scaled(closest.y, -(1.0 / upper));
        if size == 3 {
            // Close to the origin, the normal of the triangle is more accurate than the point.
            let (e, f) = (sub(simplex[1].w, simplex[0].w), sub(simplex[2].w, simplex[0].w));
            let normal = cross::<FUSED>(e, f);
            let long = dot::<FUSED>(normal, normal);
            if long > dot::<FUSED>(e, e) * dot::<FUSED>(f, f) * square && long > NO_NORMAL {
                let mut by = 1.0 / long.sqrt();
                if dot::<FUSED>(normal, simplex[0].w) > 0.0 {
                    by = -by;
                }
                dir = scaled(normal, by);
            }
        }
    }
    out.lower = 0.0;
    if query == Query::Contact {
        if polytope.face_count > 0 && polytope.height > 0.0 {
            let [i, j, k] = polytope.faces[polytope.lowest].corners;
            simplex = [polytope.corners[i], polytope.corners[j], polytope.corners[k], Corner::default()];
            let closest = on_triangle::<FUSED>(&simplex, 0, 1, 2);
            out.between = closest.y;
            out.offset = [0.0; 3];
            for corner in 0..3 {
                for axis in 0..3 {
                    out.offset[axis] =
                        mad::<FUSED>(simplex[corner].offset[axis], closest.weights[corner], out.offset[axis]);
                }
            }
        }
        out.lower = depth_lower;
        out.upper = 0.0;
        if depth_upper + error > 0.0 {
            out.upper = depth_upper + error;
        }
        if out.status == code::SEPARATED {
            out.lower = 0.0;
            out.upper = 0.0;
        } else if !(depth_lower > 0.0) && (out.status == code::OVERLAPPING || out.status == code::STALLED) {
            out.status = code::OPEN;
        }
    } else {
        if lower > error {
            out.lower = lower - error;
        }
        out.upper = upper + error;
        if out.status == code::OVERLAPPING {
            out.lower = 0.0;
            out.upper = 0.0;
        }
    }
    out.reads = MAX_READS - run.fuel;
    out
}

/// Answer of the support kernel: the support vertex of hull `hull` in direction `dir`.
///
/// `dir` is in the hull's frame and of about unit length.
///
/// # Complexity
/// At most [`MAX_READS`] nodes and blocks.
///
/// # Examples
/// ```
/// use hullmap_wgpu::{Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(200, 1));
/// let found = twin::support::<false>(&Tables::of(&pack)?, 0, [0.0, 0.0, 1.0]);
/// let hull = pack.hull(0).expect("the pack has a hull");
/// assert_eq!(found.vertex, hull.support(hullmap::glam::Vec3::Z).index);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn support<const FUSED: bool>(tables: &Tables<'_>, hull: u32, dir: [f32; 3]) -> Found {
    let Some(record) = tables.hulls.get(hull as usize) else { return Found::default() };
    if record.block_count == 0 {
        return Found::default();
    }
    Run { tables, fuel: MAX_READS }.support::<FUSED>(hull, dir)
}
