//! Casts of shapes that move and turn, against brute force in f64 at many times.

use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap_parry::{BakedHull, BakedSurface, HullDispatcher};
use hullmap_random::SplitMix64;
use hullmap_testkit::gap::gap;
use hullmap_testkit::packs;
use hullmap_testkit::polytope::Polytope;
use parry3d::math::{Pose, Vector};
use parry3d::query::{DefaultQueryDispatcher, NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastStatus};
use parry3d::shape::{Ball, Compound, Cuboid, HalfSpace, Shape, SharedShape};
use shapes::families;

use crate::bodies::{hull, pose, rotation, wide_pose};
use crate::judge::time;

/// The window in which shapes are cast.
const WINDOW: [f32; 2] = [0.25, 1.25];

fn polytope(points: &[[f32; 3]]) -> Polytope {
    Polytope::new(&packs::tree_pack(points).hull(0).unwrap())
}

fn cuboid_points(half: [f32; 3]) -> Vec<[f32; 3]> {
    packs::corners(half.map(|c| -c), half)
}

fn cuboid(half: [f32; 3]) -> BakedHull {
    hull(&cuboid_points(half))
}

/// A shape of parry's, and the solids that it is the union of.
struct Body {
    shape: SharedShape,
    solids: Vec<Polytope>,
}

impl Body {
    fn of_points(points: &[[f32; 3]]) -> Self {
        Self { shape: hull(points).into(), solids: vec![polytope(points)] }
    }

    fn radius(&self) -> f64 {
        self.solids.iter().map(Polytope::greatest).fold(0.0, f64::max)
    }

    fn cuboid(half: [f32; 3]) -> Self {
        let shape = SharedShape::new(Cuboid::new(Vector::from_array(half)));
        Self { shape, ..Self::of_points(&cuboid_points(half)) }
    }

    fn compound(seed: u64) -> Self {
        let mut rng = SplitMix64::new(seed);
        let (mut parts, mut solids) = (Vec::new(), Vec::new());
        for part in 0..3 {
            let points = families::rock(12, seed + part);
            let at = pose(&mut rng, 1.0);
            solids.push(polytope(&points).placed(wide_pose(&at)));
            parts.push((at, hull(&points).into()));
        }
        Self { shape: SharedShape::new(Compound::new(parts)), solids }
    }

    /// Triangles around the origin, in one tile or in two.
    fn surface(seed: u64, tiles: usize) -> Self {
        let mut rng = SplitMix64::new(seed);
        let (mut surfaces, mut solids) = (Vec::new(), Vec::new());
        for _ in 0..tiles {
            let at = pose(&mut rng, 0.5);
            let corner = |rng: &mut SplitMix64| (DVec3::from_array(rng.direction()) * 1.2).as_vec3().to_array();
            let positions: Vec<[f32; 3]> = (0..12).map(|_| corner(&mut rng)).collect();
            let corners: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            surfaces.push((at, BakedSurface::new(Arc::new(packs::triangle_mesh(&positions, &corners)))));
            let solid = |t: &[u32; 3]| polytope(&t.map(|corner| positions[corner as usize])).placed(wide_pose(&at));
            solids.extend(corners.iter().map(solid));
        }
        Self { shape: BakedSurface::joined(surfaces).unwrap().into(), solids }
    }
}

/// The pose at a time, in f64, by the definition in parry's documents.
fn pose_at(motion: &NonlinearRigidMotion, t: f64) -> hullmap::Pose {
    let start = wide_pose(&motion.start);
    let center = start.transform_point(motion.local_center.as_dvec3());
    let turn = DQuat::from_scaled_axis(motion.angvel.as_dvec3() * t);
    let place = center + motion.linvel.as_dvec3() * t + turn * (start.translation() - center);
    hullmap::Pose::new(place, (turn * start.rotation()).normalize()).unwrap()
}

/// A pair in motion.
struct Case<'c> {
    bodies: [&'c Body; 2],
    motions: [NonlinearRigidMotion; 2],
}

impl Case<'_> {
    /// Distance of the solids at a time; 0 if they overlap.
    fn apart(&self, t: f64) -> f64 {
        let [a, b] = [0, 1].map(|side| {
            let place = pose_at(&self.motions[side], t);
            self.bodies[side].solids.iter().map(|solid| solid.placed(place)).collect::<Vec<_>>()
        });
        let gaps = a.iter().flat_map(|a| b.iter().map(|b| gap(a, b).upper));
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// Whether the solids overlap at a time, up to rounding error.
    fn overlaps(&self, t: f64) -> bool {
        self.apart(t) < 1e-9
    }

    /// Whether the solids overlap at one of many times.
    fn meets(&self, [start, end]: [f64; 2]) -> bool {
        (0..60).any(|i| self.overlaps(start + (end - start) * f64::from(i) / 60.0))
    }

    fn cast(&self, dispatcher: &dyn QueryDispatcher, [a, b]: [&dyn Shape; 2]) -> Option<ShapeCastHit> {
        let [motion_a, motion_b] = &self.motions;
        dispatcher.cast_shapes_nonlinear(motion_a, a, motion_b, b, WINDOW[0], WINDOW[1], true).unwrap()
    }

    fn swapped(&self) -> Self {
        Self { bodies: [self.bodies[1], self.bodies[0]], motions: [self.motions[1], self.motions[0]] }
    }
}

