//! Meshes that meet: where they meet, normals are normals of one surface.

use glam::{DQuat, DVec3};
use hullmap::compound::{Joined, Tile, seams};
use hullmap::shapes::Cuboid;
use hullmap::{CompoundManifolds, ManifoldSettings, Pose, TriangleMesh};

use crate::meshes::mesh;

/// A strip of the plane z = 0, in its own frame: x from 0 to `length`, as squares of two triangles.
fn strip(length: f64, cells: usize) -> TriangleMesh {
    let mut positions = Vec::new();
    for i in 0..=cells {
        let x = length * i as f64 / cells as f64;
        positions.extend([DVec3::new(x, -4.0, 0.0), DVec3::new(x, 4.0, 0.0)]);
    }
    let quad = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
    mesh(&positions, &(0..cells as u32).flat_map(quad).collect::<Vec<_>>())
}

/// JoltPhysics#1922: a body slides from one field to the next, which lies beside it in one plane,
/// and meets the border. All normals are normals of the plane, for every placement and rotation of
/// the second sheet.
#[test]
fn a_body_slides_from_one_sheet_to_the_next() {
    let sheets = [strip(4.0, 4), strip(4.0, 3)];
    let settings = ManifoldSettings::default();
    let half_turn = DQuat::from_rotation_z(std::f64::consts::PI);
    let places = [
        [Pose::from_translation(DVec3::NEG_X * 4.0).unwrap(), Pose::IDENTITY],
        [Pose::from_translation(DVec3::NEG_X * 4.0).unwrap(), Pose::new(DVec3::X * 4.0, half_turn).unwrap()],
    ];
    let mut stumbles = 0;
    for place in places {
        let unions = sheets.each_ref().map(seams::union_of);
        let tile = |i: usize| Tile { union: &unions[i], parts: sheets[i].triangle_count(), place: place[i] };
        let tiles = [tile(0), tile(1)];
        let joined = Joined::new(&tiles);
        for half in [DVec3::new(0.3, 0.25, 0.2), DVec3::splat(0.02)] {
            let die = Cuboid::new(half).unwrap();
            for step in 0..800 {
                let x = 1.6 * half.x * (f64::from(step) / 400.0 - 1.0);
                let at = DVec3::new(x, 0.137 + 0.1 * x, half.z * (1.0 - 1e-3));
                let body = Pose::new(at, DQuat::from_rotation_z(0.3 * x / half.x)).unwrap();
                let mut points = 0;
                for i in 0..2 {
                    let b_in_a = Pose::relative(place[i], body).unwrap();
                    let mut manifolds = CompoundManifolds::new(16);
                    manifolds.update(&sheets[i], &die, b_in_a, &settings);
                    stumbles += manifolds.iter().filter(|(_, m)| m.normal().z < 0.99).count();
                    manifolds.update_joined(&joined, i, &sheets[i], &die, b_in_a, &settings);
                    for (pair, manifold) in manifolds.iter() {
                        let normal = manifold.normal();
                        assert!(normal.distance(DVec3::Z) < 1e-3, "sheet {i}, x = {x}, {pair:?}: {normal}");
                        assert!(manifold.points().iter().all(|p| p.depth <= 1.001e-3 * half.z), "x = {x}");
                        points += manifold.points().len();
                    }
                }
                assert!(points >= 4, "x = {x}: {points}");
            }
        }
    }
    println!("{stumbles} normals are wrong if each sheet is alone");
    assert!(stumbles > 20);
}
