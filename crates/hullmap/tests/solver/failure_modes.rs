//! The known failure modes of portal refinement, one test each, named after what goes wrong elsewhere.

use crate::shapes::{Ball, Cuboid, PointCloud, Rng};
use glam::{DQuat, DVec3};
use hullmap::{Cache, Contact, Distance, Overlap, Pose, Settings, Status, SupportMap, contact, distance, intersects};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn hit<A: SupportMap, B: SupportMap>(a: &A, b: &B, pose: Pose) -> Overlap {
    intersects(a, b, pose, &mut Cache::new()).status
}

fn deep<A: SupportMap, B: SupportMap>(a: &A, b: &B, pose: Pose) -> Contact {
    let c = contact(a, b, pose, &Settings::default(), &mut Cache::new());
    assert!((c.normal.length() - 1.0).abs() < 1e-14, "{c:?}");
    assert!(c.point_a.is_finite() && c.point_b.is_finite(), "{c:?}");
    assert!(0.0 <= c.depth_lower && c.depth_lower <= c.depth && c.depth <= c.depth_upper, "{c:?}");
    c
}

fn far<A: SupportMap, B: SupportMap>(a: &A, b: &B, pose: Pose) -> Distance {
    let d = distance(a, b, pose, &Settings::default(), &mut Cache::new());
    assert!((d.normal.length() - 1.0).abs() < 1e-14, "{d:?}");
    assert!(0.0 <= d.lower && d.lower <= d.distance && d.distance <= d.upper, "{d:?}");
    d
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-5 * expected.abs() + 1e-12, "{found} is not {expected}");
}

/// A cube of edge 2 that keeps its inner ball to itself, so that no early exit hides the phases.
fn shy_cube() -> PointCloud {
    PointCloud { inner_radius: 0.0, ..PointCloud::cuboid(DVec3::ONE) }
}

#[test]
fn concentric() {
    let (cube, flat) = (shy_cube(), PointCloud::cuboid(DVec3::new(3.0, 0.5, 2.0)));
    assert_eq!(hit(&cube, &cube, Pose::IDENTITY), Overlap::Overlapping);
    let c = deep(&cube, &cube, Pose::IDENTITY);
    assert_near(c.depth, 2.0);
    assert_eq!(c.status, Status::Exact);
    let c = deep(&cube, &flat, Pose::IDENTITY);
    assert_near(c.depth, 1.5);
    assert!(c.normal.abs().distance(DVec3::Y) < 1e-12);
    assert_eq!(far(&cube, &flat, Pose::IDENTITY).status, Status::Overlapping);
    for frank in [true, false] {
        let ball = Ball { center: DVec3::ZERO, radius: 1.0, frank };
        let c = contact(&ball, &ball, Pose::IDENTITY, &Settings::default(), &mut Cache::new());
        assert!(c.hit && c.depth_lower <= 2.0 && 2.0 <= c.depth_upper, "{c:?}");
        // A ball that hides its inner radius has no nearest face: the interval must say so.
        assert_eq!(c.status, if frank { Status::Exact } else { Status::IterationLimit });
        assert_eq!(hit(&ball, &ball, Pose::IDENTITY), Overlap::Overlapping);
    }
}

#[test]
fn origin_on_the_line_from_centre_to_support() {
    let cube = shy_cube();
    let point = PointCloud::point(DVec3::ZERO);
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)] {
        for t in [-0.9, -0.5, 0.25, 0.75] {
            let p = direction * t;
            let pose = Pose::from_translation(p).unwrap();
            assert_eq!(hit(&cube, &point, pose), Overlap::Overlapping, "{p}");
            let c = deep(&cube, &point, pose);
            assert_near(c.depth, 1.0 - p.abs().max_element());
            // The segment's whole line of centres.
            let d = far(&cube, &point, Pose::from_translation(direction * 4.0).unwrap());
            assert_near(d.distance, direction.length() * 3.0);
        }
    }
}

