//! A barrel of 2,000 vertices falls on a floor, without a window: in Avian, in bevy_rapier, or in
//! both. Prints its height and its tilt every half second.
//!
//!     cargo run --ignore-rust-version --example drop --features avian,rapier
//!
//! The features choose the engines. The pack is baked here; a game has it in its folder of assets,
//! written by `bake build barrel.obj --out assets`.

use std::fs;
use std::path::Path;
use std::time::Duration;

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, AssetServer};
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use hullmap_bevy::BakedCollider;

/// Simulated frames for each second.
const FRAMES_PER_SECOND: u32 = 60;

/// The body that falls.
#[derive(Component)]
struct Barrel;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    // A prism of 1,000 sides, with its caps at z = ±1.
    let positions = shapes::families::prism(2000, 1);
    let source_vertices = (0..positions.len() as u32).collect();
    let barrel = PointSet { name: "barrel".into(), positions, source_vertices, ..Default::default() };
    let hull = bake_hull(&barrel, IndexKind::Tree)?;
    fs::write(folder.path().join("barrel.hullmap"), write_pack(&[hull], &SourceRecord::default())?)?;

    #[cfg(feature = "avian")]
    in_avian(folder.path());
    #[cfg(feature = "rapier")]
    in_rapier(folder.path());
    #[cfg(not(any(feature = "avian", feature = "rapier")))]
    eprintln!("no engine: run the example with --features avian, rapier, or both");
    Ok(())
}

/// An app with the contents of both: assets, time that passes in steps, and a barrel.
fn new_app(assets: &Path) -> App {
    let assets = AssetPlugin { file_path: assets.to_string_lossy().into_owned(), ..Default::default() };
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), FrameCountPlugin, TimePlugin, TransformPlugin, assets));
    let frame = Duration::from_secs(1) / FRAMES_PER_SECOND;
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app
}

/// Updates the app until the barrel has its collider, and for five seconds after that.
fn run(mut app: App, has_collider: fn(&World, Entity) -> bool) {
    app.finish();
    app.cleanup();
    let pack = app.world().resource::<AssetServer>().load("barrel.hullmap");
    let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let place = Transform::from_xyz(0.0, 3.0, 0.0).with_rotation(Quat::from_rotation_z(0.3) * upright);
    let barrel = app.world_mut().spawn((Barrel, BakedCollider::new(pack), place)).id();
    while !has_collider(app.world(), barrel) {
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
    for frame in 0..=5 * FRAMES_PER_SECOND {
        if frame % (FRAMES_PER_SECOND / 2) == 0 {
            let place = app.world().get::<Transform>(barrel).copied().unwrap_or_default();
            let tilt = (place.rotation * Vec3::Z).angle_between(Vec3::Y).to_degrees();
            let seconds = f64::from(frame) / f64::from(FRAMES_PER_SECOND);
            println!("{seconds:4.1} s  height {:6.3}  tilt {tilt:5.2}°", place.translation.y);
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
    // The barrel starts to fall when it can collide.
    app.add_observer(|event: On<Insert<Collider>>, barrels: Query<&Barrel>, mut commands: Commands| {
        if barrels.contains(event.entity) {
            commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
        }
    });
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Static, Collider::cuboid(40.0, 1.0, 40.0), floor));
    run(app, |world, barrel| world.get::<Collider>(barrel).is_some());
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
    // The barrel starts to fall when it can collide.
    app.add_observer(|event: On<Insert<Collider>>, barrels: Query<&Barrel>, mut commands: Commands| {
        if barrels.contains(event.entity) {
            commands.entity(event.entity).insert_if_new(RigidBody::Dynamic);
        }
    });
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Fixed, Collider::cuboid(20.0, 0.5, 20.0), floor));
    run(app, |world, barrel| world.get::<Collider>(barrel).is_some());
}
