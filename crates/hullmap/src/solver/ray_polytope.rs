//! Ray cast of a polytope that the ray grazes: decided exactly, from the vertices.
//!
//! The portal search (`line`) cannot decide whether a ray in the face of a box meets the box. Seen
//! along the ray, this is a question about the convex hull of points in the plane, whose signs are
//! exact ([`exact_ray`](super::exact_ray)).
//!
//! # Steps
//! 1. Seen along the ray, keep the wedge from the line that holds all vertices so far. A vertex
//!    beyond 180 degrees closes it: its triangle with both sides of the wedge holds the line. If
//!    none does, the line misses.
//! 2. The simplex method: replace a corner of the triangle by the vertex farthest in front of it,
//!    so that the line still meets it, until no vertex is in front. Then the triangle is on the
//!    surface, where the line enters.
//! 3. If this is behind the start of the ray, look for a point of the polytope ahead in the same
//!    way.
//!
//! # Reference
//! Dantzig, "Linear Programming and Extensions", 1963; Bland, "New Finite Pivoting Rules for the
//! Simplex Method", 1977. docs/contributors/intervals.md, section 11, has the proof.

use glam::DVec3;

use super::exact_ray::{ExactRay, Meeting};
use super::motion::{CastSettings, Ray};
use super::ray_hit::RayHit;
use super::status::Status;

/// Maximum number of triangles on the way to the surface. Most rays need 1 to 5.
const MAX_PIVOTS: u32 = 100;

/// Number of triangles after which Bland's rule chooses the next vertex and the corner that it
/// replaces: the first ones in a fixed order. Where several triangles meet the line in one point,
/// the farthest vertex may lead around in a circle.
const STEADY_PIVOTS: u32 = 20;

/// Vertices of a polytope, from the index 0 on.
pub(super) type Vertices<'v> = &'v dyn Fn(u32) -> Option<DVec3>;

/// Exact answer for a ray that grazes a polytope of an outer radius, or meets it near its end.
/// `grazing` stays if the search reaches its limit without a decision.
#[cold]
#[inline(never)]
pub(super) fn ray_polytope(
    vertices: Vertices<'_>,
    ray: &Ray,
    settings: &CastSettings,
    radius: f64,
    grazing: RayHit,
) -> RayHit {
    let RayHit { iterations, support_calls, .. } = grazing;
    let miss = RayHit { iterations, support_calls, normal: grazing.normal, ..RayHit::miss(ray) };
    let search = Search { line: ExactRay::new(ray, settings), vertices };
    let mut found = Meeting::new();
    let Some(start) = search.start(&mut found) else { return miss };
    let (mut entry, mut exit) = (start, start);
    let is_first = search.refine(&mut entry, Side::Front, &mut found);
    let is_last = found.is_ahead || search.refine(&mut exit, Side::Back, &mut found);
    if is_last && !found.is_ahead {
        return miss;
    }
    if !found.is_hit() {
        return if is_first && found.is_ahead { miss } else { grazing };
    }
    let [mut t_lower, t, t_upper] = found.entry(&search.line);
    let mut status = Status::Exact;
    if !is_first && !found.is_behind {
        t_lower = grazing.t_lower.min(t_lower);
        let width = ray.motion().path().map_or(0.0, |path| path.length(t_upper - t_lower));
        status = if width <= settings.relative_tolerance() * radius { Status::Within } else { Status::Stalled };
    }
    let point = ray.point_at(t);
    let normal = if found.is_behind { search.line.against() } else { search.outward(entry, point, grazing.normal) };
    RayHit { hit: true, status, t, t_lower, t_upper, point, normal, ..miss }
}

/// A side of a triangle, seen along the ray.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Front,
    Back,
}

/// Any order of points.
fn order(p: DVec3, q: DVec3) -> std::cmp::Ordering {
    p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z))
}

struct Search<'v> {
    line: ExactRay,
    vertices: Vertices<'v>,
}

