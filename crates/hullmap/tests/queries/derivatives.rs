//! Derivatives of answers by poses: against central differences, and where there are none. The soak
//! of derivatives judges distances, depths, rays and casts of hulls.

use crate::any_shape;
use crate::compound::pack;
use crate::motions_of_parts::motion;
use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Sphere};
use hullmap::{
    Cache, CastSettings, Contact, Derivatives, Differentiability, Distance, Hull, Motion, MotionSettings, Pack, Pose,
    Ray, RigidMotion, Settings, Shape, Status, cast, cast_motion, contact, distance, ray, signed_distance,
};
use hullmap_testkit::{gap::gap, packs, polytope::Polytope};
use shapes::{families, rng::SplitMix64};

const SEED: u64 = 0xde21;

const EXACT: Settings = Settings { tolerance: 0.0, max_iterations: Settings::DEFAULT_MAX_ITERATIONS };

fn moved_to(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

/// The pose after a twist: the first three coordinates are of `v`, the others of `w`.
fn twisted(pose: Pose, axis: usize, step: f64) -> Pose {
    let unit = DVec3::AXES[axis % 3] * step;
    let (v, w) = if axis < 3 { (unit, DVec3::ZERO) } else { (DVec3::ZERO, unit) };
    Pose::new(pose.translation() + v, DQuat::from_scaled_axis(w) * pose.rotation()).unwrap()
}

/// Greatest difference of the derivatives and of central differences of `truth` by both poses.
fn off(found: &Derivatives, poses: [Pose; 2], step: f64, truth: impl Fn([Pose; 2]) -> f64) -> f64 {
    let mut off = 0.0_f64;
    for (which, by) in [found.of_a, found.of_b].into_iter().enumerate() {
        for (axis, found) in by.to_array().into_iter().enumerate() {
            let value = |step: f64| {
                let mut moved = poses;
                moved[which] = twisted(poses[which], axis, step);
                truth(moved)
            };
            off = off.max((found - (value(step) - value(-step)) / (2.0 * step)).abs());
        }
    }
    off
}

#[test]
fn distances_of_round_shapes() {
    let shapes: Vec<Box<dyn Shape + Sync>> = vec![
        Box::new(Sphere::new(0.7).unwrap()),
        Box::new(Capsule::new(0.8, 0.3).unwrap()),
        Box::new(Cylinder::new(0.5, 0.6).unwrap()),
        Box::new(Cone::new(0.5, 0.6).unwrap()),
        Box::new(Cuboid::new(DVec3::new(0.4, 0.6, 0.9)).unwrap()),
        Box::new(Rounded::new(Cuboid::new(DVec3::new(0.4, 0.3, 0.5)).unwrap(), 0.2).unwrap()),
    ];
    let mut rng = SplitMix64::new(SEED);
    let (mut unique, mut close) = (0, 0);
    for number in 0..600 {
        let (a, b) = (&*shapes[rng.below(6)], &*shapes[rng.below(6)]);
        let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
        let b_in_a = Pose::new(DVec3::from_array(rng.direction()) * rng.between(2.5, 5.0), rotation).unwrap();
        let gap = |b_in_a| distance(a, b, b_in_a, &EXACT, &mut Cache::new());
        let found = gap(b_in_a).derivatives(a, b, b_in_a);
        if found.status != Differentiability::Unique {
            // Within rounding errors, the normal of a curved surface is less accurate.
            continue;
        }
        unique += 1;
        let truth = |[a, b]: [Pose; 2]| gap(Pose::relative(a, b).unwrap()).distance;
        let off = off(&found, [Pose::IDENTITY, b_in_a], 1e-4, truth);
        close += usize::from(off < 1e-6);
        assert!(off < 1e-5, "{number}, seed {SEED:#x}: off by {off:e}: {found:?}");
    }
    println!("{unique} unique, {close} of them within 1e-6");
    assert!(unique > 500 && close * 100 > unique * 95, "{unique}, {close}");
}

/// The time at which two hulls are at a distance, by bisection of Wolfe's distance near a time.
fn meeting(bodies: [&Polytope; 2], poses: impl Fn(f64) -> [Pose; 2], target: f64, near: f64) -> f64 {
    let (mut early, mut late) = (near - 1e-3, near + 1e-3);
    for _ in 0..50 {
        let middle = 0.5 * (early + late);
        let [a, b] = poses(middle);
        let gap = gap(&bodies[0].placed(a), &bodies[1].placed(b)).upper;
        if gap > target { early = middle } else { late = middle }
    }
    0.5 * (early + late)
}

#[test]
fn times_of_impact_of_bodies_that_turn() {
    let (mut rng, pack) = (SplitMix64::new(SEED + 1), pack(6, 1.0, 51));
    let hulls: Vec<Hull<'_>> = pack.hulls().collect();
    let polytopes: Vec<Polytope> = hulls.iter().map(Polytope::new).collect();
    let settings = MotionSettings { target_distance: 0.05, tolerance: 1e-10, ..MotionSettings::default() };
    let (mut judged, mut close, mut flagged) = (0, 0, 0);
    for _ in 0..1_500 {
        let pair = [rng.below(6), rng.below(6)];
        let [a, b] = pair.map(|index| &hulls[index]);
        let [motion_a, motion_b] = [motion(&mut rng, 0.5), motion(&mut rng, 2.0)];
        let found = cast_motion(a, &motion_a, b, &motion_b, &settings, &mut Cache::new());
        if found.status != Status::Within {
            continue;
        }
        let by = found.derivatives(a, &motion_a, b, &motion_b);
        if by.status != Differentiability::Unique {
            flagged += 1;
            continue;
        }
        let bodies = pair.map(|index| &polytopes[index]);
        // The twist is the same at all times, about the origin of the frame at each.
        let truth = |which: usize, axis: usize, step: f64| {
            let poses = |t: f64| {
                let mut poses = [motion_a.pose_at(t), motion_b.pose_at(t)];
                poses[which] = twisted(poses[which], axis, step);
                poses
            };
            meeting(bodies, poses, 0.05, found.t)
        };
        let (mut off, mut greatest) = (0.0_f64, 0.0_f64);
        for (which, by) in [by.of_a, by.of_b].into_iter().enumerate() {
            for (axis, found) in by.to_array().into_iter().enumerate() {
                let step = 1e-5;
                let truth = (truth(which, axis, step) - truth(which, axis, -step)) / (2.0 * step);
                (off, greatest) = (off.max((found - truth).abs()), greatest.max(truth.abs()));
            }
        }
        // Later than the window of the bisection.
        if greatest * 1e-5 > 1e-4 {
            continue;
        }
        judged += 1;
        close += usize::from(off <= 1e-5 * greatest);
    }
    println!("{judged} judged, {close} of them within 1e-5; {flagged} flagged");
    assert!(judged > 100 && close * 100 >= judged * 97 && flagged * 20 < judged, "{judged}, {close}, {flagged}");
}

#[test]
fn parallel_features_have_no_derivative() {
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::ONE).unwrap();
    let status = |b_in_a: Pose| {
        distance(cube, cube, b_in_a, &Settings::default(), &mut Cache::new()).derivatives(cube, cube, b_in_a).status
    };
    assert_eq!(status(moved_to(3.0, 0.2, 0.1)), Differentiability::Parallel);
    // An edge over a face, across and along.
    let eighth = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
    assert_eq!(status(Pose::new(DVec3::new(4.0, 0.3, 0.1), eighth).unwrap()), Differentiability::Parallel);
    // Two parallel edges.
    assert_eq!(status(moved_to(3.0, 3.0, 0.5)), Differentiability::Parallel);
    // Crossing edges, two vertices, and a vertex over a face.
    let crossing = DQuat::from_axis_angle(DVec3::new(1.0, 1.0, 0.0).normalize(), 1.0);
    assert_eq!(status(Pose::new(DVec3::new(3.0, 3.0, 0.1), crossing).unwrap()), Differentiability::Unique);
    assert_eq!(status(moved_to(3.0, 3.0, 3.0)), Differentiability::Unique);
    let corner = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_X);
    assert_eq!(status(Pose::new(DVec3::new(4.0, 0.1, 0.2), corner).unwrap()), Differentiability::Unique);
    // Not separated.
    assert_eq!(status(moved_to(2.0, 0.0, 0.0)), Differentiability::Touching);
    assert_eq!(status(moved_to(0.5, 0.0, 0.0)), Differentiability::Touching);
}

