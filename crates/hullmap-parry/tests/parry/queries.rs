//! `HullDispatcher` on surfaces.

use hullmap::glam::DVec3;
use hullmap_parry::{BakedHull, BakedSurface, HullDispatcher};
use hullmap_random::SplitMix64;
use hullmap_testkit::depth::signed_depth_by_points;
use hullmap_testkit::gap::distance_by_features;
use parry3d::math::{Pose, Vector};
use parry3d::query::details::ShapeCastOptions;
use parry3d::query::{DefaultQueryDispatcher, QueryDispatcher, ShapeCastStatus};
use parry3d::shape::{Compound, TriMesh};

use crate::bodies::{hull, pose, vertices};
use crate::dispatcher::primitives;
use crate::grounds::{NamedSurface, field, grounds, mesh};
use crate::judge::{check, time};

/// The distance of a body from all triangles; negative if it overlaps one: the greatest depth.
fn truth(triangles: &[[DVec3; 3]], body: &[DVec3]) -> f64 {
    let center = body.iter().sum::<DVec3>() / body.len() as f64;
    let radius = body.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
    let mut least = f64::INFINITY;
    for corners in triangles {
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let reach = corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        if middle.distance(center) - radius - reach > least.max(0.0) {
            continue;
        }
        let depth = signed_depth_by_points(corners, body);
        least = least.min(if depth > 0.0 { -depth } else { distance_by_features(corners, body) });
    }
    least
}

#[test]
fn hulls_and_compounds_agree_with_brute_force() {
    let rock = hull(&shapes::families::rock(12, 1));
    let places = [Pose::translation(-0.6, 0.1, 0.0), Pose::new(Vector::new(0.7, 0.0, 0.2), Vector::Y * 0.7)];
    let compound = Compound::new(places.iter().map(|place| (*place, rock.clone().into())).collect());
    let mut rng = SplitMix64::new(4);
    for NamedSurface { name, surface, triangles } in grounds(4) {
        let mut hits = 0;
        for _ in 0..36 {
            let distance = rng.between(0.5, 6.0);
            let at = pose(&mut rng, distance);
            let of_rock = truth(&triangles, &vertices(&rock, &at));
            hits += usize::from(of_rock < 0.0);
            check(name, &surface, &rock, &at, of_rock, [3e-5, 1e-3]);
            let of_parts = places.map(|place| truth(&triangles, &vertices(&rock, &(at * place))));
            check(name, &surface, &compound, &at, of_parts[0].min(of_parts[1]), [3e-5, 1e-3]);
        }
        assert!((3..33).contains(&hits), "{name}: {hits}");
    }
}

#[test]
fn primitives_agree_with_parrys_mesh() {
    let mut rng = SplitMix64::new(5);
    for NamedSurface { name, surface, .. } in grounds(5) {
        let (vertices, triangles) = surface.to_trimesh();
        let theirs = TriMesh::new(vertices, triangles).unwrap();
        for (kind, shape) in primitives() {
            for _ in 0..9 {
                let distance = rng.between(0.5, 6.0);
                let at = pose(&mut rng, distance);
                let apart = DefaultQueryDispatcher.distance(&at, &theirs, &*shape).unwrap().distance;
                let ours = HullDispatcher.contact(&at, &surface, &*shape, 100.0).unwrap().unwrap().dist;
                assert!((ours.max(0.0) - apart).abs() < 1e-2, "{name}, {kind}: {ours} {apart}");
                check(&format!("{name}, {kind}"), &surface, &*shape, &at, f64::from(ours), [1e-4, 5e-3]);
            }
        }
    }
}

