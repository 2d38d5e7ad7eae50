//! Manifolds of the soak's pairs while B moves, with a certificate for each point.
//!
//! | claim | certificate |
//! |---|---|
//! | a point is on the surface | it is in the shape, and a direction separates it from the shape: slightly farther along the normal, or where it is |
//! | the depth is along the normal | the two points differ by the depth times the normal |
//! | no point is deeper than the contact | the reported depth, and the gap of the distance query |
//! | one point is as deep as the contact | the same, within a tenth of the prediction |
//! | points where the shapes are near | the bounds of the distance query, which has certificates of its own |
//! | a point was there before | its id and the number that the judge stored in it |
//!
//! Each pair starts in a pose of the soak of pairs, and moves in one of seven ways: it barely
//! moves, slides, rocks, rolls, turns about the normal, goes through the prediction, or jumps.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use hullmap::manifold::{FeatureId, MAX_POINTS, PointId};
use hullmap::shapes::HalfSpace;
use hullmap::{
    Cache, Contact, Manifold, ManifoldSettings, Pose, Prediction, Settings, Status, distance, signed_distance,
};
use hullmap_testkit::{random::RandomPoses, reach::Reach};
use shapes::rng::SplitMix64;

use super::{
    bodies::BodyPair,
    body::{Body, Solid, size},
    claims::{Claims, ROUNDING_UNITS},
    model::Model,
    tally::Tally,
};

/// Updates of each pair.
pub const FRAMES: u64 = 10;

/// Maximum distance of a point from a surface, along the normal, relative to the shape's outer
/// radius. Vertices are in f32, and faces flat to 5e-8 of the diameter.
const OFF_SURFACE: f64 = 2e-6;

/// Rounding error of f32 vertices, relative to their distance from the frame's origin, as it tilts
/// the faces of thin shapes far from there.
const F32: f64 = 2.0 * f32::EPSILON as f64;

/// [`OFF_SURFACE`] where edges cross: clipping has a slack of 1e-6, which a sharp corner amplifies.
const CROSSING: f64 = 2e-5;

/// A pair is extreme if one of its shapes is thinner than this, relative to its outer radius, or
/// that much smaller than the other. There, rounding errors of f32 vertices turn faces and move
/// crossings of edges by more than the thickness.
const EXTREME: f64 = 1e-3;

/// Additional tolerance of an extreme pair, relative to the larger outer radius. In 10 million
/// updates, five pairs need more than 1e-3, and one 2.6e-2: crossings of edges that are nearly
/// parallel, of discs and bars thinner than 1e-4.
const EXTREME_OFF: f64 = 5e-2;

/// Depths may differ from the contact's by this share of the prediction.
const SLIGHT: f64 = 0.1;

/// Depths may differ by this share of the smaller outer radius in any case.
const SAME_DEPTH: f64 = 1e-4;

/// A half-space in place of A.
struct Floor {
    shape: HalfSpace,
    normal: DVec3,
}

/// Judges the updates of one pair.
pub(super) fn judge(pair: &BodyPair<'_, '_>, rng: &mut SplitMix64, tally: &mut Tally) {
    let [a, b] = pair.bodies;
    let reach = a.shape().outer_radius().min(b.shape().outer_radius());
    let length = if reach > 0.0 { reach } else { size(a).max(size(b)) };
    let prediction = [
        Prediction::default(),
        Prediction::default(),
        Prediction::Relative(0.2),
        Prediction::Length(1e-3 * length),
        Prediction::Length(0.0),
    ][rng.below(5)];
    let settings = ManifoldSettings { prediction, ..ManifoldSettings::default() };
    // One pair in eight stands on a half-space through A's support point instead of on A.
    let floor = (rng.below(8) == 0).then(|| {
        let normal = rng.unit_vector();
        Floor { shape: HalfSpace::new(normal, a.model.reach(normal)).expect("a plane"), normal }
    });
    let axis = rng.unit_vector();
    let step = [1e-9, 1e-4, 1e-2, 0.1][rng.below(4)];
    let way = rng.below(7);
    // A prediction relative to the smaller body is relative to B if A is a half-space.
    let reach = if floor.is_some() { b.shape().outer_radius() } else { reach };
    let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
    let mut pose = pair.b_in_a;
    let mut known: BTreeMap<u64, PointId> = BTreeMap::new();
    for frame in 0..FRAMES {
        let contact = match (&floor, &a.solid, &b.solid) {
            (Some(floor), _, _) => manifold.update_half_space(&floor.shape, b.shape(), pose, &settings),
            (None, Solid::Hull(a), Solid::Hull(b)) => manifold.update(a, b, pose, &settings, &mut cache),
            _ => manifold.update(a.shape(), b.shape(), pose, &settings, &mut cache),
        };
        let update = Update { a, b, floor: floor.as_ref(), pose, prediction: prediction.length(reach), reach };
        let mut judge = Claims::new("manifolds", tally);
        update.judge(&mut judge, &manifold, &contact);
        judge_memory(&mut judge, &manifold, &known);
        judge.finish(pair, || format!("frame {frame}, {pose:?} {settings:?}\n  {contact:?}\n  {manifold:?}"));
        known.clear();
        for (place, point) in manifold.points_mut().iter_mut().enumerate() {
            point.user_data = frame * MAX_POINTS as u64 + place as u64 + 1;
            known.insert(point.user_data, point.id);
        }
        pose = moved(rng, pose, [way, frame as usize], step, length, if contact.hit { contact.normal } else { axis });
    }
}

