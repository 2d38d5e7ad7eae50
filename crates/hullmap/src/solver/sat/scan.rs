//! First pass of the separating axis test, in f32: which face normals and arcs may have the minimum
//! support value of the Minkowski difference.
//!
//! It only proposes. Every value is that of a point of the difference, to within [`Scan::error`],
//! so what it rules out is ruled out for certain. All that may be the minimum goes to f64.
//!
//! # Steps
//! 1. Lower bounds at all faces, from three parts of the other shape: the ball inside it, and two
//!    of its vertices.
//! 2. Support values at the faces whose bounds are all below the lowest value known.
//! 3. The same bounds hold along an arc if they hold at both of its ends. Rule out arcs by them,
//!    then by the support points at both ends.

use glam::{DMat3, DVec3};

use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;
use crate::support::facets::{Buffer, Facets, LANES, MAX_FACES, NormalBlock, PointBlock, Side, View};
use crate::support::simd::{Dispatch, Pass, Simd};

/// Bound of the error of a value of the scan, in units of 2⁻²⁴ times the reach: see
/// docs/intervals.md, section 12, which derives 20.
const ERROR_UNITS: f64 = 32.0;

/// Half a unit in the last place of 1 in f32.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Maximum number of arcs that are left to f64.
const MAX_LEFT: usize = 32;

/// Values of eight faces per block.
type Lanes = [f32; LANES];

/// The faces of a shape are the bits of a `u64`.
const _: () = assert!(MAX_FACES < u64::BITS as usize);

/// Number of lower bounds at each face: from the ball inside the other shape, then from vertices.
const BOUNDS: usize = 3;

/// The bound from the ball.
const BALL: usize = 0;

/// Shape A, shape B, and where they are.
pub(super) struct Pair<'v> {
    pub(super) a: View<'v>,
    pub(super) b: View<'v>,
    /// Number of faces of A and of B.
    pub(super) faces: [usize; 2],
    /// Rotates from B's frame to A's.
    pub(super) rotation: DMat3,
    /// The centre v0.
    pub(super) center: DVec3,
    /// Radii of the balls inside A and B.
    pub(super) inner: [f64; 2],
    /// Upper bound of the length of any point of the difference.
    pub(super) reach: f64,
    /// Outer radius of B.
    pub(super) radius_b: f64,
}

impl<'v> Pair<'v> {
    #[inline(always)]
    pub(super) fn new<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        [a, b]: &[Facets<'v>; 2],
        [buffer_a, buffer_b]: &'v mut [Buffer; 2],
    ) -> Self {
        let center = m.center_point().w;
        Self {
            a: a.view(buffer_a),
            b: b.view(buffer_b),
            faces: [a.face_count(), b.face_count()],
            rotation: m.rotation(),
            center,
            inner: m.inner_radii(),
            reach: m.outer_radius() + center.abs().element_sum(),
            radius_b: m.outer_radius_b(),
        }
    }

    /// Upper bound of the error of a value in f32: a length.
    pub(super) fn error(&self) -> f64 {
        ERROR_UNITS * UNIT * self.reach
    }
}

/// An arc of A that may have the minimum between its ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arc {
    /// The faces at its ends.
    pub(super) faces: [u8; 2],
    /// A vertex of its edge.
    pub(super) vertex: u8,
}

/// The arcs that are left to f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arcs {
    items: [Arc; MAX_LEFT],
    count: usize,
}

impl Arcs {
    pub(super) fn iter(&self) -> impl Iterator<Item = Arc> {
        self.items.iter().take(self.count).copied()
    }
}

/// The indices of the bits of `mask`, ascending.
#[inline(always)]
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        bit
    })
}

/// Rounded to f32, by rows.
fn rows(m: DMat3) -> [[f32; 3]; 3] {
    let m = m.transpose();
    [m.x_axis, m.y_axis, m.z_axis].map(|row| row.as_vec3().to_array())
}

