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

use glam::{DMat3, DVec3};
use hullmap::{
    Cache, Contact, Distance, Geometry, Intersection, Minkowski, Overlap, Pose, Settings, Status, contact, distance,
    intersects,
};
use hullmap_testkit::{
    depth::signed_depth,
    polytope::Polytope,
    reach::{Placed, Reach, way_out},
};
use twox_hash::XxHash3_64;

use super::{
    bodies::BodyPair,
    body::{Any, Body, Solid},
    tally::{Tally, Wrong},
};

/// Rounding error of a certificate, in units of the greatest lengths times the f64 epsilon: a
/// rotated direction or point has an error of about 40, a dot product of a few, on each shape.
const ROUNDING_UNITS: f64 = 64.0;

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
        for count in [
            yes.iterations,
            yes.support_calls,
            deep.iterations,
            deep.support_calls,
            near.iterations,
            near.support_calls,
        ] {
            hasher.write(&count.to_le_bytes());
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
    let scene = Scene::new(a, b, pair.b_in_a);
    scene.judge(pair, "cold", &answers, tally);
    if index.is_multiple_of(FACETS_INTERVAL) {
        scene.judge_by_normals(pair, &answers, tally);
        scene.judge_by_facets(pair, &answers, tally);
    }
    match index % 4 {
        1 => {
            // The next frame with a warm cache: a tiny step, or a larger one.
            let step = [1e-9, 1e-3, 0.1][(index / 4 % 3) as usize];
            let reach = a.shape().outer_radius().min(b.shape().outer_radius());
            let shift = DVec3::new(0.6, -0.64, 0.48) * (step * reach);
            let turn = glam::DQuat::from_xyzw(0.3 * step, 0.2 * step, -0.5 * step, 1.0);
            let moved = Pose::new(pair.b_in_a.translation() + shift, turn * pair.b_in_a.rotation()).expect("finite");
            let answers = Answers::to(a, b, moved, &mut caches);
            Scene::new(a, b, moved).judge(pair, "warm", &answers, tally);
        }
        // The pair seen from B: with empty caches, or with caches of the swapped pair.
        2 | 3 => {
            let inverse = pair.b_in_a.inverse();
            let mut fresh = Caches::default();
            let caches = if index % 4 == 2 { &mut fresh } else { &mut caches };
            let mirrored = Answers::to(b, a, inverse, caches);
            let back = Scene::new(b, a, inverse);
            back.judge(pair, "mirrored", &mirrored, tally);
            scene.compare(pair, &answers, &mirrored, &back, tally);
        }
        // Other ways to a contact: without tolerance, with few steps, by portal refinement alone.
        _ => {
            let (order, deep) = other_contact(a.shape(), b.shape(), pair.b_in_a, index / 4);
            scene.certify(pair, order, &Answers { deep, ..answers }, tally);
        }
    }
}

/// A contact of the pair by a way that depends on `index`, and its name.
fn other_contact(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, index: u64) -> (&'static str, Contact) {
    let with = |settings: Settings| contact(a, b, b_in_a, &settings, &mut Cache::new());
    match index % 3 {
        0 => ("without tolerance", with(Settings { tolerance: 0.0, ..Settings::default() })),
        1 => ("six steps", with(Settings { max_iterations: 6, ..Settings::default() })),
        _ => ("portal refinement", with(Settings { max_iterations: 0, ..Settings::default() })),
    }
}

/// Two bodies and their pose.
struct Scene<'s, 'p> {
    a: &'s Body<'p>,
    b: &'s Body<'p>,
    b_in_a: Pose,
    turn: DMat3,
    unturn: DMat3,
    shift: DVec3,
    /// Tolerance of a certificate.
    slack: f64,
    /// The solver's own bound of its rounding error.
    rounding: f64,
    /// Maximum gap or depth of touching shapes.
    hair: f64,
    /// Maximum length in the query.
    reach: f64,
}

