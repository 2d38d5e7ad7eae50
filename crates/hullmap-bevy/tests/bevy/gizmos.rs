//! Edges that are drawn, without a window.

use bevy_app::Last;
use bevy_ecs::prelude::*;
use bevy_gizmos::config::GizmoConfigStore;
use bevy_gizmos::{GizmoAsset, GizmoPlugin};
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use hullmap_bevy::{BakedCollider, HullGizmos, HullGizmosPlugin, HullmapPlugin};

use crate::packs::{corners, pack};
use crate::stage::{Folder, loaded, start};

/// Ends of the lines that were drawn in a frame.
#[derive(Resource, Default)]
struct Drawn(Vec<Vec3>);

/// Gizmos end in assets, which a renderer would draw.
fn record(assets: Res<bevy_asset::Assets<GizmoAsset>>, mut drawn: ResMut<Drawn>) {
    drawn.0 = assets.iter().flat_map(|(_, asset)| asset.buffer().list_positions.clone()).collect();
}

#[test]
fn every_edge_is_drawn_once() {
    let square = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    let segment = vec![[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
    let cube = corners(Vec3::ZERO, Vec3::splat(0.5));
    let folder = Folder::new(&pack(&[("cube", cube), ("square", square), ("segment", segment)]));
    let mut app = folder.app();
    app.add_plugins((GizmoPlugin, HullmapPlugin, HullGizmosPlugin));
    app.init_resource::<Drawn>();
    app.add_systems(Last, record.after(bevy_gizmos::GizmoMeshSystems));
    start(&mut app);
    let handle = loaded(&mut app);
    let place = Transform::from_xyz(10.0, 0.0, 0.0);
    let mut draw = |name: &str, scale: Vec3| {
        let baked = BakedCollider::object(handle.clone(), name).with_scale(scale);
        let entity = app.world_mut().spawn((baked, place)).id();
        app.update();
        let points = app.world().resource::<Drawn>().0.clone();
        app.world_mut().despawn(entity);
        points
    };
    for (name, edges) in [("cube", 12), ("square", 4), ("segment", 1)] {
        assert_eq!(draw(name, Vec3::ONE).len(), 2 * edges, "{name}");
    }
    let points = draw("cube", Vec3::new(2.0, 1.0, 1.0));
    assert!(points.iter().all(|p| (p.x - 10.0).abs() == 1.0 && p.y.abs() == 0.5 && p.z.abs() == 0.5), "{points:?}");

    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    store.config_mut::<HullGizmos>().0.enabled = false;
    app.world_mut().spawn((BakedCollider::new(handle), place));
    // The asset of the last drawing is dropped in the first update.
    app.update();
    app.update();
    assert!(app.world().resource::<Drawn>().0.is_empty());
}
