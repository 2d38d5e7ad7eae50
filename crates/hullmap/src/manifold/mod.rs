//! Contact manifold: up to four points that support a body, kept from one frame to the next.
//!
//! One contact point separates two bodies but cannot support one at rest. A manifold has the points
//! where the two facing features meet: four corners of a face on a face, two ends of an edge on a
//! face, or one vertex.
//!
//! # Reference
//! Kenwright, section 3 ("contact manifold generation (i.e., caching)"). Clipping of features:
//! Gregorius, "Robust contact creation for physics simulations", GDC 2015.
//!
//! # Steps
//! 1. Compute the contact of the shapes; if they are separated by less than the prediction, their
//!    closest points.
//! 2. Find the feature of each shape that faces the other along the normal
//!    ([`Shape::reduced_feature_within`], with the prediction as reach; a hull returns the best
//!    four corners of a baked face).
//! 3. Clip the features against each other (`clip`). If a corner of the smaller one lies outside
//!    the larger one, replace reduced features by whole ones first ([`Shape::feature_within`]).
//!    Drop points separated by more than the prediction.
//! 4. Add the contact point itself where it is deeper than all clipped points by more than a tenth
//!    of the prediction, as on curved surfaces and crossing edges.
//! 5. Select the four points that support the body best (`select`). If its centre is not over them,
//!    so that it tips, consider vertices farther out.
//! 6. Move points to the surfaces where features are not flat (`surface`). A point stays only if it
//!    is on both surfaces, and if they are separated there by at most the prediction.
//! 7. Match each point with one of the last frame, by feature or else by position. A matched point
//!    keeps the caller's data.
//!
//! # Deviations
//! - The paper collects points over several frames. Here all points are found at once, so a body is
//!   supported from the first frame on. Only the caller's data is kept between frames.
//!
//! # What did not work
//! - Taking the first four corners of a face: a prism of eight sides tips over.

#![forbid(unsafe_code)]

mod clip;
mod half_space;
mod lengths;
pub(crate) mod matching;
mod near;
mod point;
#[doc(hidden)]
pub mod select;
mod settings;
mod surface;
mod widen;

use crate::pose::Pose;
use crate::shapes::feature::KeptFace;
use crate::shapes::{Corner, Feature, Shape};
use crate::solver::{Cache, Contact, Settings, Status};
use arrayvec::ArrayVec;
pub(crate) use clip::Body;
use clip::{FACE, Frame, Part, Patch, PatchPoint, meet, nearest_on};
use glam::{DVec2, DVec3};
pub(crate) use lengths::SAME_DEPTH;
use lengths::{Lengths, ON_SURFACE};
use matching::{Likeness, match_points};
use near::{Near, near_contact};
pub use point::{FeatureId, ManifoldPoint, PointId};
use select::{Choice, SAME_PLACE, Spot};
pub use settings::{ManifoldSettings, Prediction};
use surface::{INWARD, settle, witness};
use widen::{center, middle, tips, widen};

/// Maximum number of points of a manifold.
pub const MAX_POINTS: usize = 4;

/// Maximum height of the corners of a face above its plane, relative to the length of its sides:
/// the rounding error of f32 vertices, about.
const COPLANAR: f64 = 5e-7;

/// Minimum cosine of the angle between the contact normal and the normal of a face whose heights
/// are taken from its plane: 45 degrees.
const LEAST_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Maximum number of steps of a second search for the contact of curved shapes.
const MOST_AGAIN: u32 = 128;

/// The contact manifold of two shapes: caller-owned memory of one ordered pair (A, B).
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    points: ArrayVec<ManifoldPoint, MAX_POINTS>,
    normal: DVec3,
    status: Status,
    /// The faces that the features of A and of B were made of.
    kept_faces: [KeptFace; 2],
}

impl Default for Manifold {
    fn default() -> Self {
        Self::new()
    }
}

impl Manifold {
    /// A manifold without points.
    pub const fn new() -> Self {
        Self {
            points: ArrayVec::new_const(),
            normal: DVec3::X,
            status: Status::Separated,
            kept_faces: [KeptFace::NONE; 2],
        }
    }

