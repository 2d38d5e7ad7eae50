//! Contact of two shapes: penetration depth as an interval, normal and witness points.
//!
//! # Reference
//! Kenwright, Algorithm 1 and Listing 2.
//!
//! # Steps
//! 1. Balls around the shapes, and the last separating axis: the pair may be separated at once. If
//!    the shapes are balls within the tolerance, the line of centres is the answer.
//! 2. The separating axis test (SAT), for close, small hulls.
//! 3. The last polytope under the new pose: if it still winds around the origin, continue with step
//!    6.
//! 4. Portal discovery (Algorithm 1, lines 1 to 5).
//! 5. Portal refinement towards the surface (lines 6 to 9).
//! 6. EPA from the centre and the portal to the minimum depth.
//! 7. Witness points from barycentric coordinates (line 10).
//!
//! docs/decisions/0010-solver.md has a drawing of them, and what each step is worth.
//!
//! # Deviations
//! - Step 6. The paper takes the depth along the normal of the portal that the centre ray pierces,
//!   which is up to 3.8 times too large. With `max_iterations` 0 it is returned as an upper bound.
//! - Otherwise portal refinement stops at the first portal with the origin behind it. A portal
//!   refined to the surface is a poor start for EPA.
//! - A depth of zero has a normal, and a status of its own.

use super::answer::{Contact, separated_contact};
use super::bound::{Bound, FOOT_ROUNDINGS};
use super::cache::Cache;
use super::epa::{self, Expansion};
use super::minkowski::{Minkowski, Point, Step};
use super::mpr::{self, Found, Until};
use super::sat;
use super::scratch::Workspace;
use super::settings::Settings;
use super::status::Status;
use super::steps::{SteppedQuery, at_once};
use crate::pose::Pose;
use crate::support::SupportMap;
use crate::vector::unit;
use glam::DVec3;

/// Contact of `a` and `b` without regard to convex radii.
///
/// See [`contact`](crate::contact()) for frames, units and cost.
pub(super) fn core_contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    at_once::<A, B, ContactQuery>(&mut Minkowski::new(a, b, b_in_a), settings, cache)
}

/// Contact by the separating axis test alone, whether it pays or not; `None` if it does not decide,
/// or if a shape has no facets. For tests and benchmarks.
///
/// # Complexity
/// O(faces × vertices) in f32, 8 lanes at a time, and a few support queries. No allocation.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Pose, Settings, shapes::Cuboid, solver::contact_by_facets};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let b_in_a = Pose::from_translation(DVec3::X * 1.5)?;
/// let found = contact_by_facets(&cube, &cube, b_in_a, &Settings::default()).ok_or("undecided")?;
/// assert!((found.depth - 0.5).abs() < 1e-12 && found.normal == DVec3::X);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(hidden)]
pub fn contact_by_facets<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
) -> Option<Contact> {
    let mut m = Minkowski::new(a, b, b_in_a);
    let mut out = sat::contact(&mut m, [a.facets()?, b.facets()?], settings.relative_tolerance(), &mut Cache::new())?;
    out.support_calls = m.support_calls();
    Some(out)
}

