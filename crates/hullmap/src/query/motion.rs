//! Queries of two geometries that move: when they first meet, and whether they stay clear.

use super::{PairQuery, answer};
use crate::compound::{self, Parts, half_space};
use crate::continuous::{self, ClearSettings, Clearance, MotionSettings, RigidMotion, TimeOfImpact};
use crate::geometry::Geometry;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{self, Cache, CastSettings, Impact, Motion};

/// When B, which starts at `b_in_a` and translates by `motion`, first meets A: the time of impact.
///
/// Nothing rotates. Points and directions are in A's frame. The time is in the unit of `motion`,
/// from 0 to `settings.max_t`. `cache` belongs to this ordered pair; the query reads and updates
/// it.
///
/// With parts, the answer comes from the pair of parts that meet first, and its interval contains
/// the time of impact of the whole. A pair that grazes, where rounding error decides, before the
/// first certain hit is the answer, with the status [`Stalled`](crate::Status::Stalled), and the
/// interval extends to the certain hit. If only grazing pairs were found, it contains the intervals
/// of all of them. If there is no hit, points and normal mean nothing. A point
/// ([`Sphere`](crate::shapes::Sphere) of radius 0) meets triangles and hulls exactly as a
/// [`ray`](crate::ray()) does. For a half-space, the normal is the plane's.
///
/// # Complexity
/// Two shapes: no support call if their bounding balls miss each other, one if the last separating
/// direction still separates them. 10 to 30 for most hits. Rounded shapes cost 3 to 8 distance
/// queries of their cores. The number of steps is bounded by `settings`. Parts: branch and bound,
/// at most one cast for each pair of parts, and usually only the few within the distance covered
/// until the hit. Half-space: one support query for each part. Allocation: see [`Cache`].
///
/// # Reference
/// van den Bergen 2004; Snethen, "XenoCollide". docs/contributors/intervals.md proves the interval.
#[inline]
pub fn cast<A, B>(a: &A, b: &B, b_in_a: Pose, motion: Motion, settings: &CastSettings, cache: &mut Cache) -> Impact
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, Cast { b_in_a, motion, settings, cache })
}

/// When `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, first meet.
///
/// Motions are in a common frame, over the times 0 to 1. `cache` belongs to this ordered pair; the
/// query reads and updates it.
///
/// With parts, the answer comes from the pair of parts that meet first, and its interval contains
/// the time at which the whole first meets. If the upper bound is finite, it certainly does,
/// whatever the status. The limit [`max_iterations`](MotionSettings::max_iterations) is one of all
/// queries of parts and of boxes together: many parts need more than the default. If it is reached,
/// the lower bound is the earliest time at which a pair that is not decided may meet. For a
/// half-space, the normal is the plane's.
///
/// # Complexity
/// Two shapes: 2 to 8 distance queries for most pairs, and about four times as many support
/// queries; bounded by `settings`. Parts: branch and bound, usually only searches for the few pairs
/// that may meet first. Half-space: 2 to 4 steps for most motions, of up to a dozen support queries
/// each. Allocation: see [`Cache`].
///
/// # Reference
/// Mirtich 1996 (conservative advancement). docs/contributors/intervals.md proves the interval.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Cache, MotionSettings, Pose, RigidMotion, Status, cast_motion};
/// use std::f64::consts::FRAC_PI_2;
///
/// // A rod of length 2 turns by 90 degrees, towards a wall whose side is at y = 0.6.
/// let rod = Cuboid::new(DVec3::new(1.0, 0.01, 0.01))?;
/// let wall = Cuboid::new(DVec3::new(5.0, 0.1, 5.0))?;
/// let quarter = DVec3::Z * FRAC_PI_2;
/// let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, quarter, DVec3::ZERO)?;
/// let still = RigidMotion::still(Pose::from_translation(DVec3::new(0.0, 0.7, 0.0))?);
/// let settings = MotionSettings::default();
/// let found = cast_motion(&rod, &turning, &wall, &still, &settings, &mut Cache::new());
/// // The corner at (1, 0.01) reaches y = 0.6.
/// let angle = (0.6 / 1.0001_f64.sqrt()).asin() - 0.01_f64.atan();
/// assert_eq!(found.status, Status::Within);
/// assert!((found.t - angle / FRAC_PI_2).abs() < 1e-5 && found.iterations < 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cast_motion<A, B>(
    a: &A,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &MotionSettings,
    cache: &mut Cache,
) -> TimeOfImpact
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, CastMotion { motions: [motion_a, motion_b], settings, cache })
}

