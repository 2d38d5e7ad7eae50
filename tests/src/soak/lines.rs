//! Rays, shape casts and signed distances of the soak's shapes, with a certificate for each answer.
//!
//! | claim | certificate |
//! |---|---|
//! | a miss | the planes or facets leave nothing of the path; no contact is deep on the path |
//! | lower bound of the time | at that time, the reported normal still separates the shapes |
//! | a hit | the reported points at time t are in their shapes, on the support planes of the normal and on each other, to within the interval |
//! | both bounds | the path clipped by all planes of a shape, or by all facets of the pair |
//! | lower bound of a signed distance | the plane of the reported normal; inside, all planes |
//! | upper bound of a signed distance | the reported point is in the shape; all planes |
//!
//! Each path passes through a pose or a point of the soak of pairs. Most of those pairs touch. So
//! many paths graze the shapes along a face or an edge, or just pass a vertex.

use glam::DVec3;
use hullmap::{
    Cache, CastSettings, Contact, Impact, Minkowski, Motion, Pose, Ray, RayHit, Settings, Status, cast, contact, ray,
    signed_distance,
};
use hullmap_testkit::{
    entry::{Passage, passage},
    polytope::Polytope,
    random::RandomPoses,
    reach::{Placed, Reach, way_out},
};
use shapes::rng::SplitMix64;

use super::{
    bodies::BodyPair,
    body::{Body, Kind, Solid, size, support},
    claims::{Claims, ROUNDING_UNITS, same_when_slow},
    judge::TOUCHING_ROUNDINGS,
    tally::Tally,
};

/// Maximum product of the numbers of edges for which all facets are tested.
const MAX_EDGE_PAIRS: usize = 10_000;

/// Inner radius of a body, relative to its outer radius, below which it is thin.
const THIN: f64 = 1e-4;

/// Maximum width of an exact interval, as a height above a plane, relative to the outer radii.
const EXACT: f64 = 1e-9;

/// Maximum number of steps of a cast; rounded shapes need a search of its own at each step.
const MAX_STEPS: u32 = 20_000;

/// An answer about a path, in terms that rays and casts share.
#[derive(Clone, Copy, Debug)]
struct Answer {
    hit: bool,
    status: Status,
    /// Lower bound, value and upper bound.
    t: [f64; 3],
    normal: DVec3,
    steps: u32,
}

impl From<Impact> for Answer {
    fn from(found: Impact) -> Self {
        let Impact { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, .. } = found;
        Self { hit, status, t: [t_lower, t, t_upper], normal, steps: iterations.max(support_calls) }
    }
}

/// The fields that rays and casts share.
fn as_impact(found: RayHit) -> Impact {
    let RayHit { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, .. } = found;
    Impact { hit, status, t, t_lower, t_upper, normal, iterations, support_calls, ..Impact::default() }
}

/// A path that B, or a point, takes in A's frame.
struct Path {
    start: Pose,
    velocity: DVec3,
    limit: f64,
    /// A time at which the path goes through a chosen point.
    through: f64,
    /// Tolerance of a certificate: a length.
    slack: f64,
}

/// Whether the body is nearly flat, flat, or a line.
fn is_thin(body: &Body<'_>) -> bool {
    body.shape().inner_radius() < THIN * body.shape().outer_radius()
}

/// Whether the normals of the body's faces may be rounding error. Its planes still contain it, and
/// do not describe it. The planes of polygons do.
fn is_sliver(body: &Body<'_>) -> bool {
    is_thin(body) && body.kind != Kind::Flat
}

/// A direction of which many graze the body.
fn direction(rng: &mut SplitMix64, body: &Body<'_>) -> DVec3 {
    let index = rng.below(64);
    let found = match rng.below(8) {
        0 => Some(DVec3::AXES[rng.below(3)]),
        1 => body.model.face_normal(index).map(|n| -n),
        2 => body.model.edge(index, 0.5).map(|(along, _)| along),
        // Along a face.
        3 => body.model.face_normal(index).map(|n| n.cross(rng.unit_vector())),
        _ => None,
    };
    let found = found.filter(|d| d.is_finite() && d.length() > 1e-3);
    found.unwrap_or_else(|| rng.unit_vector())
}

