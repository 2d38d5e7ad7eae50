//! Queries between whole packs, compared with their slow twin: a query of each pair of hulls.

use crate::any_shape::{self, Any};
use crate::pairings;
use glam::{DQuat, DVec3};
use hullmap::compound::CompoundManifolds;
use hullmap::shapes::{Cuboid, HalfSpace, Sphere};
use hullmap::{
    Cache, CastSettings, Compound, Contact, Distance, Geometry, Impact, Manifold, ManifoldSettings, Motion, Overlap,
    Pack, Pose, Prediction, Ray, RayHit, Settings, Shape, Status, SupportMap,
};
use hullmap_testkit::packs::{self, point_set};
use hullmap_testkit::{gap::distance_by_features, polytope::Polytope, random::RandomPoses, reach::Reach};
use shapes::{families::Family, rng::SplitMix64};
use std::collections::BTreeMap;

const SEED: u64 = 0xc0_11de;

/// A pack of `count` rocks, boxes, lenses and cones in a ball of radius `radius`: a concave shape
/// with holes.
pub(crate) fn pack(count: usize, radius: f64, seed: u64) -> Pack {
    let mut rng = SplitMix64::new(seed);
    let parts = (0..count).map(|number| {
        let place = rng.direction().map(|c| c * radius * rng.between(0.3, 1.0));
        let family = [Family::Rock, Family::CubeGrid, Family::Lens, Family::Cone][number % 4];
        let size = 0.15 + 0.25 * rng.between(0.0, 1.0);
        let placed = |p: &[f32; 3]| std::array::from_fn(|i| (f64::from(p[i]) * size + place[i]) as f32);
        let points: Vec<[f32; 3]> = family.points(40, number as u64).iter().map(placed).collect();
        point_set(&number.to_string(), &points)
    });
    packs::parts(&parts.collect::<Vec<_>>())
}

fn poses(count: usize, reach: f64, seed: u64) -> Vec<Pose> {
    let mut rng = SplitMix64::new(seed);
    let mut pose = || Pose::new(rng.unit_vector() * reach * rng.between(0.2, 1.0), rng.rotation()).unwrap();
    (0..count).map(|_| pose()).collect()
}

/// Pairs of packs with few and with many parts, one of them with a single hull.
pub(crate) fn pairings() -> Vec<(&'static str, Pack, Pack)> {
    vec![
        ("three and five", pack(3, 1.0, 1), pack(5, 1.0, 2)),
        ("twenty and twelve", pack(20, 1.2, 3), pack(12, 1.2, 4)),
        ("one and thirty", pack(1, 0.5, 5), pack(30, 1.5, 6)),
    ]
}

pub(crate) fn pairs<'a>(
    a: &'a Pack,
    b: &'a Pack,
) -> impl Iterator<Item = ([usize; 2], hullmap::Hull<'a>, hullmap::Hull<'a>)> {
    a.hulls().enumerate().flat_map(|(i, hull_a)| b.hulls().enumerate().map(move |(j, hull_b)| ([i, j], hull_a, hull_b)))
}

/// Two parts as shapes, and their indices.
type Pair<'s> = ([u32; 2], &'s Any<'s>, &'s Any<'s>);

/// Counts over poses, and support queries of intersections and distances: of the whole, and of all
/// pairs of parts.
#[derive(Debug, Default)]
struct Tally {
    tried: usize,
    hits: usize,
    queried: [u32; 2],
    all: [u32; 2],
}

