//! A hull that keeps its pack alive.

use std::{fmt, sync::Arc};

use glam::DVec3;

use super::Hull;
use crate::{
    facets::view::Facets,
    pack::{NoHullNamed, NoSuchHull, Pack},
    pose::Pose,
    shapes::{Feature, Shape, shape::forward_shape},
    solver::Ray,
    support::{Bounds, FeaturePoint, LevelEdges, Lookup, SupportMap, SupportPoint, support_map::forward_support_map},
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
    forward_support_map!(self => self.hull());
}

impl Shape for SharedHull {
    forward_shape!(self => self.hull());
}
