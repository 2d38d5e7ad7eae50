//! Queries between whole packs, compared with their slow twin: a query of each pair of hulls.

use glam::{DQuat, DVec3};
use hullmap::{Cache, Compound, CompoundCache, Contact, Overlap, Pack, Pose, Settings, Status, compound};
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0xc0_11de;

/// A pack of `count` rocks, boxes, lenses and cones in a ball of radius `radius`: a concave shape
/// with holes.
fn pack(count: usize, radius: f64, seed: u64) -> Pack {
    let mut rng = SplitMix64::new(seed);
    let hulls: Vec<_> = (0..count)
        .map(|number| {
            let place = rng.direction().map(|c| c * radius * rng.between(0.3, 1.0));
            let family = [Family::Rock, Family::CubeGrid, Family::Lens, Family::Cone][number % 4];
            let size = 0.15 + 0.25 * rng.between(0.0, 1.0);
            let points = family.points(40, number as u64);
            let positions: Vec<[f32; 3]> =
                points.iter().map(|p| std::array::from_fn(|i| (f64::from(p[i]) * size + place[i]) as f32)).collect();
            let source_vertices = (0..positions.len() as u32).collect();
            let set = PointSet { name: number.to_string(), positions, source_vertices, ..PointSet::default() };
            bake_hull(&set, IndexKind::Tree).unwrap()
        })
        .collect();
    Pack::from_bytes(&write_pack(&hulls, &SourceRecord::default()).unwrap()).unwrap()
}

fn poses(count: usize, reach: f64, seed: u64) -> Vec<Pose> {
    let mut rng = SplitMix64::new(seed);
    (0..count)
        .map(|_| {
            let translation = DVec3::from_array(rng.direction()) * reach * rng.between(0.2, 1.0);
            let axis = DVec3::from_array(rng.direction());
            Pose::new(translation, DQuat::from_axis_angle(axis, rng.between(0.0, 6.0))).unwrap()
        })
        .collect()
}

/// Pairs of packs with few and with many parts, one of them with a single hull.
fn pairings() -> Vec<(&'static str, Pack, Pack)> {
    vec![
        ("three and five", pack(3, 1.0, 1), pack(5, 1.0, 2)),
        ("twenty and twelve", pack(20, 1.2, 3), pack(12, 1.2, 4)),
        ("one and thirty", pack(1, 0.5, 5), pack(30, 1.5, 6)),
    ]
}

fn pairs<'a>(a: &'a Pack, b: &'a Pack) -> impl Iterator<Item = ([usize; 2], hullmap::Hull<'a>, hullmap::Hull<'a>)> {
    a.hulls().enumerate().flat_map(|(i, hull_a)| b.hulls().enumerate().map(move |(j, hull_b)| ([i, j], hull_a, hull_b)))
}

#[test]
fn intersection_agrees_with_all_pairs() {
    let (mut hits, mut tried, mut queried, mut all) = (0, 0, 0, 0);
    for (name, a, b) in pairings() {
        let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
        let mut cache = CompoundCache::new(8);
        for (number, pose) in poses(1_500, 2.0, SEED).into_iter().enumerate() {
            let slow = pairs(&a, &b)
                .any(|(_, a, b)| hullmap::intersects(&a, &b, pose, &mut Cache::new()).status == Overlap::Overlapping);
            let fast = compound::intersects(&whole_a, &whole_b, pose, &mut cache);
            assert_eq!(fast.answer.status == Overlap::Overlapping, slow, "{name}: pose {number}, seed {SEED:#x}");
            assert_eq!(fast.answer.is_hit(), slow, "{name}: pose {number}");
            let fresh = compound::intersects(&whole_a, &whole_b, pose, &mut CompoundCache::new(0));
            assert_eq!(fresh.answer.status, fast.answer.status, "{name}: pose {number}");
            if slow {
                let [hull_a, hull_b] = [a.hull(fast.hulls[0]).unwrap(), b.hull(fast.hulls[1]).unwrap()];
                assert!(hullmap::intersects(&hull_a, &hull_b, pose, &mut Cache::new()).is_hit());
            }
            hits += usize::from(slow);
            tried += 1;
            queried += fresh.pairs as usize;
            all += a.hull_count() * b.hull_count();
        }
    }
    println!("{hits} of {tried} overlap; {queried} of {all} pairs queried");
    assert!((tried * 3 / 10..=tried * 7 / 10).contains(&hits), "{hits} of {tried} overlap");
    assert!(queried * 10 < all, "{queried} of {all}");
}

