//! A hull that owns its share of the pack: it can be stored, sent to threads and outlive the pack's
//! own handle. `pairings` compares its answers with the borrowed hull's.

use std::sync::Arc;

use hullmap::Pack;
use hullmap::glam::Vec3;
use hullmap_bake::IndexKind;
use shapes::families::Family;

fn pack() -> Arc<Pack> {
    Arc::new(hullmap_testkit::packs::pack("rock", &Family::Rock.points(300, 7), IndexKind::Tree))
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
fn names_and_indices_that_do_not_exist_are_errors() {
    let pack = pack();
    assert!(pack.shared_hull(1).is_err());
    assert!(pack.shared_hull_named("rock").is_ok());
    assert!(pack.shared_hull_named("stone").is_err());
}