#[test]
fn depth_depends_on_the_centre_ray() {
    // A long box, the other near its middle face but far along it: the centre ray leaves through the wrong face.
    let long = PointCloud::cuboid(DVec3::new(20.0, 1.0, 1.0));
    let c = deep(&long, &shy_cube(), at(15.0, 1.5, 0.3));
    assert_near(c.depth, 0.5);
    assert!(c.normal.distance(DVec3::Y) < 1e-12, "{c:?}");
}

#[test]
fn origin_projects_outside_the_portal() {
    // Contact points stay in both shapes, within the interval, wherever the centre ray goes.
    let mut rng = Rng(77);
    let (a, b) = (Cuboid(DVec3::new(5.0, 1.0, 0.5)), Cuboid(DVec3::new(0.5, 2.0, 0.25)));
    let mut hits = 0;
    for _ in 0..500 {
        let pose = rng.pose(4.0);
        let c = deep(&a, &b, pose);
        if c.hit {
            hits += 1;
            let inside = |half: DVec3, p: DVec3| (p.abs() - half).max_element();
            assert!(inside(a.0, c.point_a) < 1e-12, "{c:?}");
            assert!(inside(b.0, pose.inverse().transform_point(c.point_b)) < 1e-12, "{c:?}");
            assert!((c.point_a - c.point_b - c.normal * c.depth).length() < 1e-4, "{c:?}");
        }
    }
    assert!((150..350).contains(&hits), "{hits}");
}

#[test]
fn portal_without_area() {
    let solid = shy_cube();
    let flat = [
        PointCloud::point(DVec3::ZERO),
        PointCloud::segment(0.5),
        PointCloud::polygon(3, 0.5),
        PointCloud::polygon(64, 0.5),
        PointCloud::new(vec![DVec3::ZERO; 5]),
    ];
    for shape in &flat {
        for z in [-0.5, 0.0, 0.5] {
            assert_eq!(hit(&solid, shape, at(0.0, 0.0, z)), Overlap::Overlapping);
            assert_eq!(hit(shape, &solid, at(0.0, 0.0, z)), Overlap::Overlapping);
            let (c, swapped) = (deep(&solid, shape, at(0.0, 0.0, z)), deep(shape, &solid, at(0.0, 0.0, -z)));
            assert!(c.hit && swapped.hit);
            assert_near(c.depth, swapped.depth);
        }
        assert_near(deep(&solid, shape, at(0.0, 0.0, 0.75)).depth, 0.25);
        assert_near(far(&solid, shape, at(0.0, 0.0, 3.0)).distance, 2.0);
    }
}

#[test]
fn flat_against_flat() {
    let polygon = PointCloud::polygon(6, 1.0);
    let segment = PointCloud::segment(1.0);
    let point = PointCloud::point(DVec3::ZERO);
    let mut rng = Rng(5);
    for (a, b) in [
        (&polygon, &polygon),
        (&polygon, &segment),
        (&segment, &polygon),
        (&segment, &segment),
        (&polygon, &point),
        (&point, &segment),
        (&point, &point),
    ] {
        // One frame for both, turned at random: coplanar, but no more along the axes.
        for _ in 0..20 {
            let frame = Pose::new(rng.direction(), rng.rotation()).unwrap();
            let placed = |s: &PointCloud| PointCloud::around(s.placed(frame), frame.transform_point(s.interior));
            let (a, b) = (placed(a), placed(b));
            let along = |v: DVec3| Pose::from_translation(frame.transform_vector(v)).unwrap();

            assert_eq!(hit(&a, &b, Pose::IDENTITY), Overlap::Touching, "{a:?} {b:?}");
            let c = deep(&a, &b, Pose::IDENTITY);
            assert!(c.hit && c.status == Status::Touching && c.depth == 0.0 && c.depth_upper < 1e-13, "{c:?}");
            assert!((c.point_a - c.point_b).length() < 1e-13, "{c:?}");
            let d = far(&a, &b, Pose::IDENTITY);
            assert!(d.status == Status::Touching && d.distance == 0.0, "{d:?}");

            // Beside it in the plane, and above it.
            for (by, expected) in [(DVec3::X * 5.0, None), (DVec3::Z * 1e-3, Some(1e-3)), (DVec3::Z * -2.0, Some(2.0))]
            {
                assert_eq!(hit(&a, &b, along(by)), Overlap::Separated, "{a:?} {b:?} {by}");
                assert!(!deep(&a, &b, along(by)).hit);
                let d = far(&a, &b, along(by));
                assert!(matches!(d.status, Status::Exact | Status::Within), "{d:?}");
                assert_near(
                    d.distance,
                    expected.unwrap_or_else(|| {
                        let reach = |s: &PointCloud| s.outer_radius;
                        5.0 - reach(&a) - reach(&b)
                    }),
                );
            }
        }
    }
}

