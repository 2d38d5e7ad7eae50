//! What a pair remembers from one query to the next.
//!
//! # Reference
//! Kenwright, section 4.1 (the face that failed is tested first in the next frame) and section 4.7 (the previous
//! solution is fed forward as the starting point).
//!
//! # Deviations
//! - Directions are kept, not points: under a new pose the support points of old directions are points of the new
//!   CSO, whereas old points are not. So a stale cache costs steps and can never cost truth.

use crate::minkowski::Vertex;
use glam::DVec3;

/// Caller-owned memory of one ordered pair (A, B), to be passed to every query of that pair.
///
/// It changes what a query costs, never its answer beyond rounding; a fresh one is always right, and so is one that belongs to
/// another pair. All directions are in A's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cache {
    /// The last separating axis, from A to B; tested before anything else.
    axis: Option<DVec3>,
    /// Directions whose support points made the last portal.
    portal: Option<[DVec3; 3]>,
    /// Directions whose support points made the last closest simplex, as many as `simplex_count`.
    simplex: [DVec3; 3],
    simplex_count: usize,
}

impl Cache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn axis(&self) -> Option<DVec3> {
        self.axis
    }

    pub(crate) fn set_axis(&mut self, axis: DVec3) {
        self.axis = Some(axis);
    }

    pub(crate) fn forget_axis(&mut self) {
        self.axis = None;
    }

    pub(crate) fn portal(&self) -> Option<[DVec3; 3]> {
        self.portal
    }

    /// Keeps the directions of a portal's vertices; forgets the portal when one of them (the centre) has none.
    pub(crate) fn set_portal(&mut self, vertices: &[Vertex; 3]) {
        let dirs = vertices.map(|v| v.dir);
        self.portal = dirs.iter().all(|d| *d != DVec3::ZERO).then_some(dirs);
    }

    pub(crate) fn simplex(&self) -> &[DVec3] {
        &self.simplex[..self.simplex_count]
    }

    /// Keeps the directions of at most three vertices, leaving out the centre, which has none.
    pub(crate) fn set_simplex(&mut self, vertices: &[Vertex]) {
        self.simplex_count = 0;
        for v in vertices.iter().filter(|v| v.dir != DVec3::ZERO).take(3) {
            self.simplex[self.simplex_count] = v.dir;
            self.simplex_count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_is_not_kept() {
        let mut cache = Cache::new();
        let seen = Vertex { dir: DVec3::X, ..Vertex::EMPTY };
        cache.set_simplex(&[seen, Vertex::EMPTY]);
        assert_eq!(cache.simplex(), &[DVec3::X]);
        cache.set_portal(&[seen, seen, Vertex::EMPTY]);
        assert_eq!(cache.portal(), None);
        cache.clear();
        assert_eq!(cache, Cache::default());
    }
}
