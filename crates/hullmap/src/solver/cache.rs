//! What a pair remembers from one query to the next.
//!
//! - The last separating axis: a miss is mostly proved again by one support call.
//! - The last portal: a hit is mostly proved again by none.
//! - The last simplex near the origin: the closest-point search goes on from it.
//! - The last polytope: the expansion goes on from it.
//!
//! # Reference
//! Kenwright, section 4.1 (the face that failed is tested first in the next frame), section 4.6 (the search for the
//! closest features goes on after a miss, for the next frame) and section 4.7 (the previous solution is fed forward as the starting point).
//!
//! # Deviations
//! - Features are kept, not points: under a new pose the points that they make are points of the new CSO, whereas old
//!   points are not. So a stale cache costs steps and can never cost truth, not even one of another pair. Shapes whose features are not
//!   points ([`SupportMap::point`](crate::SupportMap::point)) are remembered by the axis alone.
//! - The surface of the kept polytope need not be convex under the new pose. Whether it still winds around the origin
//!   is what counts, and is tested.

use crate::minkowski::Point;
use glam::DVec3;

/// Most vertices of a polytope that is kept.
pub(super) const MOST_POINTS: usize = 56;

/// Slots for its faces.
const MOST_FACES: usize = 2 * MOST_POINTS;

/// Caller-owned memory of one ordered pair (A, B), to be passed to every query of that pair. 1.3 KB, without pointers.
///
/// It changes what a query costs, never its answer beyond rounding; a fresh one is always right, and so is one that belongs to
/// another pair. All directions are in A's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Cache {
    /// The last separating axis, from A to B; tested before anything else.
    axis: Option<DVec3>,
    portal: Option<[[u32; 2]; 3]>,
    /// As many as `simplex_count`.
    simplex: [[u32; 2]; 3],
    simplex_count: u8,
    /// 0 when there is none.
    point_count: u8,
    face_count: u8,
    points: [[u32; 2]; MOST_POINTS],
    corners: [[u8; 3]; MOST_FACES],
    neighbours: [[u8; 3]; MOST_FACES],
}

impl Default for Cache {
    fn default() -> Self {
        Self {
            axis: None,
            portal: None,
            simplex: [[0; 2]; 3],
            simplex_count: 0,
            point_count: 0,
            face_count: 0,
            points: [[0; 2]; MOST_POINTS],
            corners: [[0; 3]; MOST_FACES],
            neighbours: [[0; 3]; MOST_FACES],
        }
    }
}

/// The polytope in a [`Cache`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept<'c> {
    points: &'c [[u32; 2]],
    corners: &'c [[u8; 3]],
    neighbours: &'c [[u8; 3]],
}

impl Kept<'_> {
    /// The features that make the vertices.
    pub(super) fn points(&self) -> impl ExactSizeIterator<Item = [u32; 2]> {
        self.points.iter().copied()
    }

    /// Corners and neighbours.
    pub(super) fn faces(&self) -> impl ExactSizeIterator<Item = ([u16; 3], [u16; 3])> {
        self.corners.iter().zip(self.neighbours).map(|(c, n)| (c.map(u16::from), n.map(u16::from)))
    }
}

impl Cache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.forget_axis();
        self.portal = None;
        self.simplex_count = 0;
        self.forget_polytope();
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

    pub(crate) fn portal(&self) -> Option<[[u32; 2]; 3]> {
        self.portal
    }

    pub(crate) fn set_portal(&mut self, vertices: &[Point; 3]) {
        self.portal = Some(vertices.map(|v| v.features));
    }

    pub(crate) fn simplex(&self) -> &[[u32; 2]] {
        &self.simplex[..usize::from(self.simplex_count)]
    }

    /// Keeps at most three vertices, leaving out the centre, which is known anyway.
    #[inline]
    pub(crate) fn set_simplex(&mut self, vertices: impl IntoIterator<Item = [u32; 2]>) {
        self.simplex_count = 0;
        for features in vertices.into_iter().filter(|features| *features != Point::CENTER).take(3) {
            self.simplex[usize::from(self.simplex_count)] = features;
            self.simplex_count += 1;
        }
    }

    pub(super) fn polytope(&self) -> Option<Kept<'_>> {
        let (points, faces) = (usize::from(self.point_count), usize::from(self.face_count));
        (points > 0).then(|| Kept {
            points: &self.points[..points],
            corners: &self.corners[..faces],
            neighbours: &self.neighbours[..faces],
        })
    }

    pub(super) fn forget_polytope(&mut self) {
        self.point_count = 0;
    }

    /// Keeps a polytope: vertices, then corners and neighbours of its faces. One that is too big is not kept.
    pub(super) fn keep_polytope(&mut self, points: &[[u32; 2]], (corners, neighbours): (&[[u16; 3]], &[[u16; 3]])) {
        self.point_count = 0;
        if points.len() > MOST_POINTS || corners.len() > MOST_FACES {
            return;
        }
        self.points[..points.len()].copy_from_slice(points);
        for (to, from) in self.corners.iter_mut().zip(corners) {
            *to = from.map(|c| c as u8);
        }
        for (to, from) in self.neighbours.iter_mut().zip(neighbours) {
            *to = from.map(|c| c as u8);
        }
        (self.point_count, self.face_count) = (points.len() as u8, corners.len() as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_is_not_kept_in_a_simplex() {
        let mut cache = Cache::new();
        cache.set_simplex([[3, 4], Point::CENTER]);
        assert_eq!(cache.simplex(), &[[3, 4]]);
        cache.clear();
        assert!(cache.simplex().is_empty());
    }

    #[test]
    fn a_polytope_comes_back_as_it_was() {
        let mut cache = Cache::new();
        assert!(cache.polytope().is_none());
        let points = [1, 2, 3, 4].map(|i| [i, 10 + i]);
        let (corners, neighbours) = ([[0, 1, 2], [0, 3, 1]], [[1, 2, 3], [3, 2, 0]]);
        cache.keep_polytope(&points, (&corners, &neighbours));
        let kept = cache.polytope().unwrap();
        assert!(kept.points().eq(points));
        assert!(kept.faces().eq(corners.into_iter().zip(neighbours)));
        cache.keep_polytope(&[[0; 2]; MOST_POINTS + 1], (&corners, &neighbours));
        assert!(cache.polytope().is_none());
    }

    #[test]
    fn it_is_as_small_as_the_documentation_says() {
        assert!(size_of::<Cache>() <= 1331, "{}", size_of::<Cache>());
    }
}
