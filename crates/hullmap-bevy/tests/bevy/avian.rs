//! Hulls that fall in Avian.

use avian3d::PhysicsPlugins;
use avian3d::prelude::{Collider, LinearVelocity, RigidBody, Sleeping};
use bevy_app::App;
use bevy_ecs::lifecycle::Insert;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use hullmap_bevy::{AvianColliderPlugin, BakedCollider};

use crate::packs::{corners, cube, pack, rock};
use crate::stage::{Folder, load, lowest, simulate, start, tilt, transform, update_until};

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
    let half = Vec3::new(0.6, 0.4, 0.5);
    let crate_points = corners(Vec3::ZERO, half);
    let folder = Folder::new(&pack(&[("crate", crate_points.clone()), ("rock", rock())]));
    let mut app = app_with_floor(&folder);
    let handle = load(&app);
    let place = |x: f32| Transform::from_xyz(x, 2.0, 0.0).with_rotation(tilt());
    let fallen_crate = drop_body(&mut app, BakedCollider::object(handle.clone(), "crate"), place(-3.0));
    let fallen_rock = drop_body(&mut app, BakedCollider::object(handle, "rock"), place(3.0));
    update_until(&mut app, |app| has_body(app, fallen_crate) && has_body(app, fallen_rock));
    assert_eq!(transform(&app, fallen_crate).translation.y, 2.0, "the body fell before it had a collider");

    simulate(&mut app, 6.0);
    let resting = transform(&app, fallen_crate);
    // On its face of lowest y: the tilt is small.
    assert!((resting.translation.y - half.y).abs() < 0.01, "{resting:?}");
    assert!((resting.rotation * Vec3::Y).angle_between(Vec3::Y) < 0.01, "{resting:?}");
    for (entity, points) in [(fallen_crate, &crate_points), (fallen_rock, &rock())] {
        let height = lowest(points, transform(&app, entity));
        assert!(height.abs() < 0.01, "the lowest point is {height} above the floor");
        let LinearVelocity(velocity) = app.world().get(entity).expect("it is a body");
        assert!(velocity.length() < 0.05, "{velocity}");
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

/// The scale of a transform multiplies that of the component, for one hull and for a compound.
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
    assert_eq!(bounds.maxs, Vec3::new(1.5, 0.5, 0.75));
}
