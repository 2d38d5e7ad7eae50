//! Yes or no: do two shapes share a point?
//!
//! # Reference
//! Kenwright, Algorithm 1 lines 1 to 9; section 4.1 for the order of the tests.
//!
//! # Steps
//! 1. balls around and inside the shapes: no support call;
//! 2. the axis that separated them last time: one; the portal that the origin was behind: none;
//! 3. phase one, then phase two until the answer is known;
//! 4. what these leave open (flat shapes, touching, caps) is settled by the expansion, which needs no portal.
//!
//! # Deviations
//! - The answer has four values; "touching" and "undecided" are not hidden in yes or no.

use super::discovery::{Discovery, Portal, discover, is_beyond};
use super::expansion::{self, Bound, Expansion, Goal, expand};
use super::refinement::{Side, Until, refine};
use crate::minkowski::{Minkowski, Point, unit};
use crate::{Cache, Overlap, Pose, SupportMap};
use glam::DVec3;

/// Most expansions for a yes or no. Only touching pairs come here, and a dozen is usual.
const MAX_DECIDING: u32 = 250;

/// Answer of [`intersects`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// Whether the shapes share a point.
    pub status: Overlap,
    /// Steps of all phases together.
    pub iterations: u32,
    /// Pairs of support queries made.
    pub support_calls: u32,
}

impl Intersection {
    /// True unless the shapes are proved apart: touching and undecided pairs count as hits, so that numerical trouble never
    /// reads as "no collision".
    pub fn is_hit(&self) -> bool {
        self.status != Overlap::Separated
    }
}

/// Whether `a` and `b`, placed at `b_in_a`, share a point.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date. After a miss it holds the axis, which the next
/// miss is mostly proved by, and the points seen: [`distance`](crate::distance) with the same cache goes on from them, in
/// this frame or the next, and is cheaper by what was found out here (Kenwright, section 4.6).
///
/// # Complexity
/// No support call when balls decide, 1 to 4 for most pairs apart, 3 to 7 for most that overlap; with the last query's
/// cache mostly one for pairs apart and none for those that overlap. Capped. No allocation.
///
/// # Reference
/// Kenwright, Algorithm 1.
pub fn intersects<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    cache: &mut Cache,
) -> Intersection {
    let mut m = Minkowski::new(a, b, b_in_a);
    let (status, iterations) = decide(&mut m, cache);
    Intersection { status, iterations, support_calls: m.support_calls() }
}

/// The tests that come before any search: an axis, of unit length from A to B, known to separate.
#[inline]
pub(super) fn separated_early<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &Cache,
) -> Option<DVec3> {
    if m.outer_balls_apart() {
        return unit(-m.center_point().w);
    }
    cache.axis().filter(|axis| m.point(*axis).w.dot(*axis) < -m.rounding())
}

fn decide<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    cache: &mut Cache,
) -> (Overlap, u32) {
    if m.inner_balls_overlap() {
        cache.forget_axis();
        return (Overlap::Overlapping, 0);
    }
    if let Some(axis) = separated_early(m, cache) {
        cache.set_axis(axis);
        return (Overlap::Separated, 0);
    }
    if cache.portal().is_some_and(|features| is_behind(m, features)) {
        cache.forget_axis();
        return (Overlap::Overlapping, 0);
    }
    let mut portal = Portal::NONE;
    let (found, mut iterations) = discover(m, &mut portal);
    let mut start = None;
    match found {
        Discovery::Separated { axis } => {
            keep_miss(cache, axis, &portal.vertices);
            return (Overlap::Separated, iterations);
        }
        Discovery::Portal => {
            let refined = refine(m, &mut portal, Until::Decided, &mut Bound::none());
            iterations += refined.iterations;
            match refined.side {
                Side::Separated => {
                    keep_miss(cache, refined.axis, &portal.vertices);
                    return (Overlap::Separated, iterations);
                }
                Side::Overlapping if is_proved(m, &portal) => {
                    cache.forget_axis();
                    cache.set_portal(&portal.vertices);
                    return (Overlap::Overlapping, iterations);
                }
                Side::Touching | Side::Undecided | Side::Overlapping => start = Some(tetrahedron(m, &portal)),
            }
        }
        Discovery::Flat | Discovery::Limit => {}
    }
    let (status, Bound { normal, .. }, steps) = decide_by_expansion(m, start);
    match status {
        Overlap::Separated => cache.set_axis(normal),
        _ => cache.forget_axis(),
    }
    (status, iterations + steps)
}

/// What a miss leaves for the next query: the axis, for another miss, and the points seen, for the search for the nearest points.
pub(super) fn keep_miss(cache: &mut Cache, axis: DVec3, seen: &[Point; 3]) {
    if let Some(axis) = unit(axis) {
        cache.set_axis(axis);
    }
    cache.set_simplex(seen.iter().map(|v| v.features));
}

/// Whether the origin is in the tetrahedron of the centre and of the portal that these features make. No support call.
fn is_behind<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &Minkowski<'_, A, B>, features: [[u32; 2]; 3]) -> bool {
    let [Some(v1), Some(v2), Some(v3)] = features.map(|features| m.recall(features)) else { return false };
    let portal = Portal { vertices: [v1, v2, v3] };
    portal.normal().is_some_and(|n| is_beyond(-n.dot(v1.w), n, m.rounding()))
        && portal.is_pierced(m.center_point().w)
        && is_proved(m, &portal)
}

/// Whether the origin, seen behind the portal, is truly inside and not on the surface.
fn is_proved<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(m: &Minkowski<'_, A, B>, portal: &Portal) -> bool {
    portal.holds_origin(m.center_point().w, m.inner_radius(), m.rounding())
}

/// The centre and the portal.
pub(super) fn tetrahedron<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    portal: &Portal,
) -> [Point; 4] {
    let [v1, v2, v3] = portal.vertices;
    [m.center_point(), v1, v2, v3]
}

/// The last word on whether the origin is inside, with an axis that separates if it is not, and the points where they touch if they do.
pub(super) fn decide_by_expansion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
) -> (Overlap, Bound, u32) {
    let Expansion { end, bound, iterations, .. } = expand(m, start, Goal::Decide, Bound::none(), MAX_DECIDING, None);
    let status = match end {
        expansion::End::Separated => Overlap::Separated,
        expansion::End::Inside => Overlap::Overlapping,
        // A face on the surface may be well away from the origin, of a polytope too thin to be certain to hold it.
        expansion::End::Touching | expansion::End::Converged
            if bound.upper <= expansion::FLAT_ROUNDINGS * m.rounding() =>
        {
            Overlap::Touching
        }
        _ => Overlap::Undecided,
    };
    (status, bound, iterations)
}
