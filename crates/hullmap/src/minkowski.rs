//! The Minkowski difference A − B (configuration space obstacle, CSO) of two shapes, in A's frame.
//!
//! Computes, for a direction, the point w = a − b of the CSO farthest in it. A and B share a point exactly
//! when the origin lies in the CSO; all of the solver is about where the origin lies.
//!
//! # Reference
//! Kenwright, sections 4.2 and 4.4, equation 2 and Listing 1.
//!
//! # Steps of a support query
//! 1. turn the direction into B's frame, opposite (one matrix product; the matrix is made once a query);
//! 2. ask both shapes;
//! 3. turn b's offset from B's interior point into A's frame, subtract.
//!
//! # Deviations
//! - Points are differences of *offsets from the interior points*, w = v0 + (a − ca) − R (b − cb). Shapes far
//!   from the origin of their frames then keep their digits: what is lost is lost once, in v0, where it is the
//!   same as a slightly other pose, not anew in each point.
//! - The centre v0 is the difference of interior points that the shapes vouch for, not of centroids of vertices.

#![forbid(unsafe_code)]

use crate::{Pose, SupportMap};
use glam::{DMat3, DVec3};

/// How many units of rounding each length of the query adds to what a support value, or a plane's offset, may be wrong by:
/// "Intervals" in docs/ARCHITECTURE.md derives 4.5, 23.5, 1.5, 65.75 and 4.25; the rest is for what that leaves out as of second order.
mod rounding_units {
    /// Of A's interior point.
    pub(super) const CENTER_A: f64 = 5.0;
    /// Of B's interior point, which is turned.
    pub(super) const CENTER_B: f64 = 25.0;
    /// Of the translation.
    pub(super) const TRANSLATION: f64 = 2.0;
    /// Of both outer radii together. Directions are turned too, which is what costs most.
    pub(super) const RADII: f64 = 68.0;
    /// Of the centre v0.
    pub(super) const CENTER: f64 = 5.0;
}

/// A point of the Minkowski difference, with where it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// The point a − b, in A's frame.
    pub w: DVec3,
    /// The point of A, in A's frame.
    pub a: DVec3,
    /// The point of B, in A's frame.
    pub b: DVec3,
    /// The direction asked for, in A's frame; zero for the centre v0.
    pub dir: DVec3,
    /// A's feature, as its support mapping told it; `u32::MAX` for the centre v0.
    pub feature_a: u32,
    /// B's feature, as its support mapping told it; `u32::MAX` for the centre v0.
    pub feature_b: u32,
}

/// A point of the Minkowski difference as the solver keeps it: half the size of a [`Vertex`], as polytopes hold many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// The point a − b, in A's frame.
    pub(crate) w: DVec3,
    /// The point of A, in A's frame.
    pub(crate) a: DVec3,
    /// A's feature and B's; [`Point::CENTER`] for the centre.
    pub(crate) features: [u32; 2],
}

impl Point {
    /// The features of the centre v0.
    pub(crate) const CENTER: [u32; 2] = [u32::MAX; 2];

    /// Nothing: what arrays of points hold before they are filled. All zeros, which are the cheapest to write.
    pub(crate) const EMPTY: Self = Self { w: DVec3::ZERO, a: DVec3::ZERO, features: [0; 2] };

    /// The point of B, in A's frame.
    pub(crate) fn b(&self) -> DVec3 {
        self.a - self.w
    }
}

