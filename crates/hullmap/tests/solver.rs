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
