//! Contact of two shapes that overlap, or are separated by at most the prediction.

#![forbid(unsafe_code)]

use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::known_separation;
use crate::solver::triangle_face::{self, FaceContact};
use crate::solver::{Cache, Contact, Distance, Minkowski, Settings, Status, queries};
use glam::DVec3;

/// Maximum distance between the two copies of a common point, in rounding errors.
const COPIES: f64 = 32.0;

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

impl Near {
    /// Whether its points are on both surfaces to within `off`, a length, or to within rounding
    /// error, and on a line along the normal.
    pub(super) fn is_within<A: Shape + ?Sized, B: Shape + ?Sized>(
        &self,
        off: f64,
        (a, b, b_in_a): (&A, &B, Pose),
    ) -> bool {
        let aside = (self.contact.point_a - self.contact.point_b - self.contact.normal * self.depth).length();
        // NaN takes the failing branch.
        let is_within = |off: f64| aside <= off && self.width <= off;
        is_within(off) || is_within(COPIES * Minkowski::new(a, b, b_in_a).rounding_error())
    }
}

/// The contact of two shapes, or their distance up to `prediction`. `off` is the length by which
/// points may be off a surface.
pub(super) fn near_contact<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    settings: &Settings,
    [prediction, off]: [f64; 2],
    cache: &mut Cache,
) -> Near {
    if let Some(corners) = a.triangle()
        && let Some(FaceContact { contact, depth }) = triangle_face::contact(corners, (a, b, b_in_a), cache)
    {
        return Near { contact, depth, width: 0.0, status: Status::Exact };
    }
    let apart = known_separation((a, b, b_in_a), cache);
    let mut contact = match apart {
        Some((contact, _)) => contact,
        None => queries::contact(a, b, b_in_a, settings, cache),
    };
    if contact.hit && contact.status == Status::Within && width(&contact) > 0.5 * off {
        contact = narrowed((a, b, b_in_a), settings, (contact, off), cache);
    }
    let Contact { depth, status, .. } = contact;
    if contact.hit {
        return Near { contact, depth, width: width(&contact), status };
    }
    let distance = apart.map(|(_, distance)| distance);
    let Some(gap) = distance_within((a, b, b_in_a), (contact.normal, distance), prediction, settings, cache) else {
        return Near { contact, depth: f64::NEG_INFINITY, width: 0.0, status };
    };
    (contact.normal, contact.point_a, contact.point_b) = (gap.normal, gap.point_a, gap.point_b);
    contact.iterations += gap.iterations;
    contact.support_calls += gap.support_calls;
    Near { contact, depth: -gap.distance, width: gap.upper - gap.lower, status: gap.status }
}

fn width(contact: &Contact) -> f64 {
    contact.depth_upper - contact.depth_lower
}

/// A `contact` whose interval is narrow enough that its points are at most `off` the surfaces, if
/// the search gets there. Curved shapes that are deep in each other need it.
#[inline(never)]
fn narrowed<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    settings: &Settings,
    (contact, off): (Contact, f64),
    cache: &mut Cache,
) -> Contact {
    let settings = Settings { tolerance: 0.25 * off / contact.depth_upper, ..*settings };
    let narrow = queries::contact(a, b, b_in_a, &settings, cache);
    // The first one is within the caller's tolerance, whatever became of the second search.
    let found = if narrow.hit && width(&narrow) < width(&contact) { narrow } else { contact };
    let status = if narrow.status == Status::Exact { Status::Exact } else { contact.status };
    let iterations = contact.iterations + narrow.iterations;
    Contact { status, iterations, support_calls: contact.support_calls + narrow.support_calls, ..found }
}

/// The distance of shapes that an axis separates, perhaps with a known lower bound; `None` if it is
/// above `prediction`.
fn distance_within<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    (axis, known): (DVec3, Option<f64>),
    prediction: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> Option<Distance> {
    let along = || -Minkowski::new(a, b, b_in_a).support(axis).w.dot(axis);
    if known.is_some_and(|known| known > prediction) || along() > prediction {
        return None;
    }
    let gap = queries::distance(a, b, b_in_a, settings, cache);
    (gap.distance <= prediction && gap.status != Status::Overlapping).then_some(gap)
}
