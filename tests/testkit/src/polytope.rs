//! A hull as points, face normals and edges, in f64; and the intersection of half-spaces.

use glam::{DMat3, DVec3};
use hullmap::{Hull, Pose};

use crate::reach::Reach;

/// Maximum error of a truth, in units of the greatest length in the query times the f64 epsilon.
/// Two products with a rotation, a normal, a dot product and a difference amount to about 20 on
/// each hull.
const ROUNDING_UNITS: f64 = 64.0;

/// Maximum error of a truth about `a` and `b`, both in A's frame: a length. `frames` is the
/// distance of the frames' origins.
pub fn rounding_error(a: &Polytope, b: &Polytope, frames: f64) -> f64 {
    ROUNDING_UNITS * f64::EPSILON * (a.greatest() + b.greatest() + frames)
}

/// An edge and the faces on both sides of it.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// One of its ends.
    pub point: DVec3,
    /// Its direction, of unit length.
    pub dir: DVec3,
    /// Indices of the faces in [`Polytope::normals`].
    pub faces: [usize; 2],
}

/// Signed distance of `point` from the planes of a hull's faces: the greatest one, negative inside.
pub fn height_over_faces(hull: &Hull<'_>, point: DVec3) -> f64 {
    let over = |face: u32| {
        let corner = hull.face(face).next().and_then(|vertex| hull.vertex(vertex)).unwrap().as_dvec3();
        hull.face_normal(face).unwrap().dot(point - corner)
    };
    (0..hull.face_count() as u32).map(over).fold(f64::NEG_INFINITY, f64::max)
}

/// Outward normal and offset of a half-space.
pub type Plane = (DVec3, f64);

/// Vertices of the intersection of half-spaces, by solving all triples of planes.
pub fn vertices(planes: &[Plane]) -> Vec<DVec3> {
    let mut found: Vec<DVec3> = Vec::new();
    for (i, (n, d)) in planes.iter().enumerate() {
        for (j, (m, e)) in planes.iter().enumerate().skip(i + 1) {
            for (o, f) in &planes[j + 1..] {
                let determinant = n.dot(m.cross(*o));
                if determinant.abs() < 1e-9 {
                    continue;
                }
                let p = (*d * m.cross(*o) + *e * o.cross(*n) + *f * n.cross(*m)) / determinant;
                if planes.iter().all(|(n, d)| n.dot(p) <= d + 1e-9) && found.iter().all(|q| q.distance(p) > 1e-7) {
                    found.push(p);
                }
            }
        }
    }
    found
}

/// Vertices of `count` parts whose union is the intersection of half-spaces: the largest part is
/// cut through its centre, again and again, by a plane with the next `normal`. `grow` moves the
/// cuts outwards, so that the parts overlap; a negative value leaves gaps.
pub fn cut(planes: &[Plane], count: usize, grow: f64, mut normal: impl FnMut() -> DVec3) -> Vec<Vec<DVec3>> {
    let size = |part: &Vec<Plane>| {
        let found = vertices(part);
        let far = |p: &DVec3| found.iter().map(|q| p.distance(*q)).fold(0.0, f64::max);
        found.iter().map(far).fold(0.0, f64::max)
    };
    let mut parts = vec![planes.to_vec()];
    while parts.len() < count {
        let largest = (0..parts.len()).max_by(|a, b| size(&parts[*a]).total_cmp(&size(&parts[*b])));
        let part = parts.swap_remove(largest.expect("there is a part"));
        let found = vertices(&part);
        let centre = found.iter().sum::<DVec3>() / found.len() as f64;
        let normal = normal();
        for normal in [normal, -normal] {
            parts.push(part.iter().copied().chain([(normal, normal.dot(centre) + grow)]).collect());
        }
    }
    parts.iter().map(|part| vertices(part)).filter(|part| part.len() > 3).collect()
}