/// A point of the body, or near it.
fn target(rng: &mut SplitMix64, body: &Body<'_>) -> DVec3 {
    let corner = |rng: &mut SplitMix64| support(body, rng.unit_vector());
    match rng.below(8) {
        0 => corner(rng),
        1 => corner(rng).lerp(corner(rng), rng.between(0.0, 1.0)),
        2 => (corner(rng) + corner(rng) + corner(rng)) / 3.0,
        3 => body.shape().interior_point(),
        4 => corner(rng) + rng.unit_vector() * (size(body) * 1e-9),
        _ => body.shape().interior_point() + rng.unit_vector() * (size(body) * rng.between(0.0, 1.2)),
    }
}

/// The path that leads through `middle` along `along`, for shapes of the given size.
fn path(rng: &mut SplitMix64, middle: Pose, along: DVec3, size: f64, greatest: f64) -> Path {
    let velocity = along * ([1.0, 1.0, 1.0, 1e-3, 1e3][rng.below(5)] * size.max(1e-9));
    let duration = match rng.below(16) {
        0 | 1 => 0.0,
        2 => 1e-6,
        3 => 1e3,
        _ => rng.between(0.0, 4.0),
    };
    let through = duration * size.max(1e-9) / velocity.length();
    let start = Pose::new(middle.translation() - velocity * through, middle.rotation()).expect("finite");
    let limit = match rng.below(4) {
        0 => through * rng.between(0.5, 1.5),
        _ => f64::INFINITY,
    };
    let length = start.translation().length().max(middle.translation().length()) + velocity.length() * through;
    Path { start, velocity, limit, through, slack: ROUNDING_UNITS * f64::EPSILON * (greatest + length) }
}

fn settings(rng: &mut SplitMix64, path: &Path) -> CastSettings {
    let tolerance = if rng.below(8) == 0 { 0.0 } else { CastSettings::default().tolerance };
    CastSettings { max_t: path.limit, tolerance, ..CastSettings::default() }
}

/// The claims that need no second shape. `radii` is the outer radius of the shape, or the sum of
/// both.
fn judge_form(judge: &mut Claims<'_>, answer: &Answer, path: &Path, settings: &CastSettings, radii: f64) {
    let Answer { hit, status, t: [lower, t, upper], normal, steps } = *answer;
    judge.tally.note(status.as_str());
    judge.demand("the steps are not bounded", steps <= MAX_STEPS);
    judge.unit(normal);
    judge.demand("hit and status contradict each other", hit == (status != Status::Separated));
    if hit {
        judge.demand("t is not in its own interval", 0.0 <= lower && lower <= t && t <= upper);
        judge.demand("the lower bound is beyond the limit", lower <= path.limit);
        judge.demand("an interval without end", upper < f64::INFINITY);
        let (width, speed) = (upper - lower, path.velocity.length());
        if status == Status::Within {
            judge.at_most("wider than the tolerance", width * speed, settings.tolerance * radii, path.slack);
        }
        // Rounding errors of a height above a plane, and of baked vertices.
        if status == Status::Exact {
            let height = width * normal.dot(path.velocity).abs();
            judge.at_most("an exact time is wide", height, EXACT * radii, 100.0 * path.slack);
        }
    } else {
        judge.demand("a miss at a finite time", lower == f64::INFINITY);
    }
    if status == Status::Overlapping {
        judge.demand("an overlap later than the start", upper == 0.0);
    }
}

/// At the lower bound of t, the shapes are `way` from leaving each other along the normal. At t,
/// the points are so far inside of their shapes.
fn judge_planes(judge: &mut Claims<'_>, answer: &Answer, path: &Path, way: f64, inside: &[(&'static str, f64)]) {
    let [lower, _, upper] = answer.t;
    // A path that starts inside of the shape meets its surface nowhere, which the status need not
    // reflect.
    if answer.hit && lower > 0.0 {
        judge.at_most("the normal does not separate", way, 0.0, path.slack);
        for (what, inside) in inside.iter().filter(|_| answer.status != Status::Touching) {
            judge.at_most(what, *inside, (upper - lower) * path.velocity.length(), path.slack);
        }
    }
}

