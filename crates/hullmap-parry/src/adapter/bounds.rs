//! Bounds of a baked hull: box and ball.

use hullmap::SupportMap as _;
use hullmap::glam::DVec3;

use super::BakedHull;
use super::convert::{narrow, real, wide};
use super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::parry::math::{Pose, Real};

/// Relative margin of the box in a pose, for rounding in f32: a smaller box would lose contacts.
const MARGIN: f64 = 1e-6;

impl BakedHull {
    pub(super) fn local_box(&self) -> Aabb {
        let [a, b] = self.hull().bounds().map(|bound| bound.as_dvec3() * self.scale_factors());
        Aabb::new(narrow(a.min(b)), narrow(a.max(b)))
    }

    /// The tight box in the frame that `pose` maps to, plus the margin: six support queries.
    pub(super) fn box_under(&self, pose: &Pose) -> Aabb {
        let (mut mins, mut maxs) = (DVec3::ZERO, DVec3::ZERO);
        let shift = wide(pose.translation);
        for axis in 0..3 {
            let world = DVec3::AXES.get(axis).copied().unwrap_or(DVec3::X);
            let local = wide(pose.rotation.inverse() * narrow(world));
            let reach = |dir: DVec3| self.support_point(dir).point.dot(local);
            let (low, high) = (reach(-local), reach(local));
            let margin = MARGIN * (low.abs().max(high.abs()));
            let shift = shift.dot(world);
            mins += world * (shift + low - margin);
            maxs += world * (shift + high + margin);
        }
        Aabb::new(narrow(mins), narrow(maxs))
    }

    /// A ball around the interior point that contains the hull, O(1).
    pub(super) fn ball(&self) -> BoundingSphere {
        let radius = self.outer_radius();
        BoundingSphere::new(narrow(self.interior_point()), real(radius * (1.0 + MARGIN)))
    }

    /// Radius of the ball around the interior point that the hull contains.
    pub(super) fn thickness(&self) -> Real {
        real(self.inner_radius())
    }
}
