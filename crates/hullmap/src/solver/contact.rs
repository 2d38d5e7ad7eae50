//! Contact of two shapes: penetration depth as an interval, normal and witness points.
//!
//! # Reference
//! Kenwright, Algorithm 1 and Listing 2.
//!
//! # Steps
//! 1. Balls around the shapes, and the last separating axis: the pair may be separated at once. If
//!    the shapes are balls within the tolerance, the line of centres is the answer. If one support
//!    query proves the face of the last contact again, the contact is on it.
//! 2. The separating axis test (SAT), for close, small hulls.
//! 3. The last polytope under the new pose: if it still winds around the origin, continue with step
//!    6.
//! 4. Portal discovery (Algorithm 1, lines 1 to 5).
//! 5. Portal refinement towards the surface (lines 6 to 9).
//! 6. EPA from the centre and the portal to the minimum depth.
//! 7. Witness points from barycentric coordinates (line 10).
//!
//! docs/contributors/decisions/0010-solver.md has a drawing of them, and what each step is worth.
//!
//! # Deviations
//! - Step 6. The paper takes the depth along the normal of the portal that the centre ray pierces,
//!   which is up to 3.8 times too large. With `max_iterations` 0 it is returned as an upper bound.
//! - Otherwise portal refinement stops at the first portal with the origin behind it. A portal
//!   refined to the surface is a poor start for EPA.
//! - A depth of zero has a normal, and a status of its own.

use super::answer::Contact;
use super::bound::{Bound, FOOT_ROUNDINGS};
use super::cache::Cache;
use super::epa::{self, EpaSearch, Expansion};
use super::kept_face::{self, depth_on_kept_face};
use super::minkowski::{Minkowski, Point, Step};
use super::mpr::{Found, MprSearch, Until};
use super::sat;
use super::scratch::{self, Workspace};
use super::settings::Settings;
use super::status::Status;
use super::steps::{Solver, SteppedQuery, at_once};
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
    at_once::<A, B, ContactQuery>((a, b, b_in_a), settings, cache)
}

/// The contact of shapes that the balls around them or the last axis separate, and a lower bound of
/// their distance: what [`core_contact`] answers first. `None` for rounded shapes, and if it takes
/// a search.
pub(crate) fn known_separation<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    cache: &mut Cache,
) -> Option<(Contact, f64)> {
    if a.convex_radius() + b.convex_radius() > 0.0 {
        return None;
    }
    let mut m = Minkowski::new(a, b, b_in_a);
    match ContactQuery::glance(&m, cache)? {
        Step::Answer(found) => Some((found, m.center_point().w.length() - m.outer_radius())),
        Step::Ask(axis) => {
            let point = m.point(axis);
            let found = ContactQuery::separated(&m, cache, axis, &point)?;
            Some((found, -point.w.dot(axis)))
        }
    }
}

/// Contact by the separating axis test alone, whether it pays or not; `None` if it does not decide,
/// or if a shape has no facets. For tests and benchmarks.
///
/// # Complexity
/// O(faces × vertices) in f32, 8 lanes at a time, and a few support queries. No allocation.
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

/// A contact query in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactQuery {
    tolerance: f64,
    max_iterations: u32,
    search: ContactSearch,
}

/// The search that waits for a support point.
#[derive(Clone, Copy, Debug)]
enum ContactSearch {
    Portal(MprSearch),
    /// EPA, after this number of steps of MPR.
    Expansion(EpaSearch, u32),
}

impl SteppedQuery for ContactQuery {
    type Settings = Settings;
    type Answer = Contact;
    type Workspace = Workspace;

    #[inline(always)]
    fn with_workspace<R>(search: impl FnOnce(&mut Workspace) -> R) -> R {
        scratch::with_workspace(search)
    }

