//! Data that the caller writes into manifold points.
#![allow(unsafe_code)]

use super::*;

/// Data that the caller writes into the points persists over the next update.
#[test]
fn impulses_of_manifold_points_are_kept() {
    let pack = open();
    let shapes = all_shapes(&pack);
    // A cuboid on a half-space, and a compound on it.
    for b in [&shapes[5], &shapes[3]] {
        let manifold = manifold();
        let mut pose = IDENTITY;
        // SAFETY: the pointers are valid, and the points live until the next update.
        unsafe {
            let mut shown = std::mem::zeroed::<types::ManifoldPoints>();
            let mut update = |pose: &types::Pose| {
                let code = hullmap_manifold_update(manifold.0, shapes[9].0, b.0, pose, null(), &raw mut shown);
                assert_eq!(code, Code::Ok);
                std::slice::from_raw_parts_mut(shown.points, shown.count)
            };
            let points = update(&pose);
            assert!(!points.is_empty());
            let address = points.as_ptr();
            for (i, point) in points.iter_mut().enumerate() {
                assert_eq!((point.impulse, point.user_data, point.age), ([0.0; 3], 0, 0));
                (point.impulse, point.user_data) = ([i as f64 + 1.0, 2.0, f64::NAN], 100 + i as u64);
                // Not the caller's: the library keeps its own.
                point.depth = f64::NAN;
            }
            let count = points.len();
            pose.translation.z -= 1e-4;
            let points = update(&pose);
            assert_eq!((points.len(), points.as_ptr()), (count, address));
            for (i, point) in points.iter().enumerate() {
                assert_eq!((point.impulse[0], point.user_data, point.age), (i as f64 + 1.0, 100 + i as u64, 1));
                assert!(point.depth.is_finite());
            }
            assert_eq!(hullmap_manifold_clear(manifold.0), Code::Ok);
            assert_eq!(update(&pose)[0].age, 0);
        }
    }
}
