//! Quickhull: convex hull of points that span space, with exact predicates.
//!
//! 1. Start with a tetrahedron. Assign every other point to one face that it lies strictly above.
//! 2. Take a face that has points, and make its farthest point a vertex. The faces that this point
//!    lies strictly above form a disc, bounded by the horizon (`rim`). Replace them by a fan from
//!    the horizon to the new vertex, and assign the disc's points to the fan's faces.
//! 3. When no face has points, merge exactly coplanar faces into facets. A vertex at which fewer
//!    than three facets meet is not a vertex of the hull. Remove such points, and build again from
//!    the rest.
//!
//! # Reference
//! Barber, Dobkin, Huhdanpaa, "The Quickhull algorithm for convex hulls", 1996. Predicates:
//! Shewchuk, "Adaptive precision floating-point arithmetic", 1997, by the `robust` crate.
//!
//! # Deviations
//! Barber makes facets thick enough to cover rounding error. Here, exact predicates decide which
//! points are above a face. The faces removed in step 2 therefore always form a disc, no face is
//! degenerate, and no point is lost, however flat or thin the set is.

use glam::DVec3;

/// Maximum error of the filter's determinant, relative to the sum of its terms' magnitudes. Three
/// differences, two products and four sums of f64 round at most ten times.
const FILTER: f64 = 10.0 * f64::EPSILON / 2.0;

const NONE: u32 = u32::MAX;

/// A facet of the hull: the indices of its vertices, counter-clockwise seen from outside, starting
/// at the smallest.
pub type Facet = Vec<u32>;

/// The hull's facets, in ascending order. Every vertex of a facet is an extreme point.
///
/// `points` must be distinct, and `simplex` must hold the indices of four points that span space.
/// The result depends only on the points and their order.
///
/// # Complexity
/// O(n log n) on all families tried; quadratic at worst.
pub fn hull(points: &[DVec3], simplex: [usize; 4]) -> Vec<Facet> {
    let everything: Vec<u32> = (0..points.len() as u32).collect();
    let mut builder = Builder::new(points);
    builder.build(&everything, simplex.map(|i| i as u32));
    loop {
        let (facets, flat) = builder.facets();
        if flat == 0 {
            return facets;
        }
        let extreme = extreme_vertices(&facets);
        let simplex = spanning(points, &extreme);
        builder = Builder::new(points);
        builder.build(&extreme, simplex);
    }
}

/// Vertices at which three or more facets meet, ascending.
fn extreme_vertices(facets: &[Facet]) -> Vec<u32> {
    let mut all: Vec<u32> = facets.iter().flatten().copied().collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|run| run.len() >= 3).map(|run| run[0]).collect()
}

/// Indices of four of the `chosen` points that span space.
fn spanning(points: &[DVec3], chosen: &[u32]) -> [u32; 4] {
    let positions: Vec<DVec3> = chosen.iter().map(|i| points[*i as usize]).collect();
    match super::rank::spanning_simplex(&positions) {
        super::rank::Simplex::Tetrahedron(simplex) => simplex.map(|i| chosen[i]),
        // The extreme points have the same hull as the set, which spans space.
        _ => unreachable!("the extreme points of a solid span space"),
    }
}

struct Face {
    vertices: [u32; 3],
    /// Face across the edge from vertex `i` to vertex `i + 1`.
    across: [u32; 3],
    normal: DVec3,
    /// Sum of the magnitudes of the terms in each component of the normal, for the filter.
    magnitude: DVec3,
    /// First of the points assigned to this face, and the farthest of them with its distance.
    points: u32,
    farthest: (u32, f64),
    alive: bool,
}

struct Builder<'a> {
    points: &'a [DVec3],
    faces: Vec<Face>,
    /// For each point, the next point of the same face.
    next_point: Vec<u32>,
    /// For each rim vertex, the new face that starts there. Scratch space of one insertion.
    fan_at: Vec<u32>,
}

impl<'a> Builder<'a> {
    fn new(points: &'a [DVec3]) -> Self {
        let n = points.len();
        Self { points, faces: Vec::new(), next_point: vec![NONE; n], fan_at: vec![NONE; n] }
    }

    fn point(&self, i: u32) -> DVec3 {
        self.points[i as usize]
    }