/// The path against a truth. The truth has all planes only if `is_complete`.
fn judge_passage(judge: &mut Claims<'_>, answer: &Answer, path: &Path, truth: &Passage, is_complete: bool) {
    let Answer { hit, status, t: [lower, _, upper], .. } = *answer;
    let [earliest, latest] = truth.enter.map(|t| t.max(0.0));
    if hit {
        let is_certain = status != Status::Touching;
        // An interval that ends beyond the limit leaves open whether the hit is within it.
        judge.demand("a certain hit misses", !(is_certain && truth.certainly_misses(path.limit.max(upper))));
        judge.demand("the entry is later than its interval", !is_certain || earliest <= upper);
        judge.demand("the start is not inside", status != Status::Overlapping || truth.enter[0] <= 0.0);
        if is_complete && truth.certainly_hits(path.limit) {
            judge.demand("the entry is earlier than its interval", lower <= latest);
            judge.demand("the entry is later than its interval", earliest <= upper);
        }
    } else if is_complete {
        judge.demand("a certain miss hits", !truth.certainly_hits(path.limit));
    }
}

pub(super) fn judge_ray(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let body = pair.bodies[0];
    let middle = Pose::from_translation(target(rng, body)).expect("finite");
    let along = direction(rng, body);
    let path = path(rng, middle, along, size(body), body.model.greatest);
    let settings = settings(rng, &path);
    let (origin, shape) = (path.start.translation(), body.shape());
    let line = Ray::new(origin, path.velocity).expect("finite");
    let found = match &body.solid {
        Solid::Hull(hull) => ray(hull, &line, &settings),
        Solid::Shape(_) => ray(shape, &line, &settings),
    };
    let answer = as_impact(found).into();
    let mut judge = Claims::new("rays", tally);
    judge_form(&mut judge, &answer, &path, &settings, shape.outer_radius());
    same_when_slow(&mut judge, rng, &as_impact(found), path.velocity, &settings, |velocity, settings| {
        as_impact(ray(shape, &Ray::new(origin, velocity).expect("finite"), settings))
    });
    let (model, normal) = (&body.model, found.normal);
    let way = model.reach(normal) - normal.dot(line.point_at(found.t_lower));
    let inside = model.reach(normal) - normal.dot(found.point);
    judge_planes(&mut judge, &answer, &path, way, &[("the point is not on the shape", inside)]);
    // The time of a grazing ray may be cut off at the limit. In the plane of a sliver, rounding
    // error leaves no better time than any in the interval.
    let is_free = path.limit == f64::INFINITY && !is_thin(body);
    if found.hit && (found.status != Status::Touching || is_free) {
        // The shape may be that far from the point, because t is known to within its interval only.
        let width = (found.t_upper - found.t_lower) * path.velocity.length();
        let slack = path.slack + 2.0 * shape.support_error();
        judge.at_most("the point is not in the shape", model.outside(found.point), width, slack);
    }
    let mut truth = Passage::UNBOUNDED;
    truth.clip(found.normal.dot(path.velocity), model.reach(found.normal) - found.normal.dot(origin), path.slack);
    let planes = model.planes();
    for n in planes.iter().flatten() {
        truth.clip(n.dot(path.velocity), model.reach(*n) - n.dot(origin), path.slack);
    }
    let is_complete = planes.is_some() && !is_sliver(body);
    judge.tally.normals += u64::from(is_complete);
    judge_passage(&mut judge, &answer, &path, &truth, is_complete);
    judge.finish(pair, || format!("{line:?} {settings:?}\n  {found:?}\n  {truth:?}, slack {:e}", path.slack));
}

