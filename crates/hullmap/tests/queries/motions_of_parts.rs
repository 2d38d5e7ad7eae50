//! Times of impact of compounds and half-spaces that move and turn, compared with slow twins: all
//! pairs of parts, and the lowest vertex at many times.

use std::f64::consts::PI;

use crate::compound::{pack, pairings, pairs};
use glam::{DQuat, DVec3};
use hullmap::shapes::{Cuboid, HalfSpace, Sphere};
use hullmap::{Cache, Compound, Hull, MotionSettings, Pose, RigidMotion, Shape, Status, TimeOfImpact, cast_motion};
use shapes::rng::SplitMix64;

const SEED: u64 = 0x7075;

/// The number of turns that the limit of queries counts for.
pub fn turns(motions: [&RigidMotion; 2]) -> u32 {
    let angle: f64 = motions.into_iter().map(RigidMotion::angle).sum();
    ((angle / std::f64::consts::TAU).ceil() as u32).clamp(1, MotionSettings::MAX_TURNS)
}

/// A random motion from a place within `reach` of the origin, by a screw or between poses.
pub(crate) fn motion(rng: &mut SplitMix64, reach: f64) -> RigidMotion {
    let mut direction = || DVec3::from_array(rng.direction());
    let (place, other, axis) = (direction() * reach, direction() * (0.3 * reach), direction());
    let start = Pose::new(place, DQuat::from_axis_angle(direction(), 2.0)).unwrap();
    let center = place + direction() * 0.5;
    let angle = [0.0, 0.3, 0.5 * PI, PI, 7.0, 30.0][rng.below(6)];
    match rng.below(4) {
        0 => RigidMotion::still(start),
        1 => RigidMotion::between(start, Pose::new(other, DQuat::from_axis_angle(axis, 1.0)).unwrap()).unwrap(),
        2 => RigidMotion::screw(start, DVec3::ZERO, axis * angle, center).unwrap(),
        _ => RigidMotion::screw(start, other - place, axis * angle, center).unwrap(),
    }
}

fn settings(max_iterations: u32) -> MotionSettings {
    MotionSettings { max_iterations, ..MotionSettings::default() }
}

/// Minimum of the bounds, and whether all intervals are as narrow as their settings allow.
fn first<'a>(all: impl Iterator<Item = &'a TimeOfImpact>) -> ([f64; 2], bool) {
    all.fold(([f64::INFINITY; 2], true), |([lower, upper], is_narrow), found| {
        let narrow = !found.hit || matches!(found.status, Status::Within | Status::Overlapping);
        ([lower.min(found.t_lower), upper.min(found.t_upper)], is_narrow && narrow)
    })
}

#[test]
fn compounds_meet_when_the_first_of_their_pairs_does() {
    let (mut rng, mut cache) = (SplitMix64::new(SEED), Cache::new());
    let (mut hits, mut misses, mut queries, mut all_queries) = (0, 0, 0, 0);
    for (name, a, b) in pairings() {
        let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
        for number in 0..120 {
            let (motion_a, motion_b) = (motion(&mut rng, 1.0), motion(&mut rng, 4.0));
            let cast = |limit| {
                let settings = settings(limit);
                hullmap::cast_motion(&whole_a, &motion_a, &whole_b, &motion_b, &settings, &mut Cache::with_pairs(4))
            };
            let each: Vec<TimeOfImpact> = pairs(&a, &b)
                .map(|(_, a, b)| cast_motion(&a, &motion_a, &b, &motion_b, &settings(200), &mut Cache::new()))
                .collect();
            let ([lower, upper], is_narrow) = first(each.iter());
            let fast = cast(100_000);
            let found = fast;
            let what = || format!("{name}: motion {number}, seed {SEED:#x}: [{lower}, {upper}] {fast:?}");
            // Both intervals contain the time of impact.
            assert!(found.t_lower <= upper && lower <= found.t_upper, "{}", what());
            assert!(!is_narrow || found.hit == (upper <= 1.0), "{}", what());
            assert!(!is_narrow || !found.hit || found.t_upper <= 1.0, "{}", what());
            if found.hit && found.t_upper <= 1.0 {
                hits += 1;
                assert!(found.t_lower <= found.t && found.t <= found.t_upper, "{}", what());
                let own = &each[fast.parts[0] as usize * b.hull_count() + fast.parts[1] as usize];
                assert!(own.hit && own.t_lower <= found.t_upper && found.t_lower <= own.t_upper, "{}", what());
                assert!(found.t_upper - found.t_lower < 1e-3 || !is_narrow, "{}", what());
            } else {
                misses += usize::from(!found.hit);
            }
            queries += found.iterations as usize;
            all_queries += each.iter().map(|found| found.iterations as usize).sum::<usize>();
            // Whatever the limit, the interval is true, and it is kept.
            for limit in [0, 1, 2, 3, 5, 10, 20, 50] {
                let cut = cast(limit);
                assert!(cut.iterations <= limit * turns([&motion_a, &motion_b]) + 1, "{limit}: {cut:?}; {}", what());
                assert!(cut.t_lower <= upper && lower <= cut.t_upper, "{limit}: {cut:?}; {}", what());
                assert!(cut.hit || !found.hit, "{limit}: {cut:?}; {}", what());
            }
            // With a cache that other motions have filled.
            let warm = hullmap::cast_motion(&whole_a, &motion_a, &whole_b, &motion_b, &settings(100_000), &mut cache);
            assert!(warm.t_lower <= upper && lower <= warm.t_upper, "{warm:?}; {}", what());
        }
    }
    println!("{hits} hits, {misses} misses; {queries} of {all_queries} queries");
    assert!(hits > 60 && misses > 60, "{hits}, {misses}");
    assert!(queries * 4 < all_queries, "{queries} of {all_queries}");
}

