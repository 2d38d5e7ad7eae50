//! Manifold of a half-space and a shape: the corners of the shape's feature that faces the plane.
//!
//! # Steps
//! 1. Find the deepest point of the shape: one support query.
//! 2. Find the feature of the shape that faces the plane. Its corners are the points: the plane has
//!    no sides that would clip them.
//! 3. Select and match points as for two shapes. A manifold that had no points also has the deepest
//!    point itself, since there are none that should stay.

use super::clip::{FACE, Frame, Part, Patch, PatchPoint};
use super::lengths::Lengths;
use super::surface::settle_b;
use super::widen::{farther_out, middle, tips};
use super::{Manifold, ManifoldPoint, ManifoldSettings, SAME_DEPTH, part};
use crate::pose::Pose;
use crate::shapes::{Corner, Feature, HalfSpace, Shape};
use crate::solver::{Contact, Status};
use crate::support::SupportPoint;
use glam::DVec3;

impl Manifold {
    /// Updates the points for the half-space `a` and `b` placed at `b_in_a`, and returns their
    /// contact.
    ///
    /// As [`update`](Self::update), without a cache: the contact needs none. A prediction relative
    /// to the smaller shape is relative to `b`. If there were no points before, one of the points
    /// is as deep as the contact, to within 1e-4 of the outer radius of `b`. Later, the deepest
    /// may be less deep by up to a tenth of the prediction.
    ///
    /// # Complexity
    /// One support query and one feature of `b`. No allocation.
    pub fn update_half_space<B: Shape + ?Sized>(
        &mut self,
        a: &HalfSpace,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> Contact {
        self.update_half_space_from((a, b, b_in_a), settings, self.points().is_empty())
    }

    /// Exchanges A and B, where the half-space is B. `b_in_a` maps the points from the frame of the
    /// new B into the frame of the new A.
    pub(crate) fn exchange(&mut self, b_in_a: Pose) {
        self.normal = b_in_a.transform_vector(-self.normal);
        for point in &mut self.points {
            let ManifoldPoint { point_a, local_b, .. } = *point;
            point.id.parts.reverse();
            (point.point_a, point.point_b, point.local_b) = (local_b, b_in_a.transform_point(point_a), point_a);
        }
    }

    /// As above, for adapters whose engine keeps the points: `is_new` if it had none.
    #[doc(hidden)]
    pub fn update_half_space_from<B: Shape + ?Sized>(
        &mut self,
        (a, b, b_in_a): (&HalfSpace, &B, Pose),
        settings: &ManifoldSettings,
        is_new: bool,
    ) -> Contact {
        let reach = b.outer_radius();
        let prediction = settings.prediction.length(reach);
        let contact = a.lowest(b, b_in_a).contact();
        let normal = contact.normal;
        let signed = (contact.point_a - contact.point_b).dot(normal);
        let depth = if contact.hit { contact.depth } else { signed };
        // NaN takes the failing branch.
        if !(signed >= -prediction) && !contact.hit {
            self.clear();
            return contact;
        }
        let lengths = Lengths { depth, width: 0.0, prediction, reach };
        let frame = Frame::new((contact.point_a + contact.point_b) * 0.5, normal);
        let dir = b_in_a.inverse_transform_vector(-normal);
        let mut patch = Patch::default();
        let place = |point: DVec3, part: Part| {
            let point = b_in_a.transform_point(point);
            // The origin is midway between the lowest point of B and the plane.
            let heights = [0.5 * signed, (point - frame.origin).dot(normal)];
            PatchPoint { at: frame.projected(point), heights, exact: [true; 2], is_moved: false, parts: [FACE, part] }
        };
        let add = |patch: &mut Patch, Corner { point, vertex }: Corner, is_exact: bool| {
            let mut point = place(point, [vertex; 2]);
            let is_there =
                is_exact || settle_b((b, b_in_a), &frame, vertex, [lengths.height_above(), f64::INFINITY], &mut point);
            if is_there && point.depth() >= -prediction {
                patch.push(point);
            }
        };
        let mut feature = Feature::new();
        // The plane has no sides: no corner of the whole feature is needed.
        b.reduced_feature_within(dir, prediction, &mut feature);
        feature.corners().iter().for_each(|corner| add(&mut patch, *corner, feature.has_exact_corners()));
        let equal = if is_new { SAME_DEPTH * reach } else { lengths.slight() };
        if depth > patch.deepest() + equal {
            // A touching body may be above the plane by a rounding error, and has a point in any
            // case.
            patch.put(place(b_in_a.inverse().transform_point(contact.point_b), part(&feature)));
        }
        let center = frame.projected(b_in_a.transform_point(b.interior_point()));
        let mut spots = patch.spots();
        let mut choice = self.choose((&patch, &spots), &frame, b_in_a, center, &lengths);
        if tips(&choice, &spots, center, &lengths) {
            let toward = b_in_a.inverse_transform_vector(frame.vector(center - middle(&choice, &patch)));
            for SupportPoint { point, feature } in farther_out(b, dir, toward, &lengths) {
                add(&mut patch, Corner { point, vertex: feature }, true);
            }
            spots = patch.spots();
            choice = self.choose((&patch, &spots), &frame, b_in_a, center, &lengths);
        }
        let choice = if is_new {
            choice.with_exact_deepest(&spots, center, lengths.slight())
        } else {
            choice.with_deepest(&spots, lengths.slight() - (depth - patch.deepest()).max(0.0))
        };
        self.replace(&patch, choice, &frame, b_in_a, &lengths);
        self.status = if contact.hit { contact.status } else { Status::Exact };
        contact
    }
}
