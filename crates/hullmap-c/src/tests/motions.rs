//! Motions and derivatives: the bits of the crate for Rust.
#![allow(unsafe_code)]

use hullmap::RigidMotion;

use super::*;
use crate::exports::motion::*;
use crate::types::MotionKind;

fn number_of(kind: MotionKind) -> u32 {
    kind as u32
}

fn empty<T>() -> T {
    // SAFETY: the types are plain numbers and enums with a variant 0.
    unsafe { std::mem::zeroed() }
}

/// A random motion of each kind, and the same for C.
fn random_motion(rng: &mut SplitMix64, kind: u32) -> (RigidMotion, types::Motion) {
    let (twin_start, start) = random_pose(rng, 2.5);
    let (twin_end, end) = random_pose(rng, 2.5);
    let mut next = |size: f64| rng.between(-size, size);
    let [linear, angular, center] = [1.0, 4.0, 1.0].map(|size| DVec3::new(next(size), next(size), next(size)));
    let twin = match kind {
        0 => Ok(RigidMotion::still(twin_start)),
        1 => RigidMotion::between(twin_start, twin_end),
        _ => RigidMotion::screw(twin_start, linear, angular, center),
    };
    (twin.unwrap(), types::Motion { kind, start, end, linear, angular, center })
}

#[test]
fn motions_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = twin_pack(&file);
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (other, twin_other) = (&shapes[1], &twins[1]);
    let mut rng = SplitMix64::new(17);
    let (mut hits, mut free, mut unique) = (0, 0, 0);
    for (shape, twin) in shapes.iter().zip(&twins) {
        for case in 0..12 {
            let ((twin_a, motion_a), (twin_b, motion_b)) =
                (random_motion(&mut rng, case % 3), random_motion(&mut rng, 1 + case % 2));
            let (mut found, mut by, mut clear): (types::TimeOfImpact, types::Derivatives, types::Clearance) =
                (empty(), empty(), empty());
            // SAFETY: the pointers are valid.
            let codes = unsafe {
                let (a, b) = (&raw const motion_a, &raw const motion_b);
                [
                    hullmap_cast_motion(shape.0, a, other.0, b, null(), null_mut(), &raw mut found, &raw mut by),
                    hullmap_clear(shape.0, a, other.0, b, null(), null_mut(), &raw mut clear),
                ]
            };
            let settings = hullmap::MotionSettings::default();
            let (own, cache) = (hullmap::ClearSettings::default(), || hullmap::Cache::new());
            let expected = hullmap::cast_motion(twin, &twin_a, twin_other, &twin_b, &settings, &mut cache());
            let expected_clear = hullmap::clear(twin, &twin_a, twin_other, &twin_b, &own, &mut cache());
            let with_other = |a: &dyn hullmap::Shape| {
                let derivatives = |b: &dyn hullmap::Shape| expected.derivatives(a, &twin_a, b, &twin_b);
                twin_other.with_part(expected.parts[1], derivatives)
            };
            match twin.with_part(expected.parts[0], with_other).flatten() {
                Some(slopes) => {
                    assert_eq!(by, slopes);
                    unique += usize::from(slopes.status == hullmap::Differentiability::Unique);
                }
                None => assert_eq!(by.status, types::Differentiability::Inaccurate),
            }
            same(&found, &expected);
            hits += usize::from(found.hit);
            assert_eq!(codes, [Code::Ok; 2]);
            same(&clear, &expected_clear);
            free += usize::from(expected_clear.verdict == hullmap::Verdict::Free);
        }
    }
    assert!(hits > 40 && free > 20 && unique > 10, "{hits} hits, {free} free, {unique} with derivatives");
}