/// Compares the answers for A and B with the answers for all pairs of their parts.
fn judge<A: Geometry + ?Sized, B: Geometry + ?Sized>(
    at: &str,
    (a, b): (&A, &B),
    pairs: &[Pair<'_>],
    pose: Pose,
    slack: f64,
    cache: &mut Cache,
    tally: &mut Tally,
) {
    let settings = Settings::default();
    let place = |parts: [u32; 2]| pairs.iter().position(|(pair, ..)| *pair == parts).expect("the parts exist");
    let each: Vec<_> = pairs.iter().map(|(_, a, b)| any_shape::intersects(*a, *b, pose, &mut Cache::new())).collect();
    let hit = each.iter().any(|found| found.status == Overlap::Overlapping);
    let found = hullmap::intersects(a, b, pose, cache);
    assert_eq!((found.status == Overlap::Overlapping, found.is_hit()), (hit, hit), "{at}: {found:?}");
    assert!(!hit || each[place(found.parts)].is_hit(), "{at}: {found:?}");
    let fresh = hullmap::intersects(a, b, pose, &mut Cache::with_pairs(0));
    assert_eq!(fresh.status, found.status, "{at}");
    tally.queried[0] += fresh.support_calls;
    tally.all[0] += each.iter().map(|found| found.support_calls).sum::<u32>();

    let each: Vec<_> =
        pairs.iter().map(|(_, a, b)| any_shape::distance(*a, *b, pose, &settings, &mut Cache::new())).collect();
    let least = |of: fn(&Distance) -> f64| each.iter().map(of).fold(f64::INFINITY, f64::min);
    let (lower, upper) = (least(|found| found.lower), least(|found| found.upper));
    let found = hullmap::distance(a, b, pose, &settings, cache);
    // Both intervals contain the distance.
    assert!(found.lower <= upper + slack && lower <= found.upper + slack, "{at}: {found:?}");
    assert!(found.upper - found.lower <= 2e-5 * found.upper + 1e-12, "{at}: {found:?}");
    assert_eq!(found.status == Status::Overlapping, upper == 0.0, "{at}: {found:?}");
    if upper > 0.0 {
        let between = (found.point_b - found.point_a).length();
        assert!((between - found.distance).abs() <= 1e-12 * (1.0 + found.distance), "{at}: {found:?}");
        tally.queried[1] += found.support_calls;
        tally.all[1] += each.iter().map(|found| found.support_calls).sum::<u32>();
    }

    let each: Vec<([u32; 2], Contact)> = pairs
        .iter()
        .map(|(pair, a, b)| (*pair, any_shape::contact(*a, *b, pose, &settings, &mut Cache::new())))
        .filter(|(_, found)| found.hit)
        .collect();
    let mut visited: Vec<([u32; 2], Contact)> = Vec::new();
    let sum = hullmap::contacts(a, b, pose, &settings, cache, |found| visited.push((found.parts, *found)));
    visited.sort_by_key(|(pair, _)| *pair);
    assert_eq!(sum.hits as usize, each.len(), "{at}");
    assert!(visited.iter().map(|(pair, _)| pair).eq(each.iter().map(|(pair, _)| pair)), "{at}");
    let meet = |found: &Contact, [lower, upper]: [f64; 2]| {
        found.depth_lower <= upper + slack && lower <= found.depth_upper + slack
    };
    for ((_, found), (_, slow)) in visited.iter().zip(&each) {
        assert!(meet(found, [slow.depth_lower, slow.depth_upper]), "{at}: {found:?}");
    }
    let deepest = hullmap::contact(a, b, pose, &settings, cache);
    assert_eq!(deepest.hit, !each.is_empty(), "{at}: {deepest:?}");
    if deepest.hit {
        let greatest = |of: fn(&Contact) -> f64| each.iter().map(|(_, found)| of(found)).fold(0.0, f64::max);
        let interval = [greatest(|found| found.depth_lower), greatest(|found| found.depth_upper)];
        assert!(meet(&deepest, interval) && each.iter().any(|(pair, _)| *pair == deepest.parts), "{at}: {deepest:?}");
        tally.hits += 1;
    }
    tally.tried += 1;
}

#[test]
fn packs_agree_with_all_pairs_of_parts() {
    // Near and far: the first saves intersections, the second distances.
    let mut tallies = [Tally::default(), Tally::default()];
    for (name, a, b) in pairings() {
        let hulls = [&a, &b].map(|pack| pack.hulls().collect::<Vec<_>>());
        let pairs = (0..).zip(&hulls[0]).flat_map(|(i, a)| (0..).zip(&hulls[1]).map(move |(j, b)| ([i, j], a, b)));
        let pairs: Vec<Pair<'_>> = pairs.map(|(pair, a, b)| (pair, a as &Any<'_>, b as &Any<'_>)).collect();
        let (whole, mut cache) = ((&Compound::new(&a), &Compound::new(&b)), Cache::with_pairs(8));
        for (reach, tally) in [2.0, 2.7].into_iter().zip(&mut tallies) {
            for (number, pose) in poses(500, reach, SEED).into_iter().enumerate() {
                let at = format!("{name}: pose {number} within {reach}, seed {SEED:#x}");
                judge(&at, whole, &pairs, pose, 0.0, &mut cache, tally);
            }
        }
    }
    println!("{tallies:?}");
    for (query, (Tally { tried, hits, queried, all }, share)) in tallies.iter().zip([4, 10]).enumerate() {
        assert!((tried * (3 - query) / 10..=tried * 7 / 10).contains(hits), "{hits} of {tried} hit");
        assert!(queried[query] * share < all[query], "{queried:?} of {all:?}");
    }
}

/// A compound against a single shape, on either side.
#[test]
fn single_shapes_agree_with_all_parts() {
    let (many, packs) = (pack(16, 1.2, 3), pairings::packs());
    let (whole, hulls) = (Compound::new(&many), many.hulls().collect::<Vec<_>>());
    let mut tally = Tally::default();
    for (name, shape) in pairings::all(&packs) {
        let shape: &Any<'_> = &*shape;
        let pairs: Vec<Pair<'_>> = (0..).zip(&hulls).map(|(i, hull)| ([i, 0], hull as &Any<'_>, shape)).collect();
        let turned: Vec<Pair<'_>> = pairs.iter().map(|([i, _], hull, shape)| ([0, *i], *shape, *hull)).collect();
        let (mut cache, mut other) = (Cache::new(), Cache::new());
        for (number, pose) in poses(120, 2.0, SEED + 5).into_iter().enumerate() {
            let at = format!("{name}: pose {number}, seed {SEED:#x}");
            judge(&at, (&whole, shape), &pairs, pose, 1e-12, &mut cache, &mut tally);
            judge(&at, (shape, &whole), &turned, pose.inverse(), 1e-12, &mut other, &mut tally);
        }
    }
    println!("{tally:?}");
    let Tally { tried, hits, queried, all } = tally;
    assert!((tried * 3 / 10..=tried * 7 / 10).contains(&hits), "{hits} of {tried} hit");
    assert!(queried[1] * 3 < all[1], "{queried:?} of {all:?}");
}

