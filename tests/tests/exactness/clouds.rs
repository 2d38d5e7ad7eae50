//! Small clouds of game data, many of them slivers or nearly flat, and large ones of families known
//! to be hard.
//!
//! The clouds come from the file that `HULLMAP_HULLS` names. Each is baked with every index kind
//! and queried in many directions. Brute force gives the expected answers.

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
use hullmap_testkit::packs::pack;
use hullmap_tests::{directions, game_hulls, regret::Truth};
use shapes::{families::Family, rng::SplitMix64};

/// Regret up to which a support query counts as exact.
const EXACT: f64 = 2e-7;

/// Maximum distance of a source point from its hull, relative to the diameter.
const CONTAINMENT: f64 = 1e-7;

/// Directions for each cloud and index, beside its faces' normals.
const DIRECTIONS: usize = 500;

const SEED: u64 = 0xc10d;

const INDICES: [IndexKind; 5] = [
    IndexKind::Tree,
    IndexKind::Binary,
    IndexKind::CubeMap { resolution: 1 },
    IndexKind::CubeMap { resolution: 8 },
    IndexKind::None,
];

/// Directions that a hull may get wrong: [`directions::all`], and every face's normal.
fn all_directions(hull: &Hull) -> Vec<Vec3> {
    let mut dirs = directions::all(hull, DIRECTIONS, SEED);
    let vertices: Vec<DVec3> = hull.vertices().map(|v| v.as_dvec3()).collect();
    for face in hull.faces() {
        let corners: Vec<DVec3> = face.map(|v| vertices[v as usize]).collect();
        let spokes = corners.windows(2).map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
        let normal = spokes.sum::<DVec3>().normalize_or_zero().as_vec3();
        dirs.extend([normal, -normal].into_iter().filter(|dir| *dir != Vec3::ZERO));
    }
    // Without faces there are no normals to add.
    let least = if hull.rank() < 2 { DIRECTIONS / 2 } else { DIRECTIONS };
    assert!(dirs.len() >= least, "{} directions, {} vertices", dirs.len(), vertices.len());
    dirs
}

/// Results for all clouds of one rank.
#[derive(Debug, Default)]
struct Seen {
    clouds: usize,
    points: usize,
    vertices: usize,
    containment_error: f64,
    regret: f64,
    directions: usize,
}

/// Bakes a cloud with every index, checks it, and adds the results to the sums of its rank.
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
        let max = hull.worst_cost();
        for dir in all_directions(&hull) {
            let got = hull.support(dir);
            assert_eq!(hull.vertex(got.index), Some(got.point), "{name}, {index:?}");
            let cost = hull.support_cost(dir);
            assert!(cost.nodes <= max.nodes && cost.dots <= max.dots, "{name}, {index:?}: {cost:?} exceeds {max:?}");
            let regret = truth.regret(dir, got.point);
            assert!(regret.abs() <= EXACT, "{name}, {index:?}: regret {regret:e} in direction {dir}, seed {SEED:#x}");
            this.regret = this.regret.max(regret);
            this.directions += 1;
        }
        for vertex in hull.vertices() {
            assert!(points.contains(&vertex.to_array()), "{name}: {vertex} is not a source point");
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
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(cloud) = clouds.get(index) else { break };
                    check(&format!("cloud {index}"), cloud, &seen);
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
    assert!(clouds.len() >= 3_000 && seen.contains_key(&3), "the file is not the one that this test expects");
}

/// Rings around the z axis, given by radius and height, without special cases for angles. The
/// computed sin(π) is not 0, so the ring at a pole has many points, 1e-16 apart.
fn rings(profile: &[[f64; 2]], segments: usize) -> Vec<DVec3> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / segments as f64;
    let ring = |[radius, z]: [f64; 2]| {
        (0..segments).map(move |i| DVec3::new(radius * libm::cos(angle(i)), radius * libm::sin(angle(i)), z))
    };
    profile.iter().copied().flat_map(ring).collect()
}