    /// The points; empty if the shapes are separated by more than the prediction.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points
    }

    /// The points, for storing impulses and user data.
    pub fn points_mut(&mut self) -> &mut [ManifoldPoint] {
        &mut self.points
    }

    /// Unit normal from A to B, in A's frame, of the last update that found points.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// How the query ended that found the normal: of the contact, or of the distance if the shapes
    /// are separated. [`Exact`](Status::Exact) if it is the normal of a face, as after a
    /// correction by [`weld`](crate::compound::seams::weld()). Without points,
    /// [`Separated`](Status::Separated), unless the shapes overlap, but no point on both surfaces
    /// was found. With [`Stalled`](Status::Stalled) and [`IterationLimit`](Status::IterationLimit),
    /// the depths along the normal may be far above the least ones.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Removes all points.
    pub fn clear(&mut self) {
        self.points.clear();
        (self.status, self.kept_faces) = (Status::Separated, [KeptFace::NONE; 2]);
    }

    /// Depth of the deepest point; negative infinity without any.
    pub(crate) fn deepest(&self) -> f64 {
        self.points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Updates the points for `a` and for `b` placed at `b_in_a`, and returns the contact of the
    /// two.
    ///
    /// If the shapes are separated by less than the prediction, the contact has the normal and the
    /// points of [`distance`](crate::distance()). The contact is exact within its interval; the
    /// deepest of the four points may be less deep, by up to a tenth of the prediction, since
    /// points that stay support a body better than the deepest ones. A point that was there before
    /// keeps its impulse and user data, and its age grows. The manifold and `cache` belong to this
    /// ordered pair.
    ///
    /// # Complexity
    /// The cost of [`contact`](crate::contact()), of [`distance`](crate::distance()) if the shapes
    /// are separated by less than the prediction, and of the feature of each shape, reduced and if
    /// necessary whole: for a hull at most 49 support queries each, independent of its vertex
    /// count, and often one. No allocation.
    pub fn update<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
        cache: &mut Cache,
    ) -> Contact {
        let reach = a.outer_radius().min(b.outer_radius());
        let prediction = settings.prediction.length(reach);
        let lengths = [prediction, ON_SURFACE * reach];
        let near = near_contact((a, b, b_in_a), &settings.contact, lengths, cache);
        // Where edges face each other, and one is curved, a point that is off within the tolerance
        // is beside the other edge.
        if self.update_near((a, b, b_in_a), &near, [prediction, reach], near.status != Status::Exact) {
            return near.contact;
        }
        let max_iterations = settings.contact.max_iterations.min(MOST_AGAIN);
        let exact = Settings { tolerance: 0.0, max_iterations };
        let again = near_contact((a, b, b_in_a), &exact, lengths, cache);
        self.update_near((a, b, b_in_a), &again, [prediction, reach], false);
        let iterations = near.contact.iterations + again.contact.iterations;
        Contact { iterations, support_calls: near.contact.support_calls + again.contact.support_calls, ..again.contact }
    }

    /// Updates the points for a contact. `lengths` are the prediction and the smaller outer radius.
    ///
    /// If no point is about as deep as the contact, and `is_trial`, it returns false, and leaves
    /// the points.
    fn update_near<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        (a, b, b_in_a): (&A, &B, Pose),
        near: &Near,
        [prediction, reach]: [f64; 2],
        is_trial: bool,
    ) -> bool {
        let Near { ref contact, depth, width, status } = *near;
        // NaN takes the branch that clears.
        if !(depth >= -prediction) {
            self.clear();
            return true;
        }
        let frame = Frame::new((contact.point_a + contact.point_b) * 0.5, contact.normal);
        let lengths = Lengths { depth, width, prediction, reach };
        let mut features = [Feature::new(), Feature::new()];
        features.iter_mut().zip(self.kept_faces).for_each(|(feature, kept)| feature.kept = kept);
        let mut patch = Patch::default();
        clipped((a, b, b_in_a), &frame, &lengths, &mut features, &mut patch);
        self.kept_faces = features.each_ref().map(|feature| feature.kept);
        let heights = [depth * 0.5, -depth * 0.5];
        let parts = features.each_ref().map(part);
        let exact = [near.is_within(ON_SURFACE * reach, (a, b, b_in_a)); 2];
        let point = PatchPoint { heights, exact, parts, ..PatchPoint::default() };
        if depth > patch.deepest() + lengths.slight() {
            patch.push(point);
        }
        let center = center((a, b, b_in_a), &frame);
        let spots = patch.spots();
        let mut choice = self.choose((&patch, &spots), &frame, b_in_a, center, &lengths);
        if tips(&choice, &spots, center, &lengths) {
            let from = middle(&choice, &patch);
            widen((a, b, b_in_a), &mut patch, [from, center - from], (&frame, &features), &lengths);
            choice = self.choose((&patch, &patch.spots()), &frame, b_in_a, center, &lengths);
        }
        choice = settled((a, b, b_in_a), &mut patch, choice, (&frame, &features), &lengths);
        // Between the corners of a feature that is not flat, the surface may be less deep.
        let deep = choice.indices().iter().map(|i| patch.points()[*i].depth()).fold(f64::NEG_INFINITY, f64::max);
        if depth > deep + lengths.slight() {
            let points = (point, [contact.point_a, contact.point_b], width <= ON_SURFACE * reach);
            let found = witness((a, b, b_in_a), (&frame, &features), [lengths.height_above(), reach], points);
            let reached = found.as_ref().map_or(deep, PatchPoint::depth);
            // NaN takes the failing branch.
            if is_trial && !(depth <= reached + lengths.slight()) {
                return false;
            }
            if let Some(point) = found.and_then(|point| lengths.near_enough(point)) {
                let index = patch.put(point);
                choice.insert(&patch.spots(), index);
            }
        }
        self.replace(&patch, choice, &frame, b_in_a, &lengths);
        self.status = status;
        true
    }

    /// Updates the points as [`update`](Self::update) does, along a given unit normal from A to B,
    /// in A's frame. The points are where the features that face each other along it overlap; there
    /// may be none, although the shapes touch.
    ///
    /// For a normal that is not the normal of the contact, depths are measured along this normal.
    pub(crate) fn update_along<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        (a, b, b_in_a): (&A, &B, Pose),
        normal: DVec3,
        settings: &ManifoldSettings,
    ) {
        let reach = a.outer_radius().min(b.outer_radius());
        let prediction = settings.prediction.length(reach);
        let on_a = a.support_point(normal);
        let on_b = b.support_point(b_in_a.inverse_transform_vector(-normal));
        let [corner_a, corner_b] = [(on_a.point, on_a.feature), (b_in_a.transform_point(on_b.point), on_b.feature)]
            .map(|(point, vertex)| Corner { point, vertex });
        let depth = (corner_a.point - corner_b.point).dot(normal);
        // NaN takes the branch that clears.
        if !(depth >= -prediction) {
            self.clear();
            return;
        }
        let frame = Frame::new(corner_b.point, normal);
        let lengths = Lengths { depth, width: 0.0, prediction, reach };
        let mut features = [Feature::new(), Feature::new()];
        let mut patch = Patch::default();
        clipped((a, b, b_in_a), &frame, &lengths, &mut features, &mut patch);
        if depth > patch.deepest() + lengths.slight() {
            // The support point of a curved surface may be over the other body's face, but no
            // corner.
            let [feature_a, feature_b] = &features;
            let over = |face, corner| nearest_on(face, corner, &frame, reach).filter(|point| !point.is_moved);
            let on_a = || over(feature_b, (&corner_a, Body::A));
            over(feature_a, (&corner_b, Body::B)).or_else(on_a).into_iter().for_each(|point| patch.push(point));
            patch.retain(|p| p.depth() >= -prediction);
        }
        let center = center((a, b, b_in_a), &frame);
        let choice = self.choose((&patch, &patch.spots()), &frame, b_in_a, center, &lengths);
        let choice = settled((a, b, b_in_a), &mut patch, choice, (&frame, &features), &lengths);
        self.replace(&patch, choice, &frame, b_in_a, &lengths);
    }

    /// Replaces the points by at most one, along the unit normal `normal` from A to B: the place of
    /// the other body's face nearest to `point`, which is on the surface of `body`. There is none
    /// if `body` is not there, or farther than the prediction. All are in A's frame.
    pub(crate) fn update_at<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        (a, b, b_in_a): (&A, &B, Pose),
        normal: DVec3,
        (point, body): (DVec3, Body),
        settings: &ManifoldSettings,
    ) {
        let reach = a.outer_radius().min(b.outer_radius());
        let frame = Frame::new(point, normal);
        let dir_b = b_in_a.inverse_transform_vector(-normal);
        let tops = [a.support_point(normal).point, b_in_a.transform_point(b.support_point(dir_b).point)];
        let [on_a, on_b] = tops.map(|top| (top - point).dot(normal));
        let prediction = settings.prediction.length(reach);
        let lengths = Lengths { depth: on_a - on_b, width: 0.0, prediction, reach };
        let above = on_a.abs().max(on_b.abs()) + reach;
        let mut features = [Feature::new(), Feature::new()];
        a.feature(normal, &mut features[0]);
        b.feature(dir_b, &mut features[1]);
        place(&mut features[1], b_in_a);
        let face = &features[usize::from(body == Body::A)];
        let corner = Corner { point, vertex: u32::MAX };
        let mut patch = Patch::default();
        for is_witness in [false, true] {
            let Some(mut found) = nearest_on(face, (&corner, body), &frame, reach) else { break };
            // The surface may face the other body below the point itself.
            let exact = &mut found.exact[usize::from(body == Body::B)];
            *exact = *exact && is_witness;
            if settle((a, b, b_in_a), &frame, &features, above, &mut found) && found.depth() >= -prediction {
                patch.push(found);
                break;
            }
        }
        let mut choice = Choice::default();
        (0..patch.points().len()).for_each(|index| choice.push(index));
        self.replace(&patch, choice, &frame, b_in_a, &lengths);
    }

    /// The best four points of `patch`, preferably last frame's. `spots` are the points.
    fn choose(
        &self,
        (patch, spots): (&Patch, &[Spot]),
        frame: &Frame,
        b_in_a: Pose,
        center: DVec2,
        lengths: &Lengths,
    ) -> Choice {
        // Up to four points are all chosen, whichever were there before.
        let is_choice = patch.points().len() > MAX_POINTS;
        let last = if is_choice { self.present(patch, frame, b_in_a, lengths.reach) } else { None };
        select::choose(spots, center, lengths.slight(), last)
    }

    /// Last frame's points, if all of them are in `patch`.
    fn present(&self, patch: &Patch, frame: &Frame, b_in_a: Pose, reach: f64) -> Option<Choice> {
        let points = patch.points();
        let a_in_b = b_in_a.inverse();
        // Distance between a point and an old one: on A or on B, whichever is smaller.
        let apart = |p: &PatchPoint, old: &ManifoldPoint| {
            let on_a = frame.point(p.at, p.heights[0]).distance(old.point_a);
            on_a.min(a_in_b.transform_point(frame.point(p.at, p.heights[1])).distance(old.local_b))
        };
        let mut present = Choice::default();
        for old in self.points() {
            let by_place = || {
                let distances = points.iter().map(|p| apart(p, old)).enumerate();
                let nearest = distances.min_by(|p, q| p.1.total_cmp(&q.1));
                nearest.filter(|(_, distance)| *distance <= SAME_PLACE * reach).map(|(i, _)| i)
            };
            present.push(points.iter().position(|p| p.parts == old.id.parts).or_else(by_place)?);
        }
        Some(present)
    }

    /// Replaces the points by the chosen ones; matched points keep what the caller stored.
    fn replace(&mut self, patch: &Patch, choice: Choice, frame: &Frame, b_in_a: Pose, lengths: &Lengths) {
        let old = self.points.clone();
        let a_in_b = b_in_a.inverse();
        self.points.clear();
        self.normal = frame.normal;
        self.status = if choice.indices().is_empty() { Status::Separated } else { Status::Exact };
        for &index in choice.indices() {
            let p = &patch.points()[index];
            // Features that are not quite flat rise above their planes. No point is deeper than the
            // contact: both surfaces give way by half of the excess.
            let excess = 0.5 * (p.depth() - lengths.greatest()).max(0.0);
            let heights = [p.heights[0] - excess, p.heights[1] + excess];
            let point_b = frame.point(p.at, heights[1]);
            self.points.push(ManifoldPoint {
                id: PointId { parts: p.parts },
                point_a: frame.point(p.at, heights[0]),
                point_b,
                local_b: a_in_b.transform_point(point_b),
                depth: heights[0] - heights[1],
                ..ManifoldPoint::EMPTY
            });
        }
        let (mut taken, mut matches) = ([false; MAX_POINTS], [None; MAX_POINTS]);
        let frames = Frames { new: &self.points, old: &old };
        match_points(&frames, SAME_PLACE * lengths.reach, &mut taken[..old.len()], &mut matches[..self.points.len()]);
        for (new, found) in self.points.iter_mut().zip(matches) {
            if let Some(found) = found {
                new.keep(&old[found]);
            }
        }
    }
}

