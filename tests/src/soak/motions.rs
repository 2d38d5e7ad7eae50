//! Times of impact of the soak's pairs while both shapes move and turn.
//!
//! | claim | certificate |
//! |---|---|
//! | the shapes do not meet before `t_lower`, or at all | distances and contacts at many times |
//! | they meet by `t_upper` | the same queries at that time |
//! | at `t_lower` they are within the tolerance | the same |
//! | a motion is free, with a clearance | the distance at the same times |
//!
//! Distances and contacts have certificates of their own. Some pairs are judged at all times: by
//! intervals that are divided until a bound on the speed of all points excludes a meeting.
//!
//! One query in four is about a half-space and a shape.
//!
//! At one time the pair is in a pose of the soak of pairs, so most motions graze, or lead to a
//! contact of faces or edges. The judge computes the poses by rotations of its own.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use hullmap::shapes::HalfSpace;
use hullmap::{
    Cache, ClearSettings, Contact, Distance, MotionSettings, Pose, RigidMotion, Settings, TimeOfImpact, Verdict,
    cast_motion, clear,
};
use hullmap_testkit::{
    random::RandomPoses,
    reach::{Placed, Reach},
};
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
        let length = if rng.below(2) == 0 { size(body) } else { other };
        let speed = [0.0, 0.0, 1e-3, 0.5, 4.0, 40.0][rng.below(6)] * length;
        let angle = [0.0, 0.0, 1e-4, 0.3, 0.5 * PI, PI, 7.0][rng.below(7)];
        let inside = pose.transform_point(body.shape().interior_point());
        let center = match rng.below(4) {
            0 => pose.translation(),
            1 => inside + rng.unit_vector() * (10.0 * length * rng.unit()),
            _ => inside,
        };
        // A fifth of the screws are true ones.
        let axis = rng.unit_vector();
        let linear = if rng.below(5) == 0 { axis } else { rng.unit_vector() } * speed;
        Self { pose, through, linear, turn: (axis, angle), center }
    }

    fn pose_at(&self, t: f64) -> Pose {
        let (axis, angle) = self.turn;
        let turn = DQuat::from_axis_angle(axis, angle * (t - self.through));
        let arm = self.pose.translation() - self.center;
        let place = self.center + self.linear * (t - self.through) + turn * arm;
        Pose::new(place, turn * self.pose.rotation()).expect("finite")
    }

    /// The point about which it turns, at time 0.
    fn center_at_start(&self) -> DVec3 {
        self.center - self.linear * self.through
    }

    /// The motion as the query takes it.
    fn motion(&self) -> RigidMotion {
        let (axis, angle) = self.turn;
        RigidMotion::screw(self.pose_at(0.0), self.linear, axis * angle, self.center_at_start()).expect("finite")
    }

    /// Maximum speed of any point of the body.
    fn speed(&self, body: &Body<'_>) -> f64 {
        let inside = self.pose.transform_point(body.shape().interior_point());
        self.linear.length() + self.turn.1 * (inside.distance(self.center) + body.shape().outer_radius())
    }

    /// Greatest length from which the judge computes positions.
    fn length(&self) -> f64 {
        (self.center.length() + self.linear.length() + self.arm() + self.pose.translation().length())
            * (1.0 + self.turn.1)
    }

    /// The lengths from which the query computes positions, in a frame at `origin`: c, v and the
    /// arm of docs/contributors/intervals.md, section 15. From there, c may be farther away than in
    /// the world.
    fn length_of_query(&self, origin: DVec3) -> f64 {
        self.center_at_start().distance(origin) + self.linear.length() + self.arm()
    }

    fn arm(&self) -> f64 {
        self.pose.translation().distance(self.center)
    }
}

/// Settings of the judge's queries.
const ACCURATE: Settings = Settings { tolerance: 1e-9, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

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
    /// In place of A.
    plane: Option<HalfSpace>,
    courses: [Course; 2],
    target: f64,
    slack: f64,
}

impl Case<'_, '_> {
    fn b_in_a(&self, t: f64) -> Pose {
        Pose::relative(self.courses[0].pose_at(t), self.courses[1].pose_at(t)).expect("in range")
    }

