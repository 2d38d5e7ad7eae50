//! Warm-start cache: what a pair keeps from one query to the next.
//!
//! - The last separating axis. One support call usually proves a miss again. After a contact by the
//!   separating axis test, its normal: the best guess for the next normal, or for the axis of a
//!   miss.
//! - The last portal. It usually proves a hit again without any support call.
//! - The last simplex near the origin. GJK continues from it. After a shallow contact, it is the
//!   face that decided, which one support query may prove again.
//! - The last polytope. EPA continues from it.
//! - For geometries with parts, the same for the most recent pairs of parts, and the pair that
//!   decided the last query.
//!
//! # Reference
//! Kenwright, sections 4.1, 4.6 and 4.7: the last solution is the next starting point.
//!
//! # Deviations
//! - The cache holds features, not points. Under a new pose a feature is a point of the new
//!   Minkowski difference; an old point is not. So a stale cache, or the cache of another pair,
//!   costs steps but cannot make an answer wrong. For shapes whose features are not points
//!   ([`SupportMap::point`](crate::SupportMap::point)) only the axis is kept.

use super::minkowski::Point;
use super::scratch::{Lent, Scratch};
use crate::vector::unit;
use glam::DVec3;

/// Maximum number of vertices of a cached polytope.
pub(super) const MAX_POINTS: usize = 56;

/// Number of face places of a cached polytope.
const MAX_FACES: usize = 2 * MAX_POINTS;

/// Caller-owned memory of one ordered pair (A, B), passed to every query of that pair.
///
/// It changes the cost of a query, and its answer only within the certified interval. An empty
/// cache is always valid, and so is the cache of another pair. All directions are in A's frame.
///
/// # Memory
/// It takes 1.3 KB, and no memory elsewhere for two convex shapes, unless
/// [`set_scratch`](Self::set_scratch) lends it some. If A or B has parts (a compound, a mesh, a
/// field), it also has an entry of 1.4 KB for each of the most recent pairs of parts. The first
/// such query allocates 64 of them; [`with_pairs`](Self::with_pairs) allocates them ahead.
///
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Pose, intersects, shapes::Cuboid};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// let mut cache = Cache::new();
/// for frame in 0..10 {
///     let b_in_a = Pose::from_translation(DVec3::new(1.9, 0.1 * f64::from(frame), 0.3))?;
///     let answer = intersects(&cube, &cube, b_in_a, &mut cache);
///     assert!(answer.is_hit());
/// }
/// // The next pair starts from an empty cache; keeping this one would only cost steps.
/// cache.clear();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
// Fields that every query reads come first, so that batches can fetch them ahead.
#[repr(C)]
pub struct Cache {
    /// The last separating axis, from A to B, or the last normal of a small hull.
    axis: Option<DVec3>,
    portal: Option<[[u32; 2]; 3]>,
    simplex: [[u32; 2]; 3],
    simplex_count: u8,
    /// The simplex is the face of a contact.
    simplex_is_face: bool,
    /// There is no simplex yet, so GJK starts from the support point along the axis.
    starts_from_axis: bool,
    point_count: u8,
    face_count: u8,
    scratch: Lent,
    /// `None` until the first query of parts.
    parts: Option<Box<PartCaches>>,
    /// `None` until the first polytope is kept, so that an empty cache costs no writes.
    polytope: Option<Polytope>,
}

/// Caches of the most recent pairs of parts.
#[derive(Clone, Debug, PartialEq)]
struct PartCaches {
    entries: Box<[Entry]>,
    /// The pair that decided the last query.
    first: Option<[usize; 2]>,
    /// The entry whose cache has the scratch memory, if any was lent.
    lent_to: Option<usize>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Entry {
    pair: Option<[usize; 2]>,
    cache: Cache,
}

/// Default number of pairs of parts: twice what two parts need that are each in contact with a
/// dozen others. 90 KB.
const DEFAULT_PAIRS: usize = 64;

impl PartCaches {
    fn new(pairs: usize) -> Self {
        Self { entries: vec![Entry::default(); pairs.max(1)].into_boxed_slice(), first: None, lent_to: None }
    }

    fn clear(&mut self) {
        self.first = None;
        for entry in &mut self.entries {
            entry.pair = None;
            entry.cache.clear();
        }
    }
}

/// The polytope of a [`Cache`]. The first `point_count` points and `face_count` faces are in use.
#[derive(Clone, Debug, PartialEq)]
struct Polytope {
    points: [[u32; 2]; MAX_POINTS],
    corners: [[u8; 3]; MAX_FACES],
    neighbours: [[u8; 3]; MAX_FACES],
}

impl Polytope {
    const EMPTY: Self =
        Self { points: [[0; 2]; MAX_POINTS], corners: [[0; 3]; MAX_FACES], neighbours: [[0; 3]; MAX_FACES] };
}

impl Default for Cache {
    #[inline]
    fn default() -> Self {
        Self {
            axis: None,
            starts_from_axis: false,
            portal: None,
            simplex: [[0; 2]; 3],
            simplex_count: 0,
            simplex_is_face: false,
            point_count: 0,
            face_count: 0,
            scratch: Lent::default(),
            parts: None,
            polytope: None,
        }
    }
}

/// A cached polytope: features of its vertices, and corners and neighbours of its faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct CachedPolytope<'c> {
    pub(super) points: &'c [[u32; 2]],
    pub(super) corners: &'c [[u8; 3]],
    pub(super) neighbours: &'c [[u8; 3]],
}

