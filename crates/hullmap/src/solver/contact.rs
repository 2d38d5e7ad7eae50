//! Contact of two shapes: penetration depth as an interval, normal and witness points.
//!
//! It combines MPR (portal discovery and refinement) and EPA (the expanding polytope).
//!
//! # Reference
//! Kenwright, Algorithm 1 and Listing 2.
//!
//! # Steps
//! 1. Balls around the shapes and the last separating axis: the pair may be separated at once.
//! 2. The last polytope under the new pose: if it still winds around the origin, continue with step
//!    5.
//! 3. Portal discovery (Algorithm 1, lines 1 to 5).
//! 4. Portal refinement towards the surface (lines 6 to 9).
//! 5. EPA from the centre and the portal to the minimum depth.
//! 6. Witness points from barycentric coordinates (line 10).
//!
//! # Deviations
//! - Step 5. The paper takes the depth along the normal of the portal that the centre ray pierces,
//!   which is up to 3.8 times too large. With `max_iterations` 0 it is returned as an upper bound.
//! - Otherwise portal refinement stops at the first portal with the origin behind it. A portal
//!   refined to the surface is a poor start for EPA: it took 3 to 20 more support calls (8 to 8,192
//!   points).
//! - A depth of zero has a normal, and a status of its own.

use super::bound::Bound;
use super::cache::Cache;
use super::epa::{self, Expansion, Goal, Progress, Room, expand, expand_again};
use super::intersection::{Early, portal_tetrahedron, separated_early, store_separation};
use super::minkowski::{Interrupted, Minkowski};
use super::mpr::{self, Discovery, Found, Portal, discover_portal};
use super::mpr::{Side, Until, refine_portal};
use super::sat;
use super::settings::Settings;
use super::status::Status;
use super::suspended::Suspended;
use crate::pose::Pose;
use crate::support::{SupportMap, facets::Facets};
use crate::vector::unit;
use glam::DVec3;

/// Answer of [`contact`](crate::contact()): penetration depth, normal and witness points of a pair.
///
/// Lengths are in the shapes' unit, points and directions in A's frame. If rounding error or a
/// limit stopped the search, `status` says so; the interval from `depth_lower` to `depth_upper`
/// always contains the depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// False only if a separating plane proves the shapes separated.
    pub hit: bool,
    /// How the query ended, and thus how narrow the interval is.
    pub status: Status,
    /// Penetration depth: moving B by this length along `normal` makes the shapes touch. 0 if they
    /// are separated or touch.
    pub depth: f64,
    /// Lower bound of the penetration depth, at least 0, with allowance for rounding error.
    pub depth_lower: f64,
    /// Upper bound of the penetration depth, with allowance for rounding error.
    pub depth_upper: f64,
    /// Unit vector from A to B. A separating axis if the shapes are separated.
    pub normal: DVec3,
    /// Witness point: the point of A that is deepest in B. If the shapes are separated, some point
    /// of A; [`distance`](crate::distance()) computes the closest one.
    ///
    /// Both witness points are in their shapes and on their support planes along `normal`, and
    /// `point_a` − `point_b` is `depth` times `normal`: all to within the width of the interval and
    /// rounding error. With the statuses [`IterationLimit`](Status::IterationLimit) and
    /// [`Stalled`](Status::Stalled), `point_a` − `point_b` may differ from that across the normal,
    /// and if the lower bound is 0, along it as well.
    pub point_a: DVec3,
    /// Witness point: the point of B that is deepest in A. If the shapes are separated, some point
    /// of B.
    pub point_b: DVec3,
    /// Number of steps of all phases together.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
}

impl Default for Contact {
    /// A contact that claims nothing: the interval [0, ∞) contains every depth. It initialises the
    /// slices of a batch.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::IterationLimit,
            depth: 0.0,
            depth_lower: 0.0,
            depth_upper: f64::INFINITY,
            normal: DVec3::X,
            point_a: DVec3::ZERO,
            point_b: DVec3::ZERO,
            iterations: 0,
            support_calls: 0,
        }
    }
}

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
    let mut m = Minkowski::new(a, b, b_in_a);
    let facets = a.facets().zip(b.facets()).map(|(a, b)| [a, b]);
    let mut out = solve(&mut m, facets, settings, cache);
    out.support_calls = m.support_calls();
    out
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
    let mut out =
        sat::contact(&mut m, [a.facets()?, b.facets()?], settings.relative_tolerance(), None, &mut Cache::new())?;
    out.support_calls = m.support_calls();
    Some(out)
}

