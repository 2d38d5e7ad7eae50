//! The shape traits of baked hulls against brute force over vertices and faces in f64, and against
//! parry's own polyhedron of the same vertices.

use hullmap::glam::DVec3;
use hullmap_parry::BakedHull;
use hullmap_random::SplitMix64;
use hullmap_testkit::{entry::passage_of_point, gap::gap, polytope::Polytope, reach::Reach};
use parry3d::bounding_volume::BoundingVolume;
use parry3d::math::Vector;
use parry3d::query::{PointQuery, Ray, RayCast};
use parry3d::shape::{
    ConvexPolyhedron, FeatureId, PolygonalFeature, PolygonalFeatureMap, Shape, SharedShape, SupportMap,
};
use shapes::families;

use crate::bodies::{hull as baked, pose};

/// A baked hull, its vertices and outward normals in f64, and parry's polyhedron.
struct Case {
    name: &'static str,
    hull: BakedHull,
    solid: Polytope,
    parry: ConvexPolyhedron,
}

fn case(name: &'static str, points: &[[f32; 3]], scale: Vector) -> Case {
    let hull = baked(points).scaled(scale).unwrap();
    let mut solid = Polytope::new(hull.hull());
    let factors = wide(scale);
    solid.points.iter_mut().for_each(|p| *p *= factors);
    solid.normals.iter_mut().for_each(|n| *n = (*n / factors).normalize());
    let parry = hull.to_convex_polyhedron().expect("a solid");
    Case { name, hull, solid, parry }
}

fn cases() -> Vec<Case> {
    let mirrored = Vector::new(-1.5, 0.5, 2.0);
    let mut cases = Vec::new();
    for scale in [Vector::ONE, mirrored, Vector::splat(0.1)] {
        cases.push(case("rock", &families::rock(300, 1), scale));
        cases.push(case("prism", &families::prism(64, 1), scale));
        cases.push(case("sphere", &families::sphere(500, 2), scale));
        cases.push(case("cube", &families::cube_grid(27, 1), scale));
    }
    cases
}

fn wide(v: Vector) -> DVec3 {
    v.as_dvec3()
}

fn narrow(v: DVec3) -> Vector {
    v.as_vec3()
}

impl Case {
    fn size(&self) -> f64 {
        self.solid.greatest()
    }

