//! The expanding polytope of EPA: a closed surface of triangles inside the Minkowski difference.
//!
//! Each face has a normal and an offset: the distance of its plane from the origin, positive if the
//! origin is behind the plane. [`Polytope::insert_vertex`] replaces the faces that a new vertex
//! sees by a fan to that vertex.
//!
//! # Steps of [`Polytope::insert_vertex`]
//! 1. Walk from the face below the vertex to the neighbours that see the vertex too. The walk goes
//!    around each face in order, so it meets the edges of the border in order as well.
//! 2. The border is the horizon. Each of its edges must start where the previous one ends.
//! 3. Reuse the places of the visible faces for the new faces.
//! 4. Compute the planes of the new faces, one per edge of the horizon and four at a time, and link
//!    the neighbours.
//!
//! `V` vertices need `F` ≥ 2 V faces, since a closed surface of V vertices has 2 V − 4 faces.
//!
//! # Invariants under rounding error
//! - The surface is closed: each edge belongs to two faces that traverse it in opposite directions.
//!   Step 2 ensures it.
//! - Every point of a face is at or beyond the face's offset along its normal, up to the rounding
//!   error of a dot product. The offset is the minimum over the three corners, and not the offset
//!   of an ideal plane.
//! - [`Polytope::encloses`] proves that the surface winds around the origin. Inserting a vertex
//!   keeps that property if, along the normal of each removed face, the face and the new vertex are
//!   beyond the origin. Then the minimum offset is the radius of a ball inside the
//!   Minkowski difference, even if the surface is not convex (docs/contributors/intervals.md).

use crate::solver::barycentric::on_triangle;
use crate::solver::bound::SAME_NORMAL;
use crate::solver::minkowski::Point;
use crate::support::simd::{Dispatch, Pass, Simd};
use glam::DVec3;
use std::hint::select_unpredictable;

/// A vertex sees a face if it is above the face's plane, or at most this many noises below it. So
/// it sees all of several coplanar faces, and no sliver arises between it and an edge in line with
/// it.
pub(in crate::solver) const COPLANAR_NOISES: f64 = 2.0;

/// Planes whose offsets differ by at most this much, relative, may be the same plane. The planes of
/// slivers are that inaccurate.
const COPLANAR_RELATIVE: f64 = 1e-9;

/// Unit normals closer than this may belong to the same plane, for the same reason.
const PARALLEL_DISTANCE: f64 = 1e-4;

/// The sign of a volume is certain if the volume exceeds this factor times the product of its three
/// lengths: two edges, a cross product and a dot product have a relative error of 10 · 2⁻⁵³.
const CERTAIN: f64 = 8.0 * f64::EPSILON;

const LANES: usize = 4;

const OFFSET_LANES: usize = 8;

/// Due to rounding error the horizon of a vertex is not a loop, or a new face has no area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) struct InsertError;

/// An edge of the horizon: its first corner, and the face beyond it with that face's number for it.
#[derive(Clone, Copy, Debug)]
struct HorizonEdge {
    from: u16,
    beyond: u16,
    beyond_edge: u16,
}

/// A closed surface of triangles.
///
/// Points and planes are stored by coordinate, and are written and read one number at a time: if
/// they were read back as vectors, the processor would stall.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Polytope<const V: usize, const F: usize> {
    /// Coordinates of the vertices: all x, all y, all z.
    w: [[f64; V]; 3],
    /// The points of the first shape that the vertices come from.
    a: [DVec3; V],
    features: [[u32; 2]; V],
    /// Also counts vertices that are inside the surface by now.
    pub(super) point_count: usize,
    /// Squares of the faces' offsets, with the signs of the offsets. So faces that are never
    /// selected cost no square root. Infinite for free places.
    offsets: [f64; F],
    /// The normals of the faces, not of unit length, and the dot product above which a point sees
    /// the face.
    planes: [[f64; F]; 4],
    /// Corners of the faces, counter-clockwise as seen from outside.
    pub(super) corners: [[u16; 3]; F],
    /// The faces across the edges from corner i to corner i + 1.
    neighbours: [[u16; 3]; F],
    face_count: usize,
    /// The face with the minimum offset; of several, the one with the lowest index.
    pub(super) nearest: usize,
    encloses: bool,
    dispatch: Dispatch,
    /// Heights below this count as zero: a length.
    slack: f64,
    /// Scratch of [`insert_vertex`](Self::insert_vertex): edges that the walk has yet to cross
    /// (face, edge).
    open_edges: [(u16, u16); F],
    /// Scratch: the faces that the new vertex sees, then the places of the new faces.
    removed: [u16; F],
    horizon: [HorizonEdge; V],
}

