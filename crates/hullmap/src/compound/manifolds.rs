//! Contact manifolds of compounds: one for each pair of parts that touch, kept from frame to frame.
//!
//! Here, parts touch if they have manifold points: they overlap, or are separated by at most the
//! prediction.
//!
//! # Steps
//! 1. Traverse the BVHs for the pairs of parts whose boxes are within the prediction of each other.
//!    For a single part on a mesh, the mesh finds the triangles in the box around the part.
//! 2. A pair of the last frame updates its manifold, with its solver cache. Another pair tries an
//!    empty manifold, and gets an entry if it has points.
//! 3. Normals at edges between the parts of a compound are corrected ([`seams`](super::seams)).
//! 4. If the correction leaves no pair, the deepest of those that it has removed stays: no body
//!    that touches is without a manifold. This happens where a body is not much larger than the
//!    steps of f32 coordinates, at which all normals are in doubt.
//! 5. Pairs that no longer touch leave their entries.

use super::bvh::{Node, Placement};
use super::carrying::Carrying;
use super::half_space::Descent;
use super::joined::Joined;
use super::near::{NearParts, NearTriangles};
use super::parts::Parts;
use super::seams::{self, Correction, Side, Union};
use super::sheet::{BesideSheet, CandidatePair};
use super::traversal::Traversal;
use crate::manifold::{Manifold, ManifoldSettings};
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{Cache, Contact, Scratch};
use crate::support::SupportMap;
use glam::DVec3;

/// Contact manifolds of two geometries, one for each pair of parts that touch: caller-owned memory
/// of one ordered pair (A, B).
///
/// Parts *touch* if they have manifold points: they overlap, or are separated by at most the
/// prediction. Points and normals are in A's frame, as in [`Manifold`]. Each point is on the
/// surfaces of the two parts of its pair, also where its normal is corrected.
///
/// It holds a [`Manifold`] and a [`Cache`] for each pair of parts that touch, about 2 KB, and a
/// cache for the other pairs. All memory is allocated by [`new`](Self::new).
///
/// # Examples
/// A step of an engine: update, then read and write all points.
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = two_cubes();
/// use hullmap::compound::CompoundManifolds;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{Compound, ManifoldSettings, Pose};
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4, on a floor whose top is at z = 0.
/// let (floor, cubes) = (Cuboid::new(DVec3::new(9.0, 9.0, 1.0))?, Compound::new(&pack));
/// let mut manifolds = CompoundManifolds::new(8);
/// for step in 0..3 {
///     let b_in_a = Pose::from_translation(DVec3::new(0.0, 0.01 * f64::from(step), 0.999))?;
///     let counts = manifolds.update(&floor, &cubes, b_in_a, &ManifoldSettings::default());
///     assert_eq!((counts.touching, counts.dropped), (2, 0));
///     for (_pair, manifold) in manifolds.iter_mut() {
///         for point in manifold.points_mut() {
///             assert_eq!(point.impulse[0], f64::from(step));
///             point.impulse[0] += 1.0;
///         }
///     }
/// }
/// // Part 0 of A, the floor, with part 1 of B.
/// let right = manifolds.get([0, 1]).ok_or("no contact")?;
/// assert_eq!(right.points().len(), 4);
/// assert!(right.points().iter().all(|point| point.age == 2 && point.point_a.x >= 3.0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct CompoundManifolds {
    entries: Box<[Entry]>,
    /// Indices of all entries: first those in use, ordered by their pairs, then the free ones.
    order: Box<[usize]>,
    used: usize,
    /// Solver caches of pairs without an entry.
    others: Cache,
    /// Lent by the caller, and passed to the cache in use.
    scratch: Option<Box<Scratch>>,
    welds: bool,
    /// The smaller body in the last update.
    body: SmallerBody,
}

/// The smaller one of two bodies, whose contact points are chosen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SmallerBody {
    /// A point inside, in A's frame.
    pub(super) center: DVec3,
    /// Upper bound of its outer radius.
    pub(super) reach: f64,
    pub(super) prediction: f64,
}