impl Cache {
    /// An empty cache.
    #[inline]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty cache with entries for `pairs` pairs of parts, at least one. A pair is assigned to
    /// an entry by its indices; if two pairs share an entry, the later one replaces the earlier
    /// one.
    pub fn with_pairs(pairs: usize) -> Self {
        Self { parts: Some(Box::new(PartCaches::new(pairs))), ..Self::default() }
    }

    /// A cache that starts from a direction, for pairs that have no memory of their own, such as
    /// the triangles of a mesh: three numbers kept from the last frame instead of a cache.
    ///
    /// `dir` points from A to B, in A's frame; it need not be of unit length. It is a guess, for
    /// instance the last normal, and cannot make an answer wrong. If it is zero or not finite, the
    /// cache is empty.
    ///
    /// # Complexity
    /// If `dir` is still a separating axis, [`intersects`](crate::intersects()) and
    /// [`contact`](crate::contact()) take one support call; if not, one call more than without it.
    /// [`distance`](crate::distance()), and every query of rounded shapes, starts from the support
    /// points along `dir`.
    pub fn from_axis(dir: DVec3) -> Self {
        let axis = unit(dir);
        Self { axis, starts_from_axis: axis.is_some(), ..Self::default() }
    }

    /// Empties the cache.
    pub fn clear(&mut self) {
        self.starts_from_axis = false;
        self.forget_axis();
        self.portal = None;
        (self.simplex_count, self.simplex_is_face) = (0, false);
        self.forget_polytope();
        if let Some(parts) = &mut self.parts {
            parts.clear();
        }
    }

    /// Cache of one pair of parts, by their indices in A and in B. It is empty if the pair was not
    /// cached.
    #[expect(clippy::indexing_slicing, reason = "taken modulo the number of entries, which is at least one")]
    pub(crate) fn pair(&mut self, pair: [usize; 2]) -> &mut Self {
        let scratch = self.take_scratch();
        let parts = self.parts.get_or_insert_with(|| Box::new(PartCaches::new(DEFAULT_PAIRS)));
        // The factor sends neighbouring pairs to different entries.
        let index = (pair[0].wrapping_mul(31).wrapping_add(pair[1])) % parts.entries.len();
        let entry = &mut parts.entries[index];
        if entry.pair != Some(pair) {
            entry.pair = Some(pair);
            entry.cache.clear();
        }
        // The scratch memory moves to the cache in use.
        parts.lent_to = scratch.is_some().then_some(index);
        entry.cache.scratch.0 = scratch;
        &mut entry.cache
    }

    /// The pair of parts that decided the last query, if it exists in geometries with this many
    /// parts.
    pub(crate) fn first(&self, counts: [usize; 2]) -> Option<[usize; 2]> {
        self.parts.as_ref()?.first.filter(|pair| pair[0] < counts[0] && pair[1] < counts[1])
    }

    pub(crate) fn set_first(&mut self, pair: [usize; 2]) {
        if let Some(parts) = &mut self.parts {
            parts.first = Some(pair);
        }
    }

