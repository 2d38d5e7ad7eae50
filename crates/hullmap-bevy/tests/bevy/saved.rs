//! A saved scene holds the path of the pack and the selection, not the engine's collider.

use bevy_asset::{AssetServer, EphemeralHandleBehavior, HandleDeserializeProcessor, HandleSerializeProcessor};
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_reflect::FromReflect;
use bevy_reflect::serde::{TypedReflectDeserializer, TypedReflectSerializer};
use hullmap_bevy::{BakedCollider, ColliderPlugin};
use serde::de::DeserializeSeed;

use crate::colliders::{Stored, maxs};
use crate::packs::cube;
use crate::stage::{Folder, load, start, update_until};

#[test]
fn a_saved_component_is_built_again() {
    let folder = Folder::new(&cube(0.5));
    let new_app = || {
        let mut app = folder.app();
        app.add_plugins(ColliderPlugin::<Stored>::default());
        start(&mut app);
        app
    };

    let app = new_app();
    let baked = BakedCollider::object(load(&app), "cube").with_scale(Vec3::new(1.0, 2.0, 3.0));
    let types = app.world().resource::<AppTypeRegistry>().read();
    let handles = HandleSerializeProcessor { ephemeral_handle_behavior: EphemeralHandleBehavior::Error };
    let saved = serde_json::to_string(&TypedReflectSerializer::with_processor(&baked, &types, &handles));
    let saved = saved.expect("every field can be serialised");
    assert!(saved.contains("pack.hullmap") && saved.contains("cube"), "{saved}");

    let mut app = new_app();
    let server = app.world().resource::<AssetServer>().clone();
    let types = app.world().resource::<AppTypeRegistry>().clone();
    let types = types.read();
    let registration = types.get(std::any::TypeId::of::<BakedCollider>()).expect("the plugin registers it");
    let mut handles = HandleDeserializeProcessor { load_from_path: &mut &server };
    let value = TypedReflectDeserializer::with_processor(registration, &types, &mut handles)
        .deserialize(&mut serde_json::Deserializer::from_str(&saved))
        .expect("it was just serialised");
    let loaded = BakedCollider::from_reflect(&*value).expect("all fields are there");
    assert_eq!((&loaded.hulls, loaded.scale), (&baked.hulls, baked.scale));

    let entity = app.world_mut().spawn(loaded).id();
    update_until(&mut app, |app| maxs(app.world(), entity).is_some());
    assert_eq!(maxs(app.world(), entity), Some(Vec3::new(0.5, 1.0, 1.5)));
}
