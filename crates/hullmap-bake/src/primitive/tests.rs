//! Primitives against points at random: of the mesh's surface, which must be in the primitive or in
//! another part, and of the primitives' surfaces, which must be near the solid. Distances are the
//! least over all triangles; whether a point is inside is a sum of solid angles.

use glam::{DMat3, DQuat};
use hullmap_format::PrimitiveKind;
use hullmap_geometry::triangle;
use shapes::{mesh::Mesh, rng::SplitMix64, solids::lathe};

use super::*;
use crate::{
    decompose::{Cover, Length, decompose},
    fit::fits,
    hull,
    test_meshes::{block, in_triangle, joined, point_set},
};

const SEED: u64 = 43;

const POINTS: usize = 1_500;

fn turned(mut mesh: PointSet) -> PointSet {
    let turn = DMat3::from_quat(DQuat::from_xyzw(0.09, 0.18, 0.27, 0.94).normalize());
    for p in &mut mesh.positions {
        *p = (turn * DVec3::from_array(p.map(f64::from)) + 0.25).as_vec3().to_array();
    }
    mesh
}

fn from_solid(mesh: &PointSet, p: DVec3) -> f64 {
    let angle = |triangle: &[u32; 3]| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - p);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        2.0 * libm::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
    };
    if mesh.triangles.iter().map(angle).sum::<f64>().abs() > 2.0 * std::f64::consts::PI {
        return 0.0;
    }
    let distance = |corners: &[u32; 3]| triangle::nearest(&mesh.corners(corners), p).distance(p);
    mesh.triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
}

fn on_surface(rng: &mut SplitMix64, primitive: &Primitive) -> DVec3 {
    let mut unit = || 2.0 * rng.unit() - 1.0;
    let direction = DVec3::new(unit(), unit(), unit()).normalize_or(DVec3::X);
    let flat = DVec3::new(direction.x, direction.y, 0.0).normalize_or(DVec3::X);
    let [a, b, c] = primitive.sizes;
    let (along, side) = (unit(), unit());
    let local = match primitive.kind {
        PrimitiveKind::Box => {
            let p = DVec3::new(unit(), along, side);
            p / p.abs().max_element() * DVec3::new(a, b, c)
        }
        PrimitiveKind::Sphere => direction * a,
        PrimitiveKind::Capsule if side > 0.0 => flat * a + DVec3::Z * along * b,
        PrimitiveKind::Capsule => direction * a + DVec3::Z * b * direction.z.signum(),
        PrimitiveKind::Cylinder if side > 0.0 => flat * a + DVec3::Z * along * b,
        PrimitiveKind::Cylinder => flat * a * along + DVec3::Z * b * direction.z.signum(),
    };
    primitive.center + primitive.rotation * local
}

fn judged(name: &str, mesh: &PointSet, error: f64) -> Vec<Option<PrimitiveKind>> {
    let cover = Cover { max_error: Length::Relative(error), ..Cover::default() };
    let parts: Vec<Hull> = match decompose(mesh, &cover).unwrap() {
        Some(parts) => parts.iter().map(|part| hull::build(part).unwrap()).collect(),
        None => vec![hull::build(mesh).unwrap()],
    };
    let parts: Vec<&Hull> = parts.iter().collect();
    let solid = Solid::new(mesh);
    let (diagonal, limit) = (solid.diagonal(), error * solid.diagonal());
    let fits = fits(mesh, &parts, Some(limit)).unwrap();
    let limits = PrimitiveLimits { protrusion: limit, deadline: None };
    let found = primitives(&solid, mesh, &parts, &fits, &limits);
    let late = PrimitiveLimits { deadline: Some(Deadline::after(0.0)), ..limits };
    assert!(primitives(&solid, mesh, &parts, &fits, &late).iter().all(Option::is_none), "{name}: after the deadline");
    let mut rng = SplitMix64::new(SEED);
    let planes: Vec<_> = parts.iter().map(|part| part.half_spaces()).collect();
    let room = 1e-6 * diagonal;
    for _ in 0..POINTS {
        let triangle = &mesh.triangles[rng.below(mesh.triangles.len())];
        let p = in_triangle(&mesh.corners(triangle), &mut rng);
        let is_in = |part: usize| match found[part] {
            Some(proven) => proven.primitive.holds(p, 0.0),
            None => planes[part].iter().all(|plane| plane.height(p) <= room),
        };
        assert!((0..parts.len()).any(is_in), "{name}: {p} is in nothing");
    }
    for proven in found.iter().flatten() {
        assert!(proven.protrusion <= limit, "{name}: {proven:?}");
        let farthest =
            (0..POINTS / 3).map(|_| from_solid(mesh, on_surface(&mut rng, &proven.primitive))).fold(0.0, f64::max);
        assert!(farthest <= proven.protrusion + 1e-9 * diagonal, "{name}: {farthest} {proven:?}");
    }
    println!("{name}: {found:?}");
    found.iter().map(|proven| proven.map(|proven| proven.primitive.kind)).collect()
}