    /// Signed distance to the surface by planes, exact inside; outside a lower bound.
    fn beyond_planes(&self, p: DVec3) -> f64 {
        self.solid.normals.iter().map(|n| p.dot(*n) - self.solid.reach(*n)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Where a line enters and leaves, by clipping at all planes; `None` if it misses.
    fn clip(&self, origin: DVec3, dir: DVec3) -> Option<[f64; 2]> {
        let offsets: Vec<f64> = self.solid.normals.iter().map(|n| self.solid.reach(*n)).collect();
        let found = passage_of_point(&self.solid, &offsets, origin, dir, 0.0);
        (found.enter[0] <= found.exit[0]).then_some([found.enter[0], found.exit[0]])
    }
}

#[test]
fn support_points_are_the_farthest_vertices() {
    let mut rng = SplitMix64::new(1);
    for case in cases() {
        for _ in 0..500 {
            let dir = DVec3::from_array(rng.direction());
            let found = wide(case.hull.local_support_point(narrow(dir))).dot(wide(narrow(dir)));
            let best = case.solid.reach(wide(narrow(dir)));
            assert!((found - best).abs() < 1e-6 * case.size(), "{}: {found} of {best}", case.name);
        }
    }
}

#[test]
fn boxes_are_tight_under_every_pose() {
    let mut rng = SplitMix64::new(2);
    for case in cases() {
        for _ in 0..100 {
            let pose = pose(&mut rng, 3.0);
            let found = case.hull.compute_aabb(&pose);
            let placed = case.solid.points.iter().map(|p| pose.rotation.as_dquat() * *p + wide(pose.translation));
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            placed.for_each(|p| (low, high) = (low.min(p), high.max(p)));
            let error = (wide(found.mins) - low).abs().max((wide(found.maxs) - high).abs()).max_element();
            assert!(error < 2e-6 * (case.size() + 3.0), "{}: {error:e}", case.name);
        }
        let local = case.hull.compute_local_aabb();
        assert!(local.contains(&case.parry.compute_local_aabb()) && case.parry.compute_local_aabb().contains(&local));
        let ball = case.hull.compute_local_bounding_sphere();
        let farthest = case.solid.points.iter().map(|p| p.distance(wide(ball.center))).fold(0.0, f64::max);
        assert!(farthest <= f64::from(ball.radius) && f64::from(ball.radius) < 1.7 * case.size(), "{}", case.name);
    }
}

#[test]
fn rays_hit_where_planes_clip_them() {
    let mut rng = SplitMix64::new(3);
    let (mut hits, mut total) = (0, 0);
    for case in cases() {
        for inside in [false, true] {
            for _ in 0..200 {
                let out = DVec3::from_array(rng.direction()) * case.size() * if inside { 0.05 } else { 3.0 };
                let target = DVec3::from_array(rng.direction()) * case.size() * 1.1;
                let origin = wide(narrow(out));
                let dir = wide(narrow(target - origin));
                if inside && case.beyond_planes(origin) > 0.0 {
                    continue;
                }
                let ray = Ray::new(narrow(origin), narrow(dir));
                let expected = case.clip(origin, dir).filter(|[_, leave]| *leave >= 0.0);
                let found = case.hull.cast_local_ray_and_get_normal(&ray, f32::MAX, !inside);
                total += 1;
                match (found, expected) {
                    (Some(found), Some([enter, leave])) => {
                        hits += 1;
                        let truth = if inside { leave } else { enter };
                        let error = (f64::from(found.time_of_impact) - truth).abs() * dir.length() / case.size();
                        // A ray that grazes an edge is ill-conditioned.
                        let grazing = (leave - enter) * dir.length() < 0.05 * case.size();
                        assert!(error < 1e-5 || grazing, "{}: {} of {truth}", case.name, found.time_of_impact);
                        let solid = case.hull.cast_local_ray(&ray, f32::MAX, true).unwrap();
                        assert!(!inside || solid == 0.0);
                        if !grazing {
                            // The normal points against the ray, and is the normal of a plane
                            // through the point.
                            let normal = wide(found.normal);
                            let outward = if inside { -normal } else { normal };
                            let above = case.solid.reach(outward) - (origin + dir * truth).dot(outward);
                            assert!(
                                normal.dot(dir) < 0.0 && above.abs() < 1e-5 * case.size(),
                                "{}: {above}",
                                case.name
                            );
                            assert!((normal.length() - 1.0).abs() < 1e-6, "{}", case.name);
                            assert!(matches!(found.feature, FeatureId::Face(_)), "{}", case.name);
                            assert!(case.hull.cast_local_ray(&ray, truth as f32 * 0.99, !inside).is_none());
                        }
                    }
                    (None, None) => {}
                    (found, expected) => {
                        let depth = expected.map_or(0.0, |[enter, leave]| (leave - enter) * dir.length());
                        assert!(depth < 0.05 * case.size(), "{}: {found:?} {expected:?}", case.name);
                    }
                }
            }
        }
    }
    assert!((0.3..0.95).contains(&(f64::from(hits) / f64::from(total))), "{hits} of {total}");
}

#[test]
fn points_project_to_the_surface() {
    let mut rng = SplitMix64::new(4);
    let mut inside = 0;
    for case in cases() {
        for _ in 0..200 {
            let point = narrow(DVec3::from_array(rng.direction()) * case.size() * rng.between(0.0, 1.5));
            let signed = case.beyond_planes(wide(point));
            let found = case.hull.project_local_point(point, false);
            let dot = Polytope { points: vec![wide(point)], normals: Vec::new(), edges: Vec::new() };
            let slight = 1e-5 * case.size();
            if signed.abs() > slight {
                assert_eq!(found.is_inside, signed < 0.0, "{}", case.name);
            }
            inside += i32::from(found.is_inside);
            let distance = f64::from((found.point - point).length());
            let expected = if signed < 0.0 { -signed } else { gap(&case.solid, &dot).upper };
            assert!((distance - expected).abs() < slight, "{}: {distance} of {expected}", case.name);
            assert!(case.beyond_planes(wide(found.point)).abs() < slight, "{}", case.name);
            assert_eq!(case.hull.contains_local_point(point), found.is_inside);
        }
    }
    assert!((300..2300).contains(&inside), "{inside}");
}

/// The face of a projection contains it if both have the same normal, and a vertex has the normal
/// of one of its faces.
#[test]
fn faces_of_projections_and_of_vertices() {
    let (mut rng, mut inner) = (SplitMix64::new(5), 0);
    for case in cases() {
        let reach = |n: DVec3| case.solid.reach(n);
        for _ in 0..50 {
            let point = narrow(DVec3::from_array(rng.direction()) * case.size() * 2.0);
            let (found, face) = case.hull.project_local_point_and_get_feature(point);
            assert!(matches!(face, FeatureId::Face(_)) && !found.is_inside, "{}: {face:?}", case.name);
            let normal = wide(case.hull.feature_normal_at_point(0, face, found.point).expect("a face has a normal"));
            let along = (wide(point) - wide(found.point)).normalize().dot(normal);
            assert!((normal.length() - 1.0).abs() < 1e-6 && along > 0.0, "{}: {along}", case.name);
            if along > 0.999_999 {
                let below = reach(normal) - wide(found.point).dot(normal);
                assert!(below.abs() < 1e-4 * case.size(), "{}: {below}", case.name);
                inner += 1;
            }

            let vertex = rng.below(case.solid.points.len()) as u32;
            let normal = case.hull.feature_normal_at_point(0, FeatureId::Vertex(vertex), point).map(wide);
            let normal = normal.expect("a vertex has faces");
            let below = reach(normal) - case.solid.points[vertex as usize].dot(normal);
            assert!(below.abs() < 1e-5 * case.size(), "{}: {below}", case.name);
        }
        assert!(case.hull.feature_normal_at_point(0, FeatureId::Vertex(u32::MAX), Vector::ZERO).is_none());
        assert!(case.hull.feature_normal_at_point(0, FeatureId::Face(u32::MAX), Vector::ZERO).is_none());
    }
    assert!(inner > 40, "{inner}");
}

/// On the cap of a prism of many sides, the four corners span the cap; a side has exactly four.
#[test]
fn features_of_a_prism() {
    let hull = baked(&families::prism(1000, 1));
    let mut feature = PolygonalFeature::default();
    hull.local_support_feature(Vector::new(1e-4, -2e-4, 1.0), &mut feature);
    assert_eq!(feature.num_vertices, 4);
    let [a, b, c, d] = feature.vertices;
    assert!(0.5 * (c - a).cross(d - b).length() > 1.9 && feature.vertices.iter().all(|v| v.z == 1.0));
    let ids: std::collections::BTreeSet<u32> = feature.vids.iter().map(|id| id.0).collect();
    assert_eq!(ids.len(), 4);

    let four_sides = baked(&families::prism(8, 1));
    // Towards an edge, the merged feature is the edge, and the face is returned instead.
    four_sides.local_support_feature(Vector::new(1.0, 0.0, 1.1), &mut feature);
    assert!(feature.num_vertices == 4);
}

#[test]
fn scales_multiply_and_zero_is_rejected() {
    let hull = baked(&families::rock(50, 1));
    let shape: SharedShape = hull.clone().into();
    let twice = shape.scale_dyn(Vector::new(2.0, -1.0, 1.0), 0).unwrap();
    let back = twice.scale_dyn(Vector::new(0.5, -1.0, 1.0), 0).unwrap();
    assert_eq!(back.as_shape::<BakedHull>().unwrap().scale(), Vector::ONE);
    assert_eq!(back.compute_local_aabb().maxs, hull.compute_local_aabb().maxs);
    assert!(shape.scale_dyn(Vector::ZERO, 0).is_none() && shape.scale_dyn(Vector::NAN, 0).is_none());
}

/// A polygon and a segment have no mass and no polyhedron, and answer all queries.
#[test]
fn flat_hulls_are_shapes() {
    let flat = families::flat_sheet(40, 1);
    let segment: Vec<[f32; 3]> = (0..4).map(|i| [i as f32, 0.0, 0.0]).collect();
    for points in [flat, segment] {
        let hull = baked(&points);
        assert_eq!(hull.mass_properties(1.0).mass(), 0.0);
        assert!(hull.to_convex_polyhedron().is_none());
        let above = Vector::new(0.0, 0.0, 5.0) + hull.compute_local_aabb().center();
        assert!((hull.distance_to_local_point(above, true) - 5.0).abs() < 0.1);
        let mut feature = PolygonalFeature::default();
        hull.local_support_feature(Vector::Z, &mut feature);
        assert!(feature.num_vertices >= 1);
        assert!(hull.cast_local_ray(&Ray::new(above, Vector::Z), 100.0, true).is_none());
    }
}

#[test]
fn numbers_that_are_not_finite_are_harmless() {
    let hull = baked(&families::rock(100, 1));
    for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 0.0] {
        let v = Vector::new(bad, 1.0, 0.0) * bad;
        let _ = hull.local_support_point(v);
        let mut feature = PolygonalFeature::default();
        hull.local_support_feature(v, &mut feature);
        assert!(feature.num_vertices >= 1);
    }
}
