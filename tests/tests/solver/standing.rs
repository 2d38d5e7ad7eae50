//! Contact manifolds in a small rigid-body simulation: a body on a box remains standing.
//!
//! The simulation is the simplest that physics engines use: semi-implicit Euler, sequential
//! impulses with warm starting and friction (Catto, "Iterative dynamics with temporal coherence",
//! GDC 2005), inertia from the pack. A body remains standing if its manifolds support it on all
//! sides. With incomplete manifolds it tips over, which the same simulation shows.

use glam::{DMat3, DQuat, DVec3};
use hullmap::shapes::{Cone, Cuboid, Cylinder, Rounded, Scaled};
use hullmap::{Cache, Hull, Manifold, ManifoldSettings, Pose, manifold::ManifoldPoint};
use hullmap_bake::IndexKind;
use hullmap_testkit::packs::pack;
use hullmap_tests::soak::body::Any;
use shapes::solids::{extrusion, regular_polygon};

const STEP: f64 = 1.0 / 60.0;
const STEPS: usize = 300;
const ROUNDS: usize = 12;
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);
const FRICTION: f64 = 0.6;
/// Fraction of the depth beyond the slop that one step corrects.
const BAUMGARTE: f64 = 0.2;
/// Depth that is not corrected (slop), relative to the body's size.
const SLOP: f64 = 1e-3;

/// A standing body: its shape and mass properties.
#[derive(Clone, Copy)]
struct Solid<'a> {
    shape: &'a Any<'a>,
    centroid: DVec3,
    /// About the centroid, over the mass: xx, yy, zz, yz, zx, xy.
    moments: [f64; 6],
    size: f64,
}

impl<'a> Solid<'a> {
    fn new(hull: &'a Hull) -> Self {
        Self { shape: hull, centroid: hull.centroid(), moments: hull.second_moments(), size: hull.diameter() }
    }
}

/// A body of mass 1.
struct Body<'a> {
    solid: Solid<'a>,
    center: DVec3,
    rotation: DQuat,
    velocity: DVec3,
    spin: DVec3,
    inverse_inertia: DMat3,
}

impl<'a> Body<'a> {
    /// Its lowest point at height `height`, turned by `rotation`.
    fn new(solid: Solid<'a>, rotation: DQuat, height: f64) -> Self {
        let [xx, yy, zz, yz, zx, xy] = solid.moments;
        let inertia = DMat3::from_cols(
            DVec3::new(yy + zz, -xy, -zx),
            DVec3::new(-xy, zz + xx, -yz),
            DVec3::new(-zx, -yz, xx + yy),
        );
        let low = rotation * (solid.shape.support_point(rotation.inverse() * DVec3::NEG_Z).point - solid.centroid);
        Self {
            solid,
            center: DVec3::Z * (height - low.z),
            rotation,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            inverse_inertia: inertia.inverse(),
        }
    }

    fn pose(&self) -> Pose {
        Pose::new(self.center - self.rotation * self.solid.centroid, self.rotation).unwrap()
    }

    fn inverse_inertia(&self) -> DMat3 {
        let turn = DMat3::from_quat(self.rotation);
        turn * self.inverse_inertia * turn.transpose()
    }

    fn push(&mut self, impulse: DVec3, arm: DVec3) {
        self.velocity += impulse;
        self.spin += self.inverse_inertia() * arm.cross(impulse);
    }

    fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(arm)
    }

    /// Change of the velocity at the point by a unit impulse along `axis`.
    fn response(&self, arm: DVec3, axis: DVec3) -> f64 {
        1.0 + (self.inverse_inertia() * arm.cross(axis)).cross(arm).dot(axis)
    }
}

/// How the points of a step are found.
#[derive(Clone, Copy)]
enum Points<'a> {
    Manifold,
    /// The first four corners of the bottom face. Some engines keep no more of a face.
    FirstFour(&'a Hull<'a>),
}

/// A point of contact: in the floor's frame, whose top is at 0 here.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: DVec3,
    depth: f64,
    impulse: [f64; 3],
}

/// Result of a simulation.
#[derive(Debug, Default)]
struct Outcome {
    /// Maximum and final angle from the initial orientation, in degrees.
    greatest_tilt: f64,
    last_tilt: f64,
    /// Final height of the centre, relative to the initial height.
    fall: f64,
    last_speed: f64,
    /// Number of points over all steps, and how many of them persisted from the previous step.
    points: usize,
    kept: usize,
}

