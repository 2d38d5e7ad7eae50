//! Contact manifold: up to four points that hold a body in place, kept from one frame to the next.
//!
//! One contact point is enough to separate two bodies and too little to rest on. A manifold has the points where the two
//! features that face each other meet: four corners of a face on a face, two ends of an edge on a face, one vertex.
//!
//! # Reference
//! Kenwright, section 3 ("contact manifold generation (i.e., caching)"). Clipping of features: Gregorius, "Robust contact
//! creation for physics simulations", GDC 2015.
//!
//! # Steps
//! 1. contact of the shapes; if they are apart by less than the margin, their nearest points;
//! 2. the feature of each that faces the other along the normal ([`Shape::feature`]; of a hull a baked face, by `hull_face`);
//! 3. `clip`: where the features meet; points apart by more than the margin are left out;
//! 4. the contact point itself is added where it is deeper than all of them (curved surfaces, edges that cross);
//! 5. `select`: the four that span the most area, the deepest among them; or the last frame's four while they span nearly as
//!    much, one of them given up if the deepest is another;
//! 6. each point is matched with one of the last frame, by what it is made of, else by where it is, and takes over what
//!    the caller stored there.
//!
//! # Deviations
//! - The paper gathers points over several frames. Here all points are found at once, so that a body is held from the
//!   first frame on, and what is kept between frames are the impulses.
//!
//! # What did not work
//! - The first four corners of a face: a prism of eight sides tips over.

#![forbid(unsafe_code)]

mod clip;
mod hull_face;
mod select;

use crate::minkowski::{Minkowski, perpendicular};
use crate::{Cache, Contact, Feature, Pose, Settings, Shape, Status};
use clip::{FACE, Frame, Part, Patch, PatchPoint, meet};
use glam::DVec3;
use select::{Choice, area, choose};

/// Most points of a manifold.
pub const MAX_POINTS: usize = 4;

/// By how much of the smaller shape's outer radius the contact point must be deeper than all others to be a point of its own:
/// above the solver's tolerance on any depth that is less than the radius.
const WITNESS_ADVANTAGE: f64 = 2e-5;

/// Last frame's four stay while they span this share of what the best four would.
const KEPT_AREA: f64 = 0.9;

/// Depths that differ by less than this share of the smaller shape's outer radius are the same.
const SAME_DEPTH: f64 = 1e-4;

/// A point made of other parts than before is the same if it has moved on one of the shapes by less than this share of the
/// smaller shape's outer radius.
const SAME_PLACE: f64 = 0.02;

/// What a caller asks of a manifold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldSettings {
    /// Of the contact itself.
    pub contact: Settings,
    /// Points apart by up to this are told too, as points of negative depth, so that a body that rocks keeps them: a
    /// share of the outer radius of the smaller shape. NaN and negative values count as 0.
    pub margin: f64,
}

impl ManifoldSettings {
    /// 2 % of the smaller shape.
    pub const DEFAULT_MARGIN: f64 = 0.02;
}

impl Default for ManifoldSettings {
    fn default() -> Self {
        Self { contact: Settings::default(), margin: Self::DEFAULT_MARGIN }
    }
}

/// What a point is made of: a vertex, an edge or the inside of a face, on each of both shapes. Equal from frame to frame
/// while the same features meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PointId {
    parts: [Part; 2],
}

/// A point of a [`Manifold`]. Lengths are in the shapes' units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// What it is made of.
    pub id: PointId,
    /// On A's surface, in A's frame.
    pub point_a: DVec3,
    /// On B's surface, in A's frame.
    pub point_b: DVec3,
    /// On B's surface, in B's frame.
    pub local_b: DVec3,
    /// How deep B is in A here, along the manifold's normal; negative where they are apart.
    pub depth: f64,
    /// The caller's own, to start the next frame from: 0 for a new point, and untouched while a point is kept. Say the
    /// impulse along the normal and along two tangents.
    pub impulse: [f64; 3],
    /// In how many updates before this one the point was there.
    pub age: u32,
}

