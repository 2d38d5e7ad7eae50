//! Wrap: a polytope of few vertices around a hull, with all vertices at one distance from the hull.
//!
//! # Steps
//! 1. Start with a tetrahedron of four hull vertices far from each other, pushed outward by the
//!    distance.
//! 2. Take the triangle beyond which the hull protrudes most. Add the hull's farthest vertex there,
//!    pushed outward along the triangle's normal. Repeat until the hull protrudes nowhere.
//!
//! # Reference
//! Kamenev, "A class of adaptive algorithms for approximating convex bodies by polyhedra", 1992
//! (estimate refinement), applied to the body of all points within the distance.
//!
//! # Deviations
//! - The algorithm ends when the *hull* is inside, not the larger body. The gap saves vertices.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::{nearest::Nearest, surface::Surface};
use crate::hull::rank::{Simplex, spanning_simplex};

/// Maximum protrusion of the hull beyond a triangle, relative to the diameter, that counts as
/// rounding error. The margin of the last step of simplification covers it.
const BEHIND: f64 = 1e-13;

/// A surface, and a hull vertex near each of its vertices.
pub struct Wrapped {
    /// The surface.
    pub surface: Surface,
    /// Hull vertices, by the index of the surface's vertex.
    pub feet: Vec<u32>,
}

/// A polytope of at most `max_vertices` vertices that contains the hull and whose vertices lie at
/// most `distance` from it; `None` if the algorithm does not find one.
pub fn wrap(nearest: &Nearest, diameter: f64, distance: f64, max_vertices: usize) -> Option<Wrapped> {
    let Simplex::Tetrahedron(simplex) = spanning_simplex(nearest.points()) else { return None };
    let corners = simplex.map(|i| nearest.points()[i]);
    let middle = corners.iter().sum::<DVec3>() / 4.0;
    let surface = Surface::tetrahedron(corners.map(|p| p + (p - middle).normalize() * distance));
    let feet = simplex.iter().map(|_| simplex[0] as u32).collect();
    let mut wrapped = Wrapped { surface, feet };
    // Positive heights have the same order as their bits. The hull vertex comes last, because it is
    // the same for equal corners.
    let mut queue: BinaryHeap<(u64, u32, [u32; 3], u32)> = BinaryHeap::new();
    let look = |wrapped: &Wrapped, triangle: u32, queue: &mut BinaryHeap<_>| {
        let (height, foot) = wrapped.stands_out(nearest, triangle);
        if height > BEHIND * diameter {
            queue.push((height.to_bits(), triangle, wrapped.surface.corners(triangle), foot));
        }
    };
    (0..4).for_each(|triangle| look(&wrapped, triangle, &mut queue));
    while let Some((_, triangle, corners, foot)) = queue.pop() {
        if wrapped.surface.corners(triangle) != corners {
            // The triangle was deleted, and its place reused.
            continue;
        }
        // A new vertex may remove others, but rarely more than it adds.
        if wrapped.feet.len() >= 2 * max_vertices {
            return None;
        }
        let normal = wrapped.surface.normal_of(triangle);
        let new = wrapped.surface.insert(nearest.vertex(foot) + normal * distance, triangle)?;
        wrapped.feet.push(foot);
        wrapped.surface.triangles_at(new).into_iter().for_each(|triangle| look(&wrapped, triangle, &mut queue));
    }
    (wrapped.surface.vertex_count() <= max_vertices).then_some(wrapped)
}

impl Wrapped {
    fn stands_out(&self, nearest: &Nearest, triangle: u32) -> (f64, u32) {
        let corners = self.surface.corners(triangle);
        let normal = self.surface.normal_of(triangle);
        let farthest = nearest.climb(normal, self.feet[corners[0] as usize]);
        (normal.dot(nearest.vertex(farthest) - self.surface.point(corners[0])), farthest)
    }
}