/// One shape's faces, and the other shape's vertices, in the frame of the first. `P` blocks of
/// points, `N` blocks of faces.
#[derive(Clone, Copy, Debug)]
struct Half<const P: usize, const N: usize> {
    /// The other shape's vertices in the difference. The last block fills unused ones.
    points: [PointBlock; P],
    /// Lower bounds of the support values at the faces.
    bounds: [[Lanes; N]; BOUNDS],
    /// The greatest bound at each face.
    best: [Lanes; N],
    /// Support values at those faces that are `known`.
    values: [Lanes; N],
    /// The other shape's vertex behind each known value.
    vertices: [[u8; LANES]; N],
    known: u64,
}

impl<const P: usize, const N: usize> Half<P, N> {
    const EMPTY: Self = Self {
        points: [PointBlock([[0.0; LANES]; 3]); P],
        bounds: [[[0.0; LANES]; N]; BOUNDS],
        best: [[f32::INFINITY; LANES]; N],
        values: [[0.0; LANES]; N],
        vertices: [[0; LANES]; N],
        known: 0,
    };

    #[inline(always)]
    fn value(&self, face: usize) -> f32 {
        self.values[face / LANES % N][face % LANES]
    }

    #[inline(always)]
    fn vertex(&self, face: usize) -> u8 {
        self.vertices[face / LANES % N][face % LANES]
    }

    /// Position of a vertex of the other shape in the difference.
    #[inline(always)]
    fn point(&self, vertex: usize) -> [f32; 3] {
        self.points[vertex / LANES % P].0.each_ref().map(|c| c[vertex % LANES])
    }

    /// Bounds the values at all faces by `point` of the difference, with a ball of `radius` around
    /// it.
    #[inline(always)]
    fn bound<S: Simd>(&mut self, simd: S, bound: usize, normals: &[NormalBlock], point: [f32; 3], radius: f32) {
        for ((bounds, best), faces) in self.bounds[bound].iter_mut().zip(&mut self.best).zip(normals) {
            *bounds = simd.heights(faces, point, radius);
            *best = if bound == 0 { *bounds } else { simd.greater(best, bounds) };
        }
    }

    /// The face with the lowest bound.
    #[inline(always)]
    fn lowest_bound<S: Simd>(&self, simd: S, faces: usize) -> usize {
        let low = simd.lowest(&self.best);
        // Unused lanes repeat the last face, so the lowest one is a face.
        less(simd, &self.best, faces, low.next_up()).trailing_zeros() as usize % (N * LANES)
    }

    /// Computes the support value at a face, and returns it.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, simd: S, normals: &[NormalBlock], face: usize) -> f32 {
        let lane = face % LANES;
        let Some(block) = normals.get(face / LANES) else { return f32::INFINITY };
        let (farthest, vertex) = simd.farthest(&self.points, block.normal.each_ref().map(|c| c[lane]));
        let value = farthest + block.offset[lane];
        self.values[face / LANES % N][lane] = value;
        self.vertices[face / LANES % N][lane] = vertex as u8;
        self.known |= 1 << face;
        value
    }

    /// Whether values between the ends of an arc may be below `threshold`.
    #[inline(always)]
    fn may_dip(&self, normals: &[NormalBlock], ends: [usize; 2], side: Side, span: f32, threshold: f32) -> bool {
        let [v, w] = ends.map(|face| self.value(face));
        let [p, q] = ends.map(|face| self.vertex(face));
        let low = if v < w { v } else { w };
        // Between two normals, the value dips by at most a quarter of B's diameter times their
        // distance. NaN is kept.
        if p == q || low - span * side.chord >= threshold {
            return false;
        }
        let [p, q] = [p, q].map(|vertex| self.point(usize::from(vertex)));
        let normal = |face: usize| {
            let block = normals.get(face / LANES);
            block.map_or([0.0; 3], |block| block.normal.each_ref().map(|c| c[face % LANES]))
        };
        let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let step = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        // By how much the other end's point is lower at each end.
        let (drop_v, drop_w) = (dot(step, normal(ends[0])), -dot(step, normal(ends[1])));
        let (drop_v, drop_w) = (drop_v.max(0.0), drop_w.max(0.0));
        let t = drop_v / (drop_v + drop_w).max(f32::MIN_POSITIVE);
        let first = (1.0 - t) * v + t * (w - drop_w);
        let second = (1.0 - t) * (v - drop_v) + t * w;
        // NaN counts as a dip.
        !(first >= threshold && second >= threshold)
    }
}

