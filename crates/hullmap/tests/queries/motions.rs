//! Times of impact of shapes that move and turn, against formulas. `hullmap_tests::soak` judges
//! random ones.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::any_shape::{cast_motion, distance};
use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cuboid, Sphere};
use hullmap::{
    Cache, MotionSettings, Pose, RigidMotion, Settings, Shape, Status, SupportMap, SupportPoint, TimeOfImpact,
};
use hullmap_testkit::packs::tree_pack;

fn moved_to(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn still(x: f64, y: f64, z: f64) -> RigidMotion {
    RigidMotion::still(moved_to(x, y, z))
}

fn spin(pose: Pose, angular: DVec3) -> RigidMotion {
    RigidMotion::screw(pose, DVec3::ZERO, angular, pose.translation()).unwrap()
}

fn meet(a: (&(dyn Shape + Sync), &RigidMotion), b: (&(dyn Shape + Sync), &RigidMotion)) -> TimeOfImpact {
    cast_motion(a.0, a.1, b.0, b.1, &MotionSettings::default(), &mut Cache::new())
}

/// The interval contains `t`, and is not wider than `width`.
fn assert_at(found: &TimeOfImpact, t: f64, width: f64) {
    assert!(found.hit && found.status == Status::Within, "{t}: {found:?}");
    // The formula has a few rounding errors.
    assert!(found.t_lower <= t + 1e-14 && t - 1e-14 <= found.t_upper, "{t}: {found:?}");
    assert!(found.t_upper - found.t_lower <= width, "{t}: {found:?}");
}

fn assert_missed(found: &TimeOfImpact) {
    assert!(!found.hit && found.status == Status::Separated, "{found:?}");
    assert_eq!([found.t, found.t_lower, found.t_upper], [f64::INFINITY; 3]);
}

/// A needle of length 2 and radius 1e-3 spins about its centre, past a point: its side meets the
/// point where the angle is right, or never if the point is farther than its end.
#[test]
fn a_needle_spins_past_a_point() {
    let (needle, point) = (Capsule::new(1.0, 1e-3).unwrap(), Sphere::new(1e-6).unwrap());
    let along = (DVec3::AXES.into_iter())
        .find(|axis| needle.support_point(*axis).point.dot(*axis) > 1.0)
        .map(DVec3::abs)
        .unwrap();
    let across = if along == DVec3::X { DVec3::Z } else { DVec3::X };
    let axis = along.cross(across);
    for (distance, turns) in [(0.5_f64, 0.25), (0.9, 0.7), (0.9, 2.5)] {
        let place = across * distance;
        let spinning = spin(Pose::IDENTITY, axis * (TAU * turns));
        let found = meet((&needle, &spinning), (&point, &RigidMotion::still(Pose::from_translation(place).unwrap())));
        let angle = FRAC_PI_2 - ((1e-3 + 1e-6) / distance).asin();
        assert_at(&found, angle / (TAU * turns), 1e-4);
    }
    // Close to the axis, the needle's end is twenty times as fast as the side that meets the point,
    // and steps are short. The interval is true all the same.
    let spinning = spin(Pose::IDENTITY, axis * PI);
    let place = Pose::from_translation(across * 0.05).unwrap();
    let found = meet((&needle, &spinning), (&point, &RigidMotion::still(place)));
    let t = (FRAC_PI_2 - ((1e-3_f64 + 1e-6) / 0.05).asin()) / PI;
    assert!(found.hit && found.t_lower <= t + 1e-14 && found.t_lower > t - 1e-3, "{found:?}");
    assert!(found.t_upper >= t - 1e-14, "{found:?}");
    // Many turns, out of reach: no step for each quarter of a turn.
    for turns in [0.3, 3.0, 1e3, 1e6] {
        let spinning = spin(Pose::IDENTITY, axis * (TAU * turns));
        let place = Pose::from_translation(across * 1.01).unwrap();
        let found = meet((&needle, &spinning), (&point, &RigidMotion::still(place)));
        assert_missed(&found);
        assert!(found.iterations <= 20, "{turns}: {found:?}");
        // The point comes from far away, and is passed or reached within the length of the needle.
        let coming = |end: f64| {
            RigidMotion::between(
                Pose::from_translation(across * 9.0).unwrap(),
                Pose::from_translation(across * end).unwrap(),
            )
        };
        assert_missed(&meet((&needle, &spinning), (&point, &coming(1.002).unwrap())));
        if turns < 1e3 {
            let found = meet((&needle, &spinning), (&point, &coming(0.0).unwrap()));
            assert!(found.hit && found.t_lower > (9.0 - 1.002) / 9.0 - 1e-5, "{found:?}");
        }
    }
}

#[test]
fn motions_that_end_in_touch() {
    let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Sphere::new(0.5).unwrap());
    let motion = |end: f64| RigidMotion::between(moved_to(5.0, 0.0, 0.0), moved_to(end, 0.0, 0.0)).unwrap();
    let run = |end: f64| meet((&cube, &still(0.0, 0.0, 0.0)), (&ball, &motion(end)));
    let touching = run(1.5);
    assert!(touching.hit && touching.t_lower <= 1.0 && touching.t_lower > 1.0 - 1e-12, "{touching:?}");
    assert_missed(&run(1.5 + 1e-12));
    assert_at(&run(1.5 - 1e-9), 1.0 - 1e-9 / 3.5, 1e-5);
    // Within the skin just at the end.
    let settings = MotionSettings { target_distance: 0.25, ..MotionSettings::default() };
    let run = |end: f64| cast_motion(&cube, &still(0.0, 0.0, 0.0), &ball, &motion(end), &settings, &mut Cache::new());
    assert!(run(1.75).hit && run(1.75).t_lower > 1.0 - 1e-12, "{:?}", run(1.75));
    assert_missed(&run(1.75 + 1e-12));
}