/// The cache of other compounds with more hulls never leads to a hull that does not exist.
#[test]
fn a_stale_cache_never_changes_an_answer() {
    let (large, small) = (pack(12, 1.0, 1), pack(2, 0.7, 2));
    let mut cache = Cache::with_pairs(4);
    for pose in poses(200, 2.0, SEED + 4) {
        let far =
            hullmap::distance(&Compound::new(&large), &Compound::new(&large), pose, &Settings::default(), &mut cache);
        assert!(far.parts.iter().all(|hull| *hull < 12));
        let (a, b) = (Compound::new(&small), Compound::new(&small));
        let found = hullmap::intersects(&a, &b, pose, &mut cache);
        let slow = hullmap::intersects(&a, &b, pose, &mut Cache::new());
        assert_eq!(found.status, slow.status);
        cache.clear();
    }
}

/// The signed distance of a point: the minimum over all parts, and brute force from their vertices
/// and planes.
#[test]
fn signed_distance_is_the_minimum_over_all_parts() {
    let settings = Settings::default();
    let (mut insides, mut outsides, mut deeper, mut queried, mut all) = (0, 0, 0, 0, 0);
    for (name, parts) in [("one", pack(1, 0.5, 5)), ("eight", pack(8, 0.4, 7)), ("thirty", pack(30, 1.0, 6))] {
        let whole = Compound::new(&parts);
        let polytopes: Vec<Polytope> = parts.hulls().map(|hull| Polytope::new(&hull)).collect();
        let mut cache = Cache::with_pairs(4);
        let mut rng = SplitMix64::new(SEED + 11);
        for number in 0..400 {
            let at = format!("{name}: point {number}, seed {SEED:#x}");
            let near = parts.hull(number % parts.hull_count()).unwrap();
            let away = DVec3::from_array(rng.direction()) * near.outer_radius() * rng.between(0.0, 2.0);
            let point = near.interior_point() + away;
            let found = hullmap::signed_distance(&whole, point, &settings, &mut cache).unwrap();
            assert!(found.lower <= found.distance && found.distance <= found.upper, "{at}: {found:?}");
            assert!(found.upper - found.lower <= 2e-5 * found.distance.abs() + 1e-12, "{at}: {found:?}");

            let each = |hull| hullmap::signed_distance(&hull, point, &settings, &mut Cache::new()).unwrap();
            let twins: Vec<_> = parts.hulls().map(each).collect();
            let lower = twins.iter().map(|twin| twin.lower).fold(f64::INFINITY, f64::min);
            let upper = twins.iter().map(|twin| twin.upper).fold(f64::INFINITY, f64::min);
            // Both intervals contain the minimum.
            assert!(found.lower <= upper && lower <= found.upper, "{at}: {found:?}, {lower} {upper}");
            assert!(twins[found.part as usize].lower <= upper, "{at}: {found:?}");

            // The highest plane of each part: the truth inside, a lower bound outside.
            let slack = 1e-14;
            let heights = polytopes.iter().map(|polytope| {
                let heights = polytope.normals.iter().map(|normal| normal.dot(point) - polytope.reach(*normal));
                heights.fold(f64::NEG_INFINITY, f64::max)
            });
            let lowest = heights.clone().fold(f64::INFINITY, f64::min);
            if lowest < 0.0 {
                assert!(found.lower - slack <= lowest && lowest <= found.upper + slack, "{at}: {lowest} {found:?}");
                insides += 1;
                deeper += usize::from(heights.filter(|height| *height < 0.0).count() > 1);
            } else if number % 5 == 0 {
                let apart = |polytope: &Polytope| distance_by_features(&polytope.points, &[point]);
                let truth = polytopes.iter().map(apart).fold(f64::INFINITY, f64::min);
                assert!(found.lower - slack <= truth && truth <= found.upper + slack, "{at}: {truth} {found:?}");
                outsides += 1;
            }
            queried += found.support_calls;
            all += twins.iter().map(|twin| twin.support_calls).sum::<u32>();
        }
    }
    println!("{insides} inside, {deeper} in several parts, {outsides} outside; {queried} of {all} support queries");
    assert!(insides > 200 && outsides > 60 && deeper > 50, "{insides} {outsides} {deeper}");
    assert!(queried * 3 < all, "{queried} of {all}");

    let (two, mut cache) = (pack(2, 1.0, 1), Cache::new());
    for wrong in [f64::NAN, f64::INFINITY, 1e300] {
        let point = DVec3::new(0.0, wrong, 0.0);
        assert!(hullmap::signed_distance(&Compound::new(&two), point, &settings, &mut cache).is_err());
    }
}

