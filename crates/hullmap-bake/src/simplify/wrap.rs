//! A polytope of few vertices around a hull, all of them at one distance from it.
//!
//! # Steps
//! 1. Start with a tetrahedron of four far points of the hull, pushed outward by the distance.
//! 2. Of all triangles take the one that the hull stands out of most, and add the hull's farthest point there, pushed outward
//!    along the triangle's normal. Go on until the hull stands out of none.
//!
//! # Reference
//! Kamenev, "A class of adaptive algorithms for approximating convex bodies by polyhedra", 1992 (estimate refinement), of the body
//! that is all points within the distance.
//!
//! # Deviations
//! - It ends when the *hull* is inside, not when the larger body nearly is: what lies between the two is what vertices are saved by.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::{nearest::Nearest, surface::Surface};
use crate::hull::rank::{Simplex, spanning_simplex};

/// By how much of the diameter a hull may stand out of a triangle and count as behind it: rounding, which the last step's margin
/// covers.
const BEHIND: f64 = 1e-13;

/// A surface, and for each of its vertices one of the hull near it.
pub struct Wrapped {
    /// The surface.
    pub surface: Surface,
    /// Vertices of the hull, by the number of the surface's vertex.
    pub feet: Vec<u32>,
}

/// A polytope of at most `most` vertices that holds the hull and whose vertices are `distance` away from it; `None` where this way of
/// finding one does not.
pub fn wrap(nearest: &Nearest, diameter: f64, distance: f64, most: usize) -> Option<Wrapped> {
    let Simplex::Tetrahedron(simplex) = spanning_simplex(nearest.points()) else { return None };
    let corners = simplex.map(|i| nearest.points()[i]);
    let middle = corners.iter().sum::<DVec3>() / 4.0;
    let surface = Surface::tetrahedron(corners.map(|p| p + (p - middle).normalize() * distance));
    let feet = simplex.iter().map(|_| simplex[0] as u32).collect();
    let mut wrapped = Wrapped { surface, feet };
    let mut queue = BinaryHeap::new();
    let look = |wrapped: &Wrapped, triangle: u32, queue: &mut BinaryHeap<(u64, u32, [u32; 3])>| {
        let (height, _, _) = wrapped.stands_out(nearest, triangle);
        if height > BEHIND * diameter {
            // Heights above 0 order as their bits do.
            queue.push((height.to_bits(), triangle, wrapped.surface.corners(triangle)));
        }
    };
    (0..4).for_each(|triangle| look(&wrapped, triangle, &mut queue));
    while let Some((_, triangle, corners)) = queue.pop() {
        if wrapped.surface.corners(triangle) != corners {
            // Gone, and another in its place.
            continue;
        }
        // What comes may take others out, but hardly more than it adds.
        if wrapped.feet.len() >= 2 * most {
            return None;
        }
        let (_, foot, normal) = wrapped.stands_out(nearest, triangle);
        let new = wrapped.surface.insert(nearest.vertex(foot) + normal * distance, triangle)?;
        wrapped.feet.push(foot);
        wrapped.surface.triangles_at(new).into_iter().for_each(|triangle| look(&wrapped, triangle, &mut queue));
    }
    (wrapped.surface.vertex_count() <= most).then_some(wrapped)
}

impl Wrapped {
    /// How far the hull stands out of a triangle, the vertex that does, and the triangle's normal.
    fn stands_out(&self, nearest: &Nearest, triangle: u32) -> (f64, u32, DVec3) {
        let corners = self.surface.corners(triangle);
        let normal = self.surface.normal(corners);
        let farthest = nearest.climb(normal, self.feet[corners[0] as usize]);
        (normal.dot(nearest.vertex(farthest) - self.surface.point(corners[0])), farthest, normal)
    }
}
