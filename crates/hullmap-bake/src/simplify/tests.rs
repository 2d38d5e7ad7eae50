//! Tests simplified hulls by independent means: support values, and nearest points.

use shapes::{families::Family, rng::SplitMix64};

use super::*;
use crate::test_meshes::hull_of;
use hullmap_format::archive::NO_SOURCE_VERTEX;

fn reach(hull: &Hull, direction: DVec3) -> f64 {
    hull.positions().iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}

/// Checks that the simplified hull contains `hull`, within the reported error.
fn assert_promise(name: &str, hull: &Hull, simplified: &Simplified, seed: u64) {
    let mut rng = SplitMix64::new(seed);
    let rounding = 1e-13 * hull.diameter + 1e-15 * hull.positions().iter().fold(0.0, |s: f64, p| s.max(p.length()));
    let slack = simplified.hull.containment_error * simplified.hull.diameter + rounding;
    let mut max_outside = 0.0_f64;
    let nearest = Nearest::new(hull);
    let middle = hull.positions().iter().sum::<DVec3>() / hull.vertices.len() as f64;
    for round in 0..2_000 {
        let random = DVec3::from_array(rng.direction());
        // Every second direction points from the hull to a vertex of the simplified hull.
        let vertices = simplified.hull.positions();
        let direction = if round % 2 == 0 {
            random
        } else {
            let p = vertices[round / 2 % vertices.len()];
            let from = if hull.rank == 3 { nearest.certain(p).point } else { middle };
            (p - from).normalize_or_zero()
        };
        let outside = reach(&simplified.hull, direction) - reach(hull, direction);
        assert!(outside >= -slack, "{name}: {outside:e} in direction {direction}, seed {seed}");
        assert!(outside <= simplified.outer_error + rounding, "{name}: {outside} beyond {}", simplified.outer_error);
        max_outside = max_outside.max(outside);
    }
    assert!(
        max_outside >= 0.5 * simplified.outer_error,
        "{name}: outer error {}, but only {max_outside} was found",
        simplified.outer_error
    );
}

#[test]
fn contains_the_hull_within_the_reported_error() {
    for family in Family::ALL {
        for far in [0.0_f32, 50.0] {
            let positions: Vec<[f32; 3]> = family.points(250, 1).iter().map(|p| [p[0] + far, p[1], p[2]]).collect();
            let hull = hull_of(positions);
            let mut before = f64::INFINITY;
            for max_vertices in [4, 12, 40, 128] {
                let Some(found) = simplify(&hull, Limit::Vertices(max_vertices)).unwrap() else {
                    assert!(hull.vertices.len() <= max_vertices || hull.rank < 2, "{family:?} {max_vertices}");
                    continue;
                };
                assert!(found.hull.vertices.len() <= max_vertices, "{family:?} {max_vertices}");
                assert!(found.hull.containment_error == 0.0 || hull.rank == 2, "{family:?} {max_vertices}");
                assert!(found.hull.source_vertices.iter().all(|v| *v == NO_SOURCE_VERTEX));
                assert_promise(family.name(), &hull, &found, max_vertices as u64);
                assert!(
                    found.outer_error <= before * 1.05,
                    "{family:?} {max_vertices}: {} {before}",
                    found.outer_error
                );
                before = found.outer_error;
            }
        }
    }
}

#[test]
fn distance_limits_are_kept_with_few_vertices() {
    for family in Family::ALL {
        let hull = hull_of(family.points(300, 2));
        let mut before = hull.vertices.len();
        for share in [1e-4, 1e-3, 1e-2, 1e-1] {
            let distance = share * hull.diameter;
            let Some(found) = simplify(&hull, Limit::Distance(distance)).unwrap() else { continue };
            assert!(found.outer_error <= distance, "{family:?} {share}");
            assert!(
                found.hull.vertices.len() < hull.vertices.len() && found.hull.vertices.len() <= before + 2,
                "{family:?}"
            );
            before = found.hull.vertices.len();
            assert_promise(family.name(), &hull, &found, 9);
        }
        assert!(before <= hull.vertices.len().min(40), "{family:?}: {before}");
    }
}

#[test]
fn invalid_limits_are_rejected_and_satisfied_limits_change_nothing() {
    let hull = hull_of(Family::Rock.points(300, 1));
    assert!(matches!(simplify(&hull, Limit::Vertices(3)), Err(BakeError::TooFewVertices { requested: 3 })));
    assert!(simplify(&hull, Limit::Distance(-1.0)).is_err() && simplify(&hull, Limit::Distance(f64::NAN)).is_err());
    assert!(simplify(&hull, Limit::Distance(0.0)).unwrap().is_none());
    assert!(simplify(&hull, Limit::Vertices(hull.vertices.len())).unwrap().is_none());
    assert!(simplify(&hull_of(vec![[0.0; 3], [1.0, 2.0, 3.0]]), Limit::Vertices(4)).unwrap().is_none());
}

/// A sphere has a known optimum: the best known polytopes with n vertices around a ball exceed it
/// by about 2.42 / n of its radius.
#[test]
fn a_ball_is_left_by_less_than_twice_the_best_known() {
    let hull = hull_of(Family::Sphere.points(5_000, 1));
    for max_vertices in [16, 64, 256] {
        let found = simplify(&hull, Limit::Vertices(max_vertices)).unwrap().unwrap();
        let error = found.outer_error / (0.5 * hull.diameter);
        println!(
            "{max_vertices} vertices: {error:.5} of the radius, {:.2} times the best known",
            error * max_vertices as f64 / 2.42
        );
        assert!(error * max_vertices as f64 <= 2.0 * 2.42, "{max_vertices}: {error}");
    }
}
