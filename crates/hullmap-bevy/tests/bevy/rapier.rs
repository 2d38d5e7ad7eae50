//! Hulls that fall in bevy_rapier, with parry's contacts and with hullmap's.

use bevy_app::App;
use bevy_ecs::lifecycle::Insert;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_rapier3d::plugin::context::{RapierContextSimulation, RapierRigidBodySet};
use bevy_rapier3d::plugin::{NoUserData, RapierPhysicsPlugin, TimestepMode};
use bevy_rapier3d::prelude::{Collider, RapierRigidBodyHandle, RigidBody};
use bevy_transform::components::Transform;
use hullmap_bevy::{BakedCollider, RapierColliderPlugin, RapierDispatcherPlugin, Selection};
use hullmap_parry::HullDispatcher;
use parry3d::math::{Pose, Vector};
use parry3d::query::{DefaultQueryDispatcher, QueryDispatcher};

use crate::packs::{corners, cube, pack, prism, rock};
use crate::stage::{FRAME, Folder, assert_at_rest, load, loaded, simulate, start, tilted, transform, update_until};

/// Solver that computes contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contacts {
    Parry,
    Hullmap,
}

fn app(folder: &Folder, contacts: Contacts) -> App {
    let mut app = folder.app();
    app.add_plugins((RapierPhysicsPlugin::<NoUserData>::default(), RapierColliderPlugin::default()));
    if contacts == Contacts::Hullmap {
        app.add_plugins(RapierDispatcherPlugin);
    }
    app.insert_resource(TimestepMode::Fixed { dt: FRAME.as_secs_f32(), substeps: 1 });
    start(&mut app);
    app
}

/// An app with a floor whose top is at height 0.
fn app_with_floor(folder: &Folder, contacts: Contacts) -> App {
    let mut app = app(folder, contacts);
    app.world_mut().spawn((RigidBody::Fixed, Collider::cuboid(20.0, 0.5, 20.0), Transform::from_xyz(0.0, -0.5, 0.0)));
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

/// Whether a body sleeps, and its speed.
fn motion(app: &mut App, entity: Entity) -> Option<(bool, f32)> {
    let handle = app.world().get::<RapierRigidBodyHandle>(entity)?.0;
    let mut contexts = app.world_mut().query::<&RapierRigidBodySet>();
    let body = &contexts.single(app.world()).expect("there is one context").bodies[handle];
    Some((body.is_sleeping(), body.linvel().length()))
}

#[test]
fn hulls_come_to_rest_on_a_floor() {
    for contacts in [Contacts::Parry, Contacts::Hullmap] {
        let flat_box = corners(Vec3::ZERO, Vec3::new(0.6, 0.5, 0.4));
        let folder = Folder::new(&pack(&[("box", flat_box.clone()), ("prism", prism())]));
        let mut app = app_with_floor(&folder, contacts);
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
        simulate(&mut app, 6.0);
        for (entity, points) in &bodies {
            let (_, speed) = motion(&mut app, *entity).expect("it is a body");
            assert_at_rest(&format!("contacts by {contacts:?}"), points, transform(&app, *entity), speed);
        }
    }
}

#[test]
fn a_sleeping_body_notices_that_its_pack_has_changed() {
    let folder = Folder::new(&cube(0.5));
    let mut app = app_with_floor(&folder, Contacts::Parry);
    let handle = load(&app);
    let body = drop_body(&mut app, BakedCollider::new(handle), Transform::from_xyz(0.0, 0.6, 0.0));
    update_until(&mut app, |app| motion(app, body).is_some_and(|(is_sleeping, _)| is_sleeping));
    assert!((transform(&app, body).translation.y - 0.5).abs() < 0.01);

    folder.replace(&cube(0.25));
    update_until(&mut app, |app| transform(app, body).translation.y < 0.4);
    simulate(&mut app, 2.0);
    assert!((transform(&app, body).translation.y - 0.25).abs() < 0.01);
}

#[test]
fn a_sleeping_body_notices_that_its_floor_has_changed() {
    let folder = Folder::new(&cube(10.0));
    let mut app = app(&folder, Contacts::Hullmap);
    let floor = (RigidBody::Fixed, BakedCollider::new(loaded(&mut app)), Transform::from_xyz(0.0, -10.0, 0.0));
    app.world_mut().spawn(floor);
    let body = (RigidBody::Dynamic, Collider::cuboid(0.5, 0.5, 0.5), Transform::from_xyz(0.0, 0.6, 0.0));
    let body = app.world_mut().spawn(body).id();
    update_until(&mut app, |app| motion(app, body).is_some_and(|(is_sleeping, _)| is_sleeping));
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
    let mut app = app_with_floor(&folder, Contacts::Hullmap);
    let baked = BakedCollider::new(load(&app)).with_scale(Vec3::new(-1.0, 2.0, 1.0));
    let body = drop_body(&mut app, baked, Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::new(1.0, 0.5, 1.5)));
    update_until(&mut app, |app| has_body(app, body));
    simulate(&mut app, 3.0);
    let resting = transform(&app, body);
    assert!((resting.translation.y - 0.5).abs() < 0.01, "{resting:?}");
    let bounds = app.world().get::<Collider>(body).expect("it has one").raw.compute_local_aabb();
    assert!(bounds.maxs.abs_diff_eq(Vec3::new(1.5, 0.5, 0.75), 1e-5), "{bounds:?}");
}

/// The context answers with the bits of hullmap's dispatcher, which differ from parry's.
#[test]
fn the_dispatcher_is_installed() {
    for contacts in [Contacts::Parry, Contacts::Hullmap] {
        let folder = Folder::new(&pack(&[("rock", rock())]));
        let mut app = app_with_floor(&folder, contacts);
        let handle = loaded(&mut app);
        let packs = app.world().resource::<bevy_asset::Assets<hullmap_bevy::PackAsset>>();
        let pack = packs.get(&handle).expect("it is loaded");
        let rock = pack.shape(&Selection::All, Vec3::ONE).expect("there is one hull");
        let gaps = |dispatcher: &dyn QueryDispatcher| {
            let gap = |i: u8| {
                let apart = Pose::from_translation(Vector::new(2.5, 0.1 * f32::from(i), 0.3));
                dispatcher.distance(&apart, &*rock, &*rock).expect("the pair is supported")
            };
            (0..20).map(gap).map(|gap| format!("{gap:?}")).collect::<Vec<String>>()
        };
        let [parry, hullmap] = [gaps(&DefaultQueryDispatcher), gaps(&HullDispatcher)];
        assert_ne!(parry, hullmap);
        let expected = if contacts == Contacts::Parry { parry } else { hullmap };
        let mut contexts = app.world_mut().query::<&RapierContextSimulation>();
        let context = contexts.single(app.world()).expect("there is one context");
        assert_eq!(gaps(context.query_dispatcher()), expected, "{contacts:?}");
    }
}
