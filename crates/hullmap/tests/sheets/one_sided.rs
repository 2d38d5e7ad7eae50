//! Sheets that collide on their fronts alone. `hullmap_tests::sheets::joints` judges rays and
//! casts.

use glam::DVec3;
use hullmap::compound::OneSided;
use hullmap::shapes::Cuboid;
use hullmap::{Cache, CompoundManifolds, ManifoldSettings, Pose, Settings, SupportMap, TriangleMesh};
use hullmap_testkit::depth::signed_depth_by_points;
use shapes::rng::SplitMix64;

use crate::meshes::{body, grid, meshes, triangles};

const SEED: u64 = 0x15;

/// Corners of a triangle and its front.
fn fronts(mesh: &TriangleMesh) -> Vec<([DVec3; 3], DVec3)> {
    triangles(mesh).into_iter().map(|[a, b, c]| ([a, b, c], (b - a).cross(c - a).normalize())).collect()
}

/// Contacts belong to triangles whose fronts face the body. A contact with the back becomes the
/// contact with the half-space: its depth is the depth of the lowest vertex.
#[test]
fn contacts_are_those_of_the_fronts() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let (meshes, settings) = (meshes(&mut rng), Settings::default());
    let (mut kept, mut behind, mut from_back) = (0, 0, 0);
    for round in 0..9000 {
        let mesh = &meshes[round % meshes.len()];
        let (pack, pose) = body(&mut rng);
        let hull = pack.hull(0).unwrap();
        let points: Vec<DVec3> = hull.vertices().map(|v| pose.transform_point(v.as_dvec3())).collect();
        let center = pose.transform_point(hull.interior_point());
        let collect = |one_sided: bool| {
            let (mut found, mut cache) = (Vec::new(), Cache::new());
            let visit = |contact: &hullmap::Contact| found.push((contact.parts[0] as usize, *contact));
            if one_sided {
                hullmap::contacts(&OneSided::new(mesh), &hull, pose, &settings, &mut cache, visit);
            } else {
                hullmap::contacts(mesh, &hull, pose, &settings, &mut cache, visit);
            }
            found.sort_by_key(|(triangle, _)| *triangle);
            found
        };
        let fronts = fronts(mesh);
        let (both, one) = (collect(false), collect(true));
        let hit = hullmap::intersects(&OneSided::new(mesh), &hull, pose, &mut Cache::new());
        assert_eq!(hit.is_hit(), !one.is_empty(), "round {round}");
        let mut one = one.into_iter();
        for (triangle, two_sided) in both {
            let (corners, front) = fronts[triangle];
            let height = (center - corners[0]).dot(front);
            if height < 0.0 {
                behind += 1;
                continue;
            }
            let (found, contact) = one.next().unwrap();
            assert_eq!(found, triangle, "round {round}");
            kept += 1;
            if two_sided.normal.dot(front) > -0.99 {
                assert_eq!(contact, two_sided, "round {round}");
                continue;
            }
            from_back += 1;
            let lowest = points.iter().map(|p| (*p - corners[0]).dot(front)).fold(f64::INFINITY, f64::min);
            assert!(contact.normal.distance(front) < 1e-9, "round {round}");
            let (lower, upper) = (contact.depth_lower, contact.depth_upper);
            assert!(lower <= -lowest + 1e-12 && -lowest <= upper + 1e-12, "round {round}: {contact:?}, {lowest}");
            assert!(upper - lower < 1e-9, "round {round}");
            // The half-space is at least as deep as the triangle.
            assert!(upper >= signed_depth_by_points(&corners, &points) - 1e-9, "round {round}");
        }
        assert!(one.next().is_none(), "round {round}");
    }
    println!("{kept} kept, {behind} behind, {from_back} from the back");
    assert!(kept > 500 && behind > 500 && from_back > 10);
}

/// A box that sinks through a floor is pushed up until its middle is below, from any depth, and
/// then falls on.
#[test]
fn manifolds_push_to_the_front_until_the_middle_is_behind() {
    let ground = grid(6, |_, _| 0.0);
    let floor = OneSided::new(&ground);
    let die = Cuboid::new(DVec3::new(0.4, 0.3, 0.5)).unwrap();
    let settings = ManifoldSettings::default();
    for step in 0..100 {
        let height = 0.6 - 0.012 * f64::from(step);
        let at = Pose::from_translation(DVec3::new(0.23, 0.11, height)).unwrap();
        let mut manifolds = CompoundManifolds::new(32);
        manifolds.update(&floor, &die, at, &settings);
        // At the height 0, rounding decides.
        if !(1e-9..=0.52).contains(&height) {
            assert!(manifolds.is_empty(), "{height}");
            continue;
        }
        if height <= 0.5 {
            assert!(!manifolds.is_empty(), "{height}");
        }
        for (_, manifold) in manifolds.iter() {
            assert!(manifold.normal().distance(DVec3::Z) < 1e-6, "{height}: {}", manifold.normal());
            assert!(manifold.points().iter().all(|p| (p.depth - (0.5 - height)).abs() < 1e-6), "{height}");
        }
    }
    // The mesh as the second shape: the normal is from the die to the floor.
    let a_in_b = Pose::from_translation(DVec3::new(-0.23, -0.11, -0.2)).unwrap();
    let mut swapped = CompoundManifolds::new(32);
    swapped.update(&die, &floor, a_in_b, &settings);
    assert!(!swapped.is_empty());
    for (_, manifold) in swapped.iter() {
        assert!(manifold.normal().distance(DVec3::NEG_Z) < 1e-6, "{}", manifold.normal());
        assert!(manifold.points().iter().all(|p| (p.depth - 0.3).abs() < 1e-6));
    }
    let (contact_settings, mut cache) = (Settings::default(), Cache::new());
    let contact = hullmap::contact(&die, &floor, a_in_b, &contact_settings, &mut cache);
    assert!(contact.normal.distance(DVec3::NEG_Z) < 1e-6 && (contact.depth - 0.3).abs() < 1e-6, "{contact:?}");
}
