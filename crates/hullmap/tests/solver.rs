//! The solver against brute force, on random hulls.

mod shapes;
mod truth;

use glam::DVec3;
use hullmap::{Cache, Overlap, Pose, Settings, Status, contact, distance, intersects};
use shapes::{PointCloud, Rng};
use truth::{distance_apart, signed_depth};

const SEED: u64 = 0x5eed_0001;

/// What brute force itself may be wrong by, for shapes of about unit size.
const TRUTH_ERROR: f64 = 1e-13;

/// A pair of hulls, placed; a third deep, a third within 2 % of touching, a third anywhere near.
fn pair(rng: &mut Rng) -> (PointCloud, PointCloud, Pose) {
    let mut hull = |rng: &mut Rng| {
        let count = 4 + rng.below(9);
        let on_surface = rng.below(2) == 0;
        let cloud = PointCloud::random(rng, count, on_surface);
        // Half of them away from their frame's origin.
        if rng.below(2) == 0 {
            cloud
        } else {
            cloud.moved(rng.direction() * 3.0)
        }
    };
    let (a, b) = (hull(rng), hull(rng));
    let rotation = rng.rotation();
    let direction = rng.direction();
    let turned = Pose::new(DVec3::ZERO, rotation).unwrap();
    let center = a.interior - turned.transform_point(b.interior);
    // How far B's centre goes along `direction` until it touches, nearly: by bisection of the truth's sign.
    let at = |t: f64| Pose::new(center + direction * t, rotation).unwrap();
    let pose = match rng.below(3) {
        0 => at(rng.range(0.0, 0.5)),
        1 => {
            let (mut inside, mut outside) = (0.0, 3.0);
            for _ in 0..12 {
                let middle = 0.5 * (inside + outside);
                if signed_depth(&a, &b, at(middle)) > 0.0 {
                    inside = middle
                } else {
                    outside = middle
                }
            }
            at(inside * rng.range(0.98, 1.02))
        }
        _ => at(rng.range(0.3, 2.5)),
    };
    (a, b, pose)
}

#[test]
fn random_pairs_against_brute_force() {
    const PAIRS: usize = 1500;
    let settings = Settings::default();
    let mut rng = Rng(SEED);
    let (mut hits, mut converged) = (0, 0);
    for i in 0..PAIRS {
        let seed = rng.0;
        let (a, b, pose) = pair(&mut rng);
        let truth = signed_depth(&a, &b, pose);
        let sure = truth.abs() > TRUTH_ERROR;
        let at = format!("pair {i}, seed {seed:#x}, truth {truth:e}");

        let yes = intersects(&a, &b, pose, &mut Cache::new());
        assert_ne!(yes.status, Overlap::Undecided, "{at}");
        if sure {
            assert_eq!(yes.is_hit(), truth > 0.0, "{at}: {yes:?}");
        }

        let deep = contact(&a, &b, pose, &settings, &mut Cache::new());
        if sure {
            assert_eq!(deep.hit, truth > 0.0, "{at}: {deep:?}");
        }
        assert!((deep.normal.length() - 1.0).abs() < 1e-14, "{at}: {deep:?}");
        if deep.hit {
            assert!(
                deep.depth_lower <= truth + TRUTH_ERROR && truth - TRUTH_ERROR <= deep.depth_upper,
                "{at}: {deep:?}"
            );
            assert!(
                deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper,
                "{at}: {deep:?}"
            );
            assert!(
                !matches!(deep.status, Status::IterationLimit | Status::Stalled),
                "{at}: {deep:?}"
            );
            assert!(
                deep.depth_upper - deep.depth_lower <= 1.01e-5 * deep.depth_upper + 1e-12,
                "{at}: {deep:?}"
            );
            // Moving B along the normal by the depth leaves them touching.
            let away = |by: f64| {
                Pose::new(pose.translation() + deep.normal * by, pose.rotation()).unwrap()
            };
            assert!(
                signed_depth(&a, &b, away(deep.depth + 1e-9)) < 0.0,
                "{at}: {deep:?}"
            );
            assert!(
                signed_depth(&a, &b, away(deep.depth * 0.99 - 1e-9)) > 0.0,
                "{at}: {deep:?}"
            );
            // The points lie across from each other along the normal.
            let along = deep.point_a - deep.point_b;
            assert!(
                (along - deep.normal * deep.depth).length() <= 0.02 * deep.depth + 1e-9,
                "{at}: {deep:?}"
            );
            hits += 1;
        } else {
            assert_eq!(deep.status, Status::Separated, "{at}");
        }

        let gap = distance(&a, &b, pose, &settings, &mut Cache::new());
        if sure {
            assert_eq!(
                gap.status == Status::Overlapping || gap.status == Status::Touching,
                truth > 0.0,
                "{at}: {gap:?}"
            );
        }
        if truth < -TRUTH_ERROR {
            let far = distance_apart(&a, &b, pose);
            assert!(
                gap.lower <= far + TRUTH_ERROR && far - TRUTH_ERROR <= gap.upper,
                "{at}, far {far}: {gap:?}"
            );
            assert!(
                gap.upper - gap.lower <= 1.01e-5 * gap.upper + 1e-12,
                "{at}: {gap:?}"
            );
            assert!(
                ((gap.point_b - gap.point_a) - gap.normal * gap.distance).length() < 1e-12,
                "{at}: {gap:?}"
            );
            converged += usize::from(matches!(gap.status, Status::Exact | Status::Within));
        } else {
            assert!(
                (gap.point_b - gap.point_a).length() < 1e-12,
                "{at}: {gap:?}"
            );
        }
    }
    let share = hits as f64 / PAIRS as f64;
    assert!(
        (0.3..0.7).contains(&share),
        "not representative: {share} of the pairs overlap"
    );
    assert_eq!(converged, PAIRS - hits, "distances that did not converge");
}

