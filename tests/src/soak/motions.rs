//! Times of impact of the soak's pairs while both shapes move and turn.
//!
//! | claim | certificate |
//! |---|---|
//! | the shapes do not meet before `t_lower`, or at all | distances and contacts at many times |
//! | they meet by `t_upper` | the same queries at that time |
//! | at `t_lower` they are within the tolerance | the same |
//!
//! Distances and contacts have certificates of their own. Some pairs are judged at all times: by
//! intervals that are divided until a bound on the speed of all points excludes a meeting.
//!
//! At one time the pair is in a pose of the soak of pairs, so most motions graze, or lead to a
//! contact of faces or edges. The judge has the poses from rotations of its own.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use hullmap::{Cache, MotionSettings, Pose, RigidMotion, Settings, TimeOfImpact, cast_motion, contact, distance};
use shapes::rng::SplitMix64;

use super::bodies::BodyPair;
use super::body::{Body, size};
use super::claims::{Claims, ROUNDING_UNITS};
use super::tally::Tally;

/// Number of times at which the distance is judged.
const SAMPLES: usize = 12;

/// One pair in this many is judged at all times.
const WHOLE: u64 = 16;

/// Maximum number of intervals into which the time of such a pair is divided.
const INTERVALS: u32 = 400;

/// Shortest interval of time that is divided.
const SHORTEST: f64 = 1e-9;

/// The motion of a body by the judge's own definition: in `pose` at time `through`.
struct Course {
    pose: Pose,
    through: f64,
    linear: DVec3,
    /// Axis of unit length, and the angle per unit of time.
    turn: (DVec3, f64),
    /// The point about which it turns, at time `through`.
    center: DVec3,
}

impl Course {
    /// A random one. `other` is the size of the other body.
    fn random(rng: &mut SplitMix64, body: &Body<'_>, pose: Pose, through: f64, other: f64) -> Self {
        let (own, direction) = (size(body), |rng: &mut SplitMix64| DVec3::from_array(rng.direction()));
        let length = if rng.below(2) == 0 { own } else { other };
        let speed = [0.0, 0.0, 1e-3, 0.5, 4.0, 40.0][rng.below(6)] * length;
        let angle = [0.0, 0.0, 1e-4, 0.3, 0.5 * PI, PI, 7.0][rng.below(7)];
        let inside = pose.transform_point(body.shape().interior_point());
        let center = match rng.below(4) {
            0 => pose.translation(),
            1 => inside + direction(rng) * (10.0 * length * rng.unit()),
            _ => inside,
        };
        // A fifth of the screws are true ones.
        let axis = direction(rng);
        let linear = if rng.below(5) == 0 { axis } else { direction(rng) } * speed;
        Self { pose, through, linear, turn: (axis, angle), center }
    }

    fn at(&self, t: f64) -> Pose {
        let (axis, angle) = self.turn;
        let turn = DQuat::from_axis_angle(axis, angle * (t - self.through));
        let arm = self.pose.translation() - self.center;
        let place = self.center + self.linear * (t - self.through) + turn * arm;
        Pose::new(place, turn * self.pose.rotation()).expect("finite")
    }

    /// The motion as the query takes it.
    fn motion(&self) -> RigidMotion {
        let (axis, angle) = self.turn;
        let center = self.center - self.linear * self.through;
        RigidMotion::screw(self.at(0.0), self.linear, axis * angle, center).expect("finite")
    }

    /// Maximum speed of any point of the body.
    fn speed(&self, body: &Body<'_>) -> f64 {
        let inside = self.pose.transform_point(body.shape().interior_point());
        self.linear.length() + self.turn.1 * (inside.distance(self.center) + body.shape().outer_radius())
    }

    /// Greatest length from which its positions are computed.
    fn length(&self) -> f64 {
        let arm = self.pose.translation().distance(self.center);
        (self.center.length() + self.linear.length() + arm + self.pose.translation().length()) * (1.0 + self.turn.1)
    }
}

/// Whether two bodies are within the target distance.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Nearness {
    /// Surely not: the distance exceeds the target by this length.
    Apart(f64),
    /// Surely.
    Met,
    /// Rounding errors decide.
    Open,
}

struct Case<'s, 'p> {
    bodies: [&'s Body<'p>; 2],
    courses: [Course; 2],
    target: f64,
    slack: f64,
}

impl Case<'_, '_> {
    fn nearness(&self, t: f64) -> Nearness {
        let [a, b] = self.bodies.map(Body::shape);
        let [pose_a, pose_b] = [0, 1].map(|i| self.courses[i].at(t));
        let b_in_a = Pose::relative(pose_a, pose_b).expect("in range");
        let settings = Settings { tolerance: 1e-9, ..Settings::default() };
        let gap = distance(a, b, b_in_a, &settings, &mut Cache::new());
        if gap.lower > self.target + self.slack {
            return Nearness::Apart(gap.lower - self.target - self.slack);
        }
        let has_met = if self.target > 0.0 {
            gap.upper + self.slack < self.target
        } else {
            gap.distance == 0.0 && contact(a, b, b_in_a, &settings, &mut Cache::new()).depth_lower > self.slack
        };
        if has_met { Nearness::Met } else { Nearness::Open }
    }

