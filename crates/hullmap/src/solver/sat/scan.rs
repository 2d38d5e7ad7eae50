//! First pass of the separating axis test, in f32: which face normals and arcs may have the minimum
//! support value of the Minkowski difference.
//!
//! It only proposes. Every value is that of a point of the difference, to within [`Scan::error`],
//! so what it rules out is ruled out for certain. All that may be the minimum goes to f64.
//!
//! # Steps
//! 1. Lower bounds at all faces: from the ball inside the other shape, then cut by cut from its
//!    vertices. The next vertex is the support point at the face with the lowest bound. Stop when
//!    that face has its support value, which is then the minimum, or when its bound is too high.
//! 2. Support values at the remaining faces whose bounds are all below the lowest value known.
//! 3. The same bounds hold along an arc if they hold at both of its ends. Rule out arcs by them,
//!    then by the support points at both ends.
//!
//! # Reference
//! Step 1 is Kelley's cutting-plane method (1960) with the face normals as the only directions.

use glam::{DMat3, DVec3};

use super::first_pass::FirstPass;
use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;
use crate::support::facet_table::{LANES, NormalBlock, PointBlock};
use crate::support::facets::{Buffer, Facets, View};
use crate::support::lane_set::{Blocks, LaneSet};
use crate::support::simd::{Dispatch, Pass, Simd};

/// Bound of the error of a value of the scan, in units of 2⁻²⁴ times the reach: see
/// docs/intervals.md, section 12, which derives 20.
const ERROR_UNITS: f64 = 32.0;

/// Half a unit in the last place of 1 in f32.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Maximum number of vertices that bound the values of one shape's faces.
const MAX_CUTS: usize = 24;

/// Number of blocks up to which at most two cuts are made. A third takes as long as evaluating the
/// faces that it rules out.
const FEW_BLOCKS: usize = 4;

/// Maximum number of faces that are evaluated because all their bounds are low.
const MAX_NEAR: u32 = 96;

/// Maximum number of arcs that are left to f64.
const MAX_LEFT: usize = 64;

/// Bounds that have not been compared.
const UNKNOWN: u32 = u32::MAX;

/// Values of eight faces per block.
pub(super) type Lanes = [f32; LANES];

/// Shape A, shape B, and where they are.
pub(super) struct Pair<'v> {
    pub(super) a: View<'v>,
    pub(super) b: View<'v>,
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
            rotation: m.rotation(),
            center,
            inner: m.inner_radii(),
            reach: m.outer_radius() + center.abs().element_sum(),
            radius_b: m.outer_radius_b(),
        }
    }

    /// The matrix, by rows, and the centre that place B's vertices in the difference, and those of
    /// A in B's frame, where they are mirrored through the origin: −Rᵀ ((a − c_A) + v0).
    #[inline(always)]
    pub(super) fn placements(&self) -> [([[f32; 3]; 3], [f32; 3]); 2] {
        let back = self.rotation.transpose();
        let turns = [rows(self.rotation * -1.0), rows(back * -1.0)];
        let centers = [self.center.as_vec3(), (back * -self.center).as_vec3()];
        [(turns[0], centers[0].to_array()), (turns[1], centers[1].to_array())]
    }

    /// Whether the balls inside the shapes overlap, or nearly so.
    #[inline(always)]
    fn inner_balls_overlap(&self) -> bool {
        let radius = self.inner[0] + self.inner[1];
        self.center.length_squared() < radius * radius
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
    /// A vertex of its edge. Not a byte, which would leave one byte of padding: arrays without
    /// padding are zeroed in place.
    pub(super) vertex: u16,
    /// Lower bound of the values between the ends, or the value of an end is lower.
    pub(super) bound: f32,
}

/// Rounded to f32, by rows.
#[inline(always)]
fn rows(m: DMat3) -> [[f32; 3]; 3] {
    let m = m.transpose();
    [m.x_axis.as_vec3().to_array(), m.y_axis.as_vec3().to_array(), m.z_axis.as_vec3().to_array()]
}

