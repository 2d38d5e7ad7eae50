//! Winding number of a closed triangle mesh around a point, by exact arithmetic.
//!
//! # Steps
//! 1. Take the ray from the point along an axis that leaves the bounds of the mesh first.
//! 2. Descend the tree of boxes for the triangles that the ray may cross.
//! 3. Decide each crossing by the signs of three areas, in projection along the axis, and of one
//!    volume. A point above an edge or a corner counts as moved by an infinitesimal amount, always
//!    in the same direction, so that exactly one of the triangles there is crossed.
//! 4. A crossing from back to front counts as one, from front to back as minus one.
//!
//! # Reference
//! Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
//! 1997, by the crate `robust`. Edelsbrunner, Mücke, "Simulation of Simplicity", 1990. Jacobson,
//! Kavan, Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers",
//! 2013.

#![forbid(unsafe_code)]

use arrayvec::ArrayVec;
use glam::DVec3;
use hullmap_format::bvh::MAX_LEVELS;
use hullmap_format::triangle_mesh::tree;
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::TriangleMesh;

/// Coordinates below this count as 0: products with the smallest ones of f32 would underflow.
pub(crate) const TINY: f64 = 1e-60;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    On,
    /// Beside the surface, which winds around the point this many times, counter-clockwise seen
    /// from the front.
    Around(i64),
}

/// The ray from a point along an axis, with the coordinates turned so that it is the first one.
struct AxisRay {
    axis: usize,
    /// Whether the ray goes down.
    is_down: bool,
    point: [f64; 3],
}

impl AxisRay {
    /// The ray from `point` that leaves a box on the shortest way.
    fn leaving([low, high]: [DVec3; 2], point: DVec3) -> Self {
        let up = (high - point).to_array().map(|way| (way, false));
        let down = (point - low).to_array().map(|way| (way, true));
        let ways = up.into_iter().zip(0..).chain(down.into_iter().zip(0..));
        let ((_, is_down), axis) = ways.min_by(|p, q| p.0.0.total_cmp(&q.0.0)).unwrap_or(((0.0, false), 0));
        let point = point.to_array().map(|c| if c.abs() < TINY { 0.0 } else { c });
        let mut ray = Self { axis, is_down, point };
        ray.point = ray.turned(point);
        ray
    }

    /// Coordinates of a point, that along the ray first. The orientation stays.
    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.axis {
            0 => [x, y, z],
            1 => [y, z, x],
            _ => [z, x, y],
        }
    }

    fn meets(&self, corners: [DVec3; 2]) -> bool {
        let [[x0, y0, z0], [x1, y1, z1]] = corners.map(|corner| self.turned(corner.to_array()));
        let [x, y, z] = self.point;
        let is_ahead = if self.is_down { x0 <= x } else { x <= x1 };
        is_ahead && y0 <= y && y <= y1 && z0 <= z && z <= z1
    }

    /// How a triangle adds to the winding number; `None` if the point is on it.
    fn crossing(&self, corners: [DVec3; 3]) -> Option<i64> {
        let [a, b, c] = corners.map(|corner| self.turned(corner.to_array()));
        let sides = [self.side(a, b), self.side(b, c), self.side(c, a)];
        let turn = sides[0];
        if turn == 0.0 || sides.iter().any(|side| *side != turn) {
            return Some(0);
        }
        let [a, b, c, point] = [a, b, c, self.point].map(|[x, y, z]| Coord3D { x, y, z });
        // Positive behind the front.
        let behind = orient3d(a, b, c, point);
        if behind == 0.0 {
            return None;
        }
        let is_above = (behind > 0.0) == (turn > 0.0);
        let is_crossed = is_above != self.is_down;
        // The front points along the ray if the turn is positive and the ray goes up.
        let along = if self.is_down { -turn } else { turn };
        Some(if is_crossed { along as i64 } else { 0 })
    }

    /// On which side of the line through two points, in projection along the ray, the point is that
    /// has moved by an infinitesimal amount: 1 to the left, −1 to the right, 0 without a line.
    fn side(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [from, to, point] = [from, to, self.point].map(|[_, x, y]| Coord { x, y });
        let area = orient2d(from, to, point);
        // It has moved along the second axis, and by the square of that along the third one.
        let sides = [area, from.y - to.y, to.x - from.x];
        sides.into_iter().find(|side| *side != 0.0).map_or(0.0, f64::signum)
    }
}

impl TriangleMesh {
    /// Where a point is. The number means something for watertight meshes only.
    ///
    /// # Complexity
    /// One descent of the tree, along an axis.
    pub(crate) fn place(&self, point: DVec3) -> Place {
        let ray = AxisRay::leaving(self.bounds().map(|corner| corner.as_dvec3()), point);
        let mut stack: ArrayVec<u32, { MAX_LEVELS as usize + 1 }> = [0].into_iter().collect();
        let mut winding = 0;
        while let Some(index) = stack.pop() {
            let Some((corners, [start, end])) = self.node(index) else { continue };
            if !ray.meets(corners) {
                continue;
            }
            if end - start == 1 {
                let Some(triangle) = self.triangle(start) else { continue };
                match ray.crossing(triangle.corners()) {
                    Some(turn) => winding += turn,
                    None => return Place::On,
                }
                continue;
            }
            let first = tree::first_child(index);
            for child in [first, first.saturating_add(1)] {
                let _ = stack.try_push(child);
            }
        }
        Place::Around(winding)
    }
}