/// Height of the lowest vertex of a hull over a plane at time `t`, by a scan.
fn height(plane: &HalfSpace, motion: &RigidMotion, hulls: &[Hull<'_>], motion_b: &RigidMotion, t: f64) -> f64 {
    let b_in_plane = motion.pose_at(t).inverse().compose(motion_b.pose_at(t)).unwrap();
    let vertices = hulls.iter().flat_map(|hull| hull.vertices().map(|v| v.as_dvec3()).collect::<Vec<_>>());
    let heights = vertices.map(|v| b_in_plane.transform_point(v).dot(plane.normal()) - plane.offset());
    heights.fold(f64::INFINITY, f64::min)
}

#[test]
fn half_spaces_meet_the_lowest_vertex() {
    let (mut rng, pack) = (SplitMix64::new(SEED + 3), pack(6, 1.0, 21));
    let whole = Compound::new(&pack);
    let hulls: Vec<Hull<'_>> = pack.hulls().collect();
    let (mut hits, mut misses, mut starts) = (0, 0, 0);
    for number in 0..400 {
        let normal = DVec3::from_array(rng.direction());
        let plane = HalfSpace::new(normal, rng.between(-2.5, 0.5)).unwrap();
        let at = Pose::new(DVec3::from_array(rng.direction()), DQuat::from_rotation_y(0.3)).unwrap();
        let turn = DVec3::from_array(rng.direction()) * [0.0, 0.0, 0.2, 1.5, 4.0, 20.0][rng.below(6)];
        let slide = DVec3::from_array(rng.direction()) * [0.0, 0.5][rng.below(2)];
        let motion_a = RigidMotion::screw(at, slide, turn, DVec3::from_array(rng.direction())).unwrap();
        let motion_b = motion(&mut rng, 2.0);
        let one = number % 2 == 0;
        let (found, hulls) = if one {
            (cast_motion(&plane, &motion_a, &hulls[0], &motion_b, &settings(200), &mut Cache::new()), &hulls[..1])
        } else {
            (cast_motion(&plane, &motion_a, &whole, &motion_b, &settings(2_000), &mut Cache::new()), &hulls[..])
        };
        let height = |t: f64| height(&plane, &motion_a, hulls, &motion_b, t);
        let what = || format!("{number}, seed {SEED:#x}: {found:?} {plane:?} {motion_a:?} {motion_b:?}");
        let first = (0..=4_000).map(|i| f64::from(i) / 4e3).find(|t| height(*t) <= 0.0);
        match (found.status, first) {
            (Status::Overlapping, _) => {
                starts += 1;
                assert!(height(0.0) < 1e-12, "{}", what());
            }
            (Status::Separated, _) => {
                misses += 1;
                assert_eq!(first, None, "{}", what());
            }
            (Status::Within, _) => {
                hits += 1;
                assert!(height(found.t_lower) > -1e-13 && height(found.t_upper) < 1e-13, "{}", what());
                assert!(first.is_none_or(|t| found.t_lower <= t), "{}", what());
                assert!(height(found.t_lower) < 1e-5 * 4.0, "{}", what());
                let normal = motion_a.pose_at(found.t_lower).transform_vector(plane.normal());
                assert!(found.normal.distance(normal) < 1e-12, "{}", what());
                assert!(found.iterations < 100, "{}", what());
            }
            // Rounding errors decide, or nothing is known: it must be a hit that was not missed.
            _ => assert!(first.is_none_or(|t| found.t_lower <= t), "{}", what()),
        }
    }
    println!("{hits} hits, {misses} misses, {starts} at the start");
    assert!(hits > 60 && misses > 80 && starts > 20, "{hits} hits, {misses} misses, {starts} at the start");
}

/// Never closer, however often it turns.
#[test]
fn a_half_space_that_spins_about_its_normal_meets_nothing() {
    let door = HalfSpace::new(DVec3::Y, 0.0).unwrap();
    let ball: &(dyn Shape + Sync) = &Sphere::new(0.25).unwrap();
    let still = RigidMotion::still(Pose::from_translation(DVec3::new(2.0, 1.5, 0.3)).unwrap());
    for angle in [0.1, 3.0, 1e4] {
        let spinning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Y * angle, DVec3::X).unwrap();
        let found = cast_motion(&door, &spinning, ball, &still, &settings(20_000), &mut Cache::new());
        assert!(!found.hit, "{angle}: {found:?}");
    }
}

/// A plate of a compound and a floor, far from the origin and at all sizes.
#[test]
fn half_spaces_at_extreme_sizes() {
    for size in [1e-30, 1e-9, 1.0, 1e9, 1e30] {
        let rod: &(dyn Shape + Sync) = &Cuboid::new(DVec3::new(1.0, 0.01, 0.01) * size).unwrap();
        let floor = HalfSpace::new(DVec3::NEG_Y, -0.6 * size).unwrap();
        let turning = RigidMotion::screw(Pose::IDENTITY, DVec3::ZERO, DVec3::Z * (0.5 * PI), DVec3::ZERO).unwrap();
        let still = RigidMotion::still(Pose::IDENTITY);
        let found = cast_motion(&floor, &still, rod, &turning, &MotionSettings::default(), &mut Cache::new());
        let t = ((0.6 / 1.0001_f64.sqrt()).asin() - 0.01_f64.atan()) / (0.5 * PI);
        assert!(
            found.status == Status::Within && found.t_lower <= t + 1e-14 && t - 1e-14 <= found.t_upper,
            "{found:?}"
        );
        assert!(found.iterations <= 10 && rod.outer_radius() > 0.0, "{found:?}");
    }
}
