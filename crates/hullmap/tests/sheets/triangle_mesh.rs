//! Triangle meshes: manifolds, long triangles, damaged files, and work. `hullmap_tests::sheets`
//! judges random queries by brute force.

use glam::{DQuat, DVec3};
use hullmap::shapes::{Cuboid, Sphere};
use hullmap::{Cache, CastSettings, CompoundManifolds, ManifoldSettings, Motion, Pose, Prediction, Settings};
use hullmap_testkit::{depth::signed_depth_by_points, gap::distance_by_features};
use shapes::rng::SplitMix64;

use crate::meshes::{body, grid, mesh, meshes, slide_box, triangles};

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

/// A ball that falls onto a triangle meets it when its centre is a radius above.
#[test]
fn casts_meet_the_surface() {
    let (floor, ball) = (grid(6, |_, _| 0.0), Sphere::new(0.5).unwrap());
    let start = Pose::from_translation(DVec3::new(0.3, 0.2, 3.0)).unwrap();
    let fall = Motion::new(DVec3::new(0.1, 0.0, -1.0)).unwrap();
    let settings = CastSettings { max_t: 10.0, ..CastSettings::default() };
    let found = hullmap::cast(&floor, &ball, start, fall, &settings, &mut Cache::new());
    assert!(found.hit && found.t_lower <= 2.5 && 2.5 <= found.t_upper, "{found:?}");
    assert!(found.normal.distance(DVec3::Z) < 1e-6);
}

/// A box that slides over triangles, a little below their surface, over every kind of edge inside
/// it: all normals are normals of the faces.
#[test]
fn a_box_does_not_stumble_over_edges_inside_a_surface() {
    let flat = grid(10, |_, _| 0.0);
    // A valley and a ridge: edges where normals differ, along y.
    let folded = grid(10, |x, _| [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0][x]);
    let replaced = slide_box(&flat, DVec3::new(0.3, 0.3, 0.2), 1000, 0.008)
        + slide_box(&flat, DVec3::new(0.01, 0.02, 0.01), 1000, 0.008)
        + slide_box(&folded, DVec3::splat(0.1), 1000, 0.0012);
    println!("{replaced} poses stumble without welding");
    assert!(replaced > 50, "the poses are too easy: {replaced}");
}

/// Long triangles: a body 5 cm deep in one of 1 cm to 10 km has its contact point where it is.
#[test]
fn contact_points_of_long_triangles_are_exact() {
    let settings = Settings::default();
    for length in [0.01, 1.0, 84.0, 1e3, 1e4] {
        let corners = [[0, 1, 2]];
        let floor = mesh(
            &[DVec3::new(-length, -length, 0.0), DVec3::new(length, -length, 0.0), DVec3::new(0.0, length, 0.0)],
            &corners,
        );
        for (share, turn) in [(0.0, 0.0), (0.1, 0.7), (-0.4, 2.0)] {
            let size = 0.2;
            let die = Cuboid::new(DVec3::splat(size)).unwrap();
            // One corner down.
            let rotation =
                DQuat::from_rotation_z(turn) * DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_Z);
            let lowest = size * 3.0_f64.sqrt();
            let depth = 0.05_f64.min(0.2 * length);
            let at = DVec3::new(share * length * 0.5, -0.3 * length, lowest - depth);
            let pose = Pose::new(at, rotation).unwrap();
            let found = hullmap::contact(&floor, &die, pose, &settings, &mut Cache::new());
            assert!(found.depth_lower <= depth + 1e-12 && depth <= found.depth_upper + 1e-12, "{length}: {found:?}");
            if length >= 1.0 {
                let expected = DVec3::new(at.x, at.y, 0.0);
                assert!(found.point_a.distance(expected) < 1e-6, "{length}: {found:?}, expected {expected}");
                assert!(found.normal.distance(DVec3::Z) < 1e-6, "{length}: {found:?}");
            }
        }
    }
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

/// A query of a mesh of a million triangles compares few boxes, whatever the mesh is.
#[test]
fn work_grows_with_the_logarithm_of_the_mesh() {
    let ball = Sphere::new(0.5).unwrap();
    let near = Pose::from_translation(DVec3::new(0.2, 0.1, 0.4)).unwrap();
    let mut counts = Vec::new();
    for cells in [8, 32, 128] {
        let mesh = grid(cells, |_, _| 0.0);
        let hits = hullmap::contacts(&mesh, &ball, near, &Settings::default(), &mut Cache::new(), |_| ());
        println!("{} triangles: {hits:?}", mesh.triangle_count());
        assert!(hits.pairs <= 8, "{hits:?}");
        counts.push(hits.boxes);
    }
    let (first, last) = (counts[0], counts[2]);
    // 256 times as many triangles: eight more levels.
    assert!(last <= first + 64, "{counts:?}");
}