impl<const V: usize, const F: usize> Polytope<V, F> {
    /// Memory for a polytope, to be [cleared](Self::clear) first. All of its bytes are zero, so it
    /// is written in its place; anything else would be copied there.
    pub(in crate::solver) const EMPTY: Self = {
        assert!(F >= 2 * V && F.is_multiple_of(OFFSET_LANES) && F <= u16::MAX as usize);
        Self {
            w: [[0.0; V]; 3],
            a: [DVec3::ZERO; V],
            features: [[0; 2]; V],
            point_count: 0,
            offsets: [0.0; F],
            planes: [[0.0; F]; 4],
            corners: [[0; 3]; F],
            neighbours: [[0; 3]; F],
            face_count: 0,
            nearest: 0,
            encloses: false,
            dispatch: Dispatch::Portable,
            slack: 0.0,
            open_edges: [(0, 0); F],
            removed: [0; F],
            horizon: [HorizonEdge { from: 0, beyond: 0, beyond_edge: 0 }; V],
        }
    };

    #[cfg(test)]
    fn empty(noise: f64) -> Self {
        let mut polytope = Self::EMPTY;
        polytope.clear(noise);
        polytope
    }

    /// Becomes the tetrahedron `seed`. Returns false if one of its heights is at most `min_height`.
    pub(in crate::solver) fn start(&mut self, mut seed: [Point; 4], min_height: f64) -> bool {
        const CORNERS: [[u16; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        const NEIGHBOURS: [[u16; 3]; 4] = [[1, 2, 3], [3, 2, 0], [1, 3, 0], [2, 1, 0]];
        let [p, q, r, s] = seed.map(|v| v.w);
        let (pq, pr, ps) = (q - p, r - p, s - p);
        let normals = [pq.cross(pr), pq.cross(ps), pr.cross(ps), (r - q).cross(s - q)];
        let volume = normals[0].dot(ps);
        let max_sq = normals.iter().fold(0.0, |max: f64, n| max.max(n.length_squared()));
        // NaN takes the failing branch.
        let solid = volume.abs() > min_height * max_sq.sqrt();
        if !solid {
            return false;
        }
        if volume > 0.0 {
            seed.swap(0, 1);
        }
        // Now s is behind p q r.
        self.point_count = 0;
        seed.into_iter().for_each(|point| self.push(point));
        self.set_face_count(4);
        self.corners[..4].copy_from_slice(&CORNERS);
        self.neighbours[..4].copy_from_slice(&NEIGHBOURS);
        self.update_planes(4)
    }

    /// Becomes a cached surface under a new pose. A place whose corners are all the same vertex is
    /// free. Returns false if the surface does not fit, a point is unknown, or a face has no area.
    pub(in crate::solver) fn restore(
        &mut self,
        points: &[[u32; 2]],
        recall: impl Fn([u32; 2]) -> Option<Point>,
        corners: &[[u8; 3]],
        neighbours: &[[u8; 3]],
    ) -> bool {
        self.point_count = 0;
        if points.len() > V {
            return false;
        }
        for features in points {
            let Some(point) = recall(*features) else { return false };
            self.push(point);
        }
        if corners.len() > F {
            return false;
        }
        self.set_face_count(corners.len());
        for (face, (corners, neighbours)) in corners.iter().zip(neighbours).enumerate() {
            (self.corners[face], self.neighbours[face]) = (corners.map(u16::from), neighbours.map(u16::from));
        }
        self.update_planes(self.face_count)
    }

    /// Computes the first `count` planes and offsets. Returns false if a face has no area.
    fn update_planes(&mut self, count: usize) -> bool {
        let mut update = Update { polytope: self, count, all_solid: false };
        let dispatch = update.polytope.dispatch;
        dispatch.pass(&mut update);
        update.all_solid
    }

    #[inline(always)]
    fn update(&mut self, count: usize) -> bool {
        let mut all_solid = true;
        let mut encloses = true;
        for at in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - at);
            let mut points = [[[0.0; LANES]; 3]; 3];
            for lane in 0..LANES {
                let corners = self.corners[at + if lane < lanes { lane } else { 0 }];
                for (point, corner) in points.iter_mut().zip(corners) {
                    let w = self.position(usize::from(corner));
                    (point[0][lane], point[1][lane], point[2][lane]) = (w.x, w.y, w.z);
                }
            }
            let [p, q, r] = points;
            let (planes, offsets, certain) = planes(p, q, r, self.slack);
            for lane in 0..lanes {
                let face = at + lane;
                if self.is_free(face) {
                    self.offsets[face] = f64::INFINITY;
                } else {
                    self.set_plane(face, [planes[0][lane], planes[1][lane], planes[2][lane], planes[3][lane]]);
                    self.offsets[face] = offsets[lane];
                    all_solid &= offsets[lane].is_finite();
                    encloses &= certain[lane];
                }
            }
        }
        self.encloses = all_solid && encloses;
        self.nearest = self.find_nearest();
        all_solid
    }