/// A half-space against a compound: the lowest of all parts.
#[test]
fn half_spaces_agree_with_all_parts() {
    let many = pack(24, 1.2, 3);
    let (mut rng, settings, mut cache) = (SplitMix64::new(SEED + 6), Settings::default(), Cache::new());
    let (mut hits, mut queried) = (0, 0);
    for (number, pose) in poses(1_000, 2.0, SEED + 6).into_iter().enumerate() {
        let plane = HalfSpace::new(rng.unit_vector(), rng.between(-2.0, 1.0)).unwrap();
        let (mut depths, mut uppers, mut gaps) = (vec![], vec![], vec![]);
        for part in many.hulls() {
            let c = hullmap::contact(&plane, &part, pose, &settings, &mut cache);
            depths.push(c.depth);
            uppers.push(c.depth_upper);
            gaps.push(hullmap::distance(&plane, &part, pose, &settings, &mut cache).distance);
        }
        let greatest = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
        let c = hullmap::contact(&plane, &many, pose, &settings, &mut cache);
        let d = hullmap::distance(&plane, &many, pose, &settings, &mut cache);
        let y = hullmap::intersects(&plane, &many, pose, &mut cache);
        let at = format!("seed {SEED:#x}, {number}: {c:?} {d:?} {y:?}");
        let nearest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!((c.hit, y.is_hit()), (nearest == 0.0, nearest == 0.0), "{at}");
        assert_eq!((c.depth, c.depth_upper, d.distance), (greatest(&depths), greatest(&uppers), nearest), "{at}");
        let part = many.hull(c.parts[1] as usize).unwrap();
        let one = hullmap::contact(&plane, &part, pose, &settings, &mut cache);
        assert_eq!((one.depth, one.point_b, one.parts, c.parts[0]), (c.depth, c.point_b, [0, 0], 0), "{at}");
        let mut visited = 0;
        hullmap::contacts(&plane, &many, pose, &settings, &mut cache, |found| {
            assert_eq!(found.depth, depths[found.parts[1] as usize], "{at}");
            visited += 1;
        });
        assert_eq!(visited, gaps.iter().filter(|gap| **gap == 0.0).count(), "{at}");
        hits += usize::from(c.hit);
        queried += c.support_calls;
    }
    println!("{hits} of 1000 hit, {queried} support queries");
    assert!((300..700).contains(&hits) && queried < 5_000, "{hits} {queried}");
}

