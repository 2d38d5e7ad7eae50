//! Gauss map of a hull: the normal cone of each vertex, that is the set of directions in which it
//! is the support vertex.
//!
//! The cones tile the sphere. A cone's corners are the normals of the faces at the vertex, and its
//! sides are the arcs between them, at right angles to the edges of the hull. Two cones have
//! bitwise equal ends of a common arc, so that no direction falls between them.
//!
//! An arc longer than a right angle gets an additional corner. Interpolation along it would lose
//! digits, and would lose all of them on a hull as thin as [`crate::hull::rank::FLAT`] allows.
//!
//! The cone at a corner of a polygon (rank 2) contains a whole line: the polygon's normal and its
//! opposite. It is not a polygon on the sphere, and is stored as two pieces, one per side.

use glam::DVec3;

use crate::hull::{
    Hull,
    area::{accurate_cross, area_vector},
    edges,
    polygon::side_normal,
};

/// How far beyond the border of a cube's face a piece may be to count as near. It is far more than
/// the overlap of cells, which is far more than rounding error.
const FAR: f64 = 1e-3;

/// The normal cones of a hull of rank 2 or 3, as convex spherical polygons smaller than a
/// hemisphere.
pub struct GaussMap {
    /// For each piece of a cone, its vertex (ascending) and the end of its corners.
    pieces: Vec<(u32, u32)>,
    /// For each piece, a bit for each face of the cube that it may meet.
    near: Vec<u8>,
    /// Indices of directions.
    corners: Vec<u32>,
    /// The normals of the faces, then the additional corners.
    directions: Vec<DVec3>,
    neighbour_starts: Vec<u32>,
    neighbours: Vec<u32>,
    positions: Vec<DVec3>,
}

struct Corner {
    at: u32,
    after: u32,
    before: u32,
    face: u32,
}

impl GaussMap {
    /// Computes the normal cones of `hull`, whose rank must be 2 or 3.
    ///
    /// # Complexity
    /// O(n log n).
    pub fn new(hull: &Hull) -> Self {
        let positions = hull.positions();
        let mut all: Vec<Corner> = Vec::with_capacity(hull.faces.iter().map(Vec::len).sum());
        for (face, outline) in hull.faces.iter().enumerate() {
            let before = outline.iter().cycle().skip(outline.len() - 1);
            for ((at, after), &before) in edges(outline).zip(before) {
                all.push(Corner { at, after, before, face: face as u32 });
            }
        }
        all.sort_unstable_by_key(|c| u64::from(c.at) << 32 | u64::from(c.after));
        let mut map = Self {
            pieces: Vec::with_capacity(positions.len()),
            near: Vec::with_capacity(positions.len()),
            corners: Vec::with_capacity(all.len()),
            directions: hull.faces.iter().map(|face| facet_normal(face, &positions)).collect(),
            neighbour_starts: Vec::with_capacity(positions.len() + 1),
            neighbours: Vec::with_capacity(all.len()),
            positions,
        };
        map.neighbour_starts.push(0);
        for around in all.chunk_by(|a, b| a.at == b.at) {
            if hull.rank == 2 {
                map.push_lune(around);
            } else {
                map.push_cone(around);
            }
            map.neighbours.extend(around.iter().map(|c| c.after));
            map.neighbour_starts.push(map.neighbours.len() as u32);
        }
        map
    }

    /// Adds a corner that is not the normal of a face.
    fn push_direction(&mut self, direction: DVec3) {
        self.corners.push(self.directions.len() as u32);
        self.directions.push(direction);
    }

