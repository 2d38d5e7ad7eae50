//! Known failure modes of MPR, named after what goes wrong in other implementations.

use super::shapes::{Ball, Cuboid, PointCloud};
use crate::any_shape::{Any, contact, distance, intersects};
use ::shapes::rng::SplitMix64;
use glam::{DQuat, DVec3};
use hullmap::{Cache, Contact, Distance, Overlap, Pose, Settings, Shape, Status, SupportMap};
use hullmap_testkit::{packs::tree_pack, random::RandomPoses};
use std::sync::Arc;

fn pose_at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn solve_overlap(a: &Any<'_>, b: &Any<'_>, pose: Pose) -> Overlap {
    intersects(a, b, pose, &mut Cache::new()).status
}

fn solve_contact(a: &Any<'_>, b: &Any<'_>, pose: Pose) -> Contact {
    let c = contact(a, b, pose, &Settings::default(), &mut Cache::new());
    assert!((c.normal.length() - 1.0).abs() < 1e-14, "{c:?}");
    assert!(c.point_a.is_finite() && c.point_b.is_finite(), "{c:?}");
    assert!(0.0 <= c.depth_lower && c.depth_lower <= c.depth && c.depth <= c.depth_upper, "{c:?}");
    c
}

fn solve_distance(a: &Any<'_>, b: &Any<'_>, pose: Pose) -> Distance {
    let d = distance(a, b, pose, &Settings::default(), &mut Cache::new());
    assert!((d.normal.length() - 1.0).abs() < 1e-14, "{d:?}");
    assert!(0.0 <= d.lower && d.lower <= d.distance && d.distance <= d.upper, "{d:?}");
    d
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-5 * expected.abs() + 1e-12, "{found} is not {expected}");
}

/// A cube of edge 2 without an inner ball, so that no early exit skips the phases.
fn cube_without_inner_ball() -> PointCloud {
    PointCloud { inner_radius: 0.0, ..PointCloud::cuboid(DVec3::ONE) }
}

/// Checks all queries of a pair, in both orders, whose distance is `signed`; negative if it is a
/// depth, 0 if the shapes touch. Returns the contact from A to B.
fn check(name: &str, a: &Any<'_>, b: &Any<'_>, pose: Pose, signed: f64) -> Contact {
    let contact = solve_contact(a, b, pose);
    let (depth, distance) = ((-signed).max(0.0), signed.max(0.0));
    let (overlap, of_distance) = match signed {
        0.0 => (Overlap::Touching, Status::Touching),
        _ if signed < 0.0 => (Overlap::Overlapping, Status::Overlapping),
        _ => (Overlap::Separated, Status::Exact),
    };
    for (a, b, pose) in [(a, b, pose), (b, a, pose.inverse())] {
        let (found, c, d) = (solve_overlap(a, b, pose), solve_contact(a, b, pose), solve_distance(a, b, pose));
        assert_eq!((found, c.hit), (overlap, signed <= 0.0), "{name}: {c:?}");
        assert!((c.depth - depth).abs() <= 1e-5 * depth + 1e-12, "{name}: {c:?} is not {depth} deep");
        assert!((d.distance - distance).abs() <= 1e-5 * distance + 1e-12, "{name}: {d:?} is not {distance} apart");
        assert!(d.status == of_distance || signed > 0.0 && d.status == Status::Within, "{name}: {d:?}");
        assert!(signed != 0.0 || c.status == Status::Touching && (c.point_a - c.point_b).length() < 1e-13, "{name}");
    }
    contact
}