/// The next pose.
fn moved(rng: &mut SplitMix64, pose: Pose, [way, frame]: [usize; 2], step: f64, length: f64, normal: DVec3) -> Pose {
    let random = rng.unit_vector();
    let sign = if frame.is_multiple_of(2) { 1.0 } else { -1.0 };
    let (shift, turn) = match way {
        0 => (random * 1e-13, random * 1e-13),
        1 => (normal.cross(random) * step, DVec3::ZERO),
        2 => (DVec3::ZERO, normal.any_orthonormal_vector() * (sign * step)),
        3 => (normal.cross(random) * step, random.cross(normal) * step),
        4 => (DVec3::ZERO, normal * step),
        5 => (normal * (sign * step), random * (0.1 * step)),
        _ => (random * (10.0 * step), random * (10.0 * step)),
    };
    let spin = DQuat::from_xyzw(0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z, 1.0).normalize();
    Pose::new(pose.translation() + shift * length, spin * pose.rotation()).expect("finite")
}

/// A pair in one frame.
struct Update<'s, 'p> {
    a: &'s Body<'p>,
    b: &'s Body<'p>,
    floor: Option<&'s Floor>,
    pose: Pose,
    /// A length.
    prediction: f64,
    /// The smaller outer radius.
    reach: f64,
}

impl Update<'_, '_> {
    fn judge(&self, judge: &mut Claims<'_>, manifold: &Manifold, contact: &Contact) {
        let (points, normal) = (manifold.points(), manifold.normal());
        let names = ["no points", "one point", "two points", "three points", "four points"];
        judge.tally.note(names[points.len()]);
        let lengths = self.a.model.greatest + self.b.model.greatest + self.pose.translation().length();
        let slack = ROUNDING_UNITS * f64::EPSILON * lengths;
        let (larger, is_extreme) = self.extremes();
        let gap = (!contact.hit && self.floor.is_none())
            .then(|| distance(self.a.shape(), self.b.shape(), self.pose, &Settings::default(), &mut Cache::new()));
        let along = (contact.point_a - contact.point_b).dot(contact.normal);
        // Bounds of the depth along any normal.
        let [low, high] = match &gap {
            Some(gap) => [-gap.upper, -gap.lower],
            None if contact.hit => [contact.depth_lower, contact.depth_upper],
            None => [along; 2],
        };
        // The points of a contact can be off the surfaces as far as they are beside each other, or
        // its planes from its points. The soak of pairs judges that.
        let beside = (contact.point_a - contact.point_b - contact.normal * along).length();
        let mut off = beside + (self.width(contact.normal) - along).max(0.0) + (high - low);
        let inexact = off;
        off += F32 * self.a.model.greatest.max(self.b.model.greatest);
        if is_extreme {
            off += EXTREME_OFF * larger;
        }
        if let Some(gap) = &gap {
            let is_far = gap.lower > self.prediction + slack;
            judge.demand("points of shapes that are far apart", !is_far || points.is_empty());
            let is_near = gap.upper < self.prediction - slack && gap.status != Status::Overlapping;
            judge.demand("no points of shapes that are near", !is_near || is_extreme || !points.is_empty());
        }
        let is_inexact = inexact > slack + OFF_SURFACE * self.reach;
        let has_stalled = matches!(contact.status, Status::Stalled | Status::IterationLimit);
        judge.demand("no points of a contact", !contact.hit || !points.is_empty() || is_inexact && has_stalled);
        if points.is_empty() {
            return;
        }
        if !is_extreme && is_inexact {
            judge.tally.note("inexact contacts");
        }
        judge.unit(normal);
        let allowance = OFF_SURFACE * self.reach + off;
        let slight = (SLIGHT * self.prediction).max(SAME_DEPTH * self.reach);
        let deepest = points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
        judge.at_most("no point is as deep as the contact", low - slight, deepest, slack + allowance);
        if !is_extreme {
            judge.tally.note("strict");
        }
        for (index, point) in points.iter().enumerate() {
            judge.demand("a number is not finite", point.point_a.is_finite() && point.point_b.is_finite());
            judge.at_most("a point is deeper than the contact", point.depth, high, slack + allowance);
            judge.at_most("a point is beyond the prediction", -point.depth, self.prediction, slack + allowance);
            let aside = point.point_a - point.point_b - normal * point.depth;
            judge.at_most("the depth is not along the normal", aside.length(), 0.0, slack);
            let local = self.pose.transform_point(point.local_b).distance(point.point_b);
            judge.at_most("B's point differs between the frames", local, 0.0, slack);
            let crossing = [point.id.on_a(), point.id.on_b()].map(|id| matches!(id, FeatureId::Edge(..)));
            let mut off = off;
            if crossing == [true; 2] {
                off += CROSSING * larger;
            }
            if point.depth >= along - slack {
                off += OFF_SURFACE * larger;
            }
            let is_new = points[..index].iter().all(|other| other.id != point.id);
            judge.demand("two points on the same features", is_new);
            match self.floor {
                Some(floor) => {
                    let height = floor.normal.dot(point.point_a) - self.a.model.reach(floor.normal);
                    judge.at_most("a point is not on the plane", height.abs(), OFF_SURFACE * self.reach, slack);
                }
                None => {
                    let names = ["a point is outside of A", "a point is inside of A"];
                    judge_surface(judge, self.a, names, (point.point_a, normal), off, slack);
                }
            }
            let names = ["a point is outside of B", "a point is inside of B"];
            let inward = self.pose.inverse_transform_vector(-normal);
            judge_surface(judge, self.b, names, (point.local_b, inward), off, slack);
        }
    }