#[test]
fn crossing_polygons_with_one_centre() {
    // No inner ball, centres coincide, and yet the difference is solid.
    let polygon = PointCloud::polygon(4, 1.0);
    let upright = Pose::new(DVec3::ZERO, DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)).unwrap();
    assert_eq!(hit(&polygon, &polygon, upright), Overlap::Overlapping);
    let c = deep(&polygon, &polygon, upright);
    assert!(c.hit && c.depth > 0.5, "{c:?}");
    assert_eq!(far(&polygon, &polygon, upright).status, Status::Overlapping);
}

#[test]
fn interior_point_on_the_boundary() {
    let cube = shy_cube();
    let mut rng = Rng(9);
    for corner in cube.points.clone().into_iter().chain([DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::splat(1.5)]) {
        // The last one is even outside, which the trait forbids: the answer must still be right.
        let skewed = PointCloud::around(cube.points.clone(), corner);
        for _ in 0..50 {
            let pose = rng.pose(3.0);
            let (right, got) = (deep(&cube, &cube, pose), deep(&skewed, &cube, pose));
            assert_eq!(right.hit, got.hit, "{corner} {pose:?}");
            assert_eq!(hit(&skewed, &cube, pose), hit(&cube, &cube, pose), "{corner} {pose:?}");
            assert_near(got.depth, right.depth);
        }
    }
}

#[test]
fn endless_discovery() {
    // Needles, discs and shapes with many points in line or in plane, at all angles: caps hold and statuses are sound.
    let mut rng = Rng(11);
    let shapes = [
        PointCloud::cuboid(DVec3::new(1.0, 1e-6, 1e-6)),
        PointCloud::cuboid(DVec3::new(1.0, 1.0, 1e-7)),
        PointCloud::polygon(100, 1.0),
        PointCloud::new((0..50).map(|i| DVec3::X * (f64::from(i) / 25.0 - 1.0)).collect()),
        shy_cube(),
    ];
    for a in &shapes {
        for b in &shapes {
            for _ in 0..40 {
                let pose = rng.pose(1.5);
                let i = intersects(a, b, pose, &mut Cache::new());
                assert_ne!(i.status, Overlap::Undecided, "{a:?} {b:?} {pose:?}");
                assert!(i.iterations < 100, "{i:?}");
                let c = deep(a, b, pose);
                assert!(
                    c.status != Status::IterationLimit && c.status != Status::Stalled,
                    "{c:?} {a:?} {b:?} {pose:?}"
                );
                assert_eq!(c.hit, i.is_hit(), "{c:?} {i:?} {a:?} {b:?} {pose:?}");
                let d = far(a, b, pose);
                assert!(
                    d.status != Status::IterationLimit && d.status != Status::Stalled,
                    "{d:?} {a:?} {b:?} {pose:?}"
                );
                assert_eq!(d.distance == 0.0, i.is_hit(), "{d:?} {i:?}");
            }
        }
    }
}

