//! Hulls that fall in Avian.

use avian3d::PhysicsPlugins;
use avian3d::prelude::{Collider, RigidBody, Sleeping};
use bevy_app::App;
use bevy_ecs::lifecycle::Insert;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use hullmap_bevy::{AvianColliderPlugin, BakedCollider};

use crate::packs::{corners, cube, pack, prism};
use crate::stage::{Folder, assert_at_rest, load, loaded, simulate, start, tilted, transform, update_until};

/// An app with a floor whose top is at height 0.
fn app_with_floor(folder: &Folder) -> App {
    let mut app = folder.app();
    app.add_plugins((PhysicsPlugins::default(), AvianColliderPlugin::default()));
    start(&mut app);
    app.world_mut().spawn((RigidBody::Static, Collider::cuboid(40.0, 1.0, 40.0), Transform::from_xyz(0.0, -0.5, 0.0)));
    app
}

/// A body that starts to fall when its pack is loaded.
fn drop_body(app: &mut App, baked: BakedCollider, place: Transform) -> Entity {
    let mut entity = app.world_mut().spawn((baked, place));
    entity.observe(|event: On<Insert<Collider>>, mut commands: Commands| {
        commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
    });
    entity.id()
}

fn has_body(app: &App, entity: Entity) -> bool {
    app.world().get::<RigidBody>(entity).is_some()
}

#[test]
fn hulls_come_to_rest_on_a_floor() {
    let flat_box = corners(Vec3::ZERO, Vec3::new(0.6, 0.5, 0.4));
    let folder = Folder::new(&pack(&[("box", flat_box.clone()), ("prism", prism())]));
    let mut app = app_with_floor(&folder);
    let handle = load(&app);
    let names = [("box", flat_box, -3.0), ("prism", prism(), 3.0)];
    let bodies = names.map(|(name, points, x)| {
        let baked = BakedCollider::object(handle.clone(), name);
        (drop_body(&mut app, baked, tilted(x)), points)
    });
    update_until(&mut app, |app| bodies.iter().all(|(entity, _)| has_body(app, *entity)));
    for (entity, _) in &bodies {
        assert!(transform(&app, *entity).translation.y > 1.99, "it fell before it had a collider");
    }
    simulate(&mut app, 5.0);
    let before = bodies.each_ref().map(|(entity, _)| transform(&app, *entity).translation);
    simulate(&mut app, 1.0);
    for ((entity, points), before) in bodies.iter().zip(before) {
        // Avian keeps the velocity that a sleeping body had in its last step.
        let place = transform(&app, *entity);
        assert_at_rest("in Avian", points, place, place.translation.distance(before));
    }
}

#[test]
fn a_sleeping_body_notices_that_its_pack_has_changed() {
    let folder = Folder::new(&cube(0.5));
    let mut app = app_with_floor(&folder);
    let handle = load(&app);
    let body = drop_body(&mut app, BakedCollider::new(handle), Transform::from_xyz(0.0, 0.6, 0.0));
    update_until(&mut app, |app| app.world().get::<Sleeping>(body).is_some());
    assert!((transform(&app, body).translation.y - 0.5).abs() < 0.01);

    folder.replace(&cube(0.25));
    update_until(&mut app, |app| transform(app, body).translation.y < 0.4);
    simulate(&mut app, 2.0);
    assert!((transform(&app, body).translation.y - 0.25).abs() < 0.01);
}

#[test]
fn a_sleeping_body_notices_that_its_floor_has_changed() {
    let folder = Folder::new(&cube(10.0));
    let mut app = folder.app();
    app.add_plugins((PhysicsPlugins::default(), AvianColliderPlugin::default()));
    start(&mut app);
    let floor = (RigidBody::Static, BakedCollider::new(loaded(&mut app)), Transform::from_xyz(0.0, -10.0, 0.0));
    app.world_mut().spawn(floor);
    let body = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), Transform::from_xyz(0.0, 0.6, 0.0));
    let body = app.world_mut().spawn(body).id();
    update_until(&mut app, |app| app.world().get::<Sleeping>(body).is_some());
    assert!((transform(&app, body).translation.y - 0.5).abs() < 0.01);

    folder.replace(&cube(9.0));
    update_until(&mut app, |app| transform(app, body).translation.y < 0.4);
    simulate(&mut app, 2.0);
    assert!((transform(&app, body).translation.y + 0.5).abs() < 0.01);
}

/// The scale of a transform multiplies the scale of the component, for one hull and for a compound.
#[test]
fn a_scaled_body_rests_at_its_scaled_height() {
    let boxes = [-1.0, 1.0].map(|x| corners(Vec3::new(x, 0.0, 0.0), Vec3::splat(0.5)));
    let [left, right] = boxes;
    let folder = Folder::new(&pack(&[("left", left), ("right", right)]));
    let mut app = app_with_floor(&folder);
    let baked = BakedCollider::new(load(&app)).with_scale(Vec3::new(-1.0, 2.0, 1.0));
    let body = drop_body(&mut app, baked, Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::new(1.0, 0.5, 1.5)));
    update_until(&mut app, |app| has_body(app, body));
    simulate(&mut app, 3.0);
    let resting = transform(&app, body);
    assert!((resting.translation.y - 0.5).abs() < 0.01, "{resting:?}");
    let bounds = app.world().get::<Collider>(body).expect("it has one").shape_scaled().compute_local_aabb();
    assert!(bounds.maxs.abs_diff_eq(Vec3::new(1.5, 0.5, 0.75), 1e-5), "{bounds:?}");
}
