//! Colliders of Avian (`avian3d` 0.8 with its feature `parry-f32`).
//!
//! Avian computes contacts with parry's own dispatcher; there is no way to install another one. So
//! hulls collide by parry's GJK and EPA, with the support queries and faces of hullmap.

use avian3d::prelude::{Collider, Sleeping, WakeBody};
use bevy_ecs::prelude::*;

use crate::{ColliderPlugin, EngineCollider};

/// Builds Avian's colliders for entities with a [`BakedCollider`](crate::BakedCollider).
pub type AvianColliderPlugin = ColliderPlugin<Collider>;

impl EngineCollider for Collider {
    fn wake_bodies(world: &mut World) {
        let mut sleeping = world.query_filtered::<Entity, With<Sleeping>>();
        let bodies: Vec<Entity> = sleeping.iter(world).collect();
        for body in bodies {
            world.commands().queue_silenced(WakeBody(body));
        }
        world.flush();
    }
}