fn solve<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    facets: Option<[Facets<'_>; 2]>,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    let tolerance = settings.relative_tolerance();
    let last = match separated_early(m, cache) {
        Early::Separated(axis) => return separated_contact(m, cache, axis, 0),
        Early::Unknown(last) => last,
    };
    if let Some(found) = contact_of_balls(m, tolerance) {
        cache.forget_axis();
        return found;
    }
    if settings.max_iterations > 0
        && let Some(facets) = facets
        && sat::pays(m, &facets, cache)
        && let Some(found) = sat::contact(m, facets, tolerance, last.as_ref(), cache)
    {
        return found;
    }
    if settings.max_iterations > 0
        && let Some(expanded) = expand_again(m, Goal::Depth { tolerance }, settings.max_iterations, cache)
    {
        return contact_from_expansion(m, cache, &expanded, tolerance, expanded.iterations);
    }
    let mut portal = Portal::EMPTY;
    let (found, mut iterations) = discover_portal(m, &mut portal);
    let mut bound = Bound::none();
    let mut start = None;
    match found {
        Discovery::Separated { axis } => {
            store_separation(cache, axis, &portal.vertices);
            return separated_contact(m, cache, axis, iterations);
        }
        Discovery::Portal => {
            let until = if settings.max_iterations == 0 { Until::Surface { tolerance } } else { Until::Decided };
            let refined = refine_portal(m, &mut portal, until, &mut bound);
            iterations += refined.iterations;
            if refined.side == Side::Separated {
                store_separation(cache, refined.axis, &portal.vertices);
                return separated_contact(m, cache, refined.axis, iterations);
            }
            start = Some(portal_tetrahedron(m, &portal));
        }
        Discovery::Flat | Discovery::Limit => {}
    }
    let expanded = expand(m, start, Goal::Depth { tolerance }, bound, settings.max_iterations, cache);
    iterations += expanded.iterations;
    contact_from_expansion(m, cache, &expanded, tolerance, iterations)
}

/// A contact query that is suspended wherever it waits for memory, so that a batch can keep several
/// queries in flight. The answer has the bits of [`core_contact`] for shapes of which one has no
/// facets, and for at least one iteration.
#[derive(Debug)]
pub(crate) struct SuspendedContact<'s, A: ?Sized, B: ?Sized> {
    m: Minkowski<'s, A, B>,
    phase: Phase,
    /// The support query that comes next.
    next: Interrupted,
}

/// What the next support point is for.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// The separating axis of the cache.
    Axis,
    /// Portal discovery and portal refinement.
    Portal(mpr::Search),
    /// EPA, after this number of steps of the other phases.
    Expansion(epa::Search, u32),
}