/// One shape's faces, and the other shape's vertices, in the frame of the first. `P` blocks of
/// points, `N` blocks of faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half<const P: usize, const N: usize> {
    /// The other shape's vertices in the difference. The last block fills unused ones.
    pub(super) points: [PointBlock; P],
    /// The support values at those faces that are `known`, else the greatest lower bounds. Only
    /// those of active blocks are up to date.
    values: [Lanes; N],
    /// The other shape's vertex behind each known value.
    vertices: [[u8; LANES]; N],
    known: LaneSet<N>,
    /// The blocks in which a value may be below the lowest one known.
    active: Blocks<N>,
    /// The vertices of the other shape that bound the values.
    cuts: [u8; MAX_CUTS],
    cut_count: usize,
}

impl<const P: usize, const N: usize> Half<P, N> {
    const EMPTY: Self = Self {
        points: [PointBlock([[0.0; LANES]; 3]); P],
        values: [[0.0; LANES]; N],
        vertices: [[0; LANES]; N],
        known: LaneSet::EMPTY,
        active: Blocks::NONE,
        cuts: [0; MAX_CUTS],
        cut_count: 0,
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
        let PointBlock([x, y, z]) = &self.points[vertex / LANES % P];
        let lane = vertex % LANES;
        [x[lane], y[lane], z[lane]]
    }

    /// Bounds the values by the ball of `radius` around `center` in the difference. Returns the
    /// lowest bound, and its face.
    #[inline(always)]
    fn start<S: Simd>(
        &mut self,
        simd: S,
        normals: &[NormalBlock],
        (center, radius): ([f32; 3], f32),
        threshold: f32,
    ) -> (f32, usize) {
        self.active = Blocks::first(normals.len());
        for (values, _) in self.values.iter_mut().zip(normals) {
            *values = [f32::NEG_INFINITY; LANES];
        }
        simd.raise(&mut self.values, normals, &mut self.active, (center, radius), threshold)
    }

    /// Bounds the values by a vertex of the other shape. Returns the lowest bound, and its face.
    #[inline(always)]
    fn cut<S: Simd>(&mut self, simd: S, normals: &[NormalBlock], vertex: usize, threshold: f32) -> (f32, usize) {
        if let Some(cut) = self.cuts.get_mut(self.cut_count) {
            *cut = vertex as u8;
            self.cut_count += 1;
        }
        let point = self.point(vertex);
        simd.raise(&mut self.values, normals, &mut self.active, (point, 0.0), threshold)
    }

    /// Finds the support point at a face, and returns the face's value. It is not stored in
    /// `values`: the processor cannot forward a stored lane to the load of its vector.
    #[inline(always)]
    fn find_support<S: Simd>(&mut self, simd: S, normals: &[NormalBlock], face: usize) -> f32 {
        let lane = face % LANES;
        let Some(block) = normals.get(face / LANES) else { return f32::INFINITY };
        let (farthest, vertex) = simd.farthest(&self.points, normal(normals, face));
        self.vertices[face / LANES % N][lane] = vertex as u8;
        self.known.insert(face);
        farthest + block.offset[lane]
    }

    /// Computes the support value at a face, and returns it.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, simd: S, normals: &[NormalBlock], face: usize) -> f32 {
        let value = self.find_support(simd, normals, face);
        self.values[face / LANES % N][face % LANES] = value;
        value
    }

    /// The faces of active blocks whose values are unknown, and whose bounds are below `threshold`.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, threshold: f32) -> LaneSet<N> {
        let mut near = LaneSet::EMPTY;
        for block in self.active.iter() {
            near.add_block(block, simd.less(&self.values[block % N], threshold));
        }
        near.without(&self.known)
    }

    /// The known faces whose values are not at least `threshold`. NaN is not.
    #[inline(always)]
    fn below(&self, threshold: f32) -> LaneSet<N> {
        let mut below = self.known;
        for face in self.known.iter() {
            if self.value(face) >= threshold {
                below.remove(face);
            }
        }
        below
    }

    /// Lower bound of the values between the ends of an arc, where it is lower than both ends;
    /// infinite if it is at least `threshold`. Values are at most `dip` below the lower end.
    #[inline(always)]
    fn dip(&self, normals: &[NormalBlock], ends: [usize; 2], dip: f32, threshold: f32) -> f32 {
        let (v, w) = (self.value(ends[0]), self.value(ends[1]));
        let (p, q) = (self.vertex(ends[0]), self.vertex(ends[1]));
        let low = if v < w { v } else { w };
        // NaN is kept.
        if p == q || low - dip >= threshold {
            return f32::INFINITY;
        }
        let (c, d) = (normal(normals, ends[0]), normal(normals, ends[1]));
        let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let (p, q) = (self.point(p.into()), self.point(q.into()));
        let step = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        // By how much the other end's point is lower at each end.
        let (drop_v, drop_w) = (dot(step, c), -dot(step, d));
        // NaN counts as a dip.
        let bound = value_between([v, w - drop_w], [v - drop_v, w], dot(c, d));
        if bound >= threshold { f32::INFINITY } else { bound }
    }
}