/// The points where two shapes meet: caller-owned memory of one ordered pair (A, B).
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
/// assert!(manifold.points().iter().all(|p| (p.depth - 0.01).abs() < 1e-12 && p.age == 0));
///
/// manifold.points_mut()[0].impulse[0] = 3.0;
/// manifold.update(&floor, &crate_, Pose::from_translation(DVec3::new(0.1, 0.0, 1.495))?, &settings, &mut cache);
/// assert!(manifold.points()[0].age == 1 && manifold.points()[0].impulse[0] == 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    points: [ManifoldPoint; MAX_POINTS],
    count: usize,
    normal: DVec3,
}

impl ManifoldPoint {
    /// Nothing: what places hold before they are filled.
    const EMPTY: Self = Self {
        id: PointId { parts: [FACE; 2] },
        point_a: DVec3::ZERO,
        point_b: DVec3::ZERO,
        local_b: DVec3::ZERO,
        depth: 0.0,
        impulse: [0.0; 3],
        age: 0,
    };
}

impl Default for Manifold {
    fn default() -> Self {
        Self::new()
    }
}

impl Manifold {
    /// A manifold of no points.
    pub const fn new() -> Self {
        Self { points: [ManifoldPoint::EMPTY; MAX_POINTS], count: 0, normal: DVec3::X }
    }

