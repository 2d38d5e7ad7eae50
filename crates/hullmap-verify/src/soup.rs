//! The triangles that bound the solid of a mesh: nearest triangle, ray crossings, winding number.
//!
//! Only the triangles that close the solid's holes, and the choice of triangles that bound its
//! inside, come from the baker. Distances and winding numbers use another tree of boxes and the sum
//! of all solid angles.
//!
//! # Reference
//! - Möller, Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
//! - Van Oosterom, Strackee, "The solid angle of a plane triangle", 1983.

use glam::DVec3;
use hullmap_bake::fit::Solid;
use hullmap_geometry::{
    bounds,
    triangle::{Triangle, nearest},
};
use rayon::prelude::*;

const LEAF: usize = 4;

/// Directions of the rays by which the side of a point is guessed: none along common edges.
const RAYS: [DVec3; 2] = [DVec3::new(0.283, -0.617, 0.734), DVec3::new(-0.541, 0.327, 0.775)];

/// Minimum length of an array of triangles that is summed on several threads.
const PARALLEL: usize = 4096;

/// A box, and a run of triangles or two nodes, of which the first follows.
struct Node {
    low: DVec3,
    high: DVec3,
    start: u32,
    count: u32,
    second: u32,
}

struct Face {
    corners: Triangle,
    /// Whether the triangle belongs to the mesh. Others close holes.
    is_mesh: bool,
    bounds_inside: bool,
}

/// Triangles of a mesh, and triangles that close it.
pub struct TriangleSoup {
    /// By the leaves of the tree.
    faces: Vec<Face>,
    nodes: Vec<Node>,
    /// The triangles that count for the winding number.
    winding: Vec<Triangle>,
    has_closing: bool,
    bounds: [DVec3; 2],
}

impl TriangleSoup {
    /// The soup of `solid`, which belongs to a mesh of `mesh_count` triangles.
    pub fn new(solid: &Solid, mesh_count: usize) -> Self {
        let all = solid.triangles();
        let face = |(index, corners): (usize, &Triangle)| Face {
            corners: *corners,
            is_mesh: index < mesh_count,
            bounds_inside: solid.bounds_inside(index),
        };
        let mut faces: Vec<Face> = all.iter().enumerate().map(face).collect();
        let winding = faces.iter().filter(|face| face.bounds_inside).map(|face| face.corners).collect();
        let mut nodes = Vec::new();
        let end = faces.len();
        grow(&mut faces, 0..end, &mut nodes);
        Self { faces, nodes, winding, has_closing: all.len() > mesh_count, bounds: solid.bounds() }
    }

    /// Distance of the nearest triangle of the mesh, and that triangle.
    pub fn to_mesh(&self, p: DVec3) -> Option<(f64, Triangle)> {
        self.nearest(p, true)
    }

    /// Lower bound on the distance of a point outside from the solid: closing triangles may bound
    /// it.
    pub fn gap(&self, p: DVec3) -> f64 {
        self.nearest(p, !self.has_closing).map_or(f64::INFINITY, |(distance, _)| distance)
    }

    /// Whether rays find the point inside. A guess: a ray may graze an edge.
    pub fn seems_inside(&self, p: DVec3) -> bool {
        let is_in_bounds = (self.bounds[0] - p).max(p - self.bounds[1]).max_element() <= 0.0;
        !self.winding.is_empty() && is_in_bounds && RAYS.iter().all(|ray| self.crossings(p, *ray) != 0)
    }

    /// Whether the point is certainly outside: by the sum of all solid angles, in O(triangles).
    pub fn is_outside(&self, p: DVec3) -> bool {
        let of = |triangle: &Triangle| solid_angle(triangle.map(|corner| corner - p));
        let sum: f64 = if self.winding.len() < PARALLEL {
            self.winding.iter().map(of).sum()
        } else {
            self.winding.par_iter().map(of).sum()
        };
        // The sum is a whole number of turns, except on the surface.
        (sum / (4.0 * std::f64::consts::PI)).abs() < 0.25
    }

