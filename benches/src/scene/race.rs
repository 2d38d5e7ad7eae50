//! Interleaved timing of the engines in one scene, in one thread.
//!
//! In each round every engine answers one *window* of the pairs: of all random pairs, or of the
//! neighbours in one frame of the crowd. Windows of parry3d are shorter, since a long one would
//! take minutes, but move through all pairs as well. So hulls are as cold for one engine as for
//! another.
//!
//! A window is timed in pieces of a few queries, in processor time of the thread, so that other
//! programs do not count. The result is the median over the pieces of all rounds.

use std::hint::black_box;

use glam::{DVec3, Vec3};
use hullmap::SupportMap as _;
use hullmap::{
    Cache, Contact, Distance, Hull, Intersection, Manifold, ManifoldSettings, Prediction, Settings, SupportPoint, batch,
};
use parry3d::{
    math,
    query::{self, ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher},
    shape::SupportMap as _,
};

use super::{
    Scene,
    pairs::{Crowd, ScenePair, random},
};
use crate::{
    clock::{median, time_ns},
    directions,
    subject::SEED,
};

/// Kind of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneQuery {
    /// A support vertex in a random direction.
    Support,
    /// Yes or no.
    Intersects,
    /// Distance and nearest points.
    Distance,
    /// Penetration depth, normal and points.
    Contact,
    /// Contact manifold.
    Manifold,
}

impl SceneQuery {
    /// All queries, in the order of tables.
    pub const ALL: [SceneQuery; 5] =
        [SceneQuery::Support, SceneQuery::Intersects, SceneQuery::Distance, SceneQuery::Contact, SceneQuery::Manifold];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            SceneQuery::Support => "support",
            SceneQuery::Intersects => "intersects",
            SceneQuery::Distance => "distance",
            SceneQuery::Contact => "contact",
            SceneQuery::Manifold => "manifold",
        }
    }
}

/// Engine that answers a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// hullmap, one query after the other.
    Loop,
    /// hullmap's `batch`, in one thread.
    Batch,
    /// parry3d.
    Parry,
}

impl Engine {
    /// All engines, in the order of tables.
    pub const ALL: [Engine; 3] = [Engine::Loop, Engine::Batch, Engine::Parry];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Engine::Loop => "loop",
            Engine::Batch => "batch",
            Engine::Parry => "parry3d",
        }
    }
}

/// How the queries follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Random pairs, with empty caches of the solver.
    Random,
    /// Neighbours in a moving crowd, with a cache for each pair.
    Crowd,
}

impl Order {
    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Order::Random => "random pairs",
            Order::Crowd => "moving crowd",
        }
    }
}

/// Measuring effort.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of random pairs, and of support queries.
    pub pairs: usize,
    /// Minimum number of bodies in the crowd.
    pub bodies: usize,
    /// Rounds.
    pub rounds: usize,
    /// Approximate number of vertices that parry3d reads in a window.
    pub parry_work: usize,
}

impl Effort {
    /// The whole table, in a few minutes; it takes longer if `--max-mib` is raised.
    pub const FULL: Self = Self { pairs: 8192, bodies: 1000, rounds: 9, parry_work: 1 << 18 };
    /// A short table, in less than a minute.
    pub const QUICK: Self = Self { pairs: 2048, bodies: 216, rounds: 3, parry_work: 1 << 15 };
}

/// Median time of a query.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// How the queries follow each other.
    pub order: Order,
    /// Kind of the query.
    pub query: SceneQuery,
    /// Engine that answers.
    pub engine: Engine,
    /// Median over the pieces, in nanoseconds per query.
    pub ns: f64,
}

/// Times of all queries in one scene.
pub fn run(scene: &Scene, vertices: usize, effort: Effort) -> Vec<Cell> {
    let hulls = scene.hulls();
    let mut cells = Vec::new();
    supports(scene, &hulls, effort, &mut cells);
    let pairs = random(&hulls, effort.pairs);
    let crowd = Crowd::new(effort.bodies.max(hulls.len()), hulls.len());
    for query in &SceneQuery::ALL[1..] {
        let mut bench = Bench::new(scene, &hulls, *query, vertices, effort);
        bench.random(&pairs);
        cells.extend(bench.cells(Order::Random));
        let mut bench = Bench::new(scene, &hulls, *query, vertices, effort);
        bench.crowd(&crowd);
        cells.extend(bench.cells(Order::Crowd));
    }
    cells
}

/// Number of hullmap's queries in a piece, the same one by one and in a batch: the pieces of a
/// crowd differ, so medians over other pieces would differ too. The size of a batch decides how it
/// works.
const PIECE: usize = 1024;

