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
//! - The nearest point is sought only on what has the newest vertex in it; if that comes no nearer, on the whole simplex.
//! - Repeated vertices and steps that do not come nearer end the search as a status.

use super::barycentric::{Nearest, blend, on_simplex, on_simplex_with_last};
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
        let mut vertices = [Point::EMPTY; 4];
        vertices[0] = vertex;
        Self { vertices, weights: [1.0, 0.0, 0.0, 0.0], count: 1 }
    }

    /// Adds a vertex; there must be room, which [`keep`](Self::keep) makes.
    #[inline]
    pub(super) fn push(&mut self, vertex: Point) {
        self.vertices[self.count] = vertex;
        self.weights[self.count] = 0.0;
        self.count += 1;
    }

    pub(super) fn points(&self) -> &[Point] {
        &self.vertices[..self.count]
    }

    /// The points of A and of B at the weights, and their difference.
    pub(super) fn witnesses(&self) -> (DVec3, DVec3, DVec3) {
        let mut weights = self.weights;
        weights[self.count..].fill(0.0);
        let mut vertices = self.vertices;
        vertices[self.count..].fill(self.vertices[0]);
        let w = blend(&weights, vertices.map(|v| v.w));
        let a = blend(&weights, vertices.map(|v| v.a));
        (a, a - w, w)
    }

    #[inline]
    fn corners(&self) -> [DVec3; 4] {
        [self.vertices[0].w, self.vertices[1].w, self.vertices[2].w, self.vertices[3].w]
    }

    /// Keeps only the vertices that have a weight.
    #[inline]
    fn keep(&mut self, weights: [f64; 4]) {
        let mut kept = 0;
        for (i, weight) in weights.into_iter().enumerate().take(self.count) {
            if weight > 0.0 {
                if kept != i {
                    self.vertices[kept] = self.vertices[i];
                }
                self.weights[kept] = weight;
                kept += 1;
            }
        }
        // NaN weights keep nothing: stay with the first vertex.
        if kept == 0 {
            (kept, self.weights[0]) = (1, 1.0);
        }
        self.count = kept;
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

/// The nearest point and its bounds; the simplex is left where the search began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub(super) end: End,
    /// Greatest distance known to be free, without allowance for rounding; can be negative.
    pub(super) lower: f64,
    /// Length of the nearest point found, without allowance for rounding.
    pub(super) upper: f64,
    /// Unit direction from A to B along the nearest point; zero when none was found.
    pub(super) normal: DVec3,
    pub(super) iterations: u32,
}

/// Searches from `simplex`, in place, until upper − lower ≤ `tolerance` · upper + rounding.
pub(super) fn closest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    simplex: &mut Simplex,
    tolerance: f64,
    max_iterations: u32,
) -> Closest {
    let rounding = m.rounding();
    let mut lower = f64::NEG_INFINITY;
    let mut upper = f64::INFINITY;
    let mut normal = DVec3::ZERO;
    // At least once: without a step there is no bound at all.
    let most = max_iterations.clamp(1, MAX_CLOSEST);
    for iterations in 1..=most {
        let (mut nearest, mut clearance) = if iterations == 1 {
            on_simplex(simplex.corners(), simplex.count)
        } else {
            on_simplex_with_last(simplex.corners(), simplex.count)
        };
        let mut length = nearest.point.length();
        // NaN counts as no progress, here and below.
        if !(length < upper || clearance > 0.0) {
            (nearest, clearance) = on_simplex(simplex.corners(), simplex.count);
            length = nearest.point.length();
        }
        let Nearest { weights, point: y } = nearest;
        if clearance > 0.0 {
            simplex.keep(weights);
            // A hair inside may be a hair outside.
            let end = if clearance > rounding { End::Inside } else { End::AtOrigin };
            return Closest { end, lower, upper: 0.0, normal, iterations };
        }
        let nearer = length < upper;
        if !nearer {
            // Without the last vertex it is what it was.
            simplex.count = (simplex.count - 1).max(1);
            return Closest { end: End::Stalled, lower, upper, normal, iterations };
        }
        simplex.keep(weights);
        upper = length;
        if length <= rounding {
            return Closest { end: End::AtOrigin, lower, upper, normal, iterations };
        }
        let vertex = m.point(-y);
        let scale = 1.0 / length;
        normal = y * -scale;
        lower = lower.max(vertex.w.dot(y) * scale);
        if upper - lower <= tolerance * upper + rounding {
            return Closest { end: End::Converged, lower, upper, normal, iterations };
        }
        if simplex.points().iter().any(|v| v.w == vertex.w) {
            return Closest { end: End::Stalled, lower, upper, normal, iterations };
        }
        if iterations < most {
            simplex.push(vertex);
        }
    }
    Closest { end: End::Limit, lower, upper, normal, iterations: most }
}
