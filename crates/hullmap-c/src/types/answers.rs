//! Answers of queries.

use hullmap::glam::DVec3;

use super::geometry::Vec3;
use super::status::{Overlap, Status};

/// A support point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// A point of the shape with the maximum dot product with the direction.
    pub point: Vec3,
    /// On a hull, the index of the vertex.
    pub feature: u32,
}

impl From<hullmap::SupportPoint> for Support {
    fn from(found: hullmap::SupportPoint) -> Self {
        Self { point: found.point.into(), feature: found.feature }
    }
}

/// Whether two shapes share a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// True unless the shapes are certainly separated.
    pub hit: bool,
    /// The answer.
    pub status: Overlap,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
}

impl From<hullmap::Intersection> for Intersection {
    #[inline(always)]
    fn from(found: hullmap::Intersection) -> Self {
        let [hull_a, hull_b] = found.parts;
        let hullmap::Intersection { status, iterations, support_calls, .. } = found;
        Self { hit: found.is_hit(), status: status.into(), hull_a, hull_b, iterations, support_calls }
    }
}

/// Distance of two shapes. Points and normal are in A's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the distance is 0.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Length of the segment from point_a to point_b; 0 if the shapes overlap or touch.
    pub distance: f64,
    /// Lower bound of the distance, at least 0.
    pub lower: f64,
    /// Upper bound of the distance.
    pub upper: f64,
    /// Unit vector from A to B: the normal of the planes that prove the lower bound. Any unit
    /// vector if the shapes overlap.
    pub normal: Vec3,
    /// The point of A closest to B; if they overlap, a common point.
    pub point_a: Vec3,
    /// The point of B closest to A; if they overlap, a common point.
    pub point_b: Vec3,
}

impl From<hullmap::Distance> for Distance {
    #[inline(always)]
    fn from(found: hullmap::Distance) -> Self {
        let [hull_a, hull_b] = found.parts;
        Self {
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            distance: found.distance,
            lower: found.lower,
            upper: found.upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }
}

/// Contact of two shapes. Points and normal are in A's frame. For compounds, it is the deepest
/// contact of two hulls.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// False only if the shapes are certainly separated.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_SEPARATED: no contact.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Penetration depth: moving B by it along the normal makes the shapes touch. 0 if they are
    /// separated or touch.
    pub depth: f64,
    /// Lower bound of the depth, at least 0.
    pub depth_lower: f64,
    /// Upper bound of the depth.
    pub depth_upper: f64,
    /// Unit vector from A to B. For separated convex shapes, a separating axis. For separated
    /// compounds, normal and points are 0.
    pub normal: Vec3,
    /// The point of A that is deepest in B; if they are separated, some point of A.
    pub point_a: Vec3,
    /// The point of B that is deepest in A; if they are separated, some point of B.
    pub point_b: Vec3,
}

impl From<hullmap::Contact> for Contact {
    #[inline(always)]
    fn from(found: hullmap::Contact) -> Self {
        let [hull_a, hull_b] = found.parts;
        // Separated parts have no common separating axis.
        let known = |v: DVec3| if v.is_nan() { DVec3::ZERO } else { v };
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            depth: found.depth,
            depth_lower: found.depth_lower,
            depth_upper: found.depth_upper,
            normal: known(found.normal).into(),
            point_a: known(found.point_a).into(),
            point_b: known(found.point_b).into(),
        }
    }
}

/// Where a ray first enters a shape. Point and normal are in the shape's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// False only if the ray certainly misses the shape up to max_t.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the origin is inside the shape.
    pub status: Status,
    /// For a compound, the hull that is hit; otherwise 0.
    pub hull: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// The ray enters at origin + t direction; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of t, at least 0.
    pub t_lower: f64,
    /// Upper bound of t. It may exceed max_t if the interval does.
    pub t_upper: f64,
    /// The point at t; the origin if there is no hit.
    pub point: Vec3,
    /// Unit outward normal where the ray enters.
    pub normal: Vec3,
}

impl From<hullmap::RayHit> for RayHit {
    #[inline(always)]
    fn from(found: hullmap::RayHit) -> Self {
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull: found.part,
            iterations: found.iterations,
            support_calls: found.support_calls,
            t: found.t,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
            point: found.point.into(),
            normal: found.normal.into(),
        }
    }
}

/// When and where a moving shape B first meets A. Points and normal are in A's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// False only if the shapes certainly do not meet up to max_t.
    pub hit: bool,
    /// How the query ended. HULLMAP_STATUS_OVERLAPPING: the shapes overlap at the start.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_a: u32,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull_b: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Time of impact, in the unit that the velocity implies; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of the time, at least 0.
    pub t_lower: f64,
    /// Upper bound of the time. It may exceed max_t if the interval does.
    pub t_upper: f64,
    /// Unit vector from A to B where they meet.
    pub normal: Vec3,
    /// Point of A at which the shapes meet; zero if there is no hit.
    pub point_a: Vec3,
    /// Point of B at which the shapes meet, at time t.
    pub point_b: Vec3,
}

impl From<hullmap::Impact> for Impact {
    #[inline(always)]
    fn from(found: hullmap::Impact) -> Self {
        let [hull_a, hull_b] = found.parts;
        Self {
            hit: found.hit,
            status: found.status.into(),
            hull_a,
            hull_b,
            iterations: found.iterations,
            support_calls: found.support_calls,
            t: found.t,
            t_lower: found.t_lower,
            t_upper: found.t_upper,
            normal: found.normal.into(),
            point_a: found.point_a.into(),
            point_b: found.point_b.into(),
        }
    }
}

/// Signed distance of a point from the surface of a shape, in the shape's frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// How the query ended.
    pub status: Status,
    /// For a compound, the hull that decided the query; otherwise 0.
    pub hull: u32,
    /// Number of steps.
    pub iterations: u32,
    /// Number of support calls.
    pub support_calls: u32,
    /// Distance from the surface: positive outside, negative inside.
    pub distance: f64,
    /// Lower bound of the distance.
    pub lower: f64,
    /// Upper bound of the distance.
    pub upper: f64,
    /// The point of the surface closest to the query point.
    pub point: Vec3,
    /// Unit outward normal of the surface at that point.
    pub normal: Vec3,
}

impl From<hullmap::SignedDistance> for SignedDistance {
    #[inline(always)]
    fn from(found: hullmap::SignedDistance) -> Self {
        Self {
            status: found.status.into(),
            hull: found.part,
            iterations: found.iterations,
            support_calls: found.support_calls,
            distance: found.distance,
            lower: found.lower,
            upper: found.upper,
            point: found.point.into(),
            normal: found.normal.into(),
        }
    }
}
