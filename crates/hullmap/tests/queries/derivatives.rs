//! Derivatives of answers by poses: against central differences, and where there are none. The soak
//! of derivatives judges distances, depths, rays and casts of hulls.

use crate::any_shape;
use crate::compound::pack;
use crate::motions_of_parts::motion;
use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Scaled, Sphere};
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

/// Curved and flat shapes: rims, sides, tips, caps, ellipsoids, edges and vertices.
fn round_shapes(pack: &Pack) -> Vec<Box<dyn Shape + Sync + '_>> {
    let [cylinder, cone] = [(0.5, 0.6), (0.4, 0.7)];
    let (cylinder, cone) = (Cylinder::new(cylinder.0, cylinder.1).unwrap(), Cone::new(cone.0, cone.1).unwrap());
    let (capsule, cuboid) = (Capsule::new(0.8, 0.3).unwrap(), Cuboid::new(DVec3::new(0.4, 0.6, 0.9)).unwrap());
    let scale = DVec3::new(1.2, 0.5, -0.8);
    vec![
        Box::new(cylinder),
        Box::new(cone),
        Box::new(Cylinder::new(0.0, 0.7).unwrap()),
        Box::new(Cylinder::new(0.9, 0.01).unwrap()),
        Box::new(Rounded::new(cylinder, 0.2).unwrap()),
        Box::new(Rounded::new(cuboid, 0.2).unwrap()),
        Box::new(Scaled::new(Sphere::new(0.7).unwrap(), scale).unwrap()),
        Box::new(Scaled::new(cylinder, scale).unwrap()),
        Box::new(Scaled::new(cone, scale).unwrap()),
        Box::new(Scaled::new(capsule, scale).unwrap()),
        Box::new(Sphere::new(0.7).unwrap()),
        Box::new(capsule),
        Box::new(cuboid),
        Box::new(pack.hull(0).unwrap()),
    ]
}

/// Central difference of order 4, and how much it differs from one with half of the step.
fn slope(step: f64, value: impl Fn(f64) -> Option<f64>) -> Option<[f64; 2]> {
    let of = |h: f64| {
        let [near, far] = [h, 2.0 * h].map(|h| Some(value(h)? - value(-h)?));
        Some((8.0 * near? - far?) / (12.0 * h))
    };
    let (whole, half) = (of(step)?, of(0.5 * step)?);
    Some([half, (whole - half).abs()])
}

/// Errors of derivatives that are called unique, by both poses, against central differences of
/// certified lengths.
#[derive(Default)]
struct Judged {
    unique: usize,
    flagged: usize,
    judged: usize,
    worst: f64,
}

impl Judged {
    fn add(&mut self, found: &Derivatives, poses: [Pose; 2], value: impl Fn([Pose; 2]) -> Option<f64>) {
        if found.status != Differentiability::Unique {
            self.flagged += 1;
            return;
        }
        self.unique += 1;
        let mut worst = 0.0_f64;
        for (which, by) in [found.by_a, found.by_b].into_iter().enumerate() {
            for (axis, found) in by.to_array().into_iter().enumerate() {
                let truth = slope(5e-4, |step| {
                    let mut moved = poses;
                    moved[which] = twisted(poses[which], axis, step);
                    value(moved)
                });
                // Another feature is nearest within the step.
                let Some([truth, _]) = truth.filter(|[_, doubt]| *doubt < 1e-9) else { return };
                worst = worst.max((found - truth).abs());
            }
        }
        self.judged += 1;
        self.worst = self.worst.max(worst);
    }

    /// Asserts that no derivative is off by more than `most`, and that at most one in `rare` is
    /// flagged.
    fn assert(self, tolerance: f64, most: f64, rare: usize) {
        let Self { unique, flagged, judged, worst } = self;
        println!("tolerance {tolerance}: {unique} unique, {flagged} flagged, {judged} judged, off by {worst:e}");
        assert!(worst < most, "off by {worst:e} with a tolerance of {tolerance}, seed {SEED:#x}");
        assert!(judged > 400 && flagged * rare < unique, "{unique} unique, {flagged} flagged, {judged} judged");
    }
}

/// The middle of an interval, if it is as narrow as rounding allows.
fn certified(lower: f64, upper: f64) -> Option<f64> {
    (upper - lower < 1e-12).then_some(0.5 * (lower + upper))
}