/// Frames of a slow motion of B.
fn frames(count: usize, seed: u64) -> Vec<Pose> {
    let mut rng = SplitMix64::new(seed);
    let (start, way) = (rng.unit_vector() * 0.8, rng.unit_vector() * 0.004);
    let (axis, turn) = (rng.unit_vector(), rng.rotation());
    (0..count)
        .map(|i| {
            let spin = DQuat::from_axis_angle(axis, 0.006 * i as f64);
            Pose::new(start + way * i as f64, spin * turn).unwrap()
        })
        .collect()
}

/// The manifolds of compounds equal the manifolds of all pairs of parts, frame for frame, with
/// their impulses.
#[test]
fn manifolds_agree_with_those_of_all_pairs() {
    let (a, b) = (pack(20, 1.0, 3), pack(16, 1.0, 4));
    let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
    let predictions = [Prediction::default(), Prediction::Length(0.01), Prediction::Length(0.2)];
    let (mut kept, mut points, mut most) = (0, 0, 0);
    for run in 0..6 {
        let prediction = predictions[run % 3];
        let settings = ManifoldSettings { prediction, ..ManifoldSettings::default() };
        let mut manifolds = CompoundManifolds::new(200);
        // The twins ignore other parts.
        manifolds.set_welding(false);
        let mut twins: BTreeMap<[usize; 2], (Manifold, Cache)> = BTreeMap::new();
        for (frame, pose) in frames(60, SEED + run as u64).into_iter().enumerate() {
            let counts = manifolds.update(&whole_a, &whole_b, pose, &settings);
            for (pair, hull_a, hull_b) in pairs(&a, &b) {
                let (twin, cache) = twins.entry(pair).or_default();
                twin.update(&hull_a, &hull_b, pose, &settings, cache);
            }
            let expected: Vec<_> = twins.iter().filter(|(_, (twin, _))| !twin.points().is_empty()).collect();
            assert_eq!((counts.touching as usize, counts.dropped), (expected.len(), 0), "run {run}, frame {frame}");
            assert_eq!(manifolds.len(), expected.len());
            assert_eq!(manifolds.iter().count(), expected.len());
            for (pair, (twin, _)) in expected {
                let found = manifolds.get(*pair).unwrap_or_else(|| panic!("run {run}, frame {frame}: no {pair:?}"));
                // The caches differ, so the depths may, within the tolerance. Then other points may
                // be chosen; most of them are the same.
                let deepest = |m: &Manifold| m.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
                let depth = deepest(twin);
                assert!((deepest(found) - depth).abs() <= 1e-4 * depth.abs() + 1e-9, "{run}, {frame}, {pair:?}");
                points += found.points().len();
                kept += found
                    .points()
                    .iter()
                    .filter(|p| twin.points().iter().any(|q| (p.id, p.age, p.impulse) == (q.id, q.age, q.impulse)))
                    .count();
            }
            most = most.max(manifolds.len());
            let store = |m: &mut Manifold| m.points_mut().iter_mut().for_each(|p| p.impulse[0] += 1.0);
            manifolds.iter_mut().for_each(|(_, manifold)| store(manifold));
            twins.values_mut().for_each(|(manifold, _)| store(manifold));
        }
    }
    println!("{kept} of {points} points agree; up to {most} pairs touch");
    assert!(points > 1_000 && kept * 50 > points * 49 && most > 10, "{kept} of {points}, {most}");
}

