//! First pass of the separating axis test (SAT), in f32: the support values of the Minkowski
//! difference at all face normals, and a lower bound along every arc of A.
//!
//! Every value is the height of a point of the difference, to within [`FirstPass::error`], so what
//! this pass rules out is ruled out for certain. Everything that may be the minimum goes on to f64.
//!
//! # Steps
//! 1. Heights of all vertices of the other shape over all faces, eight faces at a time, and their
//!    maxima. Ruling out faces first takes as long.
//! 2. Along each arc of A: the value at which the support points of its two ends are equally far.
//!    This follows after f64 has found the support points at the lowest faces. F32 may confuse
//!    points that are nearly as far, and an arc with the same point at both ends has no minimum
//!    between them.

use glam::{DMat3, DVec3};

use crate::facets::lane_set::LaneSet;
use crate::facets::table::{Edge, LANES, PointBlock};
use crate::facets::view::{Buffer, Facets, View};
use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;
use crate::support::simd::{Dispatch, Pass, Simd};

/// Bound of the error of a value of the pass, in units of 2⁻²⁴ times the reach: see
/// docs/contributors/intervals.md, section 12, which derives 20.
const ERROR_UNITS: f64 = 32.0;

/// Half a unit in the last place of 1 in f32.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Values of eight faces per block.
type Lanes = [f32; LANES];

pub(super) struct FacetPair<'v> {
    a: View<'v>,
    b: View<'v>,
    rotation: DMat3,
    center: DVec3,
    /// Upper bound of the length of any point of the difference.
    reach: f64,
}

impl<'v> FacetPair<'v> {
    #[inline(always)]
    pub(super) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        [a, b]: &[Facets<'v>; 2],
        [buffer_a, buffer_b]: &'v mut [Buffer; 2],
        reach: f64,
    ) -> Self {
        Self { a: a.view(buffer_a), b: b.view(buffer_b), rotation: m.rotation(), center: m.center_point().w, reach }
    }

    /// The matrix, by rows, and the centre that place B's vertices in the difference, and A's
    /// vertices in B's frame, where they are mirrored through the origin: −Rᵀ ((a − c_A) + v0).
    #[inline(always)]
    fn placements(&self) -> [([[f32; 3]; 3], [f32; 3]); 2] {
        let back = self.rotation.transpose();
        let turns = [rows(self.rotation * -1.0), rows(back * -1.0)];
        let centers = [self.center.as_vec3(), (back * -self.center).as_vec3()];
        [(turns[0], centers[0].to_array()), (turns[1], centers[1].to_array())]
    }

    /// Upper bound of the error of a value in f32: a length.
    pub(super) fn error(&self) -> f64 {
        ERROR_UNITS * UNIT * self.reach
    }
}

#[inline(always)]
fn rows(m: DMat3) -> [[f32; 3]; 3] {
    let m = m.transpose();
    [m.x_axis.as_vec3().to_array(), m.y_axis.as_vec3().to_array(), m.z_axis.as_vec3().to_array()]
}

/// An arc of A that may have the minimum between its ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arc {
    pub(super) faces: [u8; 2],
    /// A vertex of its edge. Not a byte, which would leave one byte of padding: arrays without
    /// padding are zeroed in place.
    pub(super) vertex: u16,
    /// Lower bound of the values between the ends, or the value of an end is lower.
    pub(super) bound: f32,
}

/// The support values of a pair. `P` blocks of points, `N` blocks of faces.
#[derive(Debug)]
pub(super) struct FirstPass<const P: usize, const N: usize> {
    /// The vertices of B in the difference, in A's frame, and the vertices of A, in B's frame.
    pub(super) points: [[PointBlock; P]; 2],
    /// The support values at the faces of A and of B.
    values: [[Lanes; N]; 2],
    vertices: [[u32; LANES]; N],
    heights: Heights<P, N>,
    pub(super) low: f32,
    /// Upper bound of the error of every value: a length.
    pub(super) error: f32,
    arcs: [[Arc; LANES]; N],
    arc_count: usize,
}

/// Heights of the vertices of B over the faces of A: by vertex, then by face.
type Heights<const P: usize, const N: usize> = [[[Lanes; N]; LANES]; P];

