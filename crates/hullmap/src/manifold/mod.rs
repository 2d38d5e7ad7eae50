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
//! 5. Select four points (`select`): those that span the largest area, always with one that is as
//!    deep as the deepest, within a tenth of the prediction. Last frame's four stay while they span
//!    nearly as much; if none of them is that deep, the deepest replaces one of them.
//! 6. Match each point with one of the last frame, by feature or else by position. A matched point
//!    keeps what the caller stored in it.
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
mod select;

use crate::pose::Pose;
use crate::shapes::{Corner, Feature, Shape};
use crate::solver::{Cache, Contact, Distance, Minkowski, Settings, Status, queries};
use clip::{Body, FACE, Frame, Part, Patch, PatchPoint, deepest_over, meet};
use glam::DVec3;
use select::{Choice, area, choose};
use std::fmt;

/// Maximum number of points of a manifold.
pub const MAX_POINTS: usize = 4;

/// Last frame's four points stay while their area is at least this fraction of the best four
/// points' area.
const KEPT_AREA: f64 = 0.9;

/// Depths that differ by less than this fraction of the prediction count as equal.
///
/// The deepest of the corners of a smooth body changes with every hundredth of a degree. If it is
/// always among the four, the body rocks for ever. Of 102 real meshes, 98 come to rest with a
/// tenth, 93 with half as much (decision 13).
const SLIGHT: f64 = 0.1;

/// Depths that differ by less than this count as equal in any case, relative to the smaller shape's
/// outer radius. Larger than the solver's tolerance on any depth below that radius.
const SAME_DEPTH: f64 = 1e-4;

/// A point on other features than before counts as the same point if it has moved by less than this
/// on one of the shapes, relative to the smaller shape's outer radius.
const SAME_PLACE: f64 = 0.02;

/// How far two surfaces may be separated and still have manifold points, of negative depth, so that
/// a rocking body keeps them.
///
/// NaN and negative values count as 0.
///
/// # Examples
/// ```
/// use hullmap::ManifoldSettings;
/// use hullmap::manifold::Prediction;
///
/// // A centimetre, in a scene whose unit is the metre.
/// let settings = ManifoldSettings { prediction: Prediction::Length(0.01), ..Default::default() };
/// assert_eq!(settings.prediction.length(0.5), 0.01);
/// assert_eq!(Prediction::default().length(0.5), 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prediction {
    /// A length, in the shapes' units.
    Length(f64),
    /// A fraction of the outer radius of the smaller shape.
    Relative(f64),
}

impl Prediction {
    /// The prediction as a length, for a smaller shape of this outer radius.
    pub fn length(self, smaller_outer_radius: f64) -> f64 {
        match self {
            Self::Length(length) => length.max(0.0),
            Self::Relative(fraction) => fraction.max(0.0) * smaller_outer_radius,
        }
    }
}

impl Default for Prediction {
    /// 2 % of the smaller shape's outer radius.
    fn default() -> Self {
        Self::Relative(0.02)
    }
}

/// Settings of [`Manifold::update`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldSettings {
    /// Settings of the contact or distance query inside.
    pub contact: Settings,
    /// How far two surfaces may be separated and still have points.
    pub prediction: Prediction,
}

/// The feature of one shape that a manifold point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FeatureId {
    /// A vertex: its [`Corner::vertex`](crate::Corner::vertex), which for a hull is the vertex
    /// index.
    Vertex(u32),
    /// An edge, by its two vertices in ascending order.
    Edge(u32, u32),
    /// The interior of a face.
    Face,
}

impl FeatureId {
    fn of(part: Part) -> Self {
        match part {
            FACE => Self::Face,
            [a, b] if a == b => Self::Vertex(a),
            [a, b] => Self::Edge(a, b),
        }
    }
}

impl fmt::Display for FeatureId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Edge(start, end) => write!(f, "edge {start}-{end}"),
            Self::Face => f.write_str("face"),
        }
    }
}

/// The pair of features that a manifold point lies on. Equal from frame to frame while the same
/// features meet.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::manifold::FeatureId;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Cache, Manifold, ManifoldSettings, Pose};
///
/// let (floor, cube) = (Cuboid::new(DVec3::new(5.0, 5.0, 1.0))?, Cuboid::new(DVec3::ONE)?);
/// let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
/// let b_in_a = Pose::from_translation(DVec3::new(0.0, 0.0, 1.99))?;
/// manifold.update(&floor, &cube, b_in_a, &ManifoldSettings::default(), &mut cache);
/// let id = manifold.points()[0].id;
/// assert_eq!(id.on_a(), FeatureId::Face);
/// assert!(matches!(id.on_b(), FeatureId::Vertex(_)));
/// assert!(id.to_string().starts_with("face to vertex"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PointId {
    parts: [Part; 2],
}

