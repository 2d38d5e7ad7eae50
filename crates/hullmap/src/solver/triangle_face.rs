//! Contact of a triangle and a convex shape through the triangle's face, by one support query.
//!
//! # Reference
//! docs/contributors/intervals.md, section 18, proves the depth.
//!
//! # Steps
//! 1. Take the face towards the shape's interior point c. Let p be the shape's
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

use super::answer::Contact;
use super::cache::Cache;
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
        cache.set_separation(normal, &[point; 3]);
        let contact = m.separated_contact(cache, normal, 0);
        return Some(FaceContact { contact: Contact { point_a: foot, point_b: lowest, ..contact }, depth });
    }
    // NaN takes the failing branch.
    if !(depth > margin && height.abs() > depth + margin && is_inside(center - lowest, depth)) {
        return None;
    }
    cache.forget_axis();
    let contact = Contact {
        status: Status::Exact,
        depth,
        depth_lower: depth - m.noise(),
        depth_upper: depth + m.rounding_error(),
        normal,
        point_a: foot,
        point_b: lowest,
        support_calls: m.support_calls(),
        ..Contact::default()
    };
    Some(FaceContact { contact, depth })
}

#[cfg(test)]
mod tests {
    use ::shapes::rng::SplitMix64;
    use glam::DQuat;

    use super::*;
    use crate::shapes::triangle::closest_of_triangle;
    use crate::shapes::{Cuboid, Triangle};
    use crate::solver::{Settings, queries};

    /// Boxes near triangles of many sizes, also thin boxes, and some parallel to the triangle: the
    /// interval of a depth shares a point with the interval of the general path, and a gap is the
    /// distance.
    #[test]
    fn depths_and_gaps_agree_with_those_of_the_general_path() {
        let (mut rng, mut hits, mut gaps, mut undecided, rounds) = (SplitMix64::new(18), 0, 0, 0, 20_000);
        for round in 0..rounds {
            let size = 10_f64.powi(round % 5 - 2);
            let mut vector = || DVec3::from_array([(); 3].map(|()| rng.between(-1.0, 1.0)));
            let corners = [vector() * size, vector() * size, vector() * size];
            let half = (vector().abs() + DVec3::splat(0.01))
                * if round % 3 == 0 { DVec3::new(1.0, 1.0, 0.02) } else { DVec3::ONE };
            let turn = vector();
            let turn = if round % 4 == 0 { DQuat::IDENTITY } else { DQuat::from_xyzw(turn.x, turn.y, turn.z, 0.5) };
            let corners = if round % 4 == 0 { corners.map(|corner| corner.with_z(0.0)) } else { corners };
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let at = Pose::new(middle + vector() * half.length(), turn).unwrap();
            let (triangle, cuboid) = (Triangle::new(corners).unwrap(), Cuboid::new(half).unwrap());
            let Some(found) = contact(corners, (&triangle, &cuboid, at), &mut Cache::new()) else {
                undecided += 1;
                continue;
            };
            let (face, depth) = (found.contact, found.depth);
            let pair = (&triangle, &cuboid, at);
            let expected = queries::contact(pair.0, pair.1, at, &Settings::default(), &mut Cache::new());
            let slack = 1e-12 * (size + half.length());
            assert_eq!(face.hit, expected.hit, "round {round}: {face:?}, in general {expected:?}");
            assert!((face.point_a - face.point_b).distance(face.normal * depth) <= slack, "round {round}: {face:?}");
            let on_triangle = closest_of_triangle(corners, face.point_a).distance(face.point_a);
            assert!(face.hit || on_triangle <= slack, "round {round}: {face:?}");
            if face.hit {
                hits += 1;
                let agree = face.depth_lower <= expected.depth_upper && expected.depth_lower <= face.depth_upper;
                assert!(agree, "round {round}: {face:?}, in general {expected:?}");
            } else {
                gaps += 1;
                let gap = queries::distance(pair.0, pair.1, at, &Settings::default(), &mut Cache::new());
                let is_within = gap.lower - slack <= -depth && -depth <= gap.upper + slack;
                assert!(is_within, "round {round}: {depth}, in general {gap:?}");
            }
        }
        println!("{hits} depths, {gaps} gaps, {undecided} undecided");
        assert!(hits > rounds / 100 && gaps > rounds / 100 && undecided > rounds / 10, "{hits}, {gaps}, {undecided}");
    }
}