impl<'s, 'p> Scene<'s, 'p> {
    fn new(a: &'s Body<'p>, b: &'s Body<'p>, b_in_a: Pose) -> Self {
        let (turn, shift) = (DMat3::from_quat(b_in_a.rotation()), b_in_a.translation());
        let slack = ROUNDING_UNITS * f64::EPSILON * (a.model.greatest + b.model.greatest + shift.length());
        let rounding = Minkowski::new(a.shape(), b.shape(), b_in_a).rounding_error();
        let centers = a.shape().interior_point().length() + b.shape().interior_point().length();
        let reach = a.shape().outer_radius() + b.shape().outer_radius() + centers + shift.length();
        let hair = TOUCHING_ROUNDINGS * rounding + TOUCHING_UNITS * f64::EPSILON * reach;
        Self { a, b, b_in_a, turn, unturn: turn.transpose(), shift, slack, rounding, hair, reach }
    }

    /// How far A reaches along `n`, and B against it. The sum is the way out.
    fn reaches(&self, n: DVec3) -> [f64; 2] {
        [self.a.model.reach(n), Placed::new(&self.b.model, self.b_in_a).reach(-n)]
    }

    fn way_out(&self, n: DVec3) -> f64 {
        way_out(&self.a.model, &Placed::new(&self.b.model, self.b_in_a), n)
    }

    /// Distance of a point of A's frame from A.
    fn outside_a(&self, p: DVec3) -> f64 {
        self.a.model.outside(p)
    }

    fn outside_b(&self, p: DVec3) -> f64 {
        self.b.model.outside(self.unturn * (p - self.shift))
    }

    fn wrong(
        &self,
        pair: &BodyPair<'_, '_>,
        what: &'static str,
        order: &str,
        answers: &Answers,
        more: String,
        tally: &mut Tally,
    ) {
        let Answers { yes, deep, near } = answers;
        let (slack, rounding) = (self.slack, self.rounding);
        let details = format!(
            "{pair}\n  {order}, at {:?}\n  {yes:?}\n  {deep:?}\n  {near:?}\n  slack {slack:e}, rounding {rounding:e}, {more}",
            self.b_in_a
        );
        tally.take_wrong(Wrong { index: pair.index, what, details });
    }

    fn judge(&self, pair: &BodyPair<'_, '_>, order: &str, answers: &Answers, tally: &mut Tally) {
        let Answers { yes, deep, near } = answers;
        tally.judged += 1;
        tally.count(yes, deep, near);
        tally.fingerprint = tally.fingerprint.wrapping_add(answers.hash().rotate_left((pair.index % 63) as u32));
        self.certify(pair, order, answers, tally);
    }