/// The faces whose `values` are less than `threshold`. All blocks are compared, whether in use or
/// not: a loop of varying length costs more.
#[inline(always)]
fn less<S: Simd, const N: usize>(simd: S, values: &[Lanes; N], faces: usize, threshold: f32) -> u64 {
    let mut mask = 0;
    for block in values.iter().rev() {
        mask = mask << LANES | u64::from(simd.less(block, threshold));
    }
    mask & ((1 << faces) - 1)
}

/// The scan of one pair: A's faces, and B's.
#[derive(Debug)]
pub(super) struct Scan<const P: usize, const N: usize> {
    halves: [Half<P, N>; 2],
    /// Lowest value found.
    pub(super) low: f32,
    /// Upper bound of the error of every value: a length.
    pub(super) error: f32,
}

/// The scan of the faces.
struct FacePass<'s, 'p, 'v, const P: usize, const N: usize> {
    scan: &'s mut Scan<P, N>,
    pair: &'p Pair<'v>,
    upper: f32,
    seen: Option<[usize; 2]>,
}

impl<const P: usize, const N: usize> Pass for FacePass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, upper, seen, .. } = *self;
        let Scan { halves, low, error } = &mut *self.scan;
        // A's vertices are mirrored through the origin, in B's frame: −Rᵀ ((a − c_A) + v0).
        let back = pair.rotation.transpose();
        let turns = [rows(pair.rotation * -1.0), rows(back * -1.0)];
        let centers = [pair.center, back * -pair.center].map(|center| center.as_vec3().to_array());
        let views = [&pair.a, &pair.b];
        for own in 0..2 {
            let (half, view, other) = (&mut halves[own], views[own], 1 - own);
            let Some(last) = views[other].points.last() else { return };
            for (block, to) in half.points.iter_mut().enumerate() {
                *to = simd.transform(views[other].points.get(block).unwrap_or(last), &turns[own], centers[own]);
            }
            // 1.
            half.bound(simd, BALL, view.normals, centers[own], pair.inner[other] as f32);
            for bound in 1..BOUNDS {
                let vertex = match seen {
                    Some(seen) if bound == 1 => seen[own],
                    _ => {
                        let face = half.lowest_bound(simd, pair.faces[own]);
                        let value = half.evaluate(simd, view.normals, face);
                        *low = if value < *low { value } else { *low };
                        if value < -*error {
                            // The face separates.
                            return;
                        }
                        usize::from(half.vertex(face))
                    }
                };
                half.bound(simd, bound, view.normals, half.point(vertex), 0.0);
            }
        }
        // 2.
        let threshold = threshold(if *low < upper { *low } else { upper }, *error);
        for own in 0..2 {
            let half = &mut halves[own];
            let near = less(simd, &half.best, pair.faces[own], threshold) & !half.known;
            for face in bits(near) {
                let value = half.evaluate(simd, views[own].normals, face);
                *low = if value < *low { value } else { *low };
            }
        }
    }
}

/// The scan of the arcs of A.
struct ArcPass<'s, 'p, 'v, const P: usize, const N: usize> {
    scan: &'s mut Scan<P, N>,
    pair: &'p Pair<'v>,
    upper: f32,
    found: &'s mut Arcs,
    complete: bool,
}

