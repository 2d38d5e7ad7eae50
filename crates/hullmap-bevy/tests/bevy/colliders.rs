//! Tests which shape a component gets, and what happens if there is none. The "engine" only stores
//! it.

use bevy_asset::{AssetServer, Assets, LoadState};
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use hullmap_bevy::{
    BakedCollider, ColliderFailure, ColliderPlugin, EngineCollider, HullmapPlugin, PackAsset, Selection, ShapeError,
};
use hullmap_parry::BakedHull;
use parry3d::shape::SharedShape;

use crate::packs::{corners, cube, l, pack, rock};
use crate::stage::{Folder, load, loaded, start, update_until};

/// An engine's collider.
#[derive(Component, Clone)]
pub struct Stored(pub SharedShape);

/// Number of times that the engine was notified of replaced colliders.
#[derive(Resource, Default)]
pub struct Replacements(pub usize);

impl From<SharedShape> for Stored {
    fn from(shape: SharedShape) -> Self {
        Self(shape)
    }
}

impl EngineCollider for Stored {
    fn colliders_replaced(world: &mut World) {
        world.get_resource_or_init::<Replacements>().0 += 1;
    }
}

/// Largest coordinates of an entity's shape.
pub fn maxs(world: &World, entity: Entity) -> Option<Vec3> {
    let Stored(shape) = world.get(entity)?;
    Some(shape.compute_local_aabb().maxs)
}

#[test]
fn a_collider_is_built_when_its_pack_arrives() {
    let folder = Folder::new(&cube(0.5));
    let mut app = folder.app();
    app.add_plugins(ColliderPlugin::<Stored>::default());
    start(&mut app);
    let handle = load(&app);
    let entity = app.world_mut().spawn(BakedCollider::new(handle.clone())).id();
    assert!(maxs(app.world(), entity).is_none());
    update_until(&mut app, |app| maxs(app.world(), entity).is_some());
    assert_eq!(maxs(app.world(), entity), Some(Vec3::splat(0.5)));

    // The pack is there: the collider is built with the entity, and again when it is edited.
    let scale = Vec3::new(2.0, 4.0, -1.0);
    let second = app.world_mut().spawn(BakedCollider::new(handle).with_scale(scale)).id();
    assert_eq!(maxs(app.world(), second), Some(Vec3::new(1.0, 2.0, 0.5)));
    app.world_mut().get_mut::<BakedCollider>(second).expect("it was just spawned").scale = Vec3::ONE;
    app.update();
    assert_eq!(maxs(app.world(), second), Some(Vec3::splat(0.5)));
    app.update();
    assert_eq!(app.world().resource::<Replacements>().0, 1, "a new collider replaces nothing");
}

#[test]
fn hulls_are_selected_by_name_and_index() {
    let left = corners(Vec3::new(-2.0, 0.0, 0.0), Vec3::splat(0.5));
    let right = corners(Vec3::new(2.0, 0.0, 0.0), Vec3::splat(0.5));
    let folder = Folder::new(&pack(&[("left", left), ("right", right), ("rock", rock())]));
    let mut app = folder.app();
    app.add_plugins(HullmapPlugin);
    start(&mut app);
    let handle = loaded(&mut app);
    let packs = app.world().resource::<Assets<PackAsset>>();
    let pack = packs.get(&handle).expect("it is loaded");
    let shape = |selection: Selection| pack.shape(&selection, Vec3::ONE);

    let all = shape(Selection::All).expect("all hulls are a compound");
    assert_eq!(all.as_compound().expect("three hulls").shapes().len(), 3);
    let right = shape(Selection::Object("right".into())).expect("there is such an object");
    assert_eq!(right.compute_local_aabb().mins.x, 1.5);
    let rock = shape(Selection::Hull(2)).expect("there are three hulls");
    assert_eq!(rock.as_shape::<BakedHull>().expect("one hull").hull().name(), "rock");

    let available = vec!["left".to_owned(), "right".into(), "rock".into()];
    let error = shape(Selection::Object("top".into())).err();
    assert_eq!(error, Some(ShapeError::NoSuchObject { name: "top".into(), available }));
    assert_eq!(shape(Selection::Hull(3)).err(), Some(ShapeError::NoSuchHull { index: 3, hull_count: 3 }));
    let flat = Vec3::new(1.0, 0.0, 1.0);
    assert_eq!(pack.shape(&Selection::All, flat).err(), Some(ShapeError::Scale(flat)));
    assert!(pack.shape(&Selection::All, Vec3::splat(f32::NAN)).is_err());
}

#[test]
fn parts_weigh_as_much_as_their_mesh() {
    let folder = Folder::new(&l());
    let mut app = folder.app();
    app.add_plugins(HullmapPlugin);
    start(&mut app);
    let handle = loaded(&mut app);
    let packs = app.world().resource::<Assets<PackAsset>>();
    let pack = packs.get(&handle).expect("it is loaded");
    for (selection, scale, mass) in [
        (Selection::All, 1.0, 8.0),
        (Selection::All, 2.0, 64.0),
        // A bar alone has its own mass.
        (Selection::Hull(0), 1.0, 4.0),
    ] {
        let shape = pack.shape(&selection, Vec3::splat(scale)).expect("there are two hulls");
        let found = shape.mass_properties(2.0).mass();
        assert!((found - mass).abs() < 1e-4, "{selection:?}, {scale}: {found}");
    }
}

#[test]
fn a_missing_object_is_reported_on_the_entity() {
    let folder = Folder::new(&cube(0.5));
    let mut app = folder.app();
    app.add_plugins((HullmapPlugin, ColliderPlugin::<Stored>::default()));
    start(&mut app);
    let handle = loaded(&mut app);
    let entity = app.world_mut().spawn(BakedCollider::object(handle, "ball")).id();
    let failure = app.world().get::<ColliderFailure>(entity).expect("the pack has no ball");
    assert_eq!(failure.0.to_string(), r#"the pack has no object "ball"; its objects are ["cube"]"#);
    assert!(maxs(app.world(), entity).is_none());

    app.world_mut().get_mut::<BakedCollider>(entity).expect("it was just spawned").hulls = Selection::Hull(0);
    app.update();
    assert!(app.world().get::<ColliderFailure>(entity).is_none());
    assert_eq!(maxs(app.world(), entity), Some(Vec3::splat(0.5)));
}

/// The asset server reports a damaged pack with the message that every other user of hullmap sees.
#[test]
fn a_damaged_pack_is_a_failed_load() {
    let mut bytes = cube(0.5);
    *bytes.last_mut().expect("a pack has bytes") ^= 1;
    let message = hullmap::Pack::from_bytes(&bytes).expect_err("the checksum is wrong").to_string();
    for (bytes, expected) in [(&bytes[..], message.as_str()), (&bytes[..100], ""), (b"not a pack", ""), (b"", "")] {
        let folder = Folder::new(bytes);
        let mut app = folder.app();
        app.add_plugins(ColliderPlugin::<Stored>::default());
        start(&mut app);
        let handle = load(&app);
        let entity = app.world_mut().spawn(BakedCollider::new(handle.clone())).id();
        let state = |app: &bevy_app::App| app.world().resource::<AssetServer>().load_state(&handle);
        update_until(&mut app, |app| state(app).is_failed());
        let LoadState::Failed(error) = state(&app) else { unreachable!("the loop waits for it") };
        let error = error.to_string();
        assert!(error.contains("pack.hullmap") && error.contains(expected), "{error}");
        assert!(maxs(app.world(), entity).is_none());
    }
}
