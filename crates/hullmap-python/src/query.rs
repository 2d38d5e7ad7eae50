//! The queries of a pair: one method for each pair of kinds of shapes.
//!
//! Hull against hull has code of its own. All other convex pairs share one instance, by reference
//! to a trait object.

use hullmap::compound::{self, CompoundAnswer, Parts};
use hullmap::manifold::{Manifold, ManifoldSettings};
use hullmap::shapes::HalfSpace;
use hullmap::{
    self as core, Cache, CastSettings, Compound, CompoundCache, Contact, Distance, Impact, Intersection, Motion, Pose,
    Settings, Shape, Status,
};

use crate::shape::{AnyConvex, Side};

/// Entries of a compound's cache: pairs of parts that are near each other in one pose.
const COMPOUND_SLOTS: usize = 16;

/// An answer, with the parts that decided it.
pub struct Found<T> {
    pub answer: T,
    pub parts: [u32; 2],
}

impl<T> From<T> for Found<T> {
    fn from(answer: T) -> Self {
        Self { answer, parts: [0, 0] }
    }
}

fn of_compound<T>(found: CompoundAnswer<T>) -> Found<T> {
    Found { answer: found.answer, parts: found.hulls.map(|hull| u32::try_from(hull).unwrap_or(u32::MAX)) }
}

/// A query of two shapes under one pose.
pub trait ShapeQuery: Sync {
    type Answer;

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        cache: &mut Cache,
    ) -> Self::Answer;

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, b_in_a: Pose) -> Self::Answer;

    /// `None` if there is no such query of compounds.
    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        a: &A,
        b: &B,
        b_in_a: Pose,
        cache: &mut CompoundCache,
    ) -> Option<Found<Self::Answer>>;

    /// `None` if there is no such query of compounds.
    fn half_space_compound<B: Parts + ?Sized>(&self, a: &HalfSpace, b: &B, b_in_a: Pose)
    -> Option<Found<Self::Answer>>;
}

/// Caches of a pair, or of the pairs that one thread queries.
#[derive(Default)]
pub struct Caches {
    /// Of convex shapes.
    pub pair: Cache,
    compound: Option<CompoundCache>,
}

impl Caches {
    /// The cache of compounds, which allocates: it is made by the first query that needs it.
    pub fn compound(&mut self) -> &mut CompoundCache {
        self.compound.get_or_insert_with(|| CompoundCache::new(COMPOUND_SLOTS))
    }

    /// Forgets the last pose.
    pub fn clear(&mut self) {
        self.pair.clear();
        if let Some(cache) = &mut self.compound {
            cache.clear();
        }
    }
}

/// Why a pair of shapes cannot be queried.
pub fn obstacle(query: &str, a: &Side, b: &Side, takes_compounds: bool) -> Option<String> {
    if matches!(b, Side::HalfSpace(_)) {
        let remedy = "make it the first shape, and pass the pose of the other one in its frame";
        return Some(format!("{query}: a half-space must be the first shape of a pair: {remedy}"));
    }
    if takes_compounds {
        return None;
    }
    [a, b].into_iter().find_map(|side| match side {
        Side::Compound(_) => {
            Some(format!("{query} takes convex shapes, found a pack: query it by {query}s, or its hulls one by one"))
        }
        Side::Sheet(sheet) => {
            Some(format!("{query} takes convex shapes, found {}: query it by {query}s", sheet.name()))
        }
        _ => None,
    })
}

/// Answers `query` for one pose. `None` for pairs that [`obstacle`] reports.
pub fn answer<Q: ShapeQuery>(
    query: &Q,
    a: &Side,
    b: &Side,
    b_in_a: Pose,
    caches: &mut Caches,
) -> Option<Found<Q::Answer>> {
    let cache = &mut caches.pair;
    match (a, b) {
        (Side::Hull(a), Side::Hull(b)) => Some(query.convex(a.hull(), b.hull(), b_in_a, cache).into()),
        (Side::HalfSpace(a), Side::Compound(b)) => query.half_space_compound(a, &Compound::new(b), b_in_a),
        (Side::HalfSpace(a), Side::Sheet(b)) => query.half_space_compound(a, b, b_in_a),
        (Side::HalfSpace(a), _) => Some(query.half_space(a, convex(b)?, b_in_a).into()),
        (Side::Compound(a), _) => against(query, &Compound::new(a), b, b_in_a, caches),
        (Side::Sheet(a), _) => against(query, a, b, b_in_a, caches),
        (_, Side::Compound(_) | Side::Sheet(_)) => against(query, convex(a)?, b, b_in_a, caches),
        _ => Some(query.convex(convex(a)?, convex(b)?, b_in_a, cache).into()),
    }
}

