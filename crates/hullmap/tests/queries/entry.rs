//! Rays, shape casts and signed distances: on surfaces, along faces and edges, flat, tiny, huge and
//! slow. `hullmap_tests::soak` judges random ones.

use crate::any_shape::{Any, cast, ray, signed_distance};
use glam::DVec3;
use hullmap::shapes::{Cuboid, HalfSpace, Scaled, Sphere};
use hullmap::{Cache, CastSettings, Impact, Motion, Pose, Ray, RayHit, Settings, Status};
use hullmap_testkit::packs::tree_pack;
use shapes::rng::SplitMix64;

const SEED: u64 = 20_261_122;

/// Rays at a shape: name, origin, direction, and t. Infinite if the ray misses.
type Row = (&'static str, [f64; 3], [f64; 3], f64);

/// Every t is exact up to rounding error, and certain.
fn judge(what: &str, shape: &Any<'_>, rows: &[Row]) {
    for (name, origin, direction, t) in rows {
        let line = Ray::new(DVec3::from_array(*origin), DVec3::from_array(*direction)).unwrap();
        let found = ray(shape, &line, &CastSettings::default());
        let at = format!("{what}: {name}: {found:?}");
        if *t == f64::INFINITY {
            assert_eq!((found.hit, found.status), (false, Status::Separated), "{at}");
            continue;
        }
        assert!(found.hit && matches!(found.status, Status::Exact | Status::Within), "{at}");
        assert!(found.t_lower <= *t && *t <= found.t_upper && (found.t - t).abs() < 1e-12, "{at}");
        assert!(found.normal.dot(line.direction()) <= 0.0 || found.t == 0.0, "{at}");
    }
}

/// On surfaces, in the plane of a face, along edges, and through vertices: shapes are closed.
#[test]
fn rays_at_boundaries_of_solid_and_flat_hulls_are_certain() {
    const MISS: f64 = f64::INFINITY;
    let next = 1.0_f64.next_up();
    judge(
        "cube",
        &Cuboid::new(DVec3::ONE).unwrap(),
        &[
            ("from its surface inwards", [1.0, 0.2, 0.1], [-1.0, 0.0, 0.0], 0.0),
            ("from its surface outwards", [1.0, 0.2, 0.1], [1.0, 0.0, 0.0], 0.0),
            ("from its surface along it", [1.0, 0.2, 0.1], [0.0, 1.0, 0.0], 0.0),
            ("one ulp outside, outwards", [next, 0.2, 0.1], [1.0, 0.0, 0.0], MISS),
            ("one ulp outside, along it", [next, 0.2, 0.1], [0.0, 1.0, 0.0], MISS),
            ("in the plane of a face", [-3.0, 0.0, 1.0], [1.0, 0.0, 0.0], 2.0),
            ("in the plane of a face, beside its middle", [-3.0, 0.25, 1.0], [1.0, 0.0, 0.0], 2.0),
            ("along an edge", [-3.0, 1.0, 1.0], [2.0, 0.0, 0.0], 1.0),
            ("past an edge", [0.0, 2.0, 0.0], [1.0, -1.0, 0.0], 1.0),
            ("past a vertex", [0.0, 0.0, 3.0], [1.0, 1.0, -2.0], 1.0),
            ("into a vertex", [3.0, 3.0, 3.0], [-1.0, -1.0, -1.0], 2.0),
            ("into an edge", [3.0, 3.0, 0.0], [-1.0, -1.0, 0.0], 2.0),
            ("into the middle of a face", [0.0, 0.0, 5.0], [0.0, 0.0, -4.0], 1.0),
            ("into the diagonal of a face", [0.5, 0.5, 5.0], [0.0, 0.0, -4.0], 1.0),
            ("into a face at an angle", [3.0, 2.0, 1.5], [-2.0, -1.5, -1.0], 1.0),
            ("1e-12 above a face", [-3.0, 0.0, 1.0 + 1e-12], [1.0, 0.0, 0.0], MISS),
            ("1e-12 below a face", [-3.0, 0.0, 1.0 - 1e-12], [1.0, 0.0, 0.0], 2.0),
            ("from outside, at rest", [1.5, 1.5, 1.5], [0.0; 3], MISS),
            ("from its surface, at rest", [1.0, 0.5, 0.0], [0.0; 3], 0.0),
        ],
    );
    let down = [0.0, 0.0, -1.0];
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [x, y, 0.5]);
    judge(
        "square",
        &tree_pack(&square).hull(0).unwrap(),
        &[
            ("middle", [0.0, 0.0, 3.5], down, 3.0),
            ("inside", [0.25, 0.5, 3.5], down, 3.0),
            ("on a diagonal", [0.5, 0.5, 3.5], down, 3.0),
            ("on the other diagonal", [-0.9, 0.9, 3.5], down, 3.0),
            ("beside it", [1.5, 0.0, 3.5], down, MISS),
            ("in its plane", [-3.0, 0.0, 0.5], [1.0, 0.0, 0.0], 2.0),
        ],
    );
    judge(
        "segment",
        &tree_pack(&[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).hull(0).unwrap(),
        &[
            ("across", [0.5, 0.0, 2.0], down, 2.0),
            ("along", [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0], 2.0),
            ("beside it", [0.5, 0.1, 2.0], down, MISS),
        ],
    );
    judge(
        "point",
        &tree_pack(&[[0.5, 0.25, 0.125]]).hull(0).unwrap(),
        &[("through", [0.5, 0.25, 2.0], down, 1.875), ("beside it", [0.5, 0.26, 2.0], down, MISS)],
    );
}

/// A ray from 1.5 % inside a cube far from the origin of its frame was `Exact`, with t = 0.
#[test]
fn rays_that_start_inside_overlap() {
    let corner = |i: usize, bit: usize, at: [f32; 2]| at[usize::from(i & bit != 0)];
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| [corner(i, 1, [81781.0, 81783.0]), corner(i, 2, [-1.0, 1.0]), corner(i, 4, [-1.0, 1.0])])
        .collect();
    let pack = tree_pack(&corners);
    let hull = pack.hull(0).unwrap();
    let scale = 2.0_f64.powi(110);
    let origin = DVec3::new(6.300331988517956e-29, -4.032956626326999e-34, -3.693649122063957e-34) * scale;
    let direction = DVec3::new(-3.3404182872141488e-34, -5.227812647004182e-34, 4.567152176714411e-34) * scale;
    let mut rng = SplitMix64::new(SEED + 11);
    let random = (0..2_000).map(|_| {
        let middle = DVec3::X * 81782.0;
        let inside = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)) * (1.0 - 1e-6);
        (middle + inside, DVec3::from_array(rng.direction()))
    });
    for (origin, direction) in std::iter::once((origin, direction)).chain(random) {
        for max_t in [0.0, 1.0, f64::INFINITY] {
            for tolerance in [0.0, 1e-6] {
                let settings = CastSettings { max_t, tolerance, ..CastSettings::default() };
                let hit = ray(&hull, &Ray::new(origin, direction).unwrap(), &settings);
                assert_eq!(
                    (hit.status, hit.t, hit.t_upper),
                    (Status::Overlapping, 0.0, 0.0),
                    "{origin} {direction} {hit:?}"
                );
                assert!(hit.normal.dot(direction) < 0.0 && hit.point.distance(origin) < 1e-9, "{hit:?}");
            }
        }
    }
}

