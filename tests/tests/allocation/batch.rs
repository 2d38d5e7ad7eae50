//! Batches of pairs: no allocation per pair.

use glam::{DQuat, DVec3};
use hullmap::batch::{self, BatchError, Pair};
use hullmap::shapes::{Capsule, Cuboid, Cylinder, Rounded, Scaled, Sphere};
use hullmap::{Cache, Contact, Distance, Intersection, Manifold, ManifoldSettings, Pack, Pose, Settings, Shape};
use hullmap_bake::IndexKind;
use hullmap_testkit::packs::pack;
use hullmap_testkit::random::RandomPoses;
use shapes::{families::Family, rng::SplitMix64};

use crate::{allocations, alone};

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
            let turn = DQuat::from_axis_angle(rng.unit_vector(), rng.between(0.0, 6.3));
            let far = rng.unit_vector() * rng.between(0.0, 3.0);
            Pair { a, b, b_in_a: Pose::new(far, turn).unwrap() }
        })
        .collect()
}

/// The answers of a batch.
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

/// The thread pool allocates a little for a batch of any length. The queries allocate nothing, also
/// if they are in flight, or fetch memory ahead: large sets of shapes are larger than the caches,
/// since each copy counts as another shape.
#[test]
fn nothing_is_allocated_for_a_pair() {
    let _alone = alone();
    let check = |name: &str, shapes: &[Box<Any<'_>>], threads: usize| {
        let pairs = pairs(shapes);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (mut answers, mut caches) = result_slots(&pairs);
        pool.install(|| solve(&pairs, &mut answers, &mut caches));
        let least = allocations(|| pool.install(|| solve(&pairs, &mut answers, &mut caches)));
        println!("{name}, {threads} threads: {least} allocations for {} answers", 4 * PAIRS);
        assert!(least < PAIRS / 20, "{name}, {threads} threads: {least} allocations");
        let share = answers.contacts.iter().filter(|contact| contact.hit).count() as f64 / PAIRS as f64;
        assert!((0.2..0.8).contains(&share), "{name} is not representative: {share} of the pairs overlap");
    };
    let packs = packs();
    let all = shapes(&packs);
    check("all shapes", &all, 1);
    check("all shapes", &all, 2);
    for (vertices, copies) in [(30, 3000), (100, 1000), (600, 300)] {
        let pack = pack("hull", &Family::Rock.points(vertices, 1), IndexKind::Tree);
        let shapes: Vec<Box<Any<'_>>> = (0..copies).map(|_| Box::new(pack.hull(0).unwrap()) as _).collect();
        check(&format!("{vertices} vertices"), &shapes, 1);
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
