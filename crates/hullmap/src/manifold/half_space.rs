//! Manifold of a half-space and a shape: the corners of the shape's feature that faces the plane.
//!
//! # Steps
//! 1. Find the deepest point of the shape: one support query.
//! 2. Find the feature of the shape that faces the plane. Its corners are the points: the plane has
//!    no sides that would clip them.
//! 3. Select and match points as for two shapes.

use super::clip::{FACE, Frame, Patch, PatchPoint};
use super::{Manifold, ManifoldSettings, part, slight};
use crate::pose::Pose;
use crate::shapes::{Feature, HalfSpace, Shape};
use crate::solver::Contact;
use crate::vector::perpendicular;
use glam::DVec2;

impl Manifold {
    /// Updates the points for the half-space `a` and `b` placed at `b_in_a`, and returns their
    /// contact.
    ///
    /// As [`update`](Self::update), without a cache: the contact needs none. A prediction relative
    /// to the smaller shape is relative to `b`.
    ///
    /// # Complexity
    /// One support query and one feature of `b`. No allocation.
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, HalfSpace};
    /// use hullmap::{Manifold, ManifoldSettings, Pose};
    ///
    /// let (floor, cube) = (HalfSpace::new(DVec3::Z, 0.0)?, Cuboid::new(DVec3::ONE)?);
    /// let mut manifold = Manifold::new();
    /// for step in 0..3 {
    ///     let b_in_a = Pose::from_translation(DVec3::new(0.1 * f64::from(step), 0.0, 0.99))?;
    ///     let contact =
    ///         manifold.update_half_space(&floor, &cube, b_in_a, &ManifoldSettings::default());
    ///     assert!((contact.depth - 0.01).abs() < 1e-12);
    /// }
    /// // Four corners, the same ones in every step.
    /// assert_eq!(manifold.points().len(), 4);
    /// assert!(manifold.points().iter().all(|point| point.age == 2));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update_half_space<B: Shape + ?Sized>(
        &mut self,
        a: &HalfSpace,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> Contact {
        let reach = b.outer_radius();
        let prediction = settings.prediction.length(reach);
        let contact = a.contact(b, b_in_a);
        let normal = contact.normal;
        let signed = (contact.point_a - contact.point_b).dot(normal);
        let depth = if contact.hit { contact.depth } else { signed };
        // NaN takes the failing branch.
        if !(signed >= -prediction) && !contact.hit {
            self.clear();
            return contact;
        }
        let side = perpendicular(normal);
        let frame = Frame { origin: (contact.point_a + contact.point_b) * 0.5, x: side, y: normal.cross(side), normal };
        let mut feature = Feature::new();
        // The plane has no sides: no corner of the whole feature is needed.
        b.reduced_feature_within(b_in_a.inverse_transform_vector(-normal), prediction, &mut feature);
        let mut patch = Patch::new();
        for corner in feature.corners() {
            let p = b_in_a.transform_point(corner.point) - frame.origin;
            patch.push(PatchPoint {
                at: DVec2::new(p.dot(frame.x), p.dot(frame.y)),
                // The origin is midway between the lowest point of B and the plane.
                heights: [0.5 * signed, p.dot(normal)],
                parts: [FACE, [corner.vertex; 2]],
            });
        }
        patch.retain(|p| p.depth() >= -prediction);
        let deep = patch.points().iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max);
        let slight = slight(prediction, reach);
        if depth > deep + slight {
            let parts = [FACE, part(&feature)];
            patch.push(PatchPoint { heights: [0.5 * signed, -0.5 * signed], parts, ..PatchPoint::default() });
        }
        let choice = self.select(&patch, &frame, b_in_a, reach, slight);
        self.replace(&patch, choice, &frame, b_in_a, depth, reach);
        contact
    }
}