impl<'s, A: SupportMap + ?Sized, B: SupportMap + ?Sized> Suspended<'s, A, B> for SuspendedContact<'s, A, B> {
    type Settings = Settings;
    type Answer = Contact;
    type Room = Room;

    fn start(
        (a, b, b_in_a): (&'s A, &'s B, Pose),
        settings: &Settings,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Result<Self, Contact> {
        let m = Minkowski::new(a, b, b_in_a);
        let mut query = Self { m, phase: Phase::Axis, next: Interrupted::NOTHING };
        let are_balls_separated = query.m.outer_balls_separated();
        if are_balls_separated && let Some(axis) = unit(-query.m.center_point().w) {
            return Err(separated_contact(&query.m, cache, axis, 0));
        }
        match cache.axis().filter(|_| !are_balls_separated) {
            Some(axis) => query.next = query.m.start(axis),
            None => query.start_search(settings, cache, room).map_or(Ok(()), Err)?,
        }
        Ok(query)
    }

    fn step(&mut self, settings: &Settings, cache: &mut Cache, room: &mut Room) -> Option<Contact> {
        if !self.next.is_ready() {
            self.m.resume(&mut self.next);
            return None;
        }
        let dir = self.next.dir;
        let point = self.m.finish(&self.next);
        match &mut self.phase {
            Phase::Axis => {
                if point.w.dot(dir) < -self.m.rounding_error() {
                    let found = separated_contact(&self.m, cache, dir, 0);
                    return Some(self.answer(found));
                }
                self.start_search(settings, cache, room)
            }
            Phase::Portal(search) => match search.continue_with(point) {
                None => {
                    self.next = self.m.start(search.direction());
                    None
                }
                Some(found) => {
                    let (portal, iterations) = (*search.portal(), search.iterations());
                    self.after_search(found, &portal, iterations, settings, cache, room)
                }
            },
            Phase::Expansion(search, iterations) => {
                let (progress, iterations) = (search.continue_with(point, &mut self.m, cache, room), *iterations);
                self.after_expansion(progress, iterations, settings, cache)
            }
        }
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> SuspendedContact<'_, A, B> {
    /// Continues after the test of the axis.
    fn start_search(&mut self, settings: &Settings, cache: &mut Cache, room: &mut Room) -> Option<Contact> {
        let tolerance = settings.relative_tolerance();
        if let Some(found) = contact_of_balls(&mut self.m, tolerance) {
            cache.forget_axis();
            return Some(self.answer(found));
        }
        match epa::Search::start_again(&self.m, tolerance, settings.max_iterations, cache, room) {
            Some(search) => self.start_expansion(search, 0, settings, cache, room),
            None => {
                self.start_portal();
                None
            }
        }
    }

    fn start_portal(&mut self) {
        let search = mpr::Search::new(&self.m);
        self.next = self.m.start(search.direction());
        self.phase = Phase::Portal(search);
    }

    /// Continues with what portal discovery and refinement have found, after `iterations` steps.
    fn after_search(
        &mut self,
        found: Found,
        portal: &Portal,
        iterations: u32,
        settings: &Settings,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Option<Contact> {
        let (tolerance, limit) = (settings.relative_tolerance(), settings.max_iterations);
        let start = match found {
            Found::Separated { axis } => {
                store_separation(cache, axis, &portal.vertices);
                let found = separated_contact(&self.m, cache, axis, iterations);
                return Some(self.answer(found));
            }
            Found::Portal(_) => Some(portal_tetrahedron(&self.m, portal)),
            Found::Nothing => None,
        };
        let search = start.and_then(|start| epa::Search::start(&self.m, start, tolerance, limit, cache, room));
        if let Some(search) = search {
            return self.start_expansion(search, iterations, settings, cache, room);
        }
        let expanded = expand(&mut self.m, start, Goal::Depth { tolerance }, Bound::none(), limit, cache);
        self.after_expansion(Progress::Ended(Some(expanded)), iterations, settings, cache)
    }

    fn start_expansion(
        &mut self,
        mut search: epa::Search,
        iterations: u32,
        settings: &Settings,
        cache: &mut Cache,
        room: &mut Room,
    ) -> Option<Contact> {
        let progress = search.aim(&mut self.m, cache, room);
        self.phase = Phase::Expansion(search, iterations);
        self.after_expansion(progress, iterations, settings, cache)
    }

    /// Continues with the progress of EPA, which began after `iterations` steps.
    fn after_expansion(
        &mut self,
        progress: Progress,
        iterations: u32,
        settings: &Settings,
        cache: &mut Cache,
    ) -> Option<Contact> {
        match progress {
            Progress::Query(dir) => {
                self.next = self.m.start(dir);
                None
            }
            Progress::Ended(Some(expanded)) => {
                let (tolerance, iterations) = (settings.relative_tolerance(), iterations + expanded.iterations);
                let found = contact_from_expansion(&self.m, cache, &expanded, tolerance, iterations);
                Some(self.answer(found))
            }
            // The polytope of the cache is of no use.
            Progress::Ended(None) => {
                self.start_portal();
                None
            }
        }
    }

    fn answer(&self, found: Contact) -> Contact {
        Contact { support_calls: self.m.support_calls(), ..found }
    }
}

/// The contact that follows from the outcome of EPA.
fn contact_from_expansion<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &Minkowski<'_, A, B>,
    cache: &mut Cache,
    expanded: &Expansion,
    tolerance: f64,
    iterations: u32,
) -> Contact {
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
    let roundings = if touching { epa::BESIDE_ROUNDINGS } else { epa::FOOT_ROUNDINGS };
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
        support_calls: 0,
    }
}

/// No contact: `axis` separates the shapes. Stores the axis in the cache.
pub(super) fn separated_contact<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
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
    let is_settled = vertex.w.distance(normal * upper) <= upper - lower + epa::FOOT_ROUNDINGS * rounding;
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
        support_calls: 0,
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
            let expanded = Expansion { end: epa::End::Touching, lower, bound, iterations: 1 };
            contact_from_expansion(&m, &mut Cache::new(), &expanded, 0.0, 1)
        };
        let deep = found(1.25 * m.noise(), 1.5 * m.noise());
        assert_eq!(deep.status, Status::Exact);
        assert!(0.0 < deep.depth_lower && deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper);
        let unknown = found(0.75 * m.noise(), 1.5 * m.noise());
        assert_eq!((unknown.status, unknown.depth, unknown.depth_lower), (Status::Touching, 0.0, 0.0));
    }
}