    /// Uses more places, which are free up to the next multiple of [`OFFSET_LANES`].
    #[inline(always)]
    fn set_face_count(&mut self, count: usize) {
        let [before, after] = [self.face_count, count].map(|count| count.next_multiple_of(OFFSET_LANES).min(F));
        if after > before {
            self.offsets[before..after].fill(f64::INFINITY);
        }
        self.face_count = count;
    }

    fn is_free(&self, face: usize) -> bool {
        self.corners[face][0] == self.corners[face][1]
    }

    /// Leaves no surface. `noise` is the error bound of offsets, a length.
    #[inline(always)]
    pub(in crate::solver) fn clear(&mut self, noise: f64) {
        (self.point_count, self.face_count, self.nearest, self.encloses) = (0, 0, 0, false);
        (self.dispatch, self.slack) = (Dispatch::best(), COPLANAR_NOISES * noise);
    }

    /// Overwrites `big`, which has more room, with this surface.
    #[inline(always)]
    pub(in crate::solver) fn overwrite<const W: usize, const G: usize>(&self, big: &mut Polytope<W, G>) {
        // Field by field: an empty polytope would take the stack that this saves.
        big.encloses = false;
        (big.dispatch, big.slack) = (self.dispatch, self.slack);
        for axis in 0..3 {
            big.w[axis][..self.point_count].copy_from_slice(&self.w[axis][..self.point_count]);
        }
        big.a[..self.point_count].copy_from_slice(&self.a[..self.point_count]);
        big.features[..self.point_count].copy_from_slice(&self.features[..self.point_count]);
        big.point_count = self.point_count;
        let n = self.face_count;
        big.face_count = 0;
        big.set_face_count(n);
        big.corners[..n].copy_from_slice(&self.corners[..n]);
        big.neighbours[..n].copy_from_slice(&self.neighbours[..n]);
        for (big, small) in big.planes.iter_mut().zip(&self.planes) {
            big[..n].copy_from_slice(&small[..n]);
        }
        big.offsets[..n].copy_from_slice(&self.offsets[..n]);
        big.nearest = self.nearest;
    }

    /// Whether the surface certainly wound around the origin when it was started or restored: every
    /// face has the same orientation as seen from the origin.
    pub(in crate::solver) fn encloses(&self) -> bool {
        self.encloses
    }

    /// [`encloses`](Self::encloses) for the surface as it is now.
    #[cold]
    pub(in crate::solver) fn check_encloses(&mut self) -> bool {
        self.update_planes(self.face_count);
        self.encloses
    }

    #[inline(always)]
    fn find_nearest(&self) -> usize {
        let used = self.face_count.next_multiple_of(OFFSET_LANES).min(F);
        self.dispatch.argmin(self.offsets[..used].as_chunks::<OFFSET_LANES>().0)
    }

    #[inline(always)]
    fn position(&self, index: usize) -> DVec3 {
        DVec3::new(self.w[0][index], self.w[1][index], self.w[2][index])
    }

    /// Adds a vertex without faces.
    #[inline(always)]
    fn push(&mut self, point: Point) {
        let index = self.point_count;
        (self.w[0][index], self.w[1][index], self.w[2][index]) = (point.w.x, point.w.y, point.w.z);
        self.a[index] = point.a;
        self.features[index] = point.features;
        self.point_count += 1;
    }

