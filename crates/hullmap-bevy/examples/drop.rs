//! A rock of 2,000 vertices falls on a floor, without a window: in Avian, in bevy_rapier, or in
//! both. Prints its height above the floor every half second.
//!
//!     cargo run --ignore-rust-version --example drop --features avian,rapier
//!
//! The features choose the engines. The pack is baked here; a game has it in its folder of assets,
//! written by `bake build rock.obj --out assets`.

use std::fs;
use std::path::Path;
use std::time::Duration;

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, AssetServer};
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_bevy::BakedCollider;

/// Simulated frames for each second.
const FRAMES_PER_SECOND: u32 = 60;

/// The rock, so that its height can be printed.
#[derive(Component)]
struct Rock;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let positions = shapes::families::rock(2000, 1);
    let source_vertices = (0..positions.len() as u32).collect();
    let rock = PointSet { name: "rock".into(), positions, source_vertices, ..Default::default() };
    let hull = bake_hull(&rock, IndexKind::Tree)?;
    fs::write(folder.path().join("rock.hullmap"), write_pack(&[hull], &SourceRecord::default())?)?;

    #[cfg(feature = "avian")]
    in_avian(folder.path());
    #[cfg(feature = "rapier")]
    in_rapier(folder.path());
    #[cfg(not(any(feature = "avian", feature = "rapier")))]
    eprintln!("no engine: run the example with --features avian, rapier, or both");
    Ok(())
}

/// What both apps have: assets, time that passes in steps, and a rock.
fn new_app(assets: &Path) -> App {
    let assets = AssetPlugin { file_path: assets.to_string_lossy().into_owned(), ..Default::default() };
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), FrameCountPlugin, TimePlugin, TransformPlugin, assets));
    let frame = Duration::from_secs(1) / FRAMES_PER_SECOND;
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app
}

/// Updates the app until the rock has its collider, and for five seconds after that.
fn run(mut app: App, has_collider: fn(&World, Entity) -> bool) {
    app.finish();
    app.cleanup();
    let pack = app.world().resource::<AssetServer>().load("rock.hullmap");
    let rock = app.world_mut().spawn((Rock, BakedCollider::new(pack), Transform::from_xyz(0.0, 3.0, 0.0))).id();
    while !has_collider(app.world(), rock) {
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
    for frame in 0..=5 * FRAMES_PER_SECOND {
        if frame % (FRAMES_PER_SECOND / 2) == 0 {
            let height = app.world().get::<Transform>(rock).map_or(f32::NAN, |place| place.translation.y);
            println!("{:4.1} s  {height:6.3}", f64::from(frame) / f64::from(FRAMES_PER_SECOND));
        }
        app.update();
    }
}

#[cfg(feature = "avian")]
fn in_avian(assets: &Path) {
    use avian3d::PhysicsPlugins;
    use avian3d::prelude::{Collider, RigidBody};
    use bevy_ecs::lifecycle::Insert;
    use hullmap_bevy::AvianColliderPlugin;

    println!("Avian");
    let mut app = new_app(assets);
    app.add_plugins((PhysicsPlugins::default(), AvianColliderPlugin::default()));
    // The rock starts to fall when it can collide.
    app.add_observer(|event: On<Insert<Collider>>, rocks: Query<&Rock>, mut commands: Commands| {
        if rocks.contains(event.entity) {
            commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
        }
    });
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Static, Collider::cuboid(40.0, 1.0, 40.0), floor));
    run(app, |world, rock| world.get::<Collider>(rock).is_some());
}

#[cfg(feature = "rapier")]
fn in_rapier(assets: &Path) {
    use bevy_ecs::lifecycle::Insert;
    use bevy_rapier3d::plugin::{NoUserData, RapierPhysicsPlugin, TimestepMode};
    use bevy_rapier3d::prelude::{Collider, RigidBody};
    use hullmap_bevy::{RapierColliderPlugin, RapierDispatcherPlugin};

    println!("bevy_rapier, contacts by hullmap");
    let mut app = new_app(assets);
    app.add_plugins((RapierPhysicsPlugin::<NoUserData>::default(), RapierColliderPlugin::default()));
    app.add_plugins(RapierDispatcherPlugin);
    app.insert_resource(TimestepMode::Fixed { dt: 1.0 / FRAMES_PER_SECOND as f32, substeps: 1 });
    // The rock starts to fall when it can collide.
    app.add_observer(|event: On<Insert<Collider>>, rocks: Query<&Rock>, mut commands: Commands| {
        if rocks.contains(event.entity) {
            commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
        }
    });
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Fixed, Collider::cuboid(20.0, 0.5, 20.0), floor));
    run(app, |world, rock| world.get::<Collider>(rock).is_some());
}
