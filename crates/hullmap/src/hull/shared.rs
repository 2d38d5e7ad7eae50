//! A hull that keeps its pack alive.

use std::{fmt, sync::Arc};

use glam::DVec3;

use super::Hull;
use crate::{
    facets::view::Facets,
    pack::{NoHullNamed, NoSuchHull, Pack},
    shapes::{Feature, Shape},
    solver::Ray,
    support::{Lookup, SupportMap, SupportPoint},
};

self_cell::self_cell!(
    struct Cell {
        owner: Arc<Pack>,
        #[covariant]
        dependent: Hull,
    }
);

/// A convex hull together with a reference-counted handle to its [`Pack`]. It has no lifetime, so
/// it can be stored in a component, sent to a thread, or returned.
///
/// [`Pack::shared_hull`] makes one. It is a shape like [`Hull`], with the same answers at the same
/// cost. For everything else, [`hull`](Self::hull) borrows the hull. A clone shares the pack and
/// allocates nothing. The pack is freed with its last owner.
///
/// A whole pack needs no such type: store an `Arc<Pack>`, and create a
/// [`Compound`](crate::Compound) from it for each query, which copies one reference.
///
/// # Examples
/// A type without a lifetime, queried on another thread:
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use std::{sync::Arc, thread};
/// use hullmap::{Cache, Pack, Pose, Settings, SharedHull, glam::DVec3};
///
/// struct Collider {
///     shape: SharedHull,
///     world: Pose,
/// }
///
/// let pack: Arc<Pack> = Arc::new(pack());
/// let collider = Collider {
///     shape: pack.shared_hull_named("cube")?,
///     world: Pose::from_translation(DVec3::new(5.0, 0.0, 0.0))?,
/// };
/// let probe = collider.shape.clone();
/// drop(pack);
/// let gap = thread::spawn(move || {
///     let settings = Settings::default();
///     hullmap::distance(&probe, &collider.shape, collider.world, &settings, &mut Cache::default())
/// });
/// // Two cubes of edge length 2, five units from centre to centre.
/// assert!((gap.join().expect("no panic").distance - 3.0).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct SharedHull {
    cell: Arc<Cell>,
    index: usize,
}

/// Hulls that keep the pack alive.
impl Pack {
    /// The hull of index `index`, counted from 0, as a value that keeps the pack alive.
    ///
    /// # Errors
    /// [`NoSuchHull`] if `index` is not below [`hull_count`](Self::hull_count).
    ///
    /// # Complexity
    /// O(1), one allocation. Clones of the result allocate nothing.
    pub fn shared_hull(self: &Arc<Self>, index: usize) -> Result<SharedHull, NoSuchHull> {
        SharedHull::new(Arc::clone(self), index)
    }

    /// The first hull named `name`, as a value that keeps the pack alive.
    ///
    /// # Errors
    /// [`NoHullNamed`], with the names of the hulls, if there is no such hull.
    ///
    /// # Complexity
    /// O(number of hulls).
    pub fn shared_hull_named(self: &Arc<Self>, name: &str) -> Result<SharedHull, NoHullNamed> {
        let index = self.hulls().position(|hull| hull.name() == name);
        index.and_then(|index| self.shared_hull(index).ok()).ok_or_else(|| self.no_hull_named(name))
    }
}

impl SharedHull {
    pub(crate) fn new(pack: Arc<Pack>, index: usize) -> Result<Self, NoSuchHull> {
        let cell = Cell::try_new(pack, |pack| pack.hull(index))?;
        Ok(Self { cell: Arc::new(cell), index })
    }

    /// The hull.
    ///
    /// # Complexity
    /// O(1): two pointer dereferences.
    #[inline(always)]
    pub fn hull(&self) -> &Hull<'_> {
        self.cell.borrow_dependent()
    }

    /// The pack that the hull is from.
    pub fn pack(&self) -> &Arc<Pack> {
        self.cell.borrow_owner()
    }

    /// Index of the hull in its pack.
    pub fn index(&self) -> usize {
        self.index
    }
}

impl fmt::Debug for SharedHull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.hull().name();
        f.debug_struct("SharedHull").field("index", &self.index).field("name", &name).finish_non_exhaustive()
    }
}

impl SupportMap for SharedHull {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        SupportMap::support_point(self.hull(), dir)
    }

    #[inline]
    fn interior_point(&self) -> DVec3 {
        self.hull().interior_point()
    }

    #[inline]
    fn inner_radius(&self) -> f64 {
        self.hull().inner_radius()
    }

    #[inline]
    fn outer_radius(&self) -> f64 {
        self.hull().outer_radius()
    }

    #[inline]
    fn support_error(&self) -> f64 {
        self.hull().support_error()
    }

    #[inline]
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.hull().point(feature)
    }

    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        self.hull().polytope_vertex(index)
    }

    #[inline(always)]
    fn fetch_ahead(&self) {
        self.hull().fetch_ahead();
    }

    #[inline(always)]
    fn fetch_part(&self, part: usize) -> bool {
        self.hull().fetch_part(part)
    }

    #[inline(always)]
    fn start_lookup(&self, dir: DVec3) -> Lookup {
        self.hull().start_lookup(dir)
    }

    #[inline(always)]
    fn continue_lookup(&self, dir: DVec3, lookup: Lookup) -> Lookup {
        self.hull().continue_lookup(dir, lookup)
    }

    #[inline(always)]
    fn finish_lookup(&self, dir: DVec3, lookup: Lookup) -> SupportPoint {
        self.hull().finish_lookup(dir, lookup)
    }

    #[inline(always)]
    fn working_set_len(&self) -> usize {
        self.hull().working_set_len()
    }

    #[inline(always)]
    fn facets(&self) -> Option<Facets<'_>> {
        self.hull().facets()
    }

    fn stored_bounds(&self) -> Option<[DVec3; 2]> {
        self.hull().stored_bounds()
    }

    #[inline]
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        SupportMap::support_point_from(self.hull(), dir, hint)
    }
}

impl Shape for SharedHull {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.hull().feature(dir, out);
    }
    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.hull().feature_within(dir, reach, out);
    }
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.hull().reduced_feature_within(dir, reach, out);
    }
    fn entry(&self, ray: &Ray, near: u32) -> Option<f64> {
        self.hull().entry(ray, near)
    }
}