    /// Copies what another cache holds: of its polytope, what is in use.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (self.axis, self.portal, self.simplex) = (other.axis, other.portal, other.simplex);
        (self.simplex_count, self.starts_from_axis) = (other.simplex_count, other.starts_from_axis);
        self.simplex_is_face = other.simplex_is_face;
        (self.point_count, self.face_count) = (0, 0);
        if let Some(polytope) = other.polytope.as_ref().filter(|_| other.point_count > 0) {
            let own = self.polytope.get_or_insert(Polytope::EMPTY);
            let (points, faces) = (other.point_count.into(), other.face_count.into());
            own.points[..points].copy_from_slice(&polytope.points[..points]);
            own.corners[..faces].copy_from_slice(&polytope.corners[..faces]);
            own.neighbours[..faces].copy_from_slice(&polytope.neighbours[..faces]);
            (self.point_count, self.face_count) = (other.point_count, other.face_count);
        }
    }

    /// Lends scratch memory to the queries that use this cache, until it is
    /// [taken back](Self::take_scratch). Memory lent before is dropped. [`Scratch`] has an example.
    pub fn set_scratch(&mut self, scratch: Box<Scratch>) {
        self.scratch.0 = Some(scratch);
    }

    /// Returns the scratch memory that the cache was lent, if any.
    pub fn take_scratch(&mut self) -> Option<Box<Scratch>> {
        self.scratch.0.take().or_else(|| {
            let parts = self.parts.as_mut()?;
            parts.entries.get_mut(parts.lent_to.take()?)?.cache.take_scratch()
        })
    }

    pub(super) fn scratch(&mut self) -> Option<&mut Scratch> {
        self.scratch.0.as_deref_mut()
    }

    pub(crate) fn axis(&self) -> Option<DVec3> {
        self.axis
    }

    /// The axis, if GJK is to start from it.
    pub(super) fn start(&self) -> Option<DVec3> {
        self.axis.filter(|_| self.starts_from_axis)
    }

    /// Whether a contact could start from nothing, or from the axis of [`Self::from_axis`] alone.
    pub(super) fn is_new(&self) -> bool {
        (self.axis.is_none() || self.starts_from_axis) && self.point_count == 0 && !self.simplex_is_face
    }

    pub(crate) fn set_axis(&mut self, axis: DVec3) {
        self.axis = Some(axis);
    }

    /// Stores what a miss found: the axis, for the next miss, and the points seen, for a distance
    /// query.
    pub(super) fn set_separation(&mut self, axis: DVec3, seen: &[Point; 3]) {
        self.axis = unit(axis).or(self.axis);
        self.set_simplex(seen.iter().map(|v| v.features));
    }

    pub(crate) fn forget_axis(&mut self) {
        self.axis = None;
    }

    pub(crate) fn portal(&self) -> Option<[[u32; 2]; 3]> {
        self.portal
    }

    pub(crate) fn set_portal(&mut self, vertices: &[Point; 3]) {
        self.portal = Some(vertices.map(|v| v.features));
    }

    pub(crate) fn simplex(&self) -> &[[u32; 2]] {
        &self.simplex[..usize::from(self.simplex_count)]
    }

    /// Stores up to three vertices. The centre is left out, since every query computes it.
    #[inline]
    pub(crate) fn set_simplex(&mut self, vertices: impl IntoIterator<Item = [u32; 2]>) {
        self.simplex_is_face = false;
        self.simplex_count = 0;
        for features in vertices.into_iter().filter(|features| *features != Point::CENTER).take(3) {
            self.simplex[usize::from(self.simplex_count)] = features;
            self.simplex_count += 1;
        }
    }

    /// The corners of the last contact's face, if it had one.
    pub(super) fn face(&self) -> Option<[[u32; 2]; 3]> {
        (self.simplex_is_face && self.simplex_count == 3).then_some(self.simplex)
    }

    pub(super) fn forget_face(&mut self) {
        self.simplex_is_face = false;
    }

    pub(super) fn keep_face(&mut self, corners: [[u32; 2]; 3]) {
        self.set_simplex(corners);
        self.simplex_is_face = true;
    }

    pub(super) fn polytope(&self) -> Option<CachedPolytope<'_>> {
        let (points, faces) = (usize::from(self.point_count), usize::from(self.face_count));
        if points == 0 {
            return None;
        }
        let polytope = self.polytope.as_ref()?;
        Some(CachedPolytope {
            points: &polytope.points[..points],
            corners: &polytope.corners[..faces],
            neighbours: &polytope.neighbours[..faces],
        })
    }

    pub(crate) fn has_polytope(&self) -> bool {
        self.point_count > 0
    }

    pub(super) fn forget_polytope(&mut self) {
        self.point_count = 0;
    }

    /// Stores a polytope, or none if it is too large.
    pub(super) fn keep_polytope(&mut self, points: &[[u32; 2]], (corners, neighbours): (&[[u16; 3]], &[[u16; 3]])) {
        self.point_count = 0;
        if points.len() > MAX_POINTS || corners.len() > MAX_FACES {
            return;
        }
        let polytope = self.polytope.get_or_insert(Polytope::EMPTY);
        polytope.points[..points.len()].copy_from_slice(points);
        for (to, from) in polytope.corners.iter_mut().zip(corners) {
            *to = from.map(|c| c as u8);
        }
        for (to, from) in polytope.neighbours.iter_mut().zip(neighbours) {
            *to = from.map(|c| c as u8);
        }
        (self.point_count, self.face_count) = (points.len() as u8, corners.len() as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cached_simplex_omits_the_centre() {
        let mut cache = Cache::new();
        cache.set_simplex([[3, 4], Point::CENTER]);
        assert_eq!(cache.simplex(), &[[3, 4]]);
        cache.clear();
        assert!(cache.simplex().is_empty());
    }

    #[test]
    fn a_cached_polytope_is_restored_unchanged() {
        let mut cache = Cache::new();
        assert!(cache.polytope().is_none());
        let points = [1, 2, 3, 4].map(|i| [i, 10 + i]);
        let (corners, neighbours) = ([[0, 1, 2], [0, 3, 1]], [[1, 2, 3], [3, 2, 0]]);
        cache.keep_polytope(&points, (&corners.map(|c| c.map(u16::from)), &neighbours.map(|n| n.map(u16::from))));
        let kept = cache.polytope().unwrap();
        assert_eq!(kept.points, points);
        assert!(kept.corners.iter().zip(kept.neighbours).eq(corners.iter().zip(&neighbours)));
        cache.keep_polytope(&[[0; 2]; MAX_POINTS + 1], (&[], &[]));
        assert!(cache.polytope().is_none());
    }

    #[test]
    fn size_matches_the_documentation() {
        assert!(size_of::<Cache>() <= 1331, "{}", size_of::<Cache>());
    }
}
