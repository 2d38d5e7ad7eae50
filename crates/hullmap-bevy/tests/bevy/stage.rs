//! Apps without window, and folders with packs for them.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, AssetServer, Handle};
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use hullmap_bevy::PackAsset;
use tempfile::TempDir;

/// Time that passes in each update. Bodies fall at this rate, however long the updates take.
pub const FRAME: Duration = Duration::from_micros(16_667);

/// Longest wait for a file to be loaded or reloaded.
const PATIENCE: Duration = Duration::from_secs(60);

/// A folder of assets with one pack, `pack.hullmap`.
pub struct Folder(TempDir);

impl Folder {
    pub fn new(pack: &[u8]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write(pack);
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes over the pack in place.
    pub fn write(&self, pack: &[u8]) {
        fs::write(self.path().join("pack.hullmap"), pack).expect("the pack can be written");
    }

    /// Replaces the pack by a new file, as `bake build` does.
    pub fn replace(&self, pack: &[u8]) {
        let new = self.path().join(".pack.hullmap.tmp");
        fs::write(&new, pack).expect("a new pack can be written");
        fs::rename(new, self.path().join("pack.hullmap")).expect("the pack can be replaced");
    }

    /// An app that loads assets from this folder and watches it.
    pub fn app(&self) -> App {
        let assets = AssetPlugin { file_path: self.path().to_string_lossy().into_owned(), ..Default::default() };
        let mut app = App::new();
        app.add_plugins((TaskPoolPlugin::default(), FrameCountPlugin, TimePlugin, TransformPlugin, assets));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
        app
    }
}

/// Ends the building of an app, as `App::run` does.
pub fn start(app: &mut App) {
    app.finish();
    app.cleanup();
}

/// The handle of the pack; it is being loaded.
pub fn load(app: &App) -> Handle<PackAsset> {
    app.world().resource::<AssetServer>().load("pack.hullmap")
}

/// Updates the app until `is_done`.
pub fn update_until(app: &mut App, mut is_done: impl FnMut(&mut App) -> bool) {
    let start = Instant::now();
    while !is_done(app) {
        assert!(start.elapsed() < PATIENCE, "nothing happened in {PATIENCE:?}");
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The handle of the pack, once it is loaded.
pub fn loaded(app: &mut App) -> Handle<PackAsset> {
    let handle = load(app);
    update_until(app, |app| app.world().resource::<AssetServer>().is_loaded(&handle));
    handle
}

/// Lets `seconds` of simulated time pass.
pub fn simulate(app: &mut App, seconds: f32) {
    for _ in 0..(seconds / FRAME.as_secs_f32()).ceil() as usize {
        app.update();
    }
}

pub fn transform(app: &App, entity: Entity) -> Transform {
    *app.world().get::<Transform>(entity).expect("the entity has a transform")
}

/// A place in the air at which a body's z axis points up, apart from a tilt of 10°.
pub fn tilted(x: f32) -> Transform {
    let tilt = Quat::from_axis_angle(Vec3::new(1.0, 0.3, 0.5).normalize(), 10f32.to_radians());
    Transform::from_xyz(x, 2.0, 0.0).with_rotation(tilt * Quat::from_rotation_x(-90f32.to_radians()))
}

/// Asserts that a body has come to rest on a floor at height 0, on the face opposite to its z axis.
pub fn assert_at_rest(what: &str, points: &[[f32; 3]], place: Transform, speed: f32) {
    let up = place.rotation * Vec3::Z;
    assert!(up.angle_between(Vec3::Y) < 0.01, "{what}: z points to {up}");
    let lowest = points.iter().map(|p| place.transform_point(Vec3::from_array(*p)).y).fold(f32::INFINITY, f32::min);
    assert!(lowest.abs() < 0.01, "{what}: the lowest point is {lowest} above the floor");
    assert!(speed < 0.01, "{what}: it moves at {speed}");
}