impl SmallerBody {
    /// Chooses the smaller of the balls around two bodies, both in A's frame.
    fn choose(balls: [(DVec3, f64); 2], settings: &ManifoldSettings) -> Self {
        let [(center_a, radius_a), (center_b, radius_b)] = balls;
        let (center, reach) = if radius_a < radius_b { (center_a, radius_a) } else { (center_b, radius_b) };
        Self { center, reach, prediction: settings.prediction.length(reach) }
    }
}

/// A pair of parts that touch.
#[derive(Clone, Debug, Default)]
struct Entry {
    pair: [usize; 2],
    /// Whether the pair had points in the last update. Free entries have none.
    touches: bool,
    manifold: Manifold,
    cache: Cache,
}

/// Counts of a [`CompoundManifolds::update`]: pairs that touch, and the cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ManifoldCounts {
    /// Number of pairs of parts with manifold points, without those dropped.
    pub touching: u32,
    /// Number of pairs of parts that touch but have no manifold, because all entries are in use.
    pub dropped: u32,
    /// Number of pairs of parts queried.
    pub pairs: u32,
    /// Number of pairs of boxes compared.
    pub boxes: u32,
    /// Solver iterations, summed over all pairs of parts.
    pub iterations: u32,
    /// Pairs of support queries, summed over all pairs of parts.
    pub support_calls: u32,
}

impl CompoundManifolds {
    /// Memory for at most `pairs` pairs of parts that touch at the same time, at least one.
    ///
    /// If more pairs touch, the pairs of the last frame stay, and the others are counted as
    /// [`dropped`](ManifoldCounts::dropped).
    pub fn new(pairs: usize) -> Self {
        let pairs = pairs.max(1);
        Self {
            entries: vec![Entry::default(); pairs].into_boxed_slice(),
            order: (0..pairs).collect(),
            used: 0,
            others: Cache::with_pairs(2 * pairs),
            scratch: None,
            welds: true,
            body: SmallerBody::default(),
        }
    }

    /// Sets whether normals at edges between the parts of a compound are corrected, as
    /// [`weld`](seams::weld) does. The default is true. Without welding, each manifold considers
    /// its two parts alone, and bodies stumble over these edges.
    pub fn set_welding(&mut self, welds: bool) {
        self.welds = welds;
    }