/// Nothing changes with the unit of length, nor with the length of the direction.
#[test]
fn units_change_no_answer() {
    for size in [1e-30, 1e-6, 1.0, 1e6, 1e30] {
        let cube = Cuboid::new(DVec3::splat(size)).unwrap();
        for speed in [5e-324, 1e-200, 1e-3, 1.0, 1e38] {
            let line = Ray::new(DVec3::new(0.1, 0.2, 4.0) * size, DVec3::NEG_Z * speed).unwrap();
            let found = ray(&cube, &line, &CastSettings::default());
            let t = 3.0 * size / speed;
            if t.is_finite() {
                assert!(found.hit && (found.t / t - 1.0).abs() < 1e-9, "{size:e} {speed:e} {found:?}");
                assert!(found.t_lower <= t && t <= found.t_upper, "{size:e} {speed:e} {found:?}");
            }
        }
        let far = Ray::new(DVec3::new(0.1, 0.2, 1e6) * size, DVec3::NEG_Z).unwrap();
        let found = ray(&cube, &far, &CastSettings::default());
        assert!((found.t / size - 999_999.0).abs() < 1e-6 && found.status != Status::Touching, "{found:?}");
    }
}

/// Where B meets A, or a ray an A, on each path through the code: its status, and t with its
/// interval.
fn all_entries(size: f64, start: DVec3, velocity: DVec3, settings: &CastSettings) -> Vec<(&'static str, Impact)> {
    let (motion, line, at) =
        (Motion::new(velocity).unwrap(), Ray::new(start, velocity).unwrap(), Pose::from_translation(start).unwrap());
    let (cube, ball) = (Cuboid::new(DVec3::splat(size)).unwrap(), Sphere::new(size).unwrap());
    let corners: Vec<[f32; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| (2 * bit - 1) as f32 * size as f32)).collect();
    let (floor, one) = (HalfSpace::new(DVec3::X, size).unwrap(), tree_pack(&corners));
    let of_ray = |found: RayHit| {
        let RayHit { hit, status, t, t_lower, t_upper, point, .. } = found;
        Impact { hit, status, t, t_lower, t_upper, point_a: point, point_b: point, ..Impact::default() }
    };
    let none = &mut Cache::new();
    vec![
        ("ray at a box", of_ray(ray(&cube, &line, settings))),
        ("ray at a ball", of_ray(ray(&ball, &line, settings))),
        ("ray at a half-space", of_ray(hullmap::ray(&floor, &line, settings))),
        ("ray at a compound", of_ray(hullmap::ray(&one, &line, settings))),
        ("box", cast(&cube, &cube, at, motion, settings, none)),
        ("ball", cast(&cube, &ball, at, motion, settings, none)),
        ("box and half-space", hullmap::cast(&floor, &cube, at, motion, settings, none)),
        ("compound and half-space", hullmap::cast(&floor, &one, at, motion, settings, none)),
        ("compound", hullmap::cast(&one, &one, at, motion, settings, &mut Cache::new())),
    ]
}

