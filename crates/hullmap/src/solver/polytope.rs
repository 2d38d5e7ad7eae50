//! The expanding polytope: a closed surface of triangles inside the Minkowski difference.
//!
//! Computes, face by face, unit normal and offset (distance of the plane from the origin, positive when the origin is
//! behind it), and replaces the faces that a new vertex sees by a fan to that vertex.
//!
//! # Steps of [`Polytope::insert`]
//! 1. from the face the vertex was found over, flood to neighbours that see the vertex too;
//! 2. the flood's border is the horizon: it must be one closed loop that meets each vertex once;
//! 3. one new face for each edge of the horizon, in the slots of the old ones; neighbours are linked.
//!
//! Fixed size, no heap: `V` vertices, `F` = 2 V − 4 faces, which is all that a closed surface of V vertices has.

use super::barycentric::on_triangle;
use crate::minkowski::{Vertex, unit};
use glam::DVec3;

/// A vertex sees a face it is above, or below by no more than this share of the rounding: coplanar faces are
/// replaced together, so that no sliver stands on an edge the new vertex lies in line with.
const COPLANAR_ROUNDINGS: f64 = 4.0;

/// Planes whose distances from the origin differ by less than this share may be one plane: slivers' planes are rough.
const COPLANAR: f64 = 1e-9;

/// Unit normals nearer than this may be of one plane, for the same reason.
const PARALLEL: f64 = 1e-4;

/// Why a vertex could not be inserted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Refused {
    /// No room: continue in a bigger polytope.
    Full,
    /// Rounding makes what the vertex sees no disc, or a new face has no area.
    Contradiction,
}

/// An edge of the horizon: two vertices, and the face and edge beyond.
#[derive(Clone, Copy, Debug)]
struct Horizon {
    from: u8,
    to: u8,
    beyond: u16,
    beyond_edge: u8,
}

/// A closed surface of triangles.
#[derive(Clone, Debug)]
pub(super) struct Polytope<const V: usize, const F: usize> {
    vertices: [Vertex; V],
    vertex_count: usize,
    /// Counter-clockwise from outside.
    corners: [[u8; 3]; F],
    /// The face across the edge from corner i to corner i + 1.
    neighbours: [[u16; 3]; F],
    normals: [DVec3; F],
    /// Infinite for slots that hold no face.
    offsets: [f64; F],
    face_count: usize,
    /// Distances below this are none.
    slack: f64,
}