/// Lets `body` stand on a box whose top is at 0.
fn simulate(mut body: Body, points: Points<'_>) -> Outcome {
    let floor: &Any<'_> = &Cuboid::new(DVec3::new(20.0, 20.0, 1.0)).unwrap();
    let size = body.solid.size;
    let (mut manifold, mut cache) = (Manifold::new(), Cache::new());
    let (up, start) = (body.rotation.inverse() * DVec3::Z, body.center);
    let mut outcome = Outcome::default();
    for _ in 0..STEPS {
        body.velocity += GRAVITY * STEP;
        let pose = body.pose();
        let lowered = Pose::new(pose.translation() + DVec3::Z, pose.rotation()).unwrap();
        manifold.update(floor, body.solid.shape, lowered, &ManifoldSettings::default(), &mut cache);
        if let Points::FirstFour(hull) = points {
            let face = hull.face_towards(body.rotation.inverse() * DVec3::NEG_Z).unwrap();
            let corners = hull.face(face).take(4).map(|v| pose.transform_point(hull.vertex(v).unwrap().as_dvec3()));
            let mut found: Vec<Point> = corners.map(|at| Point { at, depth: -at.z, impulse: [0.0; 3] }).collect();
            solve(&mut body, DVec3::Z, &mut found, SLOP * size);
        } else {
            let at = |p: &ManifoldPoint| Point { at: p.point_b - DVec3::Z, depth: p.depth, impulse: p.impulse };
            let mut found: Vec<Point> = manifold.points().iter().map(at).collect();
            solve(&mut body, manifold.normal(), &mut found, SLOP * size);
            manifold.points_mut().iter_mut().zip(found).for_each(|(kept, p)| kept.impulse = p.impulse);
        }
        body.center += body.velocity * STEP;
        body.rotation = (DQuat::from_scaled_axis(body.spin * STEP) * body.rotation).normalize();
        outcome.points += manifold.points().len();
        outcome.kept += manifold.points().iter().filter(|p| p.age > 0).count();
        outcome.last_tilt = (body.rotation * up).angle_between(DVec3::Z).to_degrees();
        outcome.greatest_tilt = outcome.greatest_tilt.max(outcome.last_tilt);
    }
    outcome.fall = (start.z - body.center.z) / size;
    outcome.last_speed = body.velocity.length() + body.spin.length() * size;
    outcome
}

/// Sequential impulses, warm: each point in turn stops approaching, and slides no faster than
/// friction lets it.
fn solve(body: &mut Body, normal: DVec3, points: &mut [Point], slop: f64) {
    let side = normal.any_orthonormal_vector();
    let axes = [normal, side, normal.cross(side)];
    for point in points.iter() {
        let impulse: DVec3 = axes.iter().zip(point.impulse).map(|(axis, p)| *axis * p).sum();
        body.push(impulse, point.at - body.center);
    }
    for _ in 0..ROUNDS {
        for point in points.iter_mut() {
            let arm = point.at - body.center;
            // A gap may close within the step; depth beyond the slop is pushed out.
            let wanted = if point.depth > 0.0 { BAUMGARTE * (point.depth - slop).max(0.0) } else { point.depth } / STEP;
            let change = (wanted - body.velocity_at(arm).dot(normal)) / body.response(arm, normal);
            let total = (point.impulse[0] + change).max(0.0);
            body.push(normal * (total - point.impulse[0]), arm);
            point.impulse[0] = total;
            let max = FRICTION * point.impulse[0];
            for (axis, impulse) in axes.iter().zip(&mut point.impulse).skip(1) {
                let change = -body.velocity_at(arm).dot(*axis) / body.response(arm, *axis);
                let total = (*impulse + change).clamp(-max, max);
                body.push(*axis * (total - *impulse), arm);
                *impulse = total;
            }
        }
    }
}

/// An n-gon prism, four times as high as its radius.
fn prism(n: usize) -> Vec<[f32; 3]> {
    extrusion(&regular_polygon(n, 0.5), -1.0, 1.0).vertices
}

/// `points` after `rotation`, in f32: no cap is flat to the last digit.
fn turned(points: &[[f32; 3]], rotation: DQuat) -> Vec<[f32; 3]> {
    points.iter().map(|p| (rotation * DVec3::from_array(p.map(f64::from))).as_vec3().to_array()).collect()
}

fn asset(name: &str) -> Vec<[f32; 3]> {
    let path = hullmap_outside::files::workspace().join("assets").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| -> [f32; 3] {
        line.split_whitespace().map(|c| c.parse().unwrap()).collect::<Vec<f32>>().try_into().unwrap()
    };
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(numbers).collect()
}