#[test]
fn distance_is_the_minimum_over_all_pairs() {
    let settings = Settings::default();
    let (mut separated, mut tried, mut queried, mut all) = (0, 0, 0, 0);
    for (name, a, b) in pairings() {
        let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
        let mut cache = CompoundCache::default();
        for (number, pose) in poses(700, 2.7, SEED + 1).into_iter().enumerate() {
            let each = pairs(&a, &b).map(|(_, a, b)| hullmap::distance(&a, &b, pose, &settings, &mut Cache::new()));
            let (mut lower, mut upper) = (f64::INFINITY, f64::INFINITY);
            each.for_each(|found| (lower, upper) = (lower.min(found.lower), upper.min(found.upper)));
            let fast = compound::distance(&whole_a, &whole_b, pose, &settings, &mut cache);
            let found = fast.answer;
            // Both intervals contain the distance.
            assert!(found.lower <= upper && lower <= found.upper, "{name}: pose {number}, seed {SEED:#x}: {found:?}");
            assert!(found.upper - found.lower <= 2e-5 * found.upper + 1e-12, "{name}: pose {number}: {found:?}");
            assert_eq!(found.status == Status::Overlapping, upper == 0.0, "{name}: pose {number}");
            if upper > 0.0 {
                let between = found.point_b - found.point_a;
                assert!((between.length() - found.distance).abs() <= 1e-12 * (1.0 + found.distance));
                separated += 1;
                queried += fast.pairs as usize;
                all += a.hull_count() * b.hull_count();
            }
            tried += 1;
        }
    }
    println!("{separated} of {tried} separated; {queried} of {all} pairs queried");
    assert!((tried * 3 / 10..=tried * 8 / 10).contains(&separated), "{separated} of {tried} separated");
    assert!(queried * 10 < all, "{queried} of {all}");
}

#[test]
fn contacts_agree_with_all_pairs_and_contact_is_the_deepest() {
    let settings = Settings::default();
    let (mut touching, mut tried, mut met) = (0, 0, 0);
    for (name, a, b) in pairings() {
        let (whole_a, whole_b) = (Compound::new(&a), Compound::new(&b));
        let mut cache = CompoundCache::default();
        for (number, pose) in poses(500, 2.0, SEED + 2).into_iter().enumerate() {
            let slow: Vec<([usize; 2], Contact)> = pairs(&a, &b)
                .map(|(pair, a, b)| (pair, hullmap::contact(&a, &b, pose, &settings, &mut Cache::new())))
                .filter(|(_, found)| found.hit)
                .collect();
            let mut fast: Vec<([usize; 2], Contact)> = Vec::new();
            let sum = compound::contacts(&whole_a, &whole_b, pose, &settings, &mut cache, |pair, found| {
                fast.push((pair, *found));
            });
            fast.sort_by_key(|(pair, _)| *pair);
            assert_eq!(sum.hits as usize, fast.len());
            assert!(fast.iter().map(|(pair, _)| pair).eq(slow.iter().map(|(pair, _)| pair)), "{name}: pose {number}");
            for ((_, fast), (_, slow)) in fast.iter().zip(&slow) {
                assert!(
                    fast.depth_lower <= slow.depth_upper && slow.depth_lower <= fast.depth_upper,
                    "{name}: {number}"
                );
            }
            let deepest = compound::contact(&whole_a, &whole_b, pose, &settings, &mut cache);
            let greatest = |of: fn(&Contact) -> f64| slow.iter().map(|(_, found)| of(found)).fold(0.0, f64::max);
            match deepest {
                None => assert!(slow.is_empty(), "{name}: pose {number}"),
                Some(found) => {
                    let (lower, upper) = (greatest(|c| c.depth_lower), greatest(|c| c.depth_upper));
                    assert!(found.answer.depth_lower <= upper && lower <= found.answer.depth_upper, "{name}: {number}");
                    assert!(slow.iter().any(|(pair, _)| *pair == found.hulls));
                }
            }
            touching += usize::from(!slow.is_empty());
            met += slow.len();
            tried += 1;
        }
    }
    println!("{touching} of {tried} in contact, {met} pairs");
    assert!((tried * 3 / 10..=tried * 7 / 10).contains(&touching), "{touching} of {tried}");
}

/// A single hull as a compound gives the same answers as the hull itself.
#[test]
fn a_hull_is_a_compound_of_one() {
    let (a, b) = (pack(4, 1.0, 1), pack(9, 1.0, 7));
    let whole = Compound::new(&b);
    let mut hits = 0;
    for pose in poses(600, 2.4, SEED + 3) {
        for hull in a.hulls() {
            let one = Compound::from(hull);
            assert_eq!(one.hull_count(), 1);
            let fast = compound::intersects(&one, &whole, pose, &mut CompoundCache::new(1));
            let turned = compound::intersects(&whole, &one, pose.inverse(), &mut CompoundCache::new(1));
            let slow = b.hulls().any(|other| hullmap::intersects(&hull, &other, pose, &mut Cache::new()).is_hit());
            assert_eq!([fast.answer.is_hit(), turned.answer.is_hit()], [slow; 2]);
            hits += usize::from(slow);
        }
    }
    assert!((250..2_000).contains(&hits), "{hits}");
}

/// The cache of other compounds with more hulls never leads to a hull that does not exist.
#[test]
fn a_stale_cache_never_changes_an_answer() {
    let (large, small) = (pack(12, 1.0, 1), pack(2, 0.7, 2));
    let mut cache = CompoundCache::new(4);
    for pose in poses(200, 2.0, SEED + 4) {
        let far =
            compound::distance(&Compound::new(&large), &Compound::new(&large), pose, &Settings::default(), &mut cache);
        assert!(far.hulls.iter().all(|hull| *hull < 12));
        let (a, b) = (Compound::new(&small), Compound::new(&small));
        let found = compound::intersects(&a, &b, pose, &mut cache);
        let slow = compound::intersects(&a, &b, pose, &mut CompoundCache::default());
        assert_eq!(found.answer.status, slow.answer.status);
        cache.clear();
    }
}
