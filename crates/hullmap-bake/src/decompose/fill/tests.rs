//! Voids with and without filling, at random points. Solid angles decide which are in the solid.

use glam::DVec3;
use shapes::{concave, cubes, rng::SplitMix64};

use super::super::{
    Cover, Length, decompose,
    tests::{point_set, turned},
};
use crate::{
    fit::{Solid, fits, remainder},
    hull::{self, Hull},
};
use hullmap_geometry::PointSet;

const SEED: u64 = 41;

const POINTS: usize = 4_000;

/// The winding number of the mesh around a point, from solid angles.
///
/// # Reference
/// van Oosterom and Strackee, "The solid angle of a plane triangle", 1983.
fn winding(mesh: &PointSet, p: DVec3) -> f64 {
    let angle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)) - p);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * libm::atan2(a.dot(b.cross(c)), below)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

fn holds(part: &Hull, p: DVec3) -> bool {
    let at = |v: u32| DVec3::from_array(part.vertices[v as usize].map(f64::from));
    part.faces.iter().all(|face| {
        let root = at(face[0]);
        let area: DVec3 = face[1..].windows(2).map(|pair| (at(pair[0]) - root).cross(at(pair[1]) - root)).sum();
        area.dot(p - root) <= 0.0
    })
}

fn sampled(mesh: &PointSet, parts: &[Hull]) -> [usize; 2] {
    let mut rng = SplitMix64::new(SEED);
    let [low, high] = Solid::new(mesh).bounds();
    let (mut inside, mut outside_parts) = (0, 0);
    for _ in 0..POINTS {
        let p = low + (high - low) * DVec3::new(rng.unit(), rng.unit(), rng.unit());
        if winding(mesh, p).abs() > 0.5 {
            inside += 1;
            outside_parts += usize::from(!parts.iter().any(|part| holds(part, p)));
        }
    }
    [inside, outside_parts]
}

fn parts(mesh: &PointSet, cover: &Cover) -> Vec<Hull> {
    decompose(mesh, cover).unwrap().unwrap().iter().map(|part| hull::build(part).unwrap()).collect()
}

#[test]
fn filled_parts_leave_no_voids() {
    assert_that_filled_parts_leave_no_voids(&[
        ("grooved", point_set(&cubes::grooved([9, 9, 7], [4, 4, 3])), 0.015),
        ("long", point_set(&cubes::grooved([9, 7, 7], [4, 3, 3])), 0.015),
        ("hollow", point_set(&cubes::hollow([6, 5, 4])), 0.01),
        ("stair", point_set(&concave::spiral_stair(4)), 0.01),
    ]);
}

#[test]
#[ignore = "takes long; .ci/nightly runs it"]
fn filled_parts_of_a_turned_mesh_leave_no_voids() {
    let mesh = turned(&cubes::grooved([6, 6, 6], [2, 2, 1]));
    assert_that_filled_parts_leave_no_voids(&[("turned", mesh, 0.015)]);
}

fn assert_that_filled_parts_leave_no_voids(meshes: &[(&str, PointSet, f64)]) {
    println!("seed {SEED}");
    let mut with_voids = 0;
    for (name, mesh, error) in meshes {
        let usual = Cover { max_error: Length::Relative(*error), ..Cover::default() };
        let (without, with) = (parts(mesh, &usual), parts(mesh, &Cover { fill: true, ..usual }));
        let [[inside, voids], [_, left]] = [&without, &with].map(|parts| sampled(mesh, parts));
        println!("{name}: {voids} of {inside}; {} parts, then {left}; {} parts", without.len(), with.len());
        assert!(inside > 200, "{name}: {inside} points");
        assert!(with.len() <= 2 * without.len(), "{name}: {} parts", with.len());
        assert_eq!(left, 0, "{name}");
        with_voids += usize::from(voids > 0);
        let refs: Vec<&Hull> = with.iter().collect();
        assert!(remainder(&Solid::new(mesh), &refs).is_empty(), "{name}");
        let diagonal = Solid::new(mesh).diagonal();
        for fit in fits(mesh, &refs, None).unwrap() {
            assert!(fit.uncovered <= 1e-6 * diagonal && fit.protrusion <= 1.001 * error * diagonal, "{name}: {fit:?}");
        }
        assert!(with.iter().all(|part| part.vertices.len() <= usual.max_vertices as usize), "{name}");
    }
    assert!(with_voids > 0 && 2 * with_voids >= meshes.len(), "{with_voids} meshes have voids");
}

#[test]
fn meshes_that_are_not_closed_are_left_as_they_are() {
    let mut open = point_set(&cubes::grooved([5, 5, 5], [2, 2, 2]));
    open.triangles.truncate(open.triangles.len() - 2);
    let usual = Cover { max_error: Length::Relative(0.03), ..Cover::default() };
    let [without, with] = [false, true].map(|fill| decompose(&open, &Cover { fill, ..usual }).unwrap().unwrap());
    let positions = |parts: &[PointSet]| parts.iter().map(|part| part.positions.clone()).collect::<Vec<_>>();
    assert_eq!(positions(&without), positions(&with));
}

#[test]
fn what_is_left_has_the_rest_of_the_volume() {
    let mesh = point_set(&cubes::surface(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]]));
    let solid = Solid::new(&mesh);
    let block = |low: [f32; 3], high: [f32; 3]| {
        let corner = |i: usize| [0, 1, 2].map(|axis| [low, high][i >> axis & 1][axis]);
        hull::build(&PointSet::of_positions((0..8).map(corner).collect())).unwrap()
    };
    let (thin, end) = (0.125, 1.0 - 0.125);
    let slabs = [
        block([0.0; 3], [2.0, 2.0, thin]),
        block([0.0, 0.0, end], [2.0, 2.0, 1.0]),
        block([0.0; 3], [2.0, thin, 1.0]),
        block([0.0; 3], [thin, 2.0, 1.0]),
        block([0.0, 2.0 - thin, 0.0], [1.0, 2.0, 1.0]),
        block([2.0 - thin, 0.0, 0.0], [2.0, 1.0, 1.0]),
        block([end, end, 0.0], [1.0, 2.0, 1.0]),
        block([end, end, 0.0], [2.0, 1.0, 1.0]),
    ];
    let left = remainder(&solid, &slabs.iter().collect::<Vec<_>>());
    let volume: f64 = left.iter().map(|piece| piece.body.volume()).sum();
    let (thin, height) = (f64::from(thin), 1.0 - 2.0 * f64::from(thin));
    // Two arms that share a square, without the slabs at their sides.
    let arms = 2.0 * (2.0 - 2.0 * thin) * height - height * height;
    assert!((volume - arms * height).abs() < 1e-4, "{volume}");
}
