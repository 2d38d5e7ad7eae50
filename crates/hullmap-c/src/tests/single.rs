//! Queries of one shape, and casts: the bits of the crate for Rust.
#![allow(unsafe_code)]

use super::*;

/// Queries of one shape, and casts.
#[test]
fn rays_casts_points_and_bounds_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = hullmap::Pack::from_bytes(&file).unwrap();
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (mut rng, warm) = (SplitMix64::new(2), cache());
    let mut next = |size: f64| rng.between(-size, size);
    let (mut hits, mut total, mut hulls_near) = (0, 0, [0; 2]);
    let other = &shapes[5];
    let twin_other = hullmap::shapes::Cuboid::new(DVec3::new(0.5, 0.75, 1.0)).unwrap();
    for (shape, twin) in shapes.iter().zip(&twins) {
        let (mut twin_cache, mut twin_compound) = (hullmap::Cache::new(), hullmap::CompoundCache::default());
        // SAFETY: the pointer is valid.
        assert_eq!(unsafe { hullmap_cache_clear(warm.0) }, Code::Ok);
        for _ in 0..20 {
            let (origin, target) =
                (DVec3::new(next(4.0), next(4.0), next(4.0)), DVec3::new(next(0.7), next(0.7), next(0.7)));
            let direction = target - origin;
            let by = [next(1.0), next(1.0), next(1.0), next(1.0)];
            let pose = types::Pose {
                translation: vector(origin),
                rotation: types::Quat { x: by[0], y: by[1], z: by[2], w: by[3] },
            };
            let twin_pose = hullmap::Pose::new(origin, DQuat::from_array(by)).unwrap();
            let along_x = hullmap::Ray::new(DVec3::ZERO, DVec3::X).unwrap();
            let any = hullmap::ray(&twin_other, &along_x, &hullmap::CastSettings::default());
            let mut hit = types::RayHit::new(any, 9);
            let mut impact = types::Impact::new(hullmap::Impact::default(), [9, 9]);
            let (mut bounds, mut support) = (types::Bounds::default(), [types::Support::default(); 2]);
            let mut point = hullmap::signed_distance(
                &twin_other,
                DVec3::ZERO,
                &hullmap::Settings::default(),
                &mut hullmap::Cache::new(),
            )
            .map(|found| types::SignedDistance::new(found, 9))
            .unwrap();
            let directions = [vector(direction), vector(origin)];
            // SAFETY: the pointers are valid.
            let codes = unsafe {
                [
                    hullmap_ray(shape.0, vector(origin), vector(direction), null(), &raw mut hit),
                    hullmap_signed_distance(shape.0, vector(target), null(), warm.0, &raw mut point),
                    hullmap_cast(shape.0, other.0, &raw const pose, vector(direction), null(), warm.0, &raw mut impact),
                    hullmap_bounds(shape.0, &raw const pose, &raw mut bounds),
                    hullmap_support(shape.0, directions.as_ptr(), 2, support.as_mut_ptr()),
                ]
            };
            let (ray, motion) =
                (hullmap::Ray::new(origin, direction).unwrap(), hullmap::Motion::new(direction).unwrap());
            let (settings, cast_settings) = (hullmap::Settings::default(), hullmap::CastSettings::default());
            match twin {
                Twin::Convex(twin) => {
                    assert_eq!(codes, [Code::Ok; 5]);
                    let expected = hullmap::ray(&**twin, &ray, &cast_settings);
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    let expected = hullmap::signed_distance(&**twin, target, &settings, &mut twin_cache).unwrap();
                    same!(point, expected; distance lower upper; point normal; iterations support_calls);
                    let expected =
                        hullmap::cast(&**twin, &twin_other, twin_pose, motion, &cast_settings, &mut twin_cache);
                    same!(impact, expected; t t_lower t_upper; normal point_a point_b; hit iterations support_calls);
                    let expected = twin.bounds_under(twin_pose);
                    assert_eq!(
                        [bits(bounds.min), bits(bounds.max)],
                        [expected.min, expected.max].map(|v| bits(vector(v)))
                    );
                    for (found, direction) in support.iter().zip([direction, origin]) {
                        let expected = twin.support_point(direction);
                        assert_eq!(
                            (bits(found.point), found.feature),
                            (bits(vector(expected.point)), expected.feature)
                        );
                    }
                    total += 1;
                    hits += usize::from(hit.hit);
                }
                Twin::HalfSpace(twin) => {
                    assert_eq!(codes, [Code::Ok, Code::Ok, Code::Ok, Code::Unsupported, Code::Unsupported]);
                    let expected = twin.ray(&ray, &cast_settings);
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    same!(point, twin.signed_distance(target).unwrap(); distance lower upper; point normal; iterations);
                    let expected = twin.cast(&twin_other, twin_pose, motion, &cast_settings);
                    same!(impact, expected; t t_lower t_upper; normal point_a point_b; hit iterations support_calls);
                }
                Twin::Compound(twin) => {
                    let none = Code::Unsupported;
                    assert_eq!(codes, [Code::Ok, Code::Ok, Code::Ok, Code::Ok, none]);
                    let expected = compound::signed_distance(&**twin, target, &settings, &mut twin_compound).unwrap();
                    assert_eq!((point.hull as usize, expected.hulls[1]), (expected.hulls[0], 0));
                    let expected = expected.answer;
                    same!(point, expected; distance lower upper; point normal; iterations support_calls);
                    hulls_near[point.hull as usize] += 1;
                    let expected = compound::ray(&**twin, &ray, &cast_settings);
                    assert_eq!(hit.hull as usize, expected.hulls[0]);
                    let expected = expected.answer;
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    let expected =
                        compound::cast(&**twin, &twin_other, twin_pose, motion, &cast_settings, &mut twin_compound);
                    assert_eq!([impact.hull_a as usize, impact.hull_b as usize], expected.hulls);
                    let expected = expected.answer;
                    same!(impact, expected; t t_lower t_upper; normal point_a point_b; hit iterations support_calls);
                    assert!(message().contains("hullmap_shape_hull"), "{}", message());
                    let all: Vec<_> = twin_pack.hulls().map(|hull| hull.bounds_under(twin_pose)).collect();
                    assert_eq!(bits(bounds.min), bits(vector(all[0].min.min(all[1].min))));
                    assert_eq!(bits(bounds.max), bits(vector(all[0].max.max(all[1].max))));
                }
            }
        }
    }
    assert!(hits * 10 > total * 3, "{hits} of {total}");
    assert!(hulls_near.iter().all(|count| *count > 2), "{hulls_near:?}");
}