#[test]
fn degenerate_pairs_have_their_depth_or_distance() {
    let cube = cube_without_inner_ball();
    let flat = PointCloud::cuboid(DVec3::new(3.0, 0.5, 2.0));
    assert_eq!(check("concentric", &cube, &cube, Pose::IDENTITY, -2.0).status, Status::Exact);
    let c = check("concentric boxes", &cube, &flat, Pose::IDENTITY, -1.5);
    assert!(c.normal.abs().distance(DVec3::Y) < 1e-12);

    let origin = PointCloud::point(DVec3::ZERO);
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)] {
        let name = format!("origin on the line from the centre to the support point in {direction}");
        let at = |t: f64| Pose::from_translation(direction * t).unwrap();
        for t in [-0.9, -0.5, 0.25, 0.75_f64] {
            check(&name, &cube, &origin, at(t), t.abs() - 1.0);
        }
        check(&name, &cube, &origin, at(4.0), direction.length() * 3.0);
    }

    let flat = [
        ("point", PointCloud::point(DVec3::ZERO)),
        ("segment", PointCloud::segment(0.5)),
        ("triangle", PointCloud::polygon(3, 0.5)),
        ("polygon", PointCloud::polygon(64, 0.5)),
        ("five equal points", PointCloud::new(vec![DVec3::ZERO; 5])),
    ];
    for (name, shape) in &flat {
        for z in [-0.5, 0.0, 0.5, 0.75, 3.0_f64] {
            check(&format!("portal without area: {name} at {z}"), &cube, shape, pose_at(0.0, 0.0, z), z.abs() - 1.0);
        }
    }

    // There is no inner ball and the centres coincide, but the Minkowski difference is solid.
    let square = PointCloud::polygon(4, 1.0);
    let upright = Pose::new(DVec3::ZERO, DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)).unwrap();
    check("crossing polygons with one centre", &square, &square, upright, -1.0);

    let cube = Cuboid(DVec3::ONE);
    for (x, y, z) in [(2.0, 0.0, 0.0), (0.0, -2.0, 0.5), (2.0, 2.0, 0.0), (2.0, 2.0, 2.0), (-2.0, 2.0, 0.1)] {
        let c = check(&format!("zero depth gives NaN: {x} {y} {z}"), &cube, &cube, pose_at(x, y, z), 0.0);
        // The normal separates: the support value along it is at most zero.
        let along = c.normal.dot(DVec3::new(x, y, z));
        assert!(along >= 2.0 * (c.normal.x.abs() + c.normal.y.abs() + c.normal.z.abs()) - 1e-13, "{c:?}");
    }
}

/// Without an inner ball no face is the nearest, and the status must say so.
#[test]
fn concentric_balls() {
    for has_inner_ball in [true, false] {
        let ball = Ball { center: DVec3::ZERO, radius: 1.0, has_inner_ball };
        let c = contact(&ball, &ball, Pose::IDENTITY, &Settings::default(), &mut Cache::new());
        assert!(c.hit && c.depth_lower <= 2.0 && 2.0 <= c.depth_upper, "{c:?}");
        assert_eq!(c.status, if has_inner_ball { Status::Exact } else { Status::IterationLimit });
        assert_eq!(solve_overlap(&ball, &ball, Pose::IDENTITY), Overlap::Overlapping);
    }
}

/// B is near a long face of A but far from A's centre, so the centre ray leaves through the wrong
/// face. Without iterations, the bound is valid all the same.
#[test]
fn depth_depends_on_the_centre_ray() {
    let (long, cube) = (PointCloud::cuboid(DVec3::new(20.0, 1.0, 1.0)), cube_without_inner_ball());
    let c = check("a cube at the end of a bar", &long, &cube, pose_at(15.0, 1.5, 0.3), -0.5);
    assert!(c.normal.distance(DVec3::Y) < 1e-12, "{c:?}");
    let none = Settings { max_iterations: 0, ..Settings::default() };
    let paper = contact(&long, &cube, pose_at(15.0, 1.5, 0.3), &none, &mut Cache::new());
    assert!(paper.hit && paper.depth_lower <= 0.5 && paper.depth_upper >= 0.5 - 1e-12, "{paper:?}");
}

