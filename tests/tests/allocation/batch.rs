//! Batches of pairs: the same bits on any number of threads, and no allocation per pair.

use glam::{DQuat, DVec3};
use hullmap::batch::{self, BatchError, Pair};
use hullmap::shapes::{Capsule, Cuboid, Cylinder, Rounded, Scaled, Sphere};
use hullmap::{Cache, Contact, Distance, Intersection, Manifold, ManifoldSettings, Pack, Pose, Settings, Shape};
use hullmap_bake::IndexKind;
use hullmap_testkit::packs::pack;
use shapes::{families::Family, rng::SplitMix64};
use stats_alloc::Region;

use crate::{ALLOCATOR, alone};

const SEED: u64 = 0xba7c;
const PAIRS: usize = 4000;

type Any<'h> = dyn Shape + Sync + 'h;

fn packs() -> Vec<Pack> {
    let families = [Family::Rock, Family::Prism, Family::Sphere, Family::Cone];
    families.into_iter().map(|family| pack("hull", &family.points(300, 1), IndexKind::Tree)).collect()
}

fn shapes(packs: &[Pack]) -> Vec<Box<Any<'_>>> {
    let hull = |i: usize| packs[i].hull(0).unwrap();
    vec![
        Box::new(hull(0)),
        Box::new(hull(1)),
        Box::new(hull(2)),
        Box::new(hull(3)),
        Box::new(Sphere::new(0.8).unwrap()),
        Box::new(Cuboid::new(DVec3::new(0.5, 0.8, 1.0)).unwrap()),
        Box::new(Capsule::new(0.5, 0.3).unwrap()),
        Box::new(Cylinder::new(0.5, 0.7).unwrap()),
        Box::new(Rounded::new(hull(0), 0.1).unwrap()),
        Box::new(Scaled::new(hull(3), DVec3::new(-1.0, 0.5, 0.7)).unwrap()),
    ]
}

fn pairs<'s, 'h>(shapes: &'s [Box<Any<'h>>]) -> Vec<Pair<'s, Any<'h>, Any<'h>>> {
    let mut rng = SplitMix64::new(SEED);
    (0..PAIRS)
        .map(|_| {
            let mut any = || &*shapes[rng.below(shapes.len())];
            let (a, b) = (any(), any());
            let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.3));
            let far = DVec3::from_array(rng.direction()) * rng.between(0.0, 3.0);
            Pair { a, b, b_in_a: Pose::new(far, turn).unwrap() }
        })
        .collect()
}

/// All answers of two frames; the second has warm caches.
#[derive(Clone, PartialEq, Debug)]
struct Answers {
    contacts: Vec<Contact>,
    distances: Vec<Distance>,
    intersections: Vec<Intersection>,
    manifolds: Vec<Manifold>,
}

/// Space for answers, filled with arbitrary values.
fn result_slots(pairs: &[Pair<Any<'_>, Any<'_>>]) -> (Answers, [Vec<Cache>; 4]) {
    // As any shape, so that the solver is not compiled for spheres, too.
    let ball: &Any<'_> = &Sphere::new(1.0).unwrap();
    let (settings, cache) = (Settings::default(), &mut Cache::new());
    let answers = Answers {
        contacts: vec![hullmap::contact(ball, ball, Pose::IDENTITY, &settings, cache); pairs.len()],
        distances: vec![hullmap::distance(ball, ball, Pose::IDENTITY, &settings, cache); pairs.len()],
        intersections: vec![hullmap::intersects(ball, ball, Pose::IDENTITY, cache); pairs.len()],
        manifolds: vec![Manifold::new(); pairs.len()],
    };
    (answers, [(); 4].map(|()| vec![Cache::new(); pairs.len()]))
}

fn solve(pairs: &[Pair<Any<'_>, Any<'_>>], answers: &mut Answers, caches: &mut [Vec<Cache>; 4]) {
    let [c, d, i, m] = caches;
    batch::contact(pairs, &Settings::default(), c, &mut answers.contacts).unwrap();
    batch::distance(pairs, &Settings::default(), d, &mut answers.distances).unwrap();
    batch::intersects(pairs, i, &mut answers.intersections).unwrap();
    batch::manifolds(pairs, &ManifoldSettings::default(), m, &mut answers.manifolds).unwrap();
}