impl<const P: usize, const N: usize> FirstPass<P, N> {
    #[inline(always)]
    pub(super) fn new(pair: &FacetPair<'_>) -> Self {
        Self {
            points: [[PointBlock::default(); P]; 2],
            values: [[[f32::INFINITY; LANES]; N]; 2],
            vertices: [[0; LANES]; N],
            heights: [[[[0.0; LANES]; N]; LANES]; P],
            low: f32::INFINITY,
            error: pair.error() as f32,
            arcs: [[Arc::default(); LANES]; N],
            arc_count: 0,
        }
    }

    /// Step 1: the support values at the faces of A and of B. If a face of A separates, it stops
    /// there: [`low`](Self::low) is below −`error` then.
    #[inline(always)]
    pub(super) fn find_faces(&mut self, pair: &FacetPair<'_>, dispatch: Dispatch) {
        dispatch.pass(&mut FacePass { first: self, pair });
    }

    /// Step 2: all [`arcs`](Self::arcs) of A that may have a value of at most `upper` between their
    /// ends. `None` if they are too many.
    ///
    /// `upper` is an upper bound of the depth, at most that for [`faces`](Self::faces), whose
    /// vertices are known from f64 ([`set_vertex`](Self::set_vertex)).
    #[inline(always)]
    pub(super) fn find_arcs(&mut self, pair: &FacetPair<'_>, dispatch: Dispatch, upper: f32) -> Option<()> {
        dispatch.pass(&mut ArcPass { first: self, edges: pair.a.edges, upper });
        // If all places are full, the first one may hold an arc that is not left.
        (self.arc_count < LANES * N).then_some(())
    }

    /// The arcs of A that were found, that with the lowest bound first.
    #[inline(always)]
    pub(super) fn arcs(&self) -> &[Arc] {
        self.arcs.as_flattened().get(..self.arc_count).unwrap_or_default()
    }

    /// The faces of A and of B whose values may be at most `upper`, an upper bound of the depth.
    #[inline(always)]
    pub(super) fn faces(&self, upper: f32) -> [LaneSet; 2] {
        self.faces_at_most(threshold(upper, self.error).next_down())
    }

    /// The faces of A and of B whose values are at most `value`, or NaN.
    #[inline(always)]
    pub(super) fn faces_at_most(&self, value: f32) -> [LaneSet; 2] {
        let mut found = [LaneSet::EMPTY; 2];
        for (found, values) in found.iter_mut().zip(&self.values) {
            for (block, values) in values.iter().enumerate() {
                let mut lanes = 0;
                for (lane, own) in values.iter().enumerate() {
                    let is_above = *own > value;
                    lanes |= u32::from(!is_above) << lane;
                }
                found.add_block(block, lanes);
            }
        }
        found
    }

    /// The vertex of B that is the support point at a face of A, or nearly so.
    #[inline(always)]
    pub(super) fn vertex(&self, face: usize) -> usize {
        self.vertices[face / LANES % N][face % LANES] as usize
    }

    #[inline(always)]
    pub(super) fn set_vertex(&mut self, face: usize, vertex: u32) {
        self.vertices[face / LANES % N][face % LANES] = vertex;
    }
}

struct FacePass<'s, 'p, 'v, const P: usize, const N: usize> {
    first: &'s mut FirstPass<P, N>,
    pair: &'p FacetPair<'v>,
}

impl<const P: usize, const N: usize> Pass for FacePass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, .. } = *self;
        let FirstPass { points, values, vertices, heights, low, error, .. } = &mut *self.first;
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
    cosine: Lanes,
    crossing: u32,
}

impl ArcBlock {
    const EMPTY: Self = {
        let zero = [0.0; LANES];
        Self { p_at_c: zero, p_at_d: zero, q_at_c: zero, q_at_d: zero, cosine: zero, crossing: 0 }
    };
}

struct ArcPass<'s, 'v, const P: usize, const N: usize> {
    first: &'s mut FirstPass<P, N>,
    edges: &'v [Edge],
    upper: f32,
}

impl<const P: usize, const N: usize> Pass for ArcPass<'_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let FirstPass { vertices, heights, error, arcs, arc_count, .. } = &mut *self.first;
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
            let ArcBlock { p_at_c, p_at_d, q_at_c, q_at_d, cosine, .. } = block;
            let mut bounds = [0.0; LANES];
            for (lane, bound) in bounds.iter_mut().enumerate() {
                let (p, q) = ([p_at_c[lane], p_at_d[lane]], [q_at_c[lane], q_at_d[lane]]);
                *bound = value_between(p, q, cosine[lane]);
            }
            // NaN is left.
            let mut left = simd.less(&bounds, threshold) & block.crossing;
            while left != 0 {
                let lane = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                let Edge { faces, vertex, .. } = edges[lane % edges.len()];
                arcs[count % (LANES * N)] = Arc { faces, vertex: vertex.into(), bound: bounds[lane] };
                count += 1;
            }
        }
        lowest_first(arcs.get_mut(..count).unwrap_or_default());
        *arc_count = count;
    }
}

