//! Contact of a triangle and a convex shape through the triangle's face, by one support query.
//!
//! # Reference
//! docs/intervals.md, section 18, proves the depth.
//!
//! # Steps
//! 1. Of the two faces, take the one towards the shape's interior point c. Let p be the shape's
//!    lowest point along its normal n, and d the depth of p below the face.
//! 2. If p is above the face, and its foot is on the triangle, the foot and p are the nearest
//!    points: the plane separates the shapes by −d.
//! 3. Otherwise n proves that the depth is at most d. The Minkowski difference contains the prism
//!    of the triangle and the segment from p to c, and the prism contains the ball of radius d
//!    around the origin if all of its other faces are as far away. Then the depth is d.
//!
//! Bodies that rest on the inside of a triangle are decided here. Near edges, and where bodies are
//! deep, the general path answers.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::answer::{Contact, separated_contact};
use super::cache::Cache;
use super::intersection::store_separation;
use super::minkowski::Minkowski;
use super::status::Status;
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::unit;

/// A face is as far away as another one only if it is farther by this many rounding errors: its
/// height has an error of its own. Depths up to this are left to the general path, which
/// distinguishes touching from penetrating.
const ROUNDINGS: f64 = 32.0;

/// A contact, and the depth of its points: negative for a gap.
pub(crate) struct FaceContact {
    pub(crate) contact: Contact,
    pub(crate) depth: f64,
}

/// The contact of a triangle `a` with these `corners` and of `b`; `None` if the face does not
/// decide.
///
/// # Complexity
/// One support query of `b`. No allocation.
pub(crate) fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    corners: [DVec3; 3],
    (a, b, b_in_a): (&A, &B, Pose),
    cache: &mut Cache,
) -> Option<FaceContact> {
    let [origin, second, third] = corners;
    let front = unit((second - origin).cross(third - origin))?;
    let mut m = Minkowski::new(a, b, b_in_a);
    let center = m.center().b;
    let height = (center - origin).dot(front);
    let (normal, side) = if height < 0.0 { (-front, -1.0) } else { (front, 1.0) };
    let point = m.point_with_a(origin, 0, normal);
    let (depth, lowest) = (point.w.dot(normal), point.b());
    let margin = ROUNDINGS * m.rounding_error();
    let foot = lowest + normal * depth;
    // From each corner to the next one.
    let edges = [(origin, second - origin), (second, third - second), (third, origin - third)];
    // Whether the lowest point is farther than `reach` inside all sides of the prism along `way`.
    let is_inside = |way: DVec3, reach: f64| {
        edges.iter().all(|(corner, edge)| {
            let outward = edge.cross(way) * side;
            // NaN takes the failing branch.
            (*corner - lowest).dot(outward) > (reach + margin) * outward.length()
        })
    };
    if depth < -margin && is_inside(normal, 0.0) {
        store_separation(cache, normal, &[point; 3]);
        let contact = separated_contact(&m, cache, normal, 0);
        return Some(FaceContact { contact: Contact { point_a: foot, point_b: lowest, ..contact }, depth });
    }
    // NaN takes the failing branch.
    if !(depth > margin && height.abs() > depth + margin && is_inside(center - lowest, depth)) {
        return None;
    }
    cache.forget_axis();
    let contact = Contact {
        hit: true,
        status: Status::Exact,
        depth,
        depth_lower: depth - m.noise(),
        depth_upper: depth + m.rounding_error(),
        normal,
        point_a: foot,
        point_b: lowest,
        iterations: 0,
        support_calls: m.support_calls(),
    };
    Some(FaceContact { contact, depth })
}