fn rounded(half: f64, steps: usize) -> Vec<[f64; 2]> {
    let angle = |k: usize| std::f64::consts::PI * (k as f64 / (2 * steps + 1) as f64 - 0.5);
    let ring = |k: usize| [libm::cos(angle(k)), libm::sin(angle(k)) + if k <= steps { -half } else { half }];
    let middle = (1..=2 * steps).map(ring);
    [[0.0, -1.0 - half]].into_iter().chain(middle).chain([[0.0, 1.0 + half]]).collect()
}

#[test]
fn bodies_of_one_primitive_are_found() {
    println!("seed {SEED}");
    let flat = [[0.0, -1.5], [0.8, -1.5], [0.8, 1.5], [0.0, 1.5]];
    for (name, mesh, kind) in [
        ("ball", point_set(&lathe(&rounded(0.0, 12), 32)), PrimitiveKind::Sphere),
        ("capsule", point_set(&lathe(&rounded(1.5, 12), 32)), PrimitiveKind::Capsule),
        ("cylinder", point_set(&lathe(&flat, 40)), PrimitiveKind::Cylinder),
        ("box", block([0.0; 3], [1.0, 2.0, 3.0]), PrimitiveKind::Box),
    ] {
        assert_eq!(judged(name, &turned(mesh), 0.02), [Some(kind)], "{name}");
    }
}

fn table() -> PointSet {
    let legs = [(0.1, 0.1, 1.5), (2.6, 0.1, 1.2), (0.1, 1.6, 1.0), (2.6, 1.6, 1.4)]
        .map(|(x, y, length)| block([x, y, -length], [x + 0.3, y + 0.3, 0.0]));
    joined(&[&[block([0.0; 3], [3.0, 2.0, 0.2])], legs.as_slice()].concat())
}

#[test]
fn a_table_of_boxes_becomes_boxes() {
    println!("seed {SEED}");
    assert_eq!(judged("table", &turned(table()), 0.01), [Some(PrimitiveKind::Box); 5]);
}

#[test]
#[ignore = "takes long; .ci/nightly runs it"]
fn pieces_of_a_ring_stay_hulls() {
    println!("seed {SEED}");
    let steps = 12;
    let turn = |angle: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z)
    };
    let mut mesh = Mesh::default();
    let at = |i: usize, k: usize| ((i % steps) * steps + k % steps) as u32;
    for i in 0..steps {
        for k in 0..steps {
            let [around, across] = [i, k].map(|at| 2.0 * std::f64::consts::PI * at as f64 / steps as f64);
            let p = DVec3::new(1.0 + 0.3 * libm::cos(across), 0.0, 0.3 * libm::sin(across));
            mesh.push_vertex((turn(around) * p).to_array());
            mesh.faces.push(vec![at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)]);
        }
    }
    let kinds = judged("ring", &turned(point_set(&mesh)), 0.01);
    assert!(kinds.len() > 5 && kinds.iter().all(Option::is_none), "{kinds:?}");
}