/// With a single shape, a half-space, and more pairs than manifolds.
#[test]
fn manifolds_of_shapes_and_half_spaces() {
    let many = pack(12, 1.0, 5);
    let whole = Compound::new(&many);
    let (cube, floor) = (Cuboid::new(DVec3::new(50.0, 50.0, 50.0)).unwrap(), HalfSpace::new(DVec3::Z, 50.0).unwrap());
    let slab: &(dyn Shape + Sync) = &cube;
    let settings = ManifoldSettings { prediction: Prediction::Length(0.05), ..ManifoldSettings::default() };
    let (mut on_slab, mut on_floor, mut few) =
        (CompoundManifolds::new(16), CompoundManifolds::new(16), CompoundManifolds::new(2));
    on_slab.set_welding(false);
    few.set_welding(false);
    let mut dropped = 0;
    for step in 0..40 {
        let t = f64::from(step);
        let pose = Pose::new(DVec3::new(0.0, 0.0, 50.9 - 0.03 * t), DQuat::from_rotation_x(0.01 * t)).unwrap();
        let counts = on_slab.update(slab, &whole, pose, &settings);
        let below = on_floor.update(&floor, &whole, pose, &settings);
        assert_eq!(counts.touching, below.touching, "{step}");
        for ((pair, found), (twin_pair, twin)) in on_slab.iter().zip(on_floor.iter()) {
            assert_eq!(pair, twin_pair);
            let deepest = |m: &Manifold| m.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            // Depths within a tenth of the prediction count as equal.
            assert!((deepest(found) - deepest(twin)).abs() <= 0.1 * 0.05 + 1e-4, "{step}, {pair:?}");
            let hull = many.hull(pair[1]).unwrap();
            let lowest = hullmap::contact(&floor, &hull, pose, &settings.contact, &mut Cache::new());
            let depth = (lowest.point_a - lowest.point_b).z;
            assert!((deepest(twin) - depth).abs() <= 0.1 * 0.05 + 1e-4, "{step}, {pair:?}");
        }
        let seen = few.update(slab, &whole, pose, &settings);
        assert_eq!(seen.touching + seen.dropped, counts.touching, "{step}");
        assert_eq!(few.len(), 2.min(counts.touching as usize), "{step}");
        // A pair that has a manifold keeps it.
        for (_, manifold) in few.iter_mut() {
            for point in manifold.points_mut() {
                assert_eq!(point.impulse[0] as u32, point.age, "{step}");
                point.impulse[0] += 1.0;
            }
        }
        dropped += seen.dropped;
    }
    assert!(dropped > 50, "{dropped}");
    let gone = Pose::from_translation(DVec3::Z * 90.0).unwrap();
    assert_eq!((on_slab.update(slab, &whole, gone, &settings).touching, on_slab.is_empty()), (0, true));
    on_floor.clear();
    assert!(on_floor.is_empty() && on_floor.iter().next().is_none() && on_floor.get([0, 0]).is_none());
}

/// The answers of all pairs by themselves: whether one hits for certain, the first t of these, and
/// the interval of the first hit.
fn first_of(all: impl Iterator<Item = Impact>) -> (Option<f64>, [f64; 2]) {
    let (mut t, mut lower, mut upper) = (None, f64::INFINITY, f64::INFINITY);
    for found in all.filter(|found| found.hit) {
        lower = lower.min(found.t_lower);
        if found.status != Status::Touching {
            t = Some(t.map_or(found.t, |best: f64| best.min(found.t)));
            upper = upper.min(found.t_upper);
        }
    }
    (t, [lower, upper])
}

