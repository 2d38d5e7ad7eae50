//! A pack as an asset of Bevy.

use std::ops::Range;
use std::sync::Arc;

use bevy_asset::Asset;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use hullmap::{Pack, SharedHull};
use hullmap_parry::BakedHull;
use parry3d::shape::SharedShape;

/// A `.hullmap` pack. The [`PackLoader`](crate::PackLoader) makes it, or [`PackAsset::new`].
///
/// Colliders share the pack: it lives as long as one of them, even if the asset is dropped.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = pack();
/// use bevy_math::Vec3;
/// use hullmap_bevy::{PackAsset, Selection};
///
/// // A pack of two hulls: "rock", and "cube", of edge length 2.
/// let asset = PackAsset::new(pack.into());
/// let cube = Selection::Object("cube".into());
/// assert_eq!(asset.select(&cube)?, 1..2);
///
/// // In code that uses Avian or bevy_rapier: `let collider: Collider = asset.collider(..)?`.
/// let shape = asset.shape(&cube, Vec3::new(1.0, 1.0, 3.0))?;
/// assert_eq!(shape.compute_local_aabb().maxs, Vec3::new(1.0, 1.0, 3.0));
/// assert!(asset.shape(&Selection::Hull(2), Vec3::ONE).is_err());
/// # Ok(())
/// # }
/// ```
#[derive(Asset, Reflect, Clone, Debug)]
#[reflect(opaque, Clone, Debug)]
pub struct PackAsset {
    hulls: Vec<SharedHull>,
    pack: Arc<Pack>,
}

/// Which hulls of a pack make a shape.
#[derive(Clone, Debug, Default, PartialEq, Eq, Reflect)]
pub enum Selection {
    /// All hulls of the pack: their union.
    #[default]
    All,
    /// The object of this name in the source mesh: one hull, or all its convex parts. If several
    /// objects have the name, the first.
    Object(String),
    /// The hull of this index in the pack.
    Hull(usize),
}

/// Why a pack has no such shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum ShapeError {
    /// No object has the name.
    #[error("the pack has no object {name:?}; its objects are {available:?}")]
    NoSuchObject { name: String, available: Vec<String> },
    /// No hull has the index.
    #[error("hull index {index} is out of range: the pack has {hull_count}, counted from 0")]
    NoSuchHull { index: usize, hull_count: usize },
    /// The pack has no hull at all.
    #[error("the pack has no hulls")]
    Empty,
    /// The scale cannot be applied.
    #[error("the scale {0} cannot be applied: each factor must be finite, not 0, and neither too small nor too large")]
    Scale(Vec3),
}

/// Maximum number of names in a [`ShapeError`].
pub const NAMES_IN_ERRORS: usize = 8;

impl PackAsset {
    /// The asset of an opened pack.
    ///
    /// # Complexity
    /// O(number of hulls). No hull is copied.
    pub fn new(pack: Arc<Pack>) -> Self {
        let hulls = (0..pack.hull_count()).filter_map(|index| pack.shared_hull(index).ok()).collect();
        Self { hulls, pack }
    }

    /// The pack.
    pub fn pack(&self) -> &Arc<Pack> {
        &self.pack
    }

    /// The hulls of the pack, by index.
    pub fn hulls(&self) -> &[SharedHull] {
        &self.hulls
    }

    /// Indices of the selected hulls. An object's parts follow one another in the pack.
    ///
    /// # Errors
    /// If the pack has no such object or hull.
    pub fn select(&self, selection: &Selection) -> Result<Range<usize>, ShapeError> {
        let hull_count = self.hulls.len();
        if hull_count == 0 {
            return Err(ShapeError::Empty);
        }
        match selection {
            Selection::All => Ok(0..hull_count),
            Selection::Hull(index) if *index < hull_count => Ok(*index..*index + 1),
            Selection::Hull(index) => Err(ShapeError::NoSuchHull { index: *index, hull_count }),
            Selection::Object(name) => {
                let starts_with_name = |hull: &SharedHull| hull.hull().part() == 0 && hull.hull().name() == name;
                let Some(start) = self.hulls.iter().position(starts_with_name) else {
                    // One part of several that were modelled by hand, each with a name.
                    if let Some(index) = self.hulls.iter().position(|hull| hull.hull().name() == name) {
                        return Ok(index..index + 1);
                    }
                    return Err(ShapeError::NoSuchObject { name: name.clone(), available: self.names() });
                };
                let more = self.hulls.iter().skip(start + 1).take_while(|hull| hull.hull().part() > 0).count();
                Ok(start..start + 1 + more)
            }
        }
    }

    fn names(&self) -> Vec<String> {
        let first_parts = self.hulls.iter().filter(|hull| hull.hull().part() == 0);
        first_parts.map(|hull| hull.hull().name().to_owned()).take(NAMES_IN_ERRORS).collect()
    }

    /// The selected hulls as one shape of parry3d: a [`BakedHull`], or a `Compound` of them.
    ///
    /// The shape has the frame and units of the pack, times `scale`. Negative factors mirror it. It
    /// has the mass of the mesh, if all parts of the mesh are selected and the pack records it.
    ///
    /// # Errors
    /// If the pack has no such object or hull, or the scale cannot be applied.
    ///
    /// # Complexity
    /// O(1) for one hull, O(n log n) for n. No hull is copied, and nothing is cooked.
    pub fn shape(&self, selection: &Selection, scale: Vec3) -> Result<SharedShape, ShapeError> {
        let selected = self.hulls.get(self.select(selection)?).unwrap_or_default();
        let hulls = selected.iter().map(|hull| {
            let hull = BakedHull::new(hull.clone());
            if scale == Vec3::ONE { Ok(hull) } else { hull.scaled(scale).map_err(|_| ShapeError::Scale(scale)) }
        });
        let hulls = hulls.collect::<Result<Vec<BakedHull>, ShapeError>>()?;
        hullmap_parry::union(hulls).ok_or(ShapeError::Empty)
    }

    /// The selected hulls as a collider of an engine: Avian's `Collider`, bevy_rapier's, or any
    /// other type that is made from a shape of parry3d.
    ///
    /// Use it to build a collider in code. [`BakedCollider`](crate::BakedCollider) does the same
    /// with an asset that may still be loading, and rebuilds the collider when the pack changes.
    ///
    /// # Errors
    /// As [`shape`](Self::shape).
    pub fn collider<C: From<SharedShape>>(&self, selection: &Selection, scale: Vec3) -> Result<C, ShapeError> {
        self.shape(selection, scale).map(C::from)
    }

    /// Edges of the hull of index `index`, as segments in the frame of the pack. Each edge occurs
    /// once.
    ///
    /// # Complexity
    /// O(number of edges).
    #[cfg(feature = "gizmos")]
    pub fn edges(&self, index: usize) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        let hull = self.hulls.get(index).map(SharedHull::hull);
        hull.into_iter().flat_map(|hull| {
            let vertices = (0u32..).zip(hull.vertices());
            vertices.flat_map(move |(from, start)| {
                let later = hull.neighbours(from).filter(move |to| *to > from);
                later.filter_map(move |to| Some([start, hull.vertex(to)?]))
            })
        })
    }
}