/// The scan of one pair: A's faces, and B's.
#[derive(Debug)]
pub(super) struct Scan<const P: usize, const N: usize> {
    pub(super) halves: [Half<P, N>; 2],
    /// Lowest value found.
    pub(super) low: f32,
    /// Upper bound of the error of every value: a length.
    pub(super) error: f32,
    /// The arcs of A that may have the minimum between their ends.
    arcs: [Arc; MAX_LEFT],
    arc_count: usize,
}

/// The scan of the faces.
struct FacePass<'s, 'p, 'v, const P: usize, const N: usize> {
    scan: &'s mut Scan<P, N>,
    pair: &'p Pair<'v>,
    upper: f32,
    seen: Option<[usize; 2]>,
    complete: bool,
}

impl<const P: usize, const N: usize> Pass for FacePass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, upper, seen, .. } = *self;
        let Scan { halves, low, error, .. } = &mut *self.scan;
        let placements = pair.placements();
        let views = [&pair.a, &pair.b];
        // The lowest bound of each shape's faces, and the face.
        let mut lowest = [(0.0, 0); 2];
        // In deep pairs the shapes take turns, so that the processor computes a cut of each at the
        // same time. In others, a face of A may separate them, and B needs no cut.
        let groups = if pair.inner_balls_overlap() { [0..2, 2..2] } else { [0..1, 1..2] };
        for group in groups {
            for own in group.clone() {
                let (half, normals, other) = (&mut halves[own], views[own].normals, 1 - own);
                let (turn, center) = &placements[own];
                let Some(last) = views[other].points.last() else { return };
                for (block, to) in half.points.iter_mut().enumerate() {
                    *to = simd.transform(views[other].points.get(block).unwrap_or(last), turn, *center);
                }
                // 1.
                let ball = (*center, pair.inner[other] as f32);
                let threshold = lower_threshold(*low, upper, *error);
                lowest[own] = half.start(simd, normals, ball, threshold);
                if let Some(seen) = seen {
                    lowest[own] = half.cut(simd, normals, seen[own], threshold);
                }
            }
            let mut is_done = false;
            while !is_done {
                is_done = true;
                for own in group.clone() {
                    let (half, normals, (bound, face)) = (&mut halves[own], views[own].normals, lowest[own]);
                    let is_last = half.cut_count >= const { if N <= FEW_BLOCKS { 2 } else { MAX_CUTS } };
                    if is_last || !(bound < lower_threshold(*low, upper, *error)) || half.known.contains(face) {
                        continue;
                    }
                    let value = half.find_support(simd, normals, face);
                    *low = if value < *low { value } else { *low };
                    if value < -*error {
                        // The face separates.
                        half.values[face / LANES % N][face % LANES] = value;
                        self.complete = true;
                        return;
                    }
                    let threshold = lower_threshold(*low, upper, *error);
                    lowest[own] = half.cut(simd, normals, half.vertex(face).into(), threshold);
                    is_done = false;
                }
            }
        }
        // 2.
        let threshold = lower_threshold(*low, upper, *error);
        for own in 0..2 {
            let half = &mut halves[own];
            let near = half.near(simd, threshold);
            if near.len() > MAX_NEAR {
                return;
            }
            for face in near.iter() {
                let value = half.evaluate(simd, views[own].normals, face);
                *low = if value < *low { value } else { *low };
            }
        }
        self.complete = true;
    }
}

