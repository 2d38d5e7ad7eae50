//! A pack that changes on disk.

use bevy_asset::AssetServer;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use hullmap_bevy::{BakedCollider, ColliderFailure, ColliderPlugin};

use crate::colliders::{Replacements, Stored, maxs};
use crate::packs::{corners, cube, pack};
use crate::stage::{Folder, load, start, update_until};

#[test]
fn a_collider_follows_its_file() {
    let folder = Folder::new(&cube(0.5));
    let mut app = folder.app();
    app.add_plugins(ColliderPlugin::<Stored>::default());
    start(&mut app);
    let handle = load(&app);
    let entity = app.world_mut().spawn(BakedCollider::object(handle.clone(), "cube")).id();
    let has_half = |world: &World, half: f32| maxs(world, entity) == Some(Vec3::splat(half));
    update_until(&mut app, |app| has_half(app.world(), 0.5));

    folder.write(&cube(1.0));
    update_until(&mut app, |app| has_half(app.world(), 1.0));
    folder.replace(&cube(2.0));
    update_until(&mut app, |app| has_half(app.world(), 2.0));
    assert!(app.world().resource::<Replacements>().0 >= 2);

    // A damaged file changes nothing, and a good one afterwards is loaded.
    let mut damaged = cube(3.0);
    damaged.truncate(200);
    folder.write(&damaged);
    update_until(&mut app, |app| app.world().resource::<AssetServer>().load_state(&handle).is_failed());
    assert!(has_half(app.world(), 2.0));
    folder.replace(&cube(4.0));
    update_until(&mut app, |app| has_half(app.world(), 4.0));

    // A pack without the object leaves the collider unchanged, and the failure is reported.
    folder.write(&pack(&[("ball", corners(Vec3::ZERO, Vec3::ONE))]));
    update_until(&mut app, |app| app.world().get::<ColliderFailure>(entity).is_some());
    assert!(has_half(app.world(), 4.0));
    folder.write(&cube(1.0));
    update_until(&mut app, |app| has_half(app.world(), 1.0));
    assert!(app.world().get::<ColliderFailure>(entity).is_none());
}
