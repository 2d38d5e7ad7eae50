//! Contact manifolds of `HullDispatcher` on surfaces.

use hullmap::glam::DVec3;
use hullmap_parry::{BakedSurface, HullDispatcher};
use hullmap_testkit::packs;
use parry3d::math::{Pose, Vector};
use parry3d::query::details::ContactManifoldsWorkspace;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{Ball, Capsule, Compound, Cuboid, Shape, SharedShape};

use crate::bodies::hull;
use crate::grounds::{field, mesh};

type Manifolds = Vec<ContactManifold<(), u32>>;

/// A pair, and its memory.
#[derive(Default)]
struct PairMemory {
    manifolds: Manifolds,
    workspace: Option<ContactManifoldsWorkspace>,
    flipped: bool,
}

impl PairMemory {
    fn step(&mut self, ground: &dyn Shape, body: &dyn Shape, at: &Pose) {
        let (manifolds, workspace) = (&mut self.manifolds, &mut self.workspace);
        if self.flipped {
            HullDispatcher.contact_manifolds(&at.inverse(), body, ground, 0.02, manifolds, workspace).unwrap();
        } else {
            HullDispatcher.contact_manifolds(at, ground, body, 0.02, manifolds, workspace).unwrap();
        }
    }

    /// Normals from the ground to the body in the frame of the ground, and depths.
    fn points(&self, at: &Pose) -> Vec<(Vector, f32)> {
        let normal = |m: &ContactManifold<(), u32>| {
            if self.flipped { at.rotation * -m.local_n1 } else { m.local_n1 }
        };
        self.manifolds.iter().flat_map(|m| m.points.iter().map(move |p| (normal(m), -p.dist))).collect()
    }
}

/// Two triangles, 18 wide, in the plane z = 0.
fn square() -> BakedSurface {
    let positions = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    BakedSurface::new(mesh(&positions, &[[0, 1, 2], [0, 2, 3]]))
}

/// Surfaces in the plane z = 0, with their names.
fn floors() -> Vec<(&'static str, BakedSurface)> {
    let fine = BakedSurface::new(field(20, [-10.0; 2], |_, _| 0.0));
    let half = |origin: [f64; 2]| BakedSurface::new(field(10, origin, |_, _| 0.0));
    let quarter = [[-10.0, -10.0], [0.0, -10.0], [-10.0, 0.0], [0.0, 0.0]];
    let joined = BakedSurface::joined(quarter.map(|origin| (Pose::IDENTITY, half(origin)))).unwrap();
    vec![("square", square()), ("field", fine.clone()), ("one-sided", fine.one_sided()), ("joined", joined)]
}

fn bodies() -> Vec<(&'static str, SharedShape, f32, usize)> {
    let cube = hull(&shapes::families::cube_grid(8, 1));
    let half = cube.hull().bounds()[1].z;
    let beside = |x: f32| (Pose::translation(x, 0.0, 0.0), SharedShape::new(cube.clone()));
    vec![
        ("hull", cube.clone().into(), half, 4),
        ("cuboid", SharedShape::new(Cuboid::new(Vector::new(0.5, 0.4, 0.3))), 0.3, 4),
        ("ball", SharedShape::new(Ball::new(0.5)), 0.5, 1),
        ("capsule", SharedShape::new(Capsule::new_x(0.5, 0.25)), 0.25, 2),
        ("compound", SharedShape::new(Compound::new(vec![beside(-0.9 * half), beside(0.9 * half)])), half, 4),
    ]
}

/// A body that slides over a floor has its few points in every step, with the floor's normal, and
/// the points keep their data.
#[test]
fn bodies_slide_over_flat_floors() {
    for (floor, surface) in floors() {
        for (body, shape, half, count) in bodies() {
            for flipped in [false, true] {
                let what = format!("{body} on {floor}, {flipped}");
                let mut pair = PairMemory { flipped, ..PairMemory::default() };
                let mut kept = 0;
                for step in 0..60 {
                    let x = -1.6 + 0.05 * step as f32;
                    let at = Pose::translation(x, 0.02 + 0.3 * x, half - 1e-3);
                    pair.step(&surface, &*shape, &at);
                    let points = pair.points(&at);
                    assert!((count..=4).contains(&points.len()), "{what}, {step}: {points:?}");
                    for (normal, depth) in points {
                        assert!(normal.distance(Vector::Z) < 1e-4, "{what}, {step}: {normal}");
                        assert!(depth < 1.01e-3, "{what}, {step}: {depth}");
                    }
                    let deep = pair.points(&at).iter().filter(|(_, depth)| *depth > 0.99e-3).count();
                    assert!(deep >= count, "{what}, {step}: {deep}");
                    for point in pair.manifolds.iter_mut().flat_map(|m| &mut m.points) {
                        kept += usize::from(point.data > 0);
                        point.data = step + 1;
                    }
                }
                // All but a few of 59 steps.
                assert!(kept >= count * 50, "{what}: {kept}");
                pair.step(&surface, &*shape, &Pose::translation(0.0, 0.0, half + 1.0));
                assert!(pair.manifolds.iter().all(|m| m.points.is_empty()), "{what}");
            }
        }
    }
}

