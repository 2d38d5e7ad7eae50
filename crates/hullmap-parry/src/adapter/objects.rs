//! Shapes of a whole pack: one for each object of the source. An object with several convex parts
//! is a compound, which has the mass of the object's mesh if the pack records it.

use std::sync::Arc;

use hullmap::{Pack, SharedHull};

use super::BakedHull;
use super::mass::share_masses;
use super::parry::math::Pose;
use super::parry::shape::{Compound, SharedShape};

/// A source object of a pack, as one shape.
#[derive(Clone)]
pub struct Object {
    /// Name of the object, see [`Hull::name`](hullmap::Hull::name).
    pub name: String,
    /// A [`BakedHull`], or a `Compound` of them if the object was baked as several convex parts.
    pub shape: SharedShape,
}

/// One shape for each source object of a pack, in the order and frame of the pack. O(n log n) in
/// the number of parts, for the trees of the compounds; hulls are not copied.
pub fn objects(pack: &Arc<Pack>) -> Vec<Object> {
    let mut objects: Vec<(String, Vec<SharedHull>)> = Vec::new();
    for hull in hulls(pack) {
        match objects.last_mut() {
            Some((_, parts)) if hull.hull().part() > 0 => parts.push(hull),
            _ => objects.push((hull.hull().name().to_owned(), vec![hull])),
        }
    }
    objects
        .into_iter()
        .filter_map(|(name, parts)| Some(Object { name, shape: union(parts.into_iter().map(BakedHull::new))? }))
        .collect()
}

/// All hulls of a pack as one shape, their union, with the mass of [`Pack::mass_properties`].
/// `None` for a pack without hulls.
pub fn compound(pack: &Arc<Pack>) -> Option<SharedShape> {
    union(hulls(pack).map(BakedHull::new))
}

fn hulls(pack: &Arc<Pack>) -> impl Iterator<Item = SharedHull> {
    (0..pack.hull_count()).filter_map(|index| pack.shared_hull(index).ok())
}

/// Some hulls of packs as one shape, their union; `None` if there are none. Where all parts of an
/// object follow one another, it has the mass of the object's mesh, if the pack records it;
/// otherwise the sum of the hulls' masses.
pub fn union(hulls: impl IntoIterator<Item = BakedHull>) -> Option<SharedShape> {
    let mut hulls: Vec<BakedHull> = hulls.into_iter().collect();
    if hulls.len() <= 1 {
        return hulls.pop().map(SharedShape::from);
    }
    share_masses(&mut hulls);
    let parts = hulls.into_iter().map(|hull| (Pose::identity(), hull.into()));
    Some(SharedShape::new(Compound::new(parts.collect())))
}
