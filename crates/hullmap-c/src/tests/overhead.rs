//! Time that the interface adds to a query.
#![allow(unsafe_code)]

use super::*;

/// Prints nanoseconds per query through the interface and through the crate for Rust: medians over
/// interleaved rounds.
///
///     cargo test --release --package hullmap-c --lib overhead -- --ignored --nocapture
#[test]
#[ignore = "prints times, in a release build"]
fn overhead() {
    use std::{hint::black_box, time::Instant};
    const POSES: usize = 256;
    /// Median nanoseconds of each function, called in turn.
    fn measure<const N: usize>(mut functions: [&mut dyn FnMut(usize); N]) -> [f64; N] {
        let mut times: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
        for _ in 0..81 {
            for (function, times) in functions.iter_mut().zip(&mut times) {
                let start = Instant::now();
                (0..POSES).for_each(&mut **function);
                times.push(start.elapsed().as_nanos() as f64 / POSES as f64);
            }
        }
        times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
    }
    // Through pointers that the compiler does not know, as from C.
    type Shapes = *const Shape;
    type QueryFunction<S, T> =
        unsafe extern "C" fn(Shapes, Shapes, *const types::Pose, *const S, *mut Cache, *mut T) -> Code;
    let contact: QueryFunction<types::Settings, types::Contact> = black_box(hullmap_contact);
    let distance: QueryFunction<types::Settings, types::Distance> = black_box(hullmap_distance);
    let intersects: unsafe extern "C" fn(_, _, _, _, _) -> _ = black_box(hullmap_intersects);
    let support: unsafe extern "C" fn(_, _, _, _) -> _ = black_box(hullmap_support);
    let update: unsafe extern "C" fn(_, _, _, _, _, _) -> _ = black_box(hullmap_manifold_update);
    println!("| vertices | query | C, ns | Rust, ns | difference, ns |\n|---|---|---|---|---|");
    for count in [8, 32, 512, 8192] {
        let sets = [1, 2].map(|seed| packs::point_set("ball", &shapes::families::sphere(count, seed)));
        let file = packs::bytes(&sets, hullmap_bake::IndexKind::Tree, &hullmap_bake::SourceRecord::default()).unwrap();
        let twin = hullmap::Pack::from_bytes(&file).unwrap();
        let (left, right) = (twin.hull(0).unwrap(), twin.hull(1).unwrap());
        // SAFETY: the pointers are valid.
        let pack =
            Owned::new(hullmap_pack_free, |out| unsafe { hullmap_pack_from_memory(file.as_ptr(), file.len(), 0, out) });
        // SAFETY: the pointers are valid.
        let [a, b] =
            [0, 1].map(|index| Owned::new(hullmap_shape_free, |out| unsafe { hullmap_shape_hull(pack.0, index, out) }));
        for (name, x) in [("touching", 1.9), ("apart", 2.5)] {
            let mut rng = SplitMix64::new(7);
            let poses: Vec<types::Pose> = (0..POSES)
                .map(|step| {
                    let (_, mut pose) = random_pose(&mut rng, 0.01);
                    // A slow walk, as in a simulation.
                    pose.translation.x = x + 1e-4 * step as f64;
                    pose.rotation = DQuat { x: 0.1, y: 1e-3 * step as f64, z: 0.2, w: 1.0 };
                    pose
                })
                .collect();
            let pose_of = |pose: types::Pose| {
                let DQuat { x, y, z, w } = pose.rotation;
                hullmap::Pose::new(pose.translation, DQuat::from_xyzw(x, y, z, w)).unwrap()
            };
            let settings = hullmap::Settings::default();
            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Contact::default();
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { contact(a.0, b.0, &raw const poses[i], null(), warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::contact(&left, &right, pose, &settings, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | contact, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Distance::default();
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { distance(a.0, b.0, &raw const poses[i], null(), warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::distance(&left, &right, pose, &settings, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | distance, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Intersection::default();
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { intersects(a.0, b.0, &raw const poses[i], warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::intersects(&left, &right, pose, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | intersects, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (manifold, mut twin_cache) = (manifold(), hullmap::Cache::new());
            let mut twin_manifold = hullmap::Manifold::new();
            // SAFETY: zeros are a valid value.
            let mut out = unsafe { std::mem::zeroed::<types::ManifoldPoints>() };
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { update(manifold.0, a.0, b.0, &raw const poses[i], null(), &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let settings = hullmap::ManifoldSettings::default();
                twin_manifold.update(&left, &right, pose_of(poses[i]), &settings, &mut twin_cache);
                black_box(twin_manifold.points());
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | manifold, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);
        }
        let mut rng = SplitMix64::new(8);
        let directions: Vec<DVec3> = (0..POSES).map(|_| DVec3::from_array(rng.direction())).collect();
        let mut out = vec![types::SupportPoint::default(); POSES];
        let mut one = out.clone();
        let mut by_c = |i: usize| {
            // SAFETY: the pointers are valid.
            assert!(unsafe { support(a.0, &raw const directions[i], 1, one.as_mut_ptr()) } == Code::Ok);
            black_box(&one);
        };
        let mut all = |i: usize| {
            if i == 0 {
                // SAFETY: the pointers are valid.
                let code = unsafe { support(a.0, directions.as_ptr(), POSES, out.as_mut_ptr()) };
                assert!(code == Code::Ok);
                black_box(&out);
            }
        };
        let mut by_rust = |i: usize| {
            black_box(left.support_point(directions[i]));
        };
        let [c, many, rust] = measure([&mut by_c, &mut all, &mut by_rust]);
        println!("| {count} | support | {c:.1} | {rust:.1} | {:.1} |", c - rust);
        println!("| {count} | support, {POSES} in one call | {many:.1} | {rust:.1} | {:.1} |", many - rust);
    }
}
