//! Contact of two shapes that overlap, or are separated by at most the prediction.

#![forbid(unsafe_code)]

use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::triangle_face::{self, FaceContact};
use crate::solver::{Cache, Contact, Distance, Minkowski, Settings, Status, queries};
use glam::DVec3;

/// The contact of two shapes near each other.
pub(super) struct Near {
    pub(super) contact: Contact,
    /// Depth of its points. Negative if the shapes are separated: by at most the prediction, the
    /// normal and the points belong to their distance. If it is more, it may be negative infinity.
    pub(super) depth: f64,
    /// Width of its interval.
    pub(super) width: f64,
    /// How the query of the contact or of the distance ended.
    pub(super) status: Status,
}

/// The contact of two shapes, or their distance up to `prediction`.
pub(super) fn near_contact<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    settings: &Settings,
    prediction: f64,
    cache: &mut Cache,
) -> Near {
    if let Some(corners) = a.triangle()
        && let Some(FaceContact { contact, depth }) = triangle_face::contact(corners, (a, b, b_in_a), cache)
    {
        return Near { contact, depth, width: 0.0, status: Status::Exact };
    }
    let mut contact = queries::contact(a, b, b_in_a, settings, cache);
    let Contact { depth, status, .. } = contact;
    if contact.hit {
        return Near { contact, depth, width: contact.depth_upper - contact.depth_lower, status };
    }
    let Some(gap) = distance_within((a, b, b_in_a), contact.normal, prediction, settings, cache) else {
        return Near { contact, depth: f64::NEG_INFINITY, width: 0.0, status };
    };
    (contact.normal, contact.point_a, contact.point_b) = (gap.normal, gap.point_a, gap.point_b);
    contact.iterations += gap.iterations;
    contact.support_calls += gap.support_calls;
    Near { contact, depth: -gap.distance, width: gap.upper - gap.lower, status: gap.status }
}

/// The distance of shapes that `axis` separates; `None` if it is above `prediction`.
fn distance_within<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    axis: DVec3,
    prediction: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> Option<Distance> {
    if -Minkowski::new(a, b, b_in_a).support(axis).w.dot(axis) > prediction {
        return None;
    }
    let gap = queries::distance(a, b, b_in_a, settings, cache);
    (gap.distance <= prediction && gap.status != Status::Overlapping).then_some(gap)
}