/// Gradients of curved shapes were as inaccurate as the square root of the tolerance, and were
/// called unique.
#[test]
fn gradients_of_curved_shapes_are_exact_for_every_tolerance() {
    let pack = packs::tree_pack(&families::rock(20, 3));
    let shapes = round_shapes(&pack);
    let mut rng = SplitMix64::new(SEED);
    for tolerance in [1e-3, 1e-5, 1e-8, 0.0] {
        let settings = Settings { tolerance, ..Settings::default() };
        let (mut apart, mut deep) = (Judged::default(), Judged::default());
        for number in 0..1500 {
            let (a, b) = (&*shapes[rng.below(14)], &*shapes[rng.below(14)]);
            let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
            let reach = if number % 2 == 0 { rng.between(1.5, 5.0) } else { rng.between(0.1, 1.0) };
            let b_in_a = Pose::new(DVec3::from_array(rng.direction()) * reach, rotation).unwrap();
            let poses = [Pose::IDENTITY, b_in_a];
            let relative = |[a, b]: [Pose; 2]| Pose::relative(a, b).unwrap();
            let found = any_shape::distance(a, b, b_in_a, &settings, &mut Cache::new());
            if found.lower > 1e-2 {
                let by = found.derivatives(a, b, b_in_a);
                apart.add(&by, poses, |poses| {
                    let found = any_shape::distance(a, b, relative(poses), &EXACT, &mut Cache::new());
                    certified(found.lower, found.upper)
                });
            }
            let mut cache = Cache::new();
            let found = any_shape::contact(a, b, b_in_a, &settings, &mut cache);
            if found.depth_lower > 1e-2 {
                let by = found.derivatives(a, b, b_in_a, &settings, &mut cache);
                deep.add(&by, poses, |poses| {
                    let found = any_shape::contact(a, b, relative(poses), &EXACT, &mut Cache::new());
                    certified(found.depth_lower, found.depth_upper)
                });
            }
        }
        // Rounding errors of the lengths count as 1e-14 of the step's inverse.
        [apart, deep].into_iter().for_each(|found| found.assert(tolerance, 2e-9, 5));
    }
}