    #[inline(always)]
    fn set_plane(&mut self, face: usize, [x, y, z, seen_from]: [f64; 4]) {
        self.planes[0][face] = x;
        self.planes[1][face] = y;
        self.planes[2][face] = z;
        self.planes[3][face] = seen_from;
    }

    /// Outward normal of a face, the length of that normal, and the offset of the face.
    #[inline]
    pub(in crate::solver) fn plane(&self, face: usize) -> (DVec3, f64, f64) {
        let normal = DVec3::new(self.planes[0][face], self.planes[1][face], self.planes[2][face]);
        let offset_sq = self.offsets[face];
        (normal, normal.length(), offset_sq.abs().sqrt().copysign(offset_sq))
    }

    /// The least offset of the faces whose normal differs from `normal`, at most `limit` > 0.
    pub(in crate::solver) fn offset_beside(&self, normal: DVec3, limit: f64) -> f64 {
        let mut lowest = limit * limit;
        for face in 0..self.face_count {
            // The offset of a free place is infinite.
            if self.offsets[face] < lowest {
                let (direction, length, _) = self.plane(face);
                let is_same = direction.distance(normal * length) <= SAME_NORMAL * length;
                lowest = if is_same { lowest } else { self.offsets[face] };
            }
        }
        lowest.abs().sqrt().copysign(lowest)
    }

    pub(in crate::solver) fn point(&self, index: u16) -> Point {
        let index = usize::from(index);
        Point { w: self.position(index), a: self.a[index], features: self.features[index] }
    }

    pub(in crate::solver) fn features(&self) -> &[[u32; 2]] {
        &self.features[..self.point_count]
    }

    /// Corners and neighbours of all places. The corners of a free place are all the same vertex.
    pub(in crate::solver) fn faces(&self) -> (&[[u16; 3]], &[[u16; 3]]) {
        (&self.corners[..self.face_count], &self.neighbours[..self.face_count])
    }

    fn face_points(&self, face: usize) -> [DVec3; 3] {
        self.corners[face].map(|i| self.position(usize::from(i)))
    }

    /// The face in the plane of `face`, up to `slack`, that has the point closest to the origin.
    pub(in crate::solver) fn face_of_foot(&self, face: usize, slack: f64) -> usize {
        let nearest = |face: usize| {
            let [p, q, r] = self.face_points(face);
            on_triangle(p, q, r).point.length_squared()
        };
        let (normal, length, offset) = self.plane(face);
        let (mut best, mut best_sq) = (face, nearest(face));
        // Usually the foot of the origin is in the face itself.
        let limit = offset.abs() * (1.0 + COPLANAR_RELATIVE) + slack;
        if best_sq <= limit * limit {
            return best;
        }
        for other in 0..self.face_count {
            if self.offsets[other] > limit * limit {
                continue;
            }
            let (other_normal, other_length, _) = self.plane(other);
            if (other_normal / other_length).distance(normal / length) < PARALLEL_DISTANCE {
                let other_sq = nearest(other);
                if other_sq < best_sq {
                    (best, best_sq) = (other, other_sq);
                }
            }
        }
        best
    }

    pub(in crate::solver) fn is_full(&self) -> bool {
        self.point_count == V
    }

    /// EPA's insertion: adds a vertex above `face` and replaces all faces that it sees by a fan.
    ///
    /// The polytope must not be full.
    ///
    /// # Errors
    /// The surface is torn and must not be used any more.
    #[inline(always)]
    pub(in crate::solver) fn insert_vertex(&mut self, point: Point, face: usize) -> Result<(), InsertError> {
        self.push(point);
        self.join_last_vertex(point.w.x, point.w.y, point.w.z, face)
    }

    #[inline(never)]
    fn join_last_vertex(&mut self, x: f64, y: f64, z: f64, face: usize) -> Result<(), InsertError> {
        let w = DVec3::new(x, y, z);
        let (removed, horizon) = self.walk_horizon(w, face)?;
        // The nearest of the faces that stay. The processor overlaps this search with the planes of
        // the new faces.
        let nearest = self.find_nearest();
        self.assign_places(removed, horizon)?;
        self.build_fan(w, horizon, nearest)
    }

