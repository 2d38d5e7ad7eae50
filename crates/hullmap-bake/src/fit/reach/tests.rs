use shapes::rng::SplitMix64;

use super::*;
use crate::decompose::{Cover, Length, decompose};
use crate::fit::fits_around;
use crate::hull::{self, Hull};

fn set(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> PointSet {
    PointSet { triangles, ..PointSet::of_positions(positions) }
}

fn boxes(boxes: &[([f32; 3], [f32; 3], f32)]) -> PointSet {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (low, high, sign) in boxes {
        let first = positions.len() as u32;
        positions.extend((0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] })));
        for [a, b, c, d] in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6_u32]] {
            let both = [[a, b, c], [a, c, d]].map(|t| if *sign < 0.0 { [t[0], t[2], t[1]] } else { t });
            triangles.extend(both.map(|t| t.map(|v| v + first)));
        }
    }
    set(positions, triangles)
}

fn turned(profile: &[[f32; 2]]) -> PointSet {
    const SIDES: u32 = 32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for [radius, z] in profile {
        positions.extend((0..SIDES).map(|k| {
            let angle = std::f32::consts::TAU * k as f32 / SIDES as f32;
            [radius * libm::cosf(angle), radius * libm::sinf(angle), *z]
        }));
    }
    for ring in 0..profile.len() as u32 - 1 {
        for k in 0..SIDES {
            let [a, b] = [ring * SIDES + k, ring * SIDES + (k + 1) % SIDES];
            triangles.extend([[a, b, b + SIDES], [a, b + SIDES, a + SIDES]]);
        }
    }
    set(positions, triangles)
}

/// A bottle of radius 5 and height 12, whose neck has the radius 1 inside and leads to z = 9.
fn bottle() -> PointSet {
    turned(&[
        [0.0, 0.0],
        [5.0, 0.0],
        [5.0, 8.0],
        [1.5, 10.0],
        [1.5, 12.0],
        [1.0, 12.0],
        [1.0, 9.0],
        [4.5, 7.5],
        [4.5, 0.5],
        [0.0, 0.5],
    ])
}

fn solid(mesh: &PointSet, radius: f64) -> Solid {
    with_unreachable(mesh, Solid::new(mesh), radius)
}

/// Random points in and near the box around a mesh that are only in the filled solid.
fn added(mesh: &PointSet, filled: &Solid) -> Vec<DVec3> {
    let plain = Solid::new(mesh);
    let [low, high] = plain.bounds();
    let mut rng = SplitMix64::new(7);
    let mut point = || DVec3::from_array(std::array::from_fn(|_| rng.between(-0.5, 1.5))) * (high - low) + low;
    let points: Vec<DVec3> = (0..40_000).map(|_| point()).collect();
    points.into_iter().filter(|p| filled.is_inside(*p) && !plain.is_inside(*p)).collect()
}

#[test]
fn a_closed_cavity_is_unreachable() {
    let mesh = boxes(&[([0.0; 3], [10.0; 3], 1.0), ([1.0; 3], [9.0; 3], -1.0)]);
    let plain = Solid::new(&mesh);
    assert!(!plain.is_inside(DVec3::splat(5.0)));
    for radius in [0.5, 1.0, 3.0, 20.0] {
        let filled = solid(&mesh, radius);
        let found = added(&mesh, &filled);
        // The cavity is 512 of the 8,000 units in which points are drawn.
        assert!(found.len() > 800, "{radius}: {}", found.len());
        assert!(found.iter().all(|p| (*p - 5.0).abs().max_element() <= 4.0), "{radius}");
        assert!(filled.is_inside(DVec3::splat(5.0)) && filled.distance(DVec3::splat(1.6)) < 0.7, "{radius}");
    }
}

/// A ball on the mouth of a neck of radius 1 enters it by R − √(R² − 1).
#[test]
fn a_bottle_is_reachable_only_by_balls_that_pass_its_neck() {
    let mesh = bottle();
    let deep = DVec3::new(0.0, 0.0, 4.0);
    for (radius, is_closed) in [(0.5, false), (0.8, false), (1.3, true), (2.0, true), (6.0, true)] {
        let filled = solid(&mesh, radius);
        assert_eq!(filled.is_inside(deep), is_closed, "{radius}");
        let found = added(&mesh, &filled);
        assert_eq!(found.len() > 500, is_closed, "{radius}: {}", found.len());
        let depth = if is_closed { radius - (radius * radius - 1.0).sqrt() } else { 0.0 };
        for p in found {
            let from_axis = p.truncate().length();
            // Outside the bottle, and in its mouth, all is reachable.
            assert!(from_axis <= 4.5 && p.z <= 12.0 - depth, "{radius}: {p}");
        }
    }
}

#[test]
fn inner_walls_cost_no_parts() {
    let mesh = boxes(&[
        ([0.0; 3], [10.0; 3], 1.0),
        ([0.5; 3], [9.5; 3], -1.0),
        ([4.9, 0.25, 0.25], [5.1, 9.75, 9.75], 1.0),
        ([0.25, 4.9, 0.25], [9.75, 5.1, 9.75], 1.0),
    ]);
    let cover = Cover { reachable: Some(Length::Absolute(1.0)), ..Cover::default() };
    let filled = cover.solid_of(&mesh);
    let parts = decompose(&mesh, &cover).unwrap().unwrap();
    assert_eq!(parts.len(), 1);
    let hulls: Vec<Hull> = parts.iter().map(|part| hull::build(part).unwrap()).collect();
    let limit = 0.02 * filled.diagonal();
    let fit = fits_around(&filled, &mesh, &hulls.iter().collect::<Vec<_>>(), Some(limit), None).unwrap()[0];
    assert!(fit.protrusion <= limit && fit.uncovered <= 1e-7 * filled.diagonal(), "{fit:?}");
    let everywhere = decompose(&mesh, &Cover::default()).unwrap().unwrap();
    assert!(everywhere.len() >= 6, "{}", everywhere.len());
}

#[test]
fn shells_bound_their_cells() {
    let mut rng = SplitMix64::new(4);
    let size = [7, 6, 5];
    for round in 0..20 {
        let share = [0.1, 0.5, 0.9][round % 3];
        let is_inner = |i: usize| {
            let at = [i % 7, i / 7 % 6, i / 42];
            (0..3).all(|axis| at[axis] > 0 && at[axis] + 1 < size[axis])
        };
        let cells: Vec<bool> = (0..7 * 6 * 5).map(|i| is_inner(i) && rng.unit() < share).collect();
        let (corners, triangles) = shell::shell(&cells, size);
        let mut edges = std::collections::HashMap::new();
        for [a, b, c] in &triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|sum| *sum == 0), "round {round}: an open edge");
        let at = |v: u32| DVec3::from_array(corners[v as usize]);
        for (i, is_in) in cells.iter().enumerate() {
            let p = DVec3::new((i % 7) as f64, (i / 7 % 6) as f64, (i / 42) as f64) + 0.5;
            let angle: f64 = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| at(v) - p);
                    let [la, lb, lc] = [a.length(), b.length(), c.length()];
                    let scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
                    2.0 * libm::atan2(a.dot(b.cross(c)), scale)
                })
                .sum();
            let turns = angle / (4.0 * std::f64::consts::PI);
            assert!((turns - f64::from(u8::from(*is_in))).abs() < 1e-9, "round {round}, cell {i}: {turns}");
        }
    }
}
