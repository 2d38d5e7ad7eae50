//! Tests that batches return the same bits as single queries, under every plan.

use std::fmt::Debug;

use glam::{DQuat, DVec3};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{ALL_INDICES, bytes, point_set};
use shapes::{families, rng::SplitMix64};

use super::pair::has_facets;
use super::plan::Plan;
use super::*;
use crate::pack::Pack;
use crate::shapes::{Capsule, Cuboid, Cylinder, Rounded, Scaled, Sphere};
use crate::solver::queries;
use crate::{Hull, Overlap, Pose, Status};

type AnyShape<'h> = dyn Shape + Sync + 'h;
type AnyPair<'s, 'h> = Pair<'s, AnyShape<'h>, AnyShape<'h>>;

fn packs() -> Vec<Pack> {
    // Hulls with trees of many sizes, one without an index, a flat one, and a segment.
    let sheet = (0..9).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.0]).collect();
    let trees: [Vec<[f32; 3]>; 8] = [
        families::rock(300, 1),
        families::sphere(20, 2),
        families::sphere(900, 3),
        families::sphere(60, 4),
        families::prism(130, 5),
        families::cube_grid(64, 1),
        sheet,
        vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.5]],
    ];
    let trees = trees.map(|points| (points, IndexKind::Tree));
    let others = [IndexKind::Medium].into_iter().chain(ALL_INDICES).map(|kind| (families::rock(150, 6), kind));
    trees.into_iter().chain(others).map(|(points, kind)| pack(&points, kind)).collect()
}

fn pack(points: &[[f32; 3]], kind: IndexKind) -> Pack {
    Pack::from_bytes(&bytes(&[point_set("hull", points)], kind, &SourceRecord::default()).unwrap()).unwrap()
}

fn shapes(packs: &[Pack]) -> Vec<Box<AnyShape<'_>>> {
    let hulls: Vec<Hull<'_>> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let mut shapes: Vec<Box<AnyShape<'_>>> = hulls.iter().map(|hull| Box::new(*hull) as _).collect();
    shapes.extend([
        Box::new(Cuboid::new(DVec3::ONE).unwrap()) as Box<AnyShape<'_>>,
        Box::new(Sphere::new(0.7).unwrap()),
        Box::new(Capsule::new(0.5, 0.3).unwrap()),
        Box::new(Cylinder::new(0.5, 0.7).unwrap()),
        Box::new(Rounded::new(hulls[0], 0.1).unwrap()),
        Box::new(Scaled::new(hulls[2], DVec3::new(-1.0, 0.5, 0.7)).unwrap()),
    ]);
    shapes
}

fn random_pose(rng: &mut SplitMix64) -> Pose {
    let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
    // Some shapes are centred on each other, some far apart, most close to touching.
    let reach = [0.0, 1e6, 1.0, 1.5, 2.0, 2.2][rng.between(0.0, 6.0) as usize];
    Pose::new(DVec3::from_array(rng.direction()) * reach, rotation).unwrap()
}

/// Answers `count` random pairs in both ways, in several frames, and returns all answers.
/// Answers and caches are equal bit by bit, on first queries and on warm ones.
fn compare<T: Clone + Debug + Default>(
    shapes: &[Box<AnyShape<'_>>],
    rng: &mut SplitMix64,
    count: usize,
    single: impl Fn(&AnyPair<'_, '_>, &mut Cache) -> T,
    in_flight: impl Fn(&[AnyPair<'_, '_>], &mut [Cache], &mut [T]),
) -> Vec<T> {
    let mut all = Vec::new();
    let mut pairs: Vec<AnyPair<'_, '_>> = Vec::new();
    for _ in 0..count {
        let [a, b] = [(); 2].map(|()| &*shapes[rng.below(shapes.len())]);
        pairs.push(Pair { a, b, b_in_a: Pose::IDENTITY });
    }
    let start =
        |i: usize| if i.is_multiple_of(8) { Cache::from_axis(DVec3::new(1.0, 0.5, -0.3)) } else { Cache::new() };
    let mut singles: Vec<Cache> = (0..count).map(start).collect();
    let mut caches = singles.clone();
    for frame in 0..4 {
        for pair in &mut pairs {
            pair.b_in_a = match frame {
                0 | 2 => random_pose(rng),
                _ => pair.b_in_a.moved(DVec3::from_array(rng.direction()) * 0.01),
            };
        }
        let mut out = vec![T::default(); count];
        in_flight(&pairs, &mut caches, &mut out);
        for (i, (pair, cache)) in pairs.iter().zip(&mut singles).enumerate() {
            let expected = single(pair, cache);
            // Debug output distinguishes zeros by their signs, and NaN equals NaN.
            assert_eq!(format!("{:?}", out[i]), format!("{expected:?}"), "pair {i} of {count}, frame {frame}");
            assert_eq!(*cache, caches[i], "cache of pair {i} of {count}, frame {frame}");
        }
        all.extend(out);
    }
    all
}

const COUNTS: [usize; 8] = [0, 1, 3, 4, 5, 9, 64, 1000];

/// Settings with few and with many steps.
fn all_settings() -> [Settings; 6] {
    let of = |tolerance, max_iterations| Settings { tolerance, max_iterations };
    let usual = Settings::default();
    [usual, of(0.0, usual.max_iterations), of(0.1, 3), of(1e-5, 0), of(1e-5, 1), of(f64::NAN, 12)]
}

/// Answers all pairs by one plan.
type Answer<'f, T> = &'f dyn Fn(&[AnyPair<'_, '_>], &Settings, &mut [Cache], &mut [T]);

/// The least number of answers of a kind, and whether an answer is of that kind.
type Kind<'f, T> = (usize, &'f dyn Fn(&T) -> bool);

