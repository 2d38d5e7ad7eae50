//! Triangulated surface of a convex polytope, to which outside points can be added (incremental
//! hull). Exact predicates decide, as in [`hull::quickhull`](crate::hull::quickhull), so that it
//! stays convex.

use glam::DVec3;

use crate::hull::{
    Hull,
    area::{area_vector_from, triangle_area_vector},
    quickhull::exact_above,
};

const NONE: u32 = u32::MAX;

/// Triangulated surface of a convex polytope.
pub struct Surface {
    points: Vec<DVec3>,
    triangles: Vec<Triangle>,
    /// Normal of each triangle. Stored, because it costs as much as a step of a search.
    normals: Vec<Normal>,
    free: Vec<u32>,
    /// One triangle at each vertex; `NONE` for a deleted vertex.
    at: Vec<u32>,
    live: usize,
    changes: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Triangle {
    /// Counter-clockwise seen from outside.
    corners: [u32; 3],
    /// Triangle across the edge from corner `i` to corner `i + 1`.
    across: [u32; 3],
}

#[derive(Clone, Copy)]
struct Normal {
    unit: DVec3,
    /// Whether its last digits depend on which corner comes first.
    depends_on_first: bool,
}

impl Normal {
    fn new(corners: [DVec3; 3]) -> Self {
        let (area, depends_on_first) = area_vector_from(corners);
        Self { unit: area.normalize_or_zero(), depends_on_first }
    }
}

impl Surface {
    /// The surface of solid `hull`, triangulated in a zigzag so that no vertex gains many edges.
    pub fn new(hull: &Hull) -> Self {
        let points = hull.positions();
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for face in &hull.faces {
            let (mut first, mut last) = (0, face.len() - 1);
            while last - first >= 2 {
                let next = if (last - first).is_multiple_of(2) { first + 1 } else { last - 1 };
                corners.push([face[first], face[next], face[last]]);
                *(if next == first + 1 { &mut first } else { &mut last }) = next;
            }
        }
        let mut sides: Vec<(u32, u32, u32, usize)> = corners
            .iter()
            .enumerate()
            .flat_map(|(index, c)| (0..3).map(move |i| (c[i], c[(i + 1) % 3], index as u32, i)))
            .collect();
        sides.sort_unstable();
        let mut triangles: Vec<Triangle> =
            corners.iter().map(|c| Triangle { corners: *c, across: [NONE; 3] }).collect();
        let mut at = vec![NONE; points.len()];
        for &(from, to, index, i) in &sides {
            let other = sides.binary_search_by_key(&(to, from), |side| (side.0, side.1));
            let other = other.expect("a hull's faces are a closed surface");
            triangles[index as usize].across[i] = sides[other].2;
            at[from as usize] = index;
        }
        let (live, changes) = (points.len(), vec![0; points.len()]);
        let normals = normals(&triangles, &points);
        Self { points, triangles, normals, free: Vec::new(), at, live, changes }
    }

    /// The surface of a tetrahedron with these corners, which must not be coplanar. Two corners are
    /// swapped if that is required to orient the surface outward.
    pub fn tetrahedron(points: [DVec3; 4]) -> Self {
        let [a, b, c, d] = points;
        let points = if exact_above(a, b, c, d) < 0.0 { vec![a, b, c, d] } else { vec![a, c, b, d] };
        let triangles =
            [([0, 1, 2], [3, 1, 2]), ([2, 1, 3], [0, 3, 2]), ([0, 2, 3], [0, 1, 3]), ([1, 0, 3], [0, 2, 1])];
        let triangles = triangles.map(|(corners, across)| Triangle { corners, across }).to_vec();
        let normals = normals(&triangles, &points);
        Self { points, triangles, normals, free: Vec::new(), at: vec![0, 0, 0, 1], live: 4, changes: vec![0; 4] }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.live
    }

    /// Indices and positions of all vertices.
    pub fn vertices(&self) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        let is_there = |(index, _): &(usize, &DVec3)| self.at[*index] != NONE;
        self.points.iter().enumerate().filter(is_there).map(|(index, p)| (index as u32, *p))
    }

    /// Position of a vertex.
    pub fn point(&self, vertex: u32) -> DVec3 {
        self.points[vertex as usize]
    }

    /// Whether the vertex still exists.
    pub fn is_there(&self, vertex: u32) -> bool {
        self.at[vertex as usize] != NONE
    }

    /// Number of times that the triangles at a vertex have changed.
    pub fn changes(&self, vertex: u32) -> u32 {
        self.changes[vertex as usize]
    }

