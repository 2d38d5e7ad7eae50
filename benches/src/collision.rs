//! The paper's experiment (section 5): the time of many collision tests between two objects.
//!
//! The objects are [`BODIES`] rocks, random convex shapes, with n points each. A rock has the same
//! outline for every n, in different detail. A test is [`hullmap::intersects`] on a random pair in
//! a random pose, with an empty cache. A third of the poses penetrate, a third are within 2 % of
//! touching, a third are separated. The distance at which a pair touches is found by bisection for
//! every n, so that the mix is the same for every n. All indices get the same poses.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use glam::{DQuat, DVec3};
use hullmap::{Cache, Hull, Pack, Pose, SupportMap, intersects};
use hullmap_bake::IndexKind;
use shapes::{families::Family, rng::SplitMix64};

use crate::{
    solver::pairs::{Class, touching_distance},
    subject::Subject,
};

/// Number of different rocks.
pub const BODIES: u64 = 4;

/// Two bodies and the position of the second: along `direction`, at `share` times the distance at
/// which it touches the first.
#[derive(Clone, Copy, Debug)]
struct PosedPair {
    a: usize,
    b: usize,
    rotation: DQuat,
    direction: DVec3,
    share: f64,
}

/// Two bodies and their pose.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    a: usize,
    b: usize,
    b_in_a: Pose,
}

/// The tests, independent of the bodies' detail.
#[derive(Clone, Debug)]
pub struct Scene {
    pairs: Vec<PosedPair>,
}

/// All bodies with the same number of points and the same index.
pub struct Bodies {
    packs: Vec<Pack>,
}

/// Measurements of a run through a scene.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time until each checkpoint.
    pub times: Vec<Duration>,
    /// Tests that found an overlap.
    pub hits: usize,
    /// Number of support queries, on both bodies together.
    pub support_queries: u64,
}

impl Scene {
    /// `count` tests.
    pub fn new(count: usize, seed: u64) -> Self {
        let mut rng = SplitMix64::new(seed);
        let body = |rng: &mut SplitMix64| rng.below(BODIES as usize);
        let pairs = (0..count).map(|index| PosedPair {
            a: body(&mut rng),
            b: body(&mut rng),
            rotation: DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize(),
            direction: DVec3::from_array(rng.direction()),
            share: {
                let [low, high] = Class::ALL[index % Class::ALL.len()].shares();
                rng.between(low, high)
            },
        });
        Self { pairs: pairs.collect() }
    }

    /// Computes the poses of the pairs from the shapes of `bodies`.
    pub fn place(&self, bodies: &Bodies) -> Vec<Test> {
        let hulls = bodies.hulls();
        self.pairs.iter().map(|pair| pair.placed(&hulls)).collect()
    }
}

impl PosedPair {
    fn placed(&self, hulls: &[Hull<'_>]) -> Test {
        let (a, b) = (&hulls[self.a], &hulls[self.b]);
        let distance = touching_distance(a, b, self.rotation, self.direction) * self.share;
        let from = a.interior_point() - self.rotation * b.interior_point();
        let b_in_a = Pose::new(from + self.direction * distance, self.rotation).expect("finite");
        Test { a: self.a, b: self.b, b_in_a }
    }
}

impl Bodies {
    /// Bakes all bodies with `n` points each, once for each of `kinds`.
    pub fn bake<const K: usize>(n: usize, kinds: [IndexKind; K]) -> [Self; K] {
        let subjects: Vec<Subject> = (0..BODIES).map(|seed| Subject::new(Family::Rock, n, seed)).collect();
        kinds.map(|kind| Self { packs: subjects.iter().map(|subject| subject.pack(kind)).collect() })
    }

    fn hulls(&self) -> Vec<Hull<'_>> {
        self.packs.iter().map(|pack| pack.hull(0).expect("a pack has a hull")).collect()
    }

    /// Runs all `tests`, and records the time after every `step` of them.
    pub fn run(&self, tests: &[Test], step: usize) -> Run {
        let hulls = self.hulls();
        let mut run = Run { times: Vec::new(), hits: 0, support_queries: 0 };
        let start = Instant::now();
        for group in tests.chunks(step) {
            for test in black_box(group) {
                let found = intersects(&hulls[test.a], &hulls[test.b], test.b_in_a, &mut Cache::default());
                run.hits += usize::from(found.is_hit());
                run.support_queries += 2 * u64::from(found.support_calls);
            }
            run.times.push(start.elapsed());
        }
        run
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All indices do the same work: same answers, same number of queries, and a fair mix of both
    /// outcomes.
    #[test]
    fn all_index_kinds_find_the_same_collisions() {
        let scene = Scene::new(400, 7);
        for n in [8, 200] {
            let [scan, tree] = Bodies::bake(n, [IndexKind::None, IndexKind::Tree]);
            let tests = scene.place(&tree);
            let (scan, tree) = (scan.run(&tests, 100), tree.run(&tests, 100));
            assert_eq!((scan.hits, scan.support_queries), (tree.hits, tree.support_queries));
            assert_eq!(scan.times.len(), 4);
            assert!((160..=240).contains(&scan.hits), "n = {n}: {} of 400 overlap", scan.hits);
        }
    }
}