#[test]
fn motions_that_start_in_touch_or_inside() {
    let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Sphere::new(0.5).unwrap());
    let origin = still(0.0, 0.0, 0.0);
    let leaving = |x: f64| RigidMotion::between(moved_to(x, 0.0, 0.0), moved_to(5.0, 1.0, 0.0)).unwrap();
    for x in [0.0, 0.2, 1.0, 1.5 - 1e-9] {
        let found = meet((&cube, &origin), (&ball, &leaving(x)));
        assert_eq!((found.status, found.hit, found.t, found.t_upper), (Status::Overlapping, true, 0.0, 0.0), "{x}");
    }
    let found = meet((&cube, &origin), (&ball, &leaving(1.5)));
    assert!(found.hit && found.t == 0.0 && found.t_lower == 0.0, "{found:?}");
    for gap in [1e-12, 1e-13, 2e-13, 5e-13] {
        let found = meet((&cube, &origin), (&ball, &leaving(1.5 + gap)));
        assert!(found.t_lower == 0.0 || found.status == Status::Separated, "{gap}: {found:?}");
    }
    assert_missed(&meet((&cube, &origin), (&ball, &leaving(1.5 + 1e-12))));
}

#[test]
fn settings_out_of_range_are_harmless() {
    let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Sphere::new(0.5).unwrap());
    let motion = RigidMotion::between(moved_to(5.0, 0.0, 0.0), moved_to(-5.0, 0.0, 0.0)).unwrap();
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| (2 * bit - 1) as f32)).collect();
    let (any, rest, pack): (&(dyn Shape + Sync), _, _) = (&ball, still(0.0, 0.0, 0.0), tree_pack(&corners));
    let run = |settings: MotionSettings| cast_motion(&cube, &rest, any, &motion, &settings, &mut Cache::new());
    let parts =
        |settings: MotionSettings| hullmap::cast_motion(&pack, &rest, any, &motion, &settings, &mut Cache::new());
    let usual = MotionSettings::default();
    let expected = run(usual);
    assert_at(&expected, 0.35, 1e-5);
    for target_distance in [f64::NAN, -1.0, f64::NEG_INFINITY] {
        assert_eq!(run(MotionSettings { target_distance, ..usual }), expected);
        assert_eq!(parts(MotionSettings { target_distance, ..usual }), parts(usual));
    }
    let far = MotionSettings { target_distance: f64::INFINITY, ..usual };
    assert!([run(far), parts(far)].iter().all(|found| (found.status, found.t) == (Status::Overlapping, 0.0)));
    for tolerance in [f64::NAN, -1.0, 0.0] {
        let settings = MotionSettings { tolerance, ..usual };
        for (found, width) in [(run(settings), 1e-12), (parts(settings), 1e-11)] {
            assert!(
                found.t_lower <= 0.35 && 0.35 <= found.t_upper && found.t_upper < found.t_lower + width,
                "{found:?}"
            );
        }
    }
    assert!(run(MotionSettings { tolerance: f64::INFINITY, ..usual }).t_lower <= 0.35);
    for max_iterations in [0, 1, 2, 3] {
        let found = run(MotionSettings { max_iterations, ..usual });
        assert!(found.iterations <= max_iterations.max(1) && found.hit && found.t_lower <= 0.35, "{found:?}");
        assert!(found.t_upper >= 0.35 && found.t >= found.t_lower, "{found:?}");
        assert!(max_iterations > 1 || found.status == Status::IterationLimit, "{found:?}");
    }
}