/// A contact query in steps. It waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ContactQuery {
    /// Along this separating axis of the cache.
    Axis(DVec3),
    /// For MPR.
    Portal(mpr::MprSearch),
    /// For EPA, after this number of steps of MPR.
    Expansion(epa::EpaSearch, u32),
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> SteppedQuery<A, B> for ContactQuery {
    type Settings = Settings;
    type Answer = Contact;
    type Workspace = Workspace;

    fn new() -> Self {
        Self::Axis(DVec3::ZERO)
    }

    #[inline(always)]
    fn advance(
        &mut self,
        point: Option<Point>,
        m: &mut Minkowski<'_, A, B>,
        settings: &Settings,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Step<Contact> {
        let Some(point) = point else {
            // Step 1, up to the last separating axis.
            if let Some(axis) = m.axis_of_balls() {
                return Step::Answer(separated_contact(m, cache, axis, 0));
            }
            if let Some(axis) = cache.axis() {
                *self = Self::Axis(axis);
                return Step::Ask(axis);
            }
            return self.after_axis(m, settings, cache, workspace);
        };
        match self {
            Self::Axis(axis) if m.separates(*axis, &point) => Step::Answer(separated_contact(m, cache, *axis, 0)),
            Self::Axis(_) => self.after_axis(m, settings, cache, workspace),
            Self::Portal(search) => match search.continue_with(point) {
                None => Step::Ask(search.direction()),
                Some(found) => self.after_portal(found, m, settings, cache, workspace),
            },
            Self::Expansion(..) => self.expand(Some(point), m, settings, cache, workspace),
        }
    }
}

impl ContactQuery {
    /// The rest of step 1, and steps 2 and 3: the axis of the cache does not separate the shapes.
    #[inline(always)]
    fn after_axis<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        settings: &Settings,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Step<Contact> {
        let tolerance = settings.relative_tolerance();
        if let Some(found) = contact_of_balls(m, tolerance) {
            cache.forget_axis();
            return Step::Answer(found);
        }
        if settings.max_iterations == 0 {
            return self.start_portal(m, Until::Surface { tolerance });
        }
        if let Some(facets) = m.facets()
            && sat::pays(m, &facets, cache)
            && let Some(found) = sat::contact(m, facets, tolerance, cache)
        {
            return Step::Answer(Contact { support_calls: m.support_calls(), ..found });
        }
        let terms = epa::Terms::new(m, Some(tolerance), settings.max_iterations);
        match epa::EpaSearch::start_again(m, terms, cache, workspace) {
            Some(search) => {
                *self = Self::Expansion(search, 0);
                self.expand(None, m, settings, cache, workspace)
            }
            None => self.start_portal(m, Until::Decided),
        }
    }

    /// Steps 4 and 5, up to the first support query.
    #[inline(always)]
    fn start_portal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &Minkowski<'_, A, B>,
        until: Until,
    ) -> Step<Contact> {
        let search = mpr::MprSearch::new(m, until);
        let dir = search.direction();
        *self = Self::Portal(search);
        Step::Ask(dir)
    }

    /// Step 6, from what MPR has found.
    #[inline(always)]
    fn after_portal<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        found: Found,
        m: &mut Minkowski<'_, A, B>,
        settings: &Settings,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Step<Contact> {
        let Self::Portal(search) = self else { return Step::Answer(Contact::default()) };
        let (portal, bound, iterations) = (search.portal(), search.bound(), search.iterations());
        let start = match found {
            Found::Separated { axis } => {
                cache.set_separation(axis, &portal.vertices);
                return Step::Answer(separated_contact(m, cache, axis, iterations));
            }
            Found::Portal { .. } => Some(portal.tetrahedron(m)),
            Found::Nothing => None,
        };
        let terms = epa::Terms::new(m, Some(settings.relative_tolerance()), settings.max_iterations);
        match epa::EpaSearch::start(m, start, terms, bound, cache, workspace) {
            Ok(search) => {
                *self = Self::Expansion(search, iterations);
                self.expand(None, m, settings, cache, workspace)
            }
            Err(flat) => Step::Answer(contact_from_expansion(m, cache, &flat, settings, iterations)),
        }
    }

    /// Steps 6 and 7, from the start of EPA, or with the next support point.
    #[inline(always)]
    fn expand<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        point: Option<Point>,
        m: &mut Minkowski<'_, A, B>,
        settings: &Settings,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Step<Contact> {
        let Self::Expansion(search, before) = self else { return Step::Answer(Contact::default()) };
        match search.advance(point, m, cache, workspace) {
            Step::Ask(dir) => Step::Ask(dir),
            Step::Answer(Some(expanded)) => {
                let iterations = *before + expanded.iterations;
                Step::Answer(contact_from_expansion(m, cache, &expanded, settings, iterations))
            }
            // The polytope of the cache is of no use.
            Step::Answer(None) => self.start_portal(m, Until::Decided),
        }
    }
}

