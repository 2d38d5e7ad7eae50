//! Saving shapes: a baked hull is saved as the name of its pack, its name in it, and its scale.
//!
//! parry can serialise only its own shapes. Serialising a collider with a [`BakedHull`] fails:
//! "TypedShape::Custom cannot be serialized". So an application saves a [`SavedShape`] for each
//! such collider, and puts the shape back after loading.

use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasher;
use std::sync::Arc;

use hullmap::{Hull, Pack, ShapeError, SharedHull};
use serde::{Deserialize, Serialize};

use super::baked_hull::{BakedHull, PartMass};
use super::parry::math::Pose;
use super::parry::shape::{Compound, SharedShape};

/// The packs of an application, by name, for saved shapes. `BTreeMap` and `HashMap` from names to
/// packs implement it. Implement it for your asset store.
pub trait Packs {
    /// Name of a pack, for saving; `None` if it is unknown.
    fn name(&self, pack: &Arc<Pack>) -> Option<String>;

    /// The pack with this name, for loading; `None` if the name is unknown.
    fn pack(&self, name: &str) -> Option<Arc<Pack>>;
}

impl Packs for BTreeMap<String, Arc<Pack>> {
    fn name(&self, pack: &Arc<Pack>) -> Option<String> {
        name_in(self.iter(), pack)
    }

    fn pack(&self, name: &str) -> Option<Arc<Pack>> {
        self.get(name).cloned()
    }
}

impl<S: BuildHasher> Packs for HashMap<String, Arc<Pack>, S> {
    /// If a pack has several names, the first of them in alphabetical order.
    fn name(&self, pack: &Arc<Pack>) -> Option<String> {
        name_in(self.iter(), pack)
    }

    fn pack(&self, name: &str) -> Option<Arc<Pack>> {
        self.get(name).cloned()
    }
}

fn name_in<'a>(all: impl Iterator<Item = (&'a String, &'a Arc<Pack>)>, pack: &Arc<Pack>) -> Option<String> {
    all.filter(|(_, candidate)| Arc::ptr_eq(candidate, pack)).map(|(name, _)| name).min().cloned()
}

/// A reference to a baked hull in a saved file. If the pack is baked again, the hull is found by
/// its name and part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedHull {
    /// Name of the pack, from [`Packs::name`].
    pub pack: String,
    /// Index of the hull in its pack.
    pub index: usize,
    /// Name of the hull.
    pub name: String,
    /// Part of the object, see [`Hull::part`](hullmap::Hull::part).
    pub part: u32,
    /// Scale along each axis; negative values mirror the hull.
    pub scale: [f64; 3],
    /// Which mass the shape has; in files of earlier versions, its own.
    #[serde(default)]
    pub mass: PartMass,
}

/// A shape in a saved file.
#[derive(Clone, Serialize, Deserialize)]
pub enum SavedShape {
    /// A baked hull.
    Hull(SavedHull),
    /// A compound with baked hulls: each part with its pose in the compound.
    Compound(Vec<(Pose, SavedShape)>),
    /// Any other shape. parry serialises it, which fails for custom shapes.
    Other(SharedShape),
}

/// Why a shape cannot be saved or loaded.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum SavedShapeError {
    /// The pack of a hull is not in [`Packs`].
    UnknownPack { hull: String },
    /// [`Packs`] has no pack of this name.
    NoSuchPack { pack: String },
    /// The pack has no hull with this name and part: it was baked from another source.
    NoSuchHull { pack: String, hull: String, part: u32 },
    /// The scale in the file is invalid.
    Scale(ShapeError),
    /// A compound in the file has no parts.
    EmptyCompound,
}

impl std::fmt::Display for SavedShapeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::UnknownPack { hull } => {
                write!(f, "the pack of hull {hull:?} has no name: add it to the packs before saving")
            }
            Self::NoSuchPack { pack } => {
                write!(f, "there is no pack {pack:?}: add it to the packs before loading")
            }
            Self::NoSuchHull { pack, hull, part } => {
                write!(
                    f,
                    "pack {pack:?} has no hull {hull:?}, part {part}: bake the source that the scene was saved with"
                )
            }
            Self::Scale(error) => write!(f, "a saved hull has an invalid scale: {error}"),
            Self::EmptyCompound => f.write_str("a saved compound has no parts: the file is damaged"),
        }
    }
}

impl std::error::Error for SavedShapeError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Scale(error) => Some(error),
            _ => None,
        }
    }
}