    fn distance(&self, t: f64) -> Distance {
        let ([a, b], cache) = (self.bodies.map(Body::shape), &mut Cache::new());
        match &self.plane {
            Some(plane) => hullmap::distance(plane, b, self.b_in_a(t), &ACCURATE, cache),
            None => hullmap::distance(a, b, self.b_in_a(t), &ACCURATE, cache),
        }
    }

    fn contact(&self, t: f64) -> Contact {
        let ([a, b], cache) = (self.bodies.map(Body::shape), &mut Cache::new());
        match &self.plane {
            Some(plane) => hullmap::contact(plane, b, self.b_in_a(t), &ACCURATE, cache),
            None => hullmap::contact(a, b, self.b_in_a(t), &ACCURATE, cache),
        }
    }

    fn nearness(&self, t: f64) -> Nearness {
        let gap = self.distance(t);
        if gap.lower > self.target + self.slack {
            return Nearness::Apart(gap.lower - self.target - self.slack);
        }
        let has_met = if self.target > 0.0 {
            gap.upper + self.slack < self.target
        } else {
            gap.distance == 0.0 && self.contact(t).depth_lower > self.slack
        };
        if has_met { Nearness::Met } else { Nearness::Open }
    }

    /// Upper bound of the speed at which the bodies can approach each other.
    fn speed(&self) -> f64 {
        let [a, b] = &self.courses;
        let speed_b = b.speed(self.bodies[1]);
        match &self.plane {
            // The speed of the plane where B is.
            Some(_) => {
                let far = a.center.distance(b.center) + a.linear.length() + b.linear.length();
                let inside = b.pose.transform_point(self.bodies[1].shape().interior_point());
                let reach = far + inside.distance(b.center) + self.bodies[1].shape().outer_radius();
                a.linear.length() + a.turn.1 * reach + speed_b
            }
            None => a.speed(self.bodies[0]) + speed_b,
        }
    }

    /// The answers of both queries.
    fn answers(&self, settings: &MotionSettings) -> (TimeOfImpact, Option<hullmap::Clearance>) {
        let ([a, b], [motion_a, motion_b]) = (self.bodies.map(Body::shape), self.motions());
        if let Some(plane) = &self.plane {
            return (cast_motion(plane, &motion_a, b, &motion_b, settings, &mut Cache::new()), None);
        }
        let found = cast_motion(a, &motion_a, b, &motion_b, settings, &mut Cache::new());
        let settings = ClearSettings { motion: *settings, ..ClearSettings::default() };
        (found, Some(clear(a, &motion_a, b, &motion_b, &settings, &mut Cache::new())))
    }

    fn motions(&self) -> [RigidMotion; 2] {
        [self.courses[0].motion(), self.courses[1].motion()]
    }

