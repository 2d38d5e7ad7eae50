//! Proof of coverage: an upper bound on the distance of any point of a mesh's surface from the
//! nearest part.
//!
//! # Steps
//! 1. Measure each vertex against the parts near it. A triangle whose corners lie in one part is
//!    covered.
//! 2. Subtract the parts from every other triangle, one part after the other. Convex polygons are
//!    left.
//! 3. Branch and bound over triangles of these: a triangle is bounded by the distances of its
//!    corners from one part.
//!
//! # Why the bound holds
//! The distance from a convex set is a convex function, so over a triangle it is greatest at a
//! corner. The distance from the union of the parts is at most that from one of them. Distances are
//! measured to convex combinations of a part's vertices, so none is too small except for rounding.
//!
//! # Complexity
//! One nearest-point search (GJK) per vertex and part near it, plus a bounded number of cells.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    branch::{Accuracy, Maximum, Measured, maximum},
    triangle_tree::{Bounds, TriangleTree},
};
use crate::{
    deadline::{Deadline, is_over},
    hull::Hull,
    simplify::nearest::Nearest,
};
use hullmap_geometry::{
    PointSet, bounds,
    planes::{self, HalfSpace},
    triangle::{self, Triangle},
};

/// How far a mesh's surface lies outside its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncovered {
    /// Upper bound, proven; infinite if there are triangles but no parts.
    pub bound: f64,
    /// Distance from the parts at [`at`](Self::at).
    pub reached: f64,
    /// A point of the surface.
    pub at: DVec3,
}

/// Tolerances `[outside, error]` for the subtraction of parts, relative to the diagonal, in the
/// order of trial. A point at most `outside` above all face planes counts as inside. A subtracted
/// piece is accepted if it is nowhere farther than `error` from the part.
///
/// F32 parts miss the surface by 1e-8 to 3e-7. Without a tolerance, all narrow gaps would be left
/// as pieces that reach from part to part. The second pair is for acute edges, where a point close
/// to both planes can be far from the part. The third is for wider gaps.
const INSIDE: [[f64; 2]; 3] = [[4e-8, 8e-8], [1e-12, f64::INFINITY], [3e-7, 6e-7]];

/// Accuracy of the bound, relative to the diagonal.
const ACCURACY: f64 = 2e-8;

/// Number of measurements after which branch and bound splits no more cells.
const MEASUREMENTS: usize = 100_000;

/// Number of measurements to decide one triangle.
const OF_A_TRIANGLE: usize = 2_000;

/// Maximum number of pieces of one triangle, after which no more parts are subtracted.
const MAX_PIECES: usize = 4096;

/// The greatest distance of a point on the triangles of `mesh` from the nearest of `parts`. All are
/// in the same frame.
pub fn uncovered(mesh: &PointSet, parts: &[&Hull]) -> Uncovered {
    uncovered_until(mesh, parts, None)
}

/// As [`uncovered()`]. After the deadline, the bound is not improved, but holds.
pub fn uncovered_until(mesh: &PointSet, parts: &[&Hull], deadline: Option<Deadline>) -> Uncovered {
    let positions = mesh.points();
    let [low, high] = bounds(positions.iter().copied());
    let diagonal = if positions.is_empty() { 0.0 } else { low.distance(high) };
    let parts = Parts::new(parts);
    // Points of a cloud are covered one by one.
    let points = if mesh.triangles.is_empty() { &positions[..] } else { &[] };
    let seeds: Vec<(Vec<Triangle>, f64)> = mesh
        .triangles
        .par_iter()
        .map(|t| t.map(|v| positions[v as usize]))
        .chain(points.par_iter().map(|p| [*p; 3]))
        .map(|corners| left_over(&corners, &parts, diagonal))
        .collect();
    let subtracted = seeds.iter().map(|(_, distance)| *distance).fold(0.0, f64::max);
    let cells = seeds.into_iter().flat_map(|(cells, _)| cells);
    let measure = |cell: &mut Triangle, _: f64| measured(cell, &parts);
    let accuracy = Accuracy {
        absolute: ACCURACY * diagonal,
        floor: subtracted,
        measurements: MEASUREMENTS,
        deadline,
        ..Accuracy::tight(diagonal)
    };
    let Maximum { bound, reached, at, .. } = maximum(cells, &accuracy, measure, triangle::halves);
    Uncovered { bound: bound.max(subtracted), reached, at }
}

/// Ascending indices of the triangles that are not proven to lie within `limit` of the parts. Stops
/// at the deadline.
///
/// # Complexity
/// The cost of [`uncovered()`], with up to 2,000 cells for each triangle.
pub fn uncovered_triangles(mesh: &PointSet, parts: &[&Hull], limit: f64, deadline: Option<Deadline>) -> Vec<usize> {
    let [low, high] = bounds(mesh.triangles.iter().flatten().map(|v| mesh.at(*v)));
    let diagonal = low.distance(high);
    let parts = Parts::new(parts);
    let is_uncovered = |triangle: &[u32; 3]| {
        if is_over(deadline) {
            return false;
        }
        let (pieces, subtracted) = left_over(&mesh.corners(triangle), &parts, diagonal);
        let accuracy =
            Accuracy { limit: Some(limit), measurements: OF_A_TRIANGLE, deadline, ..Accuracy::tight(diagonal) };
        let rest = maximum(pieces, &accuracy, |piece: &mut Triangle, _: f64| measured(piece, &parts), triangle::halves);
        // Written so that NaN counts as uncovered.
        !(subtracted.max(rest.bound) <= limit)
    };
    let found: Vec<bool> = mesh.triangles.par_iter().map(is_uncovered).collect();
    (0..found.len()).filter(|index| found[*index]).collect()
}

