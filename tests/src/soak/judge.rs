//! The certificates: the claims of the answers, tested by brute force on the shapes' definitions.
//!
//! | claim | certificate |
//! |---|---|
//! | separated | along the reported axis, the reaches leave a gap |
//! | overlapping | the reported common point is inside both, by their face planes |
//! | upper bound of the depth | along the reported normal, the reaches overlap by no more |
//! | lower bound of the depth | no tested direction separates the shapes by a shorter translation |
//! | points of a contact or of a distance | they are in their shapes, on the support planes of the normal to within the interval, and along the normal as far from each other as the interval states |
//! | lower bound of the distance | along the reported normal, the reaches leave a gap no smaller |
//! | upper bound of the distance | the reported points are inside their shapes, and no farther apart |
//!
//! The tested directions are the normals of other answers; for some pairs also all face normals,
//! and all facets of the Minkowski difference.
//!
//! Also: numbers are finite, intervals in order, statuses agree with the interval's width, and the
//! three queries do not contradict each other.

use std::hash::Hasher;

use glam::{DQuat, DVec3};
use hullmap::{
    Cache, Contact, Distance, Geometry, Intersection, Minkowski, Overlap, Pose, Settings, Status, contact, distance,
    intersects,
};
use hullmap_testkit::{
    depth::signed_depth,
    polytope::Polytope,
    reach::{Placed, Reach},
};
use twox_hash::XxHash3_64;

use super::{
    bodies::BodyPair,
    body::{Body, Solid},
    claims::{Claims, ROUNDING_UNITS},
    tally::Tally,
};

/// Tolerance of a unit vector's length.
const UNIT: f64 = 1e-14;

/// Maximum gap or depth of a pair reported as touching, maximum width of an exact interval, and
/// maximum distance of the two points that are a common one, in units of the solver's own rounding
/// error: shapes up to 16 units thick count as flat.
pub(super) const TOUCHING_ROUNDINGS: f64 = 20.0;

/// [`TOUCHING_ROUNDINGS`] in units of the greatest length times the f64 epsilon, for shapes that
/// are solved by their cores.
const TOUCHING_UNITS: f64 = 640.0;

/// Maximum distance, relative to the greatest length, of the two points of touching shapes. The
/// points of slivers lose digits.
const TOUCHING_POINTS: f64 = 1e-4;

/// Maximum gap, relative to the greatest length, of a pair reported as touching: slivers beside
/// each other in one plane. A false hit, never a missed one.
const FALSE_TOUCH: f64 = 1e-8;

/// Maximum iterations and support calls of a query: the limits of all phases together, twice,
/// because rounded shapes are solved twice.
const MAX_STEPS: u32 = 2 * 1600;

/// One pair out of this many is also checked against all face normals, and against all facets of
/// the Minkowski difference.
const FACETS_INTERVAL: u64 = 16;

/// Maximum product of the numbers of edges for which all facets are tested.
const MAX_EDGE_PAIRS: usize = 1_000_000;

/// The solver's answers about a pair.
#[derive(Clone, Copy, Debug)]
pub struct Answers {
    /// Intersection.
    pub yes: Intersection,
    /// Contact.
    pub deep: Contact,
    /// Distance.
    pub near: Distance,
}

/// The caches of a pair, one for each query.
#[derive(Default)]
pub struct Caches([Cache; 3]);

impl Answers {
    /// Queries the solver: hulls by their own type, other shapes through the trait object.
    pub fn to(a: &Body<'_>, b: &Body<'_>, b_in_a: Pose, caches: &mut Caches) -> Self {
        match (&a.solid, &b.solid) {
            (Solid::Hull(a), Solid::Hull(b)) => Self::query(a, b, b_in_a, caches),
            _ => Self::query(a.shape(), b.shape(), b_in_a, caches),
        }
    }

    fn query<A: Geometry + ?Sized, B: Geometry + ?Sized>(a: &A, b: &B, b_in_a: Pose, caches: &mut Caches) -> Self {
        let (settings, [yes, deep, near]) = (Settings::default(), &mut caches.0);
        Self {
            yes: intersects(a, b, b_in_a, yes),
            deep: contact(a, b, b_in_a, &settings, deep),
            near: distance(a, b, b_in_a, &settings, near),
        }
    }

