//! Queries of one shape, and casts: the bits of the crate for Rust.
#![allow(unsafe_code)]

use super::*;

/// Queries of one shape, and casts.
#[test]
fn rays_casts_points_and_bounds_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = twin_pack(&file);
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (mut rng, warm) = (SplitMix64::new(2), cache());
    let mut next = |size: f64| rng.between(-size, size);
    let (mut hits, mut total, mut hulls_near) = (0, 0, [0; 2]);
    let other = &shapes[5];
    let twin_other = twins[5].clone();
    for (shape, twin) in shapes.iter().zip(&twins) {
        let mut twin_cache = hullmap::Cache::new();
        // SAFETY: the pointer is valid.
        assert_eq!(unsafe { hullmap_cache_clear(warm.0) }, Code::Ok);
        for _ in 0..20 {
            let (origin, target) =
                (DVec3::new(next(4.0), next(4.0), next(4.0)), DVec3::new(next(0.7), next(0.7), next(0.7)));
            let direction = target - origin;
            let by = [next(1.0), next(1.0), next(1.0), next(1.0)];
            let pose = types::Pose { translation: origin, rotation: DQuat::from_array(by) };
            let twin_pose = hullmap::Pose::new(pose.translation, pose.rotation).unwrap();
            let along_x = hullmap::Ray::new(DVec3::ZERO, DVec3::X).unwrap();
            let any = hullmap::ray(&twin_other, &along_x, &hullmap::CastSettings::default());
            let mut hit = any;
            let mut impact = types::Impact::default();
            let (mut bounds, mut support) = (types::Bounds::default(), [types::SupportPoint::default(); 2]);
            let mut point = hullmap::signed_distance(
                &twin_other,
                DVec3::ZERO,
                &hullmap::Settings::default(),
                &mut hullmap::Cache::new(),
            )
            .unwrap();
            let directions = [direction, origin];
            // SAFETY: the pointers are valid.
            let codes = unsafe {
                [
                    hullmap_ray(shape.0, origin, direction, null(), &raw mut hit),
                    hullmap_signed_distance(shape.0, target, null(), warm.0, &raw mut point),
                    hullmap_cast(shape.0, other.0, &raw const pose, direction, null(), warm.0, &raw mut impact),
                    hullmap_bounds(shape.0, &raw const pose, &raw mut bounds),
                    hullmap_support(shape.0, directions.as_ptr(), 2, support.as_mut_ptr()),
                ]
            };
            let (ray, motion) =
                (hullmap::Ray::new(origin, direction).unwrap(), hullmap::Motion::new(direction).unwrap());
            let (settings, cast_settings) = (hullmap::Settings::default(), hullmap::CastSettings::default());
            let expected = hullmap::ray(twin, &ray, &cast_settings);
            same(&hit, &expected);
            let expected = hullmap::signed_distance(twin, target, &settings, &mut twin_cache).unwrap();
            same(&point, &expected);
            let expected = hullmap::cast(twin, &twin_other, twin_pose, motion, &cast_settings, &mut twin_cache);
            same(&impact, &expected);
            let is_plane = matches!(twin, SharedGeometry::HalfSpace(_));
            let [of_bounds, of_support] = [!is_plane, twin.as_shape().is_some()]
                .map(|is_known| if is_known { Code::Ok } else { Code::Unsupported });
            assert_eq!(codes, [Code::Ok, Code::Ok, Code::Ok, of_bounds, of_support]);
            if let Some(expected) = twin.bounds_under(twin_pose) {
                same(&bounds, &expected);
            }
            if let Some(twin) = twin.as_shape() {
                for (found, direction) in support.iter().zip([direction, origin]) {
                    same(found, &twin.support_point(direction));
                }
                total += 1;
                hits += usize::from(hit.hit);
            } else if twin.has_parts() {
                assert!(message().contains("hullmap_shape_hull"), "{}", message());
                hulls_near[point.part as usize] += 1;
            }
        }
    }
    assert!(hits * 10 > total * 3, "{hits} of {total}");
    assert!(hulls_near.iter().all(|count| *count > 2), "{hulls_near:?}");
}
