//! Batches: the bits of single queries.
#![allow(unsafe_code)]

use super::*;

/// A thousand pairs of all kinds, in one call and one by one.
#[test]
fn batches_have_the_bits_of_single_queries() {
    let pack = open();
    let shapes = all_shapes(&pack);
    let mut rng = SplitMix64::new(3);
    let mut pairs = Vec::new();
    for i in 0..1000 {
        let (a, b) = (&shapes[i % shapes.len()], &shapes[(i / 7) % (shapes.len() - 1)]);
        pairs.push(ShapePair { a: a.0, b: b.0, b_in_a: random_pose(&mut rng, 1.4).1 });
    }
    let count = pairs.len();
    let (caches, twin_caches): (Vec<_>, Vec<_>) = (0..count).map(|_| (cache(), cache())).unzip();
    let (manifolds, twin_manifolds): (Vec<_>, Vec<_>) = (0..count).map(|_| (manifold(), manifold())).unzip();
    let handles: Vec<*mut Cache> = caches.iter().map(|cache| cache.0).collect();
    let manifold_handles: Vec<*mut Manifold> = manifolds.iter().map(|manifold| manifold.0).collect();
    let mut contacts = vec![types::Contact::default(); count];
    let mut gaps = vec![types::Distance::default(); count];
    let mut hits = vec![types::Intersection::default(); count];
    // Cold, warm, and without caches.
    for handles in [handles.as_ptr(), handles.as_ptr(), null()] {
        // SAFETY: the pointers are valid.
        unsafe {
            let p = pairs.as_ptr();
            assert_eq!(hullmap_batch_intersects(p, count, handles, hits.as_mut_ptr()), Code::Ok);
            assert_eq!(hullmap_batch_distance(p, count, null(), handles, gaps.as_mut_ptr()), Code::Ok);
            assert_eq!(hullmap_batch_contact(p, count, null(), handles, contacts.as_mut_ptr()), Code::Ok);
        }
        for (i, pair) in pairs.iter().enumerate() {
            let (mut hit, mut gap, mut contact) = (hits[i], gaps[i], contacts[i]);
            let cache = if handles.is_null() { null_mut() } else { twin_caches[i].0 };
            let pose = &raw const pair.b_in_a;
            // SAFETY: the pointers are valid.
            unsafe {
                assert_eq!(hullmap_intersects(pair.a, pair.b, pose, cache, &raw mut hit), Code::Ok);
                assert_eq!(hullmap_distance(pair.a, pair.b, pose, null(), cache, &raw mut gap), Code::Ok);
                assert_eq!(hullmap_contact(pair.a, pair.b, pose, null(), cache, &raw mut contact), Code::Ok);
            }
            same(&(i, hit, gap, contact), &(i, hits[i], gaps[i], contacts[i]));
        }
    }
    // SAFETY: zeros are a valid value.
    let mut shown = vec![unsafe { std::mem::zeroed::<types::ManifoldPoints>() }; count];
    // SAFETY: the pointers are valid.
    let code = unsafe {
        hullmap_batch_manifolds(pairs.as_ptr(), count, null(), manifold_handles.as_ptr(), shown.as_mut_ptr())
    };
    assert_eq!(code, Code::Ok, "{}", message());
    let mut points = 0;
    for (i, pair) in pairs.iter().enumerate() {
        let mut single = shown[i];
        // SAFETY: the pointers are valid, and the points live until the next update.
        unsafe {
            let manifold = twin_manifolds[i].0;
            let pose = &raw const pair.b_in_a;
            assert_eq!(hullmap_manifold_update(manifold, pair.a, pair.b, pose, null(), &raw mut single), Code::Ok);
            let [found, expected] =
                [shown[i], single].map(|shown| std::slice::from_raw_parts(shown.points, shown.count));
            assert_eq!(found, expected, "pair {i}");
            points += found.len();
        }
    }
    assert!(points > 500, "{points}");
}