/// 2 to the power of `exponent`, down to −1074.
fn power_of_two(exponent: i32) -> f64 {
    2_f64.powi(exponent / 2) * 2_f64.powi(exponent - exponent / 2)
}

/// The speed of a subnormal velocity had a rounding error of up to 41 %, and the status was exact.
#[test]
fn subnormal_velocities_keep_their_digits() {
    // The lengths are so small that the times are finite.
    let (size, settings) = (power_of_two(-56), CastSettings::default());
    for exponent in [100, 30, -1, -160, -400, -401, -540, -900, -1022, -1050, -1074] {
        // The length is exactly 5. The paths start at x = 1e-15.
        let unit = power_of_two(exponent);
        let (velocity, start) = (DVec3::new(-4.0, 3.0, 0.0) * unit, DVec3::new(1e-15, -0.75e-15, 0.0));
        for (what, found) in all_entries(size, start, velocity, &settings) {
            // The first of the two lengths is a ray's.
            let is_free = what.starts_with("ray");
            let x = if is_free { size } else { 2.0 * size };
            let t = (1e-15 - x) / 4.0 / unit;
            if what.contains("ball") {
                // Not at x, but at an angle: near it.
                assert!(found.hit && (found.t / t - 1.0).abs() < 0.05, "{what}, 2^{exponent}: {found:?}");
                continue;
            }
            assert!(found.hit && (found.t / t - 1.0).abs() < 1e-6, "{what}, 2^{exponent}: {t:e} {found:?}");
            let error = 1e-12 * t;
            assert!(found.t_lower - error <= t && t <= found.t_upper + error, "{what}, 2^{exponent}: {t:e} {found:?}");
            assert!(found.point_a.is_finite() && found.point_b.is_finite(), "{what}, 2^{exponent}: {found:?}");
        }
    }
}

/// Times beyond the range of f64 were infinite, with `hit` and with NaN in the points.
#[test]
fn a_time_beyond_the_range_of_f64_is_no_hit() {
    for speed in [5e-324, 1e-310, 1e-309, 2e-308] {
        let (start, settings) = (DVec3::X * 9.0, CastSettings::default());
        for (what, found) in all_entries(1.0, start, DVec3::NEG_X * speed, &settings) {
            let length = if what.starts_with("ray") { 8.0 } else { 7.0 };
            let is_late = length / speed > f64::MAX;
            assert_eq!(found.hit, !is_late, "{what}, {speed:e}: {found:?}");
            assert!(!found.hit || found.t.is_finite() && found.t_lower <= found.t, "{what}, {speed:e}: {found:?}");
            assert!(found.hit || found.status == Status::Separated && found.t_lower == f64::INFINITY, "{found:?}");
            assert!(found.point_a.is_finite() && found.point_b.is_finite(), "{what}, {speed:e}: {found:?}");
        }
    }
    // At the end of the time range, rounding error decides.
    let speed = 7.0 / f64::MAX;
    for (what, found) in all_entries(1.0, DVec3::X * 9.0, DVec3::NEG_X * speed, &CastSettings::default()) {
        if found.hit {
            assert!(found.t <= f64::MAX && found.point_a.is_finite() && found.point_b.is_finite(), "{what}: {found:?}");
            assert!(found.t_upper < f64::MAX || found.status == Status::Touching, "{what}: {found:?}");
        }
    }
}

