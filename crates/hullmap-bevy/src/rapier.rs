//! Colliders of bevy_rapier (`bevy_rapier3d` 0.37), and hullmap's solver for them.

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::Insert;
use bevy_ecs::prelude::*;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use hullmap_parry::HullDispatcher;

use crate::{ColliderPlugin, EngineCollider};

/// Builds bevy_rapier's colliders for entities with a [`BakedCollider`](crate::BakedCollider).
pub type RapierColliderPlugin = ColliderPlugin<Collider>;

/// Rapier wakes the bodies at a collider that is replaced.
impl EngineCollider for Collider {}

/// Makes hullmap solve the contacts of baked hulls, in every context of bevy_rapier, instead of
/// parry. Scene queries use it too.
///
/// The plugin may be added before or after bevy_rapier's, but before the app runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct RapierDispatcherPlugin;

impl Plugin for RapierDispatcherPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(install_dispatcher);
    }
}

/// A context that was just inserted has no colliders, so none of its contacts are lost.
fn install_dispatcher(event: On<Insert<RapierContextSimulation>>, mut contexts: Query<&mut RapierContextSimulation>) {
    if let Ok(mut context) = contexts.get_mut(event.entity) {
        context.set_query_dispatcher(HullDispatcher);
    }
}
