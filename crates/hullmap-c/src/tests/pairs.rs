//! Queries of pairs, of all kinds of shapes: the bits of the crate for Rust.
#![allow(unsafe_code)]

use super::*;

/// Every pair of kinds along random walks, with and without caches.
#[test]
fn answers_have_the_bits_of_the_crate_for_rust() {
    let (pack, file) = (open(), file());
    let twin_pack = hullmap::Pack::from_bytes(&file).unwrap();
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (settings, mut rng) = (hullmap::Settings::default(), SplitMix64::new(1));
    let (mut hits, mut total, mut points) = (0, 0, 0);
    for (a, twin_a) in shapes.iter().zip(&twins) {
        for (b, twin_b) in shapes.iter().zip(&twins) {
            let (warm, manifold) = (cache(), manifold());
            let mut twin_caches = [hullmap::Cache::new(), hullmap::Cache::new()];
            let mut twin_compound = hullmap::CompoundCache::default();
            let (mut twin_manifold, mut twin_manifolds) =
                (hullmap::Manifold::new(), hullmap::CompoundManifolds::new(8));
            let mut twin_pose;
            let (_, mut pose) = random_pose(&mut rng, 1.4);
            for step in 0..12 {
                if step % 4 == 0 {
                    (twin_pose, pose) = random_pose(&mut rng, 1.4);
                } else {
                    pose.translation.x += 0.01;
                    let by = DVec3::new(pose.translation.x, pose.translation.y, pose.translation.z);
                    let types::Quat { x, y, z, w } = pose.rotation;
                    twin_pose = hullmap::Pose::new(by, DQuat::from_xyzw(x, y, z, w)).unwrap();
                }
                let mut hit = types::Intersection::new(hullmap::Intersection::default(), [9, 9]);
                let mut contact = types::Contact::separated();
                let mut gap = types::Distance::new(hullmap::Distance::default(), [9, 9]);
                let mut shown = types::ManifoldPoints {
                    points: null_mut(),
                    count: 9,
                    touching: 9,
                    dropped: 9,
                    pairs: 9,
                    iterations: 9,
                    support_calls: 9,
                };
                // SAFETY: the pointers are valid.
                let codes = unsafe {
                    [
                        hullmap_intersects(a.0, b.0, &raw const pose, warm.0, &raw mut hit),
                        hullmap_distance(a.0, b.0, &raw const pose, null(), warm.0, &raw mut gap),
                        hullmap_contact(a.0, b.0, &raw const pose, null(), warm.0, &raw mut contact),
                        hullmap_manifold_update(manifold.0, a.0, b.0, &raw const pose, null(), &raw mut shown),
                    ]
                };
                let expected = if let Twin::HalfSpace(_) = twin_b { Code::Unsupported } else { Code::Ok };
                assert_eq!(codes, [expected; 4], "{}", message());
                if expected != Code::Ok {
                    continue;
                }
                let [twin_cache, manifold_cache] = &mut twin_caches;
                let manifold_settings = hullmap::ManifoldSettings::default();
                macro_rules! check_compound {
                    ($a:expr, $b:expr) => {{
                        let (a, b) = ($a, $b);
                        let found = compound::intersects(a, b, twin_pose, &mut twin_compound);
                        same!(hit, found.answer; ; ; iterations support_calls);
                        assert_eq!([hit.hull_a as usize, hit.hull_b as usize], found.hulls);
                        let found = compound::distance(a, b, twin_pose, &settings, &mut twin_compound);
                        same_distance(&gap, &found.answer);
                        assert_eq!([gap.hull_a as usize, gap.hull_b as usize], found.hulls);
                        match compound::contact(a, b, twin_pose, &settings, &mut twin_compound) {
                            Some(found) => {
                                same_contact(&contact, &found.answer);
                                assert_eq!([contact.hull_a as usize, contact.hull_b as usize], found.hulls);
                            }
                            None => assert!(!contact.hit && contact.status == types::Status::Separated),
                        }
                        let counts = twin_manifolds.update(a, b, twin_pose, &manifold_settings);
                        assert_eq!((shown.touching, shown.pairs), (counts.touching, counts.pairs));
                        points += same_points(&shown, &twin_manifolds.iter().collect::<Vec<_>>());
                    }};
                }
                // A single hull counts as a compound of one hull, which the solver knows as a hull.
                let as_compound = |index: usize| {
                    let own = shapes.get(index).filter(|_| index < 2);
                    own.map(|_| Compound::from(twin_pack.hull(index).unwrap()))
                };
                let at = |shape: *mut Shape| shapes.iter().position(|other| other.0 == shape).unwrap();
                match (twin_a, twin_b) {
                    (Twin::Convex(a), Twin::Convex(b)) => {
                        let found = hullmap::intersects(&**a, &**b, twin_pose, twin_cache);
                        same!(hit, found; ; ; iterations support_calls);
                        same_distance(&gap, &hullmap::distance(&**a, &**b, twin_pose, &settings, twin_cache));
                        same_contact(&contact, &hullmap::contact(&**a, &**b, twin_pose, &settings, twin_cache));
                        twin_manifold.update(&**a, &**b, twin_pose, &manifold_settings, manifold_cache);
                        points += same_points(&shown, &[([0, 0], &twin_manifold)]);
                    }
                    (Twin::Compound(a), Twin::Compound(b)) => check_compound!(&**a, &**b),
                    (Twin::Compound(a), Twin::Convex(convex)) => match as_compound(at(b.0)) {
                        Some(b) => check_compound!(&**a, &b),
                        None => check_compound!(&**a, &**convex),
                    },
                    (Twin::Convex(convex), Twin::Compound(b)) => match as_compound(at(a.0)) {
                        Some(a) => check_compound!(&a, &**b),
                        None => check_compound!(&**convex, &**b),
                    },
                    (Twin::HalfSpace(a), Twin::Convex(b)) => {
                        same!(hit, a.intersects(&**b, twin_pose); ; ; iterations support_calls);
                        same_distance(&gap, &a.distance(&**b, twin_pose));
                        same_contact(&contact, &a.contact(&**b, twin_pose));
                        twin_manifold.update_half_space(a, &**b, twin_pose, &manifold_settings);
                        points += same_points(&shown, &[([0, 0], &twin_manifold)]);
                    }
                    (Twin::HalfSpace(a), Twin::Compound(b)) => {
                        let found = compound::half_space::intersects(a, &**b, twin_pose);
                        same!(hit, found.answer; ; ; iterations support_calls);
                        same_distance(&gap, &compound::half_space::distance(a, &**b, twin_pose).answer);
                        same_contact(&contact, &compound::half_space::contact(a, &**b, twin_pose).answer);
                        twin_manifolds.update_half_space(a, &**b, twin_pose, &manifold_settings);
                        points += same_points(&shown, &twin_manifolds.iter().collect::<Vec<_>>());
                    }
                    (_, Twin::HalfSpace(_)) => unreachable!("checked above"),
                }
                total += 1;
                hits += usize::from(hit.hit);
            }
        }
    }
    assert!(total == 12 * 11 * 12 && hits * 10 > total * 3 && hits * 10 < total * 9, "{hits} of {total}");
    assert!(points > 500, "{points}");
}
