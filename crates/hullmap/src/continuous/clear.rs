//! Whether two bodies stay clear of each other during a motion, for planners.
//!
//! # Steps
//! 1. Search for the first time at which they are within the margin, as
//!    [`cast_motion`](crate::cast_motion()) does.
//! 2. If there is none, and the distance proven is less than a share of the least distance found,
//!    search once more, and stay above that share.

use super::cast_motion::{MotionSettings, search_pair};
use super::rigid_motion::RigidMotion;
use super::search::{DIRECTIONS, Goal};
use super::time_of_impact::TimeOfImpact;
use crate::fields::{fields, words};
use crate::solver::{Cache, Status};
use crate::support::SupportMap;

/// Settings of [`clear`](crate::clear()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearSettings {
    /// Settings of the search. Bodies that come within the target distance, the margin, hit each
    /// other.
    pub motion: MotionSettings,
    /// The clearance of a free motion is at least this share of the least distance at any of the
    /// times that were tried. If it is not, the [`status`](Clearance::status) is not
    /// [`Within`](Status::Within). The default is 0.5. The more, the more steps. 0 saves the second
    /// search. NaN and negative values count as 0, values above 0.95 as 0.95.
    pub share: f64,
}

impl Default for ClearSettings {
    fn default() -> Self {
        Self { motion: MotionSettings::default(), share: 0.5 }
    }
}

/// Whether a motion is certainly free.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The bodies are certainly farther apart than the margin at all times.
    Free = 0,
    /// They are certainly within the margin at some time.
    Hit = 1,
    /// Neither is known: they graze the margin within rounding error, or the limit of queries was
    /// reached.
    Open = 2,
}

words!(Verdict { Free = "free" Hit = "hit" Open = "open" });

/// Answer of [`clear`](crate::clear()): whether a motion is free, and with which clearance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Whether the motion is free.
    pub verdict: Verdict,
    /// How the search ended.
    ///
    /// - [`Within`](Status::Within): a hit, or a free motion whose clearance is at least the
    ///   [`share`](ClearSettings::share) of the nearest distance.
    /// - [`Overlapping`](Status::Overlapping): a hit at the start.
    /// - [`IterationLimit`](Status::IterationLimit): the limit of queries was reached. The motion
    ///   is open, or free with a smaller clearance.
    /// - [`Touching`](Status::Touching), [`Stalled`](Status::Stalled): the same, but rounding error
    ///   stopped the search.
    pub status: Status,
    /// Lower bound of the least distance during a free motion, with allowance for rounding error. 0
    /// if it is not known to be free.
    pub clearance: f64,
    /// Upper bound of the least distance: the bodies are this near at some time that was tried. It
    /// is infinite if no parts were near enough to be tried.
    pub nearest: f64,
    /// Until this time, the bodies are certainly farther apart than the margin. Infinite if they
    /// are at all times.
    pub t_lower: f64,
    /// At this time, the bodies are certainly within the margin. Infinite if no such time is known.
    pub t_upper: f64,
    /// Number of distance and contact queries.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that meet first if the motion hits, by index: hulls of a pack,
    /// triangles of a mesh or a field. 0 otherwise, and for a shape without parts.
    pub parts: [u32; 2],
}

fields!(Clearance { verdict status clearance nearest t_lower t_upper iterations support_calls parts });

impl Default for Clearance {
    /// An answer that claims nothing. It initialises the slices of a batch.
    fn default() -> Self {
        Self {
            verdict: Verdict::Open,
            status: Status::IterationLimit,
            clearance: 0.0,
            nearest: f64::INFINITY,
            t_lower: 0.0,
            t_upper: f64::INFINITY,
            iterations: 0,
            support_calls: 0,
            parts: [0; 2],
        }
    }
}

/// [`clear`](crate::clear()) of two convex shapes.
pub(crate) fn clear<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    motions: [&RigidMotion; 2],
    settings: &ClearSettings,
    cache: &mut Cache,
) -> Clearance {
    let origin = motions[0].start();
    let motions = motions.map(|motion| motion.relative_to(origin));
    let tolerance = settings.motion.tolerance;
    judge(settings, motions, |goal| search_pair((a, b), motions, &DIRECTIONS, tolerance, goal, [0.0, 1.0], cache))
}

/// The answer by a search of the first meeting, which is made once or twice.
pub(crate) fn judge(
    settings: &ClearSettings,
    motions: [RigidMotion; 2],
    mut search: impl FnMut(&mut Goal) -> TimeOfImpact,
) -> Clearance {
    let mut goal = settings.motion.goal(motions);
    let TimeOfImpact { hit, status, t_lower, t_upper, iterations, support_calls, parts, .. } = search(&mut goal);
    let nearest = goal.nearest;
    let answer = Clearance { status, nearest, t_lower, t_upper, iterations, support_calls, ..Clearance::default() };
    if hit {
        let is_met = t_upper < f64::INFINITY;
        let (verdict, parts) = if is_met { (Verdict::Hit, parts) } else { (Verdict::Open, [0; 2]) };
        return Clearance { verdict, parts, ..answer };
    }
    let clearance = goal.clearance;
    let mut answer = Clearance { verdict: Verdict::Free, status: Status::Within, clearance, ..answer };
    if let Some(mut better) = goal.better(settings.share) {
        let again = if better.budget > 0 { search(&mut better) } else { TimeOfImpact::default() };
        answer.iterations += again.iterations;
        answer.support_calls += again.support_calls;
        answer.nearest = better.nearest;
        if again.status == Status::Separated {
            answer.clearance = answer.clearance.max(better.clearance);
        } else {
            answer.status = again.status;
        }
    }
    answer
}
