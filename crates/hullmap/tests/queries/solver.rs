//! The solver compared with brute force, on random hulls.

mod failure_modes;
pub mod shapes;

use self::shapes::PointCloud;
use crate::any_shape::{contact, distance, intersects};
use ::shapes::rng::SplitMix64;
use glam::{DQuat, DVec3};
use hullmap::{Cache, Overlap, Pose, Settings, Status};
use hullmap_testkit::{
    depth::signed_depth_by_points, gap::distance_by_features, packs::tree_pack, random::RandomPoses, reach::way_out,
};
use proptest::prelude::*;

const SEED: u64 = 0x5eed_0001;

/// Error of brute force itself, for shapes of about unit size.
const TRUTH_ERROR: f64 = 1e-13;

/// Signed depth of two solids by brute force: negative if they are separated.
fn signed_depth(a: &PointCloud, b: &PointCloud, b_in_a: Pose) -> f64 {
    signed_depth_by_points(&a.points, &b.placed(b_in_a))
}

/// Distance of two hulls by brute force, if they are separated.
fn distance_apart(a: &PointCloud, b: &PointCloud, b_in_a: Pose) -> f64 {
    distance_by_features(&a.points, &b.placed(b_in_a))
}

/// A random pair of hulls and a pose: a third penetrates, a third is within 2 % of touching, a
/// third is anywhere near.
fn pair(rng: &mut SplitMix64) -> (PointCloud, PointCloud, Pose) {
    let hull = |rng: &mut SplitMix64| {
        let count = 4 + rng.below(9);
        let on_surface = rng.below(2) == 0;
        let cloud = PointCloud::random(rng, count, on_surface);
        // Half of them are far from the origin of their frame.
        if rng.below(2) == 0 { cloud } else { cloud.moved(rng.unit_vector() * 3.0) }
    };
    let (a, b) = (hull(rng), hull(rng));
    let rotation = rng.rotation();
    let direction = rng.unit_vector();
    let turned = Pose::new(DVec3::ZERO, rotation).unwrap();
    let center = a.interior - turned.transform_point(b.interior);
    // The distance of B's centre along `direction` at which the pair nearly touches, by bisection
    // of the signed depth.
    let at = |t: f64| Pose::new(center + direction * t, rotation).unwrap();
    let pose = match rng.below(3) {
        0 => at(rng.between(0.0, 0.5)),
        1 => {
            let (mut inside, mut outside) = (0.0, 3.0);
            for _ in 0..12 {
                let middle = 0.5 * (inside + outside);
                if signed_depth(&a, &b, at(middle)) > 0.0 { inside = middle } else { outside = middle }
            }
            at(inside * rng.between(0.98, 1.02))
        }
        _ => at(rng.between(0.3, 2.5)),
    };
    (a, b, pose)
}

