//! Manifolds of a half-space, and a half-space as B.

use std::sync::Arc;

use crate::compound::pack;
use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Rounded, Segment, Sphere, Triangle};
use hullmap::{
    Cache, CastSettings, ClearSettings, CompoundManifolds, Manifold, ManifoldSettings, Motion, MotionSettings, Overlap,
    Pack, Pose, Prediction, RigidMotion, Settings, Shape, SharedGeometry,
};
use hullmap_testkit::{packs::tree_pack, random::RandomPoses};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0x005e_ed07;

fn packs() -> Vec<Pack> {
    [Family::Rock, Family::Prism, Family::Cone, Family::CubeGrid, Family::Sphere]
        .map(|family| tree_pack(&family.points(200, 1)))
        .into()
}

fn bodies(packs: &[Pack]) -> Vec<Box<dyn Shape + Sync + '_>> {
    let mut all: Vec<Box<dyn Shape + Sync>> = vec![
        Box::new(Cuboid::new(DVec3::new(0.4, 0.6, 0.9)).unwrap()),
        Box::new(Sphere::new(0.5).unwrap()),
        Box::new(Capsule::new(0.5, 0.25).unwrap()),
        Box::new(Capsule::between(DVec3::ZERO, DVec3::new(0.6, 0.4, -0.2), 0.25).unwrap()),
        Box::new(Cylinder::new(0.4, 0.5).unwrap()),
        Box::new(Cone::new(0.5, 0.5).unwrap()),
        Box::new(Segment::new(DVec3::NEG_X, DVec3::Y).unwrap()),
        Box::new(Triangle::new([DVec3::X, DVec3::Y, DVec3::new(-1.0, -0.5, 0.2)]).unwrap()),
        Box::new(Rounded::new(Cuboid::new(DVec3::splat(0.4)).unwrap(), 0.1).unwrap()),
    ];
    for pack in packs {
        all.push(Box::new(pack.hull(0).unwrap()));
    }
    all
}

/// Rotations that lay a body on a face, an edge or a corner, exactly or nearly.
fn rotation(body: &(dyn Shape + Sync), rng: &mut SplitMix64, i: usize) -> DQuat {
    let down = match i % 4 {
        0 => DVec3::AXES[rng.below(3)],
        1 => DVec3::NEG_Z,
        _ => rng.unit_vector(),
    };
    let mut feature = hullmap::Feature::new();
    body.feature(down, &mut feature);
    let corners: Vec<DVec3> = feature.corners().iter().map(|corner| corner.point).collect();
    let normal = match corners[..] {
        [a, b, c, ..] => (b - a).cross(c - a).try_normalize().unwrap_or(down),
        _ => down,
    };
    let normal = if normal.dot(down) < 0.0 { -normal } else { normal };
    let lean = DQuat::from_axis_angle(rng.unit_vector(), [0.0, 1e-9, 1e-3, 0.01, 0.3][rng.below(5)]);
    lean * DQuat::from_rotation_arc(normal, DVec3::NEG_Z)
}

/// The deepest vertex of a rock was missing, since other points are nearly as deep and span more
/// area. Points that have been there may be preferred to it, but a new manifold has none.
#[test]
fn a_new_manifold_has_the_deepest_point() {
    println!("seed {SEED:#x}");
    let packs = packs();
    let floor = HalfSpace::new(DVec3::Z, 0.0).unwrap();
    let settings = ManifoldSettings { prediction: Prediction::Length(0.05), ..Default::default() };
    let mut rng = SplitMix64::new(SEED + 1);
    let mut many = 0;
    for (which, body) in bodies(&packs).iter().enumerate() {
        for i in 0..200 {
            let pose = Pose::new(DVec3::Z * rng.between(-0.5, 0.5), rotation(&**body, &mut rng, i)).unwrap();
            let mut manifold = Manifold::new();
            let contact = manifold.update_half_space(&floor, &**body, pose, &settings);
            if manifold.points().is_empty() {
                continue;
            }
            let signed = (contact.point_a - contact.point_b).dot(contact.normal);
            let deepest = manifold.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            let off = (deepest - signed).abs() / body.outer_radius();
            assert!(off <= 1e-4, "body {which}, {i}, {pose:?}: {off:e}, {manifold:?}");
            many += usize::from(manifold.points().len() == 4);
        }
    }
    assert!(many > 500, "{many}");
}