fn some_rotation() -> DQuat {
    DQuat::from_xyzw(0.3, -0.5, 0.2, 0.7).normalize()
}

/// Places the body on the box, in exact contact and dropped, and asserts that it remains standing.
fn assert_solid_stands(name: &str, solid: Solid, upright: DQuat) {
    for drop in [0.0, 0.01 * solid.size] {
        let outcome = simulate(Body::new(solid, upright, drop), Points::Manifold);
        println!("{name}, dropped by {drop:.3}: {outcome:?}");
        assert!(outcome.greatest_tilt < 0.5, "{name}: {outcome:?}");
        assert!(outcome.last_speed < 1e-2 && outcome.fall.abs() < 0.02, "{name}: {outcome:?}");
        assert!(outcome.kept as f64 > 0.9 * outcome.points as f64, "{name}: {outcome:?}");
    }
}

fn assert_stands(name: &str, points: &[[f32; 3]], upright: DQuat) {
    let pack = pack(name, points, IndexKind::Tree);
    assert_solid_stands(name, Solid::new(&pack.hull(0).unwrap()), upright);
}

#[test]
fn prisms_stand() {
    for n in [3, 4, 5, 8, 16, 64, 1024] {
        assert_stands(&format!("prism of {n}"), &prism(n), DQuat::IDENTITY);
    }
}

/// Like typical meshes: modelled upright, turned, and stored in f32.
#[test]
fn prisms_whose_caps_are_not_quite_flat_stand() {
    let rotation = some_rotation();
    for n in [4, 8, 16, 64, 1024] {
        assert_stands(&format!("turned prism of {n}"), &turned(&prism(n), rotation), rotation.inverse());
    }
}

#[test]
fn an_imported_mesh_stands() {
    let pawn = asset("pawn.obj");
    let rotation = some_rotation();
    assert_stands("pawn", &pawn, DQuat::IDENTITY);
    assert_stands("turned pawn", &turned(&pawn, rotation), rotation.inverse());
}

/// Round bases, scaled and rounded hulls.
#[test]
fn shapes_stand() {
    let cylinder = Cylinder::new(1.0, 0.5).unwrap();
    let size = 5_f64.sqrt();
    let moments = [0.25 / 4.0, 0.25 / 4.0, 1.0 / 3.0, 0.0, 0.0, 0.0];
    let solid = Solid { shape: &cylinder, centroid: DVec3::ZERO, moments, size };
    assert_solid_stands("cylinder", solid, DQuat::IDENTITY);

    let cone = Cone::new(1.0, 0.5).unwrap();
    let moments = [0.25 * 3.0 / 20.0, 0.25 * 3.0 / 20.0, 4.0 * 3.0 / 80.0, 0.0, 0.0, 0.0];
    let solid = Solid { shape: &cone, centroid: DVec3::Z * -0.5, moments, size };
    assert_solid_stands("cone", solid, DQuat::IDENTITY);

    let pack = pack("prism", &prism(12), IndexKind::Tree);
    let hull = pack.hull(0).unwrap();
    let plain = Solid::new(&hull);
    let rounded = Rounded::new(hull, 0.1).unwrap();
    assert_solid_stands("rounded prism", Solid { shape: &rounded, ..plain }, DQuat::IDENTITY);
    let scale = DVec3::new(-1.5, 1.0, 0.5);
    let scaled = Scaled::new(hull, scale).unwrap();
    let [xx, yy, zz, ..] = plain.moments;
    let moments = [xx * scale.x * scale.x, yy * scale.y * scale.y, zz * scale.z * scale.z, 0.0, 0.0, 0.0];
    assert_solid_stands("mirrored prism", Solid { shape: &scaled, moments, ..plain }, DQuat::IDENTITY);
}

/// The simulation detects incomplete manifolds: the first four corners of a face support a box, but
/// not a prism with many sides.
#[test]
fn the_first_four_corners_do_not_support_a_prism() {
    for n in [4, 8, 16, 64] {
        let pack = pack("prism", &prism(n), IndexKind::Tree);
        let hull = pack.hull(0).unwrap();
        let outcome = simulate(Body::new(Solid::new(&hull), DQuat::IDENTITY, 0.0), Points::FirstFour(&hull));
        println!("prism of {n} on its first four corners: {outcome:?}");
        assert_eq!(outcome.greatest_tilt > 5.0, n >= 8, "prism of {n}: {outcome:?}");
    }
}