    /// The certificates of [`judge`](Self::judge), without the counts.
    fn certify(&self, pair: &BodyPair<'_, '_>, order: &str, answers: &Answers, tally: &mut Tally) {
        let Answers { yes, deep, near } = answers;
        let mut tightest = 0.0_f64;
        let mut wrong: Option<(&'static str, f64, f64)> = None;
        // NaN takes the failing branch.
        let mut at_most = |what: &'static str, found: f64, limit: f64, slack: f64| {
            if !(found <= limit + slack) {
                wrong.get_or_insert((what, found, limit));
            } else if slack > 0.0 {
                tightest = tightest.max((found - limit) / slack);
            }
        };
        let slack = self.slack;
        let [way_deep, way_near] = [self.judge_contact(deep, &mut at_most), self.judge_distance(near, &mut at_most)];
        for counts in [
            [yes.iterations, yes.support_calls],
            [deep.iterations, deep.support_calls],
            [near.iterations, near.support_calls],
        ] {
            at_most("a limit is exceeded", counts[0].max(counts[1]).into(), MAX_STEPS.into(), 0.0);
        }

        // A claim proved by one answer must not be denied by another.
        let gap = -way_deep.min(way_near);
        let depth_lower = deep.depth_lower;
        if depth_lower > 0.0 {
            at_most("the depth's lower bound is above another way out", depth_lower, way_near, slack);
        }
        if yes.status == Overlap::Separated {
            at_most("intersects reports separated, contact reports a depth", depth_lower, 0.0, slack);
        }
        if yes.status == Overlap::Overlapping {
            at_most("intersects reports overlapping, an axis separates", gap, self.rounding, slack);
        }
        if near.status == Status::Overlapping {
            at_most("distance reports overlapping, an axis separates", gap, self.rounding, slack);
        }
        // Within the rounding error, a hit may be false.
        let hair = self.hair;
        if yes.status == Overlap::Touching {
            at_most("intersects reports touching, an axis separates", gap, hair + FALSE_TOUCH * self.reach, slack);
            at_most("intersects reports touching, contact reports a depth", depth_lower, hair, slack);
        }
        if deep.hit && !matches!(deep.status, Status::IterationLimit | Status::Stalled) {
            at_most("contact hits, an axis separates", gap, hair + FALSE_TOUCH * self.reach, slack);
        }
        if near.status == Status::Touching {
            at_most("distance reports touching, an axis separates", gap, near.upper.max(hair), slack);
            at_most("distance reports touching, contact reports a depth", depth_lower, hair, slack);
        }
        if near.lower > 0.0 {
            at_most("distance reports separated, contact reports a depth", depth_lower, 0.0, slack);
        }
        tally.tightest = tally.tightest.max(tightest);
        if let Some((what, found, limit)) = wrong {
            let more = format!("found {found:e}, limit {limit:e}, ways out {way_deep:e} {way_near:e}");
            self.wrong(pair, what, order, answers, more, tally);
        }
    }

