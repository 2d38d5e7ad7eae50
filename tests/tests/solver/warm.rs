//! Warm queries on baked hulls: the answers of cold ones, at a fraction of their cost.

use glam::DQuat;
use hullmap::{Cache, Pose, Settings, contact, distance, intersects};
use hullmap_testkit::{faceless::Faceless, packs::tree_pack, random::RandomPoses};
use hullmap_tests::soak::body::Any;
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_121;

/// Maximum ratio of support calls with the cache of the previous frame to calls without it: for
/// contact, distance and intersection.
const WARM_SHARES: [f64; 3] = [0.5, 0.65, 0.9];

/// Each frame moves B by 1 % of the diameter and 1°. The answers equal a cold start's, at a
/// fraction of its cost. Contacts are counted against the general path: the separating axis test of
/// small hulls takes few support calls from any start.
#[test]
fn consecutive_frames_are_cheap() {
    let settings = Settings::default();
    let mut rng = SplitMix64::new(SEED);
    for n in [8, 32, 128, 512, 2048] {
        let families = [Family::Sphere, Family::ClusteredEllipsoid, Family::Rock];
        let packs = families.map(|family| tree_pack(&family.points(n, SEED)));
        let hulls = packs.each_ref().map(|pack| pack.hull(0).unwrap());
        let mut calls = [[0_u32; 2]; 3];
        let (mut hits, mut frames) = (0, 0);
        for pair in 0..12 {
            let (a, b) = (&hulls[pair % 3], &hulls[pair / 3 % 3]);
            let size = 0.5 * (a.diameter() + b.diameter());
            let (axis, beside) = (rng.unit_vector(), rng.unit_vector() * 0.2);
            let from = rng.unit_vector();
            let mut rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
            let mut caches = [(); 3].map(|()| Cache::default());
            for frame in 0..160 {
                rotation = (DQuat::from_axis_angle(axis, 1_f64.to_radians()) * rotation).normalize();
                let offset = (from * (1.4 - 0.01 * f64::from(frame)) + beside) * size;
                let pose = Pose::new(a.centroid() - rotation * b.centroid() + offset, rotation).unwrap();
                let what = format!("{} / {}, n {n}, pair {pair}, frame {frame}, seed {SEED}", a.name(), b.name());

                let warm = contact(a, b, pose, &settings, &mut caches[0]);
                let (hidden_a, hidden_b): (&Any<'_>, &Any<'_>) = (&Faceless(*a), &Faceless(*b));
                let general = contact(hidden_a, hidden_b, pose, &settings, &mut Cache::default());
                for cold in [contact(a, b, pose, &settings, &mut Cache::default()), general] {
                    assert_eq!(warm.hit, cold.hit, "{what}: {warm:?} {cold:?}");
                    let meet = warm.depth_lower <= cold.depth_upper && cold.depth_lower <= warm.depth_upper;
                    assert!(meet, "{what}: {warm:?} {cold:?}");
                }
                let cold = general;
                calls[0] = [calls[0][0] + warm.support_calls, calls[0][1] + cold.support_calls];
                (hits, frames) = (hits + usize::from(cold.hit), frames + 1);

                let warm = distance(a, b, pose, &settings, &mut caches[1]);
                let cold = distance(a, b, pose, &settings, &mut Cache::default());
                assert!(warm.lower <= cold.upper && cold.lower <= warm.upper, "{what}: {warm:?} {cold:?}");
                calls[1] = [calls[1][0] + warm.support_calls, calls[1][1] + cold.support_calls];

                let warm = intersects(a, b, pose, &mut caches[2]);
                let cold = intersects(a, b, pose, &mut Cache::default());
                assert_eq!(warm.is_hit(), cold.is_hit(), "{what}: {warm:?} {cold:?}");
                calls[2] = [calls[2][0] + warm.support_calls, calls[2][1] + cold.support_calls];
            }
        }
        let share = hits as f64 / frames as f64;
        assert!((0.3..=0.8).contains(&share), "n {n}: the sample is one-sided: {share}");
        let shares = calls.map(|[warm, cold]| f64::from(warm) / f64::from(cold));
        println!("n {n}: {hits} of {frames} frames overlap; support calls, warm over cold {shares:.2?}");
        assert!(shares.iter().zip(WARM_SHARES).all(|(share, max)| *share <= max), "n {n}: {shares:?}");
    }
}
