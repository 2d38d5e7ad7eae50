//! Motions of a planner: free ones are free at every time, with the clearance that they claim.

use std::f64::consts::PI;

use crate::compound::pack;
use crate::motions_of_parts::{motion, turns};
use glam::DVec3;
use hullmap::batch::{self, MovingPair};
use hullmap::shapes::{Cuboid, HalfSpace, Sphere};
use hullmap::{
    Cache, ClearSettings, Clearance, Hull, MotionSettings, Pose, RigidMotion, Settings, Shape, Status, Verdict,
    cast_motion, clear, distance,
};
use shapes::rng::SplitMix64;

const SEED: u64 = 0xed6e;

/// Number of times at which a motion is sampled.
const SAMPLES: u32 = 200;

fn settings(margin: f64, share: f64, max_iterations: u32) -> ClearSettings {
    let motion = MotionSettings { target_distance: margin, max_iterations, ..MotionSettings::default() };
    ClearSettings { motion, share }
}

/// Compares an answer with distances at many times.
fn judge(found: &Clearance, margin: f64, mut gap: impl FnMut(f64) -> hullmap::Distance, what: &str) {
    let samples = (0..=SAMPLES).map(|i| f64::from(i) / f64::from(SAMPLES));
    match found.verdict {
        Verdict::Free => {
            assert_eq!([found.t_lower, found.t_upper], [f64::INFINITY; 2], "{what}");
            assert!(found.clearance >= margin && found.clearance <= found.nearest, "{what}");
            for t in samples {
                let gap = gap(t);
                assert!(gap.upper >= found.clearance, "at {t}: {gap:?}; {what}");
            }
        }
        Verdict::Hit => {
            assert!(found.t_lower <= found.t_upper && found.t_upper <= 1.0 && found.clearance == 0.0, "{what}");
            for t in samples.filter(|t| *t < found.t_lower) {
                assert!(gap(t).upper > margin, "at {t}: {what}");
            }
            assert!(gap(found.t_upper).lower <= margin, "{what}");
        }
        Verdict::Open => {
            assert!(found.t_lower <= 1.0 && found.t_upper == f64::INFINITY && found.clearance == 0.0, "{what}");
        }
    }
}

/// Distances at many times judge packs, and hulls and packs over half-spaces that move, too. The
/// soak judges pairs of shapes.
#[test]
fn packs_and_half_spaces_are_clear_if_all_their_parts_are() {
    let (mut rng, a, b) = (SplitMix64::new(SEED + 1), pack(6, 1.0, 42), pack(7, 1.0, 43));
    let hulls: Vec<Hull<'_>> = b.hulls().collect();
    let (mut counts, mut pairs) = ([[0; 3]; 3], Vec::new());
    for number in 0..450 {
        let (own, other) = (motion(&mut rng, 0.5), motion(&mut rng, 4.0));
        let plane = HalfSpace::new(DVec3::from_array(rng.direction()), rng.between(-4.0, 0.0)).unwrap();
        let margin = [0.0, 0.01, 0.3][number / 3 % 3];
        let settings = settings(margin, [0.5, 0.0, 0.9][number / 9 % 3], 5_000);
        let at = |t: f64| Pose::relative(own.pose_at(t), other.pose_at(t)).unwrap();
        let what = format!("{number}, seed {SEED:#x}: {own:?} {other:?}");
        let (usual, mut cache) = (Settings::default(), Cache::with_pairs(4));
        let mut own_cache = Cache::new();
        let found = match number % 3 {
            0 => {
                pairs.push(MovingPair { a: &a, motion_a: own, b: &b, motion_b: other });
                let found = clear(&a, &own, &b, &other, &settings, &mut cache);
                judge(&found, margin, |t| distance(&a, &b, at(t), &usual, &mut own_cache), &what);
                for limit in [0, 3, 20] {
                    let motion = MotionSettings { max_iterations: limit, ..settings.motion };
                    let cut = clear(&a, &own, &b, &other, &ClearSettings { motion, ..settings }, &mut cache);
                    assert!(cut.iterations <= limit * turns([&own, &other]) + 1, "{limit}: {cut:?}");
                    let is_open = cut.verdict == Verdict::Open;
                    assert!(is_open || cut.verdict == found.verdict, "{limit}: {cut:?}; {what}");
                }
                found
            }
            1 => {
                let hull = &hulls[rng.below(7)];
                let found = clear(&plane, &own, hull, &other, &settings, &mut cache);
                judge(&found, margin, |t| distance(&plane, hull, at(t), &usual, &mut own_cache), &what);
                found
            }
            _ => {
                let found = clear(&plane, &own, &b, &other, &settings, &mut cache);
                judge(&found, margin, |t| distance(&plane, &b, at(t), &usual, &mut own_cache), &what);
                found
            }
        };
        if settings.share > 0.0 && (found.verdict, found.status) == (Verdict::Free, Status::Within) {
            assert!(found.clearance >= settings.share * found.nearest, "{what}: {found:?}");
        }
        counts[number % 3][found.verdict as usize] += 1;
    }
    println!("free, hit, open: {counts:?}");
    assert!(counts.iter().all(|count| count[0] > 30 && count[1] > 30 && count[2] < 5), "{counts:?}");

    // A batch has the bits of single queries.
    let settings = settings(0.0, 0.5, 5_000);
    let mut caches = vec![Cache::with_pairs(1); pairs.len()];
    let mut found = vec![Clearance::default(); pairs.len()];
    batch::clear(&pairs, &settings, &mut caches, &mut found).unwrap();
    for (pair, found) in pairs.iter().zip(&found) {
        let mut cache = Cache::with_pairs(1);
        let single = clear(pair.a, &pair.motion_a, pair.b, &pair.motion_b, &settings, &mut cache);
        assert_eq!(*found, single);
    }
    let error = batch::clear(&pairs, &settings, &mut caches, &mut found[1..]).unwrap_err();
    assert_eq!((error.pairs, error.caches, error.answers), (150, 150, 149));
}