    /// The contact's own claims. Returns the way out along its normal.
    fn judge_contact(&self, c: &Contact, at_most: &mut impl FnMut(&'static str, f64, f64, f64)) -> f64 {
        let slack = self.slack;
        let reaches = self.reaches(c.normal);
        let way = reaches[0] + reaches[1];
        at_most("the contact's normal is not of unit length", (c.normal.length() - 1.0).abs(), UNIT, 0.0);
        at_most("the contact's point is not in A", self.outside_a(c.point_a), 0.0, slack);
        at_most("the contact's point is not in B", self.outside_b(c.point_b), 0.0, slack);
        if !c.hit {
            at_most("the contact's axis does not separate", way, 0.0, slack);
            at_most("a miss has a depth", c.depth.max(c.depth_lower).max(c.depth_upper), 0.0, 0.0);
            at_most("a miss has another status than separated", f64::from(c.status != Status::Separated), 0.0, 0.0);
            return way;
        }
        let impossible = matches!(c.status, Status::Separated | Status::Overlapping);
        at_most("a hit has an impossible status", f64::from(impossible), 0.0, 0.0);
        at_most("the depth's lower bound is negative", -c.depth_lower, 0.0, 0.0);
        at_most("the depth is not in its interval", c.depth_lower, c.depth, 0.0);
        at_most("the depth is not in its interval", c.depth, c.depth_upper, 0.0);
        at_most("the contact's normal is not the way out", way, c.depth_upper, slack);
        if c.depth_lower > 0.0 {
            at_most("the depth's lower bound is above the way out", c.depth_lower, way, slack);
        }
        let (width, hair) = (c.depth_upper - c.depth_lower, self.hair);
        let between = c.point_a - c.point_b;
        let (along, slack_along) = (between.dot(c.normal), slack + 2.0 * self.rounding);
        at_most("the contact's points are deeper than the depth", along, c.depth_upper, slack_along);
        if c.depth_lower > 0.0 {
            at_most("the contact's points are less deep than the depth", c.depth_lower, along, slack_along);
        }
        // Points of a pair that may not penetrate may be farther from the surfaces than the depth.
        let settled = matches!(c.status, Status::Exact | Status::Within);
        if c.depth_lower > 0.0 || settled || c.status == Status::Touching {
            let slack = if settled { slack_along } else { slack + hair };
            for (what, inside) in [
                ("the contact's point is not on the surface of A", reaches[0] - c.normal.dot(c.point_a)),
                ("the contact's point is not on the surface of B", reaches[1] + c.normal.dot(c.point_b)),
            ] {
                at_most(what, inside, width, slack);
            }
        }
        let beside = between.distance(c.normal * along);
        match c.status {
            Status::Exact | Status::Within => {
                at_most("the contact's points are not opposite each other", beside, width, slack_along);
            }
            Status::Touching => at_most("the points of a touch are apart", between.length(), width, slack + hair),
            // The status states this.
            _ => {}
        }
        match c.status {
            Status::Exact => at_most("an exact depth is wide", width, hair, slack),
            Status::Within => {
                at_most(
                    "a depth is wider than its status",
                    width,
                    Settings::DEFAULT_TOLERANCE * c.depth_upper + hair,
                    slack,
                );
            }
            Status::Touching => {
                at_most("touching has a depth", c.depth + c.depth_lower, 0.0, 0.0);
                at_most("touching is deep", c.depth_upper, hair, slack);
            }
            _ => {}
        }
        way
    }

    /// The distance's own claims. Returns the way out along its normal.
    fn judge_distance(&self, d: &Distance, at_most: &mut impl FnMut(&'static str, f64, f64, f64)) -> f64 {
        let slack = self.slack;
        let reaches = self.reaches(d.normal);
        let way = reaches[0] + reaches[1];
        at_most("the distance's normal is not of unit length", (d.normal.length() - 1.0).abs(), UNIT, 0.0);
        at_most("the distance's point is not in A", self.outside_a(d.point_a), 0.0, slack);
        at_most("the distance's point is not in B", self.outside_b(d.point_b), 0.0, slack);
        at_most("the distance's lower bound is negative", -d.lower, 0.0, 0.0);
        at_most("the distance is not in its interval", d.lower, d.distance, 0.0);
        at_most("the distance is not in its interval", d.distance, d.upper, 0.0);
        let between = d.point_b - d.point_a;
        let (apart, along, slack_along) = (between.length(), between.dot(d.normal), slack + 2.0 * self.rounding);
        match d.status {
            Status::Overlapping => {
                at_most("an overlap has a distance", d.upper, 0.0, 0.0);
                at_most("the common point is two", apart, self.hair, slack);
                return way;
            }
            Status::Separated => at_most("a distance has an impossible status", 1.0, 0.0, 0.0),
            _ => {}
        }
        at_most("the distance's points are farther apart than its upper bound", apart, d.upper, slack);
        at_most("the distance's points are nearer than its lower bound", d.lower, apart, slack);
        if d.lower > 0.0 {
            at_most("the distance's points are nearer along the normal", d.lower, along, slack_along);
        }
        // The balls around the shapes give another bound.
        let centers = self.a.shape().interior_point() - (self.turn * self.b.shape().interior_point() + self.shift);
        let by_balls = centers.length() - self.a.shape().outer_radius() - self.b.shape().outer_radius();
        if d.lower > 0.0 {
            at_most("the distance's lower bound is above the planes' gap", d.lower, (-way).max(by_balls), slack);
        }
        let (width, hair) = (d.upper - d.lower, self.hair);
        // The normal comes from planes, unless the balls prove the bound.
        if matches!(d.status, Status::Exact | Status::Within) && d.lower > by_balls.max(0.0) {
            for (what, inside) in [
                ("the distance's point is not on the surface of A", reaches[0] - d.normal.dot(d.point_a)),
                ("the distance's point is not on the surface of B", reaches[1] + d.normal.dot(d.point_b)),
            ] {
                at_most(what, inside, width, slack_along);
            }
        }
        match d.status {
            Status::Exact => at_most("an exact distance is wide", width, hair, slack),
            Status::Within => {
                at_most(
                    "a distance is wider than its status",
                    width,
                    Settings::DEFAULT_TOLERANCE * d.upper + hair,
                    slack,
                );
            }
            Status::Touching => {
                at_most("touching has a distance", d.distance + d.lower, 0.0, 0.0);
                at_most("touching is far", d.upper, hair + TOUCHING_POINTS * self.reach, slack);
            }
            _ => {}
        }
        way
    }

    /// The depth against the ways out along all face normals.
    fn judge_by_normals(&self, pair: &BodyPair<'_, '_>, answers: &Answers, tally: &mut Tally) {
        tally.normals += 1;
        let deep = &answers.deep;
        let of_b = self.b.model.face_normals().map(|n| -(self.turn * n));
        for n in self.a.model.face_normals().chain(of_b) {
            let way = self.way_out(n);
            if deep.depth_lower > 0.0 && !(deep.depth_lower <= way + self.slack) {
                let more = format!("way out {way:e} along {n}");
                self.wrong(pair, "the depth's lower bound is above a face's way out", "cold", answers, more, tally);
                return;
            }
        }
    }

    /// The depth against all facets of the Minkowski difference.
    fn judge_by_facets(&self, pair: &BodyPair<'_, '_>, answers: &Answers, tally: &mut Tally) {
        let (Solid::Hull(a), Solid::Hull(b)) = (&self.a.solid, &self.b.solid) else { return };
        if a.rank() < 2 || b.rank() < 2 {
            return;
        }
        let (a, b) = (Polytope::new(a), Polytope::new(b).placed(self.b_in_a));
        if a.edges.len() * b.edges.len() > MAX_EDGE_PAIRS {
            return;
        }
        tally.facets += 1;
        let (depth, axis) = signed_depth(&a, &b, -4.0 * self.slack);
        let deep = &answers.deep;
        let hair = self.hair;
        // The upper bound and a miss have their own certificates. The facets' normals are not all
        // directions if a polygon is flat only up to rounding.
        let fits = !deep.hit
            || deep.depth_lower <= depth.max(0.0) + self.slack
                && (depth >= -hair - FALSE_TOUCH * self.reach
                    || matches!(deep.status, Status::IterationLimit | Status::Stalled));
        if !fits {
            let more = format!("depth by facets {depth:e} along {axis}");
            self.wrong(pair, "the depth differs from the facets'", "cold", answers, more, tally);
        }
    }

    /// The same pair seen from the other side: the intervals have a point in common.
    fn compare(
        &self,
        pair: &BodyPair<'_, '_>,
        here: &Answers,
        there: &Answers,
        back: &Scene<'_, '_>,
        tally: &mut Tally,
    ) {
        let slack = self.slack + back.slack;
        let meet = |p: [f64; 2], q: [f64; 2]| p[0] <= q[1] + slack && q[0] <= p[1] + slack;
        let depth = |c: &Contact| [c.depth_lower, c.depth_upper];
        let gap = |d: &Distance| [d.lower, d.upper];
        let hair = self.hair;
        let what = if !meet(depth(&here.deep), depth(&there.deep)) {
            "the mirrored depth differs"
        } else if !meet(gap(&here.near), gap(&there.near)) {
            "the mirrored distance differs"
        } else if here.deep.hit != there.deep.hit && here.deep.depth_lower.max(there.deep.depth_lower) > hair {
            "the mirrored contact differs"
        } else {
            return;
        };
        let more = format!("mirrored {there:?}");
        self.wrong(pair, what, "cold", here, more, tally);
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
            let scene = Scene::new(a, b, pair.b_in_a);
            let wrong = |change: &dyn Fn(&mut Answers)| {
                let (mut answers, mut tally) = (right, Tally::default());
                change(&mut answers);
                scene.certify(&pair, "changed", &answers, &mut tally);
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