#[inline(always)]
fn lower(first: f32, second: f32) -> f32 {
    if first < second {
        first
    } else if second <= first {
        second
    } else {
        f32::NAN
    }
}

/// The lower of the values of two points p and q at the unit direction between c and d where they
/// are equal, or nearly so. Where it is not exact, it is a lower bound, or not positive: for
/// directions more than 90° apart, and for negative values. NaN if a value is.
///
/// `p` and `q` are the values at c and at d, where p is higher at c, and q at d; `cosine` is c · d.
#[inline(always)]
fn value_between(p: [f32; 2], q: [f32; 2], cosine: f32) -> f32 {
    let (drop_c, drop_d) = ((p[0] - q[0]).max(0.0), (q[1] - p[1]).max(0.0));
    let t = drop_c / (drop_c + drop_d).max(f32::MIN_POSITIVE);
    let on_chord = lower((1.0 - t) * p[0] + t * p[1], (1.0 - t) * q[0] + t * q[1]);
    // The direction is a point of the chord over its length. A short one would magnify errors.
    let square = 1.0 - 2.0 * (t - t * t) * (1.0 - cosine);
    let length = if square > 0.5 { square } else { 0.5 }.sqrt();
    if on_chord > 0.0 { on_chord / length } else { on_chord }
}

/// Moves the arc with the lowest bound to the front.
#[inline(always)]
fn lowest_first(arcs: &mut [Arc]) {
    let mut lowest = 0;
    for (index, arc) in arcs.iter().enumerate() {
        lowest = if arc.bound < arcs[lowest].bound { index } else { lowest };
    }
    if lowest > 0 {
        arcs.swap(0, lowest);
    }
}