/// The scan of the arcs of A.
struct ArcPass<'s, 'p, 'v, const P: usize, const N: usize> {
    scan: &'s mut Scan<P, N>,
    pair: &'p Pair<'v>,
    upper: f32,
    complete: bool,
}

impl<const P: usize, const N: usize> Pass for ArcPass<'_, '_, '_, P, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let Self { pair, upper, .. } = *self;
        let Scan { halves: [half, _], error, arcs, arc_count, .. } = &mut *self.scan;
        let normals = pair.a.normals;
        let threshold = threshold(upper, *error);
        // 3.
        let mut points = [[0.0; 4]; MAX_CUTS];
        for (point, vertex) in points.iter_mut().zip(half.cuts).take(half.cut_count) {
            let [x, y, z] = half.point(vertex.into());
            *point = [x, y, z, threshold];
        }
        let points = &points[..half.cut_count];
        let all = (1_u32 << half.cut_count) - 1;
        let center = pair.center.as_vec3().to_array();
        let (radius, margin) = (pair.inner[1] as f32, -2.0 * *error);
        let mut near = LaneSet::<N>::EMPTY;
        for (block, (faces, stretches)) in normals.iter().zip(pair.a.stretches).enumerate().take(N) {
            let mut bounds = simd.heights(faces, center, margin);
            for (bound, stretch) in bounds.iter_mut().zip(stretches) {
                // Negative ones are stretched.
                let stretched = *bound * stretch;
                *bound = if stretched < *bound { stretched } else { *bound } + radius;
            }
            near.add_block(block, simd.less(&bounds, threshold));
        }
        // One bit per cut whose bound is below the threshold. Faces not yet compared have all bits.
        let mut below = [[UNKNOWN; LANES]; N];
        // Between two normals, the value dips by at most a quarter of B's diameter times their
        // distance.
        let span = (0.5 * pair.radius_b) as f32 * (1.0 + 1e-6);
        for face in near.iter() {
            compare(simd, &mut below, normals, points, face);
            let own = below[face / LANES % N][face % LANES];
            for side in pair.a.sides(face) {
                let beyond = usize::from(side.beyond);
                let (block, lane) = (beyond / LANES % N, beyond % LANES);
                let is_second = beyond < face && near.contains(beyond);
                if (own | below[block][lane]) & all != all || is_second {
                    continue;
                }
                compare(simd, &mut below, normals, points, beyond);
                if (own | below[block][lane]) & all != all {
                    continue;
                }
                let ends = [face, beyond];
                for end in ends {
                    if !half.known.contains(end) {
                        half.evaluate(simd, normals, end);
                    }
                }
                let bound = half.dip(normals, ends, span * side.chord(), threshold);
                // NaN is kept.
                if bound != f32::INFINITY {
                    let Some(arc) = arcs.get_mut(*arc_count) else { return };
                    *arc = Arc { faces: ends.map(|face| face as u8), vertex: side.vertex.into(), bound };
                    *arc_count += 1;
                }
            }
        }
        lowest_first(&mut arcs[..*arc_count]);
        self.complete = true;
    }
}