    fn build(&mut self, chosen: &[u32], [a, b, c, d]: [u32; 4]) {
        let below = exact_above(self.point(a), self.point(b), self.point(c), self.point(d)) < 0.0;
        let [a, b, c, d] = if below { [a, b, c, d] } else { [a, c, b, d] };
        // Vertices of each face, and its neighbours across the edges in the same order.
        for (vertices, across) in
            [([a, b, c], [3, 1, 2]), ([c, b, d], [0, 3, 2]), ([a, c, d], [0, 1, 3]), ([b, a, d], [0, 2, 1])]
        {
            self.push_face(vertices, across);
        }
        for &p in chosen {
            if ![a, b, c, d].contains(&p) {
                self.give(p, 0..4);
            }
        }
        let mut work: Vec<u32> = (0..4).collect();
        while let Some(face) = work.pop() {
            if self.faces[face as usize].alive && self.faces[face as usize].points != NONE {
                let first = self.faces.len() as u32;
                self.insert(face);
                work.extend(first..self.faces.len() as u32);
            }
        }
    }

    fn push_face(&mut self, vertices: [u32; 3], across: [u32; 3]) -> u32 {
        let [a, b, c] = vertices.map(|i| self.point(i));
        let (e, f) = (b - a, c - a);
        let (s, t) = (e.abs(), f.abs());
        let magnitude = DVec3::new(s.y * t.z + s.z * t.y, s.z * t.x + s.x * t.z, s.x * t.y + s.y * t.x);
        let (points, farthest) = (NONE, (NONE, f64::NEG_INFINITY));
        self.faces.push(Face { vertices, across, normal: e.cross(f), magnitude, points, farthest, alive: true });
        (self.faces.len() - 1) as u32
    }

    /// Whether point `p` lies strictly above the face, and its approximate height.
    fn above(&self, face: u32, p: u32) -> (bool, f64) {
        let face = &self.faces[face as usize];
        let p = self.point(p);
        let offset = p - self.point(face.vertices[0]);
        let height = face.normal.dot(offset);
        let error = FILTER * face.magnitude.dot(offset.abs());
        if height.abs() > error {
            (height > 0.0, height)
        } else {
            let [a, b, c] = face.vertices.map(|i| self.point(i));
            let exact = exact_above(a, b, c, p);
            (exact > 0.0, exact)
        }
    }

    /// Assigns `p` to the first of `faces` that it lies above. A point above no face is inside.
    fn give(&mut self, p: u32, faces: std::ops::Range<u32>) {
        for face in faces {
            let (above, height) = self.above(face, p);
            if above {
                let length = self.faces[face as usize].normal.length();
                let face = &mut self.faces[face as usize];
                self.next_point[p as usize] = face.points;
                face.points = p;
                let distance = height / length;
                if face.farthest.0 == NONE || distance > face.farthest.1 {
                    face.farthest = (p, distance);
                }
                return;
            }
        }
    }

    /// Makes the farthest point of `face` a vertex of the hull.
    fn insert(&mut self, face: u32) {
        let apex = self.faces[face as usize].farthest.0;
        let (disc, rim) = self.visible(face, apex);
        let first = self.faces.len() as u32;
        for &(a, b, outside) in &rim {
            let new = self.push_face([a, b, apex], [outside, NONE, NONE]);
            self.fan_at[a as usize] = new;
            let outside = &mut self.faces[outside as usize];
            let edge = (0..3).find(|&i| outside.vertices[i] == b && outside.vertices[(i + 1) % 3] == a);
            outside.across[edge.expect("a rim edge belongs to the face outside it")] = new;
        }
        for new in first..self.faces.len() as u32 {
            let next = self.fan_at[self.faces[new as usize].vertices[1] as usize];
            self.faces[new as usize].across[1] = next;
            self.faces[next as usize].across[2] = new;
        }
        let fan = first..self.faces.len() as u32;
        for dead in disc {
            let mut p = self.faces[dead as usize].points;
            while p != NONE {
                let next = self.next_point[p as usize];
                if p != apex {
                    self.give(p, fan.clone());
                }
                p = next;
            }
        }
    }

