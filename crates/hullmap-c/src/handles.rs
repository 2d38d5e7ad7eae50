//! Types behind the opaque pointers.
//!
//! Packs and shapes never change, so threads share them. A cache or a manifold is written to by
//! each query that takes it; it has a lock that is tried and never waited for, so that a program
//! which breaks the rule gets an error instead of a data race.

#![forbid(unsafe_code)]

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use hullmap::compound::{ManifoldCounts, SharedSheet};
use hullmap::glam::DVec3;
use hullmap::shapes::{HalfSpace, Scaled};
use hullmap::{CompoundManifolds, SharedGeometry};

use crate::failure::{Failure, Fallible};
use crate::types::{ManifoldPoint, ManifoldPoints, Result as Code};

/// An open pack: a file with one or more hulls. It never changes; threads may share it.
#[derive(Debug)]
pub struct Pack(Arc<hullmap::Pack>);

impl Pack {
    pub(crate) fn new(pack: hullmap::Pack) -> Self {
        Self(Arc::new(pack))
    }

    pub(crate) fn pack(&self) -> &Arc<hullmap::Pack> {
        &self.0
    }

    pub(crate) fn hull(&self, index: usize) -> Fallible<hullmap::Hull<'_>> {
        self.0.hull(index).map_err(not_found)
    }
}

fn not_found(error: hullmap::NoSuchHull) -> Failure {
    Failure::new(Code::NotFound, error)
}

/// An open triangle mesh: a static mesh that keeps its triangles. It never changes; threads may
/// share it.
#[derive(Debug)]
pub struct TriangleMesh(pub(crate) Arc<hullmap::TriangleMesh>);

/// An open height field: static ground whose heights are known on a grid. It never changes; threads
/// may share it.
#[derive(Debug)]
pub struct HeightField(pub(crate) Arc<hullmap::HeightField>);

impl From<hullmap::TriangleMesh> for TriangleMesh {
    fn from(mesh: hullmap::TriangleMesh) -> Self {
        Self(Arc::new(mesh))
    }
}

impl From<hullmap::HeightField> for HeightField {
    fn from(field: hullmap::HeightField) -> Self {
        Self(Arc::new(field))
    }
}

/// A shape: a hull, a whole pack as a compound, a triangle mesh, a height field, or a primitive. It
/// never changes; threads may share it. A shape that comes from a file keeps it open.
#[derive(Debug)]
pub struct Shape(pub(crate) SharedGeometry);

impl Shape {
    pub(crate) fn hull(pack: &Pack, index: usize) -> Fallible<Self> {
        pack.0.shared_hull(index).map(|hull| Self(hull.into())).map_err(not_found)
    }

    pub(crate) fn scaled_hull(pack: &Pack, index: usize, scale: DVec3) -> Fallible<Self> {
        Self::convex(Scaled::new(pack.0.shared_hull(index).map_err(not_found)?, scale))
    }

    pub(crate) fn compound(pack: &Pack) -> Self {
        Self(Arc::clone(&pack.0).into())
    }

    pub(crate) fn sheet(sheet: SharedSheet) -> Self {
        Self(SharedGeometry::Sheet(sheet))
    }

    pub(crate) fn half_space(normal: DVec3, offset: f64) -> Fallible<Self> {
        HalfSpace::new(normal, offset).map(|half_space| Self(half_space.into())).map_err(invalid)
    }

    pub(crate) fn convex<S>(shape: Result<S, hullmap::ShapeError>) -> Fallible<Self>
    where
        S: hullmap::Shape + Send + Sync + 'static,
    {
        shape.map(|shape| Self(SharedGeometry::from_shape(shape))).map_err(invalid)
    }
}

fn invalid(error: hullmap::ShapeError) -> Failure {
    Failure::new(Code::InvalidArgument, error)
}

/// A value that one call at a time may use.
#[derive(Debug)]
pub(crate) struct Exclusive<T>(Mutex<T>);

/// A value that can be emptied after a panic, which may have left it inconsistent.
pub(crate) trait Empty {
    fn empty(&mut self);
}

impl<T: Empty> Exclusive<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(Mutex::new(value))
    }

    /// The value, if no other call uses it. `name` is the name of the argument.
    #[inline(always)]
    pub(crate) fn take(&self, name: impl fmt::Display) -> Fallible<MutexGuard<'_, T>> {
        match self.0.try_lock() {
            Ok(value) => Ok(value),
            Err(TryLockError::Poisoned(poisoned)) => {
                self.0.clear_poison();
                let mut value = poisoned.into_inner();
                value.empty();
                Ok(value)
            }
            Err(TryLockError::WouldBlock) => Err(busy(name)),
        }
    }
}

