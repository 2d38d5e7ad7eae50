//! The search for the time of impact of a half-space and a shape that move and turn.
//!
//! # Steps
//! As for two shapes (`search`). The only direction is the normal of the plane, which turns with
//! the half-space; the support point of the shape below it gives distance and depth in closed form.

use super::advance::{Approach, Moving};
use super::rigid_motion::RigidMotion;
use super::search::{Goal, ImpactSearch, Queries};
use super::time_of_impact::TimeOfImpact;
use crate::pose::Pose;
use crate::shapes::HalfSpace;
use crate::solver::{Contact, Distance};
use crate::support::SupportMap;

impl HalfSpace {
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

struct PlaneQueries<'q, B: ?Sized> {
    plane: &'q HalfSpace,
    b: &'q B,
}

impl<B: SupportMap + ?Sized> Queries for PlaneQueries<'_, B> {
    fn distance(&mut self, b_in_a: Pose) -> Distance {
        self.plane.lowest(self.b, b_in_a).distance()
    }

    fn contact(&mut self, b_in_a: Pose) -> Contact {
        self.plane.lowest(self.b, b_in_a).contact()
    }
}
