//! Builds the engine's collider of each `BakedCollider`, which follows its pack.
//!
//! 1. When the component is inserted, an observer builds the collider at once if the pack is there.
//! 2. When the pack arrives or changes, or the component is changed, a system in `PreUpdate` builds
//!    it. All engines step later in the frame.
//!
//! The system is not in `PostUpdate`, where asset events are written, because parts of bevy_rapier
//! must run before them and others after.

use std::marker::PhantomData;

use bevy_app::{App, Plugin, PreUpdate};
use bevy_asset::{AssetEvent, AssetId, AssetTrackingSystems, Assets};
use bevy_ecs::component::Mutable;
use bevy_ecs::lifecycle::Insert;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use parry3d::shape::SharedShape;

use crate::collider::{BakedCollider, ColliderFailure};
use crate::plugin::HullmapPlugin;
use crate::{PackAsset, Selection};

/// An engine's collider component.
pub trait EngineCollider: Component<Mutability = Mutable> + From<SharedShape> {
    /// Called after colliders were replaced, for an engine that does not notice it by itself: wakes
    /// sleeping bodies, and drops cached contacts. Does nothing by default.
    fn colliders_replaced(world: &mut World) {
        let _ = world;
    }
}

/// Builds the colliders `C` of all entities with a [`BakedCollider`].
///
/// The features `avian` and `rapier` have names for it: `AvianColliderPlugin` and
/// `RapierColliderPlugin`. For another engine on parry3d, implement [`EngineCollider`] for its
/// collider.
#[derive(Clone, Copy, Debug)]
pub struct ColliderPlugin<C>(PhantomData<C>);

impl<C> Default for ColliderPlugin<C> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

/// The source of the collider `C` of an entity.
#[derive(Component)]
struct BuiltFrom<C: EngineCollider> {
    pack: AssetId<PackAsset>,
    hulls: Selection,
    scale: Vec3,
    engine: PhantomData<C>,
}

impl<C: EngineCollider> BuiltFrom<C> {
    fn new(baked: &BakedCollider) -> Self {
        Self { pack: baked.pack.id(), hulls: baked.hulls.clone(), scale: baked.scale, engine: PhantomData }
    }

    fn is(&self, baked: &BakedCollider) -> bool {
        self.pack == baked.pack.id() && self.hulls == baked.hulls && self.scale == baked.scale
    }
}

/// The system that builds colliders when packs arrive or change; in `PreUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ColliderSystems;

impl<C: EngineCollider> Plugin for ColliderPlugin<C> {
    fn build(&self, app: &mut App) {
        app.add_plugins(HullmapPlugin);
        app.add_observer(build_inserted::<C>);
        app.add_systems(PreUpdate, build_changed::<C>.in_set(ColliderSystems).after(AssetTrackingSystems));
    }
}

fn build_inserted<C: EngineCollider>(
    event: On<Insert<BakedCollider>>,
    colliders: Query<&BakedCollider>,
    packs: Res<Assets<PackAsset>>,
    mut commands: Commands,
) {
    let Ok(baked) = colliders.get(event.entity) else { return };
    if let Some(pack) = packs.get(&baked.pack) {
        build::<C>(&mut commands, event.entity, baked, pack);
    }
}

/// Builds the colliders whose pack has arrived or changed, and colliders that were changed.
fn build_changed<C: EngineCollider>(
    mut events: MessageReader<AssetEvent<PackAsset>>,
    colliders: Query<(Entity, Ref<BakedCollider>, Option<&BuiltFrom<C>>)>,
    packs: Res<Assets<PackAsset>>,
    mut commands: Commands,
) {
    let changed_packs: Vec<AssetId<PackAsset>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    let mut is_replaced = false;
    for (entity, baked, built_from) in &colliders {
        // The observer has seen components that were inserted when their pack was there.
        let is_edited = baked.is_changed() && !built_from.is_some_and(|built| built.is(&baked));
        if !is_edited && !changed_packs.contains(&baked.pack.id()) {
            continue;
        }
        if let Some(pack) = packs.get(&baked.pack) {
            is_replaced |= build::<C>(&mut commands, entity, &baked, pack) && built_from.is_some();
        }
    }
    if is_replaced {
        commands.queue(C::colliders_replaced);
    }
}

/// Gives `entity` its collider, or the reason why there is none. Returns whether it has one.
fn build<C: EngineCollider>(commands: &mut Commands, entity: Entity, baked: &BakedCollider, pack: &PackAsset) -> bool {
    let Ok(mut entity_commands) = commands.get_entity(entity) else { return false };
    match pack.collider::<C>(&baked.hulls, baked.scale) {
        Ok(collider) => {
            entity_commands.try_insert((collider, BuiltFrom::<C>::new(baked))).try_remove::<ColliderFailure>();
            true
        }
        Err(error) => {
            tracing::error!("no collider for entity {entity}: {error}");
            entity_commands.try_insert(ColliderFailure(error));
            false
        }
    }
}