impl PointId {
    /// The feature of A.
    pub fn on_a(self) -> FeatureId {
        FeatureId::of(self.parts[0])
    }

    /// The feature of B.
    pub fn on_b(self) -> FeatureId {
        FeatureId::of(self.parts[1])
    }
}

impl fmt::Display for PointId {
    /// For instance `face to vertex 3`: A's feature, then B's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", self.on_a(), self.on_b())
    }
}

/// A point of a [`Manifold`]. Lengths are in the shapes' units.
///
/// The two points lie on the planes of the features that meet. If a shape's feature is one face,
/// its plane is the surface. If a hull's faces were merged, the plane can be off the surface, along
/// the normal, by a quarter of the prediction, and at most by [`TILT`](crate::shapes::TILT) times
/// the extent of the feature. The contact that [`update`](Manifold::update) returns has points on
/// the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// The features it lies on.
    pub id: PointId,
    /// The point on A's feature, in A's frame.
    pub point_a: DVec3,
    /// The point on B's feature, in A's frame.
    pub point_b: DVec3,
    /// The point on B's feature, in B's frame.
    pub local_b: DVec3,
    /// Penetration depth at this point along the manifold's normal n, (`point_a` − `point_b`) · n;
    /// negative if the surfaces are separated there. At most the depth of the contact.
    pub depth: f64,
    /// Owned by the caller: 0 in a new point and unchanged while the point is kept. Made for the
    /// accumulated impulse along the normal and two tangents, with which the next frame's solver
    /// starts.
    pub impulse: [f64; 3],
    /// Owned by the caller: 0 in a new point and unchanged while the point is kept. For a material,
    /// an event id or an index.
    pub user_data: u64,
    /// Number of earlier updates in which the point was present.
    pub age: u32,
}

/// The contact manifold of two shapes: caller-owned memory of one ordered pair (A, B).
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Cache, Manifold, ManifoldSettings, Pose};
///
/// let (floor, crate_) = (Cuboid::new(DVec3::new(5.0, 5.0, 1.0))?, Cuboid::new(DVec3::splat(0.5))?);
/// let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
/// let settings = ManifoldSettings::default();
/// manifold.update(&floor, &crate_, Pose::from_translation(DVec3::new(0.0, 0.0, 1.49))?, &settings, &mut cache);
/// assert_eq!(manifold.points().len(), 4);
/// assert_eq!(manifold.normal(), DVec3::Z);
/// assert!(manifold.points().iter().all(|p| (p.depth - 0.01).abs() < 1e-12 && p.age == 0));
///
/// manifold.points_mut()[0].impulse[0] = 3.0;
/// manifold.points_mut()[0].user_data = 7;
/// manifold.update(&floor, &crate_, Pose::from_translation(DVec3::new(0.1, 0.0, 1.495))?, &settings, &mut cache);
/// let kept = manifold.points()[0];
/// assert!(kept.age == 1 && kept.impulse[0] == 3.0 && kept.user_data == 7);
///
/// manifold.clear();
/// assert!(manifold.points().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    points: [ManifoldPoint; MAX_POINTS],
    count: usize,
    normal: DVec3,
}

impl ManifoldPoint {
    /// Fills unused slots.
    const EMPTY: Self = Self {
        id: PointId { parts: [FACE; 2] },
        point_a: DVec3::ZERO,
        point_b: DVec3::ZERO,
        local_b: DVec3::ZERO,
        depth: 0.0,
        impulse: [0.0; 3],
        user_data: 0,
        age: 0,
    };
}

impl Default for Manifold {
    fn default() -> Self {
        Self::new()
    }
}

impl Manifold {
    /// A manifold without points.
    pub const fn new() -> Self {
        Self { points: [ManifoldPoint::EMPTY; MAX_POINTS], count: 0, normal: DVec3::X }
    }