impl<const P: usize, const N: usize> Pass for ArcPass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, upper, .. } = *self;
        let Scan { halves: [half, _], error, .. } = &mut *self.scan;
        let normals = pair.a.normals;
        let threshold = threshold(upper, *error);
        // 3. A bound at both ends holds between them if the part of it that is linear is positive.
        let positive = threshold.max(pair.inner[1] as f32 + 6.0 * *error);
        let mut below = [0; BOUNDS];
        for (bound, (below, bounds)) in below.iter_mut().zip(&half.bounds).enumerate() {
            *below = less(simd, bounds, pair.faces[0], if bound == BALL { positive } else { threshold });
        }
        let fewest = below.into_iter().min_by_key(|below| below.count_ones()).unwrap_or_default();
        let span = (0.5 * pair.radius_b) as f32 * (1.0 + 1e-6);
        for face in bits(fewest) {
            for side in pair.a.sides(face) {
                let beyond = usize::from(side.beyond) % (N * LANES);
                let is_second = fewest >> beyond & 1 == 1 && beyond < face;
                let is_near = below.iter().all(|below| (below >> face | below >> beyond) & 1 == 1);
                if is_second || !is_near {
                    continue;
                }
                let ends = [face, beyond];
                for end in ends {
                    if half.known >> end & 1 == 0 {
                        half.evaluate(simd, normals, end);
                    }
                }
                if half.may_dip(normals, ends, *side, span, threshold) {
                    let Some(item) = self.found.items.get_mut(self.found.count) else { return };
                    *item = Arc { faces: ends.map(|face| face as u8), vertex: side.vertex };
                    self.found.count += 1;
                }
            }
        }
        self.complete = true;
    }
}

/// What a value has to reach so that it certainly exceeds `upper`, and 0. A value along an arc has
/// up to four times the error.
#[inline(always)]
fn threshold(upper: f32, error: f32) -> f32 {
    upper.max(0.0) + 6.0 * error
}

impl<const P: usize, const N: usize> Scan<P, N> {
    /// A scan of `pair` without values.
    #[inline(always)]
    pub(super) fn new(pair: &Pair<'_>) -> Self {
        Self { halves: [Half::EMPTY; 2], low: f32::INFINITY, error: pair.error() as f32 }
    }

    /// Computes the support values at the faces of A and of B that may have the minimum.
    ///
    /// `upper` is an upper bound of the depth, or infinite. `seen` are a vertex of B and one of A
    /// that may be farthest in the direction of the depth; they only save work.
    #[inline(always)]
    pub(super) fn run(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32, seen: Option<[usize; 2]>) {
        dispatch.pass(&mut FacePass { scan: self, pair, upper, seen });
    }

    /// The known faces of A and of B whose values are not at least `threshold`. NaN is not.
    #[inline(always)]
    fn below(&self, threshold: f32) -> [u64; 2] {
        self.halves.each_ref().map(|half| {
            let mut known = half.known;
            for face in bits(half.known) {
                known &= !(u64::from(half.value(face) >= threshold) << face);
            }
            known
        })
    }

    /// The face with the lowest value, and whether it is one of B.
    pub(super) fn lowest_face(&self) -> Option<(usize, bool)> {
        let [a, b] = self.below(self.low.next_up());
        bits(a).next().map(|face| (face, false)).or_else(|| bits(b).next().map(|face| (face, true)))
    }

    /// The faces of A and of B whose values may be at most `upper`, an upper bound of the depth.
    #[inline(always)]
    pub(super) fn faces(&self, upper: f32) -> [u64; 2] {
        self.below(threshold(upper, self.error))
    }

    /// The vertex of B that is the support point at a known face of A, or nearly so.
    #[inline(always)]
    pub(super) fn vertex(&self, face: usize) -> usize {
        self.halves[0].vertex(face).into()
    }

    /// Stores the support vertex of B at a face of A, known from f64.
    #[inline(always)]
    pub(super) fn set_vertex(&mut self, face: usize, vertex: u32) {
        self.halves[0].vertices[face / LANES % N][face % LANES] = vertex as u8;
    }