/// The contact that follows from the outcome of EPA.
fn contact_from_expansion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    cache: &mut Cache,
    expanded: &Expansion,
    settings: &Settings,
    iterations: u32,
) -> Contact {
    let tolerance = settings.relative_tolerance();
    let Bound { upper, normal, point_a, point_b } = expanded.bound;
    if expanded.end == epa::End::Separated {
        return separated_contact(m, cache, normal, iterations);
    }
    cache.forget_axis();
    let rounding = m.rounding_error();
    let depth_lower = (expanded.lower - m.noise()).max(0.0);
    // The expansion may prove a face to be the nearest before it tests whether its offset is zero.
    let touching = match expanded.end {
        epa::End::Touching => upper <= epa::FLAT_ROUNDINGS * rounding,
        // The origin may lie in the plane of a flat difference, but outside the difference.
        epa::End::Stalled => false,
        _ => upper <= epa::TOUCHING_ROUNDINGS * rounding,
    };
    let off = expanded.bound.off();
    // Shapes that only touch need not have opposite witness points.
    let roundings = if touching && depth_lower == 0.0 { epa::BESIDE_ROUNDINGS } else { FOOT_ROUNDINGS };
    // The interval is as wide as the witness points are off. NaN takes the failing branch.
    let width = upper - expanded.lower.max(0.0);
    let is_settled = off <= width.max(0.0) + roundings * rounding;
    let width = if is_settled { upper - expanded.lower } else { off.max(upper - expanded.lower) };
    let status = match expanded.end {
        epa::End::Limit if !touching => Status::IterationLimit,
        // A pair with a positive lower bound penetrates, however little.
        _ if touching && is_settled && depth_lower == 0.0 => Status::Touching,
        _ if touching && is_settled => Status::Exact,
        epa::End::Stalled | epa::End::Separated => Status::Stalled,
        _ if width <= rounding => Status::Exact,
        _ if width <= tolerance * upper + 2.0 * rounding => Status::Within,
        // The face is on the surface, but the polytope is too thin to enclose the origin for
        // certain, or the witness points are not opposite each other.
        _ => Status::Stalled,
    };
    let depth_lower = if status == Status::Within { depth_lower.min(upper - width).max(0.0) } else { depth_lower };
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
        support_calls: m.support_calls(),
        features: expanded.features,
        ..Contact::default()
    }
    .with_others(expanded.others - m.noise(), m.outer_radius())
}

/// Contact of shapes that are balls within the tolerance. The line of centres gives it, with one
/// support call.
fn contact_of_balls<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    tolerance: f64,
) -> Option<Contact> {
    let rounding = m.rounding_error();
    let lower = m.inner_radius() - m.center_point().w.length();
    // NaN takes the failing branch.
    if !(lower > rounding && m.outer_radius() - m.inner_radius() <= tolerance * lower + rounding) {
        return None;
    }
    let normal = unit(-m.center_point().w).unwrap_or(DVec3::X);
    let vertex = m.point(normal);
    let upper = vertex.w.dot(normal);
    // The support point of a hull that is nearly a ball may be beside the line of centres.
    let is_settled = vertex.w.distance(normal * upper) <= upper - lower + FOOT_ROUNDINGS * rounding;
    (is_settled && upper - lower <= tolerance * upper + rounding).then_some(Contact {
        hit: true,
        status: if upper - lower <= rounding { Status::Exact } else { Status::Within },
        depth: upper,
        depth_lower: lower - rounding,
        depth_upper: upper + rounding,
        normal,
        point_a: vertex.a,
        point_b: vertex.b(),
        iterations: 1,
        support_calls: m.support_calls(),
        features: vertex.features,
        ..Contact::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::Cuboid;

    #[test]
    fn positive_lower_bound_is_not_touching() {
        let (a, b) = (Cuboid::new(DVec3::ONE).unwrap(), Cuboid::new(DVec3::ONE).unwrap());
        let m = Minkowski::new(&a, &b, Pose::from_translation(DVec3::X).unwrap());
        let found = |lower, upper| {
            let bound = Bound { upper, normal: DVec3::X, ..Bound::none() };
            let (features, others) = (Point::CENTER, 0.0);
            let expanded = Expansion { end: epa::End::Touching, lower, bound, iterations: 1, features, others };
            let exact = Settings { tolerance: 0.0, ..Settings::default() };
            contact_from_expansion(&m, &mut Cache::new(), &expanded, &exact, 1)
        };
        let deep = found(1.25 * m.noise(), 1.5 * m.noise());
        assert_eq!(deep.status, Status::Exact);
        assert!(0.0 < deep.depth_lower && deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper);
        let unknown = found(0.75 * m.noise(), 1.5 * m.noise());
        assert_eq!((unknown.status, unknown.depth, unknown.depth_lower), (Status::Touching, 0.0, 0.0));
    }
}
