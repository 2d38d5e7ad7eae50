//! Quickhull: convex hull of points that span space, with exact predicates.
//!
//! 1. Start with a tetrahedron. Assign every other point to one face that it lies strictly above.
//! 2. Take a face that has points, and make its farthest point a vertex. The faces that this point
//!    lies strictly above form a disc, bounded by the horizon. Replace them by a fan from the
//!    horizon to the new vertex, and assign the disc's points to the fan's faces.
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
//!
//! # Memory
//! Places of deleted faces are reused: about 2n faces of 72 bytes. The facets of a solid depend
//! neither on the order of insertion nor on the places.

use glam::DVec3;
use hullmap_geometry::{bounds, triangle::from_least};

/// Maximum error of the filter's determinant, relative to the sum of its terms' magnitudes. Three
/// differences, two products and four sums of f64 round at most ten times.
pub(crate) const FILTER: f64 = 10.0 * f64::EPSILON / 2.0;

const NONE: u32 = u32::MAX;

/// Vertex indices of a facet, counter-clockwise seen from outside, starting at the smallest.
pub type Facet = Vec<u32>;

/// The hull's facets, in ascending order. Every vertex of a facet is an extreme point. `points`
/// must be distinct, and `simplex` must hold four indices that span space.
///
/// # Complexity
/// O(n log n) on all families tried; quadratic at worst.
pub fn hull(points: &[DVec3], simplex: [usize; 4]) -> Vec<Facet> {
    let everything: Vec<u32> = (0..points.len() as u32).collect();
    let (mut facets, mut flat) = build(points, &everything, simplex.map(|i| i as u32));
    drop(everything);
    while flat > 0 {
        let extreme = extreme_vertices(&facets, points.len());
        drop(facets);
        (facets, flat) = build(points, &extreme, spanning(points, &extreme));
    }
    facets
}

/// Facets of the `chosen` points, and the number of vertices at which fewer than three facets meet.
fn build(points: &[DVec3], chosen: &[u32], simplex: [u32; 4]) -> (Vec<Facet>, usize) {
    let mut builder = Builder::new(points, chosen);
    builder.build(chosen, simplex);
    let facets = builder.facets();
    let mut used = vec![false; points.len()];
    builder.faces.iter().filter(|face| face.alive).flat_map(|face| face.vertices).for_each(|v| used[v as usize] = true);
    let used = used.iter().filter(|used| **used).count();
    let flat = used - extreme_vertices(&facets, points.len()).len();
    (facets, flat)
}

fn extreme_vertices(facets: &[Facet], point_count: usize) -> Vec<u32> {
    let mut counts = vec![0_u8; point_count];
    facets.iter().flatten().for_each(|v| counts[*v as usize] = counts[*v as usize].saturating_add(1));
    (0..point_count as u32).filter(|v| counts[*v as usize] >= 3).collect()
}

/// Sorts facets. No two of them have the same first edge, so that two vertices decide.
pub(super) fn sort(facets: &mut Vec<Facet>) {
    let mut order: Vec<(u64, u32)> =
        (0..).zip(facets.iter()).map(|(at, facet)| (u64::from(facet[0]) << 32 | u64::from(facet[1]), at)).collect();
    order.sort_unstable();
    *facets = order.into_iter().map(|(_, at)| std::mem::take(&mut facets[at as usize])).collect();
}

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
    /// Maximum rounding error of the height of any point.
    error: f64,
    /// First of the points assigned to this face, and the farthest of them with its height in units
    /// of the error, so that it fits into an f32 at any scale.
    points: u32,
    farthest: u32,
    height: f32,
    alive: bool,
}

struct Builder<'a> {
    points: &'a [DVec3],
    /// Sides of the box around the chosen points.
    size: DVec3,
    faces: Vec<Face>,
    free: Vec<u32>,
    /// For each point, the next point of the same face.
    next_point: Vec<u32>,
    /// For each horizon vertex, the new face that starts there. Scratch space of one insertion.
    fan_at: Vec<u32>,
    /// The visible faces, the edges around them (from, to, face outside), and the faces that
    /// replace them. Scratch space of one insertion.
    disc: Vec<u32>,
    horizon: Vec<(u32, u32, u32)>,
    fan: Vec<u32>,
}

