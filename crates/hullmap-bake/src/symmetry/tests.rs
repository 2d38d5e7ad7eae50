use shapes::{concave, rng::SplitMix64};

use super::*;
use crate::test_meshes::{block, corners, mesh, point_set};

fn mirrored_cloud(rng: &mut SplitMix64, count: usize, plane: (DVec3, f64)) -> Vec<[f32; 3]> {
    let mut points = Vec::new();
    for _ in 0..count {
        let p = DVec3::from_array(std::array::from_fn(|_| f64::from(rng.between(-1.0, 1.0) as f32)));
        let image = p - plane.0 * (2.0 * (plane.0.dot(p) - plane.1));
        points.extend([p, image].map(|p| p.as_vec3().to_array()));
    }
    for k in (1..points.len()).rev() {
        points.swap(k, rng.below(k + 1));
    }
    points
}

#[test]
fn planes_through_the_origin_across_an_axis_are_exact() {
    let mut rng = SplitMix64::new(1);
    for round in 0..30 {
        let axis = round % 3;
        let found = search::mirrors(&mirrored_cloud(&mut rng, 40, (DVec3::AXES[axis], 0.0)));
        assert_eq!(found.len(), 1, "round {round}");
        assert_eq!((found[0].axis(), found[0].is_exact(), found[0].error), (Some(axis), true, 0.0), "round {round}");
        assert_eq!(found[0].to_string(), ["x = 0", "y = 0", "z = 0"][axis]);
    }
}

#[test]
fn any_plane_is_found() {
    let mut rng = SplitMix64::new(2);
    for round in 0..60 {
        let normal = DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0))).normalize();
        let offset = rng.between(-3.0, 3.0);
        let points = mirrored_cloud(&mut rng, 30, (normal, offset));
        let found = search::mirrors(&points);
        let Some(Mirror { plane, error }) = found.first() else { panic!("round {round}: no plane") };
        let sign = plane.normal.dot(normal).signum();
        assert!(plane.normal.distance(normal * sign) < 1e-5, "round {round}: {plane:?}");
        assert!((plane.offset * sign - offset).abs() < 1e-5, "round {round}: {plane:?} {offset}");
        assert!(*error <= 3.0 * search::tolerance(&points), "round {round}: {error}");
    }
}

#[test]
fn points_that_are_not_symmetric_have_no_plane() {
    let mut rng = SplitMix64::new(3);
    for round in 0..30 {
        let mut points = mirrored_cloud(&mut rng, 30, (DVec3::Y, 0.5));
        assert_eq!(search::mirrors(&points).len(), 1);
        let moved = rng.below(points.len());
        points[moved][1] += 1e-4;
        assert_eq!(search::mirrors(&points), [], "round {round}");
    }
    assert_eq!(search::mirrors(&[]), []);
    assert_eq!(search::mirrors(&[[1.0; 3]; 9]), []);
    assert_eq!(search::mirrors(&[[f32::NAN; 3], [0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]), []);
}

#[test]
fn shapes_have_the_planes_that_they_were_made_with() {
    let of = |shape| {
        let mesh = point_set(&shape);
        mirrors_of_mesh(&mesh, &Solid::new(&mesh)).first().map(|mirror| mirror.to_string())
    };
    assert_eq!(of(concave::chair()).as_deref(), Some("x = 0.225"));
    assert_eq!(of(concave::horseshoe(6)).as_deref(), Some("x = 0"));
    // Across the longest side.
    assert_eq!(of(concave::pipe(12)).as_deref(), Some("z = 0.75"));
    assert_eq!(of(concave::spiral_stair(9)), None);
}

#[test]
fn symmetric_vertices_may_have_a_surface_that_is_not() {
    let side = |x: f32| [[x, 0.0, 0.0], [2.0 * x, 0.0, 0.5], [2.0 * x, 1.0, 0.0], [x, 1.0, 0.5]];
    let positions = [side(1.0), side(-1.0)].concat();
    let own = [[0, 1, 2], [0, 2, 3]];
    for (other, is_symmetric) in [([[4, 6, 5], [4, 7, 6]], true), ([[5, 4, 7], [5, 7, 6]], false)] {
        let mesh = mesh(positions.clone(), [own, other].concat());
        let found = mirrors_of_mesh(&mesh, &Solid::new(&mesh)).first().copied();
        assert_eq!(found.map(|mirror| mirror.to_string()).as_deref(), is_symmetric.then_some("x = 0"));
    }
}

/// Regression: the reflected centroid lies on the edge of the hole, and counted as on the surface.
#[test]
fn a_box_without_one_triangle_is_not_symmetric() {
    let whole = block([0.0; 3], [1.0, 2.0, 3.0]);
    let planes =
        |mesh: &PointSet| mirrors_of_mesh(mesh, &Solid::by(mesh, crate::fit::SolidRule::Walls)).first().copied();
    assert!(planes(&whole).is_some());
    for missing in 0..whole.triangles.len() {
        let mut open = whole.clone();
        open.triangles.remove(missing);
        assert!(planes(&open).is_none(), "{missing}");
    }
}

#[test]
fn parts_need_images_and_not_only_vertices() {
    let part = |[low, high]: [f32; 2]| corners([low, 0.0, 0.0], [high, 1.0, 0.5]);
    let of = |parts: &[Vec<[f32; 3]>]| {
        let parts: Vec<&[[f32; 3]]> = parts.iter().map(Vec::as_slice).collect();
        mirror_of_parts(&parts).map(|mirror| mirror.to_string())
    };
    assert_eq!(of(&[part([1.0, 2.0]), part([-2.0, -1.0]), part([-1.0, 1.0])]).as_deref(), Some("x = 0"));
    assert_eq!(of(&[part([11.0, 12.0]), part([8.0, 9.0])]).as_deref(), Some("x = 10"));
    assert_eq!(of(&[part([-2.0, 1.0]), part([-1.0, 2.0]), part([-2.0, 2.0])]).as_deref(), Some("x = 0"));
    // The vertices are symmetric about x = 0, and the parts are not.
    assert_ne!(of(&[part([-2.0, 1.0]), part([-2.0, -1.0]), part([-1.0, 2.0])]).as_deref(), Some("x = 0"));
    assert_eq!(of(&[part([-1.0, 1.0])]), None);
}