#[test]
fn casts_agree_with_all_pairs() {
    let (mut hits, mut tried, mut queried, mut all) = (0, 0, 0, 0);
    for (name, a, b) in pairings() {
        let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
        let mut cache = Cache::new();
        let mut rng = SplitMix64::new(SEED + 40);
        for (number, pose) in poses(600, 4.0, SEED + 40).into_iter().enumerate() {
            // Towards a point near A, at any speed; some are too short.
            let aim = DVec3::from_array(rng.direction()) * rng.between(0.0, 4.0);
            let motion = Motion::new((aim - pose.translation()) * rng.between(0.2, 2.0)).unwrap();
            let settings = CastSettings { max_t: [1.0, f64::INFINITY][number % 2], ..CastSettings::default() };
            let each: Vec<_> = pairs(&a, &b)
                .map(|(_, a, b)| hullmap::cast(&a, &b, pose, motion, &settings, &mut Cache::new()))
                .collect();
            let slow = each.iter().map(|found| found.support_calls).sum::<u32>();
            let (t, [lower, upper]) = first_of(each.into_iter());
            let found = hullmap::cast(&whole_a, &whole_b, pose, motion, &settings, &mut cache);
            let (answer, at) = (found, format!("{name}: pose {number}, seed {SEED:#x}: {:?}", found));
            assert_eq!(answer.hit, lower.is_finite(), "{at}");
            tried += 1;
            let Some(t) = t else { continue };
            assert!(answer.status != Status::Touching, "{at}");
            assert!(answer.t_lower <= upper && lower <= answer.t_upper, "{at}, {lower} to {upper}");
            assert!(answer.t_lower <= answer.t && answer.t <= answer.t_upper, "{at}");
            assert!((answer.t - t).abs() * motion.velocity().length() < 2e-5, "{at}: {t}");
            let [hull_a, hull_b] =
                [(&a, found.parts[0]), (&b, found.parts[1])].map(|(pack, part)| pack.hull(part as usize).unwrap());
            let alone = hullmap::cast(&hull_a, &hull_b, pose, motion, &settings, &mut Cache::new());
            assert!(alone.hit && alone.t_lower <= answer.t_upper, "{at}: {alone:?}");
            hits += 1;
            (queried, all) = (queried + found.support_calls, all + slow);
        }
    }
    println!("{hits} of {tried} hit; {queried} of {all} support queries");
    assert!((tried * 3 / 10..=tried * 7 / 10).contains(&hits), "{hits} of {tried} hit");
    assert!(queried * 2 < all, "{queried} of {all}");
}

#[test]
fn rays_and_half_space_casts_agree_with_all_parts() {
    let settings = CastSettings::default();
    let (mut hits, mut tried, mut queried, mut all) = (0, 0, 0, 0);
    for (name, pack) in [("three", pack(3, 1.0, 41)), ("forty", pack(40, 1.5, 42))] {
        let whole = Compound::new(&pack);
        let mut rng = SplitMix64::new(SEED + 41);
        for number in 0..2_000 {
            let origin = DVec3::from_array(rng.direction()) * rng.between(0.0, 5.0);
            let aim = DVec3::from_array(rng.direction()) * rng.between(0.0, 2.0);
            let ray = Ray::new(origin, (aim - origin) * rng.between(0.1, 3.0)).unwrap();
            let each: Vec<_> = pack.hulls().map(|hull| hullmap::ray(&hull, &ray, &settings)).collect();
            let slow = each.iter().map(|found| found.support_calls).sum::<u32>();
            let each = each.into_iter().map(|found| {
                let RayHit { hit, status, t, t_lower, t_upper, support_calls, .. } = found;
                Impact { hit, status, t, t_lower, t_upper, support_calls, ..Impact::default() }
            });
            let (t, [lower, upper]) = first_of(each);
            let found = hullmap::ray(&whole, &ray, &settings);
            let (answer, at) = (found, format!("{name}: ray {number}, seed {SEED:#x}: {:?}", found));
            assert_eq!(answer.hit, lower.is_finite(), "{at}");
            tried += 1;
            let Some(t) = t else { continue };
            // No cache: the same bits as the part by itself.
            assert_eq!(answer.t, t, "{at}");
            assert_eq!([answer.t_lower, answer.t_upper], [lower, upper], "{at}");
            let part = hullmap::ray(&pack.hull(found.part as usize).unwrap(), &ray, &settings);
            assert_eq!((part.t, part.normal, part.point), (answer.t, answer.normal, answer.point), "{at}");
            hits += 1;
            (queried, all) = (queried + found.support_calls, all + slow);
        }
        let wall = HalfSpace::new(DVec3::new(0.3, -0.5, 0.8), 0.2).unwrap();
        for pose in poses(300, 6.0, SEED + 42) {
            let motion = Motion::new(DVec3::from_array(rng.direction())).unwrap();
            let cast =
                |hull: hullmap::Hull<'_>| hullmap::cast(&wall, &hull, pose, motion, &settings, &mut Cache::new());
            let (t, [lower, upper]) = first_of(pack.hulls().map(cast));
            let found = hullmap::cast(&wall, &whole, pose, motion, &settings, &mut Cache::new());
            assert_eq!(found.hit, lower.is_finite(), "{found:?}");
            if let Some(t) = t {
                assert_eq!((found.t, found.t_lower, found.t_upper), (t, lower, upper), "{found:?}");
            }
        }
    }
    println!("{hits} of {tried} hit; {queried} of {all} support queries");
    assert!((tried * 3 / 10..=tried * 7 / 10).contains(&hits), "{hits} of {tried} hit");
    assert!(queried * 3 < 2 * all, "{queried} of {all}");
}

