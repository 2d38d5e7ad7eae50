//! Time of impact of a half-space and a shape that move and turn, and whether they stay clear.
//!
//! # Steps
//! As for two shapes (`search`). The only direction is the normal of the plane, which turns with
//! the half-space; the support point of the shape below it gives distance and depth in closed form.

use super::advance::{Approach, Moving};
use super::cast_motion::MotionSettings;
use super::clear::{ClearSettings, Clearance, judge};
use super::rigid_motion::RigidMotion;
use super::search::{Goal, ImpactSearch, Queries};
use super::time_of_impact::TimeOfImpact;
use crate::pose::Pose;
use crate::shapes::HalfSpace;
use crate::solver::{Contact, Distance};
use crate::support::SupportMap;

impl HalfSpace {
    /// When `b`, which moves by `motion_b`, first meets the half-space, which moves by `motion`.
    ///
    /// As [`cast_motion`](crate::cast_motion()). The normal is always the plane's, in the common
    /// frame of the motions.
    ///
    /// # Complexity
    /// 2 to 4 steps for most motions, of up to a dozen support queries of the shape each. No
    /// allocation.
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, HalfSpace};
    /// use hullmap::{MotionSettings, Pose, RigidMotion};
    /// use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    ///
    /// // A cube of half length 1 rolls about its centre, at a height of 1.25 over the floor.
    /// let (floor, cube) = (HalfSpace::new(DVec3::Z, 0.0)?, Cuboid::new(DVec3::ONE)?);
    /// let start = Pose::from_translation(DVec3::new(0.0, 0.0, 1.25))?;
    /// let rolling = RigidMotion::screw(start, DVec3::ZERO, DVec3::X * FRAC_PI_2, start.translation())?;
    /// let resting = RigidMotion::still(Pose::IDENTITY);
    /// let found = floor.cast_motion(&resting, &cube, &rolling, &MotionSettings::default());
    /// // Its edge is √2 from the centre.
    /// let angle = FRAC_PI_4 - (1.25_f64 / 2.0_f64.sqrt()).acos();
    /// assert!(found.hit && (found.t - angle / FRAC_PI_2).abs() < 1e-5);
    /// assert!(found.t_lower <= found.t && found.t <= found.t_upper);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cast_motion<B: SupportMap + ?Sized>(
        &self,
        motion: &RigidMotion,
        b: &B,
        motion_b: &RigidMotion,
        settings: &MotionSettings,
    ) -> TimeOfImpact {
        let origin = motion_b.start();
        let motions = [motion, motion_b].map(|motion| motion.relative_to(origin));
        let mut goal = settings.goal(motions);
        self.search(b, motions, settings.tolerance, &mut goal, [0.0, 1.0]).relative_to(origin)
    }

    /// Whether `b`, which moves by `motion_b`, stays farther than a margin from the half-space,
    /// which moves by `motion`, and the least distance that is proven.
    ///
    /// As [`clear`](crate::clear()).
    ///
    /// # Complexity
    /// The same as for [`cast_motion`](Self::cast_motion); twice as much for a free motion if
    /// [`share`](ClearSettings::share) is not 0. No allocation.
    ///
    /// # Examples
    /// ```
    /// use hullmap::glam::DVec3;
    /// use hullmap::shapes::{Cuboid, HalfSpace};
    /// use hullmap::{ClearSettings, Pose, RigidMotion, Verdict};
    /// use std::f64::consts::FRAC_PI_2;
    ///
    /// // A cube of half length 1 rolls about its centre. Its edge is √2 from the centre.
    /// let (floor, cube) = (HalfSpace::new(DVec3::Z, 0.0)?, Cuboid::new(DVec3::ONE)?);
    /// let resting = RigidMotion::still(Pose::IDENTITY);
    /// let rolling = |height: f64| -> Result<_, Box<dyn std::error::Error>> {
    ///     let start = Pose::from_translation(DVec3::new(0.0, 0.0, height))?;
    ///     Ok(RigidMotion::screw(start, DVec3::ZERO, DVec3::X * FRAC_PI_2, start.translation())?)
    /// };
    /// let found = floor.clear(&resting, &cube, &rolling(1.5)?, &ClearSettings::default());
    /// let least = 1.5 - 2.0_f64.sqrt();
    /// assert_eq!(found.verdict, Verdict::Free);
    /// assert!(0.5 * least <= found.clearance && found.clearance <= least);
    /// let found = floor.clear(&resting, &cube, &rolling(1.25)?, &ClearSettings::default());
    /// assert_eq!(found.verdict, Verdict::Hit);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn clear<B: SupportMap + ?Sized>(
        &self,
        motion: &RigidMotion,
        b: &B,
        motion_b: &RigidMotion,
        settings: &ClearSettings,
    ) -> Clearance {
        let origin = motion_b.start();
        let motions = [motion, motion_b].map(|motion| motion.relative_to(origin));
        judge(settings, motions, |goal| self.search(b, motions, settings.motion.tolerance, goal, [0.0, 1.0]))
    }

    /// The search of the half-space and a shape in a `window` of time.
    pub(crate) fn search<B: SupportMap + ?Sized>(
        &self,
        b: &B,
        [motion, motion_b]: [RigidMotion; 2],
        tolerance: f64,
        goal: &mut Goal,
        window: [f64; 2],
    ) -> TimeOfImpact {
        let foot = self.foot();
        let (a, b) = (Moving { shape: &foot, motion }, Moving { shape: b, motion: motion_b });
        let queries = PlaneQueries { plane: self, b: b.shape };
        ImpactSearch::run(Approach::new(a, b, true), queries, tolerance, goal, window)
    }
}

/// The queries of a half-space and a shape.
struct PlaneQueries<'q, B: ?Sized> {
    plane: &'q HalfSpace,
    b: &'q B,
}

impl<B: SupportMap + ?Sized> Queries for PlaneQueries<'_, B> {
    fn distance(&mut self, b_in_a: Pose) -> Distance {
        self.plane.distance(self.b, b_in_a)
    }

    fn contact(&mut self, b_in_a: Pose) -> Contact {
        self.plane.contact(self.b, b_in_a)
    }
}
