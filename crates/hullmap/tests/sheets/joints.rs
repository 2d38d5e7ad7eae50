//! Rays at the joints of triangles and of parts, with the floor behind: the nearest surface
//! answers, certainly. `hullmap_tests::sheets::joints` has random ones.

use glam::DVec3;
use hullmap::compound::OneSided;
use hullmap::height_field::{Diagonal, Layout};
use hullmap::shapes::Sphere;
use hullmap::{Cache, CastSettings, Compound, Motion, Pack, Pose, Ray, Status, TriangleMesh};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, point_set};

use crate::height_field::field;
use crate::meshes::mesh;

/// A roof whose ridge is along y at z = 1, above a floor at z = 0.
fn roof() -> TriangleMesh {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let ridge = [at(0.0, -5.0, 1.0), at(0.0, 5.0, 1.0)];
    let eaves = [at(5.0, -5.0, 0.5), at(5.0, 5.0, 0.5), at(-5.0, -5.0, 0.5), at(-5.0, 5.0, 0.5)];
    let floor = [at(-9.0, -9.0, 0.0), at(9.0, -9.0, 0.0), at(9.0, 9.0, 0.0), at(-9.0, 9.0, 0.0)];
    let corners = [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [6, 7, 8], [6, 8, 9]];
    mesh(&[&ridge[..], &eaves, &floor].concat(), &corners)
}

