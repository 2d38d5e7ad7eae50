//! Signed distance of closed meshes, compared with brute force: the nearest of all triangles, and
//! the sum of their solid angles.

use glam::{DQuat, DVec3};
use hullmap::compound::{SurfaceError, surface_distance};
use hullmap::{Cache, EdgeClass, Settings, TriangleMesh};
use hullmap_testkit::triangles::{distance_from_triangle, winding};
use shapes::rng::SplitMix64;

use crate::meshes::{grid, mesh, triangles};

const SEED: u64 = 0x51;

/// A box with these corners, its fronts outwards, as vertices and triangles that follow others.
fn add_box([low, high]: [DVec3; 2], turn: DQuat, positions: &mut Vec<DVec3>, corners: &mut Vec<[u32; 3]>) {
    let first = positions.len() as u32;
    for i in 0..8 {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        positions.push(turn * DVec3::new(pick(0), pick(1), pick(2)));
    }
    // Each side by its corners, counter-clockwise from outside.
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        corners.extend([[a, b, c], [a, c, d]].map(|t: [u32; 3]| t.map(|corner| first + corner)));
    }
}

/// A sphere of triangles, its vertices moved by random shares of `rough`.
fn ball(rings: usize, rough: f64, rng: &mut SplitMix64) -> TriangleMesh {
    let mut positions = vec![DVec3::NEG_Z, DVec3::Z];
    let around = 2 * rings;
    for ring in 1..rings {
        let angle = std::f64::consts::PI * ring as f64 / rings as f64;
        for i in 0..around {
            let turn = std::f64::consts::TAU * i as f64 / around as f64;
            let at = DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), -angle.cos());
            positions.push(at * (1.0 + rough * rng.unit()));
        }
    }
    let at = |ring: usize, i: usize| (2 + (ring - 1) * around + i % around) as u32;
    let mut corners = Vec::new();
    for i in 0..around {
        corners.push([0, at(1, i + 1), at(1, i)]);
        corners.push([1, at(rings - 1, i), at(rings - 1, i + 1)]);
        for ring in 1..rings - 1 {
            corners.push([at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)]);
            corners.push([at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)]);
        }
    }
    mesh(&positions, &corners)
}

/// Closed meshes: rough, thin, overlapping, with a cavity, and with whole coordinates.
fn closed(rng: &mut SplitMix64) -> Vec<TriangleMesh> {
    let boxes = |list: &[([f64; 3], [f64; 3], f64)]| {
        let (mut positions, mut corners) = (Vec::new(), Vec::new());
        for (low, high, turn) in list {
            add_box(
                [DVec3::from(*low), DVec3::from(*high)],
                DQuat::from_rotation_x(*turn),
                &mut positions,
                &mut corners,
            );
        }
        mesh(&positions, &corners)
    };
    let mut hollow = (Vec::new(), Vec::new());
    add_box([DVec3::splat(-2.0), DVec3::splat(2.0)], DQuat::IDENTITY, &mut hollow.0, &mut hollow.1);
    add_box([DVec3::NEG_ONE, DVec3::ONE], DQuat::IDENTITY, &mut hollow.0, &mut hollow.1);
    hollow.1[12..].iter_mut().for_each(|triangle| triangle.swap(1, 2));
    vec![
        ball(8, 0.4, rng),
        ball(4, 0.0, rng),
        boxes(&[([-2.0, -2.0, -2.0], [2.0, 2.0, 2.0], 0.0)]),
        boxes(&[([-2.0, -1.0, -1.0], [1.0, 1.0, 1.0], 0.0), ([0.0, -2.0, 0.0], [2.0, 2.0, 2.0], 0.0)]),
        boxes(&[([-2.0, -2.0, -0.001], [2.0, 2.0, 0.001], 0.4), ([-0.001, -1.0, -2.0], [0.001, 1.0, 2.0], 1.0)]),
        mesh(&hollow.0, &hollow.1),
    ]
}

#[test]
fn signs_and_distances_are_those_of_brute_force() {
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let settings = Settings::default();
    let (mut inside, mut outside, mut on) = (0, 0, 0);
    for (which, mesh) in closed(&mut rng).iter().enumerate() {
        let all = triangles(mesh);
        let mut cache = Cache::new();
        for round in 0..4000 {
            // Also points with whole coordinates: above edges and corners, and on the surface; and
            // points near vertices and edges.
            let p = match round % 4 {
                0 => 3.0 * DVec3::from_array(rng.direction()) * rng.unit(),
                1 => DVec3::new(rng.between(-3.0, 3.0), rng.between(-3.0, 3.0), rng.between(-3.0, 3.0)).round(),
                2 => {
                    (2.0 * DVec3::new(rng.between(-3.0, 3.0), rng.between(-3.0, 3.0), rng.between(-3.0, 3.0))).round()
                        / 2.0
                }
                _ => {
                    let corners = all[rng.below(all.len())];
                    let along = corners[0].lerp(corners[1], rng.between(0.0, 1.0).round());
                    along + 1e-3 * DVec3::from_array(rng.direction()) * rng.unit()
                }
            };
            let found = surface_distance(mesh, p, &settings, &mut cache).unwrap();
            let nearest = all.iter().map(|corners| distance_from_triangle(*corners, p)).fold(f64::INFINITY, f64::min);
            let answer = found;
            if nearest < 1e-12 {
                on += 1;
                assert!(
                    answer.lower <= 0.0 && 0.0 <= answer.upper && answer.distance.abs() < 1e-9,
                    "{which} {p}: {answer:?}"
                );
                continue;
            }
            let turns = winding(&all, p);
            assert!((turns - turns.round()).abs() < 1e-6, "{which} {p}: {turns}");
            let is_inside = turns.round() >= 1.0;
            let expected = if is_inside { -nearest } else { nearest };
            let slack = 1e-12;
            assert!(
                answer.lower <= expected + slack && expected <= answer.upper + slack,
                "{which} {p}: {answer:?}, {expected}"
            );
            assert!((answer.distance - expected).abs() < 1e-6 * (1.0 + nearest), "{which} {p}: {answer:?}, {expected}");
            assert!(distance_from_triangle(all[found.part as usize], answer.point) < 1e-9, "{which} {p}: {answer:?}");
            let toward = (p - answer.point).normalize() * if is_inside { -1.0 } else { 1.0 };
            assert!(nearest < 1e-6 || answer.normal.distance(toward) < 1e-5, "{which} {p}: {answer:?}, {toward}");
            inside += usize::from(is_inside);
            outside += usize::from(!is_inside);
        }
    }
    println!("{inside} inside, {outside} outside, {on} on the surface");
    assert!(inside > 3000 && outside > 3000 && on > 500);
}

#[test]
fn open_meshes_have_no_inside() {
    let sheet = grid(3, |_, _| 0.0);
    let (settings, mut cache) = (Settings::default(), Cache::new());
    let error = surface_distance(&sheet, DVec3::ONE, &settings, &mut cache).unwrap_err();
    assert!(matches!(error, SurfaceError::Open(open) if open.edge == EdgeClass::Border), "{error}");
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    add_box([DVec3::NEG_ONE, DVec3::ONE], DQuat::IDENTITY, &mut positions, &mut corners);
    assert!(mesh(&positions, &corners).check_closed().is_ok());
    // One triangle is the wrong way round.
    corners[5].swap(0, 1);
    let error = mesh(&positions, &corners).check_closed().unwrap_err();
    assert_eq!(error.edge, EdgeClass::Reversed);
    let error = surface_distance(&sheet, DVec3::NAN, &settings, &mut cache).unwrap_err();
    assert!(error.to_string().contains("not closed"));
}