/// A solid or a polygon.
#[derive(Clone, Debug)]
pub struct Polytope {
    /// The vertices.
    pub points: Vec<DVec3>,
    /// Outward unit normals of the faces; of a polygon, of both sides and, in its plane, of the
    /// edges.
    pub normals: Vec<DVec3>,
    /// The edges. On the Gauss map, each is the arc between its faces' normals. Arcs are shorter
    /// than half a circle: an edge of a polygon has two arcs, which meet in the edge's normal in
    /// the plane.
    pub edges: Vec<Edge>,
}

impl Polytope {
    /// The hull's own vertices and faces. The faces are exactly planar, so their normals are the
    /// hull's. Panics if the hull has no faces: a segment or a point.
    pub fn new(hull: &Hull<'_>) -> Self {
        let points: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
        let faces: Vec<Vec<usize>> = hull.faces().map(|face| face.map(|v| v as usize).collect()).collect();
        assert!(faces.len() >= 2, "{} is a segment or a point", hull.name());
        let mut normals: Vec<DVec3> = faces.iter().map(|face| normal(&points, face)).collect();
        let mut sides: Vec<([usize; 2], usize)> = Vec::new();
        for (index, face) in faces.iter().enumerate() {
            for (corner, &from) in face.iter().enumerate() {
                let to = face[(corner + 1) % face.len()];
                sides.push(([from.min(to), from.max(to)], index));
            }
        }
        sides.sort_unstable();
        let flat = faces.len() == 2;
        let mut edges = Vec::new();
        for pair in sides.chunks(2) {
            let ([from, to], left, right) = (pair[0].0, pair[0].1, pair[1].1);
            assert_eq!(pair[0].0, pair[1].0, "{}: an edge has two faces", hull.name());
            let (point, dir) = (points[from], (points[to] - points[from]).normalize());
            if flat {
                // In the plane, away from the other vertices.
                let side = dir.cross(normals[0]).normalize();
                let inside = points
                    .iter()
                    .map(|p| (p - point).dot(side))
                    .fold(0.0, |m: f64, d| if d.abs() > m.abs() { d } else { m });
                normals.push(if inside > 0.0 { -side } else { side });
                edges.extend([left, right].map(|face| Edge { point, dir, faces: [face, normals.len() - 1] }));
            } else {
                edges.push(Edge { point, dir, faces: [left, right] });
            }
        }
        Self { points, normals, edges }
    }

    /// The polytope in A's frame, given B's pose in it.
    pub fn placed(&self, b_in_a: Pose) -> Self {
        let (turn, shift) = (DMat3::from_quat(b_in_a.rotation()), b_in_a.translation());
        Self {
            points: self.points.iter().map(|p| turn * *p + shift).collect(),
            normals: self.normals.iter().map(|n| turn * *n).collect(),
            edges: self.edges.iter().map(|e| Edge { point: turn * e.point + shift, dir: turn * e.dir, ..*e }).collect(),
        }
    }

    /// Maximum distance of a vertex from the frame's origin.
    pub fn greatest(&self) -> f64 {
        self.points.iter().map(|p| p.length()).fold(0.0, f64::max)
    }
}

impl Reach for Polytope {
    fn reach(&self, dir: DVec3) -> f64 {
        self.points.reach(dir)
    }
}

/// The unit normal of a planar polygon, perpendicular to its longest side up to rounding error. The
/// normal of a thin polygon then has an error only about that side.
fn normal(points: &[DVec3], face: &[usize]) -> DVec3 {
    let root = points[face[0]];
    let spokes: Vec<DVec3> = face[1..].iter().map(|&v| points[v] - root).collect();
    let sum: DVec3 = spokes.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    let sides = face.iter().zip(face.iter().cycle().skip(1)).map(|(&from, &to)| points[to] - points[from]);
    let longest =
        sides.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::X).normalize();
    perpendicular_part(sum.normalize(), longest)
}

/// The part of `n` perpendicular to the unit vector `dir`, normalized. Projected twice, because the
/// first result has a rounding error relative to the part that was removed.
pub(crate) fn perpendicular_part(n: DVec3, dir: DVec3) -> DVec3 {
    let once = (n - dir * n.dot(dir)).normalize();
    (once - dir * once.dot(dir)).normalize()
}
