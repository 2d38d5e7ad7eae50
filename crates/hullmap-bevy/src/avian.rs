//! Colliders of Avian (`avian3d` 0.8 with its feature `parry-f32`).
//!
//! Avian computes contacts with parry's own dispatcher; there is no way to install another one. So
//! hulls collide by parry's GJK and EPA, with the support queries and faces of hullmap.

use avian3d::prelude::{Collider, ContactGraph, Sleeping, WakeBody};
use bevy_ecs::prelude::*;

use crate::{ColliderPlugin, EngineCollider};

/// Builds Avian's colliders for entities with a [`BakedCollider`](crate::BakedCollider).
pub type AvianColliderPlugin = ColliderPlugin<Collider>;

impl EngineCollider for Collider {
    fn colliders_replaced(world: &mut World) {
        // While a pair barely moves, Avian keeps its contacts and computes no new ones.
        if let Some(mut contacts) = world.get_resource_mut::<ContactGraph>() {
            contacts.active_pairs_mut().iter_mut().for_each(|pair| pair.recycling_cache = None);
            contacts.sleeping_pairs_mut().iter_mut().for_each(|pair| pair.recycling_cache = None);
        }
        let mut sleeping = world.query_filtered::<Entity, With<Sleeping>>();
        let bodies: Vec<Entity> = sleeping.iter(world).collect();
        for body in bodies {
            world.commands().queue_silenced(WakeBody(body));
        }
        world.flush();
    }
}
