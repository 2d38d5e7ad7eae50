//! Signed distance of a point from the union of a compound's parts: the minimum over all parts.
//!
//! # Steps
//! 1. Start with the part that decided the last query.
//! 2. Visit the parts whose boxes are no farther away than the minimum so far, nearest first. A
//!    point that is inside a part visits all parts whose boxes contain it, since it may be deeper
//!    in another one.
//!
//! # Deviations
//! Outside of all parts, the minimum is the distance from the union. Inside, the nearest point of
//! the union's surface is not computed: the ball around the point that fits into one part also fits
//! into the union, but a greater one may.
//!
//! # Reference
//! Branch and bound, as for [`distance`](super::distance()). The minimum as the signed distance of
//! a union: Hart, "Sphere tracing", 1996, section 2.

use glam::DVec3;

use super::bvh::{Nodes, Placement};
use super::parts::Parts;
use super::traversal::Traversal;
use crate::pose::Pose;
use crate::solver::motion::{VectorError, checked};
use crate::solver::signed_distance::signed_distance as of_part;
use crate::solver::{Cache, Settings, SignedDistance, Status};

/// Signed distance of `point` from the parts of `a`: the minimum over all of them.
///
/// # Complexity
/// Branch and bound: usually one query of a part for a point outside, and one for each part whose
/// box contains a point inside.
pub(crate) fn signed_distance<A: Parts + ?Sized>(
    a: &A,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Result<SignedDistance, VectorError> {
    let point = checked("point", point)?;
    let mut nearest = Nearest::default();
    let query = |nearest: &mut Nearest, part: usize, cache: &mut Cache| {
        if let Some(shape) = a.part(part) {
            nearest.add(&of_part(&shape, point, settings, cache.pair([part, 0]))?, part);
        }
        Ok(())
    };
    let first = cache.first([a.part_count(), 1]).map_or(0, |pair| pair[0]);
    query(&mut nearest, first, cache)?;
    let at_point = Nodes::one(DVec3::ZERO, DVec3::ZERO);
    let mut traversal = Traversal::new(Placement::new(a.nodes(), at_point, Pose::from_checked(point)));
    // Boxes that contain the point have a lower bound of 0.
    while let Some([part, _]) = traversal.next(nearest.upper.max(0.0)) {
        if part != first {
            query(&mut nearest, part, cache)?;
        }
    }
    let (answer, part) = nearest.answer(settings);
    cache.set_first([part, 0]);
    Ok(SignedDistance { part: part as u32, ..answer })
}

/// The minimum over the parts so far.
struct Nearest {
    best: Option<(SignedDistance, usize)>,
    /// Minimum lower bound, and the status of that part.
    lower: (f64, Status),
    /// Minimum upper bound.
    upper: f64,
    iterations: u32,
    support_calls: u32,
}

impl Default for Nearest {
    fn default() -> Self {
        Self {
            best: None,
            lower: (f64::INFINITY, Status::Exact),
            upper: f64::INFINITY,
            iterations: 0,
            support_calls: 0,
        }
    }
}

impl Nearest {
    fn add(&mut self, found: &SignedDistance, part: usize) {
        self.iterations = self.iterations.saturating_add(found.iterations);
        self.support_calls = self.support_calls.saturating_add(found.support_calls);
        // Ties go to the lowest index, so that the answer does not depend on the order of visits.
        if self
            .best
            .is_none_or(|(best, of)| found.distance < best.distance || found.distance == best.distance && part < of)
        {
            self.best = Some((*found, part));
        }
        if found.lower < self.lower.0 {
            self.lower = (found.lower, found.status);
        }
        self.upper = self.upper.min(found.upper);
    }

    fn answer(&self, settings: &Settings) -> (SignedDistance, usize) {
        // Only an unchecked pack can lack hulls.
        let (mut answer, part) = self.best.unwrap_or_default();
        (answer.iterations, answer.support_calls) = (self.iterations, self.support_calls);
        answer.upper = answer.upper.min(self.upper);
        if self.lower.0 < answer.lower {
            answer.lower = self.lower.0;
            // NaN takes the failing branch.
            if !(answer.upper - answer.lower <= settings.relative_tolerance() * answer.distance.abs()) {
                answer.status = self.lower.1;
            }
        }
        (answer, part)
    }
}