/// Whether `a`, which moves by `motion_a`, and `b`, which moves by `motion_b`, stay farther apart
/// than a margin, and the least distance that is proven.
///
/// Motions are in a common frame, over the times 0 to 1. `cache` belongs to this ordered pair; the
/// query reads and updates it. With parts, the limit of queries is the
/// same as for [`cast_motion`](cast_motion()), and applies to both searches together.
///
/// # Complexity
/// The same as for [`cast_motion`](cast_motion()); twice as much for a free motion if
/// [`share`](ClearSettings::share) is not 0. Allocation: see [`Cache`].
///
/// # Reference
/// Schwarzer, Saha, Latombe, "Adaptive dynamic collision checking for single and multiple
/// articulated robots in complex environments", 2005, for motions that are proven instead of
/// sampled.
/// docs/contributors/intervals.md, section 15, proves the bounds.
///
/// # Examples
/// ```
/// use hullmap::glam::{DQuat, DVec3};
/// use hullmap::shapes::{Cuboid, Sphere};
/// use hullmap::{Cache, ClearSettings, Pose, RigidMotion, Verdict, clear};
/// use std::f64::consts::FRAC_PI_2;
///
/// // A rod of length 2 turns by 90 degrees, past a ball that its end does not reach.
/// let (rod, ball) = (Cuboid::new(DVec3::new(1.0, 0.01, 0.01))?, Sphere::new(0.25)?);
/// let end = Pose::new(DVec3::ZERO, DQuat::from_rotation_z(FRAC_PI_2))?;
/// let turning = RigidMotion::between(Pose::IDENTITY, end)?;
/// let at = |x: f64| Pose::from_translation(DVec3::new(x, x, 0.0)).map(RigidMotion::still);
/// let settings = ClearSettings::default();
/// let found = clear(&rod, &turning, &ball, &at(1.0)?, &settings, &mut Cache::new());
/// assert_eq!(found.verdict, Verdict::Free);
/// // The centre is √2 from the axis.
/// let least = 2.0_f64.sqrt() - 0.25 - 1.0001_f64.sqrt();
/// assert!(0.5 * least < found.clearance && found.clearance <= least);
///
/// let found = clear(&rod, &turning, &ball, &at(0.7)?, &settings, &mut Cache::new());
/// assert_eq!(found.verdict, Verdict::Hit);
/// assert!(found.t_lower < found.t_upper && found.t_upper < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn clear<A, B>(
    a: &A,
    motion_a: &RigidMotion,
    b: &B,
    motion_b: &RigidMotion,
    settings: &ClearSettings,
    cache: &mut Cache,
) -> Clearance
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, Clear { motions: [motion_a, motion_b], settings, cache })
}

struct Cast<'q> {
    b_in_a: Pose,
    motion: Motion,
    settings: &'q CastSettings,
    cache: &'q mut Cache,
}

impl PairQuery for Cast<'_> {
    type Answer = Impact;

    #[inline(always)]
    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Impact {
        solver::cast::cast(a, b, self.b_in_a, self.motion, self.settings, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Impact {
        compound::motion::cast(a, b, self.b_in_a, self.motion, self.settings, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Impact {
        half_space::cast(a, b, self.b_in_a, self.motion, self.settings)
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Impact {
        let Self { b_in_a, motion, settings, .. } = self;
        half_space::cast(b, a, b_in_a.inverse(), motion.seen_from(b_in_a), settings)
            .exchanged(b_in_a, motion.velocity())
    }
}

struct CastMotion<'q> {
    motions: [&'q RigidMotion; 2],
    settings: &'q MotionSettings,
    cache: &'q mut Cache,
}

impl PairQuery for CastMotion<'_> {
    type Answer = TimeOfImpact;

    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> TimeOfImpact {
        continuous::cast_motion::cast_motion(a, b, self.motions, self.settings, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> TimeOfImpact {
        compound::cast_motion::cast_motion(a, b, self.motions, self.settings, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> TimeOfImpact {
        half_space::cast_motion(a, b, self.motions, self.settings)
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> TimeOfImpact {
        let [motion_a, motion_b] = self.motions;
        half_space::cast_motion(b, a, [motion_b, motion_a], self.settings).exchanged()
    }
}

struct Clear<'q> {
    motions: [&'q RigidMotion; 2],
    settings: &'q ClearSettings,
    cache: &'q mut Cache,
}

impl PairQuery for Clear<'_> {
    type Answer = Clearance;

    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Clearance {
        continuous::clear::clear(a, b, self.motions, self.settings, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Clearance {
        compound::clear::clear(a, b, self.motions, self.settings, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Clearance {
        half_space::clear(a, b, self.motions, self.settings)
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Clearance {
        let [motion_a, motion_b] = self.motions;
        let found = half_space::clear(b, a, [motion_b, motion_a], self.settings);
        let [of_b, of_a] = found.parts;
        Clearance { parts: [of_a, of_b], ..found }
    }
}