/// The points of this frame and of the last one.
struct Frames<'p> {
    new: &'p [ManifoldPoint],
    old: &'p [ManifoldPoint],
}

impl Likeness for Frames<'_> {
    fn has_same_features(&self, point: usize, other: usize) -> bool {
        self.new[point].id == self.old[other].id
    }

    fn distance(&self, point: usize, other: usize) -> f64 {
        self.new[point].distance(&self.old[other])
    }
}

/// The points within the prediction where the features that face each other along the normal of
/// `frame` overlap, into `patch`. Writes the features of A and of B, in A's frame.
fn clipped<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    frame: &Frame,
    lengths: &Lengths,
    features: &mut [Feature; 2],
    patch: &mut Patch,
) {
    let (normal, prediction) = (frame.normal, lengths.prediction);
    let [on_a, on_b] = features;
    let dir_b = b_in_a.inverse_transform_vector(-normal);
    a.reduced_feature_within(normal, prediction, on_a);
    b.reduced_feature_within(dir_b, prediction, on_b);
    place(on_b, b_in_a);
    // Each round replaces a reduced feature by the whole one.
    while let Some(wanted) = meet([on_a, on_b], frame, lengths.reach, patch) {
        if wanted == Body::A {
            a.feature_within(normal, prediction, on_a);
            on_a.set_whole();
        } else {
            b.feature_within(dir_b, prediction, on_b);
            on_b.set_whole();
            place(on_b, b_in_a);
        }
    }
    patch.retain(|p| p.depth() >= -prediction);
    let [flat_a, flat_b] = [is_face(a, on_a, Pose::IDENTITY, normal), is_face(b, on_b, b_in_a, normal)];
    for point in patch.points_mut().iter_mut().filter(|point| !point.is_moved) {
        point.exact = [point.exact[0] || flat_a, point.exact[1] || flat_b];
    }
}