/// Number of parry3d's queries in a piece: one of each class.
const PARRY_PIECE: usize = 3;

/// Adds the time of `work` to `times`, in nanoseconds per item.
fn record(times: &mut Vec<f64>, items: usize, work: impl FnOnce()) {
    times.push(time_ns(work) / items as f64);
}

fn supports(scene: &Scene, hulls: &[Hull<'_>], effort: Effort, cells: &mut Vec<Cell>) {
    let count = effort.pairs;
    let picks = random(hulls, count);
    let queries: Vec<(usize, Vec3)> =
        picks.iter().zip(directions::random(count, SEED)).map(|(pair, dir)| (pair.a, dir)).collect();
    let batched: Vec<_> =
        queries.iter().map(|(hull, dir)| batch::SupportQuery { shape: &hulls[*hull], dir: dir.as_dvec3() }).collect();
    let mut found = vec![SupportPoint { point: DVec3::ZERO, feature: 0 }; count];
    let mut times = [const { Vec::new() }; Engine::ALL.len()];
    for _ in 0..effort.rounds {
        for piece in batched.chunks(PIECE) {
            record(&mut times[Engine::Loop as usize], piece.len(), || {
                for query in piece {
                    black_box(query.shape.support_point(query.dir));
                }
            });
        }
        for (piece, found) in batched.chunks(PIECE).zip(found.chunks_mut(PIECE)) {
            record(&mut times[Engine::Batch as usize], piece.len(), || {
                batch::support_points(piece, found).expect(EQUAL_LENGTHS);
            });
        }
        black_box(&mut found);
        for piece in queries.chunks(PIECE) {
            record(&mut times[Engine::Parry as usize], piece.len(), || {
                for (hull, dir) in piece {
                    black_box(scene.polyhedra[*hull].local_support_point(*dir));
                }
            });
        }
    }
    cells.extend(Engine::ALL.into_iter().zip(times).filter_map(|(engine, times)| {
        Some(Cell { order: Order::Random, query: SceneQuery::Support, engine, ns: median(times)? })
    }));
}

/// State of one query's race.
struct Bench<'s> {
    scene: &'s Scene,
    hulls: &'s [Hull<'s>],
    query: SceneQuery,
    effort: Effort,
    /// Number of pairs that parry answers in a round.
    parry_window: usize,
    times: [Vec<f64>; Engine::ALL.len()],
}

/// Answers of a batch of any query.
struct Answers {
    caches: Vec<Cache>,
    intersections: Vec<Intersection>,
    distances: Vec<Distance>,
    contacts: Vec<Contact>,
    manifolds: Vec<Manifold>,
}

const EQUAL_LENGTHS: &str = "the slices have equal lengths";