/// The Minkowski difference A − B of two shapes, B placed by a pose.
#[derive(Debug)]
pub struct Minkowski<'s, A: ?Sized, B: ?Sized> {
    a: &'s A,
    b: &'s B,
    rotation: DMat3,
    /// A's frame to B's.
    unrotation: DMat3,
    center_a: DVec3,
    /// B's interior point, in B's frame.
    center_b_local: DVec3,
    /// B's interior point, in A's frame.
    center_b: DVec3,
    inner_radius_a: f64,
    inner_radius: f64,
    outer_radius: f64,
    noise: f64,
    rounding: f64,
    support_calls: u32,
}

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'s, A, B> {
    /// The difference of `a` and of `b` placed at `b_in_a`. Asks for interior points and radii; no support call.
    #[inline(always)]
    pub fn new(a: &'s A, b: &'s B, b_in_a: Pose) -> Self {
        let rotation = b_in_a.rotation_matrix();
        let center_a = a.interior_point();
        let center_b_local = b.interior_point();
        let outer_radius = a.outer_radius() + b.outer_radius();
        let center_b = rotation * center_b_local + b_in_a.translation();
        let noise = f64::EPSILON
            * (rounding_units::CENTER_A * at_most(center_a)
                + rounding_units::CENTER_B * at_most(center_b_local)
                + rounding_units::TRANSLATION * at_most(b_in_a.translation())
                + rounding_units::RADII * outer_radius
                + rounding_units::CENTER * at_most(center_a - center_b));
        Self {
            a,
            b,
            rotation,
            unrotation: rotation.transpose(),
            center_a,
            center_b_local,
            center_b,
            inner_radius_a: a.inner_radius(),
            inner_radius: a.inner_radius() + b.inner_radius(),
            outer_radius,
            noise,
            rounding: noise + a.support_error() + b.support_error(),
            support_calls: 0,
        }
    }

    /// The vertex of the difference farthest in `dir` (A's frame, any length but zero).
    ///
    /// # Complexity
    /// One support query of each shape and two matrix products.
    pub fn support(&mut self, dir: DVec3) -> Vertex {
        self.support_calls += 1;
        let on_a = self.a.support(dir);
        let on_b = self.b.support(self.unrotation * -dir);
        let offset_a = on_a.point - self.center_a;
        let offset_b = self.rotation * (on_b.point - self.center_b_local);
        Vertex {
            w: (self.center_a - self.center_b) + (offset_a - offset_b),
            a: on_a.point,
            b: self.center_b + offset_b,
            dir,
            feature_a: on_a.feature,
            feature_b: on_b.feature,
        }
    }

    /// [`support`](Self::support), as the solver keeps it.
    #[inline(always)]
    pub(crate) fn point(&mut self, dir: DVec3) -> Point {
        self.support_calls += 1;
        let on_a = self.a.support(dir);
        let on_b = self.b.support(self.unrotation * -dir);
        self.placed(on_a.point, on_b.point, [on_a.feature, on_b.feature])
    }

    /// The point that these features make under this pose, without a support query; nothing when a shape has no such
    /// feature, or cannot tell where it is.
    #[inline(always)]
    pub(crate) fn recall(&self, features: [u32; 2]) -> Option<Point> {
        if features == Point::CENTER {
            return Some(self.center_point());
        }
        Some(self.placed(self.a.point(features[0])?, self.b.point(features[1])?, features))
    }

    #[inline(always)]
    fn placed(&self, a: DVec3, b_local: DVec3, features: [u32; 2]) -> Point {
        let offset_b = self.rotation * (b_local - self.center_b_local);
        Point { w: (self.center_a - self.center_b) + ((a - self.center_a) - offset_b), a, features }
    }

    /// [`center`](Self::center), as the solver keeps it.
    #[inline(always)]
    pub(crate) fn center_point(&self) -> Point {
        Point { w: self.center_a - self.center_b, a: self.center_a, features: Point::CENTER }
    }

    /// The centre v0: the difference of the interior points, itself inside the CSO.
    pub fn center(&self) -> Vertex {
        Vertex {
            w: self.center_a - self.center_b,
            a: self.center_a,
            b: self.center_b,
            dir: DVec3::ZERO,
            feature_a: u32::MAX,
            feature_b: u32::MAX,
        }
    }

    /// Radius of a ball around the centre that lies in the CSO; 0 when nothing is known.
    pub fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    /// Radius of a ball around the centre that holds the CSO.
    pub fn outer_radius(&self) -> f64 {
        self.outer_radius
    }

    /// What the solver's own arithmetic may make a support value, or the offset of a plane through vertices, wrong by: a
    /// length, proportional to the greatest in the query.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// [`noise`](Self::noise), and what the shapes' support points may fall short of the farthest.
    ///
    /// Signs of distances smaller than this mean nothing.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// How many pairs of support queries were made: one call asks A once and B once.
    pub fn support_calls(&self) -> u32 {
        self.support_calls
    }

    /// True when the balls inside the shapes overlap, which settles that the shapes do. No support call.
    pub(crate) fn inner_balls_overlap(&self) -> bool {
        let radius = self.inner_radius - self.rounding;
        radius > 0.0 && self.center_point().w.length_squared() < radius * radius
    }

    /// True when the balls around the shapes are apart, which settles that the shapes are. No support call.
    pub(crate) fn outer_balls_apart(&self) -> bool {
        let radius = self.outer_radius + self.rounding;
        self.center_point().w.length_squared() > radius * radius
    }

    /// A point of A and of B, given that [`inner_balls_overlap`](Self::inner_balls_overlap): it divides the segment between
    /// the interior points as the radii do.
    pub(crate) fn point_in_both_balls(&self) -> DVec3 {
        let share = self.inner_radius_a / self.inner_radius;
        self.center_a - (self.center_a - self.center_b) * share
    }
}

