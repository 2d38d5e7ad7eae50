//! Queries of pairs, of all kinds of shapes: the bits of the crate for Rust.
#![allow(unsafe_code)]

use super::*;

/// Every pair of kinds along random walks, with and without caches.
#[test]
fn answers_have_the_bits_of_the_crate_for_rust() {
    let (pack, file) = (open(), file());
    let twin_pack = twin_pack(&file);
    let (mut shapes, mut twins) = (all_shapes(&pack), all_twins(&twin_pack));
    for (shape, twin) in meshes::sheets() {
        shapes.push(shape);
        twins.push(twin);
    }
    let (settings, mut rng) = (hullmap::Settings::default(), SplitMix64::new(1));
    let (mut hits, mut total, mut points) = (0, 0, 0);
    for (a, twin_a) in shapes.iter().zip(&twins) {
        for (b, twin_b) in shapes.iter().zip(&twins) {
            let (warm, manifold) = (cache(), manifold());
            let (mut twin_cache, mut twin_manifolds) = (hullmap::Cache::new(), hullmap::CompoundManifolds::new(8));
            let mut twin_pose;
            let (_, mut pose) = random_pose(&mut rng, 1.4);
            for step in 0..12 {
                if step % 4 == 0 {
                    (twin_pose, pose) = random_pose(&mut rng, 1.4);
                } else {
                    pose.translation.x += 0.01;
                    twin_pose = hullmap::Pose::new(pose.translation, pose.rotation).unwrap();
                }
                let mut hit = types::Intersection::default();
                let mut contact = types::Contact::default();
                let mut gap = types::Distance::default();
                // SAFETY: zeros are a valid value.
                let mut shown = unsafe { std::mem::zeroed::<types::ManifoldPoints>() };
                // SAFETY: the pointers are valid.
                let codes = unsafe {
                    [
                        hullmap_intersects(a.0, b.0, &raw const pose, warm.0, &raw mut hit),
                        hullmap_distance(a.0, b.0, &raw const pose, null(), warm.0, &raw mut gap),
                        hullmap_contact(a.0, b.0, &raw const pose, null(), warm.0, &raw mut contact),
                        hullmap_manifold_update(manifold.0, a.0, b.0, &raw const pose, null(), &raw mut shown),
                    ]
                };
                let are_planes = twin_a.check_pair(twin_b).is_err();
                let expected = if are_planes { Code::Unsupported } else { Code::Ok };
                assert_eq!(codes, [expected; 4], "{}", message());
                if are_planes {
                    continue;
                }
                same(&hit, &hullmap::intersects(twin_a, twin_b, twin_pose, &mut twin_cache));
                same(&gap, &hullmap::distance(twin_a, twin_b, twin_pose, &settings, &mut twin_cache));
                same(&contact, &hullmap::contact(twin_a, twin_b, twin_pose, &settings, &mut twin_cache));
                let counts = twin_manifolds.update(twin_a, twin_b, twin_pose, &hullmap::ManifoldSettings::default());
                assert_eq!((shown.touching, shown.pairs), (counts.touching, counts.pairs));
                points += same_points(&shown, &twin_manifolds.iter().collect::<Vec<_>>());
                total += 1;
                hits += usize::from(hit.is_hit());
            }
        }
    }
    assert!(total == 12 * (14 * 14 - 1) && hits * 10 > total * 3 && hits * 10 < total * 9, "{hits} of {total}");
    assert!(points > 500, "{points}");
}