    /// The points: none where the shapes are apart by more than the margin.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..self.count]
    }

    /// The points, to store impulses in.
    pub fn points_mut(&mut self) -> &mut [ManifoldPoint] {
        &mut self.points[..self.count]
    }

    /// Unit normal in A's frame, from A to B, of the last update that found points.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Forgets all points.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Brings the points up to date for `a` and for `b` placed at `b_in_a`, and returns their contact; where the shapes are
    /// apart by less than the margin, its normal and points are those of [`distance`](crate::distance()).
    ///
    /// A point that was there before keeps its place's impulse and grows older. Manifold and `cache` belong to this ordered
    /// pair.
    ///
    /// # Complexity
    /// That of [`contact`](crate::contact()) (and of the distance, if apart by less than the margin), and of the two features: of
    /// hulls 8 to 33 support queries each, whatever their vertex count. No allocation.
    pub fn update<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
        cache: &mut Cache,
    ) -> Contact {
        let reach = a.outer_radius().min(b.outer_radius());
        let margin = settings.margin.max(0.0) * reach;
        let mut contact = crate::contact(a, b, b_in_a, &settings.contact, cache);
        let mut depth = contact.depth;
        if !contact.hit {
            let Some(gap) = near((a, b, b_in_a), contact.normal, margin, &settings.contact, cache) else {
                self.clear();
                return contact;
            };
            (contact.normal, contact.point_a, contact.point_b) = (gap.normal, gap.point_a, gap.point_b);
            contact.iterations += gap.iterations;
            contact.support_calls += gap.support_calls;
            depth = -gap.distance;
        }
        let normal = contact.normal;
        let side = perpendicular(normal);
        let origin = (contact.point_a + contact.point_b) * 0.5;
        let frame = Frame { origin, x: side, y: normal.cross(side), normal };
        let mut features = [Feature::new(), Feature::new()];
        let [on_a, on_b] = &mut features;
        a.feature(normal, on_a);
        b.feature(b_in_a.inverse_transform_vector(-normal), on_b);
        for corner in on_b.corners_mut() {
            corner.point = b_in_a.transform_point(corner.point);
        }
        let mut patch = Patch::new();
        meet(on_a, on_b, &frame, &mut patch);
        patch.retain(|p| p.depth() >= -margin);
        let deep = patch.points().iter().map(PatchPoint::depth).fold(f64::NEG_INFINITY, f64::max);
        if depth > deep + WITNESS_ADVANTAGE * reach {
            let heights = [depth * 0.5, -depth * 0.5];
            patch.push(PatchPoint { heights, parts: features.each_ref().map(part), ..PatchPoint::default() });
        }
        let choice =
            self.keep(&patch, &frame, b_in_a, reach).unwrap_or_else(|| choose(patch.points(), SAME_DEPTH * reach));
        self.replace(&patch, choice, &frame, b_in_a, depth, reach);
        contact
    }

    /// Last frame's four points in `patch`, or three of them and the deepest, while they are nearly as good as the best four.
    fn keep(&self, patch: &Patch, frame: &Frame, b_in_a: Pose, reach: f64) -> Option<Choice> {
        let points = patch.points();
        if self.count < MAX_POINTS || points.len() < MAX_POINTS {
            return None;
        }
        let a_in_b = b_in_a.inverse();
        // How far a point is from where an old one was: on A or on B, whichever has moved less under it.
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
        let slight = SAME_DEPTH * reach;
        let best = choose(points, slight);
        let (&[a, b, c, d], &[e, f, g, h]) = (kept.numbers(), best.numbers()) else { return None };
        let spanned = |numbers: [usize; 4]| area(numbers.map(|i| points[i].at));
        let mut old = [a, b, c, d];
        let deep = (0..points.len()).fold(0, |best, i| if points[i].depth() > points[best].depth() { i } else { best });
        if old.iter().all(|i| points[*i].depth() < points[deep].depth() - slight) {
            let without = |place: usize| std::array::from_fn(|i| if i == place { deep } else { old[i] });
            let places = (0..MAX_POINTS).map(without);
            old = places.max_by(|p, q| spanned(*p).total_cmp(&spanned(*q))).unwrap_or(old);
        }
        let mut kept = Choice::default();
        old.into_iter().for_each(|i| kept.push(i));
        (spanned(old) >= KEPT_AREA * spanned([e, f, g, h])).then_some(kept)
    }

    /// Takes over the chosen points, and from the old ones what the caller stored.
    fn replace(&mut self, patch: &Patch, choice: Choice, frame: &Frame, b_in_a: Pose, most: f64, reach: f64) {
        let old = self.clone();
        let a_in_b = b_in_a.inverse();
        self.count = 0;
        self.normal = frame.normal;
        for &number in choice.numbers() {
            let p = &patch.points()[number];
            let point_b = frame.point(p.at, p.heights[1]);
            self.points[self.count] = ManifoldPoint {
                id: PointId { parts: p.parts },
                point_a: frame.point(p.at, p.heights[0]),
                point_b,
                local_b: a_in_b.transform_point(point_b),
                // Features that are not quite flat bulge over their planes; no point is deeper than the contact.
                depth: p.depth().min(most),
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
                    (new.impulse, new.age) = (old.points[found].impulse, old.points[found].age.saturating_add(1));
                    (taken[found], *matched) = (true, true);
                }
            }
        }
    }
}

/// The distance of shapes known to be apart along `axis`; `None` if it is above `margin`.
fn near<A: Shape + ?Sized, B: Shape + ?Sized>(
    (a, b, b_in_a): (&A, &B, Pose),
    axis: DVec3,
    margin: f64,
    settings: &Settings,
    cache: &mut Cache,
) -> Option<crate::Distance> {
    if -Minkowski::new(a, b, b_in_a).support(axis).w.dot(axis) > margin {
        return None;
    }
    let gap = crate::distance(a, b, b_in_a, settings, cache);
    (gap.lower <= margin && gap.status != Status::Overlapping).then_some(gap)
}

/// What the contact point is made of on a shape whose feature is this.
fn part(feature: &Feature) -> Part {
    match feature.corners() {
        [vertex] => [vertex.vertex; 2],
        [a, b] => [a.vertex.min(b.vertex), a.vertex.max(b.vertex)],
        _ => FACE,
    }
}