/// Two boxes with the common face x = 0, from z = −1 to 1, above a floor with its top at z = −2.
fn boxes() -> Pack {
    let part = |low: [f32; 3], high: [f32; 3]| {
        let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
        point_set("part", &(0..8).map(corner).collect::<Vec<_>>())
    };
    let sets = [
        part([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0]),
        part([0.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
        part([-9.0, -9.0, -3.0], [9.0, 9.0, -2.0]),
    ];
    Pack::from_bytes(&bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()).unwrap()
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray::new(DVec3::from(origin), DVec3::from(direction)).unwrap()
}

const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

#[test]
fn rays_at_a_ridge_hit_the_roof() {
    let (roof, settings) = (roof(), CastSettings::default());
    for (origin, direction) in [
        ([0.0, 0.3, 5.0], DOWN),
        ([-0.4, 0.1, 5.0], [0.1, 0.05, -1.0]),
        ([0.0, 5.0, 5.0], DOWN),
        ([0.0, 0.0, 5.0], DOWN),
        ([0.0, 1.0 / 3.0, 5.0], [0.0, 1e-17, -1.0]),
    ] {
        let line = ray(origin, direction);
        let answers = [hullmap::ray(&roof, &line, &settings), hullmap::ray(&OneSided::new(&roof), &line, &settings)];
        for found in answers.map(|found| found) {
            assert_eq!((found.hit, found.status, found.t), (true, Status::Exact, 4.0), "{line:?}: {found:?}");
            assert!(found.point.z == 1.0 && found.normal.z > 0.9, "{line:?}: {found:?}");
        }
        let dot = (Sphere::new(0.0).unwrap(), Pose::from_translation(line.origin()).unwrap());
        let motion = Motion::new(line.direction()).unwrap();
        let cast = hullmap::cast(&roof, &dot.0, dot.1, motion, &settings, &mut Cache::new());
        assert!(cast.hit && (cast.t - 4.0).abs() < 1e-12 && cast.t_upper < 4.001, "{line:?}: {cast:?}");
    }
    // From below, the fronts of the roof face away. A ray in the plane of a triangle meets none.
    let up = ray([0.0, 0.3, 0.5], [0.0, 0.0, 1.0]);
    assert_eq!(hullmap::ray(&roof, &up, &settings).t, 0.5);
    assert!(!hullmap::ray(&OneSided::new(&roof), &up, &settings).hit);
    let along = ray([-20.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!(hullmap::ray(&roof, &along, &settings).t, 11.0);
    assert!(!hullmap::ray(&OneSided::new(&roof), &along, &settings).hit);
}

#[test]
fn both_ends_of_a_ray_belong_to_it() {
    let roof = roof();
    for (z, max_t, hit, t) in [
        (5.0, 4.0, true, 4.0),
        (5.0, 4.0_f64.next_down(), false, f64::INFINITY),
        (1.0, 0.0, true, 0.0),
        (1.0, f64::INFINITY, true, 0.0),
        (1.0_f64.next_down(), f64::INFINITY, true, 1.0_f64.next_down()),
    ] {
        let settings = CastSettings { max_t, ..CastSettings::default() };
        let found = hullmap::ray(&roof, &ray([0.0, 0.3, z], DOWN), &settings);
        assert_eq!(found.hit, hit, "from {z} to {max_t}: {found:?}");
        assert!(found.t == t || (found.t - t).abs() < 1e-15, "from {z} to {max_t}: {found:?}");
    }
    // Without a direction, the ray is a point.
    let at = |z: f64| hullmap::ray(&roof, &ray([0.0, 0.3, z], [0.0; 3]), &CastSettings::default());
    assert!(at(1.0).hit && at(1.0).t == 0.0 && !at(1.0_f64.next_up()).hit);
}

#[test]
fn rays_at_edges_of_a_terrain_hit_it() {
    let layout = Layout { columns: 5, rows: 4, origin: [0.1, 0.3], spacing: [0.7, 0.9], diagonal: Diagonal::Rising };
    let heights: Vec<f32> = (0..20).map(|i| (i * 7 % 5) as f32 * 0.1).collect();
    let terrain = field(layout, &heights, &[]);
    for (i, height) in heights.iter().enumerate() {
        let (x, y) = (layout.x(i % 5), layout.y(i / 5));
        let found = hullmap::ray(&terrain, &ray([x, y, 5.0], DOWN), &CastSettings::default());
        assert!(found.hit && found.status == Status::Exact, "{i}: {found:?}");
        assert!((found.t - (5.0 - f64::from(*height))).abs() < 1e-15 * 10.0, "{i}: {found:?}");
        let between = ray([x, 0.5 * (layout.y(0) + layout.y(3)), 5.0], DOWN);
        assert_eq!(hullmap::ray(&terrain, &between, &CastSettings::default()).status, Status::Exact);
    }
}

#[test]
fn rays_in_the_common_face_of_two_boxes_hit_them() {
    let (pack, settings) = (boxes(), CastSettings::default());
    let boxes = Compound::new(&pack);
    for (origin, direction, t) in [
        ([0.0, 0.2, 5.0], DOWN, 4.0),
        // In a side of both boxes, and along an edge.
        ([0.0, 1.0, 5.0], DOWN, 4.0),
        ([0.5, -1.0, 5.0], DOWN, 4.0),
        ([1.0, 1.0, 5.0], DOWN, 4.0),
        // From the seam itself, and from its border.
        ([0.0, 0.2, 0.5], DOWN, 0.0),
        ([0.0, 0.2, 1.0], DOWN, 0.0),
        ([0.0, 0.2, -1.0], DOWN, 0.0),
        ([0.0, 0.2, -1.0_f64.next_up()], DOWN, 1.0),
        ([0.0, 3.0, 5.0], [0.0, -0.5, -1.0], 4.0),
        ([1.0_f64.next_up(), 0.2, 5.0], DOWN, 7.0),
    ] {
        let line = ray(origin, direction);
        let found = hullmap::ray(&boxes, &line, &settings);
        assert!(found.hit && (found.t - t).abs() < 1e-12, "{line:?}: {found:?}, expected {t}");
        assert!(
            found.t_lower <= t && t <= found.t_upper && found.t_upper - found.t_lower < 1e-9,
            "{line:?}: {found:?}"
        );
        assert!(matches!(found.status, Status::Exact | Status::Within | Status::Overlapping), "{line:?}: {found:?}");
        let (dot, start) = (Sphere::new(0.0).unwrap(), Pose::from_translation(line.origin()).unwrap());
        let motion = Motion::new(line.direction()).unwrap();
        let cast = hullmap::cast(&boxes, &dot, start, motion, &settings, &mut Cache::new());
        assert!(cast.hit && (cast.t - t).abs() < 1e-12, "{line:?}: {cast:?}, expected {t}");
    }
}

#[test]
fn a_ball_that_grazes_a_part_meets_it_before_the_part_behind() {
    let pack = boxes();
    // It slides down along the boxes, at a distance of its radius, and lands on the floor.
    let (ball, start) = (Sphere::new(0.5).unwrap(), Pose::from_translation(DVec3::new(1.5, 0.0, 5.0)).unwrap());
    let (down, settings) = (Motion::new(DVec3::from(DOWN)).unwrap(), CastSettings::default());
    let found = hullmap::cast(&Compound::new(&pack), &ball, start, down, &settings, &mut Cache::new());
    assert!(found.hit && found.status == Status::Stalled, "{found:?}");
    assert!((found.t - 4.0).abs() < 0.5 && found.t_upper > 6.4, "{found:?}");
}
