//! The adapter in double precision: its answers are not rounded to f32 on the way.
#![cfg(all(feature = "f64", feature = "dispatcher"))]

use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap_parry::f64::{BakedHull, HullDispatcher};
use hullmap_random::SplitMix64;
use hullmap_testkit::{depth::signed_depth, gap::gap, packs, polytope::Polytope};
use parry3d_f64::math::Pose;
use parry3d_f64::query::{PointQuery, QueryDispatcher, Ray, RayCast};
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
