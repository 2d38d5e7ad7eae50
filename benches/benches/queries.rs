//! Rays, shape casts and points against one hull, and the same for parry3d's convex polyhedron
//! (f32). `cargo bench -p hullmap-bench --bench queries`.
//!
//! A run of the closure is a batch of [`BATCH`] queries. The paths of rays and casts lead through
//! the ball of 0.6 times the hull's radius, so that nearly all of them hit. Caches are empty.

use std::{cell::RefCell, fmt, rc::Rc};

use divan::{Bencher, black_box, counter::ItemsCount};
use glam::{DQuat, DVec3};
use hullmap::{Cache, CastSettings, Motion, Pose, Ray, Settings, SupportMap, cast, ray, signed_distance};
use hullmap_bench::{solver::pairs::BakedPair, subject::SEED};
use parry3d::{math, query, query::PointQuery, query::RayCast};
use shapes::{families::Family, rng::SplitMix64};

/// Queries of one batch.
const BATCH: usize = 256;

const COUNTS: [usize; 5] = [32, 128, 512, 2048, 8192];

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Ray,
    Cast,
    Outside,
    Inside,
}

const KINDS: [(Kind, &str); 4] =
    [(Kind::Ray, "ray"), (Kind::Cast, "cast"), (Kind::Outside, "point outside"), (Kind::Inside, "point inside")];

/// A query of an engine on a rock of `n` points.
#[derive(Clone, Copy)]
struct Case {
    kind: (Kind, &'static str),
    n: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.kind.1, self.n)
    }
}

thread_local! {
    /// Pairs baked so far.
    static PAIRS: RefCell<Vec<(usize, Rc<BakedPair>)>> = const { RefCell::new(Vec::new()) };
}

fn pair(n: usize) -> Rc<BakedPair> {
    PAIRS.with_borrow_mut(|pairs| {
        if let Some((_, pair)) = pairs.iter().find(|(of, _)| *of == n) {
            return Rc::clone(pair);
        }
        let pair = Rc::new(BakedPair::bake(Family::Rock, n, SEED).expect("parry takes the hull"));
        pairs.push((n, Rc::clone(&pair)));
        pair
    })
}

/// The start, displacement and rotation of each path.
fn paths(radius: f64, center: DVec3) -> Vec<(DVec3, DVec3, DQuat)> {
    let mut rng = SplitMix64::new(SEED);
    let mut unit = || DVec3::from_array(rng.direction());
    let one = |_| {
        let (from, to, turn) = (unit() * 4.0 * radius, unit() * 0.6 * radius, unit());
        (center + from, to - from, DQuat::from_axis_angle(turn, 1.0))
    };
    (0..BATCH).map(one).collect()
}

fn cases() -> impl Iterator<Item = Case> {
    KINDS.into_iter().flat_map(|kind| COUNTS.map(|n| Case { kind, n }))
}

#[divan::bench(args = cases())]
fn hullmap(bencher: Bencher<'_, '_>, case: Case) {
    let pair = pair(case.n);
    let [a, b] = pair.hulls();
    let paths = paths(a.outer_radius(), a.interior_point());
    let (settings, accuracy) = (CastSettings::default(), Settings::default());
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for &(from, along, turn) in black_box(&paths) {
            match case.kind.0 {
                Kind::Ray => {
                    black_box(ray(&a, &Ray::new(from, along).expect("finite"), &settings));
                }
                Kind::Cast => {
                    let start = Pose::new(from, turn).expect("finite");
                    let motion = Motion::new(along).expect("finite");
                    black_box(cast(&a, &b, start, motion, &settings, &mut Cache::new()));
                }
                Kind::Outside | Kind::Inside => {
                    let point = if case.kind.0 == Kind::Outside { from + along * 0.4 } else { from + along };
                    let found = signed_distance(&a, point, &accuracy, &mut Cache::new());
                    black_box(found.expect("finite"));
                }
            }
        }
    });
}

#[divan::bench(args = cases())]
fn parry(bencher: Bencher<'_, '_>, case: Case) {
    let pair = pair(case.n);
    let [hull, _] = pair.hulls();
    let paths = paths(hull.outer_radius(), hull.interior_point());
    let [a, b] = pair.polyhedra();
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for &(from, along, turn) in black_box(&paths) {
            let (from, along) = (from.as_vec3(), along.as_vec3());
            match case.kind.0 {
                Kind::Ray => {
                    black_box(a.cast_local_ray_and_get_normal(&query::Ray::new(from, along), f32::MAX, true));
                }
                Kind::Cast => {
                    let start = math::Pose::from_parts(from, turn.as_quat());
                    let still = math::Vector::ZERO;
                    let options = query::ShapeCastOptions::default();
                    black_box(query::cast_shapes(&math::Pose::IDENTITY, still, a, &start, along, b, options))
                        .expect("parry supports two polyhedra");
                }
                Kind::Outside | Kind::Inside => {
                    let point = if case.kind.0 == Kind::Outside { from + along * 0.4 } else { from + along };
                    black_box(a.project_local_point(point, false));
                }
            }
        }
    });
}

fn main() {
    divan::main();
}
