//! Small clouds of game data, many of them slivers or nearly flat, and large ones of families known
//! to be hard.
//!
//! The clouds come from the file that `HULLMAP_HULLS` names. Each is baked with every index kind
//! and queried in many directions. Brute force gives the expected answers.

use glam::DVec3;
use hullmap_bake::IndexKind;
use hullmap_testkit::packs::{ALL_INDICES, pack};
use hullmap_tests::{directions, game_hulls, regret::Truth};
use rayon::prelude::*;
use shapes::{families::Family, rng::SplitMix64};

use crate::families::check;

/// Regret up to which a support query counts as exact.
const EXACT: f64 = 2e-7;

/// Directions for each cloud, beside its faces' normals.
const DIRECTIONS: usize = 180;

const SEED: u64 = 0xc10d;

#[test]
fn every_cloud_of_game_data_bakes_and_answers_exactly() {
    let Some(clouds) = game_hulls::clouds("the clouds of game data") else { return };
    clouds.par_iter().enumerate().for_each(|(index, cloud)| {
        check(&format!("cloud {index}"), cloud, &ALL_INDICES, DIRECTIONS, EXACT);
    });
    assert!(clouds.len() >= 3_000, "the file is not the one that this test expects");
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
    clouds.iter().for_each(|(name, cloud)| drop(check(name, cloud, &ALL_INDICES, DIRECTIONS, EXACT)));
    let near_zero = |cloud: &[[f32; 3]]| cloud.iter().flatten().any(|c| *c != 0.0 && c.abs() < 1e-15);
    let count = clouds.iter().filter(|(_, cloud)| near_zero(cloud)).count();
    assert!(count > 150, "{count} of {}", clouds.len());
}

/// Clouds with coordinates of all magnitudes, over up to 140 octaves.
#[test]
fn coordinates_of_all_sizes_bake() {
    let mut rng = SplitMix64::new(SEED);
    for index in 0..1_500 {
        let (octaves, count) = ([20, 44, 60, 100, 140][index % 5], 4 + rng.below(40));
        let mut coordinate = || match rng.below(4) {
            0 => 0.0,
            1 => rng.between(-1.0, 1.0) as f32,
            _ => (rng.between(-1.0, 1.0) * 2_f64.powi(-(rng.below(octaves) as i32))) as f32,
        };
        let cloud: Vec<[f32; 3]> = (0..count).map(|_| std::array::from_fn(|_| coordinate())).collect();
        check(&format!("cloud {index}, {octaves} octaves"), &cloud, &ALL_INDICES, DIRECTIONS, EXACT);
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
        let worst = directions::all(&hull, 500, SEED).into_iter().map(|dir| truth.regret(dir, hull.support(dir).point));
        assert!(worst.fold(0.0, f64::max) > 1e3 * EXACT, "vertex {lost}, seed {SEED:#x}");
    }
}