#[test]
fn zero_depth_gives_nan() {
    let cube = Cuboid(DVec3::ONE);
    for pose in [at(2.0, 0.0, 0.0), at(0.0, -2.0, 0.5), at(2.0, 2.0, 0.0), at(2.0, 2.0, 2.0), at(-2.0, 2.0, 0.1)] {
        assert_eq!(hit(&cube, &cube, pose), Overlap::Touching);
        let c = deep(&cube, &cube, pose);
        assert!(c.hit && c.status == Status::Touching && c.depth == 0.0, "{c:?}");
        // The normal keeps them apart: no support value along it is above zero.
        let t = pose.translation();
        assert!(c.normal.dot(t) >= 2.0 * (c.normal.x.abs() + c.normal.y.abs() + c.normal.z.abs()) - 1e-13, "{c:?}");
        assert!((c.point_a - c.point_b).length() < 1e-13, "{c:?}");
        let d = far(&cube, &cube, pose);
        assert_eq!((d.status, d.distance), (Status::Touching, 0.0));
    }
}

#[test]
fn ties_on_flat_faces() {
    // Parallel faces: every support along them is a tie of four points with four.
    let cube = shy_cube();
    for (x, y) in [(0.0, 0.0), (0.5, 0.25), (1.0, 1.0), (1.5, -1.5)] {
        let c = deep(&cube, &cube, at(x, y, 1.75));
        assert_near(c.depth, 0.25);
        assert!(c.normal.distance(DVec3::Z) < 1e-12, "{c:?}");
        assert!((c.point_a - c.point_b - DVec3::Z * 0.25).length() < 1e-12, "{c:?}");
        let d = far(&cube, &cube, at(x, y, 2.25));
        assert_near(d.distance, 0.25);
        assert!(d.normal.distance(DVec3::Z) < 1e-12);
    }
}

#[test]
fn swapping_a_and_b_changes_the_depth() {
    let mut rng = Rng(13);
    for _ in 0..300 {
        let (a, b) = (PointCloud::random(&mut rng, 20, true), PointCloud::random(&mut rng, 9, false));
        let pose = rng.pose(1.5);
        let (there, back) = (deep(&a, &b, pose), deep(&b, &a, pose.inverse()));
        assert_eq!(there.hit, back.hit);
        assert_near(there.depth, back.depth);
        let (there, back) = (far(&a, &b, pose), far(&b, &a, pose.inverse()));
        assert!((there.distance - back.distance).abs() < 2e-5 * there.distance + 1e-12, "{there:?} {back:?}");
        if there.distance > 1e-3 {
            assert!((there.normal + pose.transform_vector(back.normal)).length() < 1e-2, "{there:?} {back:?}");
        }
    }
}

#[test]
fn absolute_epsilons_break_at_other_scales() {
    let mut rng = Rng(17);
    for _ in 0..200 {
        let (a, b) = (PointCloud::random(&mut rng, 12, true), PointCloud::random(&mut rng, 12, true));
        let given = rng.pose(1.5);
        // Normalised once more, as those below are.
        let pose = Pose::new(given.translation(), given.rotation()).unwrap();
        let (c, d) = (deep(&a, &b, pose), far(&a, &b, pose));
        // Powers of two change no digit; powers of ten change the last ones.
        for scale in [2.0_f64.powi(-20), 2.0_f64.powi(20), 1e-6, 1e-3, 1e3, 1e6] {
            let exact = scale.log2().fract() == 0.0;
            let scaled = Pose::new(given.translation() * scale, given.rotation()).unwrap();
            let (a, b) = (a.scaled(scale), b.scaled(scale));
            let (cs, ds) = (deep(&a, &b, scaled), far(&a, &b, scaled));
            assert_eq!((c.hit, d.status == Status::Overlapping), (cs.hit, ds.status == Status::Overlapping));
            if exact {
                assert_eq!(
                    (c.status, c.iterations, c.depth * scale, c.normal),
                    (cs.status, cs.iterations, cs.depth, cs.normal)
                );
                assert_eq!(
                    (d.status, d.iterations, d.distance * scale, d.normal),
                    (ds.status, ds.iterations, ds.distance, ds.normal)
                );
            }
            assert!((cs.depth / scale - c.depth).abs() <= 1e-5 * c.depth + 1e-12, "{scale} {c:?} {cs:?}");
            assert!((ds.distance / scale - d.distance).abs() <= 2e-5 * d.distance + 1e-12, "{scale} {d:?} {ds:?}");
        }
    }
}

