//! The traits of parry's shapes.

use hullmap::glam::DVec3;
use hullmap_parry::{BakedSurface, JoinError, Sheet};
use hullmap_random::SplitMix64;
use hullmap_testkit::{ray::Line, triangles::distance_from_triangle};
use parry3d::math::{Pose, Vector};
use parry3d::query::{self, PointQuery, Ray, RayCast};
use parry3d::shape::{Ball, FeatureId, Shape, TriMesh};

use crate::grounds::{NamedSurface, field, grounds, mesh};

#[test]
fn rays_and_points_agree_with_brute_force() {
    let mut rng = SplitMix64::new(1);
    for NamedSurface { name, surface, triangles } in grounds(1) {
        let mut hits = 0;
        for _ in 0..500 {
            let origin = (DVec3::from_array(rng.direction()) * rng.between(0.0, 6.0)).as_vec3();
            let aim = (DVec3::from_array(rng.direction()) * 2.0).as_vec3();
            let ray = Ray::new(origin, (aim - origin) * 0.5);
            let (from, dir) = (origin.as_dvec3(), ray.dir.as_dvec3());
            let line = Line::new(from, dir, f64::INFINITY);
            let all = triangles.iter().enumerate().filter_map(|(i, t)| Some((line.meet(*t)?.rounded(), i)));
            let truth = all.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(t, _)| *t <= 1.5);
            let found = surface.cast_local_ray_and_get_normal(&ray, 1.5, true);
            assert_eq!(found.is_some(), truth.is_some(), "{name}");
            if let (Some(found), Some((t, index))) = (found, truth) {
                hits += 1;
                assert!((f64::from(found.time_of_impact) - t).abs() < 1e-5, "{name}: {found:?} {t}");
                assert_eq!((found.subshape as usize, found.feature), (index, FeatureId::Face(index as u32)), "{name}");
                let [a, b, c] = triangles[index];
                let normal = (b - a).cross(c - a).normalize().as_vec3();
                assert!(found.normal.dot(ray.dir) <= 0.0 && found.normal.dot(normal).abs() > 1.0 - 1e-5, "{name}");
                let at = surface.feature_normal_at_point(found.subshape, found.feature, origin).unwrap();
                assert!(at.distance(found.normal) < 1e-4, "{name}");
            }
            let point = origin.as_dvec3();
            let distance = |t: &[DVec3; 3]| distance_from_triangle(*t, point);
            let least = triangles.iter().map(distance).fold(f64::INFINITY, f64::min);
            let (projection, feature) = surface.project_local_point_and_get_feature(origin);
            let FeatureId::Face(face) = feature else { panic!("{name}: {feature:?}") };
            let own = projection.point.as_dvec3();
            assert!((own.distance(point) - least).abs() < 1e-5 && !projection.is_inside, "{name}");
            assert!((distance(&triangles[face as usize]) - least).abs() < 1e-5, "{name}");
            assert!(distance_from_triangle(triangles[face as usize], own) < 1e-5, "{name}");
        }
        assert!((50..450).contains(&hits), "{name}: {hits}");
    }
}