/// Casts a pair, judges the answers, and counts hits, misses, and meetings for which parry finds no
/// hit, or a later one.
fn judge(what: &str, case: &Case<'_>, [hits, misses, late]: &mut [usize; 3]) {
    let window = WINDOW.map(f64::from);
    for (case, flipped) in [(case, false), (&case.swapped(), true)] {
        let Some(hit) = case.cast(&HullDispatcher, case.bodies.map(|body| &*body.shape)) else {
            assert!(!case.meets(window), "{what}: missed");
            *misses += usize::from(!flipped);
            continue;
        };
        *hits += usize::from(!flipped);
        // They do not meet before. At the time, they are as near as the tolerance and rounding to
        // f32 allow, at speeds of at most 40.
        let time = f64::from(hit.time_of_impact);
        assert!(time == window[0] || !case.meets([window[0], time]), "{what}: late at {time}");
        let (apart, size) = (case.apart(time), case.bodies.iter().map(|body| body.radius()).sum::<f64>());
        assert!(apart < 4e-6 * size + 8e-6, "{what}: {apart} apart at {time}");
        if time == window[0] {
            assert_eq!(hit.status, ShapeCastStatus::PenetratingOrWithinTargetDist, "{what}");
            continue;
        }
        assert_eq!(hit.status, ShapeCastStatus::Converged, "{what}");
        let [a, b] = [0, 1].map(|side| pose_at(&case.motions[side], time));
        let apart = a.transform_point(hit.witness1.as_dvec3()).distance(b.transform_point(hit.witness2.as_dvec3()));
        assert!(apart < 1e-4, "{what}: {apart} between the points");
        let [n1, n2] = [a.transform_vector(hit.normal1.as_dvec3()), b.transform_vector(hit.normal2.as_dvec3())];
        assert!((n1 + n2).length() < 1e-4 && (n1.length() - 1.0).abs() < 1e-4, "{what}: {n1} {n2}");
        let of_parry = case.bodies.map(|body| body.shape.as_shape::<BakedHull>()?.to_convex_polyhedron());
        if let ([Some(a), Some(b)], false) = (of_parry, flipped) {
            let theirs = case.cast(&DefaultQueryDispatcher, [&a, &b]);
            let end = theirs.map_or(window[1], |hit| f64::from(hit.time_of_impact));
            *late += usize::from(case.meets([time, end]));
        }
    }
}

/// Random motions, most of which come near.
fn motions(rng: &mut SplitMix64, spin: f64) -> [NonlinearRigidMotion; 2] {
    let vector = |rng: &mut SplitMix64, length: f64| (DVec3::from_array(rng.direction()) * length).as_vec3();
    let (a, b) = (pose(rng, 0.1), pose(rng, 4.0));
    let aim = vector(rng, 2.0) - b.translation;
    let still = NonlinearRigidMotion::new(a, vector(rng, 0.3), vector(rng, 0.3), vector(rng, 1.0));
    [still, NonlinearRigidMotion::new(b, vector(rng, 0.4), aim, vector(rng, spin))]
}

#[test]
fn bodies_meet_when_brute_force_says() {
    let (rock, other) = (Body::of_points(&families::rock(30, 1)), Body::compound(6));
    let mut rng = SplitMix64::new(1);
    for (name, body) in [
        ("hull", Body::of_points(&families::prism(8, 1))),
        ("cuboid", Body::cuboid([0.5, 0.8, 0.3])),
        ("compound", Body::compound(3)),
        ("surface", Body::surface(4, 1)),
        ("two tiles", Body::surface(5, 2)),
    ] {
        let mut counts = [0; 3];
        for case in 0..40 {
            let motions = motions(&mut rng, 4.0);
            let other = if case % 2 == 0 { &other } else { &rock };
            judge(&format!("{name}, {case}"), &Case { bodies: [&body, other], motions }, &mut counts);
        }
        println!("{name}: {counts:?} hits, misses, and late with parry");
        assert!(counts[0] >= 8 && counts[1] >= 3, "{name}: {counts:?}");
    }
}