    /// The points; empty if the shapes are separated by more than the prediction.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..self.count]
    }

    /// The points, for storing impulses and user data.
    pub fn points_mut(&mut self) -> &mut [ManifoldPoint] {
        &mut self.points[..self.count]
    }

    /// Unit normal from A to B, in A's frame, of the last update that found points.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Removes all points.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Updates the points for `a` and for `b` placed at `b_in_a`, and returns the contact of the
    /// two.
    ///
    /// If the shapes are separated by less than the prediction, the contact's normal and points are
    /// those of [`distance`](crate::distance()). The contact is exact within its interval; the
    /// deepest of the four points may be less deep, by up to a tenth of the prediction, since
    /// points that stay support a body better than the deepest ones. A point that was there before
    /// keeps its impulse and user data, and its age grows. The manifold and `cache` belong to this
    /// ordered pair.
    ///
    /// # Complexity
    /// That of [`contact`](crate::contact()), of [`distance`](crate::distance()) if the shapes are
    /// separated by less than the prediction, and of the feature of each shape, reduced and if
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
        let mut contact = queries::contact(a, b, b_in_a, &settings.contact, cache);
        let mut depth = contact.depth;
        if !contact.hit {
            let Some(gap) = near((a, b, b_in_a), contact.normal, prediction, &settings.contact, cache) else {
                self.clear();
                return contact;
            };
            (contact.normal, contact.point_a, contact.point_b) = (gap.normal, gap.point_a, gap.point_b);
            contact.iterations += gap.iterations;
            contact.support_calls += gap.support_calls;
            depth = -gap.distance;
        }
        let frame = Frame::new((contact.point_a + contact.point_b) * 0.5, contact.normal);
        let mut features = [Feature::new(), Feature::new()];
        let mut patch = clipped((a, b, b_in_a), &frame, prediction, &mut features);
        let deep = patch.points().iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max);
        let slight = slight(prediction, reach);
        if depth > deep + slight {
            let heights = [depth * 0.5, -depth * 0.5];
            patch.push(PatchPoint { heights, parts: features.each_ref().map(part), ..PatchPoint::default() });
        }
        let choice = self.select(&patch, &frame, b_in_a, reach, slight);
        self.replace(&patch, choice, &frame, b_in_a, depth, reach);
        contact
    }

    /// Updates the points as [`update`](Self::update) does, along a given unit normal from A to B,
    /// in A's frame. The points are where the features that face each other along it overlap; there
    /// may be none, although the shapes touch.
    ///
    /// For a normal that is not that of the contact, the depths are those along it.
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
        let mut features = [Feature::new(), Feature::new()];
        let mut patch = clipped((a, b, b_in_a), &frame, prediction, &mut features);
        let deep = patch.points().iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max);
        let slight = slight(prediction, reach);
        if depth > deep + slight {
            // The support point of a curved surface may be over the other body's face, but no
            // corner.
            let [feature_a, feature_b] = &features;
            deepest_over(feature_a, feature_b, [&corner_a, &corner_b], &frame, &mut patch);
            patch.retain(|p| p.depth() >= -prediction);
        }
        let choice = self.select(&patch, &frame, b_in_a, reach, slight);
        self.replace(&patch, choice, &frame, b_in_a, depth, reach);
    }

    /// Replaces the points by one, with a point of A and a point of B on a line along the unit
    /// normal from A to B. All are in A's frame; `reach` is the smaller outer radius.
    pub(crate) fn update_to(&mut self, [point_a, point_b]: [DVec3; 2], normal: DVec3, b_in_a: Pose, reach: f64) {
        let frame = Frame::new(point_b, normal);
        let depth = (point_a - point_b).dot(normal);
        let mut patch = Patch::new();
        patch.push(PatchPoint { heights: [depth, 0.0], parts: [FACE; 2], ..PatchPoint::default() });
        let mut choice = Choice::default();
        choice.push(0);
        self.replace(&patch, choice, &frame, b_in_a, depth, reach);
    }

    /// The best four points in `patch`, or last frame's if they span nearly as much area.
    fn select(&self, patch: &Patch, frame: &Frame, b_in_a: Pose, reach: f64, slight: f64) -> Choice {
        let best = choose(patch.points(), slight);
        self.keep(patch, &best, frame, b_in_a, reach, slight).unwrap_or(best)
    }

    /// Last frame's four points in `patch`, or three of them and the deepest, if they span nearly
    /// as much area as the `best` four.
    fn keep(
        &self,
        patch: &Patch,
        best: &Choice,
        frame: &Frame,
        b_in_a: Pose,
        reach: f64,
        slight: f64,
    ) -> Option<Choice> {
        let points = patch.points();
        if self.count < MAX_POINTS || points.len() < MAX_POINTS {
            return None;
        }
        let a_in_b = b_in_a.inverse();
        // Distance between a point and an old one: on A or on B, whichever is smaller.
        let apart = |p: &PatchPoint, old: &ManifoldPoint| {
            let on_a = frame.point(p.at, p.heights[0]).distance(old.point_a);
            on_a.min(a_in_b.transform_point(frame.point(p.at, p.heights[1])).distance(old.local_b))
        };
        let mut kept = Choice::default();
        for old in self.points() {
            let by_place = || {
                let distances = points.iter().map(|p| apart(p, old)).enumerate();
                let nearest = distances.min_by(|p, q| p.1.total_cmp(&q.1));
                nearest.filter(|(_, distance)| *distance <= SAME_PLACE * reach).map(|(i, _)| i)
            };
            kept.push(points.iter().position(|p| p.parts == old.id.parts).or_else(by_place)?);
        }
        let (&[a, b, c, d], &[e, f, g, h]) = (kept.indices(), best.indices()) else { return None };
        let spanned = |indices: [usize; 4]| area(indices.map(|i| points[i].at));
        let mut old = [a, b, c, d];
        let deep = (0..points.len()).fold(0, |best, i| if points[i].depth() > points[best].depth() { i } else { best });
        if old.iter().all(|i| points[*i].depth() < points[deep].depth() - slight) {
            let without = |slot: usize| std::array::from_fn(|i| if i == slot { deep } else { old[i] });
            let candidates = (0..MAX_POINTS).map(without);
            old = candidates.max_by(|p, q| spanned(*p).total_cmp(&spanned(*q))).unwrap_or(old);
        }
        let mut kept = Choice::default();
        old.into_iter().for_each(|i| kept.push(i));
        (spanned(old) >= KEPT_AREA * spanned([e, f, g, h])).then_some(kept)
    }

    /// Replaces the points by the chosen ones; matched points keep what the caller stored.
    fn replace(&mut self, patch: &Patch, choice: Choice, frame: &Frame, b_in_a: Pose, contact_depth: f64, reach: f64) {
        let old = self.clone();
        let a_in_b = b_in_a.inverse();
        self.count = 0;
        self.normal = frame.normal;
        for &index in choice.indices() {
            let p = &patch.points()[index];
            // Features that are not quite flat rise above their planes. No point is deeper than the
            // contact: both surfaces give way by half of the excess.
            let excess = 0.5 * (p.depth() - contact_depth).max(0.0);
            let heights = [p.heights[0] - excess, p.heights[1] + excess];
            let point_b = frame.point(p.at, heights[1]);
            self.points[self.count] = ManifoldPoint {
                id: PointId { parts: p.parts },
                point_a: frame.point(p.at, heights[0]),
                point_b,
                local_b: a_in_b.transform_point(point_b),
                depth: heights[0] - heights[1],
                ..ManifoldPoint::EMPTY
            };
            self.count += 1;
        }
        let mut taken = [false; MAX_POINTS];
        let mut matched = [false; MAX_POINTS];
        for by_id in [true, false] {
            for (new, matched) in
                self.points[..self.count].iter_mut().zip(&mut matched).filter(|(_, matched)| !**matched)
            {
                let apart = |old: &ManifoldPoint| {
                    new.point_a.distance(old.point_a).min(new.local_b.distance(old.local_b)) / reach
                };
                let same = |old: &ManifoldPoint| if by_id { old.id == new.id } else { apart(old) <= SAME_PLACE };
                let found = (0..old.count)
                    .filter(|i| !taken[*i] && same(&old.points[*i]))
                    .min_by(|i, j| apart(&old.points[*i]).total_cmp(&apart(&old.points[*j])));
                if let Some(found) = found {
                    let kept = &old.points[found];
                    (new.impulse, new.user_data) = (kept.impulse, kept.user_data);
                    new.age = kept.age.saturating_add(1);
                    (taken[found], *matched) = (true, true);
                }
            }
        }
    }
}