    /// The larger outer radius, and whether the pair is extreme.
    fn extremes(&self) -> (f64, bool) {
        let b = self.b.shape();
        let thinness = |inner: f64, outer: f64| inner < EXTREME * outer;
        let is_thin = thinness(b.inner_radius(), b.outer_radius());
        if self.floor.is_some() {
            return (b.outer_radius(), is_thin);
        }
        let a = self.a.shape();
        let larger = a.outer_radius().max(b.outer_radius());
        (larger, is_thin || thinness(a.inner_radius(), a.outer_radius()) || thinness(self.reach, larger))
    }

    /// Depth of the support points along a unit normal.
    fn width(&self, normal: DVec3) -> f64 {
        let inward = self.pose.inverse_transform_vector(-normal);
        let of_a = self.a.model.reach(self.floor.map_or(normal, |floor| floor.normal));
        of_a + self.b.model.reach(inward) - normal.dot(self.pose.translation())
    }
}

/// The point `p` of a body's frame is on its surface, as seen along the `normal` out of it, or
/// `off` it by that much.
fn judge_surface(
    judge: &mut Claims<'_>,
    body: &Body<'_>,
    what: [&'static str; 2],
    (p, normal): (DVec3, DVec3),
    off: f64,
    slack: f64,
) {
    let (model, shape): (&Model, _) = (&body.model, body.shape());
    let allowance = OFF_SURFACE * shape.outer_radius() + off;
    judge.at_most(what[0], model.outside(p), allowance, slack);
    if model.outside(p + normal * (2.0 * (allowance + slack))) > 0.0 {
        return;
    }
    // A corner on the far side of a thin shape, or a place beside the corner of a rounded one,
    // where planes do not separate. The solver has found a direction.
    let found = signed_distance(shape, p, &Settings::default(), &mut Cache::new()).expect("finite");
    let height = found.normal.dot(p) - model.reach(found.normal);
    judge.at_most(what[1], -height, allowance, slack);
}

/// Points that were there before have what was stored in them; others have nothing.
fn judge_memory(judge: &mut Claims<'_>, manifold: &Manifold, known: &BTreeMap<u64, PointId>) {
    let points = manifold.points();
    for (index, point) in points.iter().enumerate() {
        let was_there = known.values().any(|id| *id == point.id);
        judge.demand("a point on the same features is new", !was_there || point.age > 0);
        judge.demand("age and memory contradict each other", (point.age > 0) == (point.user_data > 0));
        if point.age > 0 {
            judge.tally.note("kept");
            judge.demand("a point remembers what was never stored", known.contains_key(&point.user_data));
            let is_single = points[..index].iter().all(|other| other.user_data != point.user_data);
            judge.demand("two points remember the same", is_single);
        }
    }
}
