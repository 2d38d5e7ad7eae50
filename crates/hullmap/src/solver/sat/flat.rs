//! First pass of the separating axis test for shapes of few vertices, in f32: the support values at
//! all faces, and what two points leave possible along every arc of A.
//!
//! It proposes what [`scan`](super::scan) proposes, without its eliminations. At 8 vertices their
//! branches, which no processor predicts, take longer than computing all values.
//!
//! # Steps
//! 1. Heights of all vertices of the other shape over all faces, eight faces at a time, and their
//!    maxima.
//! 2. Along each arc of A: the value at which the support points of its two ends are equally far.
//!    This follows after f64 has found the support points at the lowest faces. F32 may confuse
//!    points that are nearly as far, and an arc with the same point at both ends has no minimum
//!    between them.

use super::first_pass::FirstPass;
use super::scan::{Arc, Lanes, Pair, lowest_first, threshold, value_between};
use crate::support::facet_table::{Edge, LANES, PointBlock};
use crate::support::lane_set::LaneSet;
use crate::support::simd::{Dispatch, Pass, Simd};

/// Number of slots for arcs that are left to f64, for each block of faces.
const ARCS_PER_BLOCK: usize = LANES;

/// The support values of a pair. `P` blocks of points, `N` blocks of faces.
#[derive(Debug)]
pub(super) struct Flat<const P: usize, const N: usize> {
    /// The vertices of B in the difference, and those of A in B's frame.
    pub(super) points: [[PointBlock; P]; 2],
    /// The support values at the faces of A and of B.
    values: [[Lanes; N]; 2],
    /// The vertex of B that is the support point at each face of A.
    vertices: [[u32; LANES]; N],
    heights: Heights<P, N>,
    /// Lowest value.
    pub(super) low: f32,
    /// Upper bound of the error of every value: a length.
    pub(super) error: f32,
    /// The arcs of A that may have the minimum between their ends.
    arcs: [[Arc; ARCS_PER_BLOCK]; N],
    arc_count: usize,
}

/// Heights of the vertices of B over the faces of A: by vertex, then by face.
type Heights<const P: usize, const N: usize> = [[[Lanes; N]; LANES]; P];

struct FlatPass<'s, 'p, 'v, const P: usize, const N: usize> {
    flat: &'s mut Flat<P, N>,
    pair: &'p Pair<'v>,
}

impl<const P: usize, const N: usize> Pass for FlatPass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, .. } = *self;
        let Flat { points, values, vertices, heights, low, error, .. } = &mut *self.flat;
        let views = [&pair.a, &pair.b];
        let placements = pair.placements();
        for own in 0..2 {
            let (view, other, (rows, center)) = (views[own], views[1 - own], &placements[own]);
            let Some(last) = other.points.last() else { return };
            for (block, to) in points[own].iter_mut().enumerate() {
                *to = simd.transform(other.points.get(block).unwrap_or(last), rows, *center);
            }
            let mut lowest = [f32::INFINITY; LANES];
            for (block, faces) in view.normals.iter().enumerate().take(N) {
                let (highest, support) = if own == 0 {
                    simd.highest(&points[0], faces, |point, row| heights[point / LANES % P][point % LANES][block] = row)
                } else {
                    simd.highest(&points[1], faces, |_, _| ())
                };
                values[own][block] = highest;
                if own == 0 {
                    vertices[block] = support;
                }
                for (lowest, value) in lowest.iter_mut().zip(highest) {
                    *lowest = if value < *lowest { value } else { *lowest };
                }
            }
            let least = |a: f32, b: f32| if b < a { b } else { a };
            let [a, b, c, d, e, f, g, h] = lowest;
            let lowest = least(least(least(a, e), least(b, f)), least(least(c, g), least(d, h)));
            *low = least(*low, lowest);
            if *low < -*error {
                // A face separates.
                return;
            }
        }
    }
}

/// Eight arcs from c to d, with the support points p at c and q at d.
#[derive(Clone, Copy)]
struct ArcBlock {
    p_at_c: Lanes,
    p_at_d: Lanes,
    q_at_c: Lanes,
    q_at_d: Lanes,
    /// Cosines of the angles between the ends.
    cosine: Lanes,
    /// One bit for each arc where p is not q.
    crossing: u32,
}

impl ArcBlock {
    const EMPTY: Self = {
        let zero = [0.0; LANES];
        Self { p_at_c: zero, p_at_d: zero, q_at_c: zero, q_at_d: zero, cosine: zero, crossing: 0 }
    };

    /// The value at the direction in which p and q are equally far.
    #[inline(always)]
    fn bounds(&self) -> Lanes {
        let Self { p_at_c, p_at_d, q_at_c, q_at_d, cosine, .. } = self;
        let mut bounds = [0.0; LANES];
        for (lane, bound) in bounds.iter_mut().enumerate() {
            let (p, q) = ([p_at_c[lane], p_at_d[lane]], [q_at_c[lane], q_at_d[lane]]);
            *bound = value_between(p, q, cosine[lane]);
        }
        bounds
    }
}

struct ArcPass<'s, 'v, const P: usize, const N: usize> {
    flat: &'s mut Flat<P, N>,
    edges: &'v [Edge],
    upper: f32,
}