/// Two boxes with a common face, and a floor below: a ball slides down along them, at a distance of
/// its radius, and lands on the floor.
#[test]
fn a_ball_that_grazes_a_part_meets_it_before_the_part_behind() {
    let part = |low: [f32; 3], high: [f32; 3]| point_set("part", &packs::corners(low, high));
    let pack = packs::parts(&[
        part([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0]),
        part([0.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
        part([-9.0, -9.0, -3.0], [9.0, 9.0, -2.0]),
    ]);
    let (ball, start) = (Sphere::new(0.5).unwrap(), Pose::from_translation(DVec3::new(1.5, 0.0, 5.0)).unwrap());
    let (down, settings) = (Motion::new(DVec3::NEG_Z).unwrap(), CastSettings::default());
    let ball: &(dyn Shape + Sync) = &ball;
    let found = hullmap::cast(&Compound::new(&pack), ball, start, down, &settings, &mut Cache::new());
    assert!(found.hit && found.status == Status::Stalled, "{found:?}");
    assert!((found.t - 4.0).abs() < 0.5 && found.t_upper > 6.4, "{found:?}");
}

/// Boxes are their own bounding boxes, so a gap of a few ulps could mislead a stage.
#[test]
fn one_ulp_gap_between_boxes() {
    let pack = packs::tree_pack(&packs::corners([0.0; 3], [1.0; 3]));
    let hull = pack.hull(0).unwrap();
    for turn in [DQuat::IDENTITY, DQuat::from_rotation_z(0.3), DQuat::from_xyzw(0.1, 0.7, -0.2, 0.5).normalize()] {
        let way = turn * DVec3::Y;
        let low = SupportMap::support_point(&hull, turn.inverse() * -way).point;
        for ulps in -40..40 {
            let on = way * (1.0 + f64::from(ulps) * f64::EPSILON) - turn * low + DVec3::new(0.2, 0.0, 0.3);
            let pose = Pose::new(on, turn).unwrap();
            let full = hullmap::intersects(&hull, &hull, pose, &mut Cache::new());
            let found = hullmap::intersects(&pack, &pack, pose, &mut Cache::with_pairs(1));
            assert_eq!(found.is_hit(), full.is_hit(), "{ulps}: {found:?} {full:?}");
        }
    }
}

/// A stored axis answers the next query of separated hulls, with one support query at most.
#[test]
fn a_stored_axis_separates_hulls_of_packs_again() {
    println!("seed {SEED:#x}");
    let families = [Family::Rock, Family::CubeGrid, Family::Lens, Family::Cone];
    let packs = families.map(|family| packs::tree_pack(&family.points(200, 1)));
    let (mut asked, mut separated) = (0, 0);
    for (a, b) in packs.iter().flat_map(|a| packs.iter().map(move |b| (a, b))) {
        let reach: f64 = [a, b].map(|pack| pack.hull(0).unwrap().outer_radius()).iter().sum();
        for pose in poses(40, reach, SEED) {
            let mut cache = Cache::with_pairs(1);
            let cold = hullmap::intersects(a, b, pose, &mut cache);
            if cold.status == Overlap::Separated {
                let warm = hullmap::intersects(a, b, pose, &mut cache);
                assert!(warm.status == Overlap::Separated && warm.support_calls <= 1, "{pose:?}: {cold:?} {warm:?}");
                separated += 1;
                asked += usize::from(cold.support_calls > 1);
            }
        }
    }
    println!("{separated} separated, {asked} of them after more than one support query");
    assert!(asked > 50, "not representative: {asked} of {separated}");
}
