//! Derivatives of distances, depths and signed distances.
//!
//! The distance is n · (b − a), with the normal n and the witness points a and b. To first order,
//! it changes as if these points moved with their shapes and n did not change. The depth is
//! n · (a − b).

use glam::DVec3;

use super::newton::{Condition, Refined, are_described, are_polytopes, if_accurate, is_accurate, refined};
use super::pose_derivative::{Derivatives, Differentiability, PoseDerivative};
use super::witness::{UNKNOWN, closest_points, meeting_points, normal_error};
use crate::pose::Pose;
use crate::solver::bound::SAME_NORMAL;
use crate::solver::queries::{contact, distance};
use crate::solver::ray::Dot;
use crate::solver::{Cache, Contact, Distance, Settings, SignedDistance, Status};
use crate::support::SupportMap;

/// Derivatives of the height of b over a along `normal`.
fn between(normal: DVec3, [point_a, point_b]: [DVec3; 2], b_in_a: Pose, status: Differentiability) -> Derivatives {
    Derivatives {
        status,
        by_a: PoseDerivative::of_height(-normal, point_a, DVec3::ZERO),
        by_b: PoseDerivative::of_height(normal, point_b, b_in_a.translation()),
    }
}

impl Distance {
    /// Derivatives of the distance by the poses of `a` and of `b`, which is at `b_in_a`: of the
    /// shapes of this answer. In A's frame; [`in_world`](Derivatives::in_world) turns them.
    ///
    /// They are as accurate as rounding error allows, whatever the tolerance: where the answer is
    /// less accurate, as for cylinders and cones, Newton's method finds the normal and the points.
    /// For a curved shape of your own, whose features are not known, they are as accurate as the
    /// answer: with a tolerance of ε, the normal is off by up to √(2 ε), usually by much less.
    ///
    /// # Complexity
    /// At most 10 support queries for polytopes; otherwise 16 to 60, and rarely a second distance
    /// query. No allocation.
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, Sphere};
    /// use hullmap::{Cache, Differentiability, Pose, Settings, distance};
    ///
    /// let (cube, ball) = (Cuboid::new(DVec3::ONE)?, Sphere::new(0.5)?);
    /// let b_in_a = Pose::from_translation(DVec3::new(4.0, 0.5, 0.0))?;
    /// let gap = distance(&cube, &ball, b_in_a, &Settings::default(), &mut Cache::new());
    /// let by = gap.derivatives(&cube, &ball, b_in_a);
    /// assert_eq!(by.status, Differentiability::Unique);
    /// assert!(by.by_b.linear.distance(DVec3::X) < 1e-12 && by.by_b.angular.length() < 1e-12);
    /// // Where the cube turns about z, its face at (1, 0.5, 0) recedes from the ball.
    /// assert!((by.by_a.angular.z - 0.5).abs() < 1e-12);
    ///
    /// // Two parallel faces.
    /// let gap = distance(&cube, &cube, b_in_a, &Settings::default(), &mut Cache::new());
    /// assert_eq!(gap.derivatives(&cube, &cube, b_in_a).status, Differentiability::Parallel);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
    ) -> Derivatives {
        // NaN takes the failing branch.
        let status = if !(self.lower > 0.0) {
            Differentiability::Touching
        } else if !is_accurate(self.status) {
            Differentiability::Inaccurate
        } else if self.status == Status::Exact && are_polytopes(a, b) {
            closest_points((a, b, b_in_a), self.normal, normal_error([self.lower, self.upper]), self.features)
        } else {
            return self.refined_derivatives(a, b, b_in_a);
        };
        between(self.normal, [self.point_a, self.point_b], b_in_a, status)
    }

    #[cold]
    #[inline(never)]
    fn refined_derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
    ) -> Derivatives {
        let (found, is_refined) = self.refined(a, b, b_in_a);
        let error = if is_refined { 0.0 } else { normal_error([found.lower, found.upper]) };
        let status = closest_points((a, b, b_in_a), found.normal, error, UNKNOWN);
        let status = if_accurate(status, is_refined || !are_described((a, b, b_in_a), found.normal));
        between(found.normal, [found.point_a, found.point_b], b_in_a, status)
    }

    /// The answer with normal and points as accurate as rounding error allows, and true; or the
    /// best that is known.
    fn refined<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(&self, a: &A, b: &B, b_in_a: Pose) -> (Self, bool) {
        let radii = a.convex_radius() + b.convex_radius();
        let refine = |answer: &Self| {
            let near = Refined { normal: answer.normal, points: [answer.point_a, answer.point_b] };
            let interval = [answer.lower + radii, answer.upper + radii];
            let found = refined((a, b, b_in_a), near, normal_error(interval), Condition::Along(interval))?;
            Some(Self { normal: found.normal, point_a: found.points[0], point_b: found.points[1], ..*answer })
        };
        if let Some(found) = refine(self) {
            return (found, true);
        }
        let exact = Settings { tolerance: 0.0, ..Settings::default() };
        let again = distance(a, b, b_in_a, &exact, &mut Cache::from_axis(self.normal));
        let is_exact = again.status == Status::Exact && are_polytopes(a, b);
        refine(&again).map_or((again, is_exact), |found| (found, true))
    }
}