#[test]
fn far_from_the_origin() {
    // Both shapes sit 1e6 diameters from their frames' origins; powers of two, so that the move itself is exact.
    let away = DVec3::new(1_048_576.0, -2_097_152.0, 524_288.0);
    let mut rng = Rng(19);
    let snap = |cloud: &PointCloud| {
        let points = cloud.points.iter().map(|p| (*p * 1024.0).round() / 1024.0).collect();
        PointCloud::around(points, DVec3::ZERO)
    };
    for _ in 0..200 {
        let (a, b) = (snap(&PointCloud::random(&mut rng, 12, true)), snap(&PointCloud::random(&mut rng, 12, true)));
        let t = (rng.direction() * 1.2 * 1024.0).round() / 1024.0;
        let pose = Pose::from_translation(t).unwrap();
        let (c, d) = (deep(&a, &b, pose), far(&a, &b, pose));
        let (a, b) = (a.moved(away), b.moved(away));
        let (cf, df) = (deep(&a, &b, pose), far(&a, &b, pose));
        assert_eq!(c.hit, cf.hit);
        assert!((c.depth - cf.depth).abs() <= 1e-5 * c.depth + 1e-8, "{c:?} {cf:?}");
        assert!((d.distance - df.distance).abs() <= 2e-5 * d.distance + 1e-8, "{d:?} {df:?}");
        assert!(cf.depth_upper - cf.depth_lower < 1e-5 * cf.depth_upper + 1e-7, "{cf:?}");
    }
}

#[test]
fn hit_and_miss_flicker_at_contact() {
    // A hair apart, touching, a hair deep: never "separated" then "overlapping" within rounding, warm or cold.
    let cube = Cuboid(DVec3::ONE);
    let mut warm = Cache::new();
    for i in -40..=40 {
        let gap = f64::from(i) * f64::EPSILON;
        let pose = at(2.0 + gap, 0.25, -0.5);
        let (cold, kept) = (hit(&cube, &cube, pose), intersects(&cube, &cube, pose, &mut warm));
        assert_eq!(cold, kept.status, "{i}");
        assert_eq!(cold, Overlap::Touching, "{i}");
    }
    for (gap, expected) in [(1e-12, Overlap::Separated), (-1e-12, Overlap::Overlapping)] {
        for _ in 0..3 {
            assert_eq!(intersects(&cube, &cube, at(2.0 + gap, 0.25, -0.5), &mut warm).status, expected);
        }
    }
}

#[test]
fn one_ulp_gap() {
    // Far coordinates, where the gap is one unit in the last place: honest, not certain.
    let cube = Cuboid(DVec3::ONE);
    let gap = 2.0_f64.next_up();
    assert_eq!(hit(&cube, &cube, at(gap, 0.0, 0.0)), Overlap::Touching);
    let d = far(&cube, &cube, at(gap, 0.0, 0.0));
    assert!(d.lower == 0.0 && d.upper >= gap - 2.0 && d.upper < 1e-13, "{d:?}");
}