    /// Adds the two pieces of the cone at a polygon's corner. Each piece spans one side's normal
    /// and the outward normals of both edges.
    fn push_lune(&mut self, around: &[Corner]) {
        for corner in around {
            let up = self.directions[corner.face as usize];
            let at = self.positions[corner.at as usize];
            let outward = |edge: DVec3| side_normal(edge, up);
            let before = outward(at - self.positions[corner.before as usize]);
            let after = outward(self.positions[corner.after as usize] - at);
            // The outward normal may turn by almost half a circle from one edge to the next.
            let between = up.cross(before);
            let middle = (before.dot(after) < 0.0).then_some(between);
            self.corners.push(corner.face);
            [before].into_iter().chain(middle).chain([after]).for_each(|direction| self.push_direction(direction));
            self.end_piece(corner.at);
        }
    }

    /// Adds the cone of a vertex, given its face corners, sorted by the vertex after each.
    fn push_cone(&mut self, around: &[Corner]) {
        let mut corner = &around[0];
        for _ in 0..around.len() {
            // Counter-clockwise, the next face lies across the edge to the vertex before this one.
            let across = corner.before;
            let next = around.binary_search_by_key(&across, |c| c.after).map_or(corner, |i| &around[i]);
            let (from, to) = (self.directions[corner.face as usize], self.directions[next.face as usize]);
            self.corners.push(corner.face);
            if from.dot(to) < 0.0 {
                // Points out of the face, across its edge from `across` to this vertex.
                let edge = self.positions[corner.at as usize] - self.positions[across as usize];
                self.push_direction(accurate_cross(edge, from).normalize());
            }
            corner = next;
        }
        self.end_piece(around[0].at);
    }

    fn end_piece(&mut self, vertex: u32) {
        let start = self.pieces.last().map_or(0, |(_, end)| *end as usize);
        let corners = self.corners[start..].iter().map(|corner| self.directions[*corner as usize]);
        // For each axis, the maximum of the coordinate minus, and plus, each of the two others: the
        // heights over the planes between the cube's faces.
        let mut heights = [[f64::NEG_INFINITY; 4]; 6];
        for d in corners {
            for (face, heights) in heights.iter_mut().enumerate() {
                let axis = face / 2;
                let towards = if face % 2 == 0 { d[axis] } else { -d[axis] };
                let [u, v] = [d[(axis + 1) % 3], d[(axis + 2) % 3]];
                for (height, side) in heights.iter_mut().zip([-u, u, -v, v]) {
                    *height = height.max(towards + side);
                }
            }
        }
        let meets = |heights: &[f64; 4]| heights.iter().all(|height| *height > -FAR);
        self.near.push((0..6).filter(|face| meets(&heights[*face])).map(|face| 1 << face).sum());
        self.pieces.push((vertex, self.corners.len() as u32));
    }

    /// Number of vertices. Each has a cone.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Calls `visit` with each piece of a cone that may meet a face of the cube, in ascending order
    /// of their vertices: the vertex, and the piece's corners in order, as unit vectors.
    pub fn for_each_piece_near(&self, face: u32, mut visit: impl FnMut(u32, &[DVec3])) {
        let mut piece = Vec::new();
        let mut start = 0;
        for (&(vertex, end), near) in self.pieces.iter().zip(&self.near) {
            if near >> face & 1 == 1 {
                piece.clear();
                let corners = &self.corners[start..end as usize];
                piece.extend(corners.iter().map(|corner| self.directions[*corner as usize]));
                visit(vertex, &piece);
            }
            start = end as usize;
        }
    }

    /// Position of a vertex.
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// Vertices that share an edge with `vertex`, ascending.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|next| self.neighbour_starts[vertex as usize + next] as usize);
        &self.neighbours[start..end]
    }

    /// Normal of the plane between the cones of two neighbours, with `vertex` in front.
    pub fn plane_between(&self, vertex: u32, neighbour: u32) -> DVec3 {
        (self.positions[vertex as usize] - self.positions[neighbour as usize]).normalize()
    }
}