    /// A time before `end` at which the bodies certainly meet, from intervals that are divided
    /// until the speed excludes a meeting.
    fn meeting_before(&self, end: f64) -> Option<f64> {
        let speed = self.speed();
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
    let far = if rng.below(8) == 0 { rng.unit_vector() * (1e4 * size(a)) } else { DVec3::ZERO };
    let world = Pose::new(far, DQuat::IDENTITY).expect("finite");
    let courses = [
        Course::random(rng, a, world, through, size(b)),
        Course::random(rng, b, world.compose(pair.b_in_a).expect("finite"), through, size(a)),
    ];
    // A plane that touches B, nearly, when the pair is in its pose.
    let plane = (rng.below(4) == 0).then(|| {
        let normal = rng.unit_vector();
        let lowest = -Placed::new(&b.model, pair.b_in_a).reach(-normal);
        let near = [0.0, 1e-12, 1e-6, 1e-2, 1.0][rng.below(5)] * rng.between(-1.0, 1.0);
        HalfSpace::new(normal, lowest + near * size(b)).ok()
    });
    let plane = plane.flatten();
    let sizes = if plane.is_some() { size(b) } else { size(a) + size(b) };
    let target = [0.0, 0.0, 0.0, 1e-3, 0.5][rng.below(5)] * sizes;
    let settings = MotionSettings { target_distance: target, ..MotionSettings::default() };
    let models = a.model.greatest + b.model.greatest + plane.map_or(0.0, |plane| plane.offset().abs());
    let spin = 1.0 + courses[0].turn.1 + courses[1].turn.1;
    let lengths = models * spin + courses[0].length() + courses[1].length();
    let unit = 4.0 * ROUNDING_UNITS * f64::EPSILON;
    let slack = unit * lengths + a.shape().support_error() + b.shape().support_error();
    // The search ends where the excess is at most 2.5 of its noises. A noise is at most
    // (280 + 2 θ) ε of the query's lengths, with angles θ of at most 7: the excess is at most 735 ε
    // of them.
    let start = courses[1].pose_at(0.0).translation();
    let of_query = models + courses[0].length_of_query(start) + courses[1].length_of_query(start);
    let last = (3.0 * unit * of_query).max(3.0 * slack);
    let case = Case { bodies: [a, b], plane, courses, target, slack };
    let (found, clearance) = case.answers(&settings);
    let mut judge = Claims::new("motions", tally);
    judge_times(&mut judge, &found);
    // The times at which they certainly do not meet, by the answer.
    let until = if found.hit { found.t_lower } else { 1.0 };
    let spread = (0..SAMPLES).map(|i| until * (i as f64 + rng.unit()) / SAMPLES as f64);
    let near = [1.0 - 1e-9, 1.0 - 1e-6, 1.0 - 1e-3].map(|share| until * share);
    let times = spread.chain(near).chain([until, through].into_iter().filter(|t| *t <= until));
    let times: Vec<f64> = times.filter(|_| until > 0.0).collect();
    let early = times.iter().copied().find(|t| case.nearness(*t) == Nearness::Met);
    if let Some(clearance) = clearance {
        let [is_free, is_met] = [Verdict::Free, Verdict::Hit].map(|verdict| clearance.verdict == verdict);
        judge.demand("clear and cast_motion contradict each other", is_free != found.hit);
        judge.demand("a hit without an upper bound", is_met == (found.t_upper <= 1.0));
        let nearer = times.iter().map(|t| case.distance(*t).upper).fold(f64::INFINITY, f64::min);
        judge.demand("nearer than the clearance", !is_free || clearance.clearance <= nearer + slack);
        judge.demand("a clearance below the margin", !is_free || clearance.clearance >= target);
        judge.demand("an interval without lengths", !is_free || clearance.clearance <= clearance.nearest);
    }
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
        judge.at_most("not near at the lower bound", gap + slack, settings.tolerance * sizes, last);
    }
    judge.tally.note(found.status.as_str());
    let many = match found.iterations {
        0..=8 => "at most 8 queries",
        9..=20 => "at most 20 queries",
        _ => "more queries",
    };
    judge.tally.note(many);
    judge.tally.iterations[0] = judge.tally.iterations[0].max(found.iterations);
    judge.tally.support_calls[0] = judge.tally.support_calls[0].max(found.support_calls);
    if case.plane.is_some() {
        judge.tally.note("half-spaces");
    }
    judge.finish(pair, || {
        let ([motion_a, motion_b], plane) = (case.motions(), &case.plane);
        format!(
            "early {early:?} {settings:?} {plane:?}\n  {motion_a:?}\n  {motion_b:?}\n  {found:?} {clearance:?}\n  slack {slack:e}"
        )
    });
}

fn judge_times(judge: &mut Claims<'_>, found: &TimeOfImpact) {
    let TimeOfImpact { hit, t, t_lower, t_upper, .. } = *found;
    if hit {
        judge.demand("times out of range", (0.0..=1.0).contains(&t_lower) && (0.0..=1.0).contains(&t));
        judge.ordered("times out of order", [t_lower, t, t_upper]);
        judge.demand("an upper bound out of range", t_upper <= 1.0 || t_upper == f64::INFINITY);
    } else {
        judge.demand("times of a miss", [t, t_lower, t_upper] == [f64::INFINITY; 3]);
    }
    judge.demand("no unit normal", (found.normal.length() - 1.0).abs() < 1e-9);
}
