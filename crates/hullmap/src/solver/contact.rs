//! Contact of two shapes: penetration depth as an interval, normal and contact points.
//!
//! # Reference
//! Kenwright, Algorithm 1 and Listing 2.
//!
//! # Steps
//! 1. balls around the shapes, and the axis that separated them last time: apart;
//! 2. the polytope of last time under the new pose, if it still winds around the origin: go on with step 4 from it;
//!    otherwise phase one: find a portal (Algorithm 1 lines 1 to 5);
//! 3. phase two: refine it to the surface (lines 6 to 9);
//! 4. expansion from the centre and the portal, until the depth is the least one;
//! 5. contact points from barycentric coordinates (line 10).
//!
//! # Deviations
//! - Step 4. The paper's depth is along the normal of the portal that the centre ray meets: too large by up to 3.8 times. It is
//!   what comes out when no expansions are allowed (`max_iterations` 0), as an upper bound.
//! - Otherwise phase two stops at the first portal with the origin behind it. A portal refined to the surface is a poor
//!   start for the expansion: it took 3 to 20 support calls more, at 8 to 8,192 points.
//! - A depth of zero has a normal and a status of its own.

use super::discovery::{Discovery, Portal, discover};
use super::expansion::{self, Bound, Expansion, Goal, expand, expand_again};
use super::intersection::{keep_miss, separated_early, tetrahedron};
use super::refinement::{Side, Until, refine};
use crate::minkowski::{Minkowski, unit};
use crate::{Cache, Pose, Settings, Status, SupportMap};
use glam::DVec3;

/// Answer of [`contact`](contact()). Lengths are in the shapes' units, points and directions in A's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// False only when a separating plane proves the shapes apart.
    pub hit: bool,
    /// How the interval came to be.
    pub status: Status,
    /// Moving B by this much along `normal` separates the shapes (they then touch). 0 when apart or touching.
    pub depth: f64,
    /// The least such motion in any direction is no less than this, rounding included.
    pub depth_lower: f64,
    /// The least such motion in any direction is no more than this, rounding included.
    pub depth_upper: f64,
    /// Of unit length, from A to B. When the shapes are apart, a separating axis.
    pub normal: DVec3,
    /// The point of A deepest in B. When the shapes are apart, some point of A: ask [`distance`](crate::distance) for the nearest.
    pub point_a: DVec3,
    /// The point of B deepest in A. When the shapes are apart, some point of B.
    pub point_b: DVec3,
    /// Steps of all phases together.
    pub iterations: u32,
    /// Pairs of support queries made.
    pub support_calls: u32,
}

/// Contact of `a` and of `b` placed at `b_in_a`: the shortest way to push B out of A.
///
/// `cache` belongs to this ordered pair; it is read and brought up to date.
///
/// # Complexity
/// 1 to 4 support calls for most pairs apart, 10 to 40 for most that overlap; capped by `settings`. No allocation.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use hullmap::{Cache, Pose, Settings, Support, SupportMap, contact};
///
/// /// A box about the origin of its frame, by its half edges.
/// struct Crate(DVec3);
///
/// impl SupportMap for Crate {
///     fn support(&self, dir: DVec3) -> Support {
///         Support { point: self.0.copysign(dir), feature: 0 }
///     }
///     fn interior_point(&self) -> DVec3 {
///         DVec3::ZERO
///     }
///     fn inner_radius(&self) -> f64 {
///         self.0.min_element()
///     }
///     fn outer_radius(&self) -> f64 {
///         self.0.length()
///     }
/// }
///
/// let (a, b) = (Crate(DVec3::ONE), Crate(DVec3::splat(0.5)));
/// let b_in_a = Pose::from_translation(DVec3::new(0.2, 1.25, 0.1))?;
/// let c = contact(&a, &b, b_in_a, &Settings::default(), &mut Cache::new());
/// assert!(c.hit && (c.depth - 0.25).abs() < 1e-12);
/// assert!(c.normal.distance(DVec3::Y) < 1e-12);
/// # Ok::<(), hullmap::PoseError>(())
/// ```
///
/// # Reference
/// Kenwright, Algorithm 1 and Listing 2.
pub fn contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    let mut m = Minkowski::new(a, b, b_in_a);
    let mut out = search(&mut m, settings, cache);
    out.support_calls = m.support_calls();
    out
}

fn search<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    let tolerance = settings.relative_gap();
    if let Some(axis) = separated_early(m, cache) {
        return apart(m, cache, axis, 0);
    }
    if let Some(found) = contact_of_balls(m, tolerance) {
        cache.forget_axis();
        return found;
    }
    if settings.max_iterations > 0
        && let Some(expanded) = expand_again(m, Goal::Depth { tolerance }, settings.max_iterations, cache)
    {
        return contact_of(m, cache, &expanded, tolerance, expanded.iterations);
    }
    let mut portal = Portal::NONE;
    let (found, mut iterations) = discover(m, &mut portal);
    let mut bound = Bound::none();
    let mut start = None;
    match found {
        Discovery::Separated { axis } => {
            keep_miss(cache, axis, &portal.vertices);
            return apart(m, cache, axis, iterations);
        }
        Discovery::Portal => {
            let until = if settings.max_iterations == 0 { Until::Surface { tolerance } } else { Until::Decided };
            let refined = refine(m, &mut portal, until, &mut bound);
            iterations += refined.iterations;
            if refined.side == Side::Separated {
                keep_miss(cache, refined.axis, &portal.vertices);
                return apart(m, cache, refined.axis, iterations);
            }
            start = Some(tetrahedron(m, &portal));
        }
        Discovery::Flat | Discovery::Limit => {}
    }
    let expanded = expand(m, start, Goal::Depth { tolerance }, bound, settings.max_iterations, Some(cache));
    iterations += expanded.iterations;
    contact_of(m, cache, &expanded, tolerance, iterations)
}