impl<const P: usize, const N: usize> Pass for ArcPass<'_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Flat { vertices, heights, error, arcs, arc_count, .. } = &mut *self.flat;
        let threshold = threshold(self.upper, *error);
        let (vertices, heights) = (vertices.as_flattened(), heights.as_flattened());
        let arcs = arcs.as_flattened_mut();
        // First everything is read, one by one, then computed, eight arcs at a time.
        let mut blocks = [[ArcBlock::EMPTY; N]; 2];
        let blocks = blocks.as_flattened_mut();
        for (block, edges) in blocks.iter_mut().zip(self.edges.chunks(LANES)) {
            for (lane, edge) in edges.iter().enumerate() {
                let lane = lane % LANES;
                let [c, d] = edge.faces;
                let (c, d) = (usize::from(c) % (LANES * N), usize::from(d) % (LANES * N));
                let (p, q) = (vertices[c] as usize % (LANES * P), vertices[d] as usize % (LANES * P));
                let (over_p, over_q) = (heights[p].as_flattened(), heights[q].as_flattened());
                block.p_at_c[lane] = over_p[c];
                block.p_at_d[lane] = over_p[d];
                block.q_at_c[lane] = over_q[c];
                block.q_at_d[lane] = over_q[d];
                block.cosine[lane] = edge.cosine;
                block.crossing |= u32::from(p != q) << lane;
            }
        }
        let mut count = 0;
        for (block, edges) in blocks.iter().zip(self.edges.chunks(LANES)) {
            let bounds = block.bounds();
            // NaN is left.
            let mut left = simd.less(&bounds, threshold) & block.crossing;
            while left != 0 {
                let lane = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                let Edge { faces, vertex, .. } = edges[lane % edges.len()];
                arcs[count % (ARCS_PER_BLOCK * N)] = Arc { faces, vertex: vertex.into(), bound: bounds[lane] };
                count += 1;
            }
        }
        lowest_first(arcs.get_mut(..count).unwrap_or_default());
        *arc_count = count;
    }
}

impl<const P: usize, const N: usize> FirstPass<P, N> for Flat<P, N> {
    const TAKES_UPPER: bool = false;

    #[inline(always)]
    fn new(pair: &Pair<'_>) -> Self {
        Self {
            points: [[PointBlock::default(); P]; 2],
            values: [[[f32::INFINITY; LANES]; N]; 2],
            vertices: [[0; LANES]; N],
            heights: [[[[0.0; LANES]; N]; LANES]; P],
            low: f32::INFINITY,
            error: pair.error() as f32,
            arcs: [[Arc::default(); ARCS_PER_BLOCK]; N],
            arc_count: 0,
        }
    }

    #[inline(always)]
    fn run(&mut self, pair: &Pair<'_>, dispatch: Dispatch, _: f32, _: Option<[usize; 2]>) -> Option<()> {
        if pair.a.edges.is_empty() {
            return None;
        }
        dispatch.pass(&mut FlatPass { flat: self, pair });
        Some(())
    }

    #[inline(always)]
    fn find_arcs(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32) -> Option<()> {
        dispatch.pass(&mut ArcPass { flat: self, edges: pair.a.edges, upper });
        // If the slots are full, the first one may hold an arc that is not left.
        (self.arc_count < ARCS_PER_BLOCK * N).then_some(())
    }

    #[inline(always)]
    fn arcs(&self) -> &[Arc] {
        self.arcs.as_flattened().get(..self.arc_count).unwrap_or_default()
    }

    #[inline(always)]
    fn low(&self) -> f32 {
        self.low
    }

    #[inline(always)]
    fn error(&self) -> f32 {
        self.error
    }

    #[inline(always)]
    fn faces(&self, upper: f32) -> [LaneSet<N>; 2] {
        self.faces_at_most(threshold(upper, self.error).next_down())
    }

    #[inline(always)]
    fn faces_at_most(&self, most: f32) -> [LaneSet<N>; 2] {
        [below(&self.values[0], most), below(&self.values[1], most)]
    }

    #[inline(always)]
    fn vertex(&self, face: usize) -> usize {
        self.vertices[face / LANES % N][face % LANES] as usize
    }

    #[inline(always)]
    fn set_vertex(&mut self, face: usize, vertex: u32) {
        self.vertices[face / LANES % N][face % LANES] = vertex;
    }

    #[inline(always)]
    fn points(&self) -> [&[PointBlock; P]; 2] {
        self.points.each_ref()
    }
}

/// The lanes whose values are at most `most`, or NaN.
#[inline(always)]
fn below<const N: usize>(values: &[Lanes; N], most: f32) -> LaneSet<N> {
    let mut below = LaneSet::EMPTY;
    for (block, values) in values.iter().enumerate() {
        let mut lanes = 0;
        for (lane, value) in values.iter().enumerate() {
            let is_above = *value > most;
            lanes |= u32::from(!is_above) << lane;
        }
        below.add_block(block, lanes);
    }
    below
}

#[cfg(test)]
impl<const P: usize, const N: usize> Flat<P, N> {
    /// The support value at a face of A or of B, if the pass has computed it.
    pub(super) fn known(&self, own: usize, face: usize) -> Option<f32> {
        Some(self.values[own][face / LANES][face % LANES]).filter(|value| value.is_finite())
    }
}
