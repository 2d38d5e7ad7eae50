//! Minkowski difference A − B of two shapes (configuration space obstacle, CSO), in A's frame, and
//! the bound of rounding errors in it.
//!
//! For a direction it computes the support point w = a − b. The shapes share a point exactly if the
//! origin lies in the CSO, so every algorithm of the solver locates the origin.
//!
//! # Reference
//! Kenwright, sections 4.2 and 4.4, equation 2 and Listing 1.
//!
//! # Deviations
//! - Points are differences of *offsets from the interior points*: w = v0 + (a − c_A) − R (b −
//!   c_B). So shapes far from the origins of their frames keep their digits. The digits that v0
//!   loses are lost once, which equals a slightly different pose, and not again for each point.
//! - The centre v0 is the difference of the interior points that the shapes report, not of vertex
//!   centroids.

#![forbid(unsafe_code)]

use crate::facets::view::Facets;
use crate::pose::Pose;
use crate::support::{Lookup, SupportMap};
use crate::vector::unit;
use glam::{DMat3, DQuat, DVec3};
use std::hint::black_box;

/// Coefficients of the bound on the error of a support value or of a plane's offset, in units of
/// `f64::EPSILON` times a length of the query.
///
/// docs/contributors/intervals.md derives them. The excess covers terms of second order.
mod rounding_units {
    pub(super) const CENTER_A: f64 = 5.0;
    pub(super) const CENTER_B: f64 = 25.0;
    pub(super) const TRANSLATION: f64 = 2.0;
    /// The rotation of the direction costs most of it.
    pub(super) const RADII: f64 = 68.0;
    pub(super) const CENTER: f64 = 5.0;
}

/// A support point of the Minkowski difference, with the points and features of A and B behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// The point a − b, in A's frame.
    pub w: DVec3,
    /// The point of A, in A's frame.
    pub a: DVec3,
    /// The point of B, in A's frame.
    pub b: DVec3,
    /// The direction of the query, in A's frame. Zero for the centre v0.
    pub dir: DVec3,
    /// The feature that A's support mapping reported. `u32::MAX` for the centre v0.
    pub feature_a: u32,
    /// The feature that B's support mapping reported. `u32::MAX` for the centre v0.
    pub feature_b: u32,
}

/// A [`Vertex`] in half the size, since polytopes hold many of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) w: DVec3,
    pub(crate) a: DVec3,
    /// The features of A and B; [`Point::CENTER`] for the centre.
    pub(crate) features: [u32; 2],
}

impl Point {
    pub(crate) const CENTER: [u32; 2] = [u32::MAX; 2];

    /// The features of the first of these points. If all of them have the same feature of B, and
    /// not of A, A's is the one of the centre.
    pub(crate) fn first_features(mut points: impl Iterator<Item = [u32; 2]>) -> [u32; 2] {
        let Some([a, b]) = points.next() else { return Self::CENTER };
        let (is_a, is_b) = points.fold((true, true), |(is_a, is_b), next| (is_a && next[0] == a, is_b && next[1] == b));
        if is_b && !is_a { [Self::CENTER[0], b] } else { [a, b] }
    }

    pub(crate) const EMPTY: Self = Self { w: DVec3::ZERO, a: DVec3::ZERO, features: [0; 2] };

    /// The point of B, in A's frame.
    pub(crate) fn b(&self) -> DVec3 {
        self.a - self.w
    }
}

/// Next need of a search in the difference.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step<T> {
    /// The support point in this direction.
    Ask(DVec3),
    /// Nothing: this is the answer.
    Answer(T),
}

/// A support query that is interrupted wherever it waits for memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interrupted {
    dir: DVec3,
    /// The negated direction, in B's frame.
    dir_in_b: DVec3,
    on_a: Lookup,
    on_b: Lookup,
}

impl Interrupted {
    pub(crate) fn dir(&self) -> DVec3 {
        self.dir
    }

    #[inline]
    pub(crate) fn is_ready(&self) -> bool {
        self.on_a.is_ready() && self.on_b.is_ready()
    }
}

