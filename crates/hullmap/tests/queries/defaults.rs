//! Answers that no query has filled claim nothing.

use hullmap::{Contact, Distance, Intersection, Status};

#[test]
fn default_answers_claim_nothing() {
    let contact = Contact::default();
    assert!(contact.hit, "only a separating plane makes a miss");
    assert_eq!((contact.depth_lower, contact.depth_upper), (0.0, f64::INFINITY));
    assert!(!matches!(contact.status, Status::Exact | Status::Within | Status::Separated));
    let distance = Distance::default();
    assert_eq!((distance.lower, distance.upper), (0.0, f64::INFINITY));
    assert!(Intersection::default().is_hit());
}
