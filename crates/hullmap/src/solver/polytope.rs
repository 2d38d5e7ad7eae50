//! The expanding polytope: a closed surface of triangles inside the Minkowski difference.
//!
//! Computes, face by face, normal and offset (distance of the plane from the origin, positive when the origin is
//! behind it), and replaces the faces that a new vertex sees by a fan to that vertex.
//!
//! # Steps of [`Polytope::insert`]
//! 1. from the face the vertex was found over, walk to neighbours that see the vertex too, around each face in order: so the
//!    border comes out in order as well;
//! 2. the border is the horizon: each of its edges must start where the one before ends;
//! 3. planes of the new faces, one for each edge of the horizon, four at a time;
//! 4. the new faces go into the slots of the old ones; neighbours are linked.
//!
//! Fixed size, no heap: `V` vertices, `F` ≥ 2 V faces, where a closed surface of V vertices has 2 V − 4.
//!
//! # What holds, whatever rounding does
//! - The surface is closed: each edge belongs to two faces that pass it in opposite directions. Step 2 sees to it.
//! - All of a face lies at or beyond its offset along its normal, up to the rounding of a dot product: the offset is the
//!   least of its corners', not one that is true only of the ideal plane.
//! - [`Polytope::encloses`] proves that the surface winds around the origin; inserting keeps it so as long as the removed
//!   faces and the new vertex are all beyond zero along the faces' normals. Then the least offset is the radius of a ball in
//!   the difference, even if the surface is not convex (see "Intervals" in docs/ARCHITECTURE.md).

use super::barycentric::on_triangle;
use crate::minkowski::Point;
use crate::simd::Level;
use glam::DVec3;
use std::hint::select_unpredictable;

/// A vertex sees a face it is above, or below by no more than this share of the noise: coplanar faces are
/// replaced together, so that no sliver stands on an edge the new vertex lies in line with.
pub(super) const COPLANAR_NOISES: f64 = 2.0;

/// Planes whose distances from the origin differ by less than this share may be one plane: slivers' planes are rough.
const COPLANAR: f64 = 1e-9;

/// Unit normals nearer than this may be of one plane, for the same reason.
const PARALLEL: f64 = 1e-4;

/// A volume's sign is certain if the volume is more than this share of the product of the three lengths it is made of.
/// Two edges, a cross and a dot product round by 10 · 2⁻⁵³ of it.
const CERTAIN: f64 = 8.0 * f64::EPSILON;

/// Planes are computed so many at a time.
const LANES: usize = 4;

/// Offsets are compared so many at a time.
const WIDE: usize = 8;

/// Up to so many, all slots are compared, in use or not: a loop of another length each time costs more.
const ALWAYS_ALL: usize = 128;

/// A vertex could not be inserted: rounding makes what it sees no disc, or a new face has no area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contradiction;

/// An edge of the horizon: the vertex it starts from, and the face and edge beyond.
#[derive(Clone, Copy, Debug)]
struct Horizon {
    from: u16,
    beyond: u16,
    beyond_edge: u16,
}

/// A closed surface of triangles.
///
/// Points and planes are kept by coordinate. One is read soon after it was written: as single numbers, both times; read as a
/// vector what was written by numbers, and the processor stalls.
#[derive(Clone, Debug)]
pub(super) struct Polytope<const V: usize, const F: usize> {
    /// Coordinates of the points of the difference: x, y, z.
    w: [[f64; V]; 3],
    a: [DVec3; V],
    features: [[u32; 2]; V],
    point_count: usize,
    /// Squares of the offsets, with the offsets' signs: no square root for faces that are never asked. Infinite for slots that
    /// hold no face.
    offsets: [f64; F],
    /// A face's normal, of any length, and the dot product with it above which a point sees the face.
    planes: [[f64; F]; 4],
    /// Counter-clockwise from outside.
    corners: [[u16; 3]; F],
    /// The face across the edge from corner i to corner i + 1.
    neighbours: [[u16; 3]; F],
    face_count: usize,
    /// The face whose plane has the least offset: the lowest number of several.
    nearest: usize,
    encloses: bool,
    level: Level,
    /// Distances below this are none.
    slack: f64,
    /// Scratch of [`insert`](Self::insert): edges yet to be crossed, faces removed, edges of the horizon.
    ahead: [(u16, u16); F],
    removed: [u16; F],
    horizon: [Horizon; V],
}

