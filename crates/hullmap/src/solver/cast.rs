//! Linear shape cast: the time of impact of two shapes that translate relative to each other.
//!
//! # Reference
//! van den Bergen, "Ray casting against general convex objects with application to continuous
//! collision detection", 2004: a shape cast is a ray cast of the Minkowski difference.
//!
//! # Steps
//! 1. Try the direction that separated the pair before: one support call decides most misses.
//! 2. Shapes without convex radius: portal refinement along the line of motion (`line`).
//! 3. Rounded shapes: Newton's method on the distance of the cores (`rounded`).

use glam::{DQuat, DVec3};

use super::cache::Cache;
use super::line::{Entry, LineQuery, enter};
use super::minkowski::Minkowski;
use super::motion::{CastSettings, Motion, Path, Ray};
use super::queries::{distance, intersects};
use super::ray_hit::RayHit;
use super::ray_polytope::{Vertices, ray_polytope};
use super::rounded::enter_rounded;
use super::settings::Settings;
use super::status::{Overlap, Status};
use crate::fields::fields;
use crate::pose::Pose;
use crate::support::SupportMap;

/// Answer of [`cast`](crate::cast()): when and where a moving shape first meets another.
///
/// Points and directions are in A's frame. Times are in the unit that the velocity implies: at time
/// t, B has moved by t times its velocity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// False only if it is certain that the shapes do not meet up to
    /// [`CastSettings::max_t`](crate::CastSettings::max_t).
    pub hit: bool,
    /// How the query ended.
    ///
    /// - [`Separated`](Status::Separated): certainly no hit. All times are infinite.
    /// - [`Overlapping`](Status::Overlapping): the shapes overlap at the start. All times are 0,
    ///   the normal is opposite to the motion, and [`contact`](crate::contact()) computes the
    ///   depth. Without motion, the normal is any unit vector.
    /// - [`Exact`](Status::Exact), [`Within`](Status::Within): a hit in the interval.
    /// - [`Touching`](Status::Touching): the shapes graze each other, and rounding error decides
    ///   between hit and miss. If they meet, they do so in the interval.
    /// - [`IterationLimit`](Status::IterationLimit), [`Stalled`](Status::Stalled): a hit, in an
    ///   interval that is wider than the tolerance.
    pub status: Status,
    /// Time of impact; infinite if there is no hit.
    pub t: f64,
    /// Lower bound of the time of impact, at least 0, with allowance for rounding error. Until then
    /// the shapes certainly do not overlap.
    pub t_lower: f64,
    /// Upper bound of the time of impact, with allowance for rounding error. It may exceed `max_t`
    /// if the interval does.
    pub t_upper: f64,
    /// Unit vector from A to B: normal of a plane that separates the shapes until `t_lower`. If
    /// there is no hit, normal of a plane that takes part in the proof.
    pub normal: DVec3,
    /// Point of A at which the shapes meet. If they overlap at the start, a common point. Zero if
    /// there is no hit.
    pub point_a: DVec3,
    /// Point of B at which the shapes meet, at time `t`.
    pub point_b: DVec3,
    /// Number of steps of the search.
    pub iterations: u32,
    /// Number of support calls. One call queries both shapes once.
    pub support_calls: u32,
    /// The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    /// mesh or a field. 0 for a shape without parts.
    pub parts: [u32; 2],
}

fields!(Impact { hit status t t_lower t_upper normal point_a point_b iterations support_calls parts });

impl Impact {
    /// The answer for a ray on a part, as the cast of a point.
    pub(crate) fn of_ray(found: RayHit, part: usize) -> Self {
        let RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls, .. } = found;
        let ([point_a, point_b], parts) = ([point; 2], [part as u32, 0]);
        Self { hit, status, t, t_lower, t_upper, normal, point_a, point_b, iterations, support_calls, parts }
    }

    /// The answer for a ray whose cast this is, with the point that it hits.
    pub(crate) fn ray_hit(self, point: DVec3) -> RayHit {
        let Self { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, parts: [part, _], .. } = self;
        RayHit { hit, status, t, t_lower, t_upper, point, normal, iterations, support_calls, part }
    }

    /// The same answer with A and B exchanged, for B that translates by `velocity`.
    pub(crate) fn exchanged(self, b_in_a: Pose, velocity: DVec3) -> Self {
        let at = |point: DVec3| b_in_a.transform_point(point) + velocity * self.t;
        let [point_a, point_b] = if self.hit { [at(self.point_b), at(self.point_a)] } else { [DVec3::ZERO; 2] };
        let ([of_a, of_b], normal) = (self.parts, b_in_a.transform_vector(-self.normal));
        Self { normal, point_a, point_b, parts: [of_b, of_a], ..self }
    }
}

