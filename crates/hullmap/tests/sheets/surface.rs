//! Meshes that are not watertight have no inside. `hullmap_tests::sheets` judges signed distances
//! of those that are.

use glam::DVec3;
use hullmap::compound::{SurfaceError, surface_distance};
use hullmap::{Cache, EdgeClass, Settings};

use crate::meshes::{grid, mesh};

#[test]
fn open_meshes_have_no_inside() {
    let sheet = grid(3, |_, _| 0.0);
    let (settings, mut cache) = (Settings::default(), Cache::new());
    let error = surface_distance(&sheet, DVec3::ONE, &settings, &mut cache).unwrap_err();
    assert!(matches!(error, SurfaceError::Open(open) if open.edge == EdgeClass::Border), "{error}");
    let positions = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| DVec3::from_array([i & 1, i >> 1 & 1, i >> 2].map(f64::from)));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut corners: Vec<[u32; 3]> = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    assert!(mesh(&positions, &corners).check_closed().is_ok());
    // One triangle is the wrong way round.
    corners[5].swap(0, 1);
    let error = mesh(&positions, &corners).check_closed().unwrap_err();
    assert_eq!(error.edge, EdgeClass::Reversed);
    let error = surface_distance(&sheet, DVec3::NAN, &settings, &mut cache).unwrap_err();
    assert!(error.to_string().contains("not watertight"));
}