#[test]
fn interior_point_on_the_boundary() {
    let cube = cube_without_inner_ball();
    let mut rng = SplitMix64::new(9);
    for corner in cube.points.clone().into_iter().chain([DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::splat(1.5)]) {
        // The last point is outside, which the trait forbids. The answer must be correct
        // nevertheless.
        let skewed = PointCloud::around(cube.points.clone(), corner);
        for _ in 0..50 {
            let pose = rng.pose(3.0);
            let (right, got) = (solve_contact(&cube, &cube, pose), solve_contact(&skewed, &cube, pose));
            assert_eq!(right.hit, got.hit, "{corner} {pose:?}");
            assert_eq!(solve_overlap(&skewed, &cube, pose), solve_overlap(&cube, &cube, pose), "{corner} {pose:?}");
            assert_near(got.depth, right.depth);
        }
    }
}

/// A and B at a scale.
type Pairs<'c> = &'c dyn Fn(f64) -> [Box<Any<'static>>; 2];

#[test]
fn absolute_epsilons_break_at_other_scales() {
    let mut rng = SplitMix64::new(17);
    for _ in 0..200 {
        let clouds = [12, 12].map(|count| PointCloud::random(&mut rng, count, true));
        let given = rng.pose(1.5);
        let of_clouds =
            |scale: f64| clouds.each_ref().map(|cloud| -> Box<Any<'static>> { Box::new(cloud.scaled(scale)) });
        let hull = |cloud: &PointCloud| -> Box<Any<'static>> {
            let points: Vec<[f32; 3]> = cloud.points.iter().map(|p| p.as_vec3().to_array()).collect();
            Box::new(Arc::new(tree_pack(&points)).shared_hull(0).unwrap())
        };
        let of_hulls = |scale: f64| clouds.each_ref().map(|cloud| hull(&cloud.scaled(scale)));
        // Hulls in f32 lose digits if the scale is no power of two.
        let kinds: [(f64, Pairs<'_>); 2] = [(1e-12, &of_clouds), (1e-6, &of_hulls)];
        for (error, bodies) in kinds {
            let [a, b] = bodies(1.0);
            // Normalised twice, as the scaled poses below are.
            let pose = Pose::new(given.translation(), given.rotation()).unwrap();
            let (c, d) = (solve_contact(&*a, &*b, pose), solve_distance(&*a, &*b, pose));
            // Powers of two change no digits, powers of ten change the last ones.
            for scale in [2.0_f64.powi(-20), 2.0_f64.powi(20), 1e-6, 1e-3, 1e3, 1e6] {
                let exact = scale.log2().fract() == 0.0;
                let scaled = Pose::new(given.translation() * scale, given.rotation()).unwrap();
                let [a, b] = bodies(scale);
                let (cs, ds) = (solve_contact(&*a, &*b, scaled), solve_distance(&*a, &*b, scaled));
                let is_clear = exact || c.depth.max(d.distance) > 10.0 * error;
                let overlaps = |d: &Distance| d.status == Status::Overlapping;
                assert!(!is_clear || (c.hit, overlaps(&d)) == (cs.hit, overlaps(&ds)), "{scale} {c:?} {cs:?}");
                if exact {
                    let scaled = [c.point_a * scale, c.point_b * scale];
                    assert_eq!(
                        (c.status, c.iterations, c.depth * scale, c.normal, scaled),
                        (cs.status, cs.iterations, cs.depth, cs.normal, [cs.point_a, cs.point_b])
                    );
                    let scaled = [d.point_a * scale, d.point_b * scale];
                    assert_eq!(
                        (d.status, d.iterations, d.distance * scale, d.normal, scaled),
                        (ds.status, ds.iterations, ds.distance, ds.normal, [ds.point_a, ds.point_b])
                    );
                }
                let converged = |status| matches!(status, Status::Exact | Status::Within);
                assert!(!is_clear || converged(c.status) == converged(cs.status), "{scale} {c:?} {cs:?}");
                assert!((cs.depth / scale - c.depth).abs() <= 1e-5 * c.depth + error, "{scale} {c:?} {cs:?}");
                assert!((ds.distance / scale - d.distance).abs() <= 2e-5 * d.distance + error, "{scale} {d:?} {ds:?}");
            }
        }
    }
}

#[test]
fn hit_and_miss_flicker_at_contact() {
    // Within rounding error of touching the answer is always "touching", with a warm and with a
    // cold cache.
    let cube = Cuboid(DVec3::ONE);
    let mut warm = Cache::new();
    for i in -40..=40 {
        let gap = f64::from(i) * f64::EPSILON;
        let pose = pose_at(2.0 + gap, 0.25, -0.5);
        let (cold, kept) = (solve_overlap(&cube, &cube, pose), intersects(&cube, &cube, pose, &mut warm));
        assert_eq!([cold, kept.status], [Overlap::Touching; 2], "{i}");
        let d = solve_distance(&cube, &cube, pose);
        assert!(d.lower == 0.0 && d.upper >= gap && d.upper < 1e-13, "{i}: {d:?}");
    }
    for (gap, expected) in [(1e-12, Overlap::Separated), (-1e-12, Overlap::Overlapping)] {
        for _ in 0..3 {
            assert_eq!(intersects(&cube, &cube, pose_at(2.0 + gap, 0.25, -0.5), &mut warm).status, expected);
        }
    }
}

#[test]
fn nan_support_points_do_not_loop_for_ever() {
    struct Broken;
    impl SupportMap for Broken {
        fn support_point(&self, _: DVec3) -> hullmap::SupportPoint {
            hullmap::SupportPoint { point: DVec3::NAN, feature: 0 }
        }
        fn interior_point(&self) -> DVec3 {
            DVec3::NAN
        }
        fn inner_radius(&self) -> f64 {
            f64::NAN
        }
        fn outer_radius(&self) -> f64 {
            f64::NAN
        }
    }
    impl Shape for Broken {}
    let cube = Cuboid(DVec3::ONE);
    let cache = &mut Cache::new();
    // Without a proof no pair is reported as separated.
    assert!(intersects(&Broken, &cube, Pose::IDENTITY, cache).is_hit());
    assert!(contact(&cube, &Broken, Pose::IDENTITY, &Settings::default(), cache).hit);
    let d = distance(&Broken, &cube, Pose::IDENTITY, &Settings::default(), cache);
    assert!(!matches!(d.status, Status::Exact | Status::Within), "{d:?}");
    // The cache that the broken shape left does no harm to a valid pair.
    assert_eq!(intersects(&cube, &cube, pose_at(3.0, 0.0, 0.0), cache).status, Overlap::Separated);
}

#[test]
fn inexact_support_breaks_termination() {
    // It selects its points by f32 dot products: off by up to 1e-7 of the size, and not even
    // monotone.
    let single = |cloud: &PointCloud| PointCloud { is_single: true, ..cloud.clone() };
    let mut rng = SplitMix64::new(31);
    for _ in 0..300 {
        let (a, b) = (PointCloud::random(&mut rng, 2000, true), PointCloud::random(&mut rng, 500, true));
        let pose = rng.pose(1.6);
        let settings = Settings { tolerance: 0.0, ..Settings::default() };
        let (exact, c) = (
            contact(&a, &b, pose, &settings, &mut Cache::new()),
            contact(&single(&a), &single(&b), pose, &settings, &mut Cache::new()),
        );
        assert!(c.iterations < 500, "{c:?}");
        if exact.depth > 1e-6 {
            assert!(
                c.hit && c.depth_lower <= exact.depth_upper + 1e-6 && exact.depth_lower <= c.depth_upper + 1e-6,
                "{c:?} {exact:?}"
            );
        }
        let d = distance(&single(&a), &single(&b), pose, &settings, &mut Cache::new());
        assert!(d.iterations < 500, "{d:?}");
    }
}

/// The witness points coincide, so their difference has no direction. The normal was a diagonal
/// once.
#[test]
fn touching_shapes_have_a_normal_that_separates() {
    let cube = PointCloud::cuboid(DVec3::ONE);
    let octahedron = PointCloud::new([DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect());
    for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        let pose = Pose::from_translation(axis * 2.0).unwrap();
        let d = distance(&cube, &octahedron, pose, &Settings::default(), &mut Cache::new());
        assert_eq!((d.status, d.distance), (Status::Touching, 0.0));
        assert!((d.normal - axis).length() < 1e-9, "{axis}: {}", d.normal);
    }
}

/// A polygon beside a slab whose top is in the plane of the polygon. No face proves them separated
/// or touching; the closest points do.
#[test]
fn origin_in_the_plane_of_a_face_but_beside_it() {
    let polygon = PointCloud::polygon(24, 1.0);
    for thick in [1e-3, 1e-5, 1e-7] {
        let slab = PointCloud::cuboid(DVec3::new(0.7, 0.5, thick));
        for gap in [1e-2, 1e-4, 1e-6] {
            for turn in [0.0, 0.3, 1.0] {
                let rotation = DQuat::from_rotation_z(turn);
                let reach = (rotation.inverse() * DVec3::X).abs().dot(DVec3::new(0.7, 0.5, 0.0));
                let pose = Pose::new(DVec3::new(1.0 + reach + gap, 0.0, -thick), rotation).unwrap();
                let name = format!("{thick} {gap} {turn}");
                check(&name, &polygon, &slab, pose, solve_distance(&polygon, &slab, pose).distance);
                assert!(solve_distance(&polygon, &slab, pose).lower > 0.99 * gap, "{name}");
            }
        }
    }
}

#[test]
fn degenerate_simplex_has_a_finite_depth() {
    // Segments that cross at all angles down to zero, far from the origins of their frames.
    let away = DVec3::new(50.0, -35.0, 20.0);
    let mut rng = SplitMix64::new(23);
    for round in 0..3000 {
        let along = rng.unit_vector();
        let angle = [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15][round % 7];
        let other = (along + rng.unit_vector() * angle).normalize();
        let segment = |dir: DVec3| PointCloud::new(vec![away + dir * 1.1, away - dir]);
        let (a, b) = (segment(along), segment(other));
        let shift = rng.unit_vector() * [0.0, 1e-15, 1e-14, 1e-13][round % 4];
        let pose = Pose::from_translation(shift).unwrap();
        for c in [solve_contact(&a, &b, pose), solve_contact(&b, &a, pose.inverse())] {
            assert!(c.depth.is_finite() && c.depth_upper < 3.0, "{c:?}");
        }
    }
}

#[test]
fn witness_points_if_all_faces_are_equally_near() {
    // A ball at the centre of a cylinder: the depth is known at once, but no face that attains it.
    for (half, radius, ball) in [(700.0, 500.0, 500.0), (0.7, 0.5, 0.8), (3.0, 0.5, 0.01)] {
        let cylinder = hullmap::shapes::Cylinder::new(half, radius).unwrap();
        let ball = hullmap::shapes::Sphere::new(ball).unwrap();
        let c = solve_contact(&cylinder, &ball, Pose::IDENTITY);
        assert_near(c.depth, radius + ball.radius());
        let width = c.depth_upper - c.depth_lower + 1e-12 * c.depth;
        assert!((c.point_a - c.point_b).distance(c.normal * c.depth) <= width, "{c:?}");
        assert!((DVec3::new(c.point_a.x, c.point_a.y, 0.0).length() - radius).abs() <= width, "{c:?}");
    }
}

#[test]
fn depth_is_exact_if_the_cores_nearly_touch() {
    let (ball, needle) =
        (hullmap::shapes::Sphere::new(0.0008).unwrap(), hullmap::shapes::Capsule::new(0.0007, 0.0).unwrap());
    let mut rng = SplitMix64::new(29);
    for _ in 0..2000 {
        // The segment passes the centre of the ball at a distance of 1e-6 to 1e-16.
        let rotation = rng.rotation();
        let side = (rotation * DVec3::Z).cross(rng.unit_vector()).normalize();
        let gap = 10.0_f64.powf(-rng.between(6.0, 16.0));
        let pose = Pose::new(side * gap, rotation).unwrap();
        let truth = 0.0008 - gap;
        for c in [solve_contact(&ball, &needle, pose), solve_contact(&needle, &ball, pose.inverse())] {
            assert!(c.depth_lower <= truth + 1e-17 && truth - 1e-17 <= c.depth_upper, "{gap:e}: {c:?}");
        }
    }
}

/// Two needles with a gap of 5e-11, and a simplex that seems to contain the origin: they were
/// called touching, although a gap of more than 16 rounding errors is certain.
#[test]
fn needles_that_touch_are_near_each_other() {
    // Its support points may fall short, as the index of a hull allows.
    let inexact = |points: Vec<DVec3>| {
        let cloud = PointCloud::new(points);
        PointCloud { support_error: 1e-12 * cloud.outer_radius, ..cloud }
    };
    let cloud = |points: &[[f64; 3]]| inexact(points.iter().copied().map(DVec3::from_array).collect());
    let a = cloud(&[
        [0.0; 3],
        [0.42150118691562743, -0.5987844699855672, -0.190698584417925],
        [0.3467096970560752, -0.4925356968736784, -0.15686088008374227],
        [0.5533931512198489, -0.7861501556085015, -0.25037008944462025],
    ]);
    let b = cloud(&[
        [-0.350019098094252, -0.011126903022359552, 0.4162918352109328],
        [-1.195781120445675, -0.5308047861251204, 0.5372112272118209],
        [0.12227494374161561, 0.27907383783247885, 0.3487675149723272],
        [0.18329803029522027, 0.31656943633397544, 0.34004298399286853],
        [-1.0413831927233717, -0.43593508732569963, 0.5151368113348014],
    ]);
    let rotation = DQuat::from_xyzw(0.3160446296770141, -0.11814838160315674, 0.12606112743492592, 0.9328801338471675);
    let shift = DVec3::new(0.437918838686537, 0.37285973291284763, -0.17304555544357192);
    let pose = Pose::new(shift, rotation).unwrap();
    // 64 rounding errors, without the noise.
    let most = 64.0 * (a.support_error() + b.support_error());
    let gap = 4.834703997844405e-11;
    let found = solve_distance(&a, &b, pose);
    assert!(found.lower <= gap && gap <= found.upper, "{found:?}");
    assert!(found.status != Status::Touching && gap > 16.0 * most / 64.0, "{found:?}");
    // In general, for needles of all widths that touch each other in a plane.
    let mut rng = SplitMix64::new(63);
    let (mut touching, mut worst) = (0, 0.0_f64);
    for _ in 0..20_000 {
        let [thin, gap] = [rng.between(-14.0, -7.0), rng.between(-13.0, -9.0)].map(|power| 10.0_f64.powf(power));
        let mut side = |up: f64| {
            let (sine, cosine) = rng.between(0.0, std::f64::consts::TAU).sin_cos();
            let (u, v) = (DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0));
            let share = rng.between(0.05, 0.95);
            let mut points = vec![u * share, u * (share - 1.0) + v * thin, u * (share - 1.0) - v * thin];
            points.extend((0..3).map(|_| {
                let height = DVec3::Z * up * rng.between(0.01, 1.0) * thin;
                u * rng.between(-1.0, 1.0) + v * (rng.between(-1.0, 1.0) * thin) + height
            }));
            inexact(points)
        };
        let (a, b) = (side(-1.0), side(1.0));
        let pose = pose_at(0.0, 0.0, gap);
        let radii = a.outer_radius() + b.outer_radius();
        let is_touching = [
            solve_distance(&a, &b, pose).status == Status::Touching,
            solve_contact(&a, &b, pose).status == Status::Touching,
            solve_overlap(&a, &b, pose) == Overlap::Touching,
        ];
        if is_touching.contains(&true) {
            touching += 1;
            worst = worst.max(gap / radii);
        }
    }
    println!("{touching} touch, with gaps of at most {worst:e} of the radii");
    assert!((2_000..18_000).contains(&touching) && worst <= 1e-10, "{touching} {worst:e}");
}