/// Whether a feature that is not marked as flat is a face of `shape` at `pose`, not steep against
/// the unit vector `normal`. All its corners lie in one plane, and the shape does not reach beyond
/// it: rays are not needed. All are in A's frame.
fn is_face<S: Shape + ?Sized>(shape: &S, feature: &Feature, pose: Pose, normal: DVec3) -> bool {
    let [first, second, .., last] = feature.corners() else { return false };
    if feature.is_flat() || !feature.has_exact_corners() {
        return false;
    }
    let corners = feature.corners();
    let across = corners.windows(2).fold(DVec3::ZERO, |sum, c| match c {
        [p, q] => sum + (p.point - first.point).cross(q.point - first.point),
        _ => sum,
    });
    let across = across.normalize_or_zero();
    let outward = across * across.dot(first.point - pose.transform_point(shape.interior_point())).signum();
    if outward.dot(normal).abs() < LEAST_COSINE {
        return false;
    }
    let slack = COPLANAR * second.point.distance(first.point).max(last.point.distance(first.point));
    let height = |point: DVec3| outward.dot(point - first.point);
    if corners.iter().any(|corner| !(height(corner.point).abs() <= slack)) {
        return false;
    }
    let top = shape.support_point(pose.inverse_transform_vector(outward)).point;
    height(pose.transform_point(top)) <= slack
}

