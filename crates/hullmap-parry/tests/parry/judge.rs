//! Checks of all queries of `HullDispatcher`.

use hullmap_parry::HullDispatcher;
use parry3d::math::Pose;
use parry3d::query::{ClosestPoints, QueryDispatcher, ShapeCastHit};
use parry3d::shape::Shape;

/// The time of a hit; infinite for a miss.
pub fn time(hit: Option<ShapeCastHit>) -> f32 {
    hit.map_or(f32::INFINITY, |hit| hit.time_of_impact)
}

/// Answers of a pair in both orders.
fn both<T>(
    ground: &dyn Shape,
    body: &dyn Shape,
    at: &Pose,
    ask: impl Fn(&Pose, &dyn Shape, &dyn Shape) -> T,
) -> [T; 2] {
    [ask(at, ground, body), ask(&at.inverse(), body, ground)]
}

/// Checks all queries of a body whose distance is `truth`: its distance up to `slight`, and its
/// points up to `aside`, which is more for curved bodies.
pub fn check(what: &str, ground: &dyn Shape, body: &dyn Shape, at: &Pose, truth: f64, [slight, aside]: [f64; 2]) {
    for dist in both(ground, body, at, |at, a, b| HullDispatcher.distance(at, a, b).unwrap().distance) {
        assert!((f64::from(dist) - truth.max(0.0)).abs() < slight, "{what}: {dist} {truth}");
    }
    for meets in both(ground, body, at, |at, a, b| HullDispatcher.intersection_test(at, a, b).unwrap().intersecting) {
        assert!(meets == (truth < 0.0) || truth.abs() < slight, "{what}: {meets} {truth}");
    }
    let contact = |at: &Pose, a: &dyn Shape, b: &dyn Shape| HullDispatcher.contact(at, a, b, 100.0).unwrap().unwrap();
    for (contact, pose) in both(ground, body, at, contact).into_iter().zip([*at, at.inverse()]) {
        assert!((f64::from(contact.dist) - truth).abs() < slight, "{what}: {} {truth}", contact.dist);
        let between = pose * contact.point2 - contact.point1;
        let off = (between - contact.normal1 * contact.dist).length();
        assert!(f64::from(off) < aside, "{what}: {off} of {}", contact.dist);
        assert!((pose.rotation * contact.normal2 + contact.normal1).length() < 1e-4, "{what}");
    }
    assert!(truth < 0.5 || HullDispatcher.contact(at, ground, body, 0.4).unwrap().is_none(), "{what}");
    let points = |at: &Pose, a: &dyn Shape, b: &dyn Shape| HullDispatcher.closest_points(at, a, b, 0.5).unwrap();
    for (points, pose) in both(ground, body, at, points).into_iter().zip([*at, at.inverse()]) {
        match points {
            ClosestPoints::Intersecting => assert!(truth < slight, "{what}"),
            ClosestPoints::WithinMargin(p1, p2) => {
                assert!((f64::from((pose * p2 - p1).length()) - truth).abs() < slight, "{what}");
            }
            ClosestPoints::Disjoint => assert!(truth > 0.5 - slight, "{what}"),
        }
    }
}