impl<'a> Builder<'a> {
    fn new(points: &'a [DVec3], chosen: &[u32]) -> Self {
        let n = points.len();
        let [low, high] = bounds(chosen.iter().map(|p| points[*p as usize]));
        Self {
            points,
            size: high - low,
            faces: Vec::new(),
            free: Vec::new(),
            next_point: vec![NONE; n],
            fan_at: vec![NONE; n],
            disc: Vec::new(),
            horizon: Vec::new(),
            fan: Vec::new(),
        }
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
                self.give(p, &[0, 1, 2, 3]);
            }
        }
        let mut work: Vec<u32> = (0..4).collect();
        while let Some(face) = work.pop() {
            let Face { alive, points, .. } = self.faces[face as usize];
            if alive && points != NONE {
                self.insert(face);
                work.extend(self.fan.iter().filter(|new| self.faces[**new as usize].points != NONE));
            }
        }
    }

    fn push_face(&mut self, vertices: [u32; 3], across: [u32; 3]) -> u32 {
        let [a, b, c] = vertices.map(|i| self.point(i));
        let normal = (b - a).cross(c - a);
        let error = FILTER * magnitude(a, b, c).dot(self.size);
        let (points, farthest, height, alive) = (NONE, NONE, f32::NEG_INFINITY, true);
        let face = Face { vertices, across, normal, error, points, farthest, height, alive };
        match self.free.pop() {
            Some(place) => {
                self.faces[place as usize] = face;
                place
            }
            None => {
                self.faces.push(face);
                (self.faces.len() - 1) as u32
            }
        }
    }

    /// Whether point `p` lies strictly above the face, and its approximate height times twice the
    /// area of the face. The height is exactly 0 only in the plane.
    fn height_above(&self, face: u32, p: u32) -> (bool, f64) {
        let face = &self.faces[face as usize];
        let p = self.point(p);
        let [a, b, c] = face.vertices;
        let a = self.point(a);
        let height = face.normal.dot(p - a);
        if height.abs() > face.error {
            return (height > 0.0, height);
        }
        // The error depends on the distance: the filter of this point accepts more.
        let (b, c) = (self.point(b), self.point(c));
        if height.abs() > FILTER * magnitude(a, b, c).dot((p - a).abs()) {
            return (height > 0.0, height);
        }
        let exact = exact_above(a, b, c, p);
        (exact > 0.0, exact)
    }

    /// Assigns `p` to the first of `faces` that it lies above. A point above no face is inside.
    fn give(&mut self, p: u32, faces: &[u32]) {
        for &face in faces {
            let (above, height) = self.height_above(face, p);
            if above {
                let face = &mut self.faces[face as usize];
                self.next_point[p as usize] = face.points;
                face.points = p;
                let height = (height / face.error) as f32;
                if face.farthest == NONE || height > face.height {
                    (face.farthest, face.height) = (p, height);
                }
                return;
            }
        }
    }

    fn insert(&mut self, face: u32) {
        let apex = self.faces[face as usize].farthest;
        self.find_visible(face, apex);
        let (disc, horizon) = (std::mem::take(&mut self.disc), std::mem::take(&mut self.horizon));
        let mut fan = std::mem::take(&mut self.fan);
        fan.clear();
        for &(a, b, outside) in &horizon {
            let new = self.push_face([a, b, apex], [outside, NONE, NONE]);
            fan.push(new);
            self.fan_at[a as usize] = new;
            let outside = &mut self.faces[outside as usize];
            let edge = (0..3).find(|&i| outside.vertices[i] == b && outside.vertices[(i + 1) % 3] == a);
            outside.across[edge.expect("a horizon edge belongs to the face outside it")] = new;
        }
        for &new in &fan {
            let next = self.fan_at[self.faces[new as usize].vertices[1] as usize];
            self.faces[new as usize].across[1] = next;
            self.faces[next as usize].across[2] = new;
        }
        for &dead in &disc {
            let mut p = self.faces[dead as usize].points;
            while p != NONE {
                let next = self.next_point[p as usize];
                if p != apex {
                    self.give(p, &fan);
                }
                p = next;
            }
        }
        self.free.extend_from_slice(&disc);
        (self.disc, self.horizon, self.fan) = (disc, horizon, fan);
    }

    /// Deletes the faces that `apex` lies strictly above, and lists them and the horizon around
    /// them. Their places are not free yet, because their points remain to be assigned.
    fn find_visible(&mut self, face: u32, apex: u32) {
        self.disc.clear();
        self.horizon.clear();
        self.disc.push(face);
        self.faces[face as usize].alive = false;
        let mut read = 0;
        while read < self.disc.len() {
            let Face { vertices, across, .. } = self.faces[self.disc[read] as usize];
            read += 1;
            for i in 0..3 {
                let other = across[i];
                if !self.faces[other as usize].alive {
                    continue;
                }
                if self.height_above(other, apex).0 {
                    self.faces[other as usize].alive = false;
                    self.disc.push(other);
                } else {
                    self.horizon.push((vertices[i], vertices[(i + 1) % 3], other));
                }
            }
        }
    }

    fn facets(&self) -> Vec<Facet> {
        let mut group = vec![NONE; self.faces.len()];
        let mut facets = Vec::new();
        let mut members = Vec::new();
        for start in 0..self.faces.len() {
            if !self.faces[start].alive || group[start] != NONE {
                continue;
            }
            let name = facets.len() as u32;
            group[start] = name;
            members.clear();
            members.push(start as u32);
            let mut read = 0;
            while read < members.len() {
                let face = members[read];
                read += 1;
                for other in self.faces[face as usize].across {
                    if group[other as usize] == NONE && self.coplanar(face, other) {
                        group[other as usize] = name;
                        members.push(other);
                    }
                }
            }
            facets.push(match members.as_slice() {
                [single] => from_least(self.faces[*single as usize].vertices).to_vec(),
                _ => self.outline(&members, &group, name),
            });
        }
        sort(&mut facets);
        facets
    }

    /// Whether all vertices of `other` lie exactly in the plane of `face`.
    fn coplanar(&self, face: u32, other: u32) -> bool {
        let own = self.faces[face as usize].vertices;
        self.faces[other as usize].vertices.iter().all(|v| own.contains(v) || self.height_above(face, *v).1 == 0.0)
    }

    /// The polygon around a group of coplanar faces: its outer edges joined end to end.
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

/// Sum of the magnitudes of the terms in each component of a triangle's normal, for the filter.
pub(crate) fn magnitude(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (s, t) = ((b - a).abs(), (c - a).abs());
    DVec3::new(s.y * t.z + s.z * t.y, s.z * t.x + s.x * t.z, s.x * t.y + s.y * t.x)
}

/// Positive if `p` lies above the plane of a, b, c (counter-clockwise seen from above), zero if it
/// lies in the plane. The sign is exact.
pub(crate) fn exact_above(a: DVec3, b: DVec3, c: DVec3, p: DVec3) -> f64 {
    let coord = |v: DVec3| robust::Coord3D { x: v.x, y: v.y, z: v.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(p))
}
