//! Half-spaces against the soak's shapes, with a certificate for each answer.
//!
//! | claim | certificate |
//! |---|---|
//! | depth, distance | how far the shape reaches below the plane is in the interval |
//! | points | one is in the shape, as low as it reaches; the other is on the plane, opposite |
//! | time of a cast | the lowest point is above the plane at the lower bound, and below it at the upper |
//!
//! Most planes nearly touch the shape, and many motions are nearly parallel to the plane.

use glam::DVec3;
use hullmap::{
    Cache, CastSettings, Contact, Distance, Minkowski, Motion, Overlap, Pose, Ray, Settings, Status,
    shapes::{HalfSpace, Sphere},
};
use hullmap_testkit::{
    random::RandomPoses,
    reach::{Placed, Reach},
};
use shapes::rng::SplitMix64;

use super::{
    bodies::BodyPair,
    body::size,
    claims::{Claims, ROUNDING_UNITS, same_when_slow},
    tally::Tally,
};

/// Judges a half-space against the second body of the pair.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let (body, pose) = (pair.bodies[1], pair.b_in_a);
    let direction = match rng.below(4) {
        0 => DVec3::AXES[rng.below(3)],
        1 => body.model.face_normal(rng.below(64)).map_or(DVec3::Z, |n| pose.transform_vector(-n)),
        _ => rng.unit_vector(),
    };
    let placed = Placed::new(&body.model, pose);
    let lowest = |normal: DVec3| -placed.reach(-normal);
    let near = [0.0, 1e-16, 1e-14, 1e-9, 1e-3, 1.0][rng.below(6)] * rng.between(-1.0, 1.0);
    let Ok(plane) = HalfSpace::new(direction, lowest(direction.normalize()) + near * size(body)) else { return };
    let (normal, shape) = (plane.normal(), body.shape());
    let depth = plane.offset() - lowest(normal);
    let greatest = body.model.greatest + pose.translation().length() + plane.offset().abs();
    let slack = ROUNDING_UNITS * f64::EPSILON * greatest + 2.0 * shape.support_error();
    let mut judge = Claims::new("half-spaces", tally);
    let inverse = pose.inverse();
    // Both points, where the shape has moved by `by`.
    let points = |judge: &mut Claims<'_>, [on_plane, on_b]: [DVec3; 2], by: DVec3| {
        let here = on_b - by;
        let slack = slack + ROUNDING_UNITS * f64::EPSILON * by.length();
        judge.at_most("the point is not in the shape", body.model.outside(inverse.transform_point(here)), 0.0, slack);
        judge.at_most("the point is not the lowest", here.dot(normal), plane.offset() - depth, slack);
        judge.at_most("the point is not on the plane", (on_plane.dot(normal) - plane.offset()).abs(), 0.0, slack);
        let across = (on_plane - on_b).reject_from_normalized(normal);
        judge.at_most("the points are not opposite each other", across.length(), 0.0, slack);
    };

    let (settings, mut cache) = (Settings::default(), Cache::new());
    let Contact { hit, status, depth: found, depth_lower, depth_upper, point_a, point_b, .. } =
        hullmap::contact(&plane, shape, pose, &settings, &mut cache);
    judge.tally.note(status.as_str());
    let overlap = hullmap::intersects(&plane, shape, pose, &mut cache).status;
    let by_contact = match (hit, status) {
        (false, Status::Separated) => Some(Overlap::Separated),
        (true, Status::Touching) => Some(Overlap::Touching),
        (true, Status::Exact) => Some(Overlap::Overlapping),
        _ => None,
    };
    judge.demand("contact and intersects contradict each other", by_contact == Some(overlap));
    judge.ordered("the depth is not in its interval", [depth_lower, found, depth_upper]);
    judge.at_most("the depth is below its interval", depth_lower, depth.max(0.0), slack);
    judge.at_most("the depth is above its interval", depth, depth_upper, slack);
    // The solver measures the shape from its interior point.
    let foot = inverse.transform_point(normal * plane.offset());
    let point = Pose::from_translation(foot).expect("finite");
    let rounding = Minkowski::new(shape, &Sphere::new(0.0).expect("a radius"), point).rounding_error();
    judge.at_most("the interval is wide", depth_upper - depth_lower, 2.0 * rounding, 4.0 * slack);
    points(&mut judge, [point_a, point_b], DVec3::ZERO);

    let Distance { status, distance, lower, upper, point_a, point_b, .. } =
        hullmap::distance(&plane, shape, pose, &settings, &mut cache);
    judge.ordered("the distance is not in its interval", [lower, distance, upper]);
    judge.at_most("the distance is below its interval", lower, (-depth).max(0.0), slack);
    judge.at_most("the distance is above its interval", -depth, upper, slack);
    let is_common = status == Status::Overlapping;
    points(&mut judge, [if is_common { point_b + normal * depth } else { point_a }, point_b], DVec3::ZERO);
    judge.demand("an overlap has two points", !is_common || point_a == point_b);

    judge_cast(&mut judge, &plane, pair, rng, depth, slack, &points);
    judge.finish(pair, || format!("{plane:?} at {pose:?}: depth {depth:e}, slack {slack:e}"));
}