#[test]
fn without_motion_only_the_start_counts() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let inside = ray(&cube, &Ray::new(DVec3::splat(0.5), DVec3::ZERO).unwrap(), &CastSettings::default());
    assert_eq!(inside.status, Status::Overlapping);
    // The points of a cast were zero.
    let (ball, start) = (Sphere::new(0.5).unwrap(), DVec3::new(1.25, 0.5, 0.75));
    for (x, status) in [(1.25, Status::Overlapping), (1.5, Status::Touching)] {
        let pose = Pose::from_translation(start.with_x(x)).unwrap();
        let motion = Motion::new(DVec3::ZERO).unwrap();
        let found = cast(&cube, &ball, pose, motion, &CastSettings::default(), &mut Cache::new());
        assert_eq!((found.hit, found.status, found.t, found.t_upper), (true, status, 0.0, 0.0), "{found:?}");
        assert!(found.point_a.distance(found.point_b) <= 1e-15, "{found:?}");
        assert!(found.point_a.abs().max_element() <= 1.0 + 1e-15, "{found:?}");
        assert!(found.point_b.distance(pose.translation()) <= 0.5 + 1e-15, "{found:?}");
    }
    let floor = HalfSpace::new(DVec3::Z, 1.0).unwrap();
    let (up, settings) = (Motion::new(DVec3::Z).unwrap(), CastSettings::default());
    let found = hullmap::cast(&floor, &ball, Pose::IDENTITY, up, &settings, &mut Cache::new());
    assert!(found.status == Status::Overlapping && found.point_a == found.point_b, "{found:?}");
    // With a limit of 0, of NaN, or below 0, too.
    for max_t in [0.0, f64::NAN, -1.0] {
        let settings = CastSettings { max_t, ..CastSettings::default() };
        let ahead = Ray::new(DVec3::X * 3.0, DVec3::NEG_X).unwrap();
        assert_eq!(ray(&cube, &ahead, &settings).status, Status::Separated, "{max_t}");
        let inside = Ray::new(DVec3::splat(0.5), DVec3::NEG_X).unwrap();
        assert!(ray(&cube, &inside, &settings).hit, "{max_t}");
    }
}

#[test]
fn vectors_that_are_not_finite_are_rejected() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39] {
        let v = DVec3::new(0.0, bad, 0.0);
        assert_eq!(Ray::new(v, DVec3::X).unwrap_err().what, "origin");
        assert_eq!(Ray::new(DVec3::X, v).unwrap_err().what, "direction");
        assert_eq!(Motion::new(v).unwrap_err().what, "velocity");
        let cube = Cuboid::new(DVec3::ONE).unwrap();
        let found = signed_distance(&cube, v, &Settings::default(), &mut Cache::new());
        assert_eq!(found.unwrap_err().what, "point");
    }
}

/// A limit on the steps ends every search with an honest interval.
#[test]
fn few_iterations_leave_a_wide_interval() {
    let egg = Scaled::new(Sphere::new(1.0).unwrap(), DVec3::new(1.0, 0.5, 2.0)).unwrap();
    let line = Ray::new(DVec3::new(0.1, 4.0, 0.3), DVec3::new(0.02, -1.0, 0.1)).unwrap();
    let exact = ray(&egg, &line, &CastSettings { tolerance: 0.0, ..CastSettings::default() });
    for max_iterations in 0..30 {
        let found = ray(&egg, &line, &CastSettings { max_iterations, ..CastSettings::default() });
        assert!(found.hit && found.t_lower <= exact.t_upper && exact.t_lower <= found.t_upper, "{found:?}");
        assert!(max_iterations > 4 || found.status == Status::IterationLimit, "{found:?}");
    }
}
