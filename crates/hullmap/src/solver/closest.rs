//! Distance phase: the point of the Minkowski difference nearest to the origin (GJK).
//!
//! # Reference
//! Gilbert, Johnson, Keerthi 1988, cited by Kenwright as [5]; the interval is that of their error bound.
//!
//! # Steps
//! 1. y = point nearest to the origin on the simplex; drop the vertices that have no part in it;
//! 2. w = support along −y; the plane through w bounds the distance from below by w · y / |y|, |y| bounds it from above;
//! 3. stop when the two are close enough; otherwise add w to the simplex; again.
//!
//! # Deviations
//! - The lower bound is the running maximum and the upper the running minimum: both hold at any time, whatever
//!   rounding does to a single step.
//! - Repeated vertices and steps that do not come nearer end the search as a status.

use super::barycentric::{self, blend};
use crate::SupportMap;
use crate::minkowski::{Minkowski, Point};
use glam::DVec3;

/// Most steps, whatever the settings. Polytopes need 5 to 30; smooth shapes at the tightest tolerance about 200.
const MAX_CLOSEST: u32 = 1000;

/// At most four vertices and the weights of their point nearest to the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simplex {
    vertices: [Point; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    pub(super) fn new(vertex: Point) -> Self {
        Self { vertices: [vertex; 4], weights: [1.0, 0.0, 0.0, 0.0], count: 1 }
    }

    /// Adds a vertex; there must be room, which [`nearest`](Self::nearest) makes.
    pub(super) fn push(&mut self, vertex: Point) {
        self.vertices[self.count] = vertex;
        self.weights[self.count] = 0.0;
        self.count += 1;
    }

    pub(super) fn points(&self) -> &[Point] {
        &self.vertices[..self.count]
    }

    /// The point of A and the point of B at the weights.
    pub(super) fn witnesses(&self) -> (DVec3, DVec3) {
        // Weights beyond the count are zero.
        (blend(&self.weights, self.vertices.map(|v| v.a)), blend(&self.weights, self.vertices.map(|v| v.b())))
    }

    /// Point of the simplex nearest to the origin, and the origin's distance from the surface if it is inside, 0 otherwise. Keeps
    /// only the vertices the point is made of: all four when the origin is inside.
    fn nearest(&mut self) -> (DVec3, f64) {
        let [p, q, r, s] = self.vertices.map(|v| v.w);
        let mut clearance = 0.0;
        let mut weights = [0.0; 4];
        let point = match self.count {
            1 => {
                weights[0] = 1.0;
                p
            }
            2 => {
                let on = barycentric::on_segment(p, q);
                weights[..2].copy_from_slice(&on.weights);
                on.point
            }
            3 => {
                let on = barycentric::on_triangle(p, q, r);
                weights[..3].copy_from_slice(&on.weights);
                on.point
            }
            _ => {
                let (on, within) = barycentric::on_tetrahedron([p, q, r, s]);
                clearance = within;
                weights = on.weights;
                on.point
            }
        };
        let mut kept = 0;
        for (i, weight) in weights.into_iter().enumerate().take(self.count) {
            if weight > 0.0 {
                self.vertices[kept] = self.vertices[i];
                self.weights[kept] = weight;
                kept += 1;
            }
        }
        // NaN weights keep nothing: stay with the first vertex.
        if kept == 0 {
            *self = Self::new(self.vertices[0]);
            return (self.vertices[0].w, 0.0);
        }
        self.count = kept;
        self.weights[kept..].fill(0.0);
        (point, clearance)
    }
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The interval is narrow enough.
    Converged,
    /// The origin is inside the simplex, clear of its faces by more than rounding.
    Inside,
    /// The nearest point is the origin, within rounding, on the simplex or a hair inside.
    AtOrigin,
    /// The cap was reached.
    Limit,
    /// Rounding stopped all progress.
    Stalled,
}

/// The nearest point and its bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub(super) end: End,
    pub(super) simplex: Simplex,
    /// Greatest distance known to be free, without allowance for rounding; can be negative.
    pub(super) lower: f64,
    /// Length of the nearest point found, without allowance for rounding.
    pub(super) upper: f64,
    /// Unit direction from A to B along the nearest point; zero when none was found.
    pub(super) normal: DVec3,
    pub(super) iterations: u32,
}

/// Searches from `simplex` until upper − lower ≤ `tolerance` · upper + rounding.
pub(super) fn closest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    mut simplex: Simplex,
    tolerance: f64,
    max_iterations: u32,
) -> Closest {
    let rounding = m.rounding();
    let mut best = Closest {
        end: End::Limit,
        simplex,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        normal: DVec3::ZERO,
        iterations: 0,
    };
    // At least once: without a step there is no bound at all.
    for _ in 0..max_iterations.clamp(1, MAX_CLOSEST) {
        best.iterations += 1;
        let (y, clearance) = simplex.nearest();
        if clearance > 0.0 {
            // A hair inside may be a hair outside.
            let end = if clearance > rounding { End::Inside } else { End::AtOrigin };
            return Closest { end, simplex, upper: 0.0, ..best };
        }
        let length = y.length();
        // NaN counts as no progress.
        let nearer = length < best.upper;
        if !nearer {
            return Closest { end: End::Stalled, ..best };
        }
        (best.simplex, best.upper) = (simplex, length);
        if length <= rounding {
            return Closest { end: End::AtOrigin, ..best };
        }
        let outward = y / length;
        best.normal = -outward;
        let vertex = m.point(-outward);
        best.lower = best.lower.max(vertex.w.dot(outward));
        if best.upper - best.lower <= tolerance * best.upper + rounding {
            return Closest { end: End::Converged, ..best };
        }
        if simplex.points().iter().any(|v| v.w == vertex.w) {
            return Closest { end: End::Stalled, ..best };
        }
        simplex.push(vertex);
    }
    best
}
