//! The contact of a pair, or its closest points if it has none.

use hullmap::glam::DVec3;
use hullmap::{Cache, Geometry, Pose, Settings};

use super::super::convert::real;
use super::super::parry::math::Real;
use super::super::parry::query::Contact;
use super::pair::{HullPair, Local, Placement, on_pair};

/// Deepest or closest points of a pair, in A's frame. The normal has unit length.
pub(super) struct Nearest {
    pub(super) point_a: DVec3,
    pub(super) point_b: DVec3,
    /// From A to B.
    pub(super) normal: DVec3,
    /// Negative if the shapes overlap.
    pub(super) dist: f64,
}

impl Nearest {
    pub(super) fn find<A: Geometry + ?Sized, B: Geometry + ?Sized>(
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Self {
        let found = hullmap::contact(a, b, b_in_a, settings, cache);
        if found.hit {
            let (point_a, point_b) = (found.point_a, found.point_b);
            return Self { point_a, point_b, normal: found.normal, dist: -found.depth };
        }
        let gap = hullmap::distance(a, b, b_in_a, settings, cache);
        Self { point_a: gap.point_a, point_b: gap.point_b, normal: gap.normal, dist: gap.distance }
    }

    /// parry's contact, if the distance is at most `prediction`.
    pub(super) fn contact(&self, placement: &Placement, prediction: Real) -> Option<Contact> {
        let dist = real(self.dist);
        // NaN takes the failing branch.
        let near = dist <= prediction;
        let Local { points: [p1, p2], normals: [n1, n2] } = placement.local(self.point_a, self.point_b, self.normal);
        near.then(|| Contact::new(p1, p2, n1, n2, dist))
    }
}

pub(super) fn contact_of(pair: &HullPair<'_>, placement: &Placement, settings: &Settings) -> Nearest {
    on_pair!(*pair, a, b => Nearest::find(a, b, placement.b_in_a, settings, &mut Cache::new()))
}