/// Rods of 100:1 that turn by up to three turns beside a thin wall, and towards it.
#[test]
fn a_spinning_rod_does_not_pass_a_thin_wall() {
    let (rod, wall) =
        (Body::of_points(&cuboid_points([1.0, 0.01, 0.01])), Body::of_points(&cuboid_points([2.0, 0.005, 2.0])));
    let (mut rng, mut counts) = (SplitMix64::new(3), [0; 3]);
    for case in 0..80 {
        let place = Vector::new(0.3, rng.between(0.3, 1.3) as f32, 0.1);
        let axis = DVec3::new(rng.between(-0.3, 0.3), rng.between(-0.3, 0.3), 1.0).normalize();
        let spin = (axis * rng.between(1.0, 18.0)).as_vec3();
        let fall = Vector::new(0.1, rng.between(-3.0, 0.1) as f32, 0.0);
        let start = Pose::from_parts(place, rotation(&mut rng).as_quat());
        let motions = [
            NonlinearRigidMotion::constant_position(Pose::IDENTITY),
            NonlinearRigidMotion::new(start, Vector::ZERO, fall, spin),
        ];
        judge(&format!("rod, {case}"), &Case { bodies: [&wall, &rod], motions }, &mut counts);
    }
    println!("{counts:?} hits, misses, and late with parry");
    assert!(counts[0] >= 40 && counts[2] > 0, "{counts:?}");
}