    /// All arcs of A that may have a value of at most `upper` at a direction that is not an end.
    /// `None` if they are too many.
    ///
    /// `upper` is an upper bound of the depth, at most that for [`faces`](Self::faces). The
    /// vertices of all faces found there are known from f64 ([`set_vertex`](Self::set_vertex)).
    #[inline(always)]
    pub(super) fn arcs(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32) -> Option<Arcs> {
        let mut found = Arcs { items: [Arc::default(); MAX_LEFT], count: 0 };
        let mut pass = ArcPass { scan: self, pair, upper, found: &mut found, complete: false };
        dispatch.pass(&mut pass);
        pass.complete.then_some(found)
    }
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
    use crate::support::facets::{NORMAL_BLOCKS, POINT_BLOCKS};
    use crate::support::simd::Instructions;
    use crate::vector::unit;

    /// Faces and arcs that were ruled out, and those that were not.
    #[derive(Debug, Default)]
    struct Seen {
        faces: [u32; 2],
        arcs: [u32; 2],
        apart: u32,
    }

    /// Compares what the scan rules out with support values in f64, at all faces and along all
    /// arcs.
    fn check(a: &Hull<'_>, b: &Hull<'_>, pose: Pose, dispatch: Dispatch, seen: &mut Seen) {
        let mut m = Minkowski::new(a, b, pose);
        let facets = [a.facets().unwrap(), b.facets().unwrap()];
        let mut buffers = [Buffer::default(), Buffer::default()];
        let pair = Pair::new(&m, &facets, &mut buffers);
        let mut scan = Scan::<POINT_BLOCKS, NORMAL_BLOCKS>::new(&pair);
        scan.run(&pair, dispatch, f32::INFINITY, None);
        let (low, error) = (f64::from(scan.low), f64::from(scan.error));
        let mut lowest = f64::INFINITY;
        for (own, facets) in facets.iter().enumerate() {
            for face in 0..facets.face_count() {
                let normal = facets.normal(face).unwrap();
                let dir = if own == 0 { normal } else { pair.rotation * -normal };
                let exact = m.point(dir).w.dot(dir);
                lowest = lowest.min(exact);
                let half = &scan.halves[own];
                if half.known >> face & 1 == 1 {
                    seen.faces[1] += 1;
                    assert!((f64::from(half.value(face)) - exact).abs() <= error);
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
        let arcs = scan.arcs(&pair, dispatch, scan.low).unwrap();
        for face in 0..pair.faces[0] {
            for side in pair.a.sides(face).iter().filter(|side| usize::from(side.beyond) > face) {
                let ends = [face, side.beyond.into()];
                let is_left =
                    |arc: Arc| arc.faces.map(usize::from) == ends || arc.faces.map(usize::from) == [ends[1], face];
                if arcs.iter().any(is_left) {
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
    }

    #[test]
    fn what_is_ruled_out_has_greater_support_values() {
        let mut rng = SplitMix64::new(20_261_123);
        let mut seen = Seen::default();
        for round in 0..300 {
            let points = [(); 2].map(|()| match (round + rng.below(2)) % 3 {
                0 => families::sphere(8 + rng.below(25), rng.next_u64()),
                1 => families::rock(8 + rng.below(25), rng.next_u64()),
                _ => families::clustered_ellipsoid(8 + rng.below(25), rng.next_u64()),
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
            for instructions in [Instructions::Portable, Instructions::Avx2] {
                if let Some(dispatch) = Dispatch::of(instructions) {
                    check(&a, &b, pose, dispatch, &mut seen);
                }
            }
        }
        // Most faces and arcs are ruled out, and some pairs are separated.
        assert!(seen.faces[1] > 1_000 && seen.faces[0] > seen.faces[1], "{seen:?}");
        assert!(seen.arcs[1] > 300 && seen.arcs[0] > 10 * seen.arcs[1] && seen.apart > 30, "{seen:?}");
    }
}