fn on_threads(threads: usize, pairs: &[Pair<Any<'_>, Any<'_>>]) -> Vec<Answers> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (mut answers, mut caches) = result_slots(pairs);
    (0..2)
        .map(|_| {
            pool.install(|| solve(pairs, &mut answers, &mut caches));
            answers.clone()
        })
        .collect()
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let _alone = alone();
    println!("seed {SEED:#x}");
    let packs = packs();
    let shapes = shapes(&packs);
    let pairs = pairs(&shapes);
    let one = on_threads(1, &pairs);
    for threads in [2, 3, 8] {
        let many = on_threads(threads, &pairs);
        assert!(many == one, "{threads} threads");
    }
    let (settings, mut caches) = (Settings::default(), vec![Cache::new(); pairs.len()]);
    let mut hits = 0;
    for frame in &one {
        for (i, (pair, cache)) in pairs.iter().zip(&mut caches).enumerate() {
            let single = hullmap::contact(pair.a, pair.b, pair.b_in_a, &settings, cache);
            assert_eq!(single, frame.contacts[i], "in the pairs' order: {i}");
            assert_eq!(single.hit, frame.intersections[i].is_hit(), "{i}");
            assert_eq!(single.hit, frame.distances[i].distance == 0.0, "{i}");
            assert!(!single.hit || !frame.manifolds[i].points().is_empty(), "{i}");
            hits += usize::from(single.hit);
        }
    }
    let share = hits as f64 / (2 * PAIRS) as f64;
    assert!((0.3..0.7).contains(&share), "not representative: {share} of the pairs overlap");
}

/// The thread pool allocates a little for a batch of any length. The queries allocate nothing.
#[test]
fn nothing_is_allocated_for_a_pair() {
    let _alone = alone();
    let packs = packs();
    let shapes = shapes(&packs);
    let pairs = pairs(&shapes);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (mut answers, mut caches) = result_slots(&pairs);
        pool.install(|| solve(&pairs, &mut answers, &mut caches));
        // The harness may allocate at the same time, so the minimum of several tries counts.
        let counts = (0..20).map(|_| {
            let region = Region::new(ALLOCATOR);
            pool.install(|| solve(&pairs, &mut answers, &mut caches));
            region.change().allocations + region.change().reallocations
        });
        let least = counts.min().unwrap();
        println!("{threads} threads: {least} allocations for {} answers", 4 * PAIRS);
        assert!(least < PAIRS / 20, "{threads} threads: {least} allocations");
    }
    // Control: the counter counts an allocation.
    let region = Region::new(ALLOCATOR);
    drop(std::hint::black_box(vec![0_u8; 100]));
    assert!(region.change().allocations > 0);
    // A single update of a manifold allocates nothing at all.
    let mut manifold = Manifold::new();
    let mut cache = Cache::new();
    let least = (0..1000)
        .map(|i| {
            let pair = &pairs[i];
            let region = Region::new(ALLOCATOR);
            manifold.update(pair.a, pair.b, pair.b_in_a, &ManifoldSettings::default(), &mut cache);
            region.change().allocations
        })
        .filter(|count| *count == 0)
        .count();
    assert!(least > 900, "updates without an allocation: {least} of 1000");
}

/// Queries are in flight, or fetch memory ahead: the shapes are larger than the caches, since each
/// copy counts as another shape.
#[test]
fn nothing_is_allocated_for_a_pair_in_flight() {
    let _alone = alone();
    for (vertices, copies) in [(30, 3000), (100, 1000), (600, 300)] {
        let pack = pack("hull", &Family::Rock.points(vertices, 1), IndexKind::Tree);
        let shapes: Vec<Box<Any<'_>>> = (0..copies).map(|_| Box::new(pack.hull(0).unwrap()) as _).collect();
        let pairs = pairs(&shapes);
        let (mut answers, mut caches) = result_slots(&pairs);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| solve(&pairs, &mut answers, &mut caches));
        let counts = (0..5).map(|_| {
            let region = Region::new(ALLOCATOR);
            pool.install(|| solve(&pairs, &mut answers, &mut caches));
            region.change().allocations + region.change().reallocations
        });
        let least = counts.min().unwrap();
        println!("{vertices} vertices: {least} allocations for {} answers", 4 * PAIRS);
        assert!(least < PAIRS / 20, "{vertices} vertices: {least} allocations");
    }
}

#[test]
fn slices_of_different_lengths_are_an_error() {
    let _alone = alone();
    let packs = packs();
    let shapes = shapes(&packs);
    let pairs = pairs(&shapes);
    let mut manifolds = vec![Manifold::new(); 3];
    let mut caches = vec![Cache::new(); 2];
    let error = batch::manifolds(&pairs[..3], &ManifoldSettings::default(), &mut caches, &mut manifolds).unwrap_err();
    assert_eq!(error, BatchError { pairs: 3, caches: 2, answers: 3 });
    assert_eq!(
        error.to_string(),
        "a batch of 3 pairs requires 3 caches and 3 answers, found 2 and 3: pass slices of equal length"
    );
    assert!(manifolds.iter().all(|m| m.points().is_empty()));
    assert!(batch::intersects::<Any, Any>(&[], &mut [], &mut []).is_ok());
}