#[test]
fn random_pairs_against_brute_force() {
    const PAIRS: usize = 1500;
    let settings = Settings::default();
    let mut rng = SplitMix64::new(SEED);
    let (mut hits, mut converged) = (0, 0);
    // A cache with features and polytopes of other pairs costs steps and never makes an answer
    // wrong.
    let mut shared = Cache::new();
    for i in 0..PAIRS {
        let seed = rng.state();
        let (a, b, pose) = pair(&mut rng);
        let truth = signed_depth(&a, &b, pose);
        let sure = truth.abs() > TRUTH_ERROR;
        let at = format!("pair {i}, seed {seed:#x}, truth {truth:e}");

        let yes = intersects(&a, &b, pose, &mut Cache::new());
        assert_ne!(yes.status, Overlap::Undecided, "{at}");
        if sure {
            assert_eq!(yes.is_hit(), truth > 0.0, "{at}: {yes:?}");
        }

        let c = contact(&a, &b, pose, &settings, &mut Cache::new());
        if sure {
            assert_eq!(c.hit, truth > 0.0, "{at}: {c:?}");
        }
        assert!((c.normal.length() - 1.0).abs() < 1e-14, "{at}: {c:?}");
        let stranger = contact(&a, &b, pose, &settings, &mut shared);
        let mirrored = contact(&b, &a, pose.inverse(), &settings, &mut Cache::new());
        for other in [stranger, mirrored] {
            assert!(!sure || other.hit == c.hit, "{at}: {c:?} {other:?}");
            assert!(c.depth_lower <= other.depth_upper && other.depth_lower <= c.depth_upper, "{at}: {c:?} {other:?}");
            assert!(!c.hit || other.depth_upper - other.depth_lower <= 1.01e-5 * c.depth_upper + 1e-12, "{at}");
        }
        if c.hit && c.depth > 1e-9 {
            // The mirrored normal is as good: the support value along it is the depth within the
            // tolerance.
            let along = way_out(&a.points[..], &b.placed(pose)[..], -pose.transform_vector(mirrored.normal));
            assert!((along - c.depth).abs() <= 2e-5 * c.depth + 1e-12, "{at}: {c:?} {mirrored:?}");
        }
        if c.hit {
            assert!(c.depth_lower <= truth + TRUTH_ERROR && truth - TRUTH_ERROR <= c.depth_upper, "{at}: {c:?}");
            assert!(c.depth_lower <= c.depth && c.depth <= c.depth_upper, "{at}: {c:?}");
            assert!(!matches!(c.status, Status::IterationLimit | Status::Stalled), "{at}: {c:?}");
            assert!(c.depth_upper - c.depth_lower <= 1.01e-5 * c.depth_upper + 1e-12, "{at}: {c:?}");
            // Moving B along the normal by the depth makes the shapes touch.
            let away = |by: f64| Pose::new(pose.translation() + c.normal * by, pose.rotation()).unwrap();
            assert!(signed_depth(&a, &b, away(c.depth + 1e-9)) < 0.0, "{at}: {c:?}");
            assert!(signed_depth(&a, &b, away(c.depth * 0.99 - 1e-9)) > 0.0, "{at}: {c:?}");
            // The witness points are opposite each other along the normal.
            let off = (c.point_a - c.point_b).distance(c.normal * c.depth);
            assert!(off <= c.depth_upper - c.depth_lower + 1e-12, "{at}: {off:e}, {c:?}");
            hits += 1;
        } else {
            assert_eq!(c.status, Status::Separated, "{at}");
        }

        let gap = distance(&a, &b, pose, &settings, &mut Cache::new());
        if sure {
            assert_eq!(
                gap.status == Status::Overlapping || gap.status == Status::Touching,
                truth > 0.0,
                "{at}: {gap:?}"
            );
        }
        let stranger = distance(&a, &b, pose, &settings, &mut shared);
        let mirrored = distance(&b, &a, pose.inverse(), &settings, &mut Cache::new());
        let meet = [stranger, mirrored].iter().all(|other| gap.lower <= other.upper && other.lower <= gap.upper);
        assert!(meet, "{at}: {gap:?} {stranger:?} {mirrored:?}");
        let by_shared = intersects(&a, &b, pose, &mut shared).is_hit();
        assert!(!sure || by_shared == (truth > 0.0), "{at}");
        if truth < -TRUTH_ERROR {
            let far = distance_apart(&a, &b, pose);
            assert!(gap.lower <= far + TRUTH_ERROR && far - TRUTH_ERROR <= gap.upper, "{at}, far {far}: {gap:?}");
            assert!(gap.upper - gap.lower <= 1.01e-5 * gap.upper + 1e-12, "{at}: {gap:?}");
            assert!(((gap.point_b - gap.point_a) - gap.normal * gap.distance).length() < 1e-12, "{at}: {gap:?}");
            converged += usize::from(matches!(gap.status, Status::Exact | Status::Within));
        } else {
            assert!((gap.point_b - gap.point_a).length() < 1e-12, "{at}: {gap:?}");
        }
    }
    let share = hits as f64 / PAIRS as f64;
    assert!((0.3..0.7).contains(&share), "not representative: {share} of the pairs overlap");
    assert_eq!(converged, PAIRS - hits, "distances that did not converge");
}

