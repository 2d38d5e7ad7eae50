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

/// One shape for each source object of a pack, in the order of the pack. All shapes have the frame
/// of the pack.
///
/// # Complexity
/// O(n log n) in the number of parts, for the trees of the compounds. The hulls are not copied.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
/// # fn main() {
/// # let pack = pack();
/// use std::sync::Arc;
///
/// let pack: Arc<hullmap::Pack> = Arc::new(pack);
/// let objects = hullmap_parry::objects(&pack);
/// assert_eq!(objects[1].name, "cube");
/// assert!(objects[1].shape.as_shape::<hullmap_parry::BakedHull>().is_some());
/// # }
/// ```
pub fn objects(pack: &Arc<Pack>) -> Vec<Object> {
    let mut objects: Vec<(String, Vec<SharedHull>)> = Vec::new();
    for hull in hulls(pack) {
        match objects.last_mut() {
            // The parts of an object follow one another, counted from 0.
            Some((_, parts)) if hull.hull().part() > 0 => parts.push(hull),
            _ => objects.push((hull.hull().name().to_owned(), vec![hull])),
        }
    }
    objects
        .into_iter()
        .filter_map(|(name, parts)| Some(Object { name, shape: union(parts.into_iter().map(BakedHull::new))? }))
        .collect()
}

/// All hulls of a pack as one shape: their union. `None` for a pack without hulls.
///
/// Its mass is [`Pack::mass_properties`]: the mass of the meshes, if the pack records it.
///
/// # Complexity
/// As [`objects`].
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = std::sync::Arc::new(two_cubes());
/// use parry3d::math::Vector;
///
/// // Two unit cubes, at x from 0 to 1 and from 3 to 4.
/// let cubes = hullmap_parry::compound(&pack).ok_or("no hulls")?;
/// assert_eq!(cubes.as_compound().ok_or("one hull")?.shapes().len(), 2);
/// assert!(cubes.compute_local_aabb().maxs.distance(Vector::new(4.0, 1.0, 1.0)) < 1e-5);
/// # Ok(())
/// # }
/// ```
pub fn compound(pack: &Arc<Pack>) -> Option<SharedShape> {
    union(hulls(pack).map(BakedHull::new))
}

fn hulls(pack: &Arc<Pack>) -> impl Iterator<Item = SharedHull> {
    (0..pack.hull_count()).filter_map(|index| pack.shared_hull(index).ok())
}

/// Some hulls of packs as one shape: their union. `None` if there are none.
///
/// Where all parts of an object follow one another, the shape has the mass of the object's mesh, if
/// the pack records it. Otherwise it has the sum of the hulls' masses.
///
/// # Complexity
/// As [`objects`].
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = std::sync::Arc::new(two_cubes());
/// use hullmap_parry::BakedHull;
///
/// let hulls = [pack.shared_hull(0)?, pack.shared_hull(1)?].map(BakedHull::new);
/// let both = hullmap_parry::union(hulls).ok_or("no hulls")?;
/// assert!((both.mass_properties(3.0).mass() - 6.0).abs() < 1e-5);
/// # Ok(())
/// # }
/// ```
pub fn union(hulls: impl IntoIterator<Item = BakedHull>) -> Option<SharedShape> {
    let mut hulls: Vec<BakedHull> = hulls.into_iter().collect();
    if hulls.len() <= 1 {
        return hulls.pop().map(SharedShape::from);
    }
    share_masses(&mut hulls);
    let parts = hulls.into_iter().map(|hull| (Pose::identity(), hull.into()));
    Some(SharedShape::new(Compound::new(parts.collect())))
}
