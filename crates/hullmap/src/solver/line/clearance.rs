//! Clearance of a line that pierces a convex set: its distance from the set's border, seen along
//! the line. EPA in two dimensions.
//!
//! # Reference
//! van den Bergen 2001 (expanding polytope), one dimension lower.
//!
//! # Steps
//! 1. Start from the corners of a portal, as a polygon.
//! 2. Take the edge nearest to the line. Its distance bounds the clearance from below.
//! 3. Query the support point across that edge. If it is farther out, insert it, remove neighbours
//!    that are no longer corners, and repeat from step 2.

use glam::DVec3;

use super::portal::{LineSearch, Portal, edge_distance, turn};
use crate::support::SupportMap;

/// Maximum number of vertices of the polygon. Lines through the middle of a face need 4 to 6.
const MAX_VERTICES: usize = 24;

/// Support points this many errors beyond an edge or less are on it.
const FLAT_ERRORS: f64 = 4.0;

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> LineSearch<'_, '_, A, B> {
    /// Lower bound of the clearance, at most a little more than `enough`. Not positive if the line
    /// may miss the set.
    pub(super) fn clearance(&mut self, portal: &Portal, enough: f64) -> f64 {
        let mut polygon = [DVec3::ZERO; MAX_VERTICES];
        for (to, corner) in polygon.iter_mut().zip(&portal.corners) {
            *to = corner.at;
        }
        let mut count = portal.corners.len();
        loop {
            let (mut nearest, mut depth) = (0, f64::INFINITY);
            for edge in 0..count {
                let distance = edge_distance(polygon[edge], polygon[(edge + 1) % count]);
                // An edge without length bounds nothing.
                if distance < depth && polygon[edge] != polygon[(edge + 1) % count] {
                    (nearest, depth) = (edge, distance);
                }
            }
            let certain = depth - self.clip.noise;
            if certain >= enough || count == MAX_VERTICES || depth == f64::INFINITY {
                return if depth == f64::INFINITY { 0.0 } else { certain };
            }
            let (a, b) = (polygon[nearest], polygon[(nearest + 1) % count]);
            let n = DVec3::new(b.y - a.y, a.x - b.x, 0.0);
            let new = self.probe(n).at;
            // NaN counts as no gain.
            let is_farther = n.dot(new - a) > FLAT_ERRORS * self.clip.error * n.length();
            if self.clip.is_empty() || !is_farther {
                return certain;
            }
            polygon.copy_within(nearest + 1..count, nearest + 2);
            polygon[nearest + 1] = new;
            count += 1;
            remove_dents(&mut polygon, &mut count, nearest + 1);
        }
    }
}

/// Removes the neighbours of the new vertex that are no longer corners. The centre is the only
/// vertex that is not a support point, so at most it is.
fn remove_dents(polygon: &mut [DVec3; MAX_VERTICES], count: &mut usize, new: usize) {
    let [before, after] = [(new + *count - 1) % *count, (new + 1) % *count];
    for at in [before.max(after), before.min(after)] {
        let [previous, next] = [(at + *count - 1) % *count, (at + 1) % *count];
        let [p, q, r] = [polygon[previous], polygon[at], polygon[next]];
        let is_corner = turn(q - p, r - q) > 0.0;
        if *count > 3 && !is_corner {
            polygon.copy_within(at + 1..*count, at);
            *count -= 1;
        }
    }
}