impl SavedShape {
    /// Converts `shape` for saving.
    ///
    /// # Errors
    /// [`SavedShapeError::UnknownPack`] if `packs` cannot name the pack of a hull.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let pack = pack();
    /// use std::collections::BTreeMap;
    /// use std::sync::Arc;
    /// use hullmap_parry::{BakedHull, SavedShape};
    /// use parry3d::shape::SharedShape;
    ///
    /// let packs = BTreeMap::from([("scenery".to_owned(), Arc::new(pack))]);
    /// let cube = packs["scenery"].shared_hull_named("cube")?;
    /// let shape: SharedShape = BakedHull::new(cube).into();
    ///
    /// let text = serde_json::to_string(&SavedShape::from_shape(&shape, &packs)?)?;
    /// assert!(text.contains(r#""pack":"scenery","index":1,"name":"cube""#));
    ///
    /// let saved: SavedShape = serde_json::from_str(&text)?;
    /// let loaded = saved.load(&packs)?;
    /// assert_eq!(loaded.compute_local_aabb(), shape.compute_local_aabb());
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_shape<P: Packs + ?Sized>(shape: &SharedShape, packs: &P) -> Result<Self, SavedShapeError> {
        if let Some(hull) = shape.as_shape::<BakedHull>() {
            return SavedHull::new(hull, packs).map(Self::Hull);
        }
        match shape.as_compound().filter(|_| is_custom(shape)) {
            Some(compound) => {
                let parts = compound.shapes().iter().map(|(pose, part)| Ok((*pose, Self::from_shape(part, packs)?)));
                parts.collect::<Result<_, _>>().map(Self::Compound)
            }
            None => Ok(Self::Other(shape.clone())),
        }
    }

    /// The shape, with its hulls from `packs`.
    ///
    /// # Errors
    /// `packs` lacks a pack or a hull, or the file is damaged: see [`SavedShapeError`].
    pub fn load<P: Packs + ?Sized>(&self, packs: &P) -> Result<SharedShape, SavedShapeError> {
        match self {
            Self::Hull(hull) => hull.load(packs).map(SharedShape::from),
            Self::Compound(parts) if parts.is_empty() => Err(SavedShapeError::EmptyCompound),
            Self::Compound(parts) => {
                let parts = parts.iter().map(|(pose, part)| Ok((*pose, part.load(packs)?)));
                Ok(SharedShape::new(Compound::new(parts.collect::<Result<_, _>>()?)))
            }
            Self::Other(shape) => Ok(shape.clone()),
        }
    }
}

impl SavedHull {
    fn new<P: Packs + ?Sized>(hull: &BakedHull, packs: &P) -> Result<Self, SavedShapeError> {
        let (shared, name) = (hull.shared_hull(), hull.hull().name().to_owned());
        let Some(pack) = packs.name(shared.pack()) else {
            return Err(SavedShapeError::UnknownPack { hull: name });
        };
        let scale = hull.scale_factors().to_array();
        Ok(Self { pack, index: shared.index(), name, part: hull.hull().part(), scale, mass: hull.part_mass() })
    }

    /// The hull, from `packs`.
    ///
    /// # Errors
    /// As [`SavedShape::load`].
    ///
    /// # Complexity
    /// O(1) if the pack has the hull at the saved index, else O(n) in the number of its hulls.
    pub fn load<P: Packs + ?Sized>(&self, packs: &P) -> Result<BakedHull, SavedShapeError> {
        let Some(pack) = packs.pack(&self.pack) else {
            return Err(SavedShapeError::NoSuchPack { pack: self.pack.clone() });
        };
        let is_it = |hull: &Hull| hull.name() == self.name && hull.part() == self.part;
        let at_index = pack.shared_hull(self.index).ok().filter(|hull| is_it(hull.hull()));
        let by_name = || -> Option<SharedHull> { pack.shared_hull(pack.hulls().position(|hull| is_it(&hull))?).ok() };
        let Some(hull) = at_index.or_else(by_name) else {
            let Self { pack, name, part, .. } = self.clone();
            return Err(SavedShapeError::NoSuchHull { pack, hull: name, part });
        };
        let mut hull = BakedHull::new(hull).scaled_by(self.scale.into()).map_err(SavedShapeError::Scale)?;
        hull.set_part_mass(self.mass);
        Ok(hull)
    }
}

/// Whether `shape` needs a [`SavedShape`]: it is a [`BakedHull`], or a compound that contains one.
pub fn is_custom(shape: &SharedShape) -> bool {
    shape.as_shape::<BakedHull>().is_some()
        || shape.as_compound().is_some_and(|compound| compound.shapes().iter().any(|(_, part)| is_custom(part)))
}