    /// Deletes the faces that `apex` lies strictly above. Returns them, and the horizon around them
    /// as edges (from, to, face outside).
    fn visible(&mut self, face: u32, apex: u32) -> (Vec<u32>, Vec<(u32, u32, u32)>) {
        let mut disc = vec![face];
        let mut rim = Vec::new();
        self.faces[face as usize].alive = false;
        let mut read = 0;
        while read < disc.len() {
            let Face { vertices, across, .. } = self.faces[disc[read] as usize];
            read += 1;
            for i in 0..3 {
                let other = across[i];
                if !self.faces[other as usize].alive {
                    continue;
                }
                if self.above(other, apex).0 {
                    self.faces[other as usize].alive = false;
                    disc.push(other);
                } else {
                    rim.push((vertices[i], vertices[(i + 1) % 3], other));
                }
            }
        }
        (disc, rim)
    }

    /// Merges exactly coplanar faces into facets. Also returns the number of vertices at which
    /// fewer than three facets meet.
    fn facets(&self) -> (Vec<Facet>, usize) {
        let mut group = vec![NONE; self.faces.len()];
        let mut facets = Vec::new();
        let mut seen = vec![false; self.points.len()];
        for start in 0..self.faces.len() {
            if !self.faces[start].alive || group[start] != NONE {
                continue;
            }
            let name = facets.len() as u32;
            group[start] = name;
            let mut members = vec![start as u32];
            let mut read = 0;
            while read < members.len() {
                let face = &self.faces[members[read] as usize];
                read += 1;
                for i in 0..3 {
                    let other = face.across[i];
                    if group[other as usize] == NONE && self.coplanar(face, &self.faces[other as usize]) {
                        group[other as usize] = name;
                        members.push(other);
                    }
                }
            }
            facets.push(self.outline(&members, &group, name));
        }
        for face in self.faces.iter().filter(|f| f.alive) {
            for v in face.vertices {
                seen[v as usize] = true;
            }
        }
        facets.sort_unstable();
        let used = seen.iter().filter(|s| **s).count();
        let flat = used - extreme_vertices(&facets).len();
        (facets, flat)
    }

    /// Whether all vertices of `other` lie exactly in the plane of `face`.
    fn coplanar(&self, face: &Face, other: &Face) -> bool {
        let [a, b, c] = face.vertices.map(|i| self.point(i));
        other.vertices.iter().all(|v| face.vertices.contains(v) || exact_above(a, b, c, self.point(*v)) == 0.0)
    }

    /// The polygon around a group of coplanar faces: the edges whose other side is outside the
    /// group, joined end to end.
    fn outline(&self, members: &[u32], group: &[u32], name: u32) -> Facet {
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for member in members {
            let face = &self.faces[*member as usize];
            for i in 0..3 {
                if group[face.across[i] as usize] != name {
                    edges.push((face.vertices[i], face.vertices[(i + 1) % 3]));
                }
            }
        }
        edges.sort_unstable();
        let mut outline = Vec::with_capacity(edges.len());
        let mut at = edges[0].0;
        for _ in 0..edges.len() {
            outline.push(at);
            let edge = edges.binary_search_by_key(&at, |e| e.0).expect("the outline of a facet is closed");
            at = edges[edge].1;
        }
        outline
    }
}

/// Positive if `p` lies above the plane of a, b, c (counter-clockwise seen from above), zero if it
/// lies in the plane. The sign is exact.
fn exact_above(a: DVec3, b: DVec3, c: DVec3, p: DVec3) -> f64 {
    let coord = |v: DVec3| robust::Coord3D { x: v.x, y: v.y, z: v.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(p))
}

#[cfg(test)]
mod tests {
    use shapes::families::Family;

    use super::*;

    /// parry3d in f64 serves as an independent check, on families whose points are either inside or
    /// extreme by more than its tolerances.
    #[test]
    fn parry_finds_the_same_vertices() {
        for family in [Family::Sphere, Family::Ball, Family::Rock, Family::Prism, Family::Cone, Family::Lens] {
            let points: Vec<DVec3> =
                family.points(400, 8).iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
            let everything: Vec<u32> = (0..points.len() as u32).collect();
            let facets = hull(&points, spanning(&points, &everything).map(|i| i as usize));
            let bits = |p: DVec3| p.to_array().map(f64::to_bits);
            let mut ours: Vec<_> = extreme_vertices(&facets).iter().map(|v| bits(points[*v as usize])).collect();
            let (theirs, _) = parry3d_f64::transformation::try_convex_hull(&points).expect("parry builds a hull");
            let mut theirs: Vec<_> = theirs.into_iter().map(bits).collect();
            ours.sort_unstable();
            theirs.sort_unstable();
            assert!(ours.len() > 40);
            assert_eq!(ours, theirs, "{}", family.name());
        }
    }
}
