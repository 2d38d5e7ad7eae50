//! Witness points of a depth: the point of the support plane's facet at the origin's foot, as a
//! combination of all vertices in the plane.
//!
//! # Steps
//! 1. For each shape, collect the vertices that are in the support plane within rounding error: a
//!    vertex, an edge, or a face. For two parallel faces, these are two polygons.
//! 2. Two edges cross, or a vertex is over a triangle: both give the points at once.
//! 3. Else, GJK in the plane: combine up to three pairs of these vertices into the foot.

use glam::DVec3;

use crate::facets::lane_set::LaneSet;
use crate::facets::table::PointBlock;
use crate::facets::view::Facets;
use crate::solver::barycentric::on_triangle;
use crate::solver::bound::Bound;
use crate::solver::minkowski::Minkowski;
use crate::support::SupportMap;
use crate::support::simd::{Dispatch, Pass, Simd};

/// Maximum number of steps. Two faces of four vertices need at most six.
const MAX_STEPS: usize = 24;

/// Vertices within this many rounding errors of the support plane are in it.
const PLANE_ROUNDINGS: f64 = 2.0;

/// Maximum number of vertices of a shape in its support plane.
const MAX_IN_PLANE: usize = 16;

struct Feature {
    /// In A's frame. B's points are mirrored, so that sums are points of the difference.
    points: [DVec3; MAX_IN_PLANE],
    vertices: [u32; MAX_IN_PLANE],
    count: usize,
}

impl Feature {
    const EMPTY: Self = Self { points: [DVec3::ZERO; MAX_IN_PLANE], vertices: [0; MAX_IN_PLANE], count: 0 };

    /// Collects the vertices that are within `slack` of the farthest one along the unit vector
    /// `dir`, of those in the mask `near`. `None` if there is none, or if there are too many.
    #[inline(always)]
    fn collect(
        &mut self,
        facets: &Facets<'_>,
        near: LaneSet,
        dir: DVec3,
        slack: f64,
        place: impl Fn(DVec3) -> DVec3,
    ) -> Option<()> {
        let mut heights = [0.0; MAX_IN_PLANE];
        let mut found = 0;
        let mut farthest = f64::NEG_INFINITY;
        for vertex in near.iter().take_while(|vertex| *vertex < facets.vertex_count()) {
            let point = facets.vertex(vertex)?;
            let height = point.dot(dir);
            *self.points.get_mut(found)? = point;
            self.vertices[found] = vertex as u32;
            heights[found] = height;
            farthest = if height > farthest { height } else { farthest };
            found += 1;
        }
        self.count = 0;
        for (i, height) in heights.iter().enumerate().take(found) {
            if *height >= farthest - slack {
                self.points[self.count] = place(self.points[i]);
                self.vertices[self.count] = self.vertices[i];
                self.count += 1;
            }
        }
        (self.count > 0).then_some(())
    }

    /// The vertices of an edge, as [`collect`](Self::collect) finds them, if there are just two in
    /// the mask.
    #[inline(always)]
    fn edge(
        facets: &Facets<'_>,
        near: LaneSet,
        dir: DVec3,
        slack: f64,
        place: impl Fn(DVec3) -> DVec3,
    ) -> Option<[(DVec3, u32); 2]> {
        let mut vertices = near.iter().take_while(|vertex| *vertex < facets.vertex_count());
        let (first, second) = (vertices.next()?, vertices.next()?);
        let (p, q) = (facets.vertex(first)?, facets.vertex(second)?);
        // NaN takes the failing branch.
        ((p.dot(dir) - q.dot(dir)).abs() <= slack && vertices.next().is_none())
            .then(|| [(place(p), first as u32), (place(q), second as u32)])
    }

    fn at(&self, index: usize) -> (DVec3, u32) {
        (self.points[index], self.vertices[index])
    }

    fn lowest(&self, dir: DVec3) -> (DVec3, u32) {
        let points = self.points.iter().take(self.count);
        let mut best = (f64::INFINITY, 0);
        for (index, point) in points.enumerate() {
            let height = point.dot(dir);
            if height < best.0 {
                best = (height, index);
            }
        }
        self.at(best.1)
    }
}

/// The witness points of A and B, and the sums of vertices that they are combined from.
pub(super) type Witness = ([DVec3; 2], [[u32; 2]; 3]);

/// The sum of a vertex of A and a mirrored one of B, less the foot.
#[derive(Clone, Copy)]
struct Sum {
    off: DVec3,
    a: DVec3,
    vertices: [u32; 2],
}

impl Sum {
    fn new((a, on_a): (DVec3, u32), (b, on_b): (DVec3, u32), foot: DVec3) -> Self {
        Self { off: (a + b) - foot, a, vertices: [on_a, on_b] }
    }
}

/// The parameters s and t from 0 to 1 at which p + s u + t v is closest to the origin; `None` if
/// they are not inside, or if u and v are parallel.
fn crossing(p: DVec3, u: DVec3, v: DVec3) -> Option<[f64; 2]> {
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let (pu, pv) = (p.dot(u), p.dot(v));
    let det = uu * vv - uv * uv;
    let (s, t) = ((uv * pv - vv * pu) / det, (uv * pu - uu * pv) / det);
    // NaN takes the failing branch.
    (det > 0.0 && (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some([s, t])
}

struct NearPass<'p, const P: usize> {
    /// B's vertices in the difference, in A's frame; A's, in B's frame.
    points: &'p [[PointBlock; P]; 2],
    /// The depth's normal in these frames: for A's vertices, which are mirrored, reversed twice.
    dirs: [DVec3; 2],
    margin: f32,
    near: [LaneSet; 2],
}

impl<const P: usize> Pass for NearPass<'_, P> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        for ((near, points), dir) in self.near.iter_mut().zip(self.points).zip(self.dirs) {
            *near = simd.near_farthest(points, dir.as_vec3().to_array(), self.margin);
        }
    }
}