    /// Steps 1 and 2. Returns the number of removed faces and the number of edges of the horizon.
    #[inline(always)]
    fn walk_horizon(&mut self, w: DVec3, face: usize) -> Result<(usize, usize), InsertError> {
        let (mut open, mut removed, mut horizon) = (3, 1, 0);
        let (mut last, mut is_broken) = (0, false);
        self.removed[0] = face as u16;
        self.offsets[face] = f64::INFINITY;
        for edge in 0..3 {
            self.open_edges[2 - edge] = (face as u16, edge as u16);
        }
        while open > 0 {
            open -= 1;
            let (here, edge) = self.open_edges[open];
            let (here, edge) = (usize::from(here), usize::from(edge));
            let next = usize::from(self.neighbours[here][edge]);
            if self.offsets[next] == f64::INFINITY {
                continue;
            }
            let from = self.corners[here][edge];
            // In the neighbour the common edge starts where it ends here.
            let to = self.corners[here][after(edge)];
            let there = self.corners[next];
            // Arithmetic instead of branches, which would be as unpredictable as random ones.
            let back = usize::from(there[1] == to) | usize::from(there[2] == to) << 1;
            let [x, y, z, seen_from] = &self.planes;
            if x[next] * w.x + y[next] * w.y + z[next] * w.z > seen_from[next] {
                self.offsets[next] = f64::INFINITY;
                if removed == F || open + 2 > F {
                    return Err(InsertError);
                }
                self.removed[removed] = next as u16;
                removed += 1;
                self.open_edges[open] = (next as u16, after(after(back)) as u16);
                self.open_edges[open + 1] = (next as u16, after(back) as u16);
                open += 2;
            } else {
                if horizon == V {
                    return Err(InsertError);
                }
                self.horizon[horizon] = HorizonEdge { from, beyond: next as u16, beyond_edge: back as u16 };
                is_broken |= (from != last) & (horizon > 0);
                horizon += 1;
                last = to;
            }
        }
        if horizon < 3 || is_broken || self.horizon[0].from != last {
            return Err(InsertError);
        }
        Ok((removed, horizon))
    }

    /// Step 3: puts the places of the new faces into `self.removed`, and frees places that are left
    /// over.
    #[inline(always)]
    fn assign_places(&mut self, removed: usize, horizon: usize) -> Result<(), InsertError> {
        let new = horizon.saturating_sub(removed);
        if removed + 2 > F || self.face_count + new > F {
            return Err(InsertError);
        }
        self.removed[removed] = self.face_count as u16;
        self.removed[removed + 1] = self.face_count as u16 + 1;
        self.set_face_count(self.face_count + new);
        for spare in horizon..removed {
            let spare = usize::from(self.removed[spare]);
            self.corners[spare] = [0; 3];
        }
        Ok(())
    }

    /// Step 4. The last vertex is at `w`, and `nearest` is the nearest of the faces that stay.
    #[inline(always)]
    fn build_fan(&mut self, w: DVec3, horizon: usize, mut nearest: usize) -> Result<(), InsertError> {
        let apex = (self.point_count - 1) as u16;
        let mut min_offset = self.offsets[nearest];
        let mut first = 0;
        let tips = [[w.x; LANES], [w.y; LANES], [w.z; LANES]];
        let mut previous = self.removed[horizon - 1];
        while first < horizon {
            let lanes = LANES.min(horizon - first);
            let mut border = [0; LANES + 1];
            for (lane, vertex) in border.iter_mut().enumerate() {
                let k = first + lane.min(lanes);
                *vertex = self.horizon[if k == horizon { 0 } else { k }].from;
            }
            let [p, q, r, s, t] = [border[0], border[1], border[2], border[3], border[4]].map(usize::from);
            let [p, q, r, s, t] =
                [self.position(p), self.position(q), self.position(r), self.position(s), self.position(t)];
            let from = [[p.x, q.x, r.x, s.x], [p.y, q.y, r.y, s.y], [p.z, q.z, r.z, s.z]];
            let to = [[q.x, r.x, s.x, t.x], [q.y, r.y, s.y, t.y], [q.z, r.z, s.z, t.z]];
            let (planes, offsets, _) = planes(tips, from, to, self.slack);
            for lane in 0..lanes {
                let place = self.removed[first + lane];
                let new = usize::from(place);
                let next = self.removed[if first + lane + 1 == horizon { 0 } else { first + lane + 1 }];
                let HorizonEdge { beyond, beyond_edge, .. } = self.horizon[first + lane];
                self.set_plane(new, [planes[0][lane], planes[1][lane], planes[2][lane], planes[3][lane]]);
                let offset = offsets[lane];
                self.offsets[new] = offset;
                // A branch would be as unpredictable as a random one.
                let is_nearer = (offset < min_offset) | ((offset == min_offset) & (new < nearest));
                nearest = select_unpredictable(is_nearer, new, nearest);
                min_offset = if offset < min_offset { offset } else { min_offset };
                // NaN takes the failing branch.
                if !offset.is_finite() {
                    return Err(InsertError);
                }
                self.corners[new] = [border[lane], border[lane + 1], apex];
                self.neighbours[new] = [beyond, next, previous];
                self.neighbours[usize::from(beyond)][usize::from(beyond_edge)] = place;
                previous = place;
            }
            first += lanes;
        }
        self.nearest = nearest;
        Ok(())
    }
}