/// Judges a cast of the second body at the first.
pub(super) fn judge_cast(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let [a, b] = pair.bodies;
    let along = direction(rng, a);
    let path = path(rng, pair.b_in_a, along, size(a).max(size(b)), a.model.greatest + b.model.greatest);
    let settings = settings(rng, &path);
    let motion = Motion::new(path.velocity).expect("finite");
    let mut cache = Cache::new();
    let is_cold = rng.below(4) != 0;
    if !is_cold {
        // Warm: a pose beside the start.
        let beside = Pose::new(path.start.translation() * 1.001, path.start.rotation()).expect("finite");
        contact(a.shape(), b.shape(), beside, &Settings::default(), &mut cache);
        cast(a.shape(), b.shape(), beside, motion, &settings, &mut cache);
    }
    let found: Impact = match (&a.solid, &b.solid) {
        (Solid::Hull(a), Solid::Hull(b)) => cast(a, b, path.start, motion, &settings, &mut cache),
        _ => cast(a.shape(), b.shape(), path.start, motion, &settings, &mut cache),
    };
    let answer = found.into();
    let mut judge = Claims::new("casts", tally);
    judge_form(&mut judge, &answer, &path, &settings, a.shape().outer_radius() + b.shape().outer_radius());
    if is_cold {
        same_when_slow(&mut judge, rng, &found, path.velocity, &settings, |velocity, settings| {
            let motion = Motion::new(velocity).expect("finite");
            cast(a.shape(), b.shape(), path.start, motion, settings, &mut Cache::new())
        });
    }
    let at = |t: f64| Pose::new(path.start.translation() + path.velocity * t, path.start.rotation()).expect("finite");
    let way = |t: f64, n: DVec3| way_out(&a.model, &Placed::new(&b.model, at(t)), n);
    if found.hit {
        let n = found.normal;
        let on_b = Placed::new(&b.model, at(found.t)).reach(-n) + n.dot(found.point_b);
        let inside =
            [("the point is not on A", a.model.reach(n) - n.dot(found.point_a)), ("the point is not on B", on_b)];
        judge_planes(&mut judge, &answer, &path, way(found.t_lower, n), &inside);
        let in_b = at(found.t).inverse().transform_point(found.point_b);
        judge.at_most("the point is not in A", a.model.outside(found.point_a), 0.0, path.slack);
        judge.at_most("the point is not in B", b.model.outside(in_b), 0.0, path.slack);
        let apart = found.point_a.distance(found.point_b);
        // The common point of a path that starts inside.
        let hair = TOUCHING_ROUNDINGS * Minkowski::new(a.shape(), b.shape(), path.start).rounding_error();
        let width = (found.t_upper - found.t_lower) * path.velocity.length();
        if found.status != Status::Touching {
            judge.at_most("the points are not one", apart, if found.t_upper == 0.0 { hair } else { width }, path.slack);
        }
    }
    // Where the pair certainly overlaps at some time, it was hit before.
    let deep: Contact = contact(a.shape(), b.shape(), at(path.through), &Settings::default(), &mut Cache::new());
    if deep.depth_lower > path.slack && path.through <= path.limit {
        judge.demand("a certain miss hits", found.hit);
        judge.demand(
            "a contact is earlier than the interval",
            !found.hit || found.t_lower <= path.through * (1.0 + 1e-15),
        );
    }
    let mut truth = Passage::UNBOUNDED;
    for n in [found.normal, deep.normal] {
        truth.clip(n.dot(path.velocity), way(0.0, n), path.slack);
    }
    let is_complete = clip_by_facets(a, b, &path, &mut truth);
    judge.tally.facets += u64::from(is_complete);
    judge_passage(&mut judge, &answer, &path, &truth, is_complete);
    judge.finish(pair, || {
        format!("from {:?} {motion:?} {settings:?}\n  {found:?}\n  {truth:?}, slack {:e}", path.start, path.slack)
    });
}