#[test]
fn ambiguous_depths_have_no_derivative() {
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::ONE).unwrap();
    let ball: &(dyn Shape + Sync) = &Sphere::new(0.25).unwrap();
    let by = |b_in_a: Pose| {
        let found = contact(cube, ball, b_in_a, &EXACT, &mut Cache::new());
        found.derivatives(cube, ball, b_in_a, &EXACT, &mut Cache::new())
    };
    assert_eq!(by(Pose::IDENTITY).status, Differentiability::Normals);
    assert_eq!(by(moved_to(0.5, 0.5, 0.1)).status, Differentiability::Normals);
    let found = by(moved_to(0.5, 0.4, 0.1));
    assert_eq!(found.status, Differentiability::Unique);
    // Moved along x, the ball is less deep.
    assert!(found.of_b.linear.distance(DVec3::NEG_X) < 1e-9 && found.of_a.linear.distance(DVec3::X) < 1e-9);
    assert_eq!(by(moved_to(3.0, 0.0, 0.0)).status, Differentiability::Missing);
    assert_eq!(by(moved_to(1.25, 0.0, 0.0)).status, Differentiability::Touching);
    // Two cubes face to face are as deep at all points of both faces.
    let b_in_a = moved_to(1.5, 0.1, 0.2);
    let found = contact(cube, cube, b_in_a, &EXACT, &mut Cache::new());
    let status = found.derivatives(cube, cube, b_in_a, &EXACT, &mut Cache::new()).status;
    assert_eq!(status, Differentiability::Parallel);

    let point = |p: DVec3| {
        let found = signed_distance(cube, p, &EXACT, &mut Cache::new()).unwrap();
        found.derivatives(cube, p, &EXACT, &mut Cache::new())
    };
    assert_eq!(point(DVec3::ZERO).status, Differentiability::Normals);
    assert_eq!(point(DVec3::X).status, Differentiability::Touching);
    assert_eq!(point(DVec3::new(3.0, 2.0, 0.0)).status, Differentiability::Unique);
    let inside = point(DVec3::new(-0.5, 0.1, 0.2));
    assert_eq!(inside.status, Differentiability::Unique);
    assert!(inside.of_b.linear.distance(DVec3::NEG_X) < 1e-9 && inside.of_b.angular.length() < 1e-9);
}

