//! The solver compared with brute force, on random hulls.

mod failure_modes;
pub mod shapes;

use self::shapes::PointCloud;
use crate::any_shape::{contact, distance, intersects};
use ::shapes::rng::SplitMix64;
use hullmap::{Cache, Pose, Settings, Status};
use hullmap_testkit::{depth::signed_depth_by_points, gap::distance_by_features, random::RandomPoses};

const SEED: u64 = 0x5eed_0001;

/// Error of brute force itself, for shapes of about unit size.
const TRUTH_ERROR: f64 = 1e-13;

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
        let truth = signed_depth_by_points(&a.points, &b.placed(pose));
        let limits = [0, 1, 2, 4, 8, 16, 32].map(|limit| Settings { max_iterations: limit, ..Settings::default() });
        if truth <= TRUTH_ERROR {
            let gap = distance_by_features(&a.points, &b.placed(pose));
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