impl Contact {
    /// Derivatives of the depth by the poses of `a` and of `b`, which is at `b_in_a`: of the shapes
    /// of this answer. In A's frame; [`in_world`](Derivatives::in_world) turns them.
    ///
    /// Usually the answer determines whether other normals have the same depth. If not, as for
    /// curved shapes, a second contact query decides, with B deeper by 1e-6 of the outer radii, and
    /// `settings` and `cache` as for the first.
    ///
    /// # Complexity
    /// At most 10 support queries; with a second query, the support queries of a
    /// [`contact`](crate::contact()), and 6 to 20 of each shape. No allocation.
    pub fn derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Derivatives {
        if !self.hit {
            return Derivatives::none(Differentiability::Missing);
        }
        // NaN takes the failing branch.
        let status = if !(self.depth_lower > 0.0) {
            Differentiability::Touching
        } else if !is_accurate(self.status) {
            Differentiability::Inaccurate
        } else {
            let (found, status) = self.meeting_derivatives(a, b, b_in_a, settings, cache);
            return between(-found.normal, [found.point_a, found.point_b], b_in_a, status);
        };
        between(-self.normal, [self.point_a, self.point_b], b_in_a, status)
    }

    /// The answer with normal and points as accurate as rounding error allows, and whether its
    /// depth has a derivative.
    fn meeting_derivatives<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> (Self, Differentiability) {
        let is_exact = self.status == Status::Exact && are_polytopes(a, b);
        if is_exact && self.is_only_normal {
            return (*self, closest_points((a, b, b_in_a), self.normal, 0.0, self.features));
        }
        let (found, is_refined) = if is_exact { (*self, true) } else { self.refined(a, b, b_in_a, settings, cache) };
        let status = if self.is_only_normal {
            closest_points((a, b, b_in_a), found.normal, 0.0, UNKNOWN)
        } else {
            found.meeting(a, b, b_in_a, settings, cache)
        };
        (found, if_accurate(status, is_refined || !are_described((a, b, b_in_a), found.normal)))
    }

    /// As [`Distance::refined`].
    #[cold]
    #[inline(never)]
    fn refined<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> (Self, bool) {
        let radii = a.convex_radius() + b.convex_radius();
        let refine = |answer: &Self| {
            let near = Refined { normal: answer.normal, points: [answer.point_a, answer.point_b] };
            let interval = [radii - answer.depth_upper, radii - answer.depth_lower];
            let found = refined((a, b, b_in_a), near, 0.0, Condition::Along(interval))?;
            Some(Self { normal: found.normal, point_a: found.points[0], point_b: found.points[1], ..*answer })
        };
        if let Some(found) = refine(self) {
            return (found, true);
        }
        let again = contact(a, b, b_in_a, &Settings { tolerance: 0.0, ..*settings }, cache);
        let is_exact = again.status == Status::Exact && are_polytopes(a, b);
        refine(&again).map_or((again, is_exact), |found| (found, true))
    }

    /// Whether normal and points are the only ones, by a second contact query.
    #[cold]
    #[inline(never)]
    fn meeting<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Differentiability {
        let found = meeting_points((a, b, b_in_a), self.normal, [self.point_a, self.point_b]);
        let has_other = found != Differentiability::Normals && self.has_other_normal(a, b, b_in_a, settings, cache);
        if has_other { Differentiability::Normals } else { found }
    }

    /// Whether B, deeper along the normal, is less deep along another one than along this one.
    fn has_other_normal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &Settings,
        cache: &mut Cache,
    ) -> bool {
        let deeper = self.deeper(a.outer_radius() + b.outer_radius());
        // Without a polytope to continue from, small hulls are solved faster afresh.
        if a.facets().is_some() && b.facets().is_some() && !cache.has_polytope() {
            cache.clear();
        }
        let found = contact(a, b, b_in_a.moved(-self.normal * deeper), settings, cache);
        // For smooth shapes, the normal is as accurate as the tolerance.
        let is_same = found.normal.distance(self.normal) <= SAME_NORMAL
            || found.depth_upper >= self.depth_lower + deeper * (1.0 - SAME_NORMAL);
        !is_same
    }
}

impl SignedDistance {
    /// Derivatives of the signed distance by the pose of `shape`, and by the position of `point`,
    /// which has no angular part: of the shape and the point of this answer. In the shape's frame.
    ///
    /// # Complexity
    /// The same as for [`Distance::derivatives`] and a point if the point is outside of the shape;
    /// inside, the same as for [`Contact::derivatives`].
    pub fn derivatives<S: SupportMap + ?Sized>(
        &self,
        shape: &S,
        point: DVec3,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Derivatives {
        let at_point = Pose::from_checked(point);
        let status = if !is_accurate(self.status) && self.status != Status::Touching {
            Differentiability::Inaccurate
        } else if self.lower > 0.0 {
            // A point has one nearest point of a convex shape.
            let Self { status, distance, lower, upper, normal, point: point_a, .. } = *self;
            let outside =
                Distance { status, distance, lower, upper, normal, point_a, point_b: point, ..Distance::default() };
            return outside.derivatives(shape, &Dot, at_point);
        } else if self.upper < 0.0 {
            let as_contact = Contact {
                hit: true,
                status: self.status,
                depth_lower: -self.upper,
                depth_upper: -self.lower,
                normal: self.normal,
                point_a: self.point,
                point_b: point,
                ..Contact::default()
            };
            let (found, status) = as_contact.meeting_derivatives(shape, &Dot, at_point, settings, cache);
            return between(found.normal, [found.point_a, point], at_point, status);
        } else {
            Differentiability::Touching
        };
        between(self.normal, [self.point, point], at_point, status)
    }
}