/// Answers `query` for parts against any bounded shape.
fn against<Q: ShapeQuery, A: Parts + ?Sized>(
    query: &Q,
    a: &A,
    b: &Side,
    b_in_a: Pose,
    caches: &mut Caches,
) -> Option<Found<Q::Answer>> {
    let cache = caches.compound();
    match b {
        Side::Compound(b) => query.compound(a, &Compound::new(b), b_in_a, cache),
        Side::Sheet(b) => query.compound(a, b, b_in_a, cache),
        _ => query.compound(a, convex(b)?, b_in_a, cache),
    }
}

/// The shape as one convex body.
pub fn convex(side: &Side) -> Option<&AnyConvex> {
    match side {
        Side::Hull(hull) => Some(hull),
        Side::Convex(shape) => Some(&**shape),
        Side::HalfSpace(_) | Side::Compound(_) | Side::Sheet(_) => None,
    }
}

pub struct Intersects;

impl ShapeQuery for Intersects {
    type Answer = Intersection;

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut Cache,
    ) -> Intersection {
        core::intersects(a, b, pose, cache)
    }

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Intersection {
        a.intersects(b, pose)
    }

    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut CompoundCache,
    ) -> Option<Found<Intersection>> {
        Some(of_compound(compound::intersects(a, b, pose, cache)))
    }

    fn half_space_compound<B: Parts + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Option<Found<Intersection>> {
        Some(of_compound(compound::half_space::intersects(a, b, pose)))
    }
}

pub struct Distances(pub Settings);

impl ShapeQuery for Distances {
    type Answer = Distance;

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(&self, a: &A, b: &B, pose: Pose, cache: &mut Cache) -> Distance {
        core::distance(a, b, pose, &self.0, cache)
    }

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Distance {
        a.distance(b, pose)
    }

    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut CompoundCache,
    ) -> Option<Found<Distance>> {
        Some(of_compound(compound::distance(a, b, pose, &self.0, cache)))
    }

    fn half_space_compound<B: Parts + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Option<Found<Distance>> {
        Some(of_compound(compound::half_space::distance(a, b, pose)))
    }
}

pub struct Contacts(pub Settings);

impl ShapeQuery for Contacts {
    type Answer = Contact;

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(&self, a: &A, b: &B, pose: Pose, cache: &mut Cache) -> Contact {
        core::contact(a, b, pose, &self.0, cache)
    }

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Contact {
        a.contact(b, pose)
    }

    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut CompoundCache,
    ) -> Option<Found<Contact>> {
        Some(match compound::contact(a, b, pose, &self.0, cache) {
            Some(found) => of_compound(found),
            // Separated compounds have no single separating plane, and no points.
            None => {
                let nothing = core::glam::DVec3::NAN;
                let (normal, point_a, point_b) = (nothing, nothing, nothing);
                let separated =
                    Contact { hit: false, status: Status::Separated, depth_upper: 0.0, ..Contact::default() };
                Contact { normal, point_a, point_b, ..separated }.into()
            }
        })
    }

    fn half_space_compound<B: Parts + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Option<Found<Contact>> {
        Some(of_compound(compound::half_space::contact(a, b, pose)))
    }
}

pub struct Manifolds(pub ManifoldSettings);

impl ShapeQuery for Manifolds {
    type Answer = (Manifold, Contact);

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut Cache,
    ) -> (Manifold, Contact) {
        let mut manifold = Manifold::new();
        let contact = manifold.update(a, b, pose, &self.0, cache);
        (manifold, contact)
    }

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> (Manifold, Contact) {
        let mut manifold = Manifold::new();
        let contact = manifold.update_half_space(a, b, pose, &self.0);
        (manifold, contact)
    }

    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        _: &A,
        _: &B,
        _: Pose,
        _: &mut CompoundCache,
    ) -> Option<Found<(Manifold, Contact)>> {
        None
    }

    fn half_space_compound<B: Parts + ?Sized>(
        &self,
        _: &HalfSpace,
        _: &B,
        _: Pose,
    ) -> Option<Found<(Manifold, Contact)>> {
        None
    }
}

/// A cast of B by one motion.
pub struct Cast(pub CastSettings, pub Motion);

impl ShapeQuery for Cast {
    type Answer = Impact;

    fn convex<A: Shape + ?Sized, B: Shape + ?Sized>(&self, a: &A, b: &B, pose: Pose, cache: &mut Cache) -> Impact {
        core::cast(a, b, pose, self.1, &self.0, cache)
    }

    fn half_space<B: Shape + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Impact {
        a.cast(b, pose, self.1, &self.0)
    }

    fn compound<A: Parts + ?Sized, B: Parts + ?Sized>(
        &self,
        a: &A,
        b: &B,
        pose: Pose,
        cache: &mut CompoundCache,
    ) -> Option<Found<Impact>> {
        Some(of_compound(compound::cast(a, b, pose, self.1, &self.0, cache)))
    }

    fn half_space_compound<B: Parts + ?Sized>(&self, a: &HalfSpace, b: &B, pose: Pose) -> Option<Found<Impact>> {
        Some(of_compound(compound::half_space::cast(a, b, pose, self.1, &self.0)))
    }
}