/// Spheres, capsules, cylinders, cones and tori: plain, scaled, moved, and turned by matrices that
/// contain such sines.
#[test]
fn shapes_of_raw_sines_bake() {
    use std::f64::consts::PI;
    let arc = |steps: usize, radius: f64, z: f64| -> Vec<[f64; 2]> {
        let angle = |i: usize| PI * i as f64 / steps as f64;
        (0..=steps).map(|i| [radius * libm::sin(angle(i)), z + radius * libm::cos(angle(i))]).collect()
    };
    let turn = |angle: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        move |p: DVec3| DVec3::new(p.x, cos * p.y - sin * p.z, sin * p.y + cos * p.z)
    };
    let mut clouds = Vec::new();
    for n in [3, 4, 5, 8, 12, 16, 24, 31] {
        let (steps, half) = (n / 2 + 1, n / 4 + 1);
        let capsule: Vec<[f64; 2]> = arc(2 * half, 1.0, 0.0)
            .into_iter()
            .enumerate()
            .map(|(i, [r, z])| [r, if i <= half { z + 1.0 } else { z - 1.0 }])
            .collect();
        let round = (0..n).map(|i| 2.0 * PI * i as f64 / n as f64);
        let torus: Vec<[f64; 2]> = round.map(|a| [2.0 + libm::cos(a), libm::sin(a)]).collect();
        for (name, profile) in [
            ("sphere", arc(steps, 1.0, 0.0)),
            ("capsule", capsule),
            ("cylinder", vec![[1e-16, 1.0], [1.0, 1.0], [1.0, -1.0], [1e-16, -1.0]]),
            ("cone", vec![[libm::sin(PI), 1.0], [1.0, 0.0], [libm::sin(2.0 * PI), 0.0]]),
            ("torus", torus),
        ] {
            let points = rings(&profile, n);
            let moves: [(&str, &dyn Fn(DVec3) -> DVec3); 6] = [
                ("plain", &|p| p),
                ("turned by 90°", &turn(PI / 2.0)),
                ("turned by 180°", &turn(PI)),
                ("turned twice", &|p| turn(PI / 2.0)(DVec3::new(turn(PI)(p).z, p.x, p.y))),
                ("small", &|p| p * 1e-3),
                ("moved", &|p| p + DVec3::new(0.0, 1e-3, 1.0)),
            ];
            for (how, transform) in moves {
                let cloud: Vec<[f32; 3]> = points.iter().map(|p| transform(*p).as_vec3().to_array()).collect();
                clouds.push((format!("{name} of {n}, {how}"), cloud));
            }
        }
    }
    let seen = Mutex::new(BTreeMap::new());
    clouds.iter().for_each(|(name, cloud)| check(name, cloud, &seen));
    let near_zero = |cloud: &[[f32; 3]]| cloud.iter().flatten().any(|c| *c != 0.0 && c.abs() < 1e-15);
    let count = clouds.iter().filter(|(_, cloud)| near_zero(cloud)).count();
    println!("{} clouds, {count} with numbers below 1e-15: {:?}", clouds.len(), seen.into_inner().unwrap());
    assert!(count > 150, "{count} of {}", clouds.len());
}

/// Clouds with coordinates of all magnitudes, over up to 140 octaves.
#[test]
fn coordinates_of_all_sizes_bake() {
    let mut rng = SplitMix64::new(SEED);
    let seen = Mutex::new(BTreeMap::new());
    for index in 0..1_500 {
        let (octaves, count) = ([20, 44, 60, 100, 140][index % 5], 4 + rng.below(40));
        let mut coordinate = || match rng.below(4) {
            0 => 0.0,
            1 => rng.between(-1.0, 1.0) as f32,
            _ => (rng.between(-1.0, 1.0) * 2_f64.powi(-(rng.below(octaves) as i32))) as f32,
        };
        let cloud: Vec<[f32; 3]> = (0..count).map(|_| std::array::from_fn(|_| coordinate())).collect();
        check(&format!("cloud {index}, {octaves} octaves"), &cloud, &seen);
    }
    println!("seed {SEED:#x}: {:?}", seen.into_inner().unwrap());
}

/// Times are printed, not asserted, because tests run unoptimized and on any machine.
#[test]
fn twenty_thousand_points_bake() {
    for family in [Family::Sphere, Family::Lens, Family::RotatedPrism, Family::Prism] {
        let points = family.points(20_000, 7);
        let truth = Truth::new(&points);
        let start = Instant::now();
        let pack = pack(family.name(), &points, IndexKind::Tree);
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

/// The comparison with the truth detects a wrong hull: each vertex is left out in turn.
#[test]
fn a_lost_vertex_is_detected() {
    let points = Family::Rock.points(40, 3);
    let truth = Truth::new(&points);
    for lost in 0..points.len() {
        let mut rest = points.clone();
        rest.remove(lost);
        let pack = pack("rest", &rest, IndexKind::Tree);
        let hull = pack.hull(0).unwrap();
        let worst = all_directions(&hull).into_iter().map(|dir| truth.regret(dir, hull.support(dir).point));
        assert!(worst.fold(0.0, f64::max) > 1e3 * EXACT, "vertex {lost}, seed {SEED:#x}");
    }
}