#[test]
fn casts_end_at_the_target_distance() {
    let rock = hull(&shapes::families::rock(12, 2));
    let mut rng = SplitMix64::new(6);
    for NamedSurface { name, surface, triangles } in grounds(6) {
        for target_distance in [0.0, 0.1] {
            let options = ShapeCastOptions { max_time_of_impact: 3.0, target_distance, ..Default::default() };
            let (mut hits, within) = (0, ShapeCastStatus::PenetratingOrWithinTargetDist);
            for _ in 0..24 {
                let at = pose(&mut rng, 6.0);
                let aim = (DVec3::from_array(rng.direction()) * 3.5).as_vec3();
                let velocity = (aim - at.translation) * 0.5;
                let found = HullDispatcher.cast_shapes(&at, velocity, &surface, &rock, options).unwrap();
                let turned = -(at.rotation.inverse() * velocity);
                let swapped = HullDispatcher.cast_shapes(&at.inverse(), turned, &rock, &surface, options).unwrap();
                let apart = |t: f32| {
                    let moved = Pose::from_parts(at.translation + velocity * t, at.rotation);
                    (truth(&triangles, &vertices(&rock, &moved)), moved)
                };
                let target = f64::from(target_distance);
                if apart(0.0).0 < target {
                    let hit = found.unwrap();
                    assert_eq!((hit.time_of_impact, hit.status), (0.0, within), "{name}");
                    continue;
                }
                let end = time(found).min(3.0);
                let before = (0..12).map(|i| apart(end * i as f32 / 12.0).0).fold(f64::INFINITY, f64::min);
                assert!(before > target - 1e-4, "{name}: {before}");
                assert!((time(swapped).min(9.0) - time(found).min(9.0)).abs() < 1e-4, "{name}");
                let Some(hit) = found else { continue };
                hits += 1;
                let (dist, moved) = apart(hit.time_of_impact);
                assert!((dist - target).abs() < 1e-4, "{name}: {dist}");
                let between = moved * hit.witness2 - hit.witness1;
                assert!((between.length() - target_distance).abs() < 1e-3, "{name}: {between}");
                assert!(hit.subshape2 == 0 && swapped.unwrap().subshape1 == 0, "{name}");
                // Two triangles that share an edge may be hit at the same time.
                for index in [hit.subshape1, swapped.unwrap().subshape2] {
                    let own = [triangles[index as usize]];
                    assert!((truth(&own, &vertices(&rock, &moved)) - target).abs() < 1e-4, "{name}");
                }
            }
            assert!((3..24).contains(&hits), "{name}: {hits}");
        }
    }
}

/// A body that lies on the ground moves towards a wall: with `stop_at_penetration`, the cast ends
/// at once. Without, it ends at the wall, or never if there is none.
#[test]
fn a_body_on_the_ground_is_cast_against_a_wall() {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let positions = [
        at(-50.0, -9.0, 0.0),
        at(4.0, -9.0, 0.0),
        at(4.0, 9.0, 0.0),
        at(-50.0, 9.0, 0.0),
        at(4.0, -9.0, 5.0),
        at(4.0, 9.0, 5.0),
    ];
    let floor = BakedSurface::new(mesh(&positions, &[[0, 1, 2], [0, 2, 3]]));
    let level = BakedSurface::new(mesh(&positions, &[[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]));
    let rock = hull(&shapes::families::cube_grid(8, 1));
    let half = rock.hull().bounds()[1].z;
    let place = Pose::translation(-20.0, 0.0, half - 1e-4);
    let sliding = Vector::new(2.0, 0.3, 0.0);
    for stop_at_penetration in [true, false] {
        let options = ShapeCastOptions { max_time_of_impact: 100.0, stop_at_penetration, ..Default::default() };
        for (surface, wall) in [(&floor, f32::INFINITY), (&level, (24.0 - half) / 2.0)] {
            for surface in [surface.clone(), surface.one_sided()] {
                let [tile] = surface.tiles() else { panic!("one tile") };
                let found = HullDispatcher.cast_shapes(&place, sliding, &surface, &rock, options).unwrap();
                // A body that does not move towards the front of a triangle does not hit it.
                if stop_at_penetration && !tile.is_one_sided() {
                    assert_eq!(time(found), 0.0);
                } else {
                    assert!(time(found) == wall || (time(found) - wall).abs() < 1e-3, "{} {wall}", time(found));
                }
            }
        }
    }
}

/// A field of a thousand triangles under a large body, and numbers that are not finite.
#[test]
fn large_bodies_and_invalid_numbers_are_harmless() {
    let surface = BakedSurface::new(field(24, [-12.0; 2], |x, y| ((x * 7 + y * 13) % 5) as f32 * 1e-3));
    let rock: BakedHull = hull(&shapes::families::rock(50, 1)).scaled(Vector::splat(20.0)).unwrap();
    for bad in [f32::NAN, f32::INFINITY, 1e38] {
        let at = Pose::translation(bad, 1.0, 0.0);
        let (mut manifolds, mut workspace) = (Vec::<parry3d::query::ContactManifold<(), ()>>::new(), None);
        use parry3d::query::PersistentQueryDispatcher as _;
        let _ = HullDispatcher.contact_manifolds(&at, &surface, &rock, 0.02, &mut manifolds, &mut workspace);
        let _ = HullDispatcher.distance(&at, &surface, &rock);
        let _ = HullDispatcher.cast_shapes(&at, Vector::splat(bad), &surface, &rock, Default::default());
        let near = Pose::translation(0.0, 0.0, 9.0);
        let _ = HullDispatcher.cast_shapes(&near, Vector::splat(bad), &surface, &rock, Default::default());
    }
}