    /// Hash of all bits, with negative zeros as positive ones.
    fn hash(&self) -> u64 {
        let mut hasher = XxHash3_64::with_seed(0);
        let Self { yes, deep, near } = self;
        hasher.write_u32(yes.status as u32);
        hasher.write_u32(deep.status as u32);
        hasher.write_u32(near.status as u32);
        for (iterations, calls) in [
            (yes.iterations, yes.support_calls),
            (deep.iterations, deep.support_calls),
            (near.iterations, near.support_calls),
        ] {
            hasher.write(&iterations.to_le_bytes());
            hasher.write(&calls.to_le_bytes());
        }
        let lengths = [deep.depth, deep.depth_lower, deep.depth_upper, near.distance, near.lower, near.upper];
        let vectors = [deep.normal, deep.point_a, deep.point_b, near.normal, near.point_a, near.point_b];
        for number in lengths.into_iter().chain(vectors.into_iter().flat_map(|v| v.to_array())) {
            hasher.write(&(number + 0.0).to_bits().to_le_bytes());
        }
        hasher.finish()
    }
}

/// Verifies all queries of a pair.
pub fn judge_pair(pair: &BodyPair<'_, '_>, tally: &mut Tally) {
    let ([a, b], index) = (pair.bodies, pair.index);
    let mut caches = Caches::default();
    let answers = Answers::to(a, b, pair.b_in_a, &mut caches);
    tally.pairs += 1;
    let counts = tally.meetings.entry(pair.meeting).or_default();
    *counts = [counts[0] + 1, counts[1] + u64::from(answers.deep.hit)];
    for body in pair.bodies {
        *tally.kinds.entry(body.kind).or_default() += 1;
    }
    let scene = Scene::new(pair, [a, b], pair.b_in_a);
    scene.judge("cold", &answers, tally, |claims| {
        if index.is_multiple_of(FACETS_INTERVAL) {
            scene.judge_by_normals(claims, &answers.deep);
            scene.judge_by_facets(claims, &answers.deep);
        }
    });
    match index % 4 {
        1 => {
            // The next frame with a warm cache: a tiny step, or a larger one.
            let step = [1e-9, 1e-3, 0.1][(index / 4 % 3) as usize];
            let reach = a.shape().outer_radius().min(b.shape().outer_radius());
            let shift = DVec3::new(0.6, -0.64, 0.48) * (step * reach);
            let turn = DQuat::from_xyzw(0.3 * step, 0.2 * step, -0.5 * step, 1.0);
            let moved = Pose::new(pair.b_in_a.translation() + shift, turn * pair.b_in_a.rotation()).expect("finite");
            let answers = Answers::to(a, b, moved, &mut caches);
            Scene::new(pair, [a, b], moved).judge("warm", &answers, tally, |_| {});
        }
        // The pair seen from B: with empty caches, or with caches of the swapped pair.
        2 | 3 => {
            let inverse = pair.b_in_a.inverse();
            let mut fresh = Caches::default();
            let caches = if index % 4 == 2 { &mut fresh } else { &mut caches };
            let mirrored = Answers::to(b, a, inverse, caches);
            let back = Scene::new(pair, [b, a], inverse);
            back.judge("mirrored", &mirrored, tally, |claims| scene.compare(claims, &answers, &mirrored, back.slack));
        }
        // Other ways to a contact: without tolerance, with few steps, by portal refinement alone.
        _ => {
            let default = Settings::default();
            let (order, settings) = [
                ("without tolerance", Settings { tolerance: 0.0, ..default }),
                ("six steps", Settings { max_iterations: 6, ..default }),
                ("portal refinement", Settings { max_iterations: 0, ..default }),
            ][(index / 4 % 3) as usize];
            let deep = contact(a.shape(), b.shape(), pair.b_in_a, &settings, &mut Cache::new());
            scene.certify(order, &Answers { deep, ..answers }, tally, |_| {});
        }
    }
}