/// Support calls and steps, and how often the interval is right, over larger hulls: `cargo test --release -- --ignored --nocapture`.
#[test]
#[ignore = "prints figures"]
fn figures() {
    let settings = Settings::default();
    println!(
        "{:>6} {:>9} {:>6} | {:>23} | {:>23} | {:>23} | not converged",
        "n", "what", "pairs", "intersects calls", "distance calls", "contact calls"
    );
    for n in [8, 32, 128, 512, 2048, 8192] {
        for (what, from, to) in [
            ("deep", 0.0, 0.5),
            ("touching", 0.98, 1.02),
            ("apart", 1.2, 2.0),
        ] {
            let mut rng = Rng(SEED);
            let mut calls = [const { Vec::new() }; 3];
            let mut steps = Vec::new();
            let (mut open, mut hits) = (0, 0);
            for _ in 0..200 {
                let (a, b) = (
                    PointCloud::random(&mut rng, n, true),
                    PointCloud::random(&mut rng, n, true),
                );
                let (rotation, direction) = (rng.rotation(), rng.direction());
                let at = |t: f64| Pose::new(direction * t, rotation).unwrap();
                let (mut inside, mut outside) = (0.0, 3.0);
                for _ in 0..20 {
                    let middle = 0.5 * (inside + outside);
                    if intersects(&a, &b, at(middle), &mut Cache::new()).is_hit() {
                        inside = middle
                    } else {
                        outside = middle
                    }
                }
                let pose = at(inside * rng.range(from, to));
                calls[0].push(intersects(&a, &b, pose, &mut Cache::new()).support_calls);
                calls[1].push(distance(&a, &b, pose, &settings, &mut Cache::new()).support_calls);
                let c = contact(&a, &b, pose, &settings, &mut Cache::new());
                calls[2].push(c.support_calls);
                steps.push(c.iterations);
                hits += usize::from(c.hit);
                open += usize::from(matches!(c.status, Status::IterationLimit | Status::Stalled));
            }
            let [i, d, c] = calls.map(|mut v| {
                v.sort_unstable();
                format!(
                    "{:>5.1} {:>5} {:>5} {:>5}",
                    v.iter().sum::<u32>() as f64 / v.len() as f64,
                    v[v.len() / 2],
                    v[v.len() * 99 / 100],
                    v[v.len() - 1]
                )
            });
            println!("{n:>6} {what:>9} {hits:>6} | {i} | {d} | {c} | {open}");
        }
    }
}
