//! Voids of parts with and without filling, by points at random. Whether a point is in the solid is
//! the sum of the solid angles of all triangles; whether it is in a part follows from the part's
//! vertices.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use shapes::{concave, rng::SplitMix64};

use super::super::{Cover, Length, decompose, tests::point_set};
use crate::{
    PointSet,
    fit::{Solid, fits, remainder},
    hull::{self, Hull},
};

const SEED: u64 = 41;

/// Points that are drawn in the box around a mesh.
const POINTS: usize = 4_000;

/// The surface of unit cubes at these places: two triangles for each side that no other cube has.
/// No two cubes may share an edge or a corner alone.
fn of_cubes(cubes: &[[i32; 3]]) -> PointSet {
    let mut vertices: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut set = PointSet { name: "cubes".into(), ..PointSet::default() };
    for cube in cubes {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beside = *cube;
            beside[axis] += 2 * side - 1;
            if cubes.contains(&beside) {
                continue;
            }
            let corner = |[u, v]: [i32; 2]| {
                let mut at = *cube;
                at[axis] += side;
                at[(axis + 1) % 3] += u;
                at[(axis + 2) % 3] += v;
                at
            };
            let quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|uv| {
                let next = vertices.len() as u32;
                *vertices.entry(corner(uv)).or_insert_with_key(|at| {
                    set.positions.push(at.map(|c| c as f32));
                    set.source_vertices.push(next);
                    next
                })
            });
            let [a, b, c, d] = if side == 1 { quad } else { [quad[3], quad[2], quad[1], quad[0]] };
            set.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    set
}

/// A block with a groove around it in each of three directions. Its inside is far from the surface.
fn grooved(size: [i32; 3], grooves: [i32; 3]) -> PointSet {
    let [length, width, height] = size;
    let all = (0..length).flat_map(|x| (0..width).flat_map(move |y| (0..height).map(move |z| [x, y, z])));
    let is_groove = |cube: &[i32; 3], axis: usize| cube[axis] == grooves[axis];
    let is_kept = |cube: &[i32; 3]| {
        (0..3).all(|axis| {
            let is_outer = cube[axis] == 0 || cube[axis] == size[axis] - 1;
            !(is_outer && (is_groove(cube, (axis + 1) % 3) || is_groove(cube, (axis + 2) % 3)))
        })
    };
    of_cubes(&all.filter(is_kept).collect::<Vec<_>>())
}

/// The mesh, turned about an axis that is not one of the coordinates'.
fn turned(mut mesh: PointSet) -> PointSet {
    let turn = DMat3::from_axis_angle(DVec3::new(3.0, 1.0, 2.0).normalize(), 0.6);
    mesh.positions.iter_mut().for_each(|p| *p = (turn * DVec3::from_array(p.map(f64::from))).as_vec3().to_array());
    mesh
}

/// A box with a cavity that opens nowhere.
fn hollow() -> PointSet {
    let all = (0..6).flat_map(|x| (0..5).flat_map(move |y| (0..4).map(move |z| [x, y, z])));
    let is_wall = |[x, y, z]: &[i32; 3]| !((1..5).contains(x) && (1..4).contains(y) && (1..3).contains(z));
    of_cubes(&all.filter(is_wall).collect::<Vec<_>>())
}

/// The winding number of the mesh around a point, from solid angles.
///
/// # Reference
/// van Oosterom and Strackee, "The solid angle of a plane triangle", 1983.
fn winding(mesh: &PointSet, p: DVec3) -> f64 {
    let angle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)) - p);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Whether a point is behind the planes of all faces, each through three corners.
fn holds(part: &Hull, p: DVec3) -> bool {
    let at = |v: u32| DVec3::from_array(part.vertices[v as usize].map(f64::from));
    part.faces.iter().all(|face| {
        let root = at(face[0]);
        let area: DVec3 = face[1..].windows(2).map(|pair| (at(pair[0]) - root).cross(at(pair[1]) - root)).sum();
        area.dot(p - root) <= 0.0
    })
}

/// Number of points in the solid, and of those that are in no part.
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
    println!("seed {SEED}");
    let meshes = [
        ("grooved", grooved([9, 9, 9], [4, 4, 4]), 0.01),
        ("long", grooved([11, 9, 8], [5, 3, 4]), 0.01),
        ("turned", turned(grooved([8, 9, 9], [4, 4, 3])), 0.01),
        ("hollow", hollow(), 0.01),
        ("stair", point_set(&concave::spiral_stair(7)), 0.01),
    ];
    let mut with_voids = 0;
    for (name, mesh, error) in meshes {
        let usual = Cover { max_error: Length::Relative(error), ..Cover::default() };
        let (without, with) = (parts(&mesh, &usual), parts(&mesh, &Cover { fill: true, ..usual }));
        let [[inside, voids], [_, left]] = [&without, &with].map(|parts| sampled(&mesh, parts));
        println!("{name}: {voids} of {inside}; {} parts, then {left}; {} parts", without.len(), with.len());
        assert!(inside > 200, "{name}: {inside} points");
        assert_eq!(left, 0, "{name}");
        with_voids += usize::from(voids > 0);
        let refs: Vec<&Hull> = with.iter().collect();
        assert!(remainder(&Solid::new(&mesh), &refs).is_empty(), "{name}");
        // Both bounds still hold.
        let diagonal = Solid::new(&mesh).diagonal();
        for fit in fits(&mesh, &refs, None).unwrap() {
            assert!(fit.uncovered <= 1e-6 * diagonal && fit.protrusion <= 1.001 * error * diagonal, "{name}: {fit:?}");
        }
        assert!(with.iter().all(|part| part.vertices.len() <= usual.max_vertices as usize), "{name}");
    }
    assert!(with_voids > 2, "{with_voids} meshes have voids");
}

/// A sheet has no inside, and a mesh with a hole none that is known.
#[test]
fn meshes_that_are_not_closed_are_left_as_they_are() {
    let mut open = grooved([5, 5, 5], [2, 2, 2]);
    open.triangles.truncate(open.triangles.len() - 2);
    let usual = Cover { max_error: Length::Relative(0.03), ..Cover::default() };
    let [without, with] = [false, true].map(|fill| decompose(&open, &Cover { fill, ..usual }).unwrap().unwrap());
    let positions = |parts: &[PointSet]| parts.iter().map(|part| part.positions.clone()).collect::<Vec<_>>();
    assert_eq!(positions(&without), positions(&with));
}

/// What is left has the volume that the parts leave out, for parts whose volume is known.
#[test]
fn what_is_left_has_the_rest_of_the_volume() {
    let mesh = of_cubes(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]]);
    let solid = Solid::new(&mesh);
    // They contain the surface, and overlap in the corner.
    let block = |low: [f32; 3], high: [f32; 3]| {
        let corner = |i: usize| [0, 1, 2].map(|axis| [low, high][i >> axis & 1][axis]);
        let source_vertices = (0..8).collect();
        hull::build(&PointSet { positions: (0..8).map(corner).collect(), source_vertices, ..PointSet::default() })
            .unwrap()
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