/// The points within the prediction where the features that face each other along the normal of
/// `frame` overlap. Writes the features of A and of B, in A's frame.
fn clipped<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    frame: &Frame,
    prediction: f64,
    features: &mut [Feature; 2],
) -> Patch {
    let normal = frame.normal;
    let [on_a, on_b] = features;
    let dir_b = b_in_a.inverse_transform_vector(-normal);
    a.reduced_feature_within(normal, prediction, on_a);
    b.reduced_feature_within(dir_b, prediction, on_b);
    place(on_b, b_in_a);
    let mut patch = Patch::new();
    // Each round replaces a reduced feature by the whole one.
    while let Some(wanted) = meet(on_a, on_b, frame, &mut patch) {
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
    patch
}

/// The distance of shapes that `axis` separates; `None` if it is above `prediction`.
fn near<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    axis: DVec3,
    prediction: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> Option<Distance> {
    if -Minkowski::new(a, b, b_in_a).support(axis).w.dot(axis) > prediction {
        return None;
    }
    let gap = queries::distance(a, b, b_in_a, settings, cache);
    (gap.lower <= prediction && gap.status != Status::Overlapping).then_some(gap)
}

/// Moves a feature of B from B's frame to A's.
fn place(on_b: &mut Feature, b_in_a: Pose) {
    for corner in on_b.corners_mut() {
        corner.point = b_in_a.transform_point(corner.point);
    }
}

/// Depths that differ by less than this length count as equal.
fn slight(prediction: f64, reach: f64) -> f64 {
    (SLIGHT * prediction).max(SAME_DEPTH * reach)
}

/// The part of a shape with this feature that the contact point lies on.
fn part(feature: &Feature) -> Part {
    match feature.corners() {
        [vertex] => [vertex.vertex; 2],
        [a, b] => [a.vertex.min(b.vertex), a.vertex.max(b.vertex)],
        _ => FACE,
    }
}
