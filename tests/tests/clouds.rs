//! Small clouds of game data, many of them slivers or nearly flat, and large ones of families known to be hard.
//!
//! The clouds are those of the file that `HULLMAP_HULLS` names. Each is baked with every kind of index and asked in many directions, the truth being
//! brute force.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    time::Instant,
};

use glam::{DVec3, Vec3};
use hullmap::Hull;
use hullmap_bake::IndexKind;
use hullmap_tests::{directions, game_hulls, packs::pack, regret::Truth};
use shapes::families::Family;

/// Regret up to which a support query counts as exact.
const EXACT: f64 = 2e-7;

/// Most that a source point may lie outside its hull, over the diameter.
const CONTAINMENT: f64 = 1e-7;

/// Directions for each cloud and index, beside its faces' normals.
const DIRECTIONS: usize = 500;

const SEED: u64 = 0xc10d;

const INDICES: [IndexKind; 5] = [
    IndexKind::TREE,
    IndexKind::Binary,
    IndexKind::CubeMap { resolution: 1 },
    IndexKind::CubeMap { resolution: 8 },
    IndexKind::None,
];

/// Directions that a hull may get wrong: those of [`directions::all`], and every face's normal.
fn all_directions(hull: &Hull) -> Vec<Vec3> {
    let mut dirs = directions::all(hull, DIRECTIONS, SEED);
    let vertices: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
    for face in hull.faces() {
        let corners: Vec<DVec3> = face.map(|v| vertices[v as usize]).collect();
        let spokes = corners.windows(2).map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
        let normal = spokes.sum::<DVec3>().normalize_or_zero().as_vec3();
        dirs.extend([normal, -normal].into_iter().filter(|dir| *dir != Vec3::ZERO));
    }
    assert!(dirs.len() >= DIRECTIONS);
    dirs
}

/// What came out for the clouds of one rank.
#[derive(Debug, Default)]
struct Seen {
    clouds: usize,
    points: usize,
    vertices: usize,
    containment_error: f64,
    regret: f64,
    directions: usize,
}

/// Bakes a cloud with every index and checks it; adds to what was seen of its rank.
fn check(name: &str, points: &[[f32; 3]], seen: &Mutex<BTreeMap<u32, Seen>>) {
    let truth = Truth::new(points);
    let mut this = Seen { clouds: 1, points: points.len(), ..Seen::default() };
    let mut rank = None;
    for index in INDICES {
        let pack = pack(name, points, index);
        let hull = pack.hull(0).unwrap();
        assert_eq!(*rank.get_or_insert(hull.rank()), hull.rank(), "{name}: the rank does not depend on the index");
        assert!(hull.containment_error() <= CONTAINMENT, "{name}: {}", hull.containment_error());
        this.containment_error = this.containment_error.max(hull.containment_error());
        this.vertices = hull.vertex_count();
        let most = hull.worst_cost();
        for dir in all_directions(&hull) {
            let got = hull.support(dir);
            assert_eq!(hull.vertex(got.index), Some(got.point), "{name}, {index:?}");
            let cost = hull.support_cost(dir);
            assert!(cost.nodes <= most.nodes && cost.dots <= most.dots, "{name}, {index:?}: {cost:?} exceeds {most:?}");
            let regret = truth.regret(dir, got.point);
            assert!(regret.abs() <= EXACT, "{name}, {index:?}: regret {regret:e} in direction {dir}, seed {SEED:#x}");
            this.regret = this.regret.max(regret);
            this.directions += 1;
        }
        for vertex in hull.vertices() {
            assert!(points.contains(&vertex.to_array()), "{name}: {vertex} is no source point");
        }
    }
    let mut seen = seen.lock().unwrap();
    let sum = seen.entry(rank.unwrap()).or_default();
    sum.clouds += 1;
    sum.points += this.points;
    sum.vertices += this.vertices;
    sum.directions += this.directions;
    sum.containment_error = sum.containment_error.max(this.containment_error);
    sum.regret = sum.regret.max(this.regret);
}

#[test]
fn every_cloud_of_game_data_bakes_and_answers_exactly() {
    let Some(clouds) = game_hulls::clouds("the clouds of game data") else { return };
    let (seen, next) = (Mutex::new(BTreeMap::new()), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(cloud) = clouds.get(number) else { break };
                    check(&format!("cloud {number}"), cloud, &seen);
                }
            });
        }
    });
    let seen = seen.into_inner().unwrap();
    println!("{} clouds, seed {SEED:#x}", clouds.len());
    for (rank, sum) in &seen {
        println!("rank {rank}: {sum:?}");
    }
    assert_eq!(seen.values().map(|sum| sum.clouds).sum::<usize>(), clouds.len());
    assert!(clouds.len() >= 3_000 && seen.contains_key(&3), "the file is not the one that this test is for");
}

/// How long each takes is printed, not asserted: tests run unoptimised, and on any machine.
#[test]
fn twenty_thousand_points_bake() {
    for family in [Family::Sphere, Family::Lens, Family::RotatedPrism, Family::Prism] {
        let points = family.points(20_000, 7);
        let truth = Truth::new(&points);
        let start = Instant::now();
        let pack = pack(family.name(), &points, IndexKind::TREE);
        let elapsed = start.elapsed();
        let hull = pack.hull(0).unwrap();
        assert_eq!(hull.rank(), 3);
        assert!(hull.containment_error() <= CONTAINMENT);
        // A point may be rounded into the hull of its neighbours, but not many.
        assert!(hull.vertex_count() > 15_000, "{}: {} vertices", family.name(), hull.vertex_count());
        let mut worst: f64 = 0.0;
        for dir in directions::all(&hull, DIRECTIONS, SEED) {
            let regret = truth.regret(dir, hull.support(dir).point);
            assert!(regret.abs() <= EXACT, "{}: {regret:e} in direction {dir}, seed {SEED:#x}", family.name());
            worst = worst.max(regret);
        }
        println!("{:14} {} vertices, {elapsed:.1?}, worst regret {worst:.1e}", family.name(), hull.vertex_count());
    }
}

/// The truth of the tests above, tried on hulls that are wrong: each vertex in turn is left out.
#[test]
fn a_lost_vertex_is_noticed() {
    let points = Family::Rock.points(40, 3);
    let truth = Truth::new(&points);
    for lost in 0..points.len() {
        let mut rest = points.clone();
        rest.remove(lost);
        let pack = pack("rest", &rest, IndexKind::TREE);
        let hull = pack.hull(0).unwrap();
        let worst = all_directions(&hull).into_iter().map(|dir| truth.regret(dir, hull.support(dir).point));
        assert!(worst.fold(0.0, f64::max) > 1e3 * EXACT, "vertex {lost}, seed {SEED:#x}");
    }
}