    /// The triangles at a vertex, clockwise, each given by its other two corners in order.
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.fan(vertex).map(|(_, others)| others)
    }

    fn fan(&self, vertex: u32) -> impl Iterator<Item = (u32, [u32; 2])> + '_ {
        let first = self.at[vertex as usize];
        let mut next = first;
        std::iter::from_fn(move || {
            if next == NONE {
                return None;
            }
            let index = next;
            let triangle = &self.triangles[index as usize];
            let [a, b, c] = triangle.corners;
            let (i, others) = if a == vertex {
                (0, [b, c])
            } else if b == vertex {
                (1, [c, a])
            } else {
                (2, [a, b])
            };
            next = triangle.across[i];
            if next == first {
                next = NONE;
            }
            Some((index, others))
        })
    }

    /// Normals of the triangles at a vertex, in the order of [`around`](Self::around), as
    /// [`normal`](Self::normal) computes them with the vertex first.
    pub fn normals_around(&self, vertex: u32) -> impl Iterator<Item = DVec3> + '_ {
        self.fan(vertex).map(move |(index, [b, c])| {
            let normal = self.normals[index as usize];
            let is_stored = !normal.depends_on_first || self.triangles[index as usize].corners[0] == vertex;
            if is_stored { normal.unit } else { self.normal([vertex, b, c]) }
        })
    }

    /// A triangle at an existing vertex.
    pub fn triangle_at(&self, vertex: u32) -> u32 {
        self.at[vertex as usize]
    }

    /// Indices of the triangles at a vertex.
    pub fn triangles_at(&self, vertex: u32) -> Vec<u32> {
        let first = self.at[vertex as usize];
        let mut all = vec![first];
        loop {
            let triangle = &self.triangles[all[all.len() - 1] as usize];
            let i = triangle.corners.iter().position(|c| *c == vertex).expect("a triangle at a vertex has it");
            if triangle.across[i] == first {
                return all;
            }
            all.push(triangle.across[i]);
        }
    }

    /// Corners of a triangle, counter-clockwise seen from outside. Its place may be reused.
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize].corners
    }

    /// Unit outward normal of the triangle of three vertices; zero if the triangle is degenerate.
    pub fn normal(&self, [a, b, c]: [u32; 3]) -> DVec3 {
        triangle_area_vector([a, b, c].map(|v| self.point(v))).normalize_or_zero()
    }

    /// Unit outward normal of a triangle; zero if it is degenerate.
    pub fn normal_of(&self, triangle: u32) -> DVec3 {
        self.normals[triangle as usize].unit
    }

    /// Whether `p` lies strictly outside all triangles at `vertex`. Exact.
    pub fn sees_all_around(&self, p: DVec3, vertex: u32) -> bool {
        self.around(vertex).all(|[b, c]| self.is_above(p, [vertex, b, c]))
    }

    fn is_above(&self, p: DVec3, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|v| self.point(v));
        exact_above(a, b, c, p) > 0.0
    }

    /// Moves a vertex if the surface stays convex. Otherwise, returns false and changes nothing.
    /// Exact.
    pub fn try_move(&mut self, vertex: u32, to: DVec3) -> bool {
        let before = std::mem::replace(&mut self.points[vertex as usize], to);
        let first = self.at[vertex as usize];
        let mut next = first;
        let convex = loop {
            let triangle = self.triangles[next as usize];
            let i = triangle.corners.iter().position(|c| *c == vertex).expect("a triangle at a vertex has it");
            // Test the edge from the vertex, and the edge opposite it.
            let is_bent = |side: usize| {
                let other = self.triangles[triangle.across[side] as usize];
                let [from, to] = [triangle.corners[side], triangle.corners[(side + 1) % 3]];
                let far = other.corners.into_iter().find(|c| *c != from && *c != to).expect("a third corner");
                let [a, b, c] = triangle.corners.map(|v| self.point(v));
                exact_above(a, b, c, self.point(far)) < 0.0
            };
            if !is_bent(i) || !is_bent((i + 1) % 3) {
                break false;
            }
            next = triangle.across[i];
            if next == first {
                break true;
            }
        };
        if !convex {
            self.points[vertex as usize] = before;
            return false;
        }
        let fan: Vec<(u32, [u32; 2])> = self.fan(vertex).collect();
        self.changes[vertex as usize] += 1;
        for (triangle, [b, _]) in fan {
            self.changes[b as usize] += 1;
            self.normals[triangle as usize] = Normal::new(self.corners(triangle).map(|v| self.point(v)));
        }
        true
    }

    /// Adds a point, and removes the triangles that it sees: the exact convex hull with the point.
    /// Returns the new vertex's index; `None`, without changes, if the point is not outside
    /// triangle `start`, or if what it sees has no simple boundary.
    pub fn insert(&mut self, p: DVec3, start: u32) -> Option<u32> {
        let Visible { triangles, corners, horizon } = self.visible_from(p, start)?;
        let new = self.points.len() as u32;
        self.points.push(p);
        self.at.push(NONE);
        self.changes.push(0);
        for corner in &corners {
            self.at[*corner as usize] = NONE;
            self.changes[*corner as usize] += 1;
        }
        for gone in &triangles {
            self.triangles[*gone as usize].corners = [NONE; 3];
        }
        self.free.extend(&triangles);
        self.add_fan(new, &horizon);
        self.live = self.live + 1 - corners.iter().filter(|corner| self.at[**corner as usize] == NONE).count();
        Some(new)
    }

    /// The triangles that a point sees, from `start` on, if their boundary is a single loop.
    fn visible_from(&self, p: DVec3, start: u32) -> Option<Visible> {
        if !self.is_above(p, self.triangles[start as usize].corners) {
            return None;
        }
        let mut found = Visible { triangles: vec![start], corners: Vec::new(), horizon: Vec::new() };
        let mut is_seen = std::collections::HashSet::from([start]);
        let mut read = 0;
        while read < found.triangles.len() {
            let Triangle { corners, across } = self.triangles[found.triangles[read] as usize];
            read += 1;
            found.corners.extend(corners);
            for i in 0..3 {
                if is_seen.contains(&across[i]) {
                    continue;
                }
                if self.is_above(p, self.triangles[across[i] as usize].corners) {
                    is_seen.insert(across[i]);
                    found.triangles.push(across[i]);
                } else {
                    found.horizon.push((corners[i], corners[(i + 1) % 3], across[i]));
                }
            }
        }
        found.corners.sort_unstable();
        found.corners.dedup();
        // The visible part is a disc; the fan that replaces it requires a single loop as boundary.
        let horizon = &mut found.horizon;
        horizon.sort_unstable();
        let is_loop = horizon.windows(2).all(|pair| pair[0].0 != pair[1].0)
            && horizon.iter().all(|edge| horizon.binary_search_by_key(&edge.1, |other| other.0).is_ok());
        is_loop.then_some(found)
    }

    fn add_fan(&mut self, new: u32, horizon: &[(u32, u32, u32)]) {
        let fan: Vec<u32> = horizon
            .iter()
            .map(|&(from, to, outside)| {
                self.add_triangle(Triangle { corners: [from, to, new], across: [outside, NONE, NONE] })
            })
            .collect();
        for (&(from, to, outside), &index) in horizon.iter().zip(&fan) {
            let next = fan[horizon.binary_search_by_key(&to, |edge| edge.0).expect("the horizon is closed")];
            self.triangles[index as usize].across[1] = next;
            self.triangles[next as usize].across[2] = index;
            let outside = &mut self.triangles[outside as usize];
            let side = (0..3).find(|&i| outside.corners[i] == to && outside.corners[(i + 1) % 3] == from);
            outside.across[side.expect("an edge of the horizon belongs to the triangle outside")] = index;
            self.at[from as usize] = index;
        }
        self.at[new as usize] = fan[0];
    }

    fn add_triangle(&mut self, triangle: Triangle) -> u32 {
        let normal = Normal::new(triangle.corners.map(|v| self.point(v)));
        match self.free.pop() {
            Some(index) => {
                self.triangles[index as usize] = triangle;
                self.normals[index as usize] = normal;
                index
            }
            None => {
                self.triangles.push(triangle);
                self.normals.push(normal);
                (self.triangles.len() - 1) as u32
            }
        }
    }
}

