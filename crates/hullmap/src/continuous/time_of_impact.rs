//! Answer of queries about moving bodies: when they first meet.

use glam::DVec3;

use crate::fields::fields;
use crate::solver::Status;

/// Answer of [`cast_motion`](crate::cast_motion()): when and where two moving shapes first meet.
///
/// Points and directions are in the common frame of the motions.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOfImpact {
    /// False only if it is certain that the shapes do not meet until time 1.
    pub hit: bool,
    /// How the query ended.
    ///
    /// - [`Separated`](Status::Separated): certainly no hit. All times are infinite.
    /// - [`Overlapping`](Status::Overlapping): the shapes meet at the start, in their poses as
    ///   computed there. All times are 0.
    /// - [`Within`](Status::Within): a hit in the interval. At `t_lower` the shapes are within the
    ///   tolerance of the target distance.
    /// - [`Touching`](Status::Touching): the shapes come within rounding error of each other, and
    ///   may graze without meeting. If they meet, they do so in the interval.
    /// - [`IterationLimit`](Status::IterationLimit), [`Stalled`](Status::Stalled): it is open
    ///   whether they meet. If they do, it is in the interval.
    pub status: Status,
    /// Time of impact, between 0 and 1; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of the time of impact, with allowance for rounding error. Until then the shapes
    /// are certainly farther apart than the target distance.
    pub t_lower: f64,
    /// Upper bound: at this time the shapes are certainly within the target distance. Infinite if
    /// no such time was found.
    pub t_upper: f64,
    /// Unit vector from A to B at `t_lower`: normal of a plane that separates the shapes then.
    pub normal: DVec3,
    /// Point of A closest to B at `t_lower`.
    pub point_a: DVec3,
    /// Point of B closest to A at `t_lower`.
    pub point_b: DVec3,
    /// Number of distance and contact queries.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    /// mesh or a field. 0 for a shape without parts.
    pub parts: [u32; 2],
}

fields!(TimeOfImpact { hit status t t_lower t_upper normal point_a point_b iterations support_calls parts });

impl Default for TimeOfImpact {
    /// An answer that claims nothing.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::IterationLimit,
            t: 0.0,
            t_lower: 0.0,
            t_upper: f64::INFINITY,
            normal: DVec3::X,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            iterations: 0,
            support_calls: 0,
            parts: [0; 2],
        }
    }
}

impl TimeOfImpact {
    /// The answer for bodies that certainly do not meet, but for the normal and the counts.
    pub(crate) const NEVER: Self = Self {
        hit: false,
        status: Status::Separated,
        t: f64::INFINITY,
        t_lower: f64::INFINITY,
        t_upper: f64::INFINITY,
        normal: DVec3::X,
        point_a: DVec3::ZERO,
        point_b: DVec3::ZERO,
        iterations: 0,
        support_calls: 0,
        parts: [0; 2],
    };

    pub(crate) fn exchanged(self) -> Self {
        let Self { point_a, point_b, parts: [of_a, of_b], .. } = self;
        Self { normal: -self.normal, point_a: point_b, point_b: point_a, parts: [of_b, of_a], ..self }
    }

    /// The answer, with its points moved to the frame in which `origin` is the origin of the frame
    /// that they are in.
    pub(crate) fn relative_to(mut self, origin: DVec3) -> Self {
        if self.hit {
            self.point_a += origin;
            self.point_b += origin;
        }
        self
    }
}