/// The witness points of A and B for the depth of `bound`, opposite each other along its normal to
/// within `enough`; `None` if the foot is not in the facet.
pub(super) fn points<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const P: usize>(
    m: &Minkowski<'_, A, B>,
    [a, b]: &[Facets<'_>; 2],
    points: &[[PointBlock; P]; 2],
    error: f64,
    dispatch: Dispatch,
    &Bound { upper: depth, normal, .. }: &Bound,
    enough: f64,
) -> Option<Witness> {
    let slack = PLANE_ROUNDINGS * m.rounding_error() + 4.0 * (a.slack() + b.slack());
    let dirs = [normal, m.rotation().transpose() * -normal];
    let margin = (slack + 2.0 * error) as f32;
    let mut pass = NearPass { points, dirs, margin, near: [LaneSet::EMPTY; 2] };
    dispatch.pass(&mut pass);
    // Points of the difference for the point at the origin of A's frame.
    let place = |point: DVec3| m.point_of(DVec3::ZERO, point, [0; 2]).w;
    let foot = normal * depth;
    if let Some([a0, a1]) = Feature::edge(a, pass.near[1], dirs[0], slack, |point| point)
        && let Some([b0, b1]) = Feature::edge(b, pass.near[0], dirs[1], slack, place)
        && let ([u, v], [w, x]) = ([a0.0, a1.0], [b0.0, b1.0])
        && let Some([s, t]) = crossing(u + w - foot, v - u, x - w)
    {
        let (on_a, on_b) = (u + (v - u) * s, w + (x - w) * t);
        if (on_a + on_b - foot).length() <= enough {
            // The half of the parallelogram that the foot is in.
            let near = if s + t < 1.0 { [a0.1, b0.1] } else { [a1.1, b1.1] };
            return Some(([on_a, -on_b], [near, [a0.1, b1.1], [a1.1, b0.1]]));
        }
    }
    let (mut on_a, mut on_b) = (Feature::EMPTY, Feature::EMPTY);
    on_a.collect(a, pass.near[1], dirs[0], slack, |point| point)?;
    on_b.collect(b, pass.near[0], dirs[1], slack, place)?;
    let triangle = match (on_a.count, on_b.count) {
        (3, 1) => Some([0, 1, 2].map(|corner| Sum::new(on_a.at(corner), on_b.at(0), foot))),
        (1, 3) => Some([0, 1, 2].map(|corner| Sum::new(on_a.at(0), on_b.at(corner), foot))),
        _ => None,
    };
    if let Some(triangle) = triangle {
        // A vertex and a triangle.
        let [p, q, r] = triangle.map(|sum| sum.off);
        let nearest = on_triangle(p, q, r);
        if nearest.point.length() <= enough {
            return Some(combined(&triangle, nearest.weights, foot));
        }
    }
    nearest(&on_a, &on_b, foot, enough)
}

/// Step 3: the points of A and B of which the difference is the foot, to within `enough`.
fn nearest(on_a: &Feature, on_b: &Feature, foot: DVec3, enough: f64) -> Option<Witness> {
    let sum = |dir: DVec3| Sum::new(on_a.lowest(dir), on_b.lowest(dir), foot);
    let mut simplex = [sum(DVec3::ZERO); 3];
    let (mut weights, mut at) = ([1.0, 0.0, 0.0], simplex[0].off);
    for _ in 0..MAX_STEPS {
        if at.length() <= enough {
            break;
        }
        let next = sum(at);
        // NaN counts as no progress.
        if !(next.off.dot(at) < at.length_squared() - enough * at.length()) {
            break;
        }
        // Replace a vertex without weight.
        let free = if weights[1] == 0.0 {
            1
        } else if weights[2] == 0.0 {
            2
        } else {
            0
        };
        let mut larger = simplex;
        larger[free] = next;
        for (vertex, weight) in weights.iter().enumerate() {
            // Unused vertices repeat the new one.
            if *weight == 0.0 {
                larger[vertex] = next;
            }
        }
        let [p, q, r] = larger.map(|sum| sum.off);
        let nearest = on_triangle(p, q, r);
        if !(nearest.point.length_squared() < at.length_squared()) {
            break;
        }
        (simplex, weights, at) = (larger, nearest.weights, nearest.point);
    }
    // NaN takes the failing branch.
    (at.length() <= enough).then(|| combined(&simplex, weights, foot))
}

fn combined(simplex: &[Sum; 3], weights: [f64; 3], foot: DVec3) -> Witness {
    let mut point_a = DVec3::ZERO;
    let mut off = DVec3::ZERO;
    for (sum, weight) in simplex.iter().zip(weights) {
        point_a += sum.a * weight;
        off += sum.off * weight;
    }
    ([point_a, point_a - (foot + off)], simplex.map(|sum| sum.vertices))
}
