//! First pass of the separating axis test, in f32: support values of the Minkowski difference at
//! all face normals, and lower bounds over all arcs.
//!
//! It only proposes. Every value is that of a point of the difference, to within [`Scan::error`],
//! so what it rules out is ruled out for certain. All that may be the minimum goes to f64.

use glam::{DMat3, DVec3};

use crate::support::facets::{Arc, LANES, MAX_FACES, MAX_VERTICES, NORMAL_BLOCKS, POINT_BLOCKS, PointBlock, View};
use crate::support::simd::Dispatch;

/// Bound of the error of a value of the scan, in units of 2⁻²⁴ times the reach: see
/// docs/intervals.md, section 12, which derives 20.
const ERROR_UNITS: f64 = 32.0;

/// Half a unit in the last place of 1 in f32.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Maximum number of items of a kind that are left to f64.
pub(super) const MAX_LEFT: usize = 32;

/// Values of eight directions per block.
pub(super) type Lanes = [f32; LANES];

/// A list of few indices.
#[derive(Clone, Copy, Debug)]
pub(super) struct List {
    items: [u8; MAX_LEFT],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { items: [0; MAX_LEFT], count: 0 };

    /// False if the list is full.
    #[inline(always)]
    fn push(&mut self, item: usize) -> bool {
        let free = self.count < MAX_LEFT;
        if free {
            self.items[self.count] = item as u8;
            self.count += 1;
        }
        free
    }

    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        self.items.iter().take(self.count).map(|item| usize::from(*item))
    }
}

/// The faces whose values may be the minimum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Faces {
    pub(super) of_a: List,
    pub(super) of_b: List,
}

/// Number of directions that the arrays have room for.
const DIRECTIONS: usize = NORMAL_BLOCKS * LANES;

/// The scan of one pair.
#[derive(Debug)]
pub(super) struct Scan {
    at_a: [Lanes; NORMAL_BLOCKS],
    at_b: [Lanes; NORMAL_BLOCKS],
    /// The vertex of B behind each value at a normal of A.
    vertices: [[u32; LANES]; NORMAL_BLOCKS],
    /// B's vertices in the difference: the centre minus their offset from B's interior point.
    points: [PointBlock; POINT_BLOCKS],
    /// Upper bound of the error of every value: a length.
    pub(super) error: f32,
}

/// Shape A, shape B, and where they are.
pub(super) struct Pair<'v> {
    pub(super) a: View<'v>,
    pub(super) b: View<'v>,
    /// Number of faces of A and of B.
    pub(super) faces: [usize; 2],
    /// Number of vertices of A and of B.
    pub(super) vertices: [usize; 2],
    /// Rotates from B's frame to A's.
    pub(super) rotation: DMat3,
    /// The centre v0.
    pub(super) center: DVec3,
    /// Upper bound of the length of any point of the difference.
    pub(super) reach: f64,
    /// Outer radius of B.
    pub(super) radius_b: f64,
}

impl Pair<'_> {
    /// Upper bound of the error of a value in f32: a length.
    pub(super) fn error(&self) -> f64 {
        ERROR_UNITS * UNIT * self.reach
    }
}

/// Rounded to f32, by rows.
fn rows(m: DMat3) -> [[f32; 3]; 3] {
    let m = m.transpose();
    [m.x_axis, m.y_axis, m.z_axis].map(|row| row.as_vec3().to_array())
}

/// c + M p for eight points.
#[inline(always)]
fn transform(block: &PointBlock, m: &[[f32; 3]; 3], c: [f32; 3]) -> PointBlock {
    let mut out = PointBlock::default();
    let [x, y, z] = &block.0;
    for ((out, row), c) in out.0.iter_mut().zip(m).zip(c) {
        for lane in 0..LANES {
            out[lane] = row[0] * x[lane] + row[1] * y[lane] + row[2] * z[lane] + c;
        }
    }
    out
}