impl Search<'_> {
    fn each(&self) -> impl Iterator<Item = DVec3> {
        (0..).map_while(self.vertices)
    }

    /// Step 1: a triangle of vertices that the line meets, not edge-on. `None` if it misses the
    /// polytope. Adds the vertices on the line: if it runs along an edge, the line enters at one of
    /// them.
    ///
    /// If all vertices are in one plane with the line, a corner of the triangle is a point beside
    /// this plane. The hull of this point and the polytope meets the plane in the polytope alone.
    fn start(&self, found: &mut Meeting) -> Option<[DVec3; 3]> {
        let line = &self.line;
        // Sides of the wedge, the clockwise one first; a vertex on the line, or two on opposite
        // sides of it.
        let (mut wedge, mut through): (Option<[DVec3; 2]>, Option<[DVec3; 2]>) = (None, None);
        for vertex in self.each() {
            let Some([right, left]) = wedge else {
                if line.is_on(vertex) {
                    line.meet([vertex; 3], found);
                    through = Some([vertex; 2]);
                } else {
                    wedge = Some([vertex; 2]);
                }
                continue;
            };
            // Positive if the vertex is counter-clockwise of the side.
            match (line.turn(right, vertex), line.turn(left, vertex)) {
                (0, 0) if line.is_on(vertex) => {
                    line.meet([vertex; 3], found);
                    through = Some([vertex; 2]);
                }
                (0, 0) if line.is_between(right, vertex) => through = Some([right, vertex]),
                (1, 1) => wedge = Some([right, vertex]),
                (-1, -1) => wedge = Some([vertex, left]),
                (-1, 0 | 1) | (0, 1) => return Some([right, left, vertex]),
                _ => {}
            }
        }
        let [p, q] = through?;
        let [x, y, z] = DVec3::AXES;
        let beside = [DVec3::ZERO, x, y, z];
        let sides = wedge.into_iter().flatten().chain(beside);
        if p != q {
            return sides.map(|side| [p, q, side]).find(|triangle| line.pierces(*triangle));
        }
        let mut pairs = sides.clone().flat_map(|side| sides.clone().map(move |other| [p, side, other]));
        pairs.find(|triangle| line.pierces(*triangle))
    }

    /// The normal of a triangle on the front, or another one if the polytope extends less beyond
    /// its plane through a point.
    fn outward(&self, triangle: [DVec3; 3], point: DVec3, other: DVec3) -> DVec3 {
        let own = self.line.outward(triangle).unwrap_or(other);
        let beyond = |normal: DVec3| self.each().map(|v| (v - point).dot(normal)).fold(0.0, f64::max);
        if beyond(own) <= beyond(other) { own } else { other }
    }

    /// Step 2 or 3: moves a triangle to the front or the back of the polytope. Returns whether it
    /// is there; it stops before if it is known that the ray starts inside.
    fn refine(&self, triangle: &mut [DVec3; 3], side: Side, found: &mut Meeting) -> bool {
        for round in 0..MAX_PIVOTS {
            self.line.meet(*triangle, found);
            let is_enough = if side == Side::Front { found.is_behind } else { found.is_ahead };
            let facing = self.line.facing(*triangle);
            let sense = if side == Side::Front { -1.0 } else { 1.0 };
            let heights = self.each().map(|vertex| (sense * self.line.beyond(*triangle, facing, vertex), vertex));
            let farther = heights.filter(|(height, _)| *height > 0.0);
            let is_steady = round < STEADY_PIVOTS;
            let vertex = if is_steady {
                farther.max_by(|p, q| p.0.total_cmp(&q.0))
            } else {
                farther.min_by(|p, q| order(p.1, q.1))
            };
            let Some((_, vertex)) = vertex.filter(|_| !is_enough) else { return true };
            let [a, b, c] = *triangle;
            let mut next = [(a, [vertex, b, c]), (b, [a, vertex, c]), (c, [a, b, vertex])];
            next.rotate_left(round as usize % 3);
            // At least one of the three does.
            let mut next = next.into_iter().filter(|(_, next)| self.line.pierces(*next));
            let next = if is_steady { next.next() } else { next.min_by(|p, q| order(p.0, q.0)) };
            let Some((_, next)) = next else { return false };
            *triangle = next;
        }
        false
    }
}