/// Two bodies and their pose.
struct Scene<'s, 'p> {
    pair: &'s BodyPair<'s, 'p>,
    a: &'s Body<'p>,
    b: &'s Body<'p>,
    b_in_a: Pose,
    /// Tolerance of a certificate.
    slack: f64,
    /// The solver's own bound of its rounding error.
    rounding: f64,
    /// Maximum gap or depth of touching shapes.
    hair: f64,
    /// Maximum length in the query.
    reach: f64,
}

/// The part of an answer that contacts and distances have in common.
struct Evidence {
    /// 0 for a contact, 1 for a distance.
    which: usize,
    status: Status,
    normal: DVec3,
    points: [DVec3; 2],
    /// Lower bound, value and upper bound.
    interval: [f64; 3],
}

impl<'s, 'p> Scene<'s, 'p> {
    fn new(pair: &'s BodyPair<'s, 'p>, [a, b]: [&'s Body<'p>; 2], b_in_a: Pose) -> Self {
        let shift = b_in_a.translation().length();
        let slack = ROUNDING_UNITS * f64::EPSILON * (a.model.greatest + b.model.greatest + shift);
        let rounding = Minkowski::new(a.shape(), b.shape(), b_in_a).rounding_error();
        let centers = a.shape().interior_point().length() + b.shape().interior_point().length();
        let reach = a.shape().outer_radius() + b.shape().outer_radius() + centers + shift;
        let hair = TOUCHING_ROUNDINGS * rounding + TOUCHING_UNITS * f64::EPSILON * reach;
        Self { pair, a, b, b_in_a, slack, rounding, hair, reach }
    }

    /// How far A reaches along `n`, and B against it. The sum is the way out.
    fn reaches(&self, n: DVec3) -> [f64; 2] {
        [self.a.model.reach(n), Placed::new(&self.b.model, self.b_in_a).reach(-n)]
    }