/// Rods of 100:1 that touch the front of a thin wall with one end at the start, and swing or fly
/// through it. Rapier ignores the touch, so no later hit would let the rod pass.
#[test]
fn a_rod_that_touches_a_thin_wall_does_not_swing_through() {
    let (half, thick) = ([1.0, 0.01, 0.01], 0.005_f64);
    let (rod, wall) = (hull(&cuboid_points(half)), hull(&cuboid_points([thick as f32, 4.0, 4.0])));
    let of_parry = [&wall, &rod].map(|hull| hull.to_convex_polyhedron().unwrap());
    let corners: Vec<DVec3> = cuboid_points(half).into_iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let mut rng = SplitMix64::new(4);
    let (mut passed, mut swings) = ([0, 0], 0);
    for _ in 0..60 {
        let turn = rotation(&mut rng);
        let reach = corners.iter().map(|p| (turn * *p).x).fold(0.0, f64::max);
        let place = DVec3::new(-thick - reach, rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        let spin = DVec3::from_array(rng.direction()) * rng.between(0.5, 3.0);
        let velocity = DVec3::new(rng.between(0.0, 1.0), rng.between(-1.0, 1.0), 0.0);
        let start = Pose::from_parts(place.as_vec3(), turn.as_quat());
        let motion = NonlinearRigidMotion::new(start, Vector::ZERO, velocity.as_vec3(), spin.as_vec3());
        let deepest = |t: f64| {
            let place = pose_at(&motion, t);
            corners.iter().map(|p| place.transform_point(*p).x + thick).fold(f64::NEG_INFINITY, f64::max)
        };
        // Whether a corner leaves the wall at its back.
        let is_through = |end: f64| (0..=100).any(|i| deepest(end * f64::from(i) / 100.0) > 2.0 * thick);
        if !is_through(1.0) {
            continue;
        }
        swings += 1;
        let cast = |dispatcher: &dyn QueryDispatcher, [a, b]: [&dyn Shape; 2]| {
            let hit = dispatcher.cast_shapes_nonlinear(&still, a, &motion, b, 0.0, 1.0, false).unwrap();
            // Rapier ignores a hit at the start.
            hit.map(|hit| f64::from(hit.time_of_impact)).filter(|time| *time > 0.0).unwrap_or(1.0)
        };
        passed[0] += usize::from(is_through(cast(&HullDispatcher, [&wall, &rod])));
        passed[1] += usize::from(is_through(cast(&DefaultQueryDispatcher, [&of_parry[0], &of_parry[1]])));
    }
    println!("of {swings} rods that would pass, {} do, and with parry {}", passed[0], passed[1]);
    assert!(swings > 40 && passed[0] == 0, "{passed:?} of {swings}");
}

/// Half-spaces, which parry's own casts do not support: a rod and a ball that turn onto a floor.
#[test]
fn bodies_turn_onto_a_half_space() {
    let floor = HalfSpace::new(Vector::Y);
    let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
    let rod = cuboid([1.0, 0.01, 0.01]);
    let quarter = std::f32::consts::FRAC_PI_2;
    let turning = |height: f32| {
        NonlinearRigidMotion::new(Pose::translation(0.0, height, 0.0), Vector::ZERO, Vector::ZERO, Vector::Z * quarter)
    };
    let cast = |a: &dyn Shape, motion_a: &NonlinearRigidMotion, b: &dyn Shape, motion_b: &NonlinearRigidMotion| {
        time(HullDispatcher.cast_shapes_nonlinear(motion_a, a, motion_b, b, 0.0, 1.0, true).unwrap())
    };
    // The corner at (-1, -0.01) or (1, -0.01) reaches y = 0.
    let angle = (0.6 / 1.0001_f64.sqrt()).asin() - 0.01_f64.atan();
    for found in [cast(&floor, &still, &rod, &turning(0.6)), cast(&rod, &turning(0.6), &floor, &still)] {
        assert!((f64::from(found) * std::f64::consts::FRAC_PI_2 - angle).abs() < 1e-5, "{found}");
    }
    assert_eq!(cast(&floor, &still, &rod, &turning(1.1)), f32::INFINITY);
    let ball = Ball::new(0.25);
    let swinging =
        NonlinearRigidMotion::new(Pose::translation(1.0, 0.75, 0.0), Vector::NEG_X, Vector::ZERO, Vector::Z * -quarter);
    let found = cast(&floor, &still, &ball, &swinging);
    assert!((f64::from(found) * std::f64::consts::FRAC_PI_2 - 0.5_f64.asin()).abs() < 1e-5, "{found}");
}

/// Bodies that touch at the start.
#[test]
fn bodies_in_contact_stop_only_if_asked_to() {
    let cube = cuboid([0.5; 3]);
    let floor_points =
        [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [4.0, 0.0, 9.0], [4.0, 0.0, -9.0], [4.0, 5.0, 9.0], [4.0, 5.0, -9.0]];
    let mesh = |corners: &[[u32; 3]]| BakedSurface::new(Arc::new(packs::triangle_mesh(&floor_points, corners)));
    let floor = mesh(&[[0, 1, 2], [0, 2, 3]]);
    let level = mesh(&[[0, 1, 2], [0, 2, 3], [2, 4, 5], [2, 5, 3]]);
    let slab = cuboid([9.0, 1.0, 9.0]);
    let (still, lower) = (
        NonlinearRigidMotion::constant_position(Pose::IDENTITY),
        NonlinearRigidMotion::constant_position(Pose::translation(0.0, -1.0, 0.0)),
    );
    let plane = HalfSpace::new(Vector::Y);
    let sliding = |velocity: Vector| {
        NonlinearRigidMotion::new(Pose::translation(0.0, 0.4999, 0.0), Vector::ZERO, velocity, Vector::ZERO)
    };
    let grounds: [(&str, &dyn Shape, &NonlinearRigidMotion, f32); 4] = [
        ("floor", &floor, &still, f32::INFINITY),
        ("level", &level, &still, 0.35),
        ("slab", &slab, &lower, f32::INFINITY),
        ("half-space", &plane, &still, f32::INFINITY),
    ];
    for (name, ground, motion, wall) in grounds {
        for up in [0.0, 0.5] {
            let body = sliding(Vector::new(10.0, up, 0.0));
            let cast = |stop: bool, swapped: bool| {
                let found = if swapped {
                    HullDispatcher.cast_shapes_nonlinear(&body, &cube, motion, ground, 0.0, 1.0, stop)
                } else {
                    HullDispatcher.cast_shapes_nonlinear(motion, ground, &body, &cube, 0.0, 1.0, stop)
                };
                time(found.unwrap())
            };
            for swapped in [false, true] {
                assert_eq!(cast(true, swapped), 0.0, "{name}");
                let found = cast(false, swapped);
                assert!(found == wall || (found - wall).abs() < 1e-4, "{name}, {up}: {found} {wall}");
            }
        }
    }
}

/// Numbers that are not finite, and windows of no length.
#[test]
fn invalid_numbers_are_harmless() {
    let (rock, surface) = (hull(&families::rock(12, 1)), Body::surface(1, 1).shape);
    for bad in [f32::NAN, f32::INFINITY, 1e38] {
        for [start, end] in [[0.0, bad], [bad, 1.0], [0.5, 0.5], [1.0, 0.0]] {
            let motion = NonlinearRigidMotion::new(Pose::IDENTITY, Vector::ZERO, Vector::X, Vector::splat(bad));
            let still = NonlinearRigidMotion::constant_position(Pose::translation(5.0, 0.0, 0.0));
            let _ = HullDispatcher.cast_shapes_nonlinear(&still, &*surface, &still, &rock, start, end, true);
            let _ = HullDispatcher.cast_shapes_nonlinear(
                &motion,
                &rock,
                &still,
                &HalfSpace::new(Vector::Y),
                0.0,
                1.0,
                false,
            );
        }
    }
}
