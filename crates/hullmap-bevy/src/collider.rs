//! `BakedCollider`: hulls of a pack as the collider of an entity.

use bevy_asset::Handle;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_reflect::Reflect;

use crate::{PackAsset, Selection, ShapeError};

/// Hulls of a pack as the collider of this entity.
///
/// [`ColliderPlugin`] inserts the engine's collider when the pack is loaded, and replaces it when
/// the pack is reloaded or this component changes. Until then the entity has no collider: a body
/// would fall through the floor. Insert the body with the collider, for instance in an observer of
/// `On<Insert<Collider>>`, or spawn the entity when the pack is loaded.
///
/// If this component is removed, the collider stays.
///
/// Saved scenes hold this component (the path of the pack, and the selection) instead of the
/// engine's collider, which cannot be serialised. Loading the scene builds the collider again.
///
/// # Examples
/// ```
/// use bevy_asset::Handle;
/// use bevy_math::Vec3;
/// use hullmap_bevy::{BakedCollider, PackAsset, Selection};
///
/// # let pack: Handle<PackAsset> = Handle::default();
/// // let pack = asset_server.load("crate.hullmap");
/// let whole = BakedCollider::new(pack.clone());
/// assert_eq!((&whole.hulls, whole.scale), (&Selection::All, Vec3::ONE));
///
/// let wheel = BakedCollider::object(pack, "wheel").with_scale(Vec3::new(-1.0, 1.0, 1.0));
/// assert_eq!(wheel.hulls, Selection::Object("wheel".into()));
/// ```
///
/// [`ColliderPlugin`]: crate::ColliderPlugin
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub struct BakedCollider {
    /// The pack.
    pub pack: Handle<PackAsset>,
    /// Hulls of the pack.
    pub hulls: Selection,
    /// Scale of the hulls along each axis; negative factors mirror. The engine multiplies it by the
    /// scale of the entity's transform (Avian by its absolute value; bevy_rapier rounds it to
    /// 0.0001).
    pub scale: Vec3,
}

impl BakedCollider {
    /// All hulls of a pack.
    pub fn new(pack: Handle<PackAsset>) -> Self {
        Self { pack, hulls: Selection::All, scale: Vec3::ONE }
    }

    /// One object of a pack, with all its convex parts.
    pub fn object(pack: Handle<PackAsset>, name: impl Into<String>) -> Self {
        Self { pack, hulls: Selection::Object(name.into()), scale: Vec3::ONE }
    }

    /// One hull of a pack.
    pub fn hull(pack: Handle<PackAsset>, index: usize) -> Self {
        Self { pack, hulls: Selection::Hull(index), scale: Vec3::ONE }
    }

    /// A copy with this scale.
    pub fn with_scale(mut self, scale: Vec3) -> Self {
        self.scale = scale;
        self
    }
}

/// Why an entity with a [`BakedCollider`] has no collider, or still has the collider of an earlier
/// pack. Removed when a collider is built. The message is also logged.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct ColliderFailure(pub ShapeError);