#[test]
fn shapes_that_give_nan_are_no_endless_loop() {
    struct Broken;
    impl SupportMap for Broken {
        fn support(&self, _: DVec3) -> hullmap::Support {
            hullmap::Support { point: DVec3::NAN, feature: 0 }
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
    let cube = Cuboid(DVec3::ONE);
    let cache = &mut Cache::new();
    // Nothing is proved, so nothing is called apart.
    assert!(intersects(&Broken, &cube, Pose::IDENTITY, cache).is_hit());
    assert!(contact(&cube, &Broken, Pose::IDENTITY, &Settings::default(), cache).hit);
    let d = distance(&Broken, &cube, Pose::IDENTITY, &Settings::default(), cache);
    assert!(!matches!(d.status, Status::Exact | Status::Within), "{d:?}");
    // And a good pair forgives the cache that a bad one left.
    assert_eq!(intersects(&cube, &cube, at(3.0, 0.0, 0.0), cache).status, Overlap::Separated);
}

/// A prism or, with `top` 0, a cone of many sides: flat caps of many points, and needle-thin side faces.
fn prism(sides: usize, top: f64, half_height: f64) -> PointCloud {
    let ring = PointCloud::polygon(sides, 1.0).points;
    let lower = ring.iter().map(|p| *p - DVec3::Z * half_height);
    let upper = ring.iter().map(|p| *p * top + DVec3::Z * half_height);
    PointCloud::new(lower.chain(upper).collect())
}

#[test]
fn many_coplanar_points() {
    let mut rng = Rng(23);
    let shapes = [prism(200, 1.0, 0.5), prism(200, 0.0, 1.0), prism(60, 0.5, 0.05), shy_cube()];
    let (mut hits, mut pairs) = (0, 0);
    for a in &shapes {
        for b in &shapes {
            for i in 0..60 {
                let mut pose = rng.pose(2.5);
                if i % 3 == 0 {
                    // Caps parallel: hundreds of ties.
                    pose = Pose::new(pose.translation(), DQuat::from_rotation_z(rng.range(0.0, 6.0))).unwrap();
                }
                let (c, back) = (deep(a, b, pose), deep(b, a, pose.inverse()));
                // Nearly concentric cones are as deep along 400 faces, which is more than the expansion holds.
                let wide = c.depth_upper - c.depth_lower > 1e-3 * c.depth_upper + 1e-12;
                assert!(c.status != Status::Stalled && !wide, "{c:?} {pose:?}");
                assert_eq!(c.hit, back.hit, "{pose:?}");
                assert!(
                    c.depth_lower <= back.depth_upper && back.depth_lower <= c.depth_upper,
                    "{c:?} {back:?} {pose:?}"
                );
                assert_eq!(hit(a, b, pose) != Overlap::Separated, c.hit, "{pose:?}");
                let d = far(a, b, pose);
                assert!(!matches!(d.status, Status::IterationLimit | Status::Stalled), "{d:?} {pose:?}");
                assert_eq!(d.distance == 0.0, c.hit, "{d:?} {pose:?}");
                if c.hit {
                    // Pushed out by the depth they touch, or miss by no more than the interval.
                    let away = Pose::new(pose.translation() + c.normal * c.depth, pose.rotation()).unwrap();
                    let left = far(a, b, away);
                    assert!(left.distance <= 1e-3 * c.depth + 1e-12, "{c:?} {left:?}");
                }
                pairs += 1;
                hits += usize::from(c.hit);
            }
        }
    }
    let share = f64::from(hits as u32) / f64::from(pairs);
    assert!((0.3..0.85).contains(&share), "{share}");
}

#[test]
fn smooth_shapes() {
    /// A capsule along z, by closed form.
    struct Capsule {
        half: f64,
        radius: f64,
    }
    impl SupportMap for Capsule {
        fn support(&self, dir: DVec3) -> hullmap::Support {
            let end = DVec3::Z * if dir.z < 0.0 { -self.half } else { self.half };
            hullmap::Support { point: end + dir.normalize_or_zero() * self.radius, feature: 0 }
        }
        fn interior_point(&self) -> DVec3 {
            DVec3::ZERO
        }
        fn inner_radius(&self) -> f64 {
            self.radius
        }
        fn outer_radius(&self) -> f64 {
            self.half + self.radius
        }
    }
    let (a, b) = (Capsule { half: 1.0, radius: 0.25 }, Capsule { half: 0.5, radius: 0.5 });
    let (spine_a, spine_b) =
        (PointCloud::new(vec![DVec3::Z, DVec3::NEG_Z]), PointCloud::new(vec![DVec3::Z * 0.5, DVec3::Z * -0.5]));
    let mut rng = Rng(29);
    let mut hits = 0;
    for _ in 0..400 {
        let pose = rng.pose(2.5);
        let spines = far(&spine_a, &spine_b, pose);
        let gap = spines.distance - 0.75;
        let slack = spines.upper - spines.lower + 1e-12;
        let (c, d) = (deep(&a, &b, pose), far(&a, &b, pose));
        assert_eq!(c.hit, gap < 0.0, "{gap} {c:?}");
        if c.hit {
            hits += 1;
            // Spines apart: the depth is the radii less their distance.
            if spines.distance > 0.0 {
                assert!(c.depth_lower <= slack - gap && -gap <= c.depth_upper + slack, "{gap} {c:?}");
                assert!(c.status != Status::Stalled, "{c:?}");
            }
        } else {
            assert!(d.lower <= gap + slack && gap <= d.upper + slack, "{gap} {d:?}");
            assert!(d.upper - d.lower <= 1.01e-5 * d.upper + 1e-12, "{d:?}");
        }
    }
    assert!((100..300).contains(&hits), "{hits}");
}

#[test]
fn inexact_support_breaks_termination() {
    /// Chooses its points by single-precision dot products: off by up to 1e-7 of its size, and not even monotone.
    struct Single(PointCloud);
    impl SupportMap for Single {
        fn support(&self, dir: DVec3) -> hullmap::Support {
            let value = |p: &DVec3| p.as_vec3().dot(dir.as_vec3());
            let mut best = 0;
            for i in 1..self.0.points.len() {
                if value(&self.0.points[i]) > value(&self.0.points[best]) {
                    best = i;
                }
            }
            hullmap::Support { point: self.0.points[best], feature: best as u32 }
        }
        fn interior_point(&self) -> DVec3 {
            self.0.interior
        }
        fn inner_radius(&self) -> f64 {
            0.0
        }
        fn outer_radius(&self) -> f64 {
            self.0.outer_radius
        }
    }
    let mut rng = Rng(31);
    for _ in 0..300 {
        let (a, b) = (PointCloud::random(&mut rng, 2000, true), PointCloud::random(&mut rng, 500, true));
        let pose = rng.pose(1.6);
        let settings = Settings { tolerance: 0.0, ..Settings::default() };
        let (exact, c) = (
            contact(&a, &b, pose, &settings, &mut Cache::new()),
            contact(&Single(a.clone()), &Single(b.clone()), pose, &settings, &mut Cache::new()),
        );
        assert!(c.iterations < 500, "{c:?}");
        if exact.depth > 1e-6 {
            assert!(
                c.hit && c.depth_lower <= exact.depth_upper + 1e-6 && exact.depth_lower <= c.depth_upper + 1e-6,
                "{c:?} {exact:?}"
            );
        }
        let d = distance(&Single(a), &Single(b), pose, &settings, &mut Cache::new());
        assert!(d.iterations < 500, "{d:?}");
    }
}

/// The nearest points coincide, and their difference points nowhere: the normal came out along a diagonal.
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

#[test]
fn origin_in_a_faces_plane_but_beside_the_face() {
    // A polygon, and a slab whose top is in the polygon's plane, beside it: no face proves them apart or touching, the nearest points do.
    let polygon = PointCloud::polygon(24, 1.0);
    for thick in [1e-3, 1e-5, 1e-7] {
        let slab = PointCloud::cuboid(DVec3::new(0.7, 0.5, thick));
        for gap in [1e-2, 1e-4, 1e-6] {
            for turn in [0.0, 0.3, 1.0] {
                let rotation = DQuat::from_rotation_z(turn);
                let reach = (rotation.inverse() * DVec3::X).abs().dot(DVec3::new(0.7, 0.5, 0.0));
                let pose = Pose::new(DVec3::new(1.0 + reach + gap, 0.0, -thick), rotation).unwrap();
                let what = format!("{thick} {gap} {turn}");
                assert_eq!(hit(&polygon, &slab, pose), Overlap::Separated, "{what}");
                assert_eq!(hit(&slab, &polygon, pose.inverse()), Overlap::Separated, "{what}");
                assert!(!deep(&polygon, &slab, pose).hit && !deep(&slab, &polygon, pose.inverse()).hit, "{what}");
                assert!(far(&polygon, &slab, pose).lower > 0.99 * gap, "{what}");
            }
        }
    }
}

#[test]
fn degenerate_simplex_has_a_finite_depth() {
    // Segments that cross at all angles, down to none, far from their frames' origins.
    let away = DVec3::new(50.0, -35.0, 20.0);
    let mut rng = Rng(23);
    for round in 0..3000 {
        let along = rng.direction();
        let angle = [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15][round % 7];
        let other = (along + rng.direction() * angle).normalize();
        let segment = |dir: DVec3| PointCloud::new(vec![away + dir * 1.1, away - dir]);
        let (a, b) = (segment(along), segment(other));
        let shift = rng.direction() * [0.0, 1e-15, 1e-14, 1e-13][round % 4];
        let pose = Pose::from_translation(shift).unwrap();
        for c in [deep(&a, &b, pose), deep(&b, &a, pose.inverse())] {
            assert!(c.depth.is_finite() && c.depth_upper < 3.0, "{c:?}");
        }
    }
}

#[test]
fn witness_points_where_every_face_is_as_near() {
    // A ball at the centre of a cylinder: the depth is known at once, a face that shows it is not.
    for (half, radius, ball) in [(700.0, 500.0, 500.0), (0.7, 0.5, 0.8), (3.0, 0.5, 0.01)] {
        let cylinder = hullmap::shapes::Cylinder::new(half, radius).unwrap();
        let ball = hullmap::shapes::Sphere::new(ball).unwrap();
        let c = deep(&cylinder, &ball, Pose::IDENTITY);
        assert_near(c.depth, radius + ball.radius());
        let between = c.point_a - c.point_b;
        assert!(between.dot(c.normal) <= c.depth_upper * (1.0 + 1e-12), "{c:?}");
        assert!(between.length() >= c.depth_lower * (1.0 - 1e-3), "{c:?}");
        assert!((DVec3::new(c.point_a.x, c.point_a.y, 0.0).length() - radius).abs() < 1e-3 * radius, "{c:?}");
    }
}

#[test]
fn cores_that_nearly_touch_are_no_deeper_than_they_are() {
    let (ball, needle) =
        (hullmap::shapes::Sphere::new(0.0008).unwrap(), hullmap::shapes::Capsule::new(0.0007, 0.0).unwrap());
    let mut rng = Rng(29);
    for _ in 0..2000 {
        // The segment passes the ball's centre at a distance from 1e-6 to 1e-16.
        let rotation = rng.rotation();
        let side = (rotation * DVec3::Z).cross(rng.direction()).normalize();
        let gap = 10.0_f64.powf(-rng.range(6.0, 16.0));
        let pose = Pose::new(side * gap, rotation).unwrap();
        let truth = 0.0008 - gap;
        for c in [deep(&ball, &needle, pose), deep(&needle, &ball, pose.inverse())] {
            assert!(c.depth_lower <= truth + 1e-17 && truth - 1e-17 <= c.depth_upper, "{gap:e}: {c:?}");
        }
    }
}

#[test]
fn parallel_close_faces() {
    let (a, b) = (shy_cube(), PointCloud::cuboid(DVec3::new(0.5, 2.0, 0.25)));
    for exponent in 3..=15 {
        for sign in [-1.0, 1.0] {
            let gap = sign * 10.0_f64.powi(-exponent);
            for slide in [0.0, 0.3, 1.2] {
                let pose = at(1.5 + gap, slide, 0.1);
                let gap = pose.translation().x - 1.5;
                let (c, d) = (deep(&a, &b, pose), far(&a, &b, pose));
                // What is farther than rounding is told for certain.
                if gap.abs() > 2e-15 * 64.0 {
                    assert_eq!(c.hit, gap < 0.0, "{gap:e}");
                    assert_eq!(hit(&a, &b, pose) == Overlap::Separated, gap > 0.0, "{gap:e}");
                }
                if c.hit {
                    assert!(c.depth_lower <= (-gap).max(0.0) && -gap <= c.depth_upper, "{gap:e}: {c:?}");
                    assert!(c.normal.distance(DVec3::X) < 1e-12, "{gap:e}: {c:?}");
                }
                assert!(d.lower <= gap.max(0.0) && gap <= d.upper + 1e-15, "{gap:e}: {d:?}");
            }
        }
    }
}