/// Tiny and huge bodies, far from the origin.
#[test]
fn nothing_depends_on_the_scale() {
    for size in [1e-30, 1e-3, 1.0, 1e4, 1e30] {
        let floor = HalfSpace::new(DVec3::Z, 3.0 * size).unwrap();
        let body = Cuboid::new(DVec3::splat(size)).unwrap();
        let pose = Pose::from_translation(DVec3::new(50.0, -20.0, 3.99) * size).unwrap();
        let mut manifold = Manifold::new();
        let contact = manifold.update_half_space(&floor, &body, pose, &ManifoldSettings::default());
        assert!((contact.depth - 0.01 * size).abs() < 1e-13 * size, "{contact:?}");
        assert_eq!(manifold.points().len(), 4, "{size}");
    }
}

/// A half-space as B has the answers of the exchanged pair, against a shape and a pack: the same
/// numbers, points and normals in the frame of the other, and the manifolds keep their points.
#[test]
fn a_half_space_as_b_has_the_exchanged_answers() {
    let seed = 0xb0;
    println!("seed {seed}");
    let (mut rng, pack) = (SplitMix64::new(seed), pack(5, 1.0, 7));
    let shape = Cuboid::new(DVec3::new(0.3, 0.7, 0.5)).unwrap();
    let things = [SharedGeometry::from(Arc::new(pack)), SharedGeometry::from_shape(shape)];
    let (settings, casts, motions) = (Settings::default(), CastSettings::default(), MotionSettings::default());
    let (mut hits, mut rounds, none) = (0, 0, || Cache::new());
    for thing in &things {
        for _ in 0..300 {
            let wall = HalfSpace::new(rng.unit_vector(), rng.between(-1.5, 0.5)).unwrap();
            // The thing in the frame of the wall, and the wall in the frame of the thing.
            let pose = Pose::new(rng.unit_vector(), rng.rotation()).unwrap();
            let back = pose.inverse();
            let point = |p: DVec3, q: DVec3| assert!(back.transform_point(p).distance(q) < 1e-12, "{p} {q}");
            let normal = |n: DVec3, m: DVec3| assert!(back.transform_vector(-n).distance(m) < 1e-12, "{n} {m}");
            let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-10 * (1.0 + x.abs()) || x == y, "{x} {y}");

            let (c, turned) = (
                hullmap::contact(&wall, thing, pose, &settings, &mut none()),
                hullmap::contact(thing, &wall, back, &settings, &mut none()),
            );
            assert_eq!((c.hit, c.parts), (turned.hit, [turned.parts[1], turned.parts[0]]));
            near(c.depth, turned.depth);
            normal(c.normal, turned.normal);
            point(c.point_a, turned.point_b);
            point(c.point_b, turned.point_a);
            let yes = hullmap::intersects(thing, &wall, back, &mut none());
            assert_eq!((yes.is_hit(), yes.parts), (c.hit, turned.parts));
            let (d, turned) = (
                hullmap::distance(&wall, thing, pose, &settings, &mut none()),
                hullmap::distance(thing, &wall, back, &settings, &mut none()),
            );
            near(d.distance, turned.distance);
            point(d.point_a, turned.point_b);
            point(d.point_b, turned.point_a);
            let mut seen = Vec::new();
            hullmap::contacts(thing, &wall, back, &settings, &mut none(), |c| seen.push(c.parts[0]));
            assert_eq!(seen.contains(&c.parts[1]), c.hit);

            // The thing moves by a velocity in the frame of the wall: there, the wall moves against
            // it.
            let velocity = rng.unit_vector();
            let against = Motion::new(back.transform_vector(-velocity)).unwrap();
            let (i, turned) = (
                hullmap::cast(&wall, thing, pose, Motion::new(velocity).unwrap(), &casts, &mut none()),
                hullmap::cast(thing, &wall, back, against, &casts, &mut none()),
            );
            assert_eq!((i.hit, i.status, i.parts), (turned.hit, turned.status, [turned.parts[1], turned.parts[0]]));
            near(i.t, turned.t);
            if i.hit {
                // At the time of impact, the thing is at `pose` plus the way.
                let on = |p: DVec3| back.transform_point(p - velocity * i.t);
                let apart = on(i.point_b).distance(turned.point_a).max(on(i.point_a).distance(turned.point_b));
                assert!(apart < 1e-9 * (1.0 + i.t), "{apart}");
            }
            let end = Pose::new(rng.unit_vector(), rng.rotation()).unwrap();
            let (still, moving) = (RigidMotion::still(Pose::IDENTITY), RigidMotion::between(pose, end).unwrap());
            let t = hullmap::cast_motion(&wall, &still, thing, &moving, &motions, &mut none());
            let turned = hullmap::cast_motion(thing, &moving, &wall, &still, &motions, &mut none());
            assert_eq!((t.hit, t.t, t.point_a, t.normal), (turned.hit, turned.t, turned.point_b, -turned.normal));
            let way = ClearSettings::default();
            let free = hullmap::clear(&wall, &still, thing, &moving, &way, &mut none());
            let turned = hullmap::clear(thing, &moving, &wall, &still, &way, &mut none());
            assert_eq!((free.verdict, free.clearance), (turned.verdict, turned.clearance));
            assert_eq!(free.parts, [turned.parts[1], turned.parts[0]]);

            let (mut own, mut exchanged) = (CompoundManifolds::new(5), CompoundManifolds::new(5));
            for step in 0..3 {
                let pose = Pose::new(pose.translation() + wall.normal() * (0.01 * f64::from(step)), pose.rotation());
                // The same bits as inside.
                let back = pose.unwrap().inverse();
                own.update(&wall, thing, back.inverse(), &ManifoldSettings::default());
                exchanged.update(thing, &wall, back, &ManifoldSettings::default());
                assert_eq!(own.len(), exchanged.len());
                for (([_, part], of_wall), (pair, found)) in own.iter().zip(exchanged.iter()) {
                    assert_eq!(pair, [part, 0]);
                    for (p, q) in of_wall.points().iter().zip(found.points()) {
                        assert_eq!((p.id.on_a(), p.id.on_b(), p.age), (q.id.on_b(), q.id.on_a(), q.age));
                        near(p.depth, q.depth);
                        assert!(p.local_b.distance(q.point_a) < 1e-12 && p.point_a.distance(q.local_b) < 1e-12);
                        assert!((q.point_a - q.point_b - found.normal() * q.depth).length() < 1e-6);
                    }
                }
            }
            (hits, rounds) = (hits + usize::from(c.hit), rounds + 1);
        }
    }
    assert!((rounds * 3 / 10..rounds * 7 / 10).contains(&hits), "{hits} of {rounds} overlap");
}

/// Two half-spaces: nothing is claimed.
#[test]
fn two_half_spaces_claim_nothing() {
    let (floor, none) = (HalfSpace::new(DVec3::Z, 0.0).unwrap(), &mut Cache::new());
    let settings = Settings::default();
    let c = hullmap::contact(&floor, &floor, Pose::IDENTITY, &settings, none);
    let d = hullmap::distance(&floor, &floor, Pose::IDENTITY, &settings, none);
    assert_eq!([c.depth_lower, c.depth_upper, d.lower, d.upper], [0.0, f64::INFINITY, 0.0, f64::INFINITY]);
    assert_eq!(hullmap::intersects(&floor, &floor, Pose::IDENTITY, none).status, Overlap::Undecided);
    let shared = SharedGeometry::from(floor);
    let error = shared.check_pair(&shared).unwrap_err().to_string();
    assert!(error.starts_with("two half-spaces have no query"), "{error}");
}