#[cold]
fn busy(name: impl fmt::Display) -> Failure {
    let remedy = "use one for each pair of shapes, in one thread at a time";
    Failure::new(Code::Busy, format_args!("{name} is in use by another call, or was passed twice: {remedy}"))
}

/// Memory of one ordered pair of shapes from query to query. It makes the next query cheaper, and
/// changes answers by no more than rounding error. One call at a time may use it.
#[derive(Debug)]
pub struct Cache(pub(crate) Exclusive<hullmap::Cache>);

impl Cache {
    pub(crate) fn new() -> Self {
        Self(Exclusive::new(hullmap::Cache::new()))
    }
}

impl Empty for hullmap::Cache {
    fn empty(&mut self) {
        self.clear();
    }
}

/// Maximum number of pairs of hulls of a manifold: about 300 MB. A wrong number must not end the
/// process by asking for more memory than there is.
const MAX_PAIRS: u32 = 1 << 16;

/// The contact points of one ordered pair of shapes, kept from step to step. One call at a time may
/// use it.
#[derive(Debug)]
pub struct Manifold(pub(crate) Exclusive<Points>);

impl Manifold {
    pub(crate) fn new(pairs: u32) -> Fallible<Self> {
        if pairs > MAX_PAIRS {
            let message = format_args!("found {pairs}, but a manifold has room for at most {MAX_PAIRS} pairs of hulls");
            return Err(Failure::argument("max_pairs", message));
        }
        let pairs = pairs.max(1) as usize;
        // So that its memory never moves.
        let shown = Vec::with_capacity(pairs * hullmap::manifold::MAX_POINTS);
        Ok(Self(Exclusive::new(Points { pairs, manifolds: None, shown, counts: ManifoldCounts::default() })))
    }
}

/// A manifold, and its points as the caller sees them.
#[derive(Debug)]
pub(crate) struct Points {
    /// Maximum number of pairs of hulls.
    pairs: usize,
    /// Made by the first update.
    manifolds: Option<CompoundManifolds>,
    /// The caller writes impulses and user data here.
    shown: Vec<ManifoldPoint>,
    counts: ManifoldCounts,
}

impl Points {
    /// Result of the last update, with a pointer to the points.
    pub(crate) fn answer(&mut self) -> ManifoldPoints {
        let ManifoldCounts { touching, dropped, pairs, iterations, support_calls, .. } = self.counts;
        let (points, count) = (self.shown.as_mut_ptr(), self.shown.len());
        ManifoldPoints { points, count, touching, dropped, pairs, iterations, support_calls }
    }

    /// Takes over what the caller has written since the last update, updates the points, and shows
    /// them to the caller.
    pub(crate) fn update(&mut self, update: impl FnOnce(&mut CompoundManifolds) -> ManifoldCounts) {
        let Self { pairs, manifolds, shown, counts } = self;
        let manifolds = manifolds.get_or_insert_with(|| CompoundManifolds::new(*pairs));
        let points = manifolds.iter_mut().flat_map(|(_, manifold)| manifold.points_mut());
        for (point, shown) in points.zip(shown.iter()) {
            (point.impulse, point.user_data) = (shown.impulse, shown.user_data);
        }
        *counts = update(manifolds);
        shown.clear();
        manifolds.iter().for_each(|(hulls, manifold)| show(manifold, hulls, shown));
    }
}

fn show(manifold: &hullmap::Manifold, hulls: [usize; 2], shown: &mut Vec<ManifoldPoint>) {
    let parts = hulls.map(|hull| hull as u32);
    shown.extend(manifold.points().iter().map(|point| ManifoldPoint {
        normal: manifold.normal(),
        point_a: point.point_a,
        point_b: point.point_b,
        local_b: point.local_b,
        depth: point.depth,
        impulse: point.impulse,
        user_data: point.user_data,
        age: point.age,
        parts,
        feature_a: point.id.on_a().into(),
        feature_b: point.id.on_b().into(),
        status: manifold.status(),
    }));
}

impl Empty for Points {
    fn empty(&mut self) {
        self.counts = ManifoldCounts::default();
        if let Some(manifolds) = &mut self.manifolds {
            manifolds.clear();
        }
        self.shown.clear();
    }
}