impl<const V: usize, const F: usize> Polytope<V, F> {
    /// Room without a surface. `noise` is what offsets may be wrong by.
    #[inline(always)]
    pub(super) fn empty(noise: f64) -> Self {
        const { assert!(F >= 2 * V && F.is_multiple_of(WIDE) && F <= u16::MAX as usize) }
        Self {
            w: [[0.0; V]; 3],
            a: [DVec3::ZERO; V],
            features: [[0; 2]; V],
            point_count: 0,
            offsets: [f64::INFINITY; F],
            planes: [[0.0; F]; 4],
            corners: [[0; 3]; F],
            neighbours: [[0; 3]; F],
            face_count: 0,
            nearest: 0,
            encloses: false,
            level: Level::best(),
            slack: COPLANAR_NOISES * noise,
            ahead: [(0, 0); F],
            removed: [0; F],
            horizon: [Horizon { from: 0, beyond: 0, beyond_edge: 0 }; V],
        }
    }

    /// Becomes the tetrahedron `seed`; false when one of its heights is `least_height` or less.
    pub(super) fn start(&mut self, mut seed: [Point; 4], least_height: f64) -> bool {
        const CORNERS: [[u16; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        const NEIGHBOURS: [[u16; 3]; 4] = [[1, 2, 3], [3, 2, 0], [1, 3, 0], [2, 1, 0]];
        let [p, q, r, s] = seed.map(|v| v.w);
        let (pq, pr, ps) = (q - p, r - p, s - p);
        let normals = [pq.cross(pr), pq.cross(ps), pr.cross(ps), (r - q).cross(s - q)];
        let volume = normals[0].dot(ps);
        let greatest_sq = normals.iter().fold(0.0, |most: f64, n| most.max(n.length_squared()));
        // NaN takes the failing branch.
        let solid = volume.abs() > least_height * greatest_sq.sqrt();
        if !solid {
            return false;
        }
        if volume > 0.0 {
            seed.swap(0, 1);
        }
        // Now s lies behind p q r.
        self.point_count = 0;
        seed.into_iter().for_each(|point| self.push(point));
        self.face_count = 4;
        self.corners[..4].copy_from_slice(&CORNERS);
        self.neighbours[..4].copy_from_slice(&NEIGHBOURS);
        self.update_planes(4)
    }

    /// Becomes the surface of `corners` and `neighbours` over `points`, which were such once, under another pose. Slots whose corners
    /// are one vertex hold no face. False when it does not fit or a face has no area.
    pub(super) fn restore(
        &mut self,
        points: impl Iterator<Item = Option<Point>>,
        faces: impl ExactSizeIterator<Item = ([u16; 3], [u16; 3])>,
    ) -> bool {
        self.point_count = 0;
        for point in points {
            let (Some(point), true) = (point, self.point_count < V) else { return false };
            self.push(point);
        }
        if faces.len() > F {
            return false;
        }
        self.face_count = faces.len();
        for (face, (corners, neighbours)) in faces.enumerate() {
            (self.corners[face], self.neighbours[face]) = (corners, neighbours);
        }
        self.update_planes(self.face_count)
    }

    /// Computes planes and offsets of the first `count` faces from their corners; false when one has no area.
    fn update_planes(&mut self, count: usize) -> bool {
        let mut all_solid = true;
        let mut encloses = true;
        for at in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - at);
            let [c, d, e, f] = [0, 1, 2, 3].map(|lane: usize| self.corners[at + lane.min(lanes - 1)]);
            let w = |i: u16| self.at(usize::from(i));
            let across = |k: usize| {
                let [p, q, r, s] = [w(c[k]), w(d[k]), w(e[k]), w(f[k])];
                [[p.x, q.x, r.x, s.x], [p.y, q.y, r.y, s.y], [p.z, q.z, r.z, s.z]]
            };
            let (planes, offsets, certain) = planes(across(0), across(1), across(2), self.slack);
            for lane in 0..lanes {
                let face = at + lane;
                if self.is_spare(face) {
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
        self.nearest = self.least_offset();
        all_solid
    }

    fn is_spare(&self, face: usize) -> bool {
        self.corners[face][0] == self.corners[face][1]
    }

    /// The same surface with room for more.
    #[inline(always)]
    pub(super) fn grown<const W: usize, const G: usize>(&self) -> Polytope<W, G> {
        let mut big = Polytope::<W, G>::empty(0.0);
        big.slack = self.slack;
        for axis in 0..3 {
            big.w[axis][..self.point_count].copy_from_slice(&self.w[axis][..self.point_count]);
        }
        big.a[..self.point_count].copy_from_slice(&self.a[..self.point_count]);
        big.features[..self.point_count].copy_from_slice(&self.features[..self.point_count]);
        big.point_count = self.point_count;
        let n = self.face_count;
        big.corners[..n].copy_from_slice(&self.corners[..n]);
        big.neighbours[..n].copy_from_slice(&self.neighbours[..n]);
        for (big, small) in big.planes.iter_mut().zip(&self.planes) {
            big[..n].copy_from_slice(&small[..n]);
        }
        big.offsets[..n].copy_from_slice(&self.offsets[..n]);
        big.face_count = n;
        big.nearest = self.nearest;
        big
    }

    /// Whether the surface was certain to wind around the origin when it was started or restored: seen from there, every
    /// face turns the same way, so that the solid angles add up to a whole sphere or more.
    pub(super) fn encloses(&self) -> bool {
        self.encloses
    }

    /// The same of the surface as it is now.
    #[cold]
    pub(super) fn check_encloses(&mut self) -> bool {
        self.update_planes(self.face_count);
        self.encloses
    }

    /// The face whose plane has the least offset: the lowest number of several.
    #[inline]
    pub(super) fn nearest_face(&self) -> usize {
        self.nearest
    }

    #[inline(always)]
    fn least_offset(&self) -> usize {
        // The same number of chunks each time, where it is small: nothing to predict.
        let used = if F <= ALWAYS_ALL { F } else { self.face_count.next_multiple_of(WIDE).min(F) };
        self.level.least(self.offsets[..used].as_chunks::<WIDE>().0)
    }

    #[inline(always)]
    fn at(&self, number: usize) -> DVec3 {
        DVec3::new(self.w[0][number], self.w[1][number], self.w[2][number])
    }

    /// Adds a vertex without faces; there must be room.
    #[inline(always)]
    fn push(&mut self, point: Point) {
        let number = self.point_count;
        (self.w[0][number], self.w[1][number], self.w[2][number]) = (point.w.x, point.w.y, point.w.z);
        self.a[number] = point.a;
        self.features[number] = point.features;
        self.point_count += 1;
    }

    #[inline(always)]
    fn set_plane(&mut self, face: usize, [x, y, z, seen_from]: [f64; 4]) {
        self.planes[0][face] = x;
        self.planes[1][face] = y;
        self.planes[2][face] = z;
        self.planes[3][face] = seen_from;
    }

    /// Normal of a face, outwards, of any length, that length, and the face's offset.
    #[inline]
    pub(super) fn plane(&self, face: usize) -> (DVec3, f64, f64) {
        let normal = DVec3::new(self.planes[0][face], self.planes[1][face], self.planes[2][face]);
        let offset_sq = self.offsets[face];
        (normal, normal.length(), offset_sq.abs().sqrt().copysign(offset_sq))
    }

    /// The numbers of the corners of a face.
    pub(super) fn corners(&self, face: usize) -> [u16; 3] {
        self.corners[face]
    }

    /// The vertex with this number.
    pub(super) fn point(&self, number: u16) -> Point {
        let number = usize::from(number);
        Point { w: self.at(number), a: self.a[number], features: self.features[number] }
    }

    /// How many vertices there are, also those that are inside by now.
    pub(super) fn point_count(&self) -> usize {
        self.point_count
    }

    /// The features that make the vertices.
    pub(super) fn features(&self) -> &[[u32; 2]] {
        &self.features[..self.point_count]
    }

    /// Corners and neighbours of all slots; the corners of a slot that holds no face are one vertex.
    pub(super) fn faces(&self) -> (&[[u16; 3]], &[[u16; 3]]) {
        (&self.corners[..self.face_count], &self.neighbours[..self.face_count])
    }

    fn face_points(&self, face: usize) -> [DVec3; 3] {
        self.corners[face].map(|i| self.at(usize::from(i)))
    }

    /// Of all faces in the plane of `face`, give or take `slack`, the one with the point nearest to the origin.
    pub(super) fn face_of_foot(&self, face: usize, slack: f64) -> usize {
        let nearest = |face: usize| {
            let [p, q, r] = self.face_points(face);
            on_triangle(p, q, r).point.length_squared()
        };
        let (normal, length, offset) = self.plane(face);
        let (mut best, mut best_sq) = (face, nearest(face));
        // Usually the foot is in the face itself.
        let most = offset.abs() * (1.0 + COPLANAR) + slack;
        if best_sq <= most * most {
            return best;
        }
        for other in 0..self.face_count {
            if self.offsets[other] > most * most {
                continue;
            }
            let (other_normal, other_length, _) = self.plane(other);
            if (other_normal / other_length).distance(normal / length) < PARALLEL {
                let other_sq = nearest(other);
                if other_sq < best_sq {
                    (best, best_sq) = (other, other_sq);
                }
            }
        }
        best
    }

    /// True when there is no room for another vertex.
    pub(super) fn is_full(&self) -> bool {
        self.point_count == V
    }

    /// Adds a vertex that lies above `face`. There must be room.
    ///
    /// # Errors
    /// When rounding makes the horizon no loop; the surface must not be used any more.
    #[inline(always)]
    pub(super) fn insert(&mut self, point: Point, face: usize) -> Result<(), Contradiction> {
        self.push(point);
        self.join(point.w.x, point.w.y, point.w.z, face)
    }

    /// Joins the last vertex to the surface. It comes as three numbers, in registers.
    #[inline(never)]
    fn join(&mut self, x: f64, y: f64, z: f64, face: usize) -> Result<(), Contradiction> {
        let w = DVec3::new(x, y, z);
        // 1. Walk; 2. each edge of the horizon starts where the one before it ends.
        let (mut ahead, mut removed, mut horizon) = (3, 1, 0);
        let (mut last, mut is_broken) = (0, false);
        self.removed[0] = face as u16;
        self.offsets[face] = f64::INFINITY;
        for edge in 0..3 {
            self.ahead[2 - edge] = (face as u16, edge as u16);
        }
        while ahead > 0 {
            ahead -= 1;
            let (at, edge) = self.ahead[ahead];
            let (at, edge) = (usize::from(at), usize::from(edge));
            let next = usize::from(self.neighbours[at][edge]);
            if self.offsets[next] == f64::INFINITY {
                continue;
            }
            let from = self.corners[at][edge];
            // The edge that the two share starts, in the neighbour, where it ends here.
            let to = self.corners[at][after(edge)];
            let there = self.corners[next];
            // Not branches, as they are as good as random.
            let back = usize::from(there[1] == to) | usize::from(there[2] == to) << 1;
            let [x, y, z, seen_from] = &self.planes;
            if x[next] * w.x + y[next] * w.y + z[next] * w.z > seen_from[next] {
                self.offsets[next] = f64::INFINITY;
                if removed == F || ahead + 2 > F {
                    return Err(Contradiction);
                }
                self.removed[removed] = next as u16;
                removed += 1;
                self.ahead[ahead] = (next as u16, after(after(back)) as u16);
                self.ahead[ahead + 1] = (next as u16, after(back) as u16);
                ahead += 2;
            } else {
                if horizon == V {
                    return Err(Contradiction);
                }
                self.horizon[horizon] = Horizon { from, beyond: next as u16, beyond_edge: back as u16 };
                is_broken |= (from != last) & (horizon > 0);
                horizon += 1;
                last = to;
            }
        }
        if horizon < 3 || is_broken || self.horizon[0].from != last {
            return Err(Contradiction);
        }
        let apex = (self.point_count - 1) as u16;
        // Of the faces that stay, while the planes of the new ones are computed.
        let mut nearest = self.least_offset();
        let mut least = self.offsets[nearest];
        // 4. Slots: the freed ones, then new ones, of which a horizon needs two at most.
        let new = horizon.saturating_sub(removed);
        if removed + 2 > F || self.face_count + new > F {
            return Err(Contradiction);
        }
        self.removed[removed] = self.face_count as u16;
        self.removed[removed + 1] = self.face_count as u16 + 1;
        self.face_count += new;
        for spare in horizon..removed {
            let spare = usize::from(self.removed[spare]);
            self.corners[spare] = [0; 3];
        }
        // 3. Planes.
        let mut at = 0;
        let tips = [[w.x; LANES], [w.y; LANES], [w.z; LANES]];
        let mut previous = self.removed[horizon - 1];
        while at < horizon {
            let lanes = LANES.min(horizon - at);
            let mut rim = [0; LANES + 1];
            for (lane, number) in rim.iter_mut().enumerate() {
                let k = at + lane.min(lanes);
                *number = self.horizon[if k == horizon { 0 } else { k }].from;
            }
            let [p, q, r, s, t] = [rim[0], rim[1], rim[2], rim[3], rim[4]].map(usize::from);
            let [p, q, r, s, t] = [self.at(p), self.at(q), self.at(r), self.at(s), self.at(t)];
            let from = [[p.x, q.x, r.x, s.x], [p.y, q.y, r.y, s.y], [p.z, q.z, r.z, s.z]];
            let to = [[q.x, r.x, s.x, t.x], [q.y, r.y, s.y, t.y], [q.z, r.z, s.z, t.z]];
            let (planes, offsets, _) = planes(tips, from, to, self.slack);
            for lane in 0..lanes {
                let number = self.removed[at + lane];
                let new = usize::from(number);
                let next = self.removed[if at + lane + 1 == horizon { 0 } else { at + lane + 1 }];
                let Horizon { beyond, beyond_edge, .. } = self.horizon[at + lane];
                self.set_plane(new, [planes[0][lane], planes[1][lane], planes[2][lane], planes[3][lane]]);
                let offset = offsets[lane];
                self.offsets[new] = offset;
                // Not a branch, as it is as good as random.
                let is_nearer = (offset < least) | ((offset == least) & (new < nearest));
                nearest = select_unpredictable(is_nearer, new, nearest);
                least = if offset < least { offset } else { least };
                // NaN takes the failing branch.
                if !offset.is_finite() {
                    return Err(Contradiction);
                }
                self.corners[new] = [rim[lane], rim[lane + 1], apex];
                self.neighbours[new] = [beyond, next, previous];
                self.neighbours[usize::from(beyond)][usize::from(beyond_edge)] = number;
                previous = number;
            }
            at += lanes;
        }
        self.nearest = nearest;
        Ok(())
    }
}

/// The edge, or corner, after this one.
fn after(edge: usize) -> usize {
    // 1, 2, 0 in two bits each, from the lowest on: not a branch.
    0b00_10_01 >> (2 * edge) & 3
}

/// Planes of triangles `p q r`, counter-clockwise, each as normal and the height from which it is seen; then their offsets squared, with their
/// signs, not finite where there is no area; and whether the volume of the triangle and the origin is certain to be
/// positive.
///
/// Written lane by lane so that the compiler finds the vectors.
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
        let height = |v: [[f64; LANES]; 3]| n[0] * v[0][l] + n[1] * v[1][l] + n[2] * v[2][l];
        // The plane of a sliver fits its corners only roughly: the innermost keeps the bound below true.
        let (at_p, at_q, at_r) = (height(p), height(q), height(r));
        let low = if at_q < at_r { at_q } else { at_r };
        let low = if at_p < low { at_p } else { low };
        offsets[l] = low * low.abs() / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        let seen_from = low - slack * (n[0].abs() + n[1].abs() + n[2].abs());
        (out[0][l], out[1][l], out[2][l], out[3][l]) = (n[0], n[1], n[2], seen_from);
        // Half the sum of two squares is no less than the product, nor the sum of coordinates than the length.
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

    /// Every edge is shared by two faces that name each other.
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
    fn a_tetrahedron_of_either_hand_faces_outwards() {
        let mut other_hand = tetrahedron();
        other_hand.swap(2, 3);
        for seed in [tetrahedron(), other_hand] {
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
            polytope.insert(v, face).unwrap();
            assert_closed(&polytope);
            assert!(polytope.check_encloses());
        }
        let live = (0..polytope.face_count).filter(|f| polytope.offsets[*f] < f64::INFINITY);
        assert_eq!(live.clone().count(), 12);
        assert!(live.into_iter().all(|f| (polytope.plane(f).2 - 1.0).abs() < 1e-15));
        assert!(polytope.is_full());
        let mut grown = polytope.grown::<16, 32>();
        let top = (0..grown.face_count).find(|f| grown.plane(*f).0.z > 0.9 * grown.plane(*f).1).unwrap();
        grown.insert(vertex(0.0, 0.0, 3.0), top).unwrap();
        assert_closed(&grown);
    }

    #[test]
    fn a_flat_tetrahedron_is_refused() {
        let flat = [vertex(0.0, 0.0, 0.0), vertex(1.0, 0.0, 0.0), vertex(0.0, 1.0, 0.0), vertex(1.0, 1.0, 0.0)];
        assert!(!Polytope::<8, 16>::empty(1e-15).start(flat, 0.0));
    }

    #[test]
    fn a_surface_beside_the_origin_does_not_enclose_it() {
        let mut polytope = Polytope::<8, 16>::empty(1e-15);
        assert!(polytope.start(tetrahedron().map(|v| Point { w: v.w + DVec3::X * 3.0, ..v }), 0.1));
        assert!(!polytope.encloses());
    }

    /// The lanes against one plane at a time, and the least offset against a plain search.
    #[test]
    fn planes_and_nearest_face_are_what_a_plain_loop_says() {
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
            polytope.insert(point, face).unwrap();
            assert_closed(&polytope);
            let mut least = 0;
            for face in 0..polytope.face_count {
                if polytope.offsets[face] < polytope.offsets[least] {
                    least = face;
                }
                if polytope.offsets[face] < f64::INFINITY {
                    let [p, q, r] = polytope.face_points(face);
                    let n = (q - p).cross(r - p).normalize();
                    let (normal, length, offset) = polytope.plane(face);
                    assert!((n - normal / length).length() < 1e-12);
                    assert!((n.dot(p) - offset).abs() < 1e-12);
                }
            }
            assert_eq!(polytope.nearest_face(), least);
        }
    }
}
