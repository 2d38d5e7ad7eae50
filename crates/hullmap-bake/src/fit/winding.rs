//! Winding number of a closed surface, which is an integer at every point off the surface.
//!
//! # Steps
//! 1. A ray counts crossings of triangles by their orientation. If it passes too close to an edge
//!    to be certain, another ray is cast.
//! 2. If all rays do, the caller may add the solid angles of all triangles.
//!
//! # Reference
//! - Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized
//!   winding numbers", 2013.
//! - Van Oosterom, Strackee, "The solid angle of a plane triangle", 1983.

use std::ops::ControlFlow;

use glam::DVec3;

use super::triangle_tree::{Bounds, TriangleTree};
use hullmap_geometry::{
    planes::HalfSpace,
    triangle::{self, Triangle},
};

/// Relative error up to which the side of an edge on which a ray passes is uncertain.
const UNCERTAIN: f64 = 1e-13;

pub(super) const RAYS: usize = 12;

/// Bound on rounding errors of lengths, relative to the greatest coordinate. A point this close to
/// a triangle is on it.
const ROUNDING: f64 = 1e-12;

/// A closed surface of triangles.
pub struct ClosedSurface {
    /// Triangles of the mesh, then the triangles that close it.
    pub(super) triangles: Vec<Triangle>,
    /// Whether the triangle counts for the winding number: others repeat a triangle, or have no
    /// area.
    pub(super) counts: Vec<bool>,
    pub(super) tree: TriangleTree,
    /// Diagonal of the box around the mesh.
    pub(super) diagonal: f64,
    pub(super) bounds: [DVec3; 2],
    /// Maximum distance by which a vertex was moved.
    pub(super) moved: f64,
    pub(super) rounding: f64,
    pub(super) needles: f64,
}

/// Why a ray does not decide whether a point is inside.
pub(super) enum Doubt {
    Edge,
    On(u32),
}

impl ClosedSurface {
    /// The surface of triangles, of which some count, in a box around the mesh.
    pub(super) fn new(triangles: Vec<Triangle>, counts: Vec<bool>, bounds: [DVec3; 2], moved: f64) -> Self {
        let diagonal = if triangles.is_empty() { 0.0 } else { bounds[0].distance(bounds[1]) };
        let tree = TriangleTree::new(&triangles);
        let rounding = ROUNDING * bounds[0].abs().max(bounds[1].abs()).max_element().max(0.0);
        let needles = triangles.iter().map(triangle::needle).fold(0.0, f64::max);
        Self { triangles, counts, tree, diagonal, bounds, moved, rounding, needles }
    }

    /// All triangles: the mesh's, then the triangles that close it.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Indices of the triangles whose boxes touch a box.
    pub fn triangles_in(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        let touches = |own: &Bounds| own.low.cmple(high).all() && own.high.cmpge(low).all();
        self.tree.for_each(touches, |index| found.push(index));
        found
    }

    /// Maximum error of distances: vertices that were moved together, needles, and rounding.
    pub fn tolerance(&self) -> f64 {
        self.moved + self.needles + self.rounding
    }

    /// Winding number of the surface about a point, with its sign; `None` if the point is so close
    /// to triangles that no ray is certain.
    pub fn winding_number(&self, p: DVec3) -> Option<i32> {
        if self.is_outside_bounds(p) {
            return Some(0);
        }
        (0..RAYS).find_map(|ray| self.crossings(p, ray_direction(ray)).ok())
    }

    /// Distance of a point from the nearest triangle that does not lie in `plane`; at most the
    /// diagonal.
    pub fn clearance(&self, p: DVec3, plane: &HalfSpace) -> f64 {
        let is_in_plane = |corner: &DVec3| plane.height(*corner).abs() <= self.tolerance();
        let counts = |index: usize| !self.triangles[index].iter().all(is_in_plane);
        self.nearest(p, self.diagonal, counts).map_or(self.diagonal, |(distance, _)| distance)
    }

    pub(super) fn is_outside_bounds(&self, p: DVec3) -> bool {
        (self.bounds[0] - p).max(p - self.bounds[1]).max_element() > 0.0
    }

    /// The nearest of the triangles that `counts`, with its distance.
    pub(super) fn nearest(&self, p: DVec3, within: f64, counts: impl Fn(usize) -> bool) -> Option<(f64, usize)> {
        // Squares, because roots take time.
        let to_box = |own: &Bounds| (own.low - p).max(p - own.high).max(DVec3::ZERO).length_squared();
        let to_triangle = |index: u32| {
            let index = index as usize;
            counts(index).then(|| triangle::nearest(&self.triangles[index], p).distance_squared(p))
        };
        let (square, index) = self.tree.lowest((within * within).min(f64::MAX), to_box, to_triangle)?;
        Some((square.sqrt(), index as usize))
    }

