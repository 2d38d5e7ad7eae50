//! The adapter in double precision: its answers are not rounded to f32 on the way.
#![cfg(all(feature = "f64", feature = "dispatcher"))]

use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap::height_field::{Diagonal, Layout};
use hullmap_parry::f64::{BakedHull, BakedSurface, HullDispatcher};
use hullmap_random::SplitMix64;
use hullmap_testkit::{depth::signed_depth, gap::gap, packs, polytope::Polytope};
use parry3d_f64::math::Pose;
use parry3d_f64::query::{
    ContactManifold, NonlinearRigidMotion, PersistentQueryDispatcher, PointQuery, QueryDispatcher, Ray, RayCast,
};
use parry3d_f64::shape::{Shape, SupportMap};
use shapes::families;

fn baked(points: &[[f32; 3]]) -> BakedHull {
    BakedHull::new(Arc::new(packs::tree_pack(points)).shared_hull(0).unwrap())
}

fn turn(rng: &mut SplitMix64) -> DQuat {
    DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize()
}

#[test]
fn shapes_keep_double_precision() {
    let factors = DVec3::new(-1.1, 0.7, 1.3);
    let hull = baked(&families::rock(300, 1)).scaled(factors).unwrap();
    let points: Vec<DVec3> = hull.hull().vertices().map(|v| v.as_dvec3() * factors).collect();
    let (mut rng, mut exact) = (SplitMix64::new(1), 0);
    for _ in 0..200 {
        let dir = DVec3::from_array(rng.direction());
        let best = points.iter().map(|v| v.dot(dir)).fold(f64::NEG_INFINITY, f64::max);
        assert!((hull.local_support_point(dir).dot(dir) - best).abs() < 1e-14);

        let pose = Pose::from_parts(DVec3::from_array(rng.direction()) * 3.0, turn(&mut rng));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        points.iter().map(|p| pose * *p).for_each(|p| (low, high) = (low.min(p), high.max(p)));
        let found = hull.compute_aabb(&pose);
        // The margin of f32, in both precisions.
        let margin = (low - found.mins).min(found.maxs - high);
        assert!(
            margin.min_element() > 0.0 && (found.maxs - found.mins - (high - low)).max_element() < 1e-5,
            "{found:?}"
        );

        // From far outside to a vertex: the ray ends on the hull, and not before its plane.
        let point = dir * 3.0;
        let projection = hull.project_local_point(point, true);
        let away = (point - projection.point).normalize();
        let height = points.iter().map(|v| v.dot(away)).fold(f64::NEG_INFINITY, f64::max);
        let error = (projection.point.dot(away) - height).abs();
        assert!(error < 1e-4, "{projection:?}");
        exact += usize::from(error < 1e-12);
        let ray = Ray::new(point, -dir);
        let hit = hull.cast_local_ray_and_get_normal(&ray, 10.0, true).unwrap();
        let reach = points.iter().map(|v| v.dot(hit.normal)).fold(f64::NEG_INFINITY, f64::max);
        assert!((ray.point_at(hit.time_of_impact).dot(hit.normal) - reach).abs() < 1e-5, "{hit:?}");
    }
    // The others are within the solver's tolerance.
    assert!(exact > 100, "{exact}");
}

/// Most answers are exact far beyond f32; all are within the solver's tolerance.
#[test]
fn distances_and_depths_keep_double_precision() {
    let (a, b) = (baked(&families::rock(60, 1)), baked(&families::prism(16, 1)));
    let solids = [&a, &b].map(|hull| Polytope::new(hull.hull()));
    let (mut rng, mut exact, mut hits) = (SplitMix64::new(2), 0, 0);
    for _ in 0..300 {
        let (rotation, away) = (turn(&mut rng), DVec3::from_array(rng.direction()) * rng.between(0.2, 2.6));
        let pose = Pose::from_parts(away, rotation);
        let placed = solids[1].placed(hullmap::Pose::new(away, rotation).unwrap());
        let apart = gap(&solids[0], &placed);
        let overlaps = apart.upper < 1e-9;
        hits += usize::from(overlaps);
        let truth = if overlaps { -signed_depth(&solids[0], &placed, 0.0).0 } else { apart.upper };
        let found = HullDispatcher.contact(&pose, &a, &b, 100.0).unwrap().unwrap().dist;
        let error = (found - truth).abs();
        assert!(error < 2e-5 * (1.0 + truth.abs()), "{found} of {truth}");
        exact += usize::from(error < 1e-12);
    }
    assert!((75..225).contains(&hits), "{hits}");
    assert!(exact > 200, "{exact}");
}

/// Far from the origin, where f32 has steps of 6 cm: a field of one ramp, a ray, a distance,
/// contact points, and a cube that turns as it falls onto it.
#[test]
fn surfaces_keep_double_precision() {
    let far = 1e6;
    let layout = Layout { columns: 3, rows: 2, origin: [far, far], spacing: [2.0, 4.0], diagonal: Diagonal::Rising };
    let heights = [0.0, 1.0, 2.0, 0.0, 1.0, 2.0];
    let ramp = BakedSurface::new(Arc::new(packs::height_field(layout, &heights, &[])));
    let (foot, normal) = (DVec3::new(far + 1.3, far + 2.1, 0.65), DVec3::new(-1.0, 0.0, 2.0).normalize());

    let hit = ramp.cast_local_ray_and_get_normal(&Ray::new(foot + DVec3::Z, -DVec3::Z), 9.0, true).unwrap();
    assert!((hit.time_of_impact - 1.0).abs() < 1e-9 && hit.normal.distance(normal) < 1e-9, "{hit:?}");
    let projection = ramp.project_local_point(foot + normal * 0.25, true);
    assert!(projection.point.distance(foot) < 1e-9, "{projection:?}");

    let cube = baked(&families::cube_grid(8, 1));
    let half = cube.compute_local_aabb().half_extents().x;
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
    let above = |gap: f64| Pose::from_parts(foot + normal * (half + gap), turn);
    let found = HullDispatcher.distance(&above(0.125), &ramp, &cube).unwrap().distance;
    assert!((found - 0.125).abs() < 1e-6, "{found}");
    let (mut manifolds, mut workspace) = (Vec::<ContactManifold<(), ()>>::new(), None);
    HullDispatcher.contact_manifolds(&above(-1e-3), &ramp, &cube, 0.02, &mut manifolds, &mut workspace).unwrap();
    let points: Vec<f64> = manifolds.iter().flat_map(|m| m.points.iter().map(|p| p.dist)).collect();
    assert!(points.len() == 4 && points.iter().all(|dist| (dist + 1e-3).abs() < 1e-8), "{points:?}");
    assert!(manifolds.iter().all(|m| m.local_n1.distance(normal) < 1e-9));

    // It falls onto the ramp, and turns about the normal.
    let motion = NonlinearRigidMotion::new(above(0.5), DVec3::ZERO, -normal, normal);
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let hit = HullDispatcher.cast_shapes_nonlinear(&still, &ramp, &motion, &cube, 0.0, 2.0, true).unwrap().unwrap();
    assert!(hit.time_of_impact <= 0.5 && hit.time_of_impact > 0.5 - 1e-5, "{}", hit.time_of_impact);
}