/// A value that is at least this certainly exceeds `upper`, and 0. A value along an arc has up to
/// four times the error.
#[inline(always)]
pub(super) fn threshold(upper: f32, error: f32) -> f32 {
    upper.max(0.0) + 6.0 * error
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use hullmap_testkit::packs;
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::hull::Hull;
    use crate::pack::Pack;
    use crate::pose::Pose;
    use crate::support::simd::dispatches;
    use crate::vector::unit;

    /// Faces and arcs that were ruled out, and the others.
    #[derive(Debug, Default)]
    struct Seen {
        faces: [u32; 2],
        arcs: [u32; 2],
        apart: u32,
    }

    /// Compares what the pass rules out with support values in f64, at all faces and along all
    /// arcs.
    fn check<const P: usize, const N: usize>([a, b]: [&Hull<'_>; 2], pose: Pose, dispatch: Dispatch, seen: &mut Seen) {
        let mut m = Minkowski::new(a, b, pose);
        let facets = [a.facets().unwrap(), b.facets().unwrap()];
        let mut buffers = [Buffer::default(), Buffer::default()];
        let reach = m.outer_radius() + m.center_point().w.abs().element_sum();
        let pair = FacetPair::new(&m, &facets, &mut buffers, reach);
        let mut first = FirstPass::<P, N>::new(&pair);
        first.find_faces(&pair, dispatch);
        let (low, error) = (f64::from(first.low), f64::from(first.error));
        let mut lowest = f64::INFINITY;
        for (own, facets) in facets.iter().enumerate() {
            for face in 0..facets.face_count() {
                let normal = facets.normal(face).unwrap();
                let dir = if own == 0 { normal } else { pair.rotation * -normal };
                let exact = m.point(dir).w.dot(dir);
                lowest = lowest.min(exact);
                let value = first.values[own][face / LANES][face % LANES];
                if value.is_finite() {
                    seen.faces[1] += 1;
                    assert!((f64::from(value) - exact).abs() <= error);
                } else if low >= -error {
                    seen.faces[0] += 1;
                    assert!(exact > low, "{exact} {low}");
                }
            }
        }
        if low < -error {
            seen.apart += 1;
            assert!(lowest < 0.0);
            return;
        }
        assert!((lowest - low).abs() <= error);
        for face in first.faces(first.low)[0].iter() {
            let on_b = m.point(facets[0].normal(face).unwrap()).features[1];
            first.set_vertex(face, on_b);
        }
        first.find_arcs(&pair, dispatch, first.low).unwrap();
        let arcs = first.arcs();
        for edge in pair.a.edges {
            let ends = edge.faces.map(usize::from);
            if arcs.iter().any(|arc| arc.faces == edge.faces) {
                seen.arcs[1] += 1;
                continue;
            }
            seen.arcs[0] += 1;
            let [from, to] = ends.map(|face| facets[0].normal(face).unwrap());
            for step in 1..8 {
                let t = f64::from(step) / 8.0;
                let dir = unit(from * (1.0 - t) + to * t).unwrap();
                let exact = m.point(dir).w.dot(dir);
                assert!(exact >= low - 2.0 * error, "{exact} {low}");
            }
        }
    }

    #[test]
    fn values_between_are_those_at_unit_directions() {
        let mut rng = SplitMix64::new(20_261_124);
        let (mut equal, mut low) = (0, 0);
        for _ in 0..20_000 {
            let [c, d] = [(); 2].map(|()| DVec3::from_array(rng.direction()));
            let [p, q] = [(); 2].map(|()| DVec3::from_array(rng.direction()) * rng.between(0.0, 2.0) + (c + d) * 0.7);
            let (p, q) = if p.dot(c) >= q.dot(c) { (p, q) } else { (q, p) };
            if p.dot(d) >= q.dot(d) {
                continue;
            }
            let value = f64::from(value_between(
                [p.dot(c), p.dot(d)].map(|v| v as f32),
                [q.dot(c), q.dot(d)].map(|v| v as f32),
                c.dot(d) as f32,
            ));
            // The direction in which they are equal, in f64.
            let (drop_c, drop_d) = ((p - q).dot(c), (q - p).dot(d));
            let chord = c * drop_d + d * drop_c;
            let exact = p.dot(unit(chord).unwrap());
            assert!(value <= exact.max(0.0) + 2e-6, "{value} {exact}");
            // Long chords give the value itself.
            let is_long = chord.length() > 0.708 * (drop_c + drop_d);
            assert!(!is_long || exact < 0.0 || value >= exact - 2e-6, "{value} {exact}");
            equal += u32::from(is_long && exact > 0.0);
            low += u32::from(exact > 0.0 && value < 0.95 * exact);
        }
        assert!(equal > 1_000 && low > 100, "{equal} {low}");
    }

    #[test]
    fn what_is_ruled_out_has_greater_support_values() {
        let mut rng = SplitMix64::new(20_261_123);
        let mut seen = Seen::default();
        for round in 0..400 {
            let most = [8, 16, 32][round % 3];
            let points = [(); 2].map(|()| {
                let count = 4 + rng.below(most - 3);
                // A family has at least 8 points.
                let mut points = match (round / 3 + rng.below(2)) % 3 {
                    0 => families::sphere(count.max(8), rng.next_u64()),
                    1 => families::rock(count.max(8), rng.next_u64()),
                    _ => families::clustered_ellipsoid(count.max(8), rng.next_u64()),
                };
                points.truncate(count);
                points
            });
            let packs = points.map(|points| Pack::from_bytes(&packs::tree_bytes(&points)).unwrap());
            let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
            if a.facets().is_none() || b.facets().is_none() {
                continue;
            }
            let reach = a.outer_radius() + b.outer_radius();
            let distance = reach * if round % 5 == 0 { 0.0 } else { rng.between(0.0, 0.9) };
            let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
            let offset = DVec3::from_array(rng.direction()) * distance;
            let pose = Pose::new(a.interior_point() + offset - rotation * b.interior_point(), rotation).unwrap();
            for dispatch in dispatches() {
                match a.vertex_count().max(b.vertex_count()) {
                    0..=8 => check::<1, 2>([&a, &b], pose, dispatch, &mut seen),
                    9..=16 => check::<2, 4>([&a, &b], pose, dispatch, &mut seen),
                    _ => check::<4, 8>([&a, &b], pose, dispatch, &mut seen),
                }
            }
        }
        // All faces are known, until one separates. Most arcs are ruled out.
        assert!(seen.faces[0] == 0 && seen.faces[1] > 10_000, "{seen:?}");
        assert!(seen.arcs[1] > 300 && seen.arcs[0] > 10 * seen.arcs[1] && seen.apart > 30, "{seen:?}");
    }
}
