//! Manifolds of triangle meshes. `hullmap_tests::sheets` judges random queries by
//! brute force.

use glam::DVec3;
use hullmap::{CompoundManifolds, ManifoldSettings, Prediction};
use hullmap_testkit::{depth::signed_depth_by_points, gap::distance_by_features};
use shapes::rng::SplitMix64;

use crate::meshes::{body, meshes, triangles};

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