impl<'s> Bench<'s> {
    fn new(scene: &'s Scene, hulls: &'s [Hull<'s>], query: SceneQuery, vertices: usize, effort: Effort) -> Self {
        let parry_window = (effort.parry_work / vertices).max(16);
        Self { scene, hulls, query, effort, parry_window, times: Default::default() }
    }

    fn cells(self, order: Order) -> impl Iterator<Item = Cell> {
        let query = self.query;
        Engine::ALL
            .into_iter()
            .zip(self.times)
            .filter_map(move |(engine, times)| Some(Cell { order, query, engine, ns: median(times)? }))
    }

    /// All pairs with empty caches, in each round.
    fn random(&mut self, pairs: &[ScenePair]) {
        let mut answers = self.answers(pairs.len());
        for round in 0..self.effort.rounds {
            answers.caches.fill(Cache::default());
            self.one_by_one(pairs, &mut answers);
            answers.caches.fill(Cache::default());
            self.in_a_batch(pairs, &mut answers);
            self.parry(pairs, round);
        }
    }

    /// A frame in each round, with warm caches. The first frame is not timed.
    fn crowd(&mut self, crowd: &Crowd) {
        let mut singles = self.answers(crowd.pair_count());
        let mut batches = self.answers(crowd.pair_count());
        for frame in 0..=self.effort.rounds {
            let pairs = crowd.frame(frame);
            self.one_by_one(&pairs, &mut singles);
            self.in_a_batch(&pairs, &mut batches);
            self.parry(&pairs, frame);
            if frame == 0 {
                self.times.iter_mut().for_each(Vec::clear);
            }
        }
    }

    fn answers(&self, count: usize) -> Answers {
        let caches = vec![Cache::default(); count];
        let of = |query| if self.query == query { count } else { 0 };
        Answers {
            caches,
            intersections: vec![Intersection::default(); of(SceneQuery::Intersects)],
            distances: vec![Distance::default(); of(SceneQuery::Distance)],
            contacts: vec![Contact::default(); of(SceneQuery::Contact)],
            manifolds: vec![Manifold::new(); of(SceneQuery::Manifold)],
        }
    }

    fn one_by_one(&mut self, pairs: &[ScenePair], answers: &mut Answers) {
        let (settings, manifold_settings) = (Settings::default(), manifold_settings());
        let (hulls, query) = (self.hulls, self.query);
        let mut each = |i: usize, pair: &ScenePair| {
            let (a, b, cache) = (&hulls[pair.a], &hulls[pair.b], &mut answers.caches[i]);
            match query {
                SceneQuery::Support | SceneQuery::Intersects => {
                    answers.intersections[i] = hullmap::intersects(a, b, pair.placed.b_in_a, cache);
                }
                SceneQuery::Distance => {
                    answers.distances[i] = hullmap::distance(a, b, pair.placed.b_in_a, &settings, cache)
                }
                SceneQuery::Contact => {
                    answers.contacts[i] = hullmap::contact(a, b, pair.placed.b_in_a, &settings, cache)
                }
                SceneQuery::Manifold => {
                    answers.manifolds[i].update(a, b, pair.placed.b_in_a, &manifold_settings, cache);
                }
            }
        };
        for (number, piece) in pairs.chunks(PIECE).enumerate() {
            record(&mut self.times[Engine::Loop as usize], piece.len(), || {
                piece.iter().enumerate().for_each(|(i, pair)| each(number * PIECE + i, pair));
            });
        }
    }

    fn in_a_batch(&mut self, pairs: &[ScenePair], answers: &mut Answers) {
        let pair = |pair: &ScenePair| batch::Pair {
            a: &self.hulls[pair.a],
            b: &self.hulls[pair.b],
            b_in_a: pair.placed.b_in_a,
        };
        let pairs: Vec<batch::Pair<'_, Hull<'_>, Hull<'_>>> = pairs.iter().map(pair).collect();
        let (settings, manifold_settings) = (Settings::default(), manifold_settings());
        for (number, piece) in pairs.chunks(PIECE).enumerate() {
            let at = number * PIECE..number * PIECE + piece.len();
            let caches = &mut answers.caches[at.clone()];
            record(&mut self.times[Engine::Batch as usize], piece.len(), || {
                let done = match self.query {
                    SceneQuery::Support | SceneQuery::Intersects => {
                        batch::intersects(piece, caches, &mut answers.intersections[at])
                    }
                    SceneQuery::Distance => batch::distance(piece, &settings, caches, &mut answers.distances[at]),
                    SceneQuery::Contact => batch::contact(piece, &settings, caches, &mut answers.contacts[at]),
                    SceneQuery::Manifold => {
                        batch::manifolds(piece, &manifold_settings, caches, &mut answers.manifolds[at])
                    }
                };
                done.expect(EQUAL_LENGTHS);
            });
        }
    }

    /// The next window of the pairs.
    fn parry(&mut self, pairs: &[ScenePair], round: usize) {
        const SUPPORTED: &str = "parry supports two polyhedra";
        let window = self.parry_window.min(pairs.len());
        let from = (round * window) % (pairs.len() - window + 1);
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        let mut workspace = None;
        let identity = math::Pose::IDENTITY;
        let (query, polyhedra) = (self.query, &self.scene.polyhedra);
        let mut each = |pair: &ScenePair| {
            let (a, b, pose) = (&polyhedra[pair.a], &polyhedra[pair.b], &pair.placed.parry);
            match query {
                SceneQuery::Support | SceneQuery::Intersects => {
                    black_box(query::intersection_test(&identity, a, pose, b).expect(SUPPORTED));
                }
                SceneQuery::Distance => _ = black_box(query::distance(&identity, a, pose, b).expect(SUPPORTED)),
                SceneQuery::Contact => _ = black_box(query::contact(&identity, a, pose, b, 0.0).expect(SUPPORTED)),
                SceneQuery::Manifold => {
                    manifolds.clear();
                    let prediction = PREDICTION as f32;
                    DefaultQueryDispatcher
                        .contact_manifolds(pose, a, b, prediction, &mut manifolds, &mut workspace)
                        .expect(SUPPORTED);
                }
            }
        };
        for piece in pairs[from..from + window].chunks(PARRY_PIECE) {
            record(&mut self.times[Engine::Parry as usize], piece.len(), || piece.iter().for_each(&mut each));
        }
    }
}

/// Prediction of manifolds, where hulls have a radius of about 1.
const PREDICTION: f64 = 0.02;

fn manifold_settings() -> ManifoldSettings {
    ManifoldSettings { prediction: Prediction::Length(PREDICTION), ..ManifoldSettings::default() }
}