#[test]
fn shares_out_of_range_are_harmless() {
    let ball: &(dyn Shape + Sync) = &Sphere::new(1.0).unwrap();
    let at = |x: f64, y: f64| Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap();
    let still = RigidMotion::still(Pose::IDENTITY);
    let passing = RigidMotion::between(at(-5.0, 2.5), at(5.0, 2.5)).unwrap();
    for share in [f64::NAN, -1.0, 0.0, 0.5, 0.95, 1.0, f64::INFINITY] {
        let found = clear(ball, &still, ball, &passing, &settings(0.0, share, 200), &mut Cache::new());
        assert_eq!(found.verdict, Verdict::Free, "{share}: {found:?}");
        assert!(found.clearance > 0.0 && found.clearance <= 0.5, "{share}: {found:?}");
        assert!(found.clearance >= 0.5 * share.clamp(0.0, 0.94) || share.is_nan(), "{share}: {found:?}");
    }
    // The same margin as the distance: rounding errors decide, and nothing is claimed.
    let found = clear(ball, &still, ball, &passing, &settings(0.5, 0.5, 200), &mut Cache::new());
    assert!(found.verdict != Verdict::Free && found.t_lower <= 0.5, "{found:?}");
}

/// A clearance that was requested and not reached had no status. A small distance was one reason:
/// the search gave up within the tolerance.
#[test]
fn a_clearance_is_the_requested_share_or_has_a_status() {
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::ONE).unwrap();
    let ball: &(dyn Shape + Sync) = &Sphere::new(0.5).unwrap();
    let rod: &(dyn Shape + Sync) = &Cuboid::new(DVec3::new(1.0, 0.01, 0.01)).unwrap();
    let at = |x: f64, y: f64, z: f64| Pose::from_translation(DVec3::new(x, y, z)).unwrap();
    let still = RigidMotion::still(Pose::IDENTITY);
    for (gap, share) in [(1e-3, 0.5), (1e-6, 0.5), (1e-9, 0.5), (1e-9, 0.95), (1e-6, 0.0)] {
        let start = at(0.0, 0.0, 1.5 + gap);
        let turning = RigidMotion::screw(start, DVec3::ZERO, DVec3::Z * 7.0, start.translation()).unwrap();
        let found = clear(cube, &still, ball, &turning, &settings(0.0, share, 200), &mut Cache::new());
        assert_eq!((found.verdict, found.status), (Verdict::Free, Status::Within), "{gap:e}, {share}: {found:?}");
        assert!(found.clearance >= share * (gap - 1e-14) && found.clearance <= gap + 1e-14, "{gap:e}: {found:?}");
    }
    // Past a ball, with all limits of queries.
    let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Z * 3.0, DVec3::ZERO).unwrap();
    let (place, mut statuses) = (RigidMotion::still(at(1.1, 1.1, 0.0)), Vec::new());
    for (limit, share) in (1..60).flat_map(|limit| [(limit, 0.5), (limit, 0.95)]) {
        let found = clear(rod, &turning, ball, &place, &settings(0.0, share, limit), &mut Cache::new());
        let is_reached = found.clearance >= share * found.nearest;
        assert_eq!(found.status == Status::Within, found.verdict == Verdict::Free && is_reached, "{found:?}");
        assert!(found.status == Status::Within || found.status == Status::IterationLimit, "{found:?}");
        statuses.push((found.verdict, found.status));
    }
    let count = |verdict, status| statuses.iter().filter(|own| **own == (verdict, status)).count();
    let seen = [(Verdict::Free, Status::Within), (Verdict::Free, Status::IterationLimit)].map(|(v, s)| count(v, s));
    assert!(seen.iter().all(|count| *count > 0) && count(Verdict::Open, Status::IterationLimit) > 0, "{statuses:?}");
}

/// The limit of queries is one for each turn: it was 200 for 50 turns, and half of them were open.
#[test]
fn fifty_turns_are_decided_by_default() {
    let rod: &(dyn Shape + Sync) = &Cuboid::new(DVec3::new(1.0, 0.1, 0.1)).unwrap();
    let bar: &(dyn Shape + Sync) = &Cuboid::new(DVec3::new(0.5, 0.1, 0.1)).unwrap();
    let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Z * 100.0 * PI, DVec3::ZERO).unwrap();
    let mut counts = [0; 3];
    for number in 0..40 {
        let x = 1.4 + 0.03 * f64::from(number);
        let at = |y: f64| Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap();
        let passing = RigidMotion::between(at(-1.0), at(1.0)).unwrap();
        let found = clear(rod, &turning, bar, &passing, &ClearSettings::default(), &mut Cache::new());
        let met = cast_motion(rod, &turning, bar, &passing, &MotionSettings::default(), &mut Cache::new());
        // The corner of the rod is at √1.01.
        let expected = if x - 0.5 > 1.01_f64.sqrt() { Verdict::Free } else { Verdict::Hit };
        assert_eq!((found.verdict, met.hit), (expected, expected == Verdict::Hit), "{x}: {found:?} {met:?}");
        assert!(found.iterations <= 200 * 50, "{found:?}");
        counts[found.verdict as usize] += 1;
    }
    assert!(counts[0] > 20 && counts[1] > 3, "{counts:?}");
}