/// More iterations only narrow the interval, and it always contains the depth or the distance. The
/// limit is a status.
#[test]
fn more_iterations_narrow_the_interval() {
    let mut rng = SplitMix64::new(SEED + 10);
    let mut widths = [0.0; 7];
    let (mut hits, mut too_large, mut limited, mut misses, mut far_limited) = (0, 0, 0, 0, 0);
    for i in 0..200 {
        let seed = rng.state();
        let (a, b) = (PointCloud::random(&mut rng, 12, true), PointCloud::random(&mut rng, 12, true));
        let pose = rng.pose(1.5);
        let truth = signed_depth(&a, &b, pose);
        let limits = [0, 1, 2, 4, 8, 16, 32].map(|limit| Settings { max_iterations: limit, ..Settings::default() });
        if truth <= TRUTH_ERROR {
            let gap = distance_apart(&a, &b, pose);
            for settings in &limits[..3] {
                assert!(!contact(&a, &b, pose, settings, &mut Cache::new()).hit || truth > -TRUTH_ERROR, "pair {i}");
                let d = distance(&a, &b, pose, settings, &mut Cache::new());
                misses += 1;
                far_limited += usize::from(d.status == Status::IterationLimit);
                assert!(d.lower <= gap + TRUTH_ERROR && gap <= d.upper + TRUTH_ERROR && d.upper < 10.0, "{gap} {d:?}");
            }
            continue;
        }
        hits += 1;
        let mut before = (0.0, f64::INFINITY);
        for (number, settings) in limits.iter().enumerate() {
            let c = contact(&a, &b, pose, settings, &mut Cache::new());
            let at = format!("pair {i}, seed {seed:#x}, {settings:?}, truth {truth:e}: {c:?}");
            assert!(c.hit && c.depth_lower <= truth + TRUTH_ERROR && truth <= c.depth_upper + TRUTH_ERROR, "{at}");
            // The minimum offset may decrease when faces are replaced, by the rounding error of
            // slivers.
            assert!(c.depth_lower >= before.0 - 1e-9 && c.depth_upper <= before.1 && c.depth_upper < 10.0, "{at}");
            // Without iterations, the bounds come from the centre ray.
            if number > 0 {
                before = (c.depth_lower, c.depth_upper);
            }
            widths[number] += (c.depth_upper - c.depth_lower) / c.depth_upper;
            too_large += usize::from(number == 0 && c.depth_upper > 1.01 * truth);
            limited += usize::from(number < 3 && c.status == Status::IterationLimit);
        }
    }
    println!("{hits} hits, mean widths {:?}", widths.map(|w| w / hits as f64));
    assert!(hits > 60, "not representative: {hits} of 200 overlap");
    assert!(widths[1..].is_sorted_by(|wide, narrow| wide >= narrow) && widths[6] < 1e-2 * widths[1], "{widths:?}");
    assert!(too_large * 4 > hits, "{too_large} of {hits}: EPA would be pointless");
    assert!(limited * 2 > 3 * hits && far_limited * 4 > misses, "{limited} of {hits}, {far_limited} of {misses}");
}

/// Points of a small grid, with many duplicate, collinear and coplanar points. The rank is 0 to 3.
fn grid_cloud() -> impl Strategy<Value = PointCloud> {
    let point = (-2..=2_i32, -2..=2_i32, -2..=2_i32).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()));
    prop::collection::vec(point, 1..9).prop_map(PointCloud::new)
}