    /// A time before `end` at which the bodies surely meet, from intervals that are divided until
    /// the speed excludes a meeting.
    fn meeting_before(&self, end: f64) -> Option<f64> {
        let speed = self.courses[0].speed(self.bodies[0]) + self.courses[1].speed(self.bodies[1]);
        let mut open = vec![(0.0, end)];
        for _ in 0..INTERVALS {
            let (from, to) = open.pop()?;
            let middle = 0.5 * (from + to);
            match self.nearness(middle) {
                Nearness::Met => return Some(middle),
                Nearness::Apart(gap) if gap > speed * 0.5 * (to - from) => {}
                _ if to - from < SHORTEST => {}
                _ => open.extend([(middle, to), (from, middle)]),
            }
        }
        None
    }
}

/// Judges the time of impact of one pair.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let [a, b] = pair.bodies;
    let through = [0.0, 1.0, rng.unit(), rng.unit()][rng.below(4)];
    // One pair in eight is far from the origin.
    let far = if rng.below(8) == 0 { DVec3::from_array(rng.direction()) * (1e4 * size(a)) } else { DVec3::ZERO };
    let world = Pose::new(far, DQuat::IDENTITY).expect("finite");
    let courses = [
        Course::random(rng, a, world, through, size(b)),
        Course::random(rng, b, world.compose(pair.b_in_a).expect("finite"), through, size(a)),
    ];
    let sizes = size(a) + size(b);
    let target = [0.0, 0.0, 0.0, 1e-3, 0.5][rng.below(5)] * sizes;
    let settings = MotionSettings { target_distance: target, ..MotionSettings::default() };
    let lengths = a.model.greatest + b.model.greatest;
    let spin = 1.0 + courses[0].turn.1 + courses[1].turn.1;
    let lengths = lengths * spin + courses[0].length() + courses[1].length();
    let slack = 4.0 * ROUNDING_UNITS * f64::EPSILON * lengths + a.shape().support_error() + b.shape().support_error();
    let case = Case { bodies: [a, b], courses, target, slack };
    let [motion_a, motion_b] = [0, 1].map(|i| case.courses[i].motion());
    let found = cast_motion(a.shape(), &motion_a, b.shape(), &motion_b, &settings, &mut Cache::new());
    let mut judge = Claims { wrong: None, tightest: 0.0, queries: "motions", tally };
    judge_times(&mut judge, &found);
    // The times at which they surely do not meet, by the answer.
    let until = if found.hit { found.t_lower } else { 1.0 };
    let spread = (0..SAMPLES).map(|i| until * (i as f64 + rng.unit()) / SAMPLES as f64);
    let near = [1.0 - 1e-9, 1.0 - 1e-6, 1.0 - 1e-3].map(|share| until * share);
    let times = spread.chain(near).chain([until, through].into_iter().filter(|t| *t <= until));
    let early = times.into_iter().filter(|_| until > 0.0).find(|t| case.nearness(*t) == Nearness::Met);
    let is_whole = pair.index.is_multiple_of(WHOLE);
    let early = early.or_else(|| (is_whole && until > 0.0).then(|| case.meeting_before(until)).flatten());
    judge.demand(if found.hit { "they meet before" } else { "they meet" }, early.is_none());
    if found.t_upper <= 1.0 {
        let nearness = case.nearness(found.t_upper);
        judge.demand("they do not meet by the upper bound", !matches!(nearness, Nearness::Apart(_)));
    }
    if found.status == hullmap::Status::Within
        && let Nearness::Apart(gap) = case.nearness(found.t_lower)
    {
        judge.at_most("not near at the lower bound", gap, settings.tolerance * sizes, 2.0 * slack);
    }
    let tally = &mut *judge.tally;
    *tally.lines.entry(found.status.as_str()).or_default() += 1;
    let many = match found.iterations {
        0..=8 => "at most 8 queries",
        9..=20 => "at most 20 queries",
        _ => "more queries",
    };
    *tally.lines.entry(many).or_default() += 1;
    tally.iterations[0] = tally.iterations[0].max(found.iterations);
    tally.support_calls[0] = tally.support_calls[0].max(found.support_calls);
    judge.finish(pair, || {
        format!("early {early:?} {settings:?}\n  {motion_a:?}\n  {motion_b:?}\n  {found:?}\n  slack {slack:e}")
    });
}

fn judge_times(judge: &mut Claims<'_>, found: &TimeOfImpact) {
    let TimeOfImpact { hit, t, t_lower, t_upper, .. } = *found;
    if hit {
        judge.demand("times out of range", (0.0..=1.0).contains(&t_lower) && (0.0..=1.0).contains(&t));
        judge.demand("times out of order", t_lower <= t && t <= t_upper);
        judge.demand("an upper bound out of range", t_upper <= 1.0 || t_upper == f64::INFINITY);
    } else {
        judge.demand("times of a miss", [t, t_lower, t_upper] == [f64::INFINITY; 3]);
    }
    judge.demand("no unit normal", (found.normal.length() - 1.0).abs() < 1e-9);
}