/// Rays from above at the ridge of a roof over a floor: parry's own mesh agrees.
#[test]
fn rays_at_a_ridge_hit_the_roof_as_in_parry() {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let roof = [(0.0, 1.0), (5.0, 0.5), (-5.0, 0.5)].map(|(x, z)| [at(x, -5.0, z), at(x, 5.0, z)]);
    let floor = [at(-9.0, -9.0, 0.0), at(9.0, -9.0, 0.0), at(9.0, 9.0, 0.0), at(-9.0, 9.0, 0.0)];
    let positions = [roof.as_flattened(), &floor].concat();
    let corners = [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [6, 7, 8], [6, 8, 9]];
    let surface = BakedSurface::new(mesh(&positions, &corners));
    let vertices = positions.iter().map(|p| p.as_vec3()).collect();
    let of_parry = TriMesh::new(vertices, corners.to_vec()).unwrap();
    let joined = BakedSurface::joined([(Pose::IDENTITY, surface.clone())]).unwrap();
    for i in 0..40 {
        let y = -4.9 + 0.25 * i as f32;
        let ray = Ray::new(Vector::new(0.0, y, 5.0), Vector::new(0.0, 0.0, -1.0));
        for own in [&surface, &joined, &surface.clone().one_sided()] {
            let found = own.cast_local_ray_and_get_normal(&ray, 9.0, true).unwrap();
            assert_eq!((found.time_of_impact, own.cast_local_ray(&ray, 9.0, true)), (4.0, Some(4.0)), "y {y}");
            assert!(found.normal.z > 0.9 && found.subshape < 4, "y {y}: {found:?}");
        }
        let theirs = of_parry.cast_local_ray(&ray, 9.0, true).unwrap();
        assert!((theirs - 4.0).abs() < 1e-5, "y {y}: {theirs}");
    }
}

/// Tiles that are moved by sums of powers of two share their edges exactly.
#[test]
fn rays_at_the_seams_of_joined_tiles_hit_a_tile() {
    let square =
        |size: f64| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0) * size);
    let corners = [[0, 1, 2], [0, 2, 3]];
    let [tile, floor] = [1.0, 64.0].map(|size| BakedSurface::new(mesh(&square(size), &corners)));
    let at = |x: f32, y: f32, z: f32| Pose::from_translation(Vector::new(x, y, z));
    let tiles = (0..9_u8).map(|k| (at(0.125 + f32::from(k % 3), f32::from(k / 3) - 7.5, 4.0), tile.clone()));
    let below = (at(-32.0, -32.0, 0.0), floor);
    let surface = BakedSurface::joined(tiles.chain([below])).unwrap();
    let seed = 5;
    println!("seed {seed}");
    let mut rng = SplitMix64::new(seed);
    let mut vertices = 0;
    for round in 0..4000 {
        let mut step = |count: f64| (rng.unit() * count).floor() as f32;
        let (seam, along) = (1.0 + step(2.0), 0.25 + step(40.0) / 16.0);
        let [x, y] = if round % 2 == 0 { [seam, along] } else { [along, seam] };
        vertices += usize::from(along.fract() == 0.0);
        let target = Vector::new(0.125 + x, y - 7.5, 4.0);
        let slope = Vector::new(step(65.0) / 32.0 - 1.0, step(65.0) / 32.0 - 1.0, 0.5 + step(16.0) / 16.0);
        let ray = Ray::new(target + slope * 2.0, -slope);
        for own in [&surface, &surface.one_sided()] {
            let found = own.cast_local_ray_and_get_normal(&ray, 1e3, true).unwrap();
            assert_eq!(found.time_of_impact, 2.0, "round {round}: {ray:?}");
            assert!(found.normal.z > 0.9 && found.subshape < 18, "round {round}: {found:?}");
        }
    }
    assert!(vertices > 100, "{vertices}");
}

#[test]
fn boxes_contain_all_triangles() {
    for NamedSurface { name, surface, triangles } in grounds(2) {
        assert_eq!(surface.triangle_count(), triangles.len());
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        triangles.iter().flatten().for_each(|p| (low, high) = (low.min(*p), high.max(*p)));
        let found = surface.compute_local_aabb();
        assert!(found.mins.as_dvec3().cmple(low).all() && found.maxs.as_dvec3().cmpge(high).all(), "{name}");
        assert!(surface.compute_local_bounding_sphere().radius() < 2.0 * low.distance(high) as f32, "{name}");
        let of_parts = surface.as_composite_shape().unwrap();
        for (index, corners) in triangles.iter().enumerate() {
            let mut is_there = false;
            of_parts.map_part_at(index as u32, &mut |pose, shape, _| {
                let pose = pose.copied().unwrap_or(Pose::IDENTITY);
                let triangle = shape.as_triangle().unwrap();
                for (own, corner) in [triangle.a, triangle.b, triangle.c].into_iter().zip(corners) {
                    assert!((pose * own).as_dvec3().distance(*corner) < 1e-5, "{name}");
                }
                is_there = true;
            });
            let near = parry3d::bounding_volume::Aabb::from_points(corners.iter().map(|c| c.as_vec3()));
            assert!(is_there && of_parts.bvh().intersect_aabb(&near).any(|leaf| leaf as usize == index), "{name}");
        }
        assert!(surface.mass_properties(3.0).mass() == 0.0 && surface.scale_dyn(Vector::splat(2.0), 1).is_none());
        assert!(surface.scale_dyn(Vector::ONE, 1).is_some() && !surface.is_convex());
    }
}