struct Update<'p, const V: usize, const F: usize> {
    polytope: &'p mut Polytope<V, F>,
    count: usize,
    all_solid: bool,
}

impl<const V: usize, const F: usize> Pass for Update<'_, V, F> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, _: S) {
        self.all_solid = self.polytope.update(self.count);
    }
}

/// The edge, or corner, that follows.
fn after(edge: usize) -> usize {
    // A table of 1, 2, 0 with two bits per entry, from the lowest bit on. It saves a branch.
    0b00_10_01 >> (2 * edge) & 3
}

/// Planes of the counter-clockwise triangles `p q r`.
///
/// Returns the normals with the dot products above which a point sees the triangle, the signed
/// squares of the offsets (not finite for a triangle without area), and whether the volume of each
/// triangle with the origin is certainly positive.
///
/// The loop over lanes has a form that the compiler vectorises: no closure takes a whole array.
#[inline(always)]
fn planes(
    p: [[f64; LANES]; 3],
    q: [[f64; LANES]; 3],
    r: [[f64; LANES]; 3],
    slack: f64,
) -> ([[f64; LANES]; 4], [f64; LANES], [bool; LANES]) {
    let mut out = [[0.0; LANES]; 4];
    let mut offsets = [0.0; LANES];
    let mut certain = [false; LANES];
    for l in 0..LANES {
        let e = [q[0][l] - p[0][l], q[1][l] - p[1][l], q[2][l] - p[2][l]];
        let f = [r[0][l] - p[0][l], r[1][l] - p[1][l], r[2][l] - p[2][l]];
        let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let height = |x: f64, y: f64, z: f64| n[0] * x + n[1] * y + n[2] * z;
        // The plane of a sliver fits its corners badly. The innermost corner keeps the lower bound
        // valid.
        let at_p = height(p[0][l], p[1][l], p[2][l]);
        let at_q = height(q[0][l], q[1][l], q[2][l]);
        let at_r = height(r[0][l], r[1][l], r[2][l]);
        let low = if at_q < at_r { at_q } else { at_r };
        let low = if at_p < low { at_p } else { low };
        offsets[l] = low * low.abs() / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        let seen_from = low - slack * (n[0].abs() + n[1].abs() + n[2].abs());
        (out[0][l], out[1][l], out[2][l], out[3][l]) = (n[0], n[1], n[2], seen_from);
        // Upper bound of |e| |f| |p|: half the sum of two squares is at least their product, and
        // the L1 norm is at least the length.
        let edges = 0.5 * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
        // NaN takes the failing branch.
        certain[l] = low > CERTAIN * edges * (p[0][l].abs() + p[1][l].abs() + p[2][l].abs());
    }
    (out, offsets, certain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64, y: f64, z: f64) -> Point {
        Point { w: DVec3::new(x, y, z), ..Point::EMPTY }
    }

    fn tetrahedron() -> [Point; 4] {
        [vertex(1.0, 1.0, 1.0), vertex(-1.0, -1.0, 1.0), vertex(-1.0, 1.0, -1.0), vertex(1.0, -1.0, -1.0)]
    }

    /// Every edge belongs to two faces that are neighbours of each other.
    fn assert_closed<const V: usize, const F: usize>(polytope: &Polytope<V, F>) {
        for face in (0..polytope.face_count).filter(|f| polytope.offsets[*f] < f64::INFINITY) {
            for edge in 0..3 {
                let (from, to) = (polytope.corners[face][edge], polytope.corners[face][(edge + 1) % 3]);
                let next = usize::from(polytope.neighbours[face][edge]);
                let back = (0..3).find(|e| polytope.corners[next][*e] == to).unwrap();
                assert_eq!(polytope.corners[next][(back + 1) % 3], from);
                assert_eq!(usize::from(polytope.neighbours[next][back]), face);
            }
        }
    }

    #[test]
    fn tetrahedron_of_either_orientation_faces_outwards() {
        let mut mirrored = tetrahedron();
        mirrored.swap(2, 3);
        for seed in [tetrahedron(), mirrored] {
            let mut polytope = Polytope::<8, 16>::empty(1e-15);
            assert!(polytope.start(seed, 0.1));
            assert_closed(&polytope);
            assert!(polytope.encloses());
            for face in 0..4 {
                assert!((polytope.plane(face).2 - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn grows_to_a_cube_with_coplanar_faces() {
        let mut polytope = Polytope::<8, 16>::empty(1e-15);
        assert!(polytope.start(tetrahedron(), 0.1));
        for v in [vertex(-1.0, 1.0, 1.0), vertex(1.0, -1.0, 1.0), vertex(1.0, 1.0, -1.0), vertex(-1.0, -1.0, -1.0)] {
            let above = |f: &usize| polytope.plane(*f).0.dot(v.w) > polytope.planes[3][*f] + 0.1;
            let face = (0..polytope.face_count).find(above).unwrap();
            polytope.insert_vertex(v, face).unwrap();
            assert_closed(&polytope);
            assert!(polytope.check_encloses());
        }
        let live = (0..polytope.face_count).filter(|f| polytope.offsets[*f] < f64::INFINITY);
        assert_eq!(live.clone().count(), 12);
        assert!(live.into_iter().all(|f| (polytope.plane(f).2 - 1.0).abs() < 1e-15));
        assert!(polytope.is_full());
        let mut grown = Polytope::<16, 32>::empty(0.0);
        polytope.overwrite(&mut grown);
        let top = (0..grown.face_count).find(|f| grown.plane(*f).0.z > 0.9 * grown.plane(*f).1).unwrap();
        grown.insert_vertex(vertex(0.0, 0.0, 3.0), top).unwrap();
        assert_closed(&grown);
    }

    #[test]
    fn flat_tetrahedron_is_rejected() {
        let flat = [vertex(0.0, 0.0, 0.0), vertex(1.0, 0.0, 0.0), vertex(0.0, 1.0, 0.0), vertex(1.0, 1.0, 0.0)];
        assert!(!Polytope::<8, 16>::empty(1e-15).start(flat, 0.0));
    }

    #[test]
    fn surface_beside_the_origin_does_not_enclose_it() {
        let mut polytope = Polytope::<8, 16>::empty(1e-15);
        assert!(polytope.start(tetrahedron().map(|v| Point { w: v.w + DVec3::X * 3.0, ..v }), 0.1));
        assert!(!polytope.encloses());
    }

    /// Compares the lanes with planes computed one at a time, and the nearest face with a plain
    /// search.
    #[test]
    fn planes_and_nearest_face_agree_with_a_plain_loop() {
        let mut rng = shapes::rng::SplitMix64::new(11);
        let mut polytope = Polytope::<64, 128>::empty(1e-15);
        assert!(polytope.start(tetrahedron().map(|v| Point { w: v.w * 0.5, ..v }), 0.0));
        while !polytope.is_full() {
            let point = Point { w: DVec3::from_array(rng.direction()), ..Point::EMPTY };
            let above = |f: &usize| {
                let (normal, length, offset) = polytope.plane(*f);
                polytope.offsets[*f] < f64::INFINITY && normal.dot(point.w) > (offset + 1e-6) * length
            };
            let face = (0..polytope.face_count).find(above).unwrap();
            polytope.insert_vertex(point, face).unwrap();
            assert_closed(&polytope);
            let mut expected = 0;
            for face in 0..polytope.face_count {
                if polytope.offsets[face] < polytope.offsets[expected] {
                    expected = face;
                }
                if polytope.offsets[face] < f64::INFINITY {
                    let [p, q, r] = polytope.face_points(face);
                    let n = (q - p).cross(r - p).normalize();
                    let (normal, length, offset) = polytope.plane(face);
                    assert!((n - normal / length).length() < 1e-12);
                    assert!((n.dot(p) - offset).abs() < 1e-12);
                }
            }
            assert_eq!(polytope.nearest, expected);
        }
    }
}