/// No less than the length of `v`, nor more than 1.8 times it: without a square root.
#[inline]
fn at_most(v: DVec3) -> f64 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// `v` at unit length; nothing when it is zero or not finite.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let length = v.length();
    // NaN and infinity take the failing branch.
    (length > f64::MIN_POSITIVE && length < f64::INFINITY).then(|| v * (1.0 / length))
}

/// A unit vector perpendicular to the unit vector `n`: the cross product with the axis that `n` is farthest from.
pub(crate) fn perpendicular(n: DVec3) -> DVec3 {
    let m = n.abs();
    let axis = if m.x <= m.y && m.x <= m.z {
        DVec3::X
    } else if m.y <= m.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    unit(n.cross(axis)).unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Support;
    use glam::DQuat;

    /// A sphere of radius `r` about `c`.
    struct Ball {
        c: DVec3,
        r: f64,
    }

    impl SupportMap for Ball {
        fn support(&self, dir: DVec3) -> Support {
            Support { point: self.c + unit(dir).unwrap_or(DVec3::X) * self.r, feature: 0 }
        }
        fn interior_point(&self) -> DVec3 {
            self.c
        }
        fn inner_radius(&self) -> f64 {
            self.r
        }
        fn outer_radius(&self) -> f64 {
            self.r
        }
    }

    #[test]
    fn difference_of_balls_is_the_ball_of_the_sum() {
        let a = Ball { c: DVec3::new(1.0, 2.0, 3.0), r: 0.5 };
        let b = Ball { c: DVec3::new(-1.0, 0.0, 2.0), r: 0.25 };
        let pose = Pose::new(DVec3::new(4.0, 0.0, 0.0), DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9)).unwrap();
        let mut m = Minkowski::new(&a, &b, pose);
        let center = m.center();
        assert!((center.w - (a.c - pose.transform_point(b.c))).length() < 1e-14);
        for dir in [DVec3::X, DVec3::new(1.0, -2.0, 0.5)] {
            let v = m.support(dir);
            assert!((v.w - center.w - dir.normalize() * 0.75).length() < 1e-14);
            assert!((v.a - v.b - v.w).length() < 1e-14);
        }
        assert_eq!(m.support_calls(), 2);
    }

    #[test]
    fn perpendicular_is_of_unit_length() {
        for n in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.8, 0.0), DVec3::ONE.normalize()] {
            let p = perpendicular(n);
            assert!((p.length() - 1.0).abs() < 1e-15 && p.dot(n).abs() < 1e-15);
        }
    }

    #[test]
    fn unit_refuses_zero_and_what_is_not_finite() {
        assert_eq!(unit(DVec3::ZERO), None);
        assert_eq!(unit(DVec3::new(f64::NAN, 1.0, 0.0)), None);
        assert_eq!(unit(DVec3::new(f64::INFINITY, 1.0, 0.0)), None);
    }
}