/// Points of a body that barely moves stay, and their distances follow.
#[test]
fn bodies_that_barely_move_keep_their_points() {
    let (surface, cube) = (square(), hull(&shapes::families::cube_grid(8, 1)));
    let half = cube.hull().bounds()[1].z;
    let mut pair = PairMemory::default();
    let mut at = |x: f32, z: f32| {
        let at = Pose::translation(x, 0.7, half + z);
        pair.step(&surface, &cube, &at);
        assert!(pair.points(&at).iter().all(|(_, depth)| (depth + z).abs() < 1e-5));
        pair.manifolds.iter().flat_map(|m| m.points.iter().map(|p| [p.local_p1, p.local_p2])).collect::<Vec<_>>()
    };
    let first = at(0.3, -0.002);
    assert_eq!(at(0.3005, -0.0025), first);
    assert_ne!(at(0.32, -0.0025), first);
}

/// jrouwe/JoltPhysics#1922: a box slides from one height field onto the next. As two shapes, each
/// pushes it along its way; joined, they do not. parry's own algorithm pushes, too.
#[test]
fn joined_fields_do_not_stop_a_box() {
    let half = |x: f64| BakedSurface::new(field(4, [x, -2.0], |_, _| 0.0));
    let (left, right) = (half(-4.0), half(0.0));
    let both = BakedSurface::joined([(Pose::IDENTITY, left), (Pose::IDENTITY, right.clone())]).unwrap();
    let die = hull(&packs::corners([-0.2, -0.3, -0.1], [0.2, 0.3, 0.1]));
    let (mut joined, mut alone, mut stumbles, mut of_parry) = (PairMemory::default(), PairMemory::default(), 0, 0);
    for step in 0..300 {
        let x = -0.6 + 0.004 * step as f32;
        let at = Pose::translation(x, 0.05 * x, 0.1 - 1e-3);
        let is_steep = |(normal, _): &(Vector, f32)| normal.distance(Vector::Z) > 1e-3;
        joined.step(&both, &die, &at);
        let points = joined.points(&at);
        assert!(points.len() >= 3 && !points.iter().any(is_steep), "x = {x}: {points:?}");
        alone.step(&right, &die, &at);
        stumbles += alone.points(&at).iter().filter(|point| is_steep(point)).count();
        let mut theirs: Manifolds = Vec::new();
        DefaultQueryDispatcher.contact_manifolds(&at, &both, &die, 0.02, &mut theirs, &mut None).unwrap();
        of_parry += theirs.iter().filter(|m| !m.points.is_empty() && m.local_n1.z < 0.99).count();
    }
    assert!(stumbles > 10, "{stumbles}");
    println!("{stumbles} wrong normals of one field alone, {of_parry} by parry's algorithm");
}

/// A body over far more triangles than there is memory for at first.
#[test]
fn a_large_body_touches_many_triangles() {
    let surface = BakedSurface::new(field(30, [-15.0; 2], |_, _| 0.0));
    let slab = hull(&packs::corners([-8.2, -8.1, -0.5], [8.3, 8.2, 0.5]));
    let mut pair = PairMemory::default();
    for step in 0..3 {
        let at = Pose::translation(0.1 * step as f32, 0.0, 0.499);
        pair.step(&surface, &slab, &at);
        let points = pair.points(&at);
        assert!(points.len() == 4 && points.iter().all(|(normal, _)| normal.distance(Vector::Z) < 1e-4), "{points:?}");
        let corner = |low: Vector, p: Vector| low.min(p);
        let places = || pair.manifolds.iter().flat_map(|m| m.points.iter().map(|p| p.local_p2));
        let (low, high) = (places().fold(Vector::INFINITY, corner), places().fold(Vector::NEG_INFINITY, Vector::max));
        assert!(low.x < -8.1 && low.y < -8.0 && high.x > 8.2 && high.y > 8.1, "{low} {high}");
    }
}