/// The `choice` of the points of `patch`, moved to the surfaces. Points drop out where a surface
/// is missing, or farther than the prediction from the other one.
fn settled<A: Shape + ?Sized, B: Shape + ?Sized>(
    pair: (&A, &B, Pose),
    patch: &mut Patch,
    choice: Choice,
    (frame, features): (&Frame, &[Feature; 2]),
    lengths: &Lengths,
) -> Choice {
    let mut kept = Choice::default();
    let middle = patch.points().iter().map(|point| point.at).sum::<DVec2>() / patch.points().len().max(1) as f64;
    for index in choice.indices() {
        let point = &mut patch.points_mut()[*index];
        if point.exact == [true; 2] {
            if point.depth() <= lengths.greatest() + ON_SURFACE * lengths.reach {
                kept.push(*index);
                continue;
            }
            // No point is deeper than the contact: the plane of a sliver is off.
            point.exact = [false; 2];
        }
        let mut is_there = settle(pair, frame, features, lengths.height_above(), point);
        if !is_there {
            point.at += (middle - point.at).normalize_or_zero() * (INWARD * lengths.reach);
            point.exact = [false; 2];
            is_there = settle(pair, frame, features, lengths.height_above(), point);
        }
        if is_there && point.depth() >= -lengths.prediction {
            kept.push(*index);
        }
    }
    kept
}

/// Moves a feature of B from B's frame to A's.
fn place(on_b: &mut Feature, b_in_a: Pose) {
    for corner in on_b.corners_mut() {
        corner.point = b_in_a.transform_point(corner.point);
    }
}

/// The part of a shape with this feature that the contact point lies on.
fn part(feature: &Feature) -> Part {
    match feature.corners() {
        [vertex] => [vertex.vertex; 2],
        [a, b] => [a.vertex.min(b.vertex), a.vertex.max(b.vertex)],
        _ => FACE,
    }
}
