//! Reads bytes as point sets, bakes and opens them, and checks answers against the points.

use glam::Vec3;
use hullmap::Pack;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{self, point_set};

use super::bytes::Bytes;
use crate::{directions, regret::Truth};

/// Maximum number of hulls of a pack, and of points of each hull.
const MAX_HULLS: usize = 3;
const MAX_POINTS: usize = 96;

/// Directions of each hull's own faces and edges, and directions read from the bytes.
const OWN_DIRECTIONS: usize = 64;
const READ_DIRECTIONS: usize = 16;

/// Maximum regret that counts as exact.
const EXACT: f64 = 2e-7;

/// Bakes, writes, opens and queries a pack: every support point of a hull must equal the support
/// point of its source points. Panics if points cannot be baked, a pack does not open or
/// contradicts itself, or an answer is not exact.
pub fn build_open_verify(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let index = index(&mut bytes);
    let sets: Vec<_> = (0..1 + bytes.below(MAX_HULLS))
        .map(|hull| point_set(["a", "bé", ""][hull], &bytes.points(MAX_POINTS, true)))
        .collect();
    let file = match packs::bytes(&sets, index, &SourceRecord::default()) {
        Ok(file) => file,
        Err(error) => panic!("{error}: {index:?} {sets:?}"),
    };
    let again = packs::bytes(&sets, index, &SourceRecord::default());
    assert_eq!(again.as_ref(), Ok(&file), "the same points make the same bytes");
    let pack = Pack::from_bytes(&file).unwrap_or_else(|error| panic!("{error}: {index:?} {sets:?}"));
    assert_eq!(pack.check_repeats(), Ok(()), "{index:?} {sets:?}");
    assert_eq!(pack.hull_count(), sets.len());
    let read: Vec<Vec3> =
        (0..READ_DIRECTIONS).map(|_| Vec3::new(bytes.float(), bytes.float(), bytes.float())).collect();
    for (hull, set) in pack.hulls().zip(&sets) {
        let truth = Truth::new(&set.positions);
        let own = directions::all(&hull, OWN_DIRECTIONS, data.len() as u64);
        for &dir in own.iter().chain(&read) {
            let got = hull.support(dir);
            assert_eq!(hull.vertex(got.index), Some(got.point), "{dir}");
            assert_eq!(hull.support_from(dir, got.index), got, "{dir}");
            if dir.is_finite() && dir != Vec3::ZERO {
                let regret = truth.regret(dir, got.point);
                assert!(regret <= EXACT, "{index:?}: regret {regret:e} in direction {dir:?} of {set:?}");
            }
            let (cost, max) = (hull.support_cost(dir), hull.worst_cost());
            assert!(cost.nodes <= max.nodes && cost.dots <= max.dots, "{cost:?} exceeds {max:?}");
        }
        let mut points = set.positions.iter().map(|p| Vec3::from_array(*p));
        assert!(hull.vertices().all(|v| points.any(|p| p == v)), "vertices are source points, in their order: {set:?}");
    }
}

fn index(bytes: &mut Bytes) -> IndexKind {
    match bytes.below(8) {
        1 => IndexKind::Medium,
        2 => IndexKind::Compact,
        3 => IndexKind::Binary,
        4 => IndexKind::None,
        5 => IndexKind::CubeMap { resolution: 1 + bytes.below(9) as u32 },
        _ => IndexKind::Tree,
    }
}