struct Parts {
    all: Vec<PartShape>,
    tree: TriangleTree,
}

impl Parts {
    fn new(hulls: &[&Hull]) -> Self {
        let bounds = hulls.iter().map(|hull| Bounds::around(&hull.positions()));
        Self { tree: TriangleTree::of_boxes(bounds), all: hulls.iter().map(|hull| PartShape::new(hull)).collect() }
    }

    fn solids_near(&self, bounds: &Bounds) -> Vec<&PartShape> {
        let mut near = Vec::new();
        self.tree.for_each(|part| part.touches(bounds), |part| near.push(part));
        near.sort_unstable();
        near.into_iter().map(|part| &self.all[part as usize]).filter(|part| part.is_solid).collect()
    }

    /// Distance of the farthest of some points from the part nearest to it; infinite without parts.
    fn distance(&self, corners: &[DVec3]) -> f64 {
        let of_box = |bounds: &Bounds| corners.iter().map(|p| bounds.distance(*p)).fold(0.0, f64::max);
        let of_part = |part: u32| Some(self.all[part as usize].farthest(corners));
        self.tree.lowest(f64::INFINITY, of_box, of_part).map_or(f64::INFINITY, |(distance, _)| distance)
    }
}

struct PartShape {
    nearest: Nearest,
    planes: Vec<HalfSpace>,
    is_solid: bool,
}

impl PartShape {
    fn new(hull: &Hull) -> Self {
        let is_solid = hull.rank == 3;
        let planes = if is_solid { hull.half_spaces() } else { Vec::new() };
        Self { nearest: Nearest::new(hull), planes, is_solid }
    }

    /// Upper bound on the distance of a point, exact except for rounding. Each search starts at
    /// vertex `start` and sets it to a vertex near the point.
    fn distance(&self, p: DVec3, start: &mut u32) -> f64 {
        let foot = if self.is_solid { self.nearest.nearest_from(p, *start) } else { self.nearest.certain(p) };
        *start = foot.vertex;
        foot.point.distance(p)
    }

    fn farthest(&self, corners: &[DVec3]) -> f64 {
        let mut start = 0;
        corners.iter().map(|p| self.distance(*p, &mut start)).fold(0.0, f64::max)
    }
}

/// The rest of a triangle outside the parts, and the greatest distance of a subtracted piece from
/// the part that contains it.
fn left_over(corners: &Triangle, parts: &Parts, diagonal: f64) -> (Vec<Triangle>, f64) {
    let [outside, error] = INSIDE[0].map(|distance| distance * diagonal);
    let near = parts.solids_near(&Bounds::around(corners).grown(outside));
    let contains =
        |part: &&&PartShape| part.planes.iter().all(|plane| corners.iter().all(|p| plane.height(*p) <= outside));
    let mut left = None;
    for whole in near.iter().filter(contains) {
        let distance = whole.farthest(corners);
        if distance <= error {
            return (Vec::new(), distance);
        }
    }
    for [outside, error] in INSIDE {
        let next = subtract(corners, &near, outside * diagonal);
        let is_accepted = next.1 <= error * diagonal;
        if is_accepted && next.0.is_empty() {
            return next;
        }
        // The coarser of two accepted results has fewer pieces.
        if is_accepted && (outside > INSIDE[0][0] || left.is_none()) {
            left = Some(next);
        }
    }
    left.unwrap_or_else(|| (vec![*corners], 0.0))
}

fn subtract(corners: &Triangle, parts: &[&PartShape], tolerance: f64) -> (Vec<Triangle>, f64) {
    let mut pieces = vec![corners.to_vec()];
    let mut subtracted = 0.0_f64;
    for part in parts {
        let mut left = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let (inside, outside) = planes::divide(&piece, &part.planes, tolerance);
            subtracted = subtracted.max(part.farthest(&inside));
            left.extend(outside);
        }
        pieces = left;
        if pieces.len() > MAX_PIECES {
            break;
        }
    }
    (pieces.iter().flat_map(|piece| planes::fan(piece)).collect(), subtracted)
}

fn measured(corners: &Triangle, parts: &Parts) -> Measured {
    let (centre, radius) = triangle::ball(corners);
    let (bound, reached) = (parts.distance(corners), parts.distance(&[centre]));
    let is_empty = parts.all.is_empty();
    Measured { bound: bound.min(reached + radius), reached: if is_empty { 0.0 } else { reached }, at: centre }
}