    /// Whether some triangle that `counts` is nearer than `within`, also with allowance for errors.
    pub(super) fn has_triangle_within(&self, p: DVec3, within: f64, counts: impl Fn(usize) -> bool) -> bool {
        let square = within * within;
        let is_near = |own: &Bounds| (own.low - p).max(p - own.high).max(DVec3::ZERO).length_squared() < square;
        let take = |index: u32| {
            let own = triangle::nearest(&self.triangles[index as usize], p).distance_squared(p);
            if counts(index as usize) && own < square && own.sqrt() + self.tolerance() <= within {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        self.tree.visit(is_near, take).is_break()
    }

    /// Winding number, as the signed number of triangles that a ray crosses.
    pub(super) fn crossings(&self, p: DVec3, direction: DVec3) -> Result<i32, Doubt> {
        let inverse = direction.recip();
        let margin = self.rounding;
        let is_hit = |own: &Bounds| {
            let (s, t) = ((own.low - p - margin) * inverse, (own.high - p + margin) * inverse);
            let (enter, leave) = (s.min(t).max_element(), s.max(t).min_element());
            leave >= 0.0 && enter <= leave
        };
        let mut winding = 0;
        let count = |index: u32| {
            if !self.counts[index as usize] {
                return ControlFlow::Continue(());
            }
            let triangle = &self.triangles[index as usize];
            match crossing(triangle, p, direction) {
                Some(crossed) => winding += crossed,
                None if triangle::nearest(triangle, p).distance(p) <= self.rounding => {
                    return ControlFlow::Break(Doubt::On(index));
                }
                None => return ControlFlow::Break(Doubt::Edge),
            }
            ControlFlow::Continue(())
        };
        match self.tree.visit(is_hit, count) {
            ControlFlow::Break(doubt) => Err(doubt),
            ControlFlow::Continue(()) => Ok(winding),
        }
    }

    /// Winding number as the sum of all solid angles: slow, with an error far below a half.
    pub(super) fn solid_angles(&self, p: DVec3) -> i32 {
        let mut sum = 0.0;
        for ([a, b, c], counts) in self.triangles.iter().zip(&self.counts) {
            if *counts {
                let [a, b, c] = [*a - p, *b - p, *c - p];
                let [la, lb, lc] = [a.length(), b.length(), c.length()];
                let volume = a.dot(b.cross(c));
                let scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
                sum += 2.0 * libm::atan2(volume, scale);
            }
        }
        let turns = sum / (4.0 * std::f64::consts::PI);
        turns.round() as i32
    }
}

pub(super) fn ray_direction(index: usize) -> DVec3 {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    let z = 1.0 - (2 * index + 1) as f64 / RAYS as f64;
    let radius = (1.0 - z * z).sqrt();
    // The first angle is arbitrary.
    let angle = GOLDEN * index as f64 + 0.381;
    DVec3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
}

/// −1, 0 or 1: how a ray from `p` crosses a triangle; `None` if that is uncertain.
fn crossing(triangle: &Triangle, p: DVec3, direction: DVec3) -> Option<i32> {
    let [a, b, c] = triangle.map(|corner| corner - p);
    let ahead = [a, b, c].map(|corner| corner.dot(direction));
    let size = a.abs().max(b.abs()).max(c.abs()).max_element();
    if ahead.iter().all(|along| *along < -UNCERTAIN * size) {
        return Some(0);
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let volume = direction.dot(from.cross(to));
        let error = UNCERTAIN * from.length() * to.length();
        if volume > error {
            1
        } else if volume < -error {
            -1
        } else {
            0
        }
    });
    if sides.contains(&1) && sides.contains(&-1) {
        return Some(0);
    }
    if sides.contains(&0) {
        return None;
    }
    // The line crosses the triangle. The ray does if the plane lies ahead.
    let is_ahead = if ahead.iter().all(|along| *along > UNCERTAIN * size) {
        true
    } else {
        let normal = (b - a).cross(c - a);
        let height = a.dot(normal);
        // Edges may be much shorter than their distance: the normal's error comes from the edges.
        let error = UNCERTAIN * size * (b - a).length() * (c - a).length();
        if height.abs() <= error {
            return None;
        }
        (height > 0.0) == (direction.dot(normal) > 0.0)
    };
    Some(if is_ahead { sides[0] } else { 0 })
}