/// Unit outward normal of a face. All corners contribute, because a polygon of rank 2 may deviate
/// from its plane by as much as [`crate::hull::rank::FLAT`].
fn facet_normal(face: &[u32], positions: &[DVec3]) -> DVec3 {
    area_vector(face, positions).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::hull_of;

    fn map(positions: Vec<[f32; 3]>) -> (Hull, GaussMap) {
        let hull = hull_of(positions);
        let map = GaussMap::new(&hull);
        (hull, map)
    }

    /// Checks that the vertex is a support vertex in the directions of its cone's corners.
    fn check(hull: &Hull, map: &GaussMap) {
        let positions = hull.positions();
        assert_eq!(map.vertex_count(), positions.len());
        for_each_piece(map, |v, piece| {
            assert!(piece.len() >= 3);
            for corner in piece {
                let best = positions.iter().map(|p| p.dot(*corner)).fold(f64::NEG_INFINITY, f64::max);
                assert!(best - positions[v as usize].dot(*corner) <= 1e-13 * hull.diameter, "vertex {v}");
            }
        });
    }

    fn for_each_piece(map: &GaussMap, mut visit: impl FnMut(u32, &[DVec3])) {
        let mut start = 0;
        for &(vertex, end) in &map.pieces {
            let corners = &map.corners[start..end as usize];
            visit(vertex, &corners.iter().map(|corner| map.directions[*corner as usize]).collect::<Vec<_>>());
            start = end as usize;
        }
    }

    fn sizes(map: &GaussMap) -> Vec<usize> {
        let mut sizes = Vec::new();
        for_each_piece(map, |_, piece| sizes.push(piece.len()));
        sizes
    }

    #[test]
    fn skipped_pieces_do_not_meet_the_face() {
        for family in shapes::families::Family::ALL {
            let (hull, map) = map(family.points(300, 4));
            if hull.rank < 2 {
                continue;
            }
            for face in 0..6 {
                let axis = face as usize / 2;
                let sign = if face % 2 == 0 { 1.0 } else { -1.0 };
                let mut near = Vec::new();
                map.for_each_piece_near(face, |v, piece| near.push((v, piece.to_vec())));
                let mut all = Vec::new();
                for_each_piece(&map, |v, piece| all.push((v, piece.to_vec())));
                assert!(near.iter().all(|piece| all.contains(piece)));
                all.retain(|piece| !near.contains(piece));
                // A mean of the corners with any weights lies in the piece.
                for (v, piece) in all {
                    for at in 0..piece.len() {
                        for share in [0.0, 0.1, 0.5] {
                            let mean = piece.iter().sum::<DVec3>() / piece.len() as f64;
                            let d = piece[at].lerp(piece[(at + 1) % piece.len()], share).lerp(mean, share);
                            let others = [1, 2].map(|next| d[(axis + next) % 3].abs());
                            assert!(sign * d[axis] < others[0].max(others[1]), "{family:?} {face} {v}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn corners_are_where_vertices_tie() {
        for family in [shapes::families::sphere, shapes::families::lens, shapes::families::prism] {
            let (hull, map) = map(family(200, 3));
            check(&hull, &map);
            assert_eq!(sizes(&map).len(), hull.vertices.len());
            let joined = |v: u32, w: u32| hull.faces.iter().flat_map(|f| edges(f)).any(|e| e == (v, w));
            for v in 0..hull.vertices.len() as u32 {
                assert!(map.neighbours(v).iter().all(|&w| joined(v, w)) && map.neighbours(v).len() >= 3);
            }
        }
    }

    #[test]
    fn a_polygon_has_two_pieces_per_corner() {
        let (hull, map) = map(vec![[0., 0., 1.], [1., 0., 1.], [0., 1., 1.], [1., 1., 1.], [0.5, 1.25, 1.]]);
        assert_eq!(hull.rank, 2);
        check(&hull, &map);
        assert_eq!(sizes(&map).len(), 10);
        let (_, sharp) = super::tests::map(vec![[0., 0., 0.], [9., 0.1, 0.], [9., -0.1, 0.]]);
        assert_eq!(sizes(&sharp).first(), Some(&4), "up, side, between, side");
    }
}