/// The lower of two values; NaN if one of them is.
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
pub(super) fn value_between(p: [f32; 2], q: [f32; 2], cosine: f32) -> f32 {
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
pub(super) fn lowest_first(arcs: &mut [Arc]) {
    let mut lowest = 0;
    for (index, arc) in arcs.iter().enumerate() {
        lowest = if arc.bound < arcs[lowest].bound { index } else { lowest };
    }
    if lowest > 0 {
        arcs.swap(0, lowest);
    }
}

/// The normal of a face.
#[inline(always)]
fn normal(normals: &[NormalBlock], face: usize) -> [f32; 3] {
    let lane = face % LANES;
    match normals.get(face / LANES) {
        Some(NormalBlock { normal: [x, y, z], .. }) => [x[lane], y[lane], z[lane]],
        None => [0.0; 3],
    }
}

/// Compares the bounds of the block of `face` if they are unknown.
#[inline(always)]
fn compare<S: Simd, const N: usize>(
    simd: S,
    below: &mut [[u32; LANES]; N],
    normals: &[NormalBlock],
    points: &[[f32; 4]],
    face: usize,
) {
    let block = face / LANES % N;
    if below[block][0] == UNKNOWN
        && let Some(faces) = normals.get(block)
    {
        below[block] = simd.below(faces, points);
    }
}

/// The [`threshold`] for the lower of two upper bounds.
#[inline(always)]
fn lower_threshold(low: f32, upper: f32, error: f32) -> f32 {
    threshold(if low < upper { low } else { upper }, error)
}

/// A value that is at least this certainly exceeds `upper`, and 0. A value along an arc has up to
/// four times the error.
#[inline(always)]
pub(super) fn threshold(upper: f32, error: f32) -> f32 {
    upper.max(0.0) + 6.0 * error
}

impl<const P: usize, const N: usize> FirstPass<P, N> for Scan<P, N> {
    const TAKES_UPPER: bool = true;

    #[inline(always)]
    fn new(pair: &Pair<'_>) -> Self {
        Self {
            halves: [Half::EMPTY; 2],
            low: f32::INFINITY,
            error: pair.error() as f32,
            arcs: [Arc::default(); MAX_LEFT],
            arc_count: 0,
        }
    }

    #[inline(always)]
    fn run(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32, seen: Option<[usize; 2]>) -> Option<()> {
        let mut pass = FacePass { scan: self, pair, upper, seen, complete: false };
        dispatch.pass(&mut pass);
        pass.complete.then_some(())
    }

    #[inline(always)]
    fn find_arcs(&mut self, pair: &Pair<'_>, dispatch: Dispatch, upper: f32) -> Option<()> {
        let mut pass = ArcPass { scan: self, pair, upper, complete: false };
        dispatch.pass(&mut pass);
        pass.complete.then_some(())
    }

    #[inline(always)]
    fn arcs(&self) -> &[Arc] {
        self.arcs.get(..self.arc_count).unwrap_or_default()
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
        let [a, b] = &self.halves;
        let threshold = threshold(upper, self.error);
        [a.below(threshold), b.below(threshold)]
    }

    #[inline(always)]
    fn faces_at_most(&self, value: f32) -> [LaneSet<N>; 2] {
        [self.halves[0].below(value.next_up()), self.halves[1].below(value.next_up())]
    }

    #[inline(always)]
    fn vertex(&self, face: usize) -> usize {
        self.halves[0].vertex(face).into()
    }

    #[inline(always)]
    fn set_vertex(&mut self, face: usize, vertex: u32) {
        self.halves[0].vertices[face / LANES % N][face % LANES] = vertex as u8;
    }

    #[inline(always)]
    fn points(&self) -> [&[PointBlock; P]; 2] {
        self.halves.each_ref().map(|half| &half.points)
    }
}

#[cfg(test)]
mod tests {
    use super::super::flat::Flat;
    use glam::DQuat;
    use hullmap_testkit::packs;
    use shapes::{families, rng::SplitMix64};

    use super::*;
    use crate::hull::Hull;
    use crate::pack::Pack;
    use crate::pose::Pose;
    use crate::support::facet_table::{NORMAL_BLOCKS, POINT_BLOCKS};
    use crate::support::simd::Instructions;
    use crate::vector::unit;

    /// Faces and arcs that were ruled out, and those that were not.
    #[derive(Debug, Default)]
    struct Seen {
        faces: [u32; 2],
        arcs: [u32; 2],
        apart: u32,
    }

    impl<const P: usize, const N: usize> Scan<P, N> {
        fn known(&self, own: usize, face: usize) -> Option<f32> {
            let half = &self.halves[own];
            half.known.contains(face).then(|| half.value(face))
        }
    }

    /// Compares what the scan rules out with support values in f64, at all faces and along all
    /// arcs. `known_value` is the support value at a face, if the pass has computed it.
    fn check<F: FirstPass<P, N>, const P: usize, const N: usize>(
        [a, b]: [&Hull<'_>; 2],
        pose: Pose,
        dispatch: Dispatch,
        known_value: impl Fn(&F, usize, usize) -> Option<f32>,
        seen: &mut Seen,
    ) {
        let mut m = Minkowski::new(a, b, pose);
        let facets = [a.facets().unwrap(), b.facets().unwrap()];
        let mut buffers = [Buffer::default(), Buffer::default()];
        let pair = Pair::new(&m, &facets, &mut buffers);
        let mut scan = F::new(&pair);
        scan.run(&pair, dispatch, f32::INFINITY, None).unwrap();
        let (low, error) = (f64::from(scan.low()), f64::from(scan.error()));
        let mut lowest = f64::INFINITY;
        for (own, facets) in facets.iter().enumerate() {
            for face in 0..facets.face_count() {
                let normal = facets.normal(face).unwrap();
                let dir = if own == 0 { normal } else { pair.rotation * -normal };
                let exact = m.point(dir).w.dot(dir);
                lowest = lowest.min(exact);
                if let Some(value) = known_value(&scan, own, face) {
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
        for face in scan.faces(scan.low())[0].iter() {
            let on_b = m.point(facets[0].normal(face).unwrap()).features[1];
            scan.set_vertex(face, on_b);
        }
        scan.find_arcs(&pair, dispatch, scan.low()).unwrap();
        let arcs = scan.arcs();
        for face in 0..facets[0].face_count() {
            for side in pair.a.sides(face).iter().filter(|side| usize::from(side.beyond) > face) {
                let ends = [face, side.beyond.into()];
                let is_left =
                    |arc: Arc| arc.faces.map(usize::from) == ends || arc.faces.map(usize::from) == [ends[1], face];
                if arcs.iter().copied().any(is_left) {
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
        let (mut seen, mut flat) = (Seen::default(), Seen::default());
        for round in 0..300 {
            let most = [8, 16, 32, 32, 64, 128][round % 6];
            let points = [(); 2].map(|()| {
                let count = 4 + rng.below(most - 3);
                // A family has at least 8 points.
                let mut points = match (round + rng.below(2)) % 3 {
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
            for instructions in [Instructions::Portable, Instructions::Avx2] {
                if let Some(dispatch) = Dispatch::of(instructions) {
                    match a.vertex_count().max(b.vertex_count()) {
                        0..=8 => {
                            check([&a, &b], pose, dispatch, Scan::<1, 2>::known, &mut seen);
                            check([&a, &b], pose, dispatch, Flat::<1, 2>::known, &mut flat);
                        }
                        9..=16 => {
                            check([&a, &b], pose, dispatch, Scan::<2, 4>::known, &mut seen);
                            check([&a, &b], pose, dispatch, Flat::<2, 4>::known, &mut flat);
                        }
                        17..=32 => check([&a, &b], pose, dispatch, Scan::<4, 8>::known, &mut seen),
                        33..=64 => check([&a, &b], pose, dispatch, Scan::<8, 16>::known, &mut seen),
                        _ => check([&a, &b], pose, dispatch, Scan::<POINT_BLOCKS, NORMAL_BLOCKS>::known, &mut seen),
                    }
                }
            }
        }
        // Most faces and arcs are ruled out, and some pairs are separated.
        assert!(seen.faces[1] > 1_000 && seen.faces[0] > seen.faces[1], "{seen:?}");
        assert!(seen.arcs[1] > 300 && seen.arcs[0] > 10 * seen.arcs[1] && seen.apart > 30, "{seen:?}");
        // The pass for few vertices knows all faces, until one separates.
        assert!(flat.faces[0] == 0 && flat.faces[1] > 1_000 && flat.apart > 10, "{flat:?}");
        assert!(flat.arcs[1] > 100 && flat.arcs[0] > 5 * flat.arcs[1], "{flat:?}");
    }
}