/// The same scene at all sizes that shapes may have has the same time of impact.
#[test]
fn extreme_sizes_and_speeds() {
    for size in [1e-30, 1e-12, 1.0, 1e12, 1e30, 1e37] {
        let rod = Cuboid::new(DVec3::new(1.0, 0.01, 0.01) * size).unwrap();
        let wall = Cuboid::new(DVec3::new(5.0, 0.1, 5.0) * size).unwrap();
        let turning = spin(Pose::IDENTITY, DVec3::Z * FRAC_PI_2);
        let found = meet((&rod, &turning), (&wall, &still(0.0, 0.7 * size, 0.0)));
        let t = ((0.6 / 1.0001_f64.sqrt()).asin() - 0.01_f64.atan()) / FRAC_PI_2;
        assert_at(&found, t, 1e-5);
    }
    let ball = Sphere::new(1.0).unwrap();
    let fast = RigidMotion::between(moved_to(1e38, 0.0, 0.0), moved_to(-1e38, 0.0, 0.0)).unwrap();
    let found = meet((&ball, &still(0.0, 0.0, 0.0)), (&ball, &fast));
    assert!(found.hit && found.t_lower <= 0.5 && found.t_lower > 0.5 - 1e-12, "{found:?}");
    // An angle beyond all sense: nothing is claimed unless it is sure.
    let rod = Cuboid::new(DVec3::new(1.0, 0.01, 0.01)).unwrap();
    for angle in [1e9, 1e20, 3e38] {
        let spinning = spin(Pose::IDENTITY, DVec3::Z * angle);
        let found = meet((&rod, &spinning), (&ball, &still(0.0, 1.5, 0.0)));
        assert!(found.hit && found.t_lower < 1.0, "{found:?}");
    }
}

/// A shape that fails if its contract is broken.
struct Strict<'s> {
    shape: &'s Cuboid,
    calls: AtomicU32,
}

impl SupportMap for Strict<'_> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        assert!(dir.is_finite() && dir.length_squared() > 1e-60, "no direction: {dir}");
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.shape.support_point(dir)
    }
    fn interior_point(&self) -> DVec3 {
        self.shape.interior_point()
    }
    fn inner_radius(&self) -> f64 {
        self.shape.inner_radius()
    }
    fn outer_radius(&self) -> f64 {
        self.shape.outer_radius()
    }
}

impl Shape for Strict<'_> {}

/// The normal is exactly the axis of rotation, so its part in the plane of rotation is zero.
#[test]
fn support_mappings_never_get_a_zero_direction() {
    let cube = Cuboid::new(DVec3::ONE).unwrap();
    let strict = || Strict { shape: &cube, calls: AtomicU32::new(0) };
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let (a, b) = (strict(), strict());
        let falling =
            RigidMotion::screw(Pose::from_translation(axis * 4.0).unwrap(), axis * -3.0, axis * 2.0, DVec3::ZERO);
        let found = meet((&a, &spin(Pose::IDENTITY, axis * 1.5)), (&b, &falling.unwrap()));
        assert_at(&found, 2.0 / 3.0, 1e-5);
        assert!(a.calls.into_inner() > 0 && b.calls.into_inner() > 0);
    }
}

/// Points and normal are in the common frame: they belong to the shapes in their poses at
/// `t_lower`, far from the origin, too.
#[test]
fn answers_are_in_the_common_frame() {
    let (rod, ball) = (Cuboid::new(DVec3::new(1.0, 0.1, 0.1)).unwrap(), Sphere::new(0.2).unwrap());
    let place = DVec3::new(100.0, -50.0, 7.0);
    let pose = Pose::new(place, DQuat::from_rotation_y(0.4)).unwrap();
    let a = RigidMotion::screw(pose, DVec3::X * 0.1, DVec3::Z * 2.0, place + DVec3::Y).unwrap();
    let b = RigidMotion::between(moved_to(102.5, -49.0, 7.0), moved_to(100.0, -49.2, 7.0)).unwrap();
    let found = meet((&rod, &a), (&ball, &b));
    assert_eq!(found.status, Status::Within, "{found:?}");
    let [pose_a, pose_b] = [a.pose_at(found.t_lower), b.pose_at(found.t_lower)];
    let b_in_a = Pose::relative(pose_a, pose_b).unwrap();
    let gap = distance(&rod, &ball, b_in_a, &Settings::default(), &mut Cache::new());
    assert!(found.point_a.distance(pose_a.transform_point(gap.point_a)) < 1e-4, "{found:?}");
    assert!(found.point_b.distance(pose_a.transform_point(gap.point_b)) < 1e-4, "{found:?}");
    assert!(found.normal.distance(pose_a.transform_vector(gap.normal)) < 1e-3, "{found:?}");
}