impl Default for Impact {
    /// An impact that claims nothing: the interval [0, ∞) contains every time, and the shapes may
    /// miss each other.
    fn default() -> Self {
        Self {
            hit: true,
            status: Status::Touching,
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

/// [`cast`](crate::cast()) of two convex shapes.
pub(crate) fn cast<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Impact {
    let found = cast_by_support((a, b, b_in_a), motion, settings, cache);
    if found.status != Status::Touching && !(found.hit && found.t_upper > settings.limit()) {
        return found;
    }
    // A point at the origin of its frame, where no rotation rounds, moves as a ray.
    let is_point = |radius: f64, center: DVec3| radius == 0.0 && center == DVec3::ZERO;
    let (start, velocity) = (b_in_a.translation(), motion.velocity());
    if is_point(b.outer_radius(), b.interior_point()) && a.polytope_vertex(0).is_some() {
        return cast_point(&|index| a.polytope_vertex(index), [start, velocity], settings, a.outer_radius(), found);
    }
    let is_turned = b_in_a.rotation() != DQuat::IDENTITY;
    if is_point(a.outer_radius(), a.interior_point()) && !is_turned && b.polytope_vertex(0).is_some() {
        let seen_from_b = Impact { normal: -found.normal, ..found };
        let found =
            cast_point(&|index| b.polytope_vertex(index), [-start, -velocity], settings, b.outer_radius(), seen_from_b);
        return Impact { normal: -found.normal, point_a: DVec3::ZERO, point_b: DVec3::ZERO, ..found };
    }
    found
}

/// Exact answer for `grazing`, the cast of a point from `start` that grazes a polytope of an outer
/// radius.
#[cold]
fn cast_point(
    vertices: Vertices<'_>,
    [start, velocity]: [DVec3; 2],
    settings: &CastSettings,
    radius: f64,
    grazing: Impact,
) -> Impact {
    let Ok(ray) = Ray::new(start, velocity) else { return grazing };
    let as_ray = grazing.ray_hit(grazing.point_a);
    let RayHit { hit, status, t, t_lower, t_upper, point, normal, .. } =
        ray_polytope(vertices, &ray, settings, radius, as_ray);
    let point = if hit { point } else { DVec3::ZERO };
    Impact { hit, status, t, t_lower, t_upper, normal, point_a: point, point_b: point, ..grazing }
}

/// The cast by support queries: grazing shapes touch.
pub(super) fn cast_by_support<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Impact {
    let Some(path) = motion.path() else { return at_rest(a, b, b_in_a, cache) };
    let radii = [a.convex_radius(), b.convex_radius()];
    let found = if radii[0] + radii[1] > 0.0 {
        let (entry, support_calls) = enter_rounded((a, b, b_in_a), radii, &query(a, b, path, settings), cache);
        impact(&entry, path, support_calls)
    } else {
        cast_sharp((a, b, b_in_a), path, settings, cache.axis())
    };
    if !found.hit {
        cache.set_axis(found.normal);
    }
    found
}

/// The cast of shapes without convex radius, along a path. `axis` is the last separating direction,
/// if any.
#[inline]
pub(super) fn cast_sharp<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    path: Path,
    settings: &CastSettings,
    axis: Option<DVec3>,
) -> Impact {
    enter_along((a, b, b_in_a), path, &query(a, b, path, settings), axis)
}

/// [`cast_sharp`] of a point along a ray. On a polytope, the normal belongs to a face.
#[inline]
pub(super) fn cast_dot<S: SupportMap + ?Sized, D: SupportMap>(
    (shape, dot, start): (&S, &D, Pose),
    path: Path,
    settings: &CastSettings,
) -> Impact {
    let query = query(shape, dot, path, settings);
    let gap = if shape.polytope_vertex(0).is_some() { f64::NEG_INFINITY } else { query.gap };
    enter_along((shape, dot, start), path, &LineQuery { gap, ..query }, None)
}

#[inline]
fn enter_along<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    path: Path,
    query: &LineQuery,
    axis: Option<DVec3>,
) -> Impact {
    let mut m = Minkowski::new(a, b, b_in_a);
    let entry = enter(&mut m, query, axis);
    impact(&entry, path, m.support_calls())
}

fn query<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    a: &A,
    b: &B,
    path: Path,
    settings: &CastSettings,
) -> LineQuery {
    let tolerance = settings.relative_tolerance() * (a.outer_radius() + b.outer_radius());
    LineQuery {
        direction: path.direction,
        // Rounded up: the limit itself counts.
        limit: path.length(settings.limit()) * (1.0 + 2.0 * f64::EPSILON),
        tolerance,
        gap: tolerance,
        max_iterations: settings.max_iterations,
    }
}

/// The answer for an entry at a length along the path.
fn impact(entry: &Entry, path: Path, support_calls: u32) -> Impact {
    let is_hit = entry.status != Status::Separated;
    // The speed and the quotient have an error of a few roundings.
    let time = |length: f64, roundings: f64| path.time(length) * (1.0 + roundings * f64::EPSILON);
    let (t_lower, t, t_upper) = (time(entry.lower, -4.0), time(entry.at, 0.0), time(entry.upper, 4.0));
    // A hit near the end of the time range: rounding error decides whether it is within.
    let is_late = is_hit && !(t_upper < f64::INFINITY);
    let latest = if is_hit { f64::MAX } else { f64::INFINITY };
    Impact {
        hit: is_hit,
        status: if is_late { Status::Touching } else { entry.status },
        t: t.min(latest),
        t_lower: t_lower.min(latest),
        t_upper: t_upper.min(latest),
        normal: entry.normal,
        point_a: entry.points[0],
        point_b: entry.points[1],
        iterations: entry.iterations,
        support_calls,
        parts: [0; 2],
    }
}

/// Without motion, the shapes meet at the start or never.
fn at_rest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(a: &A, b: &B, b_in_a: Pose, cache: &mut Cache) -> Impact {
    let found = intersects(a, b, b_in_a, cache);
    let (iterations, support_calls) = (found.iterations, found.support_calls);
    if found.status == Overlap::Separated {
        let (never, normal) = (f64::INFINITY, cache.axis().unwrap_or(DVec3::X));
        let miss = Impact { hit: false, status: Status::Separated, normal, ..Impact::default() };
        return Impact { t: never, t_lower: never, t_upper: never, iterations, support_calls, ..miss };
    }
    let near = distance(a, b, b_in_a, &Settings::default(), cache);
    Impact {
        status: if found.status == Overlap::Overlapping { Status::Overlapping } else { Status::Touching },
        t_upper: 0.0,
        normal: near.normal,
        point_a: near.point_a,
        point_b: near.point_b,
        iterations: iterations + near.iterations,
        support_calls: support_calls + near.support_calls,
        ..Impact::default()
    }
}