    /// Step 1.
    #[inline(always)]
    fn glance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
    ) -> Option<Step<Contact>> {
        match m.axis_of_balls() {
            Some(axis) => Some(Step::Answer(m.separated_contact(cache, axis, 0))),
            None => cache.axis().map(Step::Ask),
        }
    }

    #[inline(always)]
    fn separated<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        cache: &mut Cache,
        axis: DVec3,
        point: &Point,
    ) -> Option<Contact> {
        m.separates(axis, point).then(|| m.separated_contact(cache, axis, 0))
    }

    /// The rest of step 1, and step 2.
    #[inline(always)]
    fn shortcut<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &mut Minkowski<'_, A, B>,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Option<Contact> {
        let tolerance = settings.relative_tolerance();
        if let Some(found) = contact_of_balls(m, tolerance) {
            cache.forget_axis();
            return Some(found);
        }
        if settings.max_iterations == 0 {
            return None;
        }
        if let Some(face) = cache.face()
            && let Some(found) = m.contact_on_kept_face(face, tolerance, cache)
        {
            return Some(found);
        }
        let facets = m.facets()?;
        let found =
            if sat::pays(m, &facets, cache) { sat::contact(m, facets, tolerance, cache)? } else { return None };
        Some(Contact { support_calls: m.support_calls(), ..found })
    }

    /// Step 3, and the start of step 4.
    #[inline(always)]
    fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, (), Workspace>,
        settings: &Settings,
    ) -> Result<(Self, DVec3), Contact> {
        let Solver { m, cache, workspace, .. } = solver;
        let (tolerance, max_iterations) = (settings.relative_tolerance(), settings.max_iterations);
        let until = if max_iterations == 0 { Until::Surface { tolerance } } else { Until::Decided };
        let search = MprSearch::new(m, until);
        let mut query = Self { tolerance, max_iterations, search: ContactSearch::Portal(search) };
        if max_iterations == 0 {
            return Ok((query, search.direction()));
        }
        let terms = epa::Terms::new(m, Some(tolerance), max_iterations);
        let mut solver = Solver { query: &mut query, m, cache, workspace };
        let Some(expansion) = solver.start_from_cache(terms) else { return Ok((query, search.direction())) };
        solver.query.search = ContactSearch::Expansion(expansion, 0);
        match solver.expand(None) {
            Step::Ask(dir) => Ok((query, dir)),
            Step::Answer(found) => Err(found),
        }
    }

    #[inline(always)]
    fn advance<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        solver: Solver<'_, '_, A, B, Self, Workspace>,
        point: Point,
    ) -> Step<Contact> {
        let ContactSearch::Portal(search) = &mut solver.query.search else { return solver.expand(Some(point)) };
        match search.continue_with(point) {
            None => Step::Ask(search.direction()),
            Some(found) => solver.after_portal(found),
        }
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Solver<'_, '_, A, B, ContactQuery, Workspace> {
    /// Steps 4 and 5, up to the first support query.
    #[inline(always)]
    fn start_portal(self, until: Until) -> Step<Contact> {
        let search = MprSearch::new(self.m, until);
        let dir = search.direction();
        self.query.search = ContactSearch::Portal(search);
        Step::Ask(dir)
    }

    /// Step 6, from what MPR has found.
    #[inline(always)]
    fn after_portal(mut self, found: Found) -> Step<Contact> {
        let ContactSearch::Portal(search) = &self.query.search else { return Step::Answer(Contact::default()) };
        let (portal, bound, iterations) = (search.portal(), search.bound(), search.iterations());
        let start = match found {
            Found::Separated { axis } => {
                self.cache.set_separation(axis, &portal.vertices);
                return Step::Answer(self.m.separated_contact(self.cache, axis, iterations));
            }
            Found::Portal { .. } => Some(portal.tetrahedron(self.m)),
            Found::Nothing => None,
        };
        let terms = epa::Terms::new(self.m, Some(self.query.tolerance), self.query.max_iterations);
        match self.start_expansion(start, terms, bound) {
            Ok(search) => {
                self.cache.forget_polytope();
                self.query.search = ContactSearch::Expansion(search, iterations);
                self.expand(None)
            }
            Err(flat) => {
                Step::Answer(self.m.contact_from_expansion(&flat, self.query.tolerance, iterations, self.cache))
            }
        }
    }

    /// Steps 6 and 7, from the start of EPA, or with the next support point.
    #[inline(always)]
    fn expand(self, point: Option<Point>) -> Step<Contact> {
        let ContactSearch::Expansion(search, before) = &mut self.query.search else {
            return Step::Answer(Contact::default());
        };
        let (before, solver) =
            (*before, Solver { query: search, m: self.m, cache: self.cache, workspace: self.workspace });
        match solver.advance(point) {
            Step::Ask(dir) => Step::Ask(dir),
            Step::Answer(Some(expanded)) => {
                let iterations = before + expanded.iterations;
                let tolerance = self.query.tolerance;
                Step::Answer(self.m.contact_from_expansion(&expanded, tolerance, iterations, self.cache))
            }
            // The cached polytope is unusable.
            Step::Answer(None) => self.start_portal(Until::Decided),
        }
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'_, A, B> {
    /// The contact on the face of the last one. Not inlined, since few of deep pairs have such a
    /// face.
    #[inline(never)]
    fn contact_on_kept_face(&mut self, face: [[u32; 2]; 3], tolerance: f64, cache: &mut Cache) -> Option<Contact> {
        let kept_face::Found { bound, lower, features, others } = depth_on_kept_face(self, face)?;
        let expanded = Expansion { end: epa::End::Converged, lower, bound, iterations: 1, features, others };
        Some(self.contact_from_expansion(&expanded, tolerance, 1, cache))
    }

    /// The contact that follows from the outcome of EPA.
    fn contact_from_expansion(
        &self,
        expanded: &Expansion,
        tolerance: f64,
        iterations: u32,
        cache: &mut Cache,
    ) -> Contact {
        let Bound { upper, normal, point_a, point_b } = expanded.bound;
        if expanded.end == epa::End::Separated {
            return self.separated_contact(cache, normal, iterations);
        }
        cache.forget_axis();
        let rounding = self.rounding_error();
        let depth_lower = (expanded.lower - self.noise()).max(0.0);
        // The expansion may prove a face to be the nearest before it tests whether its offset is
        // zero.
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
            support_calls: self.support_calls(),
            features: expanded.features,
            ..Contact::default()
        }
        .with_others(expanded.others - self.noise(), self.outer_radius())
    }
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
            m.contact_from_expansion(&expanded, 0.0, 1, &mut Cache::new())
        };
        let deep = found(1.25 * m.noise(), 1.5 * m.noise());
        assert_eq!(deep.status, Status::Exact);
        assert!(0.0 < deep.depth_lower && deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper);
        let unknown = found(0.75 * m.noise(), 1.5 * m.noise());
        assert_eq!((unknown.status, unknown.depth, unknown.depth_lower), (Status::Touching, 0.0, 0.0));
    }
}