    /// Counts and certifies the answers; `more` are further claims about them.
    fn judge(&self, order: &str, answers: &Answers, tally: &mut Tally, more: impl FnOnce(&mut Claims<'_>)) {
        let Answers { yes, deep, near } = answers;
        tally.judged += 1;
        tally.count(yes, deep, near);
        tally.fingerprint = tally.fingerprint.wrapping_add(answers.hash().rotate_left((self.pair.index % 63) as u32));
        self.certify(order, answers, tally, more);
    }

    /// The certificates of [`judge`](Self::judge), without the counts.
    fn certify(&self, order: &str, answers: &Answers, tally: &mut Tally, more: impl FnOnce(&mut Claims<'_>)) {
        let Answers { yes, deep, near } = answers;
        let mut claims = Claims::uncounted("pairs", tally);
        let [way_deep, way_near] = [self.judge_contact(&mut claims, deep), self.judge_distance(&mut claims, near)];
        let steps = [yes.iterations, deep.iterations, near.iterations];
        let calls = [yes.support_calls, deep.support_calls, near.support_calls];
        let most = steps.into_iter().chain(calls).max().unwrap_or(0);
        claims.demand("a limit is exceeded", most <= MAX_STEPS);

        // A claim proved by one answer must not be denied by another. Within the rounding error, a
        // hit may be false.
        let (gap, depth, hair) = (-way_deep.min(way_near), deep.depth_lower, self.hair);
        let false_touch = hair + FALSE_TOUCH * self.reach;
        let is_settled = !matches!(deep.status, Status::IterationLimit | Status::Stalled);
        for (is_claimed, what, found, limit) in [
            (depth > 0.0, "the depth's lower bound is above another way out", depth, way_near),
            (yes.status == Overlap::Separated, "intersects reports separated, contact reports a depth", depth, 0.0),
            (
                yes.status == Overlap::Overlapping,
                "intersects reports overlapping, an axis separates",
                gap,
                self.rounding,
            ),
            (near.status == Status::Overlapping, "distance reports overlapping, an axis separates", gap, self.rounding),
            (yes.status == Overlap::Touching, "intersects reports touching, an axis separates", gap, false_touch),
            (yes.status == Overlap::Touching, "intersects reports touching, contact reports a depth", depth, hair),
            (deep.hit && is_settled, "contact hits, an axis separates", gap, false_touch),
            (
                near.status == Status::Touching,
                "distance reports touching, an axis separates",
                gap,
                near.upper.max(hair),
            ),
            (near.status == Status::Touching, "distance reports touching, contact reports a depth", depth, hair),
            (near.lower > 0.0, "distance reports separated, contact reports a depth", depth, 0.0),
        ] {
            if is_claimed {
                claims.at_most(what, found, limit, self.slack);
            }
        }
        more(&mut claims);
        claims.finish(self.pair, || {
            let (slack, rounding) = (self.slack, self.rounding);
            format!(
                "{order}, at {:?}\n  {yes:?}\n  {deep:?}\n  {near:?}\n  slack {slack:e}, rounding {rounding:e}, ways out \
                 {way_deep:e} {way_near:e}",
                self.b_in_a
            )
        });
    }

    /// The normal, the points and the interval. Returns how far the shapes reach along the normal.
    fn judge_evidence(&self, claims: &mut Claims<'_>, evidence: &Evidence) -> [f64; 2] {
        let Evidence { which, normal, points: [on_a, on_b], interval: [lower, value, upper], .. } = *evidence;
        let [unit, in_a, in_b, negative, outside] = [
            [
                "the contact's normal is not of unit length",
                "the contact's point is not in A",
                "the contact's point is not in B",
                "the depth's lower bound is negative",
                "the depth is not in its interval",
            ],
            [
                "the distance's normal is not of unit length",
                "the distance's point is not in A",
                "the distance's point is not in B",
                "the distance's lower bound is negative",
                "the distance is not in its interval",
            ],
        ][which];
        claims.at_most(unit, (normal.length() - 1.0).abs(), UNIT, 0.0);
        claims.at_most(in_a, self.a.model.outside(on_a), 0.0, self.slack);
        let local_b = self.b_in_a.inverse().transform_point(on_b);
        claims.at_most(in_b, self.b.model.outside(local_b), 0.0, self.slack);
        claims.demand(negative, lower >= 0.0);
        claims.ordered(outside, [lower, value, upper]);
        self.reaches(normal)
    }

    /// The points are on the support planes of the normal.
    fn judge_surfaces(&self, claims: &mut Claims<'_>, evidence: &Evidence, reaches: [f64; 2], slack: f64) {
        let Evidence { which, normal, points: [on_a, on_b], interval: [lower, _, upper], .. } = *evidence;
        let [of_a, of_b] = [
            ["the contact's point is not on the surface of A", "the contact's point is not on the surface of B"],
            ["the distance's point is not on the surface of A", "the distance's point is not on the surface of B"],
        ][which];
        claims.at_most(of_a, reaches[0] - normal.dot(on_a), upper - lower, slack);
        claims.at_most(of_b, reaches[1] + normal.dot(on_b), upper - lower, slack);
    }

    /// The interval is as narrow as the status says.
    fn judge_width(&self, claims: &mut Claims<'_>, evidence: &Evidence) {
        let Evidence { which, status, interval: [lower, value, upper], .. } = *evidence;
        let [exact, within, touching] = [
            ["an exact depth is wide", "a depth is wider than its status", "touching has a depth"],
            ["an exact distance is wide", "a distance is wider than its status", "touching has a distance"],
        ][which];
        let (width, hair) = (upper - lower, self.hair);
        match status {
            Status::Exact => claims.at_most(exact, width, hair, self.slack),
            Status::Within => claims.at_most(within, width, Settings::DEFAULT_TOLERANCE * upper + hair, self.slack),
            Status::Touching => {
                claims.demand(touching, value + lower <= 0.0);
                let far = if which == 0 { 0.0 } else { TOUCHING_POINTS * self.reach };
                claims.at_most("touching is deep or far", upper, hair + far, self.slack);
            }
            _ => {}
        }
    }

    /// The contact's own claims. Returns the way out along its normal.
    fn judge_contact(&self, claims: &mut Claims<'_>, c: &Contact) -> f64 {
        let (slack, hair) = (self.slack, self.hair);
        let interval = [c.depth_lower, c.depth, c.depth_upper];
        let points = [c.point_a, c.point_b];
        let evidence = Evidence { which: 0, status: c.status, normal: c.normal, points, interval };
        let reaches = self.judge_evidence(claims, &evidence);
        let way = reaches[0] + reaches[1];
        if !c.hit {
            claims.at_most("the contact's axis does not separate", way, 0.0, slack);
            claims.demand("a miss has a depth", interval.iter().all(|depth| *depth <= 0.0));
            claims.demand("a miss has another status than separated", c.status == Status::Separated);
            return way;
        }
        claims.demand("a hit has an impossible status", !matches!(c.status, Status::Separated | Status::Overlapping));
        claims.at_most("the contact's normal is not the way out", way, c.depth_upper, slack);
        let width = c.depth_upper - c.depth_lower;
        let between = c.point_a - c.point_b;
        let (along, slack_along) = (between.dot(c.normal), slack + 2.0 * self.rounding);
        claims.at_most("the contact's points are deeper than the depth", along, c.depth_upper, slack_along);
        if c.depth_lower > 0.0 {
            claims.at_most("the depth's lower bound is above the way out", c.depth_lower, way, slack);
            claims.at_most("the contact's points are less deep than the depth", c.depth_lower, along, slack_along);
        }
        // Points of a pair that may not penetrate may be farther from the surfaces than the depth.
        let settled = matches!(c.status, Status::Exact | Status::Within);
        if c.depth_lower > 0.0 || settled || c.status == Status::Touching {
            self.judge_surfaces(claims, &evidence, reaches, if settled { slack_along } else { slack + hair });
        }
        let beside = between.distance(c.normal * along);
        if settled {
            claims.at_most("the contact's points are not opposite each other", beside, width, slack_along);
        } else if c.status == Status::Touching {
            claims.at_most("the points of a touch are apart", between.length(), width, slack + hair);
        }
        self.judge_width(claims, &evidence);
        way
    }

    /// The distance's own claims. Returns the way out along its normal.
    fn judge_distance(&self, claims: &mut Claims<'_>, d: &Distance) -> f64 {
        let slack = self.slack;
        let (interval, points) = ([d.lower, d.distance, d.upper], [d.point_a, d.point_b]);
        let evidence = Evidence { which: 1, status: d.status, normal: d.normal, points, interval };
        let reaches = self.judge_evidence(claims, &evidence);
        let way = reaches[0] + reaches[1];
        let between = d.point_b - d.point_a;
        let (apart, along, slack_along) = (between.length(), between.dot(d.normal), slack + 2.0 * self.rounding);
        if d.status == Status::Overlapping {
            claims.demand("an overlap has a distance", d.upper <= 0.0);
            claims.at_most("the common point is two", apart, self.hair, slack);
            return way;
        }
        claims.demand("a distance has an impossible status", d.status != Status::Separated);
        claims.at_most("the distance's points are farther apart than its upper bound", apart, d.upper, slack);
        claims.at_most("the distance's points are nearer than its lower bound", d.lower, apart, slack);
        // The balls around the shapes give another bound.
        let (a, b) = (self.a.shape(), self.b.shape());
        let centers = a.interior_point().distance(self.b_in_a.transform_point(b.interior_point()));
        let by_balls = centers - a.outer_radius() - b.outer_radius();
        if d.lower > 0.0 {
            claims.at_most("the distance's points are nearer along the normal", d.lower, along, slack_along);
            claims.at_most("the distance's lower bound is above the planes' gap", d.lower, (-way).max(by_balls), slack);
        }
        // The normal comes from planes, unless the balls prove the bound.
        if matches!(d.status, Status::Exact | Status::Within) && d.lower > by_balls.max(0.0) {
            self.judge_surfaces(claims, &evidence, reaches, slack_along);
        }
        self.judge_width(claims, &evidence);
        way
    }

    /// The depth against the ways out along all face normals.
    fn judge_by_normals(&self, claims: &mut Claims<'_>, deep: &Contact) {
        claims.tally.normals += 1;
        let of_b = self.b.model.face_normals().map(|n| -self.b_in_a.transform_vector(n));
        for n in self.a.model.face_normals().chain(of_b).filter(|_| deep.depth_lower > 0.0) {
            let way = self.reaches(n).iter().sum();
            claims.at_most("the depth's lower bound is above a face's way out", deep.depth_lower, way, self.slack);
        }
    }

    /// The depth against all facets of the Minkowski difference. The upper bound and a miss have
    /// their own certificates. The facets' normals are not all directions if a polygon is flat only
    /// up to rounding.
    fn judge_by_facets(&self, claims: &mut Claims<'_>, deep: &Contact) {
        let (Solid::Hull(a), Solid::Hull(b)) = (&self.a.solid, &self.b.solid) else { return };
        if a.rank() < 2 || b.rank() < 2 {
            return;
        }
        let (a, b) = (Polytope::new(a), Polytope::new(b).placed(self.b_in_a));
        if a.edges.len() * b.edges.len() > MAX_EDGE_PAIRS {
            return;
        }
        claims.tally.facets += 1;
        let (depth, _) = signed_depth(&a, &b, -4.0 * self.slack);
        if deep.hit {
            claims.at_most("the depth differs from the facets'", deep.depth_lower, depth.max(0.0), self.slack);
        }
        if deep.hit && !matches!(deep.status, Status::IterationLimit | Status::Stalled) {
            claims.at_most("contact hits, a facet separates", -depth, self.hair + FALSE_TOUCH * self.reach, 0.0);
        }
    }

    /// The same pair seen from the other side: the intervals have a point in common.
    fn compare(&self, claims: &mut Claims<'_>, here: &Answers, there: &Answers, slack_back: f64) {
        let slack = self.slack + slack_back;
        let depth = |answers: &Answers| [answers.deep.depth_lower, answers.deep.depth_upper];
        let gap = |answers: &Answers| [answers.near.lower, answers.near.upper];
        for (what, p, q) in [
            ("the mirrored depth differs", depth(here), depth(there)),
            ("the mirrored distance differs", gap(here), gap(there)),
        ] {
            claims.at_most(what, p[0].max(q[0]), p[1].min(q[1]), slack);
        }
        let is_clear = here.deep.depth_lower.max(there.deep.depth_lower) > self.hair;
        claims.demand("the mirrored contact differs", here.deep.hit == there.deep.hit || !is_clear);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soak::bodies::{Bodies, Stock};

    /// Changed answers are wrong: the certificates are no formality.
    #[test]
    fn wrong_answers_are_found() {
        let stock = Stock::bake(&[], 1);
        let bodies = Bodies::new(&stock);
        let (mut hits, mut apart) = (0, 0);
        for index in 0..600 {
            let pair = bodies.pair(20_261_121, index);
            let [a, b] = pair.bodies;
            let right = Answers::to(a, b, pair.b_in_a, &mut Caches::default());
            let scene = Scene::new(&pair, [a, b], pair.b_in_a);
            let wrong = |change: &dyn Fn(&mut Answers)| {
                let (mut answers, mut tally) = (right, Tally::default());
                change(&mut answers);
                scene.certify("changed", &answers, &mut tally, |_| {});
                !tally.wrong.is_empty()
            };
            assert!(!wrong(&|_| {}), "{pair}");
            // Far from touching, compared with the tolerance of the certificates.
            let clear = 1e5 * (scene.slack + scene.hair);
            if right.deep.depth_lower > clear && right.deep.status == Status::Exact {
                hits += 1;
                assert!(wrong(&|answers| answers.deep.hit = false), "{pair}");
                for factor in [1.0 - 1e-3, 1.0 + 1e-3] {
                    let scale = |c: &mut Contact| {
                        (c.depth_lower, c.depth) = (c.depth_lower * factor, c.depth * factor);
                        c.depth_upper *= factor;
                    };
                    assert!(wrong(&|answers| scale(&mut answers.deep)), "{pair}: a depth times {factor}");
                }
            } else if right.near.lower > clear && right.near.status == Status::Exact {
                apart += 1;
                assert!(wrong(&|answers| answers.deep.normal = -answers.deep.normal), "{pair}");
                for factor in [1.0 - 1e-3, 1.0 + 1e-3] {
                    let scale = |d: &mut Distance| {
                        (d.lower, d.distance, d.upper) = (d.lower * factor, d.distance * factor, d.upper * factor);
                    };
                    assert!(wrong(&|answers| scale(&mut answers.near)), "{pair}: a distance times {factor}");
                }
            }
        }
        assert!(hits > 50 && apart > 30, "{hits} {apart}");
    }
}