/// Answers of many pairs under every plan, and with all settings.
fn compare_plans<T: Clone + Debug + Default>(
    seed: u64,
    single: impl Fn(&AnyPair<'_, '_>, &Settings, &mut Cache) -> T,
    plans: [Answer<'_, T>; 2],
) -> Vec<T> {
    println!("seed {seed}");
    let mut rng = SplitMix64::new(seed);
    let packs = packs();
    let (shapes, mut found) = (shapes(&packs), Vec::new());
    for settings in &all_settings() {
        for (count, plan) in COUNTS.into_iter().flat_map(|count| plans.map(|plan| (count, plan))) {
            let single = |pair: &AnyPair<'_, '_>, cache: &mut Cache| single(pair, settings, cache);
            found.extend(compare(&shapes, &mut rng, count, single, |pairs, caches, out| {
                plan(pairs, settings, caches, out)
            }));
        }
    }
    found
}

/// Asserts that there are enough answers of each kind.
fn assert_counts<T>(found: &[T], kinds: &[Kind<'_, T>]) {
    for (kind, (least, is_kind)) in kinds.iter().enumerate() {
        let count = found.iter().filter(|found| is_kind(found)).count();
        assert!(count >= *least, "kind {kind}: {count} of {}", found.len());
    }
}

#[test]
fn intersections_have_the_bits_of_single_queries() {
    let found = compare_plans(
        17,
        |pair, _, cache| queries::intersects(pair.a, pair.b, pair.b_in_a, cache),
        [
            &|pairs, _, caches, out| {
                in_flight::answer_all::<_, _, IntersectionQuery, IN_FLIGHT>(pairs, &(), caches, out);
            },
            &|pairs, _, caches, out| ahead::answer_all::<_, _, IntersectionQuery>(pairs, &(), caches, out),
        ],
    );
    assert_counts(&found, &[(9000, &|y| y.status == Overlap::Overlapping), (9000, &|y| !y.is_hit())]);
}

#[test]
fn distances_have_the_bits_of_single_queries() {
    let found = compare_plans(
        18,
        |pair, settings, cache| queries::distance(pair.a, pair.b, pair.b_in_a, settings, cache),
        [
            &|pairs, settings, caches, out| {
                in_flight::answer_all::<_, _, DistanceQuery, IN_FLIGHT>(pairs, settings, caches, out);
            },
            &|pairs, settings, caches, out| {
                ahead::answer_all::<_, _, DistanceQuery>(pairs, settings, caches, out);
            },
        ],
    );
    assert_counts(
        &found,
        &[
            (10_000, &|d| d.lower > 0.0),
            (10_000, &|d| d.status == Status::Overlapping),
            (2000, &|d| d.status == Status::IterationLimit),
            (1, &|d| d.status == Status::Touching),
        ],
    );
}

#[test]
fn contacts_have_the_bits_of_single_queries() {
    let found = compare_plans(
        19,
        |pair, settings, cache| queries::contact(pair.a, pair.b, pair.b_in_a, settings, cache),
        [
            &|pairs, settings, caches, out| {
                in_flight::answer_all::<_, _, ContactQuery, CONTACTS_IN_FLIGHT>(pairs, settings, caches, out);
            },
            &|pairs, settings, caches, out| ahead::contact(pairs, settings, caches, out),
        ],
    );
    // More than 80 iterations take the third size of polytopes.
    assert_counts(
        &found,
        &[
            (10_000, &|c| c.hit),
            (10_000, &|c| !c.hit),
            (40, &|c| c.iterations > 80),
            (2000, &|c| c.status == Status::IterationLimit),
        ],
    );
}

/// Most pairs of the tests above are in flight, also with the separating axis test.
#[test]
fn only_rounded_shapes_are_answered_at_once() {
    let packs = packs();
    let shapes = shapes(&packs);
    let (mut rounded, mut faceted, mut suspended) = (0, 0, 0);
    for (a, b) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (a, b))) {
        let pair: AnyPair<'_, '_> = Pair { a: &**a, b: &**b, b_in_a: Pose::IDENTITY };
        let is_rounded = in_flight::is_rounded(&pair);
        rounded += usize::from(is_rounded);
        faceted += usize::from(!is_rounded && has_facets(&pair));
        suspended += usize::from(!is_rounded);
    }
    assert!(rounded > 50 && faceted > 5 && suspended > 2 * rounded, "{:?}", [rounded, faceted, suspended]);
}