    /// [`update`](Self::update) for two convex shapes, which have one manifold.
    #[inline(always)]
    pub(crate) fn update_shapes<A: Shape + ?Sized, B: Shape + ?Sized>(
        &mut self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> ManifoldCounts {
        let mut frame = self.start();
        let center_b = b_in_a.transform_point(b.interior_point());
        let balls = [(a.interior_point(), a.outer_radius()), (center_b, b.outer_radius())];
        self.body = SmallerBody::choose(balls, settings);
        self.visit(&mut frame, [0, 0], |manifold, cache| manifold.update(a, b, b_in_a, settings, cache));
        self.finish(frame)
    }

    /// [`update`](Self::update) for two geometries, at least one of which has parts.
    pub(crate) fn update_parts<A: Parts + ?Sized, B: Parts + ?Sized>(
        &mut self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> ManifoldCounts {
        let mut triangles = NearTriangles::new();
        let near = NearParts::new((a, b, b_in_a), settings, &mut triangles);
        let in_a = (self.welds && a.part_count() > 1).then_some((&near as &dyn Union, 0, Pose::IDENTITY));
        self.update_within(in_a, true, &near, (a, b, b_in_a), settings)
    }

    /// [`update`](Self::update) for a mesh or a compound that meets others: `a` is the tile `tile`
    /// of `joined`. Normals at edges where tiles meet are corrected as those at edges inside one.
    ///
    /// The caller keeps separate manifolds for each tile near a body. See [`Joined`].
    ///
    /// # Complexity
    /// As [`update`](Self::update), but the correction also tests the other tiles.
    pub fn update_joined<A: Parts + ?Sized, B: Parts + ?Sized>(
        &mut self,
        joined: &Joined<'_>,
        tile: usize,
        a: &A,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> ManifoldCounts {
        let in_a = joined.tile(tile).filter(|_| self.welds);
        let in_a = in_a.map(|(first, place)| (joined as &dyn Union, first, place));
        let mut triangles = NearTriangles::new();
        let near = NearParts::new((a, b, b_in_a), settings, &mut triangles);
        self.update_within(in_a, false, &near, (a, b, b_in_a), settings)
    }

    /// Updates the manifolds of `a`, which is in a union: the union, the index of its first part
    /// there, its pose, and whether it is all of it. `near` has the parts of `a` near the body.
    fn update_within<A: Parts + ?Sized, B: Parts + ?Sized>(
        &mut self,
        in_a: Option<(&dyn Union, usize, Pose)>,
        is_whole: bool,
        near: &NearParts<'_, A>,
        (a, b, b_in_a): (&A, &B, Pose),
        settings: &ManifoldSettings,
    ) -> ManifoldCounts {
        let mut frame = self.start();
        let union_b = seams::union_of(b);
        let in_b = (self.welds && b.part_count() > 1).then_some(&union_b as &dyn Union);
        let bodies = BodyPair { b_in_a, in_a, in_b, is_whole, settings };
        if let Some(part) = b.part(0).filter(|_| b.part_count() == 1) {
            let radius = part.outer_radius();
            let ball = (b_in_a.transform_point(part.interior_point()), radius);
            self.body = SmallerBody::choose([a.nodes().ball(), ball], settings);
            let beside = BesideSheet::new(&part, b_in_a);
            let prediction = settings.prediction.length(radius);
            let mut visit = |index: usize, corners: [DVec3; 3]| {
                if !beside.is_apart(corners, prediction)
                    && let Some(parts) = CandidatePair::new(a, b, [index, 0], b_in_a)
                    && !parts.is_behind()
                {
                    self.meet(&mut frame, &bodies, [index, 0], &parts);
                }
            };
            if let Some(boxes) = near.triangles(&mut visit) {
                frame.counts.boxes = boxes;
                return self.finish(frame);
            }
        }
        let nodes = [a.nodes(), b.nodes()];
        let [ball_a, (center_b, radius_b)] = nodes.map(|nodes| nodes.ball());
        self.body = SmallerBody::choose([ball_a, (b_in_a.transform_point(center_b), radius_b)], settings);
        let placement = Placement::new(nodes[0], nodes[1], b_in_a);
        // A part is in its box and in all boxes above, so the radius of a ball around an interior
        // point is at most the diagonal of each.
        let reach = |a: &Node, b: &Node| settings.prediction.length(a.diagonal().min(b.diagonal()));
        let mut traversal = Traversal::new(placement);
        while let Some(pair) = traversal.next_within(reach) {
            let Some(parts) = CandidatePair::new(a, b, pair, b_in_a) else { continue };
            let prediction = settings.prediction.length(parts.a.outer_radius().min(parts.b.outer_radius()));
            // NaN takes the branch that queries.
            if !(traversal.lower_bound() > prediction || parts.is_behind() || parts.is_apart(prediction)) {
                self.meet(&mut frame, &bodies, pair, &parts);
            }
        }
        frame.counts.boxes = traversal.boxes();
        self.finish(frame)
    }

    fn meet<A: Parts + ?Sized, B: Parts + ?Sized>(
        &mut self,
        frame: &mut Frame,
        bodies: &BodyPair<'_>,
        pair: [usize; 2],
        parts: &CandidatePair<'_, A, B>,
    ) {
        let BodyPair { b_in_a, in_a, in_b, settings, .. } = *bodies;
        if in_a.is_none() && in_b.is_none() {
            self.visit(frame, pair, |manifold, cache| parts.update(manifold, settings, cache));
            return;
        }
        let mut removed = None;
        self.visit(frame, pair, |manifold, cache| {
            let before = manifold.clone();
            let contact = parts.update(manifold, settings, cache);
            if manifold.points().is_empty() {
                return contact;
            }
            let normal = manifold.normal();
            let carrying_a = in_a.zip(parts.b.triangle()).and_then(|((union, _, place), corners)| {
                let towards = b_in_a.inverse_transform_vector(-normal);
                Carrying::new(union, corners, towards, place.compose(b_in_a).ok()?)
            });
            let carrying_b = in_b.zip(parts.a.triangle());
            let carrying_b =
                carrying_b.and_then(|(union, corners)| Carrying::new(union, corners, normal, b_in_a.inverse()));
            let in_a = in_a.map(|(union, first, place)| {
                (carrying_a.as_ref().map_or(union, |own| own as &dyn Union), first + pair[0], place)
            });
            let in_b = in_b.map(|union| carrying_b.as_ref().map_or(union, |own| own as &dyn Union));
            let side_a = Side { shape: &parts.a, union: in_a };
            let side_b = Side { shape: &parts.b, union: in_b.map(|union| (union, pair[1], Pose::IDENTITY)) };
            let correction = seams::correct(manifold, &before, &side_a, &side_b, b_in_a, settings);
            if correction == Correction::Unsupported {
                removed = Some(manifold.clone());
                manifold.clear();
            }
            contact
        });
        // Another tile may support the body.
        if let Some(manifold) = removed.filter(|_| bodies.is_whole) {
            frame.remove(pair, manifold);
        }
    }

    /// [`update`](Self::update) for a half-space as A, which has one part.
    pub(crate) fn update_half_space<B: Parts + ?Sized>(
        &mut self,
        a: &HalfSpace,
        b: &B,
        b_in_a: Pose,
        settings: &ManifoldSettings,
    ) -> ManifoldCounts {
        let mut frame = self.start();
        let nodes = b.nodes();
        let (center, radius) = nodes.ball();
        self.body =
            SmallerBody::choose([(DVec3::ZERO, f64::INFINITY), (b_in_a.transform_point(center), radius)], settings);
        let reach = settings.prediction.length(nodes.diagonal());
        let mut descent = Descent::new(a, nodes, b_in_a);
        while let Some(index) = descent.next(-reach) {
            let Some(part) = b.part(index) else { continue };
            self.visit(&mut frame, [0, index], |manifold, _| manifold.update_half_space(a, &part, b_in_a, settings));
        }
        frame.counts.boxes = descent.boxes();
        self.finish(frame)
    }

    /// Exchanges A and B, for B in the frame of A at this pose.
    pub(crate) fn exchange(&mut self, b_in_a: Pose) {
        for entry in &mut self.entries {
            entry.pair.reverse();
            entry.manifold.exchange(b_in_a);
        }
        self.body.center = b_in_a.transform_point(self.body.center);
    }

    #[expect(clippy::indexing_slicing, reason = "`order` is a permutation of the entries; `used` is within")]
    fn start(&mut self) -> Frame {
        // The free ones do not touch.
        for entry in &self.order[..self.used] {
            self.entries[*entry].touches = false;
        }
        Frame { old: self.used, counts: ManifoldCounts::default(), removed: None }
    }

    /// Updates the manifold of a pair, and assigns an entry to a new pair that touches.
    #[expect(clippy::indexing_slicing, reason = "`order` is a permutation of the entries; `old` and `used` are within")]
    fn visit(
        &mut self,
        frame: &mut Frame,
        pair: [usize; 2],
        mut update: impl FnMut(&mut Manifold, &mut Cache) -> Contact,
    ) {
        let Self { entries, order, used, others, scratch, .. } = self;
        let mut update = |manifold: &mut Manifold, cache: &mut Cache| {
            if let Some(scratch) = scratch.take() {
                cache.set_scratch(scratch);
            }
            let contact = update(manifold, cache);
            *scratch = cache.take_scratch();
            contact
        };
        let known = order[..frame.old].binary_search_by_key(&pair, |entry| entries[*entry].pair);
        let contact = match known.map(|at| order[at]) {
            Ok(entry) => {
                let Entry { manifold, cache, touches, .. } = &mut entries[entry];
                let contact = update(manifold, cache);
                *touches = !manifold.points().is_empty();
                contact
            }
            Err(_) => {
                let cache = others.pair(pair);
                let Some(free) = order.get(*used) else {
                    let mut manifold = Manifold::new();
                    let contact = update(&mut manifold, cache);
                    frame.counts.dropped += u32::from(!manifold.points().is_empty());
                    frame.count(&contact);
                    return;
                };
                // In its place: an entry is large.
                let entry = &mut entries[*free];
                entry.manifold.clear();
                let contact = update(&mut entry.manifold, cache);
                if !entry.manifold.points().is_empty() {
                    (entry.pair, entry.touches) = (pair, true);
                    entry.cache.copy_from(cache);
                    *used += 1;
                }
                contact
            }
        };
        frame.count(&contact);
    }

    /// Frees the entries of pairs that do not touch.
    #[expect(clippy::indexing_slicing, reason = "`order` is a permutation of the entries; `used` is within")]
    fn finish(&mut self, frame: Frame) -> ManifoldCounts {
        let Self { entries, order, used, others, .. } = self;
        let mut kept = 0;
        for at in 0..*used {
            let entry = &mut entries[order[at]];
            if entry.touches {
                order.swap(kept, at);
                kept += 1;
            } else {
                entry.manifold.clear();
            }
        }
        if let Some((pair, manifold)) = frame.removed.filter(|_| kept == 0) {
            let entry = &mut entries[order[0]];
            entry.cache.copy_from(others.pair(pair));
            (entry.pair, entry.touches, entry.manifold) = (pair, true, manifold);
            kept = 1;
        }
        order[..kept].sort_unstable_by_key(|entry| entries[*entry].pair);
        *used = kept;
        ManifoldCounts { touching: kept as u32, ..frame.counts }
    }

    /// Upper bound of the outer radius of the smaller body in the last update.
    pub(super) fn body(&self) -> SmallerBody {
        self.body
    }

    /// Number of pairs of parts that touch.
    pub fn len(&self) -> usize {
        self.used
    }

    /// True if no pair of parts touches.
    pub fn is_empty(&self) -> bool {
        self.used == 0
    }

    /// The pairs of parts that touch, by their indices in A and in B, and their manifolds.
    ///
    /// A pair keeps its relative place in this order while it touches.
    pub fn iter(&self) -> impl Iterator<Item = ([usize; 2], &Manifold)> {
        self.entries.iter().filter(|entry| entry.touches).map(|entry| (entry.pair, &entry.manifold))
    }

    /// [`iter`](Self::iter), for storing impulses and user data.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = ([usize; 2], &mut Manifold)> {
        self.entries.iter_mut().filter(|entry| entry.touches).map(|entry| (entry.pair, &mut entry.manifold))
    }

    /// The manifold of a pair of parts; `None` if they do not touch.
    #[expect(clippy::indexing_slicing, reason = "`order` is a permutation of the entries; `used` is within")]
    pub fn get(&self, pair: [usize; 2]) -> Option<&Manifold> {
        let at = self.order[..self.used].binary_search_by_key(&pair, |entry| self.entries[*entry].pair).ok()?;
        Some(&self.entries[self.order[at]].manifold)
    }

    /// Lends scratch memory to the queries of the updates, as [`Cache::set_scratch`] does.
    pub fn set_scratch(&mut self, scratch: Box<Scratch>) {
        self.scratch = Some(scratch);
    }

    /// Returns the scratch memory that was lent, if any.
    pub fn take_scratch(&mut self) -> Option<Box<Scratch>> {
        self.scratch.take()
    }

    /// Removes all manifolds and clears the caches.
    pub fn clear(&mut self) {
        let frame = self.start();
        self.finish(frame);
        self.others.clear();
    }
}

/// An update in progress.
struct Frame {
    /// Number of entries in use before it.
    old: usize,
    counts: ManifoldCounts,
    /// The deepest manifold that the correction has removed.
    removed: Option<([usize; 2], Manifold)>,
}

impl Frame {
    fn remove(&mut self, pair: [usize; 2], manifold: Manifold) {
        // Ties go to the lowest pair, so that the answer does not depend on the order of visits.
        let is_first = self.removed.as_ref().is_none_or(|(other, deepest)| {
            let [own, most] = [&manifold, deepest].map(Manifold::deepest);
            own > most || own == most && pair < *other
        });
        if is_first {
            self.removed = Some((pair, manifold));
        }
    }

    fn count(&mut self, contact: &Contact) {
        self.counts.pairs += 1;
        self.counts.iterations += contact.iterations;
        self.counts.support_calls += contact.support_calls;
    }
}

struct BodyPair<'u> {
    b_in_a: Pose,
    /// The union that A is in, the index of its first part there, and its pose.
    in_a: Option<(&'u dyn Union, usize, Pose)>,
    in_b: Option<&'u dyn Union>,
    /// Whether A is all of its union.
    is_whole: bool,
    settings: &'u ManifoldSettings,
}
