//! Motions of a planner: free ones are free at every time, with the clearance that they claim.

use std::f64::consts::PI;

use crate::compound::pack;
use crate::motions_of_parts::{motion, turns};
use glam::DVec3;
use hullmap::batch::{self, MovingPair};
use hullmap::shapes::{Cuboid, HalfSpace, Sphere};
use hullmap::{
    Cache, ClearSettings, Clearance, Compound, Hull, MotionSettings, Pose, RigidMotion, Settings, Shape, Status,
    Verdict, cast_motion, clear, distance,
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

#[test]
fn free_motions_are_free_and_hits_hit() {
    let (mut rng, pack) = (SplitMix64::new(SEED), pack(8, 1.0, 41));
    let hulls: Vec<Hull<'_>> = pack.hulls().collect();
    let (mut counts, mut queries) = ([0; 3], [0; 2]);
    for number in 0..600 {
        let (a, b) = (&hulls[rng.below(8)], &hulls[rng.below(8)]);
        let (motion_a, motion_b) = (motion(&mut rng, 0.5), motion(&mut rng, 2.0));
        let margin = [0.0, 0.01, 0.3][number % 3];
        let gap = |t: f64| {
            let b_in_a = Pose::relative(motion_a.pose_at(t), motion_b.pose_at(t)).unwrap();
            distance(a, b, b_in_a, &Settings::default(), &mut Cache::new())
        };
        for (way, share) in [0.0, 0.5, 0.9].into_iter().enumerate() {
            let settings = settings(margin, share, 1_000);
            let found = clear(a, &motion_a, b, &motion_b, &settings, &mut Cache::new());
            let what = format!("{number}, share {share}, seed {SEED:#x}: {found:?} {motion_a:?} {motion_b:?}");
            judge(&found, margin, gap, &what);
            let cast = cast_motion(a, &motion_a, b, &motion_b, &settings.motion, &mut Cache::new());
            assert_eq!(
                (found.verdict == Verdict::Free, found.verdict == Verdict::Hit),
                (!cast.hit, cast.t_upper <= 1.0)
            );
            if found.verdict == Verdict::Free && found.nearest > 1e-3 {
                assert!(found.clearance >= share * found.nearest || margin >= share * found.nearest, "{what}");
            }
            if way < 2 {
                queries[way] += found.iterations;
            }
            counts[found.verdict as usize] += 1;
        }
    }
    println!("free, hit, open: {counts:?}; queries with a share of 0 and 0.5: {queries:?}");
    assert!(counts[0] > 400 && counts[1] > 300 && counts[2] < 30, "{counts:?}");
}

#[test]
fn compounds_are_clear_if_all_their_parts_are() {
    let (mut rng, a, b) = (SplitMix64::new(SEED + 1), pack(6, 1.0, 42), pack(7, 1.0, 43));
    let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
    let mut counts = [0; 3];
    let mut pairs = Vec::new();
    for number in 0..150 {
        let (motion_a, motion_b) = (motion(&mut rng, 0.5), motion(&mut rng, 4.0));
        pairs.push(MovingPair { a: &whole_a, motion_a, b: &whole_b, motion_b });
        let margin = [0.0, 0.02][number % 2];
        let settings = settings(margin, 0.5, 5_000);
        let found = hullmap::clear(&whole_a, &motion_a, &whole_b, &motion_b, &settings, &mut Cache::with_pairs(4));
        let what = format!("{number}, seed {SEED:#x}: {found:?} {motion_a:?} {motion_b:?}");
        let mut cache = Cache::new();
        let gap = |t: f64| {
            let b_in_a = Pose::relative(motion_a.pose_at(t), motion_b.pose_at(t)).unwrap();
            hullmap::distance(&whole_a, &whole_b, b_in_a, &Settings::default(), &mut cache)
        };
        judge(&found, margin, gap, &what);
        if found.verdict == Verdict::Free {
            assert!(found.clearance >= 0.5 * found.nearest, "{what}");
        }
        counts[found.verdict as usize] += 1;
        for limit in [0, 3, 20] {
            let cut = ClearSettings { motion: MotionSettings { max_iterations: limit, ..settings.motion }, share: 0.5 };
            let cut = hullmap::clear(&whole_a, &motion_a, &whole_b, &motion_b, &cut, &mut Cache::with_pairs(4));
            assert!(cut.iterations <= limit * turns([&motion_a, &motion_b]) + 1, "{limit}: {cut:?}");
            let is_open = cut.verdict == Verdict::Open;
            assert!(is_open || cut.verdict == found.verdict, "{limit}: {cut:?}; {what}");
        }
    }
    println!("free, hit, open: {counts:?}");
    assert!(counts[0] > 30 && counts[1] > 30 && counts[2] < 5, "{counts:?}");

    // A batch has the bits of single queries.
    let settings = settings(0.0, 0.5, 5_000);
    let mut caches = vec![Cache::with_pairs(1); pairs.len()];
    let mut found = vec![Clearance::default(); pairs.len()];
    batch::clear(&pairs, &settings, &mut caches, &mut found).unwrap();
    for (pair, found) in pairs.iter().zip(&found) {
        let mut cache = Cache::with_pairs(1);
        let single = hullmap::clear(pair.a, &pair.motion_a, pair.b, &pair.motion_b, &settings, &mut cache);
        assert_eq!(*found, single);
    }
    assert!(batch::clear(&pairs, &settings, &mut caches[1..], &mut found).is_err());
}

/// Hulls, and all hulls together, above planes that move, too.
#[test]
fn half_spaces_are_clear_if_the_lowest_vertices_are() {
    let (mut rng, pack) = (SplitMix64::new(SEED + 3), pack(8, 1.0, 43));
    let hulls: Vec<Hull<'_>> = pack.hulls().collect();
    let all = Compound::new(&pack);
    let mut counts = [0; 3];
    for number in 0..400 {
        let hull = &hulls[rng.below(8)];
        let plane = HalfSpace::new(DVec3::from_array(rng.direction()), rng.between(-4.0, 0.0)).unwrap();
        let (own, other) = (motion(&mut rng, 0.5), motion(&mut rng, 2.0));
        let margin = [0.0, 0.01, 0.3][number % 3];
        let settings = settings(margin, [0.0, 0.5, 0.9][number / 3 % 3], 1_000);
        let at = |t: f64| Pose::relative(own.pose_at(t), other.pose_at(t)).unwrap();
        let what = format!("{number}, seed {SEED:#x}: {own:?} {other:?}");
        let (usual, mut cache) = (Settings::default(), Cache::new());
        let single = clear(&plane, &own, hull, &other, &settings, &mut cache);
        judge(&single, margin, |t| distance(&plane, hull, at(t), &usual, &mut Cache::new()), &what);
        let whole = clear(&plane, &own, &all, &other, &settings, &mut cache);
        judge(&whole, margin, |t| distance(&plane, &all, at(t), &usual, &mut Cache::new()), &what);
        counts[single.verdict as usize] += 1;
        counts[whole.verdict as usize] += 1;
    }
    println!("{counts:?}");
    assert!(counts[0] > 100 && counts[1] > 100, "{counts:?}");
}

#[test]
fn batches_of_moving_pairs_have_the_bits_of_single_queries() {
    let ball: &(dyn Shape + Sync) = &Sphere::new(0.4).unwrap();
    let cube: &(dyn Shape + Sync) = &Cuboid::new(DVec3::new(0.2, 0.5, 1.0)).unwrap();
    let mut rng = SplitMix64::new(SEED + 2);
    let pairs: Vec<_> = (0..300)
        .map(|_| MovingPair { a: cube, motion_a: motion(&mut rng, 0.5), b: ball, motion_b: motion(&mut rng, 2.0) })
        .collect();
    let settings = ClearSettings::default();
    let (mut caches, mut found) = (vec![Cache::new(); pairs.len()], vec![Clearance::default(); pairs.len()]);
    batch::clear(&pairs, &settings, &mut caches, &mut found).unwrap();
    for (pair, found) in pairs.iter().zip(&found) {
        let single = clear(pair.a, &pair.motion_a, pair.b, &pair.motion_b, &settings, &mut Cache::new());
        assert_eq!(*found, single);
    }
    let error = batch::clear(&pairs, &settings, &mut caches, &mut found[1..]).unwrap_err();
    assert_eq!((error.pairs, error.caches, error.answers), (300, 300, 299));
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