fn judge_cast(
    judge: &mut Claims<'_>,
    plane: &HalfSpace,
    pair: &BodyPair<'_, '_>,
    rng: &mut SplitMix64,
    depth: f64,
    slack: f64,
    points: &impl Fn(&mut Claims<'_>, [DVec3; 2], DVec3),
) {
    let (body, pose, normal) = (pair.bodies[1], pair.b_in_a, plane.normal());
    let aside = normal.cross(rng.unit_vector());
    let velocity = match rng.below(4) {
        0 => aside,
        1 => aside + normal * (rng.between(-8.0, 8.0) * f64::EPSILON),
        _ => rng.unit_vector(),
    } * size(body).max(1e-9);
    let settings = CastSettings {
        max_t: if rng.below(2) == 0 { f64::INFINITY } else { rng.between(0.0, 2.0) },
        ..CastSettings::default()
    };
    let cast = |velocity: DVec3, settings: &CastSettings| {
        let motion = Motion::new(velocity).expect("finite");
        hullmap::cast(plane, body.shape(), pose, motion, settings, &mut Cache::new())
    };
    let found = cast(velocity, &settings);
    same_when_slow(judge, rng, &found, velocity, &settings, cast);
    // How far the lowest point is above the plane. The speed has a rounding error, too.
    let (speed, speed_error) = (-normal.dot(velocity), ROUNDING_UNITS * f64::EPSILON * velocity.length());
    let height = |t: f64, speed: f64| -depth - speed * t;
    if found.hit {
        judge.ordered("t is not in its interval", [found.t_lower, found.t, found.t_upper]);
        judge.demand("the lower bound is beyond the limit", found.t_lower <= settings.max_t);
        if found.t_lower > 0.0 {
            judge.at_most("below the plane too early", 0.0, height(found.t_lower, speed - speed_error), slack);
        }
        if found.status == Status::Overlapping {
            judge.demand("an overlap has two points", found.point_a == found.point_b);
            judge.at_most("the common point is not below the plane", found.point_b.dot(normal), plane.offset(), slack);
        }
        if found.status == Status::Exact {
            judge.at_most("above the plane too late", height(found.t_upper, speed + speed_error), 0.0, slack);
            points(judge, [found.point_a, found.point_b], velocity * found.t);
        }
    } else {
        let t = settings.max_t.min(f64::MAX);
        judge.at_most("a certain miss hits", 0.0, height(t, speed - speed_error), slack);
    }
    // A ray is the cast of a point.
    let origin = pose.transform_point(body.shape().interior_point());
    let line = Ray::new(origin, velocity).expect("finite");
    let (ray, dot) = (hullmap::ray(plane, &line, &settings), Sphere::new(0.0).expect("a radius"));
    let (start, motion) = (Pose::from_translation(origin).expect("finite"), Motion::new(velocity).expect("finite"));
    let twin = hullmap::cast(plane, &dot, start, motion, &settings, &mut Cache::new());
    judge.demand(
        "a ray is not the cast of a point",
        (ray.status, ray.t, ray.normal) == (twin.status, twin.t, twin.normal),
    );
}