impl<const V: usize, const F: usize> Polytope<V, F> {
    /// Becomes the tetrahedron `seed`; false when one of its heights is `least_height` or less.
    pub(super) fn start(&mut self, mut seed: [Vertex; 4], least_height: f64) -> bool {
        const CORNERS: [[u8; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        const NEIGHBOURS: [[u16; 3]; 4] = [[1, 2, 3], [3, 2, 0], [1, 3, 0], [2, 1, 0]];
        let [p, q, r, s] = seed.map(|v| v.w);
        let base = (q - p).cross(r - p);
        let volume = base.dot(s - p);
        let greatest_sq = base
            .length_squared()
            .max((q - p).cross(s - p).length_squared())
            .max((r - p).cross(s - p).length_squared())
            .max((r - q).cross(s - q).length_squared());
        // NaN takes the failing branch.
        let solid = volume.abs() > least_height * greatest_sq.sqrt();
        if !solid {
            return false;
        }
        if volume > 0.0 {
            seed.swap(0, 1);
        }
        // Now s lies behind p q r.
        self.vertices[..4].copy_from_slice(&seed);
        (self.vertex_count, self.face_count) = (4, 4);
        self.neighbours[..4].copy_from_slice(&NEIGHBOURS);
        (0..4).all(|face| self.set_face(face, CORNERS[face]))
    }

    /// Room without a surface. `rounding` is what vertices may be wrong by.
    pub(super) fn empty(rounding: f64) -> Self {
        const { assert!(V <= 256 && F + 4 >= 2 * V) }
        Self {
            vertices: [Vertex::EMPTY; V],
            vertex_count: 0,
            corners: [[0; 3]; F],
            neighbours: [[0; 3]; F],
            normals: [DVec3::ZERO; F],
            offsets: [f64::INFINITY; F],
            face_count: 0,
            slack: COPLANAR_ROUNDINGS * rounding,
        }
    }

    /// The same surface with room for more.
    pub(super) fn grown<const W: usize, const G: usize>(&self) -> Polytope<W, G> {
        let mut big = Polytope::<W, G>::empty(0.0);
        big.slack = self.slack;
        big.vertices[..self.vertex_count].copy_from_slice(&self.vertices[..self.vertex_count]);
        big.vertex_count = self.vertex_count;
        let n = self.face_count;
        big.corners[..n].copy_from_slice(&self.corners[..n]);
        big.neighbours[..n].copy_from_slice(&self.neighbours[..n]);
        big.normals[..n].copy_from_slice(&self.normals[..n]);
        big.offsets[..n].copy_from_slice(&self.offsets[..n]);
        big.face_count = n;
        big
    }

    /// The face whose plane has the least offset: the lowest number of several.
    pub(super) fn nearest_face(&self) -> usize {
        let mut best = 0;
        for (face, offset) in self.offsets[..self.face_count].iter().enumerate() {
            if *offset < self.offsets[best] {
                best = face;
            }
        }
        best
    }

    /// Unit normal of a face, outwards.
    pub(super) fn normal(&self, face: usize) -> DVec3 {
        self.normals[face]
    }

    /// Distance of a face's plane from the origin; negative when the origin is outside it.
    pub(super) fn offset(&self, face: usize) -> f64 {
        self.offsets[face]
    }

    /// The corners of a face.
    pub(super) fn face_vertices(&self, face: usize) -> [Vertex; 3] {
        self.corners[face].map(|i| self.vertices[usize::from(i)])
    }

    /// Of all faces in the plane of `face`, give or take `slack`, the one with the point nearest to the origin.
    pub(super) fn face_of_foot(&self, face: usize, slack: f64) -> usize {
        let nearest = |face: usize| {
            let [p, q, r] = self.face_vertices(face).map(|v| v.w);
            on_triangle(p, q, r).point.length_squared()
        };
        let (mut best, mut best_sq) = (face, nearest(face));
        for other in 0..self.face_count {
            let same_plane = self.offsets[other] - self.offsets[face] <= slack + COPLANAR * self.offsets[face].abs()
                && self.normals[other].distance(self.normals[face]) < PARALLEL;
            if same_plane {
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
        self.vertex_count == V
    }

    /// True when a vertex with these very coordinates is there already.
    pub(super) fn has_vertex(&self, w: DVec3) -> bool {
        self.vertices[..self.vertex_count].iter().any(|v| v.w == w)
    }

    /// Adds a vertex that lies above `face`.
    ///
    /// # Errors
    /// When there is no room (the surface is unchanged), or when rounding makes the horizon no loop (it must not be
    /// used any more).
    pub(super) fn insert(&mut self, vertex: Vertex, face: usize) -> Result<(), Refused> {
        if self.vertex_count == V {
            return Err(Refused::Full);
        }
        // 1. Flood.
        let mut seen = [false; F];
        let mut stack = [0_u16; F];
        let mut removed = [0_u16; F];
        let mut horizon = [Horizon { from: 0, to: 0, beyond: 0, beyond_edge: 0 }; V];
        let (mut depth, mut removed_count, mut horizon_count) = (1, 0, 0);
        stack[0] = face as u16;
        seen[face] = true;
        while depth > 0 {
            depth -= 1;
            let at = usize::from(stack[depth]);
            removed[removed_count] = at as u16;
            removed_count += 1;
            for edge in 0..3 {
                let next = usize::from(self.neighbours[at][edge]);
                if !seen[next] && self.normals[next].dot(vertex.w) - self.offsets[next] > -self.slack {
                    seen[next] = true;
                    stack[depth] = next as u16;
                    depth += 1;
                }
            }
        }
        // 2. The horizon, and where the loop goes on from each vertex.
        let mut starts = [u16::MAX; V];
        for &at in &removed[..removed_count] {
            let at = usize::from(at);
            for edge in 0..3 {
                let beyond = self.neighbours[at][edge];
                if seen[usize::from(beyond)] {
                    continue;
                }
                let from = self.corners[at][edge];
                let to = self.corners[at][(edge + 1) % 3];
                if horizon_count == V || starts[usize::from(from)] != u16::MAX {
                    return Err(Refused::Contradiction);
                }
                let Some(beyond_edge) = self.corners[usize::from(beyond)].iter().position(|c| *c == to) else {
                    return Err(Refused::Contradiction);
                };
                starts[usize::from(from)] = horizon_count as u16;
                horizon[horizon_count] = Horizon { from, to, beyond, beyond_edge: beyond_edge as u8 };
                horizon_count += 1;
            }
        }
        if horizon_count < 3 || !is_one_loop(&horizon[..horizon_count], &starts) {
            return Err(Refused::Contradiction);
        }
        // 3. The fan: first in the freed slots, then in new ones.
        let apex = self.vertex_count as u8;
        self.vertices[self.vertex_count] = vertex;
        self.vertex_count += 1;
        let reused = removed_count.min(horizon_count);
        let first_new = self.face_count;
        if first_new + (horizon_count - reused) > F {
            return Err(Refused::Contradiction);
        }
        let slot = |k: usize| {
            if k < reused { usize::from(removed[k]) } else { first_new + k - reused }
        };
        self.face_count += horizon_count - reused;
        for &spare in &removed[reused..removed_count] {
            self.offsets[usize::from(spare)] = f64::INFINITY;
        }
        for (k, edge) in horizon[..horizon_count].iter().enumerate() {
            let new = slot(k);
            let after = starts[usize::from(edge.to)];
            if after == u16::MAX || !self.set_face(new, [edge.from, edge.to, apex]) {
                return Err(Refused::Contradiction);
            }
            let after = slot(usize::from(after));
            self.neighbours[new][0] = edge.beyond;
            self.neighbours[new][1] = after as u16;
            self.neighbours[after][2] = new as u16;
            self.neighbours[usize::from(edge.beyond)][usize::from(edge.beyond_edge)] = new as u16;
        }
        Ok(())
    }

    /// Sets corners, normal and offset; false when the face has no area.
    fn set_face(&mut self, face: usize, corners: [u8; 3]) -> bool {
        let [p, q, r] = corners.map(|i| self.vertices[usize::from(i)].w);
        let Some(normal) = unit((q - p).cross(r - p)) else {
            return false;
        };
        self.corners[face] = corners;
        self.normals[face] = normal;
        // The plane of a sliver fits its corners only roughly: the innermost keeps the bound below true.
        self.offsets[face] = normal.dot(p).min(normal.dot(q)).min(normal.dot(r));
        self.offsets[face].is_finite()
    }
}

/// Whether following `starts` from the first edge passes every edge once.
fn is_one_loop(horizon: &[Horizon], starts: &[u16]) -> bool {
    let mut at = 0;
    for step in 1..=horizon.len() {
        let next = starts[usize::from(horizon[at].to)];
        if next == u16::MAX {
            return false;
        }
        at = usize::from(next);
        if at == 0 {
            return step == horizon.len();
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64, y: f64, z: f64) -> Vertex {
        Vertex { w: DVec3::new(x, y, z), ..Vertex::EMPTY }
    }

    fn tetrahedron() -> [Vertex; 4] {
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
            let mut polytope = Polytope::<8, 12>::empty(1e-15);
            assert!(polytope.start(seed, 0.1));
            assert_closed(&polytope);
            for face in 0..4 {
                assert!((polytope.offset(face) - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn grows_to_a_cube_with_coplanar_faces() {
        let mut polytope = Polytope::<8, 12>::empty(1e-15);
        assert!(polytope.start(tetrahedron(), 0.1));
        for v in [vertex(-1.0, 1.0, 1.0), vertex(1.0, -1.0, 1.0), vertex(1.0, 1.0, -1.0), vertex(-1.0, -1.0, -1.0)] {
            let face =
                (0..polytope.face_count).find(|f| polytope.normal(*f).dot(v.w) > polytope.offset(*f) + 0.1).unwrap();
            polytope.insert(v, face).unwrap();
            assert_closed(&polytope);
        }
        let live = (0..polytope.face_count).filter(|f| polytope.offset(*f) < f64::INFINITY);
        assert_eq!(live.clone().count(), 12);
        assert!(live.into_iter().all(|f| (polytope.offset(f) - 1.0).abs() < 1e-15));
        assert_eq!(polytope.insert(vertex(0.0, 0.0, 3.0), 0), Err(Refused::Full));
        let mut grown = polytope.grown::<16, 28>();
        let top = (0..grown.face_count).find(|f| grown.normal(*f).z > 0.9).unwrap();
        grown.insert(vertex(0.0, 0.0, 3.0), top).unwrap();
        assert_closed(&grown);
    }

    #[test]
    fn a_flat_tetrahedron_is_refused() {
        let flat = [vertex(0.0, 0.0, 0.0), vertex(1.0, 0.0, 0.0), vertex(0.0, 1.0, 0.0), vertex(1.0, 1.0, 0.0)];
        assert!(!Polytope::<8, 12>::empty(1e-15).start(flat, 0.0));
    }
}