fn normals(triangles: &[Triangle], points: &[DVec3]) -> Vec<Normal> {
    triangles.iter().map(|triangle| Normal::new(triangle.corners.map(|v| points[v as usize]))).collect()
}

struct Visible {
    triangles: Vec<u32>,
    corners: Vec<u32>,
    /// Edges around the triangles, each with the triangle outside, ascending by their starts.
    horizon: Vec<(u32, u32, u32)>,
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn stored_normals_match_the_corners() {
        const SEED: u64 = 6;
        let mut rng = SplitMix64::new(SEED);
        for round in 0..40 {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
            let mut surface = Surface::tetrahedron(corners);
            for _ in 0..60 {
                let mut p = DVec3::from_array(rng.direction()) * rng.between(0.5, 1.5);
                if round % 2 == 0 {
                    p = (p * 4.0).round() * 0.25;
                }
                let triangles: Vec<u32> = surface.vertices().flat_map(|(v, _)| surface.triangles_at(v)).collect();
                let seen = triangles.into_iter().find_map(|triangle| surface.insert(p, triangle));
                let moved = seen.unwrap_or_else(|| surface.vertices().map(|(v, _)| v).last().unwrap());
                surface.try_move(moved, surface.point(moved) * rng.between(0.9, 1.1));
                for (v, _) in surface.vertices() {
                    let computed = surface.around(v).map(|[b, c]| surface.normal([v, b, c]));
                    let bits = |normal: DVec3| normal.to_array().map(f64::to_bits);
                    assert!(surface.normals_around(v).map(bits).eq(computed.map(bits)), "round {round}, seed {SEED}");
                    for triangle in surface.triangles_at(v) {
                        assert_eq!(surface.normal_of(triangle), surface.normal(surface.corners(triangle)));
                    }
                }
            }
            assert!(surface.vertex_count() > 8, "round {round}");
        }
    }
}