/// parry solves each triangle alone, like the triangles of its own mesh.
#[test]
fn the_default_dispatcher_takes_surfaces() {
    let mut rng = SplitMix64::new(3);
    for NamedSurface { name, surface, .. } in grounds(3) {
        let (vertices, triangles) = surface.to_trimesh();
        let of_parry = TriMesh::new(vertices, triangles).unwrap();
        for _ in 0..100 {
            let place = Pose::from_translation((DVec3::from_array(rng.direction()) * rng.between(0.0, 5.0)).as_vec3());
            let ball = Ball::new(0.4);
            let distance = |shape: &dyn Shape| query::distance(&Pose::IDENTITY, shape, &place, &ball).unwrap().distance;
            let (ours, theirs) = (distance(&surface), distance(&of_parry));
            assert!((ours - theirs).abs() < 1e-4, "{name}: {ours} {theirs}");
            let meets = |shape: &dyn Shape| {
                query::intersection_test(&Pose::IDENTITY, shape, &place, &ball).unwrap().intersecting
            };
            let of_both = [meets(&surface), meets(&of_parry)];
            assert!(of_both == [ours == 0.0; 2] || ours < 1e-4, "{name}: {of_both:?} {ours} {theirs}");
        }
    }
}

#[test]
fn triangles_are_found_by_their_subshapes() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
    let (first, second) = (mesh(&corners, &[[0, 1, 2], [1, 3, 2]]), field(1, [0.0; 2], |_, _| 0.0));
    let right = Pose::translation(3.0, 0.0, 0.0);
    let surface = BakedSurface::joined([
        (Pose::IDENTITY, BakedSurface::new(first.clone())),
        (right, BakedSurface::new(second).one_sided()),
    ])
    .unwrap();
    let found: Vec<_> =
        (0..5).map(|i| surface.locate(i).map(|(tile, i)| (tile.first(), i, tile.material(i)))).collect();
    let material = |i: usize| first.material(i);
    assert_eq!(
        found,
        [Some((0, 0, material(0))), Some((0, 1, material(1))), Some((2, 0, Some(0))), Some((2, 1, Some(0))), None]
    );
    let [left, tile] = surface.tiles() else { panic!("two tiles") };
    assert!(matches!(left.sheet(), Sheet::Mesh(_)) && matches!(tile.sheet(), Sheet::Field(_)));
    assert!(!left.is_one_sided() && tile.is_one_sided() && tile.place().translation() == DVec3::X * 3.0);
    // Rays from behind pass a one-sided tile.
    let up = |x: f32| Ray::new(Vector::new(x, 0.2, -1.0), Vector::Z);
    assert!(surface.intersects_local_ray(&up(0.4), 9.0) && !surface.intersects_local_ray(&up(3.4), 9.0));

    assert_eq!(BakedSurface::joined([]).unwrap_err(), JoinError::NoTiles);
    let far = Pose::translation(f32::NAN, 0.0, 0.0);
    let error = BakedSurface::joined([(far, surface)]).unwrap_err();
    assert_eq!(error, JoinError::Pose);
    assert!(error.to_string().contains("move it nearer"));
}
