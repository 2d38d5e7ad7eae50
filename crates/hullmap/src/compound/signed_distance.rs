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
use super::{CompoundAnswer, CompoundCache};
use crate::pose::Pose;
use crate::solver::motion::{VectorError, checked};
use crate::solver::signed_distance::signed_distance as of_part;
use crate::solver::{Settings, SignedDistance, Status};

/// Answer for a pack without hulls, which only an unchecked pack can lack: nothing is known.
const NOTHING_KNOWN: SignedDistance = SignedDistance {
    status: Status::Stalled,
    distance: 0.0,
    lower: f64::NEG_INFINITY,
    upper: f64::INFINITY,
    point: DVec3::ZERO,
    normal: DVec3::X,
    iterations: 0,
    support_calls: 0,
};

/// Signed distance of `point` from the compound `a`: the minimum of its
/// [signed distances](crate::signed_distance()) from all parts.
///
/// Positive outside: then it is the distance from the union, and `point` of the answer is the
/// closest point of the union. Negative inside: then it is the depth in the part in which the point
/// is deepest, so a ball of radius `-distance` around the point is inside the union. Where parts
/// overlap or touch, the surface of the union may be farther away, and `point` of the answer, on
/// the surface of its part, may be inside another one.
///
/// The interval contains this minimum. A positive lower bound proves that the point is outside of
/// the union, a negative upper bound that it is inside. The status comes from the deciding part,
/// unless another part's interval makes the whole wider than the settings allow. Then it is the
/// status of that other part. `hulls` has the index of the part first.
///
/// Lengths are in the compound's unit, points and directions in its frame. `cache` belongs to the
/// compound and to points near this one; the query reads and updates it.
///
/// # Errors
/// A component of `point` is NaN, infinite, or beyond
/// [`MAX_TRANSLATION`](crate::pose::MAX_TRANSLATION).
///
/// # Complexity
/// Branch and bound: usually one query of a part for a point outside, and one for each part whose
/// box contains a point inside. At most one for each part. No allocation.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Compound, CompoundCache, Settings, compound};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4.
/// let (cubes, settings) = (Compound::new(&pack), Settings::default());
/// let mut cache = CompoundCache::default();
/// let mut at = |x: f64| compound::signed_distance(&cubes, DVec3::new(x, 0.5, 0.5), &settings, &mut cache);
/// let between = at(2.25)?;
/// assert!((between.answer.distance - 0.75).abs() < 1e-12);
/// assert!(between.answer.point.distance(DVec3::new(3.0, 0.5, 0.5)) < 1e-12);
/// assert_eq!(between.hulls, [1, 0]);
/// assert!((at(0.25)?.answer.distance + 0.25).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
pub fn signed_distance<A: Parts + ?Sized>(
    a: &A,
    point: DVec3,
    settings: &Settings,
    cache: &mut CompoundCache,
) -> Result<CompoundAnswer<SignedDistance>, VectorError> {
    let point = checked("point", point)?;
    let mut nearest = Nearest::default();
    let query = |nearest: &mut Nearest, part: usize, cache: &mut CompoundCache| {
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
    Ok(CompoundAnswer { answer, hulls: [part, 0], pairs: nearest.queried, boxes: traversal.boxes() })
}

/// The minimum over the parts so far.
struct Nearest {
    best: Option<(SignedDistance, usize)>,
    /// Minimum lower bound, and the status of that part.
    lower: (f64, Status),
    /// Minimum upper bound.
    upper: f64,
    queried: u32,
    iterations: u32,
    support_calls: u32,
}

impl Default for Nearest {
    fn default() -> Self {
        Self {
            best: None,
            lower: (f64::INFINITY, Status::Exact),
            upper: f64::INFINITY,
            queried: 0,
            iterations: 0,
            support_calls: 0,
        }
    }
}

impl Nearest {
    fn add(&mut self, found: &SignedDistance, part: usize) {
        self.queried += 1;
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
        let (mut answer, part) = self.best.unwrap_or((NOTHING_KNOWN, 0));
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