/// Times of rays and casts at curved shapes.
#[test]
fn times_of_rays_and_casts_at_curved_shapes_have_exact_derivatives() {
    let pack = packs::tree_pack(&families::rock(20, 3));
    let shapes = round_shapes(&pack);
    let exact = CastSettings { tolerance: 0.0, ..CastSettings::default() };
    let mut rng = SplitMix64::new(SEED + 3);
    for tolerance in [1e-3, 1e-6, 0.0] {
        let settings = CastSettings { tolerance, ..exact };
        let (mut rays, mut casts) = (Judged::default(), Judged::default());
        for _ in 0..1200 {
            let (a, b) = (&*shapes[rng.below(14)], &*shapes[rng.below(14)]);
            let origin = DVec3::from_array(rng.direction()) * 4.0;
            let velocity = DVec3::from_array(rng.direction()) * rng.between(0.0, 0.6) - origin;
            let line = Ray::new(origin, velocity).unwrap();
            let hit = any_shape::ray(a, &line, &settings);
            if matches!(hit.status, Status::Exact | Status::Within) {
                rays.add(
                    &hit.derivatives(a, &line),
                    [Pose::IDENTITY, moved_to(origin.x, origin.y, origin.z)],
                    |poses| {
                        let ray = Pose::relative(poses[0], poses[1]).unwrap();
                        let line = Ray::new(ray.translation(), ray.transform_vector(velocity)).unwrap();
                        let hit = any_shape::ray(a, &line, &exact);
                        certified(hit.t_lower, hit.t_upper)
                    },
                );
            }
            let rotation = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.0));
            let (start, motion) = (Pose::new(origin, rotation).unwrap(), Motion::new(velocity).unwrap());
            let found = any_shape::cast(a, b, start, motion, &settings, &mut Cache::new());
            if matches!(found.status, Status::Exact | Status::Within) {
                let at_impact = Pose::new(origin + velocity * found.t, rotation).unwrap();
                casts.add(&found.derivatives(a, b, start, motion), [Pose::IDENTITY, at_impact], |[a_now, b_now]| {
                    let start = Pose::new(b_now.translation() - velocity * found.t, b_now.rotation()).unwrap();
                    let start = Pose::relative(a_now, start).unwrap();
                    let motion = Motion::new(a_now.inverse_transform_vector(velocity)).unwrap();
                    let found = any_shape::cast(a, b, start, motion, &exact, &mut Cache::new());
                    certified(found.t_lower, found.t_upper)
                });
            }
        }
        [rays, casts].into_iter().for_each(|found| found.assert(tolerance, 4e-9, 20));
    }
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
        for (which, by) in [by.by_a, by.by_b].into_iter().enumerate() {
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
    use Differentiability::{Parallel, Touching, Unique};
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::ONE).unwrap();
    let eighth = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
    let crossing = DQuat::from_axis_angle(DVec3::new(1.0, 1.0, 0.0).normalize(), 1.0);
    let corner = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_X);
    for (name, at, turn, expected) in [
        ("two faces", [3.0, 0.2, 0.1], DQuat::IDENTITY, Parallel),
        ("an edge over a face", [4.0, 0.3, 0.1], eighth, Parallel),
        ("two parallel edges", [3.0, 3.0, 0.5], DQuat::IDENTITY, Parallel),
        ("crossing edges", [3.0, 3.0, 0.1], crossing, Unique),
        ("two vertices", [3.0, 3.0, 3.0], DQuat::IDENTITY, Unique),
        ("a vertex over a face", [4.0, 0.1, 0.2], corner, Unique),
        ("touching", [2.0, 0.0, 0.0], DQuat::IDENTITY, Touching),
        ("overlapping", [0.5, 0.0, 0.0], DQuat::IDENTITY, Touching),
    ] {
        let b_in_a = Pose::new(DVec3::from_array(at), turn).unwrap();
        let found = distance(cube, cube, b_in_a, &Settings::default(), &mut Cache::new());
        assert_eq!(found.derivatives(cube, cube, b_in_a).status, expected, "{name}");
    }
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
    assert!(found.by_b.linear.distance(DVec3::NEG_X) < 1e-9 && found.by_a.linear.distance(DVec3::X) < 1e-9);
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
    assert!(inside.by_b.linear.distance(DVec3::NEG_X) < 1e-9 && inside.by_b.angular.length() < 1e-9);
}

/// Compares what a contact and an answer know of other normals and features with the second query
/// and support queries, which mostly find the same without them.
#[test]
fn known_normals_and_features_change_no_status() {
    let (mut rng, mut different) = (SplitMix64::new(SEED + 2), 0);
    for vertices in [8, 16, 30, 100] {
        let points = [0, 1].map(|seed| families::rock(vertices, seed));
        let packs = points.map(|points| packs::tree_pack(&points));
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
            assert_eq!((by.by_a, by.by_b), (expected.by_a, expected.by_b), "seed {SEED:#x}: {b_in_a:?}");
            different += usize::from(by.status != expected.status);
            unique += usize::from(by.status == Differentiability::Unique);
            let found = contact(&a, &b, b_in_a, &EXACT, &mut cache);
            if !found.hit {
                continue;
            }
            let twin = Contact { is_only_normal: false, features: [u32::MAX; 2], ..found };
            let by = found.derivatives(&a, &b, b_in_a, &EXACT, &mut Cache::new());
            let expected = twin.derivatives(&a, &b, b_in_a, &EXACT, &mut Cache::new());
            assert_eq!((by.by_a, by.by_b), (expected.by_a, expected.by_b), "seed {SEED:#x}: {b_in_a:?} {found:?}");
            different += usize::from(by.status != expected.status);
            hits += 1;
            known += usize::from(found.is_only_normal);
        }
        println!("{vertices} vertices: {unique} distances unique, {known} of {hits} contacts know");
        assert!(unique > 100 && hits > 100 && known * 100 > hits * 95, "{unique}, {known} of {hits}");
    }
    // If a face is level just within the error of the normal, only some corners show it.
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
    assert!((found.by_b.to_array()[0] - 0.5).abs() < 1e-9 && found.by_b.angular.length() < 1e-9);
    assert!((found.by_a.angular.z - 0.25).abs() < 1e-9);

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