#[test]
fn support_points_are_those_of_single_queries() {
    let packs = packs();
    let shapes = shapes(&packs);
    let mut rng = SplitMix64::new(3);
    let odd = [0.0, f64::NAN, 1e300, 1e-300, 5e-324, f64::INFINITY, 1e-30, 1e38];
    let queries: Vec<_> = (0..4000)
        .map(|i| {
            let scale = if i % 5 == 0 { odd[i / 5 % odd.len()] } else { 1.0 };
            let axis = DVec3::AXES[i % 3];
            let dir = if i % 7 == 0 { axis } else { DVec3::from_array(rng.direction()) };
            SupportQuery { shape: &*shapes[i % shapes.len()], dir: dir * scale }
        })
        .collect();
    for count in [0, 1, 8, 9, 4000] {
        let mut out = vec![SupportPoint { point: DVec3::NAN, feature: 77 }; count];
        for solve in [in_flight::support_points, ahead::support_points] {
            out.fill(SupportPoint { point: DVec3::NAN, feature: 77 });
            solve(&queries[..count], &mut out);
            for (query, found) in queries.iter().zip(&out) {
                let expected = query.shape.support_point(query.dir);
                assert_eq!((found.point, found.feature), (expected.point, expected.feature), "{}", query.dir);
            }
        }
    }
}

#[test]
fn manifolds_have_the_bits_of_single_updates() {
    let seed = 20;
    println!("seed {seed}");
    let mut rng = SplitMix64::new(seed);
    let packs = packs();
    let shapes = shapes(&packs);
    let settings = ManifoldSettings::default();
    let single = |pair: &AnyPair<'_, '_>, cache: &mut Cache| {
        let mut manifold = Manifold::new();
        manifold.update(pair.a, pair.b, pair.b_in_a, &settings, cache);
        manifold
    };
    let ahead = |pairs: &[AnyPair<'_, '_>], caches: &mut [Cache], out: &mut [Manifold]| {
        ahead::manifolds(pairs, &settings, caches, out);
    };
    let found = compare(&shapes, &mut rng, 1000, single, ahead);
    let hits = found.iter().filter(|manifold| !manifold.points().is_empty()).count();
    assert!(hits > 1000 && found.len() - hits > 1000, "{hits} of {}", found.len());
}

/// The public functions, on scenes for which they choose every plan.
#[test]
fn every_plan_has_the_bits_of_single_queries() {
    let settings = Settings::default();
    let mut plans = Vec::new();
    // A copy of a hull has an address of its own, and counts as another shape.
    for (vertices, copies) in [(20, 2), (20, 1500), (100, 120), (100, 800), (600, 20), (600, 200)] {
        let pack = pack(&families::rock(vertices, 7), IndexKind::Tree);
        let hulls = vec![pack.hull(0).unwrap(); copies];
        let mut rng = SplitMix64::new(21);
        let pairs: Vec<Pair<'_, Hull<'_>, Hull<'_>>> = (0..2000)
            .map(|_| {
                let [a, b] = [(); 2].map(|()| &hulls[rng.below(copies)]);
                Pair { a, b, b_in_a: random_pose(&mut rng) }
            })
            .collect();
        plans.push([Plan::of_pairs(&pairs), Plan::of_contacts(&pairs)]);
        let mut caches = [(); 3].map(|()| vec![Cache::new(); pairs.len()]);
        let mut found =
            (vec![Intersection::default(); 2000], vec![Distance::default(); 2000], vec![Contact::default(); 2000]);
        intersects(&pairs, &mut caches[0], &mut found.0).unwrap();
        distance(&pairs, &settings, &mut caches[1], &mut found.1).unwrap();
        contact(&pairs, &settings, &mut caches[2], &mut found.2).unwrap();
        for (i, Pair { a, b, b_in_a }) in pairs.iter().enumerate() {
            let mut single = [(); 3].map(|()| Cache::new());
            assert_eq!(found.0[i], queries::intersects(*a, *b, *b_in_a, &mut single[0]));
            assert_eq!(found.1[i], queries::distance(*a, *b, *b_in_a, &settings, &mut single[1]));
            assert_eq!(found.2[i], queries::contact(*a, *b, *b_in_a, &settings, &mut single[2]));
            assert!((0..3).all(|query| caches[query][i] == single[query]));
        }
    }
    use Plan::{Ahead, InFlight, Loop};
    let expected = [[Loop; 2], [Ahead; 2], [Ahead; 2], [InFlight, Ahead], [Ahead; 2], [InFlight; 2]];
    assert_eq!(plans, expected);
}