/// Poses that map the grid to a grid, and others that do not.
fn grid_pose() -> impl Strategy<Value = Pose> {
    let step = || (-8..=8_i32).prop_map(|i| f64::from(i) / 2.0);
    let turn = || (-1..=1_i32).prop_map(f64::from);
    (step(), step(), step(), turn(), turn(), turn())
        .prop_map(|(x, y, z, i, j, k)| Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, 1.0)).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn degenerate_hulls_have_consistent_answers(a in grid_cloud(), b in grid_cloud(), pose in grid_pose()) {
        let settings = Settings::default();
        let yes = intersects(&a, &b, pose, &mut Cache::new());
        let c = contact(&a, &b, pose, &settings, &mut Cache::new());
        let d = distance(&a, &b, pose, &settings, &mut Cache::new());
        prop_assert!(yes.status != Overlap::Undecided, "{:?}", yes);
        prop_assert!(!matches!(c.status, Status::IterationLimit | Status::Stalled), "{:?}", c);
        prop_assert!(!matches!(d.status, Status::IterationLimit | Status::Stalled), "{:?}", d);
        prop_assert_eq!(yes.is_hit(), c.hit);
        prop_assert_eq!(yes.is_hit(), matches!(d.status, Status::Overlapping | Status::Touching), "{:?}", d);
        // Distances and depths on the grid are far above rounding error, so all queries agree on
        // touching too.
        prop_assert_eq!(yes.status == Overlap::Touching, c.status == Status::Touching, "{:?} {:?}", yes, c);
        prop_assert_eq!(yes.status == Overlap::Touching, d.status == Status::Touching, "{:?} {:?}", yes, d);
        // Checks the claims of the normals by a linear scan.
        let placed = b.placed(pose);
        let value = |n: DVec3| way_out(&a.points[..], &placed[..], n);
        let truth = signed_depth(&a, &b, pose);
        if c.hit {
            prop_assert!((value(c.normal) - c.depth).abs() < 1e-12, "{:?}", c);
            prop_assert!(c.depth_upper - c.depth_lower <= 1.01e-5 * c.depth_upper + 1e-12, "{:?}", c);
            prop_assert!(!truth.is_finite() || c.depth_lower <= truth.max(0.0) + 1e-12, "{} {:?}", truth, c);
        } else {
            prop_assert!(value(c.normal) < 0.0, "{:?}", c);
            prop_assert!(value(d.normal) <= -0.999 * d.lower && d.lower > 0.0, "{:?}", d);
            prop_assert!((distance_apart(&a, &b, pose) - d.distance).abs() <= 1e-5 * d.distance + 1e-12, "{:?}", d);
        }
        // Baked hulls of these points have the same answers.
        let packs = [&a, &b].map(|cloud| {
            tree_pack(&cloud.points.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>())
        });
        let [of_a, of_b] = packs.each_ref().map(|pack| pack.hull(0).unwrap());
        let error = 1e-10;
        let deep = contact(&of_a, &of_b, pose, &settings, &mut Cache::new());
        let near = distance(&of_a, &of_b, pose, &settings, &mut Cache::new());
        let is_hit = intersects(&of_a, &of_b, pose, &mut Cache::new()).is_hit();
        if truth.is_finite() && truth.abs() > error {
            prop_assert_eq!([deep.hit, is_hit, near.status == Status::Overlapping], [truth > 0.0; 3], "{}", truth);
        }
        if deep.hit {
            prop_assert!(deep.depth_lower <= c.depth_upper + error && c.depth_lower <= deep.depth_upper + error);
            prop_assert!(value(deep.normal) <= deep.depth_upper + error, "{:?}", deep);
        } else {
            prop_assert!(value(deep.normal) <= error, "{:?}", deep);
        }
        prop_assert!(near.lower <= d.upper + error && d.lower <= near.upper + error, "{:?} {:?}", near, d);
    }
}

/// Kenwright, 4.6: the points that a miss has seen speed up a distance query, in the same frame or
/// the next.
#[test]
fn distance_continues_from_a_miss() {
    let settings = Settings::default();
    let mut rng = SplitMix64::new(SEED + 7);
    let (mut after, mut cold, mut next, mut misses) = (0, 0, 0, 0);
    for _ in 0..300 {
        let (a, b) = (PointCloud::random(&mut rng, 60, true), PointCloud::random(&mut rng, 60, true));
        let pose = rng.pose(1.6);
        let mut cache = Cache::new();
        let yes = intersects(&a, &b, pose, &mut cache);
        if yes.is_hit() || yes.support_calls == 0 {
            continue;
        }
        misses += 1;
        let d = distance(&a, &b, pose, &settings, &mut cache.clone());
        let alone = distance(&a, &b, pose, &settings, &mut Cache::new());
        assert!(d.lower <= alone.upper && alone.lower <= d.upper, "{d:?} {alone:?}");
        let moved = Pose::new(pose.translation() + rng.unit_vector() * 0.01, pose.rotation()).unwrap();
        next += distance(&a, &b, moved, &settings, &mut cache).support_calls;
        (after, cold) = (after + d.support_calls, cold + alone.support_calls);
    }
    println!(
        "{misses} misses: {cold} calls for a cold distance query, {after} after an intersection test, {next} one frame later"
    );
    assert!(misses > 50, "not representative: {misses} misses");
    assert!(f64::from(after) < 0.9 * f64::from(cold) && f64::from(next) < 0.95 * f64::from(cold));
}
