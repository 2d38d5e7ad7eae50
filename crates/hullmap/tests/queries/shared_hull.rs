//! A hull that owns its share of the pack: it can be stored, sent to threads and outlive the pack's
//! own handle.

use std::sync::Arc;

use crate::any_shape::contact;
use hullmap::glam::{DQuat, DVec3, Vec3};
use hullmap::{Cache, Pack, Pose, Settings, Shape, SharedHull, SupportMap};
use hullmap_bake::IndexKind;
use shapes::families::Family;

fn pack() -> Arc<Pack> {
    Arc::new(hullmap_testkit::packs::pack("rock", &Family::Rock.points(300, 7), IndexKind::Tree))
}

/// Requirements of engines on a collider's shape.
fn assert_storable<T: Shape + Clone + Send + Sync + 'static>() {}

#[test]
fn shared_hulls_can_be_stored_and_sent() {
    assert_storable::<SharedHull>();
}

#[test]
fn a_shared_hull_keeps_its_pack_alive() {
    let pack = pack();
    let weak = Arc::downgrade(&pack);
    let hull = pack.shared_hull(0).unwrap();
    let copy = hull.clone();
    let expected = pack.hull(0).unwrap().support(Vec3::X);
    drop(pack);
    assert_eq!(hull.hull().support(Vec3::X), expected);
    drop(hull);
    // The clone alone still holds the pack.
    assert!(weak.upgrade().is_some());
    let found = std::thread::spawn(move || copy.hull().support(Vec3::X)).join().unwrap();
    assert_eq!(found, expected);
    assert!(weak.upgrade().is_none(), "the last shared hull releases the pack");
}

#[test]
fn shared_and_borrowed_hulls_answer_alike() {
    let pack = pack();
    let (shared, borrowed) = (pack.shared_hull(0).unwrap(), pack.hull(0).unwrap());
    for step in 0..50 {
        let way = DVec3::new(f64::from(step).sin(), f64::from(step).cos(), 0.3);
        let b_in_a = Pose::new(way * 1.2, DQuat::from_rotation_y(f64::from(step))).unwrap();
        let settings = Settings::default();
        assert_eq!(
            contact(&shared, &shared, b_in_a, &settings, &mut Cache::new()),
            contact(&borrowed, &borrowed, b_in_a, &settings, &mut Cache::new())
        );
        assert_eq!(shared.support_point(way), borrowed.support_point(way));
    }
}

#[test]
fn names_and_indices_that_do_not_exist_are_errors() {
    let pack = pack();
    assert!(pack.shared_hull(1).is_err());
    assert!(pack.shared_hull_named("rock").is_ok());
    assert!(pack.shared_hull_named("stone").is_err());
}
