//! Distance of two shapes, with the points where they are nearest.
//!
//! # Reference
//! Kenwright, section 3 ("closest points between pairs of convex polytopes") and section 4.6 (the search for the closest
//! features serves the next frame).
//!
//! # Steps
//! 1. balls inside the shapes overlap: distance 0, no support call;
//! 2. start from the last nearest simplex under the new pose, from what a yes/no query saw before it missed, or from the
//!    centre;
//! 3. closest-point search; a nearest point at the origin is settled by the expansion.

use super::closest::{self, Simplex, closest};
use super::intersection::decide_by_expansion;
use crate::minkowski::{Minkowski, unit};
use crate::{Cache, Overlap, Pose, Settings, Status, SupportMap};
use glam::DVec3;

/// Answer of [`distance`](distance()). Lengths are in the shapes' units, points and directions in A's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// How the interval came to be.
    pub status: Status,
    /// Length of the segment from `point_a` to `point_b`; 0 when the shapes overlap or touch.
    pub distance: f64,
    /// The distance is no less than this, rounding included.
    pub lower: f64,
    /// The distance is no more than this, rounding included.
    pub upper: f64,
    /// Of unit length, from A to B along the shortest segment: of the planes, square to it, that prove `lower`. When they touch, of a
    /// plane between them. When the shapes overlap, any unit vector.
    pub normal: DVec3,
    /// The point of A nearest to B; when they overlap, a point of both.
    pub point_a: DVec3,
    /// The point of B nearest to A; when they overlap, a point of both.
    pub point_b: DVec3,
    /// Steps of the search.
    pub iterations: u32,
    /// Pairs of support queries made.
    pub support_calls: u32,
}

/// Distance of `a` and of `b` placed at `b_in_a`; 0 when they overlap ([`contact`](crate::contact) tells how deep).
///
/// `cache` belongs to this ordered pair; it is read and brought up to date.
///
/// # Complexity
/// 4 to 10 support calls for most pairs; capped by `settings`. No allocation.
pub fn distance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    let mut m = Minkowski::new(a, b, b_in_a);
    let rounding = m.rounding();
    let center = m.center_point();
    let mut out = Distance {
        status: Status::Overlapping,
        distance: 0.0,
        lower: 0.0,
        upper: 0.0,
        normal: unit(-center.w).unwrap_or(DVec3::X),
        point_a: center.a,
        point_b: center.b(),
        iterations: 0,
        support_calls: 0,
    };
    if m.inner_balls_overlap() {
        (out.point_a, out.point_b) = (m.point_in_both_balls(), m.point_in_both_balls());
        cache.forget_axis();
        return out;
    }
    let mut simplex = Simplex::empty();
    for vertex in cache.simplex().iter().filter_map(|features| m.recall(*features)) {
        if !simplex.contains(vertex.w) {
            simplex.push(vertex);
        }
    }
    if simplex.is_empty() {
        simplex.push(center);
    }
    let found = closest(&mut m, &mut simplex, settings.relative_gap(), settings.max_iterations);
    cache.set_simplex(simplex.features());
    let (point_a, point_b, between) = simplex.witnesses(found.upper, m.noise());
    (out.point_a, out.point_b) = (point_a, point_b);
    out.iterations = found.iterations;
    if found.normal != DVec3::ZERO {
        out.normal = found.normal;
    }
    let apart = found.lower > rounding;
    if apart {
        cache.set_axis(out.normal);
    } else {
        cache.forget_axis();
    }
    if found.end == closest::End::Inside && !apart {
        out.support_calls = m.support_calls();
        return out;
    }
    // The distance of two points that are there, whatever rounding did to the plane that the search went by.
    out.distance = between.length();
    let by_balls = center.w.length() - m.outer_radius();
    let lower = found.lower.max(by_balls);
    if by_balls > found.lower {
        // The planes that prove it are square to the centres' line.
        out.normal = unit(-center.w).unwrap_or(out.normal);
    }
    out.lower = (lower - rounding).max(0.0);
    out.upper = out.distance + m.noise();
    out.status = match found.end {
        closest::End::Converged if out.distance - lower <= rounding => Status::Exact,
        closest::End::Converged if out.distance - lower <= settings.relative_gap() * out.distance + 2.0 * rounding => {
            Status::Within
        }
        closest::End::Limit => Status::IterationLimit,
        _ => Status::Stalled,
    };
    if found.upper <= 2.0 * rounding && !apart {
        // The origin is on the simplex, but is it on the surface?
        let (overlap, bound, steps) = decide_by_expansion(&mut m, None);
        out.iterations += steps;
        // Points that are all but the same point nowhere; the face that the origin is on does.
        if overlap != Overlap::Overlapping && bound.normal != DVec3::ZERO {
            out.normal = bound.normal;
            let apart = bound.point_a.distance(bound.point_b);
            if apart < out.distance {
                (out.point_a, out.point_b, out.upper) = (bound.point_a, bound.point_b, apart + m.noise());
            }
        }
        out.lower = 0.0;
        match overlap {
            Overlap::Overlapping => (out.status, out.distance, out.upper) = (Status::Overlapping, 0.0, 0.0),
            Overlap::Touching | Overlap::Separated => (out.status, out.distance) = (Status::Touching, 0.0),
            // It may be deep.
            Overlap::Undecided => (out.status, out.distance) = (Status::Stalled, out.point_a.distance(out.point_b)),
        }
    }
    out.support_calls = m.support_calls();
    out
}