/// What the expansion says.
fn contact_of<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    cache: &mut Cache,
    expanded: &Expansion,
    tolerance: f64,
    iterations: u32,
) -> Contact {
    let Bound { upper, normal, point_a, point_b } = expanded.bound;
    if expanded.end == expansion::End::Separated {
        return apart(m, cache, normal, iterations);
    }
    cache.forget_axis();
    let rounding = m.rounding();
    let depth_lower = (expanded.lower - m.noise()).max(0.0);
    // A face may be proved nearest before anybody looks whether it is at zero.
    let touching = match expanded.end {
        expansion::End::Touching => upper <= expansion::FLAT_ROUNDINGS * rounding,
        // A flat difference's own plane may hold the origin beside it.
        expansion::End::Stalled => false,
        _ => upper <= expansion::TOUCHING_ROUNDINGS * rounding,
    };
    let status = match expanded.end {
        // What is certainly deep, by however little, does not only touch.
        _ if touching && depth_lower == 0.0 => Status::Touching,
        _ if touching => Status::Exact,
        expansion::End::Limit => Status::IterationLimit,
        expansion::End::Stalled | expansion::End::Separated => Status::Stalled,
        _ if upper - expanded.lower <= rounding => Status::Exact,
        _ if upper - expanded.lower <= tolerance * upper + 2.0 * rounding => Status::Within,
        // A face that is on the surface, of a polytope that is too thin to be certain to enclose the origin.
        expansion::End::Converged | expansion::End::Inside | expansion::End::Touching => Status::Stalled,
    };
    Contact {
        hit: true,
        status,
        depth: if status == Status::Touching { 0.0 } else { upper.max(depth_lower) },
        depth_lower,
        depth_upper: upper.max(0.0) + rounding,
        normal: unit(normal).unwrap_or(DVec3::X),
        point_a,
        point_b,
        iterations,
        support_calls: 0,
    }
}

/// No contact: `axis` separates.
pub(super) fn apart<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    cache: &mut Cache,
    axis: DVec3,
    iterations: u32,
) -> Contact {
    let axis = unit(axis).unwrap_or(DVec3::X);
    cache.set_axis(axis);
    let center = m.center_point();
    Contact {
        hit: false,
        status: Status::Separated,
        depth: 0.0,
        depth_lower: 0.0,
        depth_upper: 0.0,
        normal: axis,
        point_a: center.a,
        point_b: center.b(),
        iterations,
        support_calls: 0,
    }
}

/// Contact of shapes that are balls, within the tolerance: the centres' line says it all, in one support call.
fn contact_of_balls<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    tolerance: f64,
) -> Option<Contact> {
    let rounding = m.rounding();
    let lower = m.inner_radius() - m.center_point().w.length();
    // NaN takes the failing branch.
    if !(lower > rounding && m.outer_radius() - m.inner_radius() <= tolerance * lower + rounding) {
        return None;
    }
    let normal = unit(-m.center_point().w).unwrap_or(DVec3::X);
    let vertex = m.point(normal);
    let upper = vertex.w.dot(normal);
    (upper - lower <= tolerance * upper + rounding).then_some(Contact {
        hit: true,
        status: if upper - lower <= rounding { Status::Exact } else { Status::Within },
        depth: upper,
        depth_lower: lower - rounding,
        depth_upper: upper + rounding,
        normal,
        point_a: vertex.a,
        point_b: vertex.b(),
        iterations: 1,
        support_calls: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::Cuboid;

    #[test]
    fn certainly_deep_by_a_hair_is_not_touching() {
        let (a, b) = (Cuboid::new(DVec3::ONE).unwrap(), Cuboid::new(DVec3::ONE).unwrap());
        let m = Minkowski::new(&a, &b, Pose::from_translation(DVec3::X).unwrap());
        let found = |lower, upper| {
            let bound = Bound { upper, normal: DVec3::X, ..Bound::none() };
            let expanded = Expansion { end: expansion::End::Touching, lower, bound, iterations: 1 };
            contact_of(&m, &mut Cache::new(), &expanded, 0.0, 1)
        };
        let deep = found(1.25 * m.noise(), 1.5 * m.noise());
        assert_eq!(deep.status, Status::Exact);
        assert!(0.0 < deep.depth_lower && deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper);
        let unknown = found(0.75 * m.noise(), 1.5 * m.noise());
        assert_eq!((unknown.status, unknown.depth, unknown.depth_lower), (Status::Touching, 0.0, 0.0));
    }
}