/// What a contact knows of other normals, and an answer of its features, against the second query
/// and support queries, which mostly find the same without them.
#[test]
fn known_normals_and_features_change_no_status() {
    let (mut rng, mut different) = (SplitMix64::new(SEED + 2), 0);
    for vertices in [8, 16, 30, 100] {
        let points = [0, 1].map(|seed| families::rock(vertices, seed));
        let packs = points.map(|points| Pack::from_bytes(&packs::tree_bytes(&points)).unwrap());
        let [a, b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
        let (mut hits, mut known, mut unique) = (0, 0, 0);
        for _ in 0..400 {
            let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
            let b_in_a = Pose::new(DVec3::from_array(rng.direction()) * rng.between(0.2, 2.5), rotation).unwrap();
            let mut cache = Cache::new();
            let near = distance(&a, &b, b_in_a, &EXACT, &mut cache);
            let twin = Distance { features: [u32::MAX; 2], ..near };
            let by = near.derivatives(&a, &b, b_in_a);
            let expected = twin.derivatives(&a, &b, b_in_a);
            assert_eq!((by.of_a, by.of_b), (expected.of_a, expected.of_b), "seed {SEED:#x}: {b_in_a:?}");
            different += usize::from(by.status != expected.status);
            unique += usize::from(by.status == Differentiability::Unique);
            let found = contact(&a, &b, b_in_a, &EXACT, &mut cache);
            if !found.hit {
                continue;
            }
            let twin = Contact { is_only_normal: false, features: [u32::MAX; 2], ..found };
            let by = found.derivatives(&a, &b, b_in_a, &EXACT, &mut Cache::new());
            let expected = twin.derivatives(&a, &b, b_in_a, &EXACT, &mut Cache::new());
            assert_eq!((by.of_a, by.of_b), (expected.of_a, expected.of_b), "seed {SEED:#x}: {b_in_a:?} {found:?}");
            different += usize::from(by.status != expected.status);
            hits += 1;
            known += usize::from(found.is_only_normal);
        }
        println!("{vertices} vertices: {unique} distances unique, {known} of {hits} contacts know");
        assert!(unique > 100 && hits > 100 && known * 100 > hits * 95, "{unique}, {known} of {hits}");
    }
    // Of a face that is level just within the error of the normal, only some corners show it.
    assert!(different <= 2, "{different} statuses differ");
    // As deep along y as along x, and nearly so.
    let (cube, ball) = (Cuboid::new(DVec3::ONE).unwrap(), Cuboid::new(DVec3::splat(0.25)).unwrap());
    for (y, expected) in [(0.5, false), (0.499_999, false), (0.499, true)] {
        let found = any_shape::contact(&cube, &ball, moved_to(0.5, y, 0.1), &EXACT, &mut Cache::new());
        assert_eq!(found.is_only_normal, expected, "{found:?}");
    }
}

#[test]
fn rays_and_casts_without_a_derivative() {
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::ONE).unwrap();
    let settings = CastSettings::default();
    let by = |origin: DVec3, direction: DVec3| {
        let line = Ray::new(origin, direction).unwrap();
        ray(cube, &line, &settings).derivatives(cube, &line)
    };
    assert_eq!(by(DVec3::new(5.0, 0.0, 0.0), DVec3::X).status, Differentiability::Missing);
    assert_eq!(by(DVec3::new(0.5, 0.0, 0.0), DVec3::X).status, Differentiability::Missing);
    assert_eq!(by(DVec3::new(5.0, 5.0, 0.0), DVec3::new(-1.0, -1.0, 0.0)).status, Differentiability::Normals);
    assert_eq!(by(DVec3::new(5.0, 3.0, 0.5), DVec3::new(-4.0, -2.0, 0.0)).status, Differentiability::Normals);
    assert_eq!(by(DVec3::new(5.0, 5.0, 5.0), DVec3::NEG_ONE).status, Differentiability::Normals);
    assert_ne!(by(DVec3::new(5.0, 1.0, 0.0), DVec3::NEG_X).status, Differentiability::Unique);
    let found = by(DVec3::new(5.0, 0.5, 0.0), DVec3::new(-2.0, 0.0, 0.0));
    assert_eq!(found.status, Differentiability::Unique);
    // The ray turns about its origin, and t grows in the second order; the cube turns about z, and
    // its face at (1, 0.5, 0) recedes by half the angle.
    assert!((found.of_b.to_array()[0] - 0.5).abs() < 1e-9 && found.of_b.angular.length() < 1e-9);
    assert!((found.of_a.angular.z - 0.25).abs() < 1e-9);

    let start = moved_to(-5.0, 0.2, 0.3);
    for (velocity, expected) in [
        (DVec3::X, Differentiability::Parallel),
        // Past an edge of the difference, at (-2, -2), and away.
        (DVec3::new(3.0, -2.2, -0.3), Differentiability::Grazing),
        (DVec3::NEG_X, Differentiability::Missing),
        (DVec3::ZERO, Differentiability::Missing),
    ] {
        let velocity = Motion::new(velocity).unwrap();
        let found = cast(cube, cube, start, velocity, &settings, &mut Cache::new());
        assert_eq!(found.derivatives(cube, cube, start, velocity).status, expected, "{velocity:?}");
    }
    // It stays in touch, or passes for ever at the target distance.
    let still = RigidMotion::still(Pose::IDENTITY);
    let passing = RigidMotion::between(moved_to(-5.0, 3.0, 0.0), moved_to(5.0, 3.0, 0.0)).unwrap();
    let target = MotionSettings { target_distance: 1.0, ..MotionSettings::default() };
    let found = cast_motion(cube, &still, cube, &passing, &target, &mut Cache::new());
    assert_ne!(found.derivatives(cube, &still, cube, &passing).status, Differentiability::Unique, "{found:?}");
}