impl Scan {
    /// Support values at all face normals of A and of B.
    #[inline(always)]
    pub(super) fn new(pair: &Pair<'_>, dispatch: Dispatch) -> Self {
        let mut scan = Self {
            at_a: [[0.0; LANES]; NORMAL_BLOCKS],
            at_b: [[0.0; LANES]; NORMAL_BLOCKS],
            vertices: [[0; LANES]; NORMAL_BLOCKS],
            points: [PointBlock::default(); POINT_BLOCKS],
            error: pair.error() as f32,
        };
        let turn = rows(pair.rotation * -1.0);
        let center = pair.center.as_vec3().to_array();
        for (to, from) in scan.points.iter_mut().zip(pair.b.points) {
            *to = transform(from, &turn, center);
        }
        // A's vertices, mirrored through the origin, in B's frame: −Rᵀ ((a − c_A) + v0).
        let mut mirrored = [PointBlock::default(); POINT_BLOCKS];
        let unturn = rows(pair.rotation.transpose() * -1.0);
        let center = (pair.rotation.transpose() * -pair.center).as_vec3().to_array();
        for (to, from) in mirrored.iter_mut().zip(pair.a.points) {
            *to = transform(from, &unturn, center);
        }
        let index = Some(&mut scan.vertices[..]);
        dispatch.farthest(pair.a.normals, &scan.points, pair.vertices[1], &mut scan.at_a, index);
        dispatch.farthest(pair.b.normals, &mirrored, pair.vertices[0], &mut scan.at_b, None);
        scan
    }

    /// The minimum over all faces of A and B.
    #[inline(always)]
    pub(super) fn minimum(&self, pair: &Pair<'_>) -> f32 {
        let mut low = [f32::INFINITY; LANES];
        // Unused lanes repeat the last face.
        let blocks = |faces: usize| faces.div_ceil(LANES);
        let all = self.at_a.iter().take(blocks(pair.faces[0]));
        for block in all.chain(self.at_b.iter().take(blocks(pair.faces[1]))) {
            for (low, value) in low.iter_mut().zip(block) {
                *low = if *value < *low { *value } else { *low };
            }
        }
        low.into_iter().fold(f32::INFINITY, |min, value| if value < min { value } else { min })
    }

    /// The face with the value `low`, and whether it is one of B.
    pub(super) fn lowest_face(&self, pair: &Pair<'_>, low: f32) -> Option<(usize, bool)> {
        let face = |values: &[Lanes], faces: usize| values.as_flattened().iter().take(faces).position(|v| *v == low);
        face(&self.at_a, pair.faces[0])
            .map(|face| (face, false))
            .or_else(|| face(&self.at_b, pair.faces[1]).map(|face| (face, true)))
    }

    #[inline(always)]
    fn value(&self, face: u8) -> f32 {
        self.at_a.as_flattened()[usize::from(face) % DIRECTIONS]
    }

    /// The vertex of B that is the support point at a face normal of A, or nearly so.
    #[inline(always)]
    pub(super) fn vertex(&self, face: u8) -> u32 {
        self.vertices.as_flattened()[usize::from(face) % DIRECTIONS]
    }

    /// Stores the support vertex of B at a face normal of A, known from f64.
    #[inline(always)]
    pub(super) fn set_vertex(&mut self, face: usize, vertex: u32) {
        self.vertices.as_flattened_mut()[face % DIRECTIONS] = vertex;
    }

