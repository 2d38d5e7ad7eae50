//! Support queries on baked packs against brute force in f64, over all families and indices.

use hullmap_bake::IndexKind;
use hullmap_testkit::packs::{ALL_INDICES, pack};
use hullmap_tests::{directions, regret::Truth};
use shapes::families::Family;

/// Regret up to which a support query counts as exact.
const EXACT: f64 = 2e-7;

/// Bakes points and checks many directions; returns the worst regret.
fn check(name: &str, positions: &[[f32; 3]], index: IndexKind, count: usize) -> f64 {
    let pack = pack(name, positions, index);
    let hull = pack.hull(0).unwrap();
    let truth = Truth::new(positions);
    let mut worst: f64 = 0.0;
    let mut hint = 0;
    for dir in directions::all(&hull, count, 0x5eed) {
        let got = hull.support(dir);
        assert_eq!(hull.vertex(got.index), Some(got.point), "{name}: the point and the index differ");
        for hint in [hint, got.index, u32::MAX] {
            assert_eq!(hull.support_from(dir, hint), got, "{name}: {dir} from {hint}");
        }
        hint = got.index;
        let cost = hull.support_cost(dir);
        let max = hull.worst_cost();
        assert!(cost.nodes <= max.nodes && cost.dots <= max.dots, "{name}: {cost:?} exceeds the stated {max:?}");
        let regret = truth.regret(dir, got.point);
        assert!(regret <= EXACT, "{name}: regret {regret:e} in direction {dir}, seed 0x5eed");
        worst = worst.max(regret);
    }
    for dir in directions::invalid() {
        let got = hull.support(dir);
        assert_eq!(hull.vertex(got.index), Some(got.point), "{name}: {dir}");
        assert_eq!(hull.support_from(dir, hint), got, "{name}: {dir}");
    }
    worst
}

#[test]
fn exact_on_every_family_with_every_index() {
    for family in Family::ALL {
        for n in [8, 9, 40, 1000] {
            let points = family.points(n, 11);
            for index in ALL_INDICES {
                let worst = check(family.name(), &points, index, 4_000);
                println!("{:20} {n:5} {index:?}: worst regret {worst:.1e}", family.name());
            }
        }
    }
}

#[test]
fn exact_on_large_families() {
    for family in Family::ALL {
        let points = family.points(20_000, 3);
        let worst = check(family.name(), &points, IndexKind::Tree, 1_000);
        println!("{:20} worst regret {worst:.1e}", family.name());
    }
}

#[test]
fn exact_at_any_scale_and_far_from_the_origin() {
    for family in [Family::Rock, Family::Lens, Family::RotatedPrism, Family::FlatSheet, Family::Needle] {
        for (scale, offset) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1000.0), (1e-3, 1.0), (1e-30, 0.0), (1e30, 0.0)] {
            let moved: Vec<[f32; 3]> = family.points(500, 5).iter().map(|p| p.map(|c| c * scale + offset)).collect();
            check(family.name(), &moved, IndexKind::Tree, 2_000);
        }
    }
}

/// Degenerate points that no family contains: ties, duplicates, every rank, nearly flat, nearly
/// straight, and caps that are tilted by a few units in the last place.
/// docs/contributors/intervals.md (section 9), docs/contributors/FORMAT.md and docs/limits.md state
/// the worst regrets.
#[test]
fn exact_on_degenerate_points() {
    let nearly_flat = |thickness: f32| -> Vec<[f32; 3]> {
        Family::Ball.points(300, 2).iter().map(|p| [p[0], p[1], p[2] * thickness]).collect()
    };
    let nearly_straight = |width: f32| -> Vec<[f32; 3]> {
        Family::Ball.points(300, 4).iter().map(|p| [p[0] * width, p[1], p[2] * width]).collect()
    };
    let mut cases: Vec<(String, Vec<[f32; 3]>)> = vec![
        ("point".into(), vec![[1.0, -2.0, 3.0]; 4]),
        ("segment".into(), vec![[0.0; 3], [1.0, 2.0, 3.0], [0.5, 1.0, 1.5], [0.0; 3]]),
        ("triangle".into(), vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        ("signed_zeros".into(), vec![[0.0, -0.0, 0.0], [-0.0, 0.0, -0.0], [1.0, -0.0, 0.0], [0.0, 1.0, 0.0]]),
        ("two_far_points".into(), vec![[f32::MAX / 4.0; 3], [-f32::MAX / 4.0; 3]]),
        ("tiny".into(), Family::Rock.points(64, 1).iter().map(|p| p.map(|c| c * 1e-42)).collect()),
    ];
    for exponent in 1..12 {
        let t = 10_f32.powi(-exponent);
        cases.push((format!("flat 1e-{exponent}"), nearly_flat(t)));
        cases.push((format!("straight 1e-{exponent}"), nearly_straight(t)));
    }
    for (corners, tilt) in [12, 40, 300].into_iter().flat_map(|n| [0.6e-7, 1e-7, 2e-7, 1e-6].map(|tilt| (n, tilt))) {
        let tilted = |[x, y, z]: [f32; 3]| [x, y, z + tilt * (x + 0.3 * y)];
        let points = Family::Prism.points(corners, 0).into_iter().map(tilted).collect();
        cases.push((format!("prism of {corners}, tilted by {tilt:e}"), points));
    }
    for (name, points) in cases {
        let worst = ALL_INDICES.map(|index| check(&name, &points, index, 1_000)).into_iter().fold(0.0, f64::max);
        println!("{name}: worst regret {worst:.1e}");
        // Points near a plane or a line are baked as a polygon or a segment.
        let most = if name.starts_with("flat") || name.starts_with("straight") { 5e-8 } else { 1e-12 };
        assert!(worst <= most, "{name}: regret {worst:e}");
    }
}
