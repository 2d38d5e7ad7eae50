//! Manifolds of a half-space: compared with the manifolds of a large box, which has the same
//! surface.

use crate::any_shape::update;
use glam::{DQuat, DVec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Rounded, Segment, Sphere, Triangle};
use hullmap::{Cache, Manifold, ManifoldSettings, Pack, Pose, Prediction, Shape};
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

/// The deepest point, the number of points and the area agree with those on a box of a kilometre.
#[test]
fn a_half_space_equals_a_large_box() {
    println!("seed {SEED:#x}");
    let packs = packs();
    let floor = HalfSpace::new(DVec3::Z, 0.0).unwrap();
    let slab = Cuboid::new(DVec3::new(1e3, 1e3, 1e3)).unwrap();
    let settings = ManifoldSettings { prediction: Prediction::Length(0.02), ..Default::default() };
    let mut rng = SplitMix64::new(SEED);
    let (mut several, mut separated, mut total) = (0, 0, 0);
    for (which, body) in bodies(&packs).iter().enumerate() {
        for i in 0..200 {
            let turn = rotation(&**body, &mut rng, i);
            let low = body.support_point(turn.inverse() * DVec3::NEG_Z).point;
            let height = rng.between(-0.05, 0.03) - (turn * low).z;
            let shift = DVec3::new(rng.between(-9.0, 9.0), rng.between(-9.0, 9.0), height);
            let pose = Pose::new(shift, turn).unwrap();
            let in_slab = Pose::new(shift + DVec3::Z * 1e3, turn).unwrap();
            let (mut found, mut twin) = (Manifold::new(), Manifold::new());
            let contact = found.update_half_space(&floor, &**body, pose, &settings);
            update(&mut twin, &slab, &**body, in_slab, &settings, &mut Cache::new());
            let at = format!("body {which}, {i}, {pose:?}:\n{found:?}\n{twin:?}");
            total += 1;
            separated += usize::from(!contact.hit);
            let depths = |m: &Manifold| m.points().iter().map(|p| p.depth).fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(found.points().is_empty(), twin.points().is_empty(), "{at}");
            if found.points().is_empty() {
                continue;
            }
            several += usize::from(found.points().len() >= 3);
            // The points are corners of the body itself, with one that is about as deep as the
            // deepest: depths within a tenth of the prediction count as equal.
            let deepest = (contact.point_a - contact.point_b).dot(contact.normal);
            assert!((depths(&found) - deepest).abs() <= 0.1 * 0.02 + 1e-9, "{at}");
            // On the box, the normal of a shallow contact of a curved shape is known within the
            // tolerance only, and points lie on the planes of merged faces.
            assert!((depths(&found) - depths(&twin)).abs() < 0.1 * 0.02 + 1e-3, "{at}");
            for point in found.points() {
                assert!((point.depth - (point.point_a - point.point_b).z).abs() < 1e-15, "{at}");
                assert!(point.point_a.z.abs() < 1e-9 && point.depth >= -0.02 - 1e-9, "{at}");
                assert!((pose.transform_point(point.local_b) - point.point_b).length() < 1e-9, "{at}");
                // No point of the body is lower than the lowest.
                assert!(point.depth <= contact.depth + 1e-9, "{at}");
            }
        }
    }
    assert!(several > total / 8 && separated > total / 10, "{several} and {separated} of {total}");
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

/// A box slides and rocks on the plane: its points keep id, impulse and user data.
#[test]
fn points_are_kept_from_frame_to_frame() {
    let wall = HalfSpace::new(DVec3::new(1.0, 1.0, 0.0), 2.0).unwrap();
    let body = Cuboid::new(DVec3::new(0.5, 0.7, 0.9)).unwrap();
    let onto = DQuat::from_rotation_arc(DVec3::NEG_X, -wall.normal());
    let mut manifold = Manifold::new();
    for step in 0..50 {
        let t = f64::from(step);
        let rock = DQuat::from_rotation_z(0.004 * (t * 0.7).sin());
        let along = DVec3::new(-1.0, 1.0, 0.3).normalize() * (0.05 * t);
        let pose = Pose::new(wall.normal() * (2.0 + 0.499) + along, rock * onto).unwrap();
        let contact = manifold.update_half_space(&wall, &body, pose, &ManifoldSettings::default());
        assert!(contact.hit && contact.normal == wall.normal());
        assert_eq!(manifold.points().len(), 4);
        for point in manifold.points_mut() {
            let id = format!("{}", point.id);
            assert!(id.starts_with("face to vertex"), "{id}");
            assert_eq!((point.age, point.impulse[0]), (step as u32, t), "{id}");
            point.impulse[0] += 1.0;
        }
    }
    // Far away the points are dropped.
    let far = Pose::from_translation(wall.normal() * 9.0).unwrap();
    assert!(!manifold.update_half_space(&wall, &body, far, &ManifoldSettings::default()).hit);
    assert!(manifold.points().is_empty());
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
