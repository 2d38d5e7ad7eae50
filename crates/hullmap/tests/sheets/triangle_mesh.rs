//! Triangle meshes: manifolds, and long triangles. `hullmap_tests::sheets` judges random queries by
//! brute force.

use glam::{DQuat, DVec3};
use hullmap::shapes::Cuboid;
use hullmap::{CompoundManifolds, ManifoldSettings, Pose, Prediction};
use hullmap_testkit::{depth::signed_depth_by_points, gap::distance_by_features};
use shapes::rng::SplitMix64;

use crate::meshes::{body, mesh, meshes, triangles};

const SEED: u64 = 0x39;

/// Bodies that touch few triangles, none or many, also beside the mesh and on meshes of one
/// triangle.
#[test]
fn manifolds_are_with_all_triangles_within_the_prediction() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let meshes = meshes(&mut rng);
    let (mut near, mut far) = (0, 0);
    for round in 0..600 {
        let mesh = &meshes[round % meshes.len()];
        let (pack, pose) = body(&mut rng);
        let hull = pack.hull(0).unwrap();
        let prediction = [0.0, 0.05, 0.4][round % 3];
        let settings = ManifoldSettings { prediction: Prediction::Length(prediction), ..ManifoldSettings::default() };
        let points: Vec<DVec3> = hull.vertices().map(|v| pose.transform_point(v.as_dvec3())).collect();
        let mut manifolds = CompoundManifolds::new(256);
        manifolds.set_welding(round % 2 == 0);
        manifolds.update(mesh, &hull, pose, &settings);
        for (index, corners) in triangles(mesh).into_iter().enumerate() {
            let depth = signed_depth_by_points(&corners, &points);
            let distance = if depth < 0.0 { distance_by_features(&corners, &points) } else { 0.0 };
            if distance < prediction - 1e-9 || depth > 1e-9 {
                near += 1;
                // The correction may leave out what another triangle hides.
                let is_found = manifolds.get([index, 0]).is_some();
                assert!(is_found || round % 2 == 0, "round {round}: triangle {index}, {distance} away");
            } else if distance > prediction + 1e-9 {
                far += 1;
                assert!(manifolds.get([index, 0]).is_none(), "round {round}: triangle {index}, {distance} away");
            }
        }
    }
    println!("{near} within the prediction, {far} farther");
    assert!(near > 500 && far > 4_000);
}

/// A box that lies 5 cm deep in a triangle of up to 10 km has its points where its corners are
/// (JoltPhysics#2065: in f32, a point was tens of metres away).
#[test]
fn manifold_points_of_long_triangles_are_exact() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    for length in [2.0, 84.0, 1e3, 1e4] {
        let corners =
            [DVec3::new(-length, -length, 0.0), DVec3::new(length, -length, 0.0), DVec3::new(0.0, length, 0.0)];
        let floor = mesh(&corners, &[[0, 1, 2]]);
        for _ in 0..50 {
            let half = DVec3::new(0.3, 0.2, 0.15);
            let at = DVec3::new(rng.between(-0.3, 0.3) * length, rng.between(-0.5, -0.3) * length, half.z - 0.05);
            let pose = Pose::new(at, DQuat::from_rotation_z(rng.between(0.0, 6.0))).unwrap();
            let mut manifolds = CompoundManifolds::new(4);
            manifolds.update(&floor, &Cuboid::new(half).unwrap(), pose, &ManifoldSettings::default());
            let (_, manifold) = manifolds.iter().next().unwrap();
            assert_eq!(manifold.points().len(), 4, "{length}");
            for point in manifold.points() {
                let corner = pose.transform_point(point.local_b.signum() * half);
                assert!(point.point_b.distance(corner) < 1e-6, "{length}: {point:?}, the corner is at {corner}");
                assert!(point.point_a.distance(corner.with_z(0.0)) < 1e-6, "{length}: {point:?}");
                assert!((point.depth - 0.05).abs() < 1e-9, "{length}: {point:?}");
            }
        }
    }
}