/// The Minkowski difference A − B of two shapes, with B at a pose.
///
/// All points, directions and lengths are in A's frame and the shapes' unit.
///
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Minkowski, Pose, shapes::Cuboid};
///
/// let (a, b) = (Cuboid::new(DVec3::ONE)?, Cuboid::new(DVec3::splat(0.5))?);
/// let b_in_a = Pose::from_translation(DVec3::new(4.0, 0.0, 0.0))?;
/// let mut difference = Minkowski::new(&a, &b, b_in_a);
/// // The largest x of A minus the smallest x of B: 1 − 3.5. It is negative, so x separates the shapes.
/// let vertex = difference.support(DVec3::X);
/// assert_eq!(vertex.w.x, -2.5);
/// assert_eq!(vertex.w, vertex.a - vertex.b);
/// assert_eq!(difference.support_calls(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Minkowski<'s, A: ?Sized, B: ?Sized> {
    a: &'s A,
    b: &'s B,
    rotation: DMat3,
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
    rounding_error: f64,
    support_calls: u32,
}

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'s, A, B> {
    /// The difference of `a` and of `b` at `b_in_a`.
    ///
    /// # Complexity
    /// One query of each interior point and radius. No support call.
    #[inline(always)]
    pub fn new(a: &'s A, b: &'s B, b_in_a: Pose) -> Self {
        let rotation = rotation_matrix(b_in_a);
        let center_a = a.interior_point();
        let center_b_local = b.interior_point();
        let outer_radius = a.outer_radius() + b.outer_radius();
        let center_b = rotation * center_b_local + b_in_a.translation();
        let noise = f64::EPSILON
            * (rounding_units::CENTER_A * l1_norm(center_a)
                + rounding_units::CENTER_B * l1_norm(center_b_local)
                + rounding_units::TRANSLATION * l1_norm(b_in_a.translation())
                + rounding_units::RADII * outer_radius
                + rounding_units::CENTER * l1_norm(center_a - center_b));
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
            rounding_error: noise + a.support_error() + b.support_error(),
            support_calls: 0,
        }
    }

    /// Result of `query` if B is moved by `by`, in A's frame, which is no longer than the shapes
    /// together. The rounding error is the noise alone: the points that it finds count, and not
    /// whether they are the farthest.
    pub(super) fn moved<T>(&mut self, by: DVec3, query: impl FnOnce(&mut Self) -> T) -> T {
        let (center_b, rounding_error) = (self.center_b, self.rounding_error);
        self.center_b += by;
        self.rounding_error = self.noise;
        let found = query(self);
        (self.center_b, self.rounding_error) = (center_b, rounding_error);
        found
    }

    /// Support point of the difference in direction `dir`.
    ///
    /// `dir` is in A's frame, finite and non-zero; it need not be of unit length.
    ///
    /// # Complexity
    /// One support query of each shape and two matrix products.
    pub fn support(&mut self, dir: DVec3) -> Vertex {
        self.support_calls += 1;
        let on_a = self.a.support_point(dir);
        let on_b = self.b.support_point(self.unrotation * -dir);
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

    /// [`support`](Self::support) in compact form.
    #[inline(always)]
    pub(crate) fn point(&mut self, dir: DVec3) -> Point {
        self.support_calls += 1;
        let on_a = self.a.support_point(dir);
        let on_b = self.b.support_point(self.unrotation * -dir);
        self.point_of(on_a.point, on_b.point, [on_a.feature, on_b.feature])
    }

    /// [`point`](Self::point) where the support point of A is known.
    #[inline(always)]
    pub(super) fn point_with_a(&mut self, a: DVec3, feature: u32, dir: DVec3) -> Point {
        self.support_calls += 1;
        let on_b = self.b.support_point(self.unrotation * -dir);
        self.point_of(a, on_b.point, [feature, on_b.feature])
    }

    /// [`point`](Self::point) where the support point of B is known, in B's frame.
    #[inline(always)]
    pub(super) fn point_with_b(&mut self, b_local: DVec3, feature: u32, dir: DVec3) -> Point {
        self.support_calls += 1;
        let on_a = self.a.support_point(dir);
        self.point_of(on_a.point, b_local, [on_a.feature, feature])
    }

    #[inline(always)]
    pub(crate) fn start(&self, dir: DVec3) -> Interrupted {
        let dir_in_b = self.unrotation * -dir;
        Interrupted { dir, dir_in_b, on_a: self.a.start_lookup(dir), on_b: self.b.start_lookup(dir_in_b) }
    }

    /// Continues a support query up to the next memory that it reads.
    #[inline]
    pub(crate) fn resume(&self, query: &mut Interrupted) {
        query.on_a = self.a.continue_lookup(query.dir, query.on_a);
        query.on_b = self.b.continue_lookup(query.dir_in_b, query.on_b);
    }

    /// The point of [`point`](Self::point), from a query that is ready.
    #[inline(always)]
    pub(crate) fn finish(&mut self, query: &Interrupted) -> Point {
        self.support_calls += 1;
        let on_a = self.a.finish_lookup(query.dir, query.on_a);
        let on_b = self.b.finish_lookup(query.dir_in_b, query.on_b);
        self.point_of(on_a.point, on_b.point, [on_a.feature, on_b.feature])
    }

    /// The point of these features under this pose, without a support query. `None` if a shape does
    /// not know it.
    #[inline(always)]
    pub(crate) fn recall(&self, features: [u32; 2]) -> Option<Point> {
        if features == Point::CENTER {
            return Some(self.center_point());
        }
        Some(self.point_of(self.a.point(features[0])?, self.b.point(features[1])?, features))
    }

    /// The point of the difference for a point of A in A's frame and a point of B in B's frame.
    #[inline(always)]
    pub(super) fn point_of(&self, a: DVec3, b_local: DVec3, features: [u32; 2]) -> Point {
        let offset_b = self.rotation * (b_local - self.center_b_local);
        Point { w: (self.center_a - self.center_b) + ((a - self.center_a) - offset_b), a, features }
    }

    /// [`center`](Self::center) in compact form.
    #[inline(always)]
    pub(crate) fn center_point(&self) -> Point {
        Point { w: self.center_a - self.center_b, a: self.center_a, features: Point::CENTER }
    }

    /// The centre v0: the difference of the interior points. It lies in the CSO.
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

    /// Radius of a ball around the centre that lies in the CSO; 0 if no such ball is known.
    pub fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    /// Radius of a ball around the centre that contains the CSO.
    pub fn outer_radius(&self) -> f64 {
        self.outer_radius
    }

    /// Upper bound of the solver's own rounding error in a support value, or in the offset of a
    /// plane through vertices.
    ///
    /// It is a length, proportional to the lengths of the query.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// [`noise`](Self::noise) plus the support errors of both shapes: a length.
    ///
    /// The sign of a support value of smaller magnitude is not significant.
    pub fn rounding_error(&self) -> f64 {
        self.rounding_error
    }

    /// Number of support calls so far. One call queries A once and B once.
    pub fn support_calls(&self) -> u32 {
        self.support_calls
    }

    /// True if the balls inside the shapes overlap, which proves that the shapes do. No support
    /// call.
    pub(crate) fn inner_balls_overlap(&self) -> bool {
        let radius = self.inner_radius - self.rounding_error;
        radius > 0.0 && self.center_point().w.length_squared() < radius * radius
    }

    /// True if the balls around the shapes are separated, which proves that the shapes are. No
    /// support call.
    pub(crate) fn outer_balls_separated(&self) -> bool {
        let radius = self.outer_radius + self.rounding_error;
        self.center_point().w.length_squared() > radius * radius
    }

    /// The line of centres, if the outer balls are separated: a separating axis of unit length.
    #[inline(always)]
    pub(super) fn axis_of_balls(&self) -> Option<DVec3> {
        if self.outer_balls_separated() { unit(-self.center_point().w) } else { None }
    }

    /// The facets of A and of B, each in its own frame; `None` if one has none.
    #[inline(always)]
    pub(super) fn facets(&self) -> Option<[Facets<'s>; 2]> {
        Some([self.a.facets()?, self.b.facets()?])
    }

    /// Whether the support `point` in direction `axis`, of unit length, proves that the axis
    /// separates the shapes.
    #[inline(always)]
    pub(super) fn separates(&self, axis: DVec3, point: &Point) -> bool {
        point.w.dot(axis) < -self.rounding_error
    }

    pub(super) fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// A common point of A and B, provided that [`inner_balls_overlap`](Self::inner_balls_overlap).
    ///
    /// It divides the segment between the interior points in the ratio of the inner radii.
    pub(crate) fn point_in_both_balls(&self) -> DVec3 {
        let ratio = self.inner_radius_a / self.inner_radius;
        self.center_a - (self.center_a - self.center_b) * ratio
    }
}

/// The rotation of `pose` as a matrix, with one load for each component of the quaternion.
///
/// The caller has just written the pose. The compiler would load two components at once, and where
/// these were written by two stores, the processor waits for both: 15 ns on an Intel Xeon.
#[inline(always)]
fn rotation_matrix(pose: Pose) -> DMat3 {
    DMat3::from_quat(DQuat::from_array(pose.rotation().to_array().map(black_box)))
}

/// L1 norm of `v`: at least its length and at most 1.8 times its length, without a square root.
#[inline]
fn l1_norm(v: DVec3) -> f64 {
    v.x.abs() + v.y.abs() + v.z.abs()
}