    /// All faces whose value may be at most `upper`, an upper bound of the depth. `None` if they
    /// are too many.
    #[inline(always)]
    pub(super) fn faces(&self, pair: &Pair<'_>, upper: f32) -> Option<Faces> {
        let threshold = self.threshold(upper);
        let list = |values: &[Lanes; NORMAL_BLOCKS], faces: usize| {
            let mut list = List::EMPTY;
            for (b, block) in values.iter().take(faces.div_ceil(LANES)).enumerate() {
                let mut below = 0_u32;
                for (lane, value) in block.iter().enumerate() {
                    // NaN is kept.
                    below |= u32::from(!(*value >= threshold)) << lane;
                }
                while below != 0 {
                    let face = LANES * b + below.trailing_zeros() as usize;
                    below &= below - 1;
                    if face < faces && !list.push(face) {
                        return None;
                    }
                }
            }
            Some(list)
        };
        Some(Faces { of_a: list(&self.at_a, pair.faces[0])?, of_b: list(&self.at_b, pair.faces[1])? })
    }

    /// All arcs of A that may have a value of at most `upper` at a direction that is not an end.
    /// `None` if they are too many.
    ///
    /// `upper` is an upper bound of the depth, at most that for [`faces`](Self::faces). The
    /// vertices of all faces found there are known from f64 ([`set_vertex`](Self::set_vertex)).
    #[inline(always)]
    pub(super) fn arcs(&self, pair: &Pair<'_>, upper: f32) -> Option<List> {
        let threshold = self.threshold(upper);
        let span = (0.5 * pair.radius_b) as f32 * (1.0 + 1e-6);
        let mut near = [0_u8; 4 * MAX_VERTICES];
        let mut count = 0;
        for (index, arc) in pair.a.arcs.iter().enumerate() {
            let [v, w] = arc.faces.map(|face| self.value(face));
            let low = if v < w { v } else { w };
            let differ = self.vertex(arc.faces[0]) != self.vertex(arc.faces[1]);
            near[count % (4 * MAX_VERTICES)] = index as u8;
            // Between two normals, the value dips by at most a quarter of B's diameter times their
            // distance. NaN is kept.
            count += usize::from(differ & !(low - span * arc.chord >= threshold));
        }
        let mut left = List::EMPTY;
        for index in near.iter().take(count) {
            let Some(arc) = pair.a.arcs.get(usize::from(*index)) else { continue };
            if self.may_dip(pair, arc, threshold) && !left.push(usize::from(*index)) {
                return None;
            }
        }
        Some(left)
    }

    /// What a value has to reach so that it certainly exceeds `upper`, and 0. A value along an arc
    /// has up to four times the error.
    #[inline(always)]
    fn threshold(&self, upper: f32) -> f32 {
        upper.max(0.0) + 6.0 * self.error
    }

    /// Whether the values between the ends of an arc may be below `threshold`, by the support
    /// points at both ends.
    #[inline(always)]
    fn may_dip(&self, pair: &Pair<'_>, arc: &Arc, threshold: f32) -> bool {
        let [v, w] = arc.faces.map(|face| self.value(face));
        let [p, q] = arc.faces.map(|face| self.vertex(face) as usize % MAX_VERTICES).map(|i| {
            let PointBlock([x, y, z]) = &self.points[i / LANES];
            [x[i % LANES], y[i % LANES], z[i % LANES]]
        });
        let normal = |face: u8| {
            let block = pair.a.normals.get(usize::from(face) / LANES);
            block.map_or([0.0; 3], |block| block.normal.each_ref().map(|c| c[usize::from(face) % LANES]))
        };
        let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let step = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        // By how much the other end's point is lower at each end.
        let (drop_v, drop_w) = (dot(step, normal(arc.faces[0])), -dot(step, normal(arc.faces[1])));
        let (drop_v, drop_w) = (drop_v.max(0.0), drop_w.max(0.0));
        let t = drop_v / (drop_v + drop_w).max(f32::MIN_POSITIVE);
        let first = (1.0 - t) * v + t * (w - drop_w);
        let second = (1.0 - t) * (v - drop_v) + t * w;
        // NaN counts as a dip.
        !(first >= threshold && second >= threshold)
    }
}

/// Faces and edges fit into a byte.
const _: () = assert!(MAX_FACES < 3 * MAX_VERTICES && 3 * MAX_VERTICES <= u8::MAX as usize);