#[test]
fn derivatives_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = twin_pack(&file);
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let twin_b = twins[1].as_shape().unwrap();
    let (mut rng, settings) = (SplitMix64::new(18), hullmap::Settings::default());
    let mut unique = [0; 2];
    for (shape, twin) in shapes.iter().zip(&twins) {
        for _ in 0..10 {
            let (twin_pose, pose) = random_pose(&mut rng, 1.2);
            let (mut gap, mut contact): (types::Distance, types::Contact) = (empty(), empty());
            let mut by: [types::Derivatives; 2] = [empty(), empty()];
            let mut of_points: [types::WitnessDerivatives; 2] = [empty(), empty()];
            let ([of_gap, of_depth], [at_gap, at_depth]) = (&mut by, &mut of_points);
            // SAFETY: the pointers are valid.
            let codes = unsafe {
                let (b, pose, none) = (shapes[1].0, &raw const pose, null_mut());
                [
                    hullmap_distance_derivatives(shape.0, b, pose, null(), none, &raw mut gap, of_gap, at_gap),
                    hullmap_contact_derivatives(shape.0, b, pose, null(), none, &raw mut contact, of_depth, at_depth),
                ]
            };
            let Some(a) = twin.as_shape() else {
                assert_eq!(codes, [Code::Unsupported; 2]);
                continue;
            };
            assert_eq!(codes, [Code::Ok; 2]);
            let b = twin_b;
            let expected = hullmap::distance(a, b, twin_pose, &settings, &mut hullmap::Cache::new());
            same(&gap, &expected);
            assert_eq!(by[0], expected.derivatives(a, b, twin_pose));
            assert_eq!(of_points[0], expected.witness_derivatives(a, b, twin_pose));
            let mut cache = hullmap::Cache::new();
            let expected = hullmap::contact(a, b, twin_pose, &settings, &mut cache);
            same(&contact, &expected);
            assert_eq!(by[1], expected.derivatives(a, b, twin_pose, &settings, &mut cache));
            let expected = expected.witness_derivatives(a, b, twin_pose, &settings, &mut cache);
            assert_eq!(of_points[1], expected);
            for (count, by) in unique.iter_mut().zip(&by) {
                *count += usize::from(by.status == types::Differentiability::Unique);
            }
        }
    }
    assert!(unique.iter().all(|count| *count > 10), "{unique:?}");
}

#[test]
fn derivatives_of_rays_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = twin_pack(&file);
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (mut rng, mut unique, mut missing) = (SplitMix64::new(23), 0, 0);
    for (shape, twin) in shapes.iter().zip(&twins) {
        for case in 0..20 {
            let origin = DVec3::from_array([0, 1, 2].map(|_| rng.between(-3.0, 3.0)));
            let aim = DVec3::from_array([0, 1, 2].map(|_| rng.between(-0.5, 0.5)));
            let direction = if case % 5 == 0 { origin } else { aim - origin };
            let (mut hit, mut by): (types::RayHit, types::Derivatives) = (empty(), empty());
            // SAFETY: the pointers are valid.
            let code =
                unsafe { hullmap_ray_derivatives(shape.0, origin, direction, null(), &raw mut hit, &raw mut by) };
            let Some(twin) = twin.as_shape() else {
                assert_eq!(code, Code::Unsupported);
                continue;
            };
            assert_eq!(code, Code::Ok);
            let ray = hullmap::Ray::new(origin, direction).unwrap();
            let expected = hullmap::ray(twin, &ray, &hullmap::CastSettings::default());
            same(&hit, &expected);
            assert_eq!(by, expected.derivatives(twin, &ray));
            unique += usize::from(by.status == types::Differentiability::Unique);
            missing += usize::from(by.status == types::Differentiability::Missing);
        }
    }
    assert!(unique > 20 && missing > 20, "{unique} with derivatives, {missing} without a hit");
}

#[test]
fn wrong_motions_are_errors() {
    let pack = open();
    let shapes = all_shapes(&pack);
    let mut rng = SplitMix64::new(3);
    let (_, fine) = random_motion(&mut rng, number_of(MotionKind::Screw));
    let run = |motion_b: &types::Motion, b: *const Shape| {
        let mut found: types::Clearance = empty();
        // SAFETY: the pointers are valid or NULL.
        unsafe { hullmap_clear(shapes[0].0, &raw const fine, b, motion_b, null(), null_mut(), &raw mut found) }
    };
    let wrong_kind = types::Motion { kind: 3, ..fine };
    assert_eq!(run(&wrong_kind, shapes[1].0), Code::InvalidArgument);
    assert!(message().contains("motion_b") && message().contains("HullmapMotionKind"), "{}", message());
    let infinite = types::Motion { linear: DVec3 { x: f64::INFINITY, ..DVec3::ZERO }, ..fine };
    assert_eq!(run(&infinite, shapes[1].0), Code::InvalidArgument);
    let turned = types::Pose { translation: DVec3::ZERO, rotation: DQuat::from_array([0.0; 4]) };
    assert_eq!(run(&types::Motion { start: turned, ..fine }, shapes[1].0), Code::InvalidArgument);
    assert_eq!(run(&fine, null()), Code::Null);
    let plane = shapes.last().unwrap().0;
    assert_eq!(run(&fine, plane), Code::Ok);
    let (fine, mut found): (_, types::Clearance) = (&raw const fine, empty());
    // SAFETY: the pointers are valid or NULL.
    let code = unsafe { hullmap_clear(plane, fine, plane, fine, null(), null_mut(), &raw mut found) };
    assert_eq!(code, Code::Unsupported);
    // Members of other kinds are not read.
    let still = types::Motion { kind: number_of(MotionKind::Still), ..infinite };
    assert_eq!(run(&still, shapes[1].0), Code::Ok);
}