/// Clips by all facets of the Minkowski difference, if there are not too many of them.
fn clip_by_facets(a: &Body<'_>, b: &Body<'_>, path: &Path, truth: &mut Passage) -> bool {
    let (Solid::Hull(hull_a), Solid::Hull(hull_b)) = (&a.solid, &b.solid) else { return false };
    let is_solid = [(a, hull_a), (b, hull_b)].iter().all(|(body, hull)| hull.rank() == 3 && !is_sliver(body));
    if !is_solid || 9 * hull_a.vertex_count() * hull_b.vertex_count() > MAX_EDGE_PAIRS {
        return false;
    }
    let (a, b) = (Polytope::new(hull_a), Polytope::new(hull_b).placed(path.start));
    let found = passage(&a, &b, path.velocity, path.slack);
    truth.enter = [0, 1].map(|i| truth.enter[i].max(found.enter[i]));
    truth.exit = [0, 1].map(|i| truth.exit[i].min(found.exit[i]));
    true
}

/// Judges a signed distance of a point from the first body.
pub(super) fn judge_point(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let body = pair.bodies[0];
    let offset = size(body) * [0.0, 0.0, 1e-15, 1e-9, 1e-3, 0.3, 3.0, 1e3][rng.below(8)];
    let point = target(rng, body) + direction(rng, body) * offset;
    let settings = Settings::default();
    let mut cache = Cache::new();
    if rng.below(2) == 0 {
        let beside = point + rng.unit_vector() * (0.01 * size(body));
        signed_distance(body.shape(), beside, &settings, &mut cache).expect("finite");
    }
    let found = match &body.solid {
        Solid::Hull(hull) => signed_distance(hull, point, &settings, &mut cache),
        Solid::Shape(shape) => signed_distance(&**shape, point, &settings, &mut cache),
    }
    .expect("finite");
    let model = &body.model;
    let greatest = model.greatest + point.length();
    let slack = ROUNDING_UNITS * f64::EPSILON * greatest;
    let mut judge = Claims::new("points", tally);
    judge.tally.note(found.status.as_str());
    judge.demand("the steps are not bounded", found.iterations.max(found.support_calls) <= MAX_STEPS);
    judge.demand("a status about overlap", !matches!(found.status, Status::Separated | Status::Overlapping));
    judge.ordered("not in its own interval", [found.lower, found.distance, found.upper]);
    judge.unit(found.normal);
    // The signed distance is the maximum over all planes of the height above the plane.
    let height = |n: DVec3| n.dot(point) - model.reach(n);
    if found.lower > 0.0 {
        judge.at_most("the normal does not prove the lower bound", found.lower, height(found.normal), slack);
    }
    judge.at_most("the point is not in the shape", model.outside(found.point), 0.0, slack);
    if found.upper > 0.0 && found.lower > 0.0 {
        judge.at_most("a point is nearer than the bound", found.lower, found.point.distance(point), slack);
    }
    if matches!(found.status, Status::Exact | Status::Within) {
        let (width, slack_along) = (found.upper - found.lower, slack + 2.0 * body.shape().support_error());
        let inside = model.reach(found.normal) - found.normal.dot(found.point);
        judge.at_most("the point is not on the surface", inside, width, slack_along);
        let along = (point - found.point).dot(found.normal);
        judge.at_most("the point is farther than the distance", along, found.upper, slack_along);
        judge.at_most("the point is nearer than the distance", found.lower, along, slack_along);
        let tolerance = if found.status == Status::Within { settings.tolerance * found.distance.abs() } else { 0.0 };
        judge.at_most("a distance is wide", width, tolerance + EXACT * size(body), slack_along);
    }
    let planes = model.planes();
    let highest = planes.iter().flatten().map(|n| height(*n)).fold(height(found.normal), f64::max);
    judge.at_most("the distance is above its interval", highest, found.upper, slack);
    if planes.is_some() && !is_sliver(body) && highest < 0.0 {
        judge.tally.normals += 1;
        judge.at_most("the distance is below its interval", found.lower, highest, slack);
    }
    judge.finish(pair, || format!("{point} {found:?}\n  highest plane {highest:e}, slack {slack:e}"));
}
