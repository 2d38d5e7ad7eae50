//! Shapes that panic, and handles that are in use.
#![allow(unsafe_code)]

use hullmap::SupportPoint;

use super::*;

/// A shape with a bug.
struct Broken;

impl SupportMap for Broken {
    fn support_point(&self, _: DVec3) -> SupportPoint {
        panic!("broken shape")
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        0.0
    }
    fn outer_radius(&self) -> f64 {
        1.0
    }
}

impl hullmap::Shape for Broken {}

/// No panic passes the border, not from another thread of a batch either, and the handles of the
/// call can be used again.
#[test]
fn panics_become_errors() {
    let pack = open();
    let shapes = all_shapes(&pack);
    let broken = Shape(SharedGeometry::from_shape(Broken));
    let pose = IDENTITY;
    let (warm, manifold) = (cache(), manifold());
    let mut contact = types::Contact::default();
    // SAFETY: the pointers are valid.
    unsafe {
        let pose = &raw const pose;
        let found = hullmap_contact(shapes[0].0, &raw const broken, pose, null(), warm.0, &raw mut contact);
        assert_eq!(found, Code::Panic);
        assert!(message().contains("broken shape"), "{}", message());
        assert_eq!(contact, types::Contact::default());
        let mut shown = std::mem::zeroed::<types::ManifoldPoints>();
        let a = shapes[3].0;
        let found = hullmap_manifold_update(manifold.0, a, &raw const broken, pose, null(), &raw mut shown);
        assert_eq!(found, Code::Panic);
        let pairs = vec![ShapePair { a, b: &raw const broken, b_in_a: *pose }; 200];
        let mut contacts = vec![contact; 200];
        let out = contacts.as_mut_ptr();
        assert_eq!(hullmap_batch_contact(pairs.as_ptr(), 200, null(), null(), out), Code::Panic);
        let direction = DVec3::default();
        let mut support = types::SupportPoint::default();
        assert_eq!(hullmap_support(&raw const broken, &raw const direction, 1, &raw mut support), Code::Panic);

        let b = shapes[5].0;
        assert_eq!(hullmap_contact(shapes[0].0, b, pose, null(), warm.0, &raw mut contact), Code::Ok);
        assert_eq!(hullmap_manifold_update(manifold.0, a, b, pose, null(), &raw mut shown), Code::Ok);
    }
}

/// One cache in two calls, or twice in a batch.
#[test]
fn handles_in_use_are_busy() {
    let pack = open();
    let shapes = all_shapes(&pack);
    let (warm, manifold) = (cache(), manifold());
    let b_in_a = IDENTITY;
    let pairs = [ShapePair { a: shapes[0].0, b: shapes[1].0, b_in_a }; 2];
    let mut contacts = [types::Contact::default(); 2];
    // SAFETY: the pointers are valid.
    unsafe {
        let caches = [warm.0; 2];
        let out = contacts.as_mut_ptr();
        assert_eq!(hullmap_batch_contact(pairs.as_ptr(), 2, null(), caches.as_ptr(), out), Code::Busy);
        assert!(message().starts_with("caches[1] is in use"), "{}", message());
        let guard = (*warm.0).0.take("cache").unwrap();
        assert_eq!(hullmap_contact(pairs[0].a, pairs[0].b, &raw const b_in_a, null(), warm.0, out), Code::Busy);
        assert_eq!(hullmap_cache_clear(warm.0), Code::Busy);
        drop(guard);
        assert_eq!(hullmap_contact(pairs[0].a, pairs[0].b, &raw const b_in_a, null(), warm.0, out), Code::Ok);
        let manifolds = [manifold.0; 2];
        let mut shown = [std::mem::zeroed::<types::ManifoldPoints>(); 2];
        let found = hullmap_batch_manifolds(pairs.as_ptr(), 2, null(), manifolds.as_ptr(), shown.as_mut_ptr());
        assert_eq!(found, Code::Busy);
    }
}