    fn nearest(&self, p: DVec3, is_mesh_only: bool) -> Option<(f64, Triangle)> {
        let mut best: Option<(f64, Triangle)> = None;
        let mut stack = vec![0_usize];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index) else { continue };
            if best.is_some_and(|(least, _)| to_box(node, p) >= least) {
                continue;
            }
            if node.count == 0 {
                let children = [index + 1, node.second as usize];
                let far = usize::from(to_box(&self.nodes[children[0]], p) <= to_box(&self.nodes[children[1]], p));
                stack.extend([children[far], children[1 - far]]);
                continue;
            }
            for face in self.run(node) {
                let distance = nearest(&face.corners, p).distance(p);
                if (face.is_mesh || !is_mesh_only) && best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, face.corners));
                }
            }
        }
        best
    }

    fn run(&self, node: &Node) -> &[Face] {
        &self.faces[node.start as usize..(node.start + node.count) as usize]
    }

    /// Winding number as the signed number of triangles that a ray crosses.
    fn crossings(&self, p: DVec3, direction: DVec3) -> i32 {
        let inverse = direction.recip();
        let (mut sum, mut stack) = (0, vec![0_usize]);
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index) else { continue };
            let (s, t) = ((node.low - p) * inverse, (node.high - p) * inverse);
            let (enter, leave) = (s.min(t).max_element(), s.max(t).min_element());
            if !(leave >= 0.0 && enter <= leave) {
                continue;
            }
            if node.count == 0 {
                stack.extend([index + 1, node.second as usize]);
            }
            let bounding = self.run(node).iter().filter(|face| face.bounds_inside);
            sum += bounding.map(|face| crossing(&face.corners, p, direction)).sum::<i32>();
        }
        sum
    }
}

fn grow(faces: &mut [Face], range: std::ops::Range<usize>, nodes: &mut Vec<Node>) {
    let own = &mut faces[range.clone()];
    let [low, high] = bounds(own.iter().flat_map(|face| face.corners));
    let index = nodes.len();
    let is_leaf = own.len() <= LEAF;
    let count = if is_leaf { own.len() as u32 } else { 0 };
    nodes.push(Node { low, high, start: range.start as u32, count, second: 0 });
    if is_leaf {
        return;
    }
    let axis = (high - low).max_position();
    let key = |face: &Face| face.corners.iter().map(|corner| corner[axis]).sum::<f64>();
    let half = own.len() / 2;
    own.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
    grow(faces, range.start..range.start + half, nodes);
    nodes[index].second = nodes.len() as u32;
    grow(faces, range.start + half..range.end, nodes);
}

fn to_box(node: &Node, p: DVec3) -> f64 {
    (node.low - p).max(p - node.high).max(DVec3::ZERO).length()
}

/// Solid angle of a triangle seen from the origin, signed by its orientation.
fn solid_angle([a, b, c]: Triangle) -> f64 {
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(scale)
}

/// −1, 0 or 1: how a ray crosses a triangle.
fn crossing(&[a, b, c]: &Triangle, p: DVec3, direction: DVec3) -> i32 {
    let (ab, ac) = (b - a, c - a);
    let side = direction.cross(ac);
    let volume = ab.dot(side);
    if volume == 0.0 {
        return 0;
    }
    let from = p - a;
    let u = from.dot(side) / volume;
    let turned = from.cross(ab);
    let v = direction.dot(turned) / volume;
    let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(turned) / volume > 0.0;
    if is_hit { volume.signum() as i32 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;
    use hullmap_bake::fit::SolidRule;
    use hullmap_geometry::PointSet;

    /// Two cubes; the second has no lid.
    fn cubes() -> PointSet {
        let mut cubes = shapes::cubes::surface(&[[0; 3], [3, 0, 0]]);
        cubes.faces.pop();
        PointSet { triangles: cubes.fans(), ..PointSet::of_positions(cubes.vertices) }
    }

    #[test]
    fn distances_and_sides_match_cubes() {
        let mesh = cubes();
        let soup = TriangleSoup::new(&Solid::by(&mesh, SolidRule::Closed), mesh.triangles.len());
        let mut random = SplitMix::new(5);
        let mut inside = 0;
        for _ in 0..2_000 {
            let p = DVec3::new(2.0, 0.5, 0.5) + random.in_ball_f64() * 2.5;
            let away = [0.0, 3.0].map(|x| {
                let low = DVec3::new(x, 0.0, 0.0);
                (low - p).max(p - low - 1.0)
            });
            let distance = away.map(|away| away.max(DVec3::ZERO).length()).into_iter().fold(f64::INFINITY, f64::min);
            let is_inside = away.iter().any(|away| away.max_element() < 0.0);
            assert_eq!((soup.is_outside(p), soup.seems_inside(p)), (!is_inside, is_inside), "{p}");
            if !is_inside {
                assert!(
                    (soup.gap(p) - distance).abs() < 1e-12 && soup.to_mesh(p).unwrap().0 >= distance - 1e-12,
                    "{p}"
                );
            }
            inside += usize::from(is_inside);
        }
        assert!((50..500).contains(&inside), "{inside}");
    }
}
