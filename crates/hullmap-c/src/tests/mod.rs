//! The exported functions from Rust: the same bits as `hullmap`, panics that do not pass, and calls
//! that break the rules. `tests/c` has the same from C.
#![allow(unsafe_code)]

mod any;
mod batches;
mod facts;
mod lifetimes;
mod manifolds;
mod meshes;
mod misuse;
mod motions;
mod pairs;
mod single;

use std::ffi::CStr;
use std::ptr::{null, null_mut};
use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap::{SharedGeometry, SupportMap};
use hullmap_random::SplitMix64;
use hullmap_testkit::packs;

use crate::exports::batch::{
    ShapePair, hullmap_batch_contact, hullmap_batch_distance, hullmap_batch_intersects, hullmap_batch_manifolds,
};
use crate::exports::{cache::*, manifold::*, pack::*, pose::*, query::*, shape::*, version::*};
use crate::handles::{Cache, Manifold, Pack, Shape};
use crate::types::{self, Result as Code};

const IDENTITY: types::Pose = types::Pose { translation: DVec3::ZERO, rotation: DQuat::IDENTITY };

/// Two rocks: a pack as a file's bytes.
fn file() -> Vec<u8> {
    let moved = |seed: u64, by: f32| -> Vec<[f32; 3]> {
        shapes::families::rock(60, seed).into_iter().map(|[x, y, z]| [x + by, y, z]).collect()
    };
    let sets = [packs::point_set("left", &moved(1, -0.6)), packs::point_set("right", &moved(2, 0.6))];
    packs::bytes(&sets, hullmap_bake::IndexKind::Tree, &hullmap_bake::SourceRecord::default()).unwrap()
}

/// A handle that is freed at the end.
struct Owned<T>(*mut T, unsafe extern "C" fn(*mut T));

impl<T> Owned<T> {
    fn new(free: unsafe extern "C" fn(*mut T), make: impl FnOnce(*mut *mut T) -> Code) -> Self {
        let mut handle = null_mut();
        assert_eq!(make(&raw mut handle), Code::Ok, "{}", message());
        assert!(!handle.is_null());
        Self(handle, free)
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        // SAFETY: the handle is from the library, and is freed once.
        unsafe { (self.1)(self.0) }
    }
}

fn message() -> String {
    // SAFETY: the message ends with NUL, and lives until the next failure of this thread.
    unsafe { CStr::from_ptr(hullmap_last_error()) }.to_str().unwrap().to_owned()
}

fn open() -> Owned<Pack> {
    let file = file();
    // SAFETY: the pointers are valid.
    Owned::new(hullmap_pack_free, |out| unsafe { hullmap_pack_from_memory(file.as_ptr(), file.len(), 0, out) })
}

fn cache() -> Owned<Cache> {
    // SAFETY: the pointer is valid.
    Owned::new(hullmap_cache_free, |out| unsafe { hullmap_cache_new(out) })
}

fn manifold() -> Owned<Manifold> {
    // SAFETY: the pointer is valid.
    Owned::new(hullmap_manifold_free, |out| unsafe { hullmap_manifold_new(8, out) })
}

/// Every kind of shape, by the exported functions. The half-space is last.
fn all_shapes(pack: &Owned<Pack>) -> Vec<Owned<Shape>> {
    let make = |body: &dyn Fn(*mut *mut Shape) -> Code| Owned::new(hullmap_shape_free, body);
    let v = DVec3::new;
    // SAFETY: the pointers are valid.
    unsafe {
        vec![
            make(&|out| hullmap_shape_hull(pack.0, 0, out)),
            make(&|out| hullmap_shape_hull(pack.0, 1, out)),
            make(&|out| hullmap_shape_scaled_hull(pack.0, 1, v(1.0, -0.5, 2.0), out)),
            make(&|out| hullmap_shape_compound(pack.0, out)),
            make(&|out| hullmap_shape_sphere(0.75, out)),
            make(&|out| hullmap_shape_cuboid(v(0.5, 0.75, 1.0), out)),
            make(&|out| hullmap_shape_capsule(0.5, 0.25, out)),
            make(&|out| hullmap_shape_cylinder(0.5, 0.75, out)),
            make(&|out| hullmap_shape_cone(1.0, 0.5, out)),
            make(&|out| hullmap_shape_segment(v(-0.5, 0.25, 0.0), v(0.5, -0.25, 1.0), out)),
            make(&|out| hullmap_shape_triangle(v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.25), v(-0.5, -0.5, 0.0), out)),
            make(&|out| hullmap_shape_half_space(v(0.25, 0.5, 1.0), -0.25, out)),
        ]
    }
}

/// The same shapes, by the crate for Rust.
fn all_twins(pack: &Arc<hullmap::Pack>) -> Vec<SharedGeometry> {
    use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Scaled, Segment, Sphere, Triangle};
    let [left, right] = [0, 1].map(|index| pack.shared_hull(index).unwrap());
    let corners = [DVec3::X, DVec3::new(0.0, 1.0, 0.25), DVec3::new(-0.5, -0.5, 0.0)];
    vec![
        left.into(),
        right.clone().into(),
        SharedGeometry::from_shape(Scaled::new(right, DVec3::new(1.0, -0.5, 2.0)).unwrap()),
        pack.clone().into(),
        SharedGeometry::from_shape(Sphere::new(0.75).unwrap()),
        SharedGeometry::from_shape(Cuboid::new(DVec3::new(0.5, 0.75, 1.0)).unwrap()),
        SharedGeometry::from_shape(Capsule::new(0.5, 0.25).unwrap()),
        SharedGeometry::from_shape(Cylinder::new(0.5, 0.75).unwrap()),
        SharedGeometry::from_shape(Cone::new(1.0, 0.5).unwrap()),
        SharedGeometry::from_shape(Segment::new(DVec3::new(-0.5, 0.25, 0.0), DVec3::new(0.5, -0.25, 1.0)).unwrap()),
        SharedGeometry::from_shape(Triangle::new(corners).unwrap()),
        HalfSpace::new(DVec3::new(0.25, 0.5, 1.0), -0.25).unwrap().into(),
    ]
}

fn twin_pack(file: &[u8]) -> Arc<hullmap::Pack> {
    Arc::new(hullmap::Pack::from_bytes(file).unwrap())
}

/// Asserts that answers have the same bits: text distinguishes all numbers, and NaN equals NaN.
fn same<T: std::fmt::Debug>(found: &T, expected: &T) {
    assert_eq!(format!("{found:?}"), format!("{expected:?}"));
}

/// A pose, and the same pose for C: not normalised, to show that both sides do the same with it.
fn random_pose(rng: &mut SplitMix64, reach: f64) -> (hullmap::Pose, types::Pose) {
    let mut next = |size: f64| rng.between(-size, size);
    let translation = DVec3::new(next(reach), next(reach), next(reach));
    let rotation = DQuat::from_xyzw(next(3.0), next(3.0), next(3.0), next(3.0));
    (hullmap::Pose::new(translation, rotation).unwrap(), types::Pose { translation, rotation })
}

fn same_points(found: &types::ManifoldPoints, expected: &[([usize; 2], &hullmap::Manifold)]) -> usize {
    // SAFETY: the manifold was updated last by this thread, and is not freed.
    let found = unsafe { std::slice::from_raw_parts(found.points, found.count) };
    let expected: Vec<_> =
        expected.iter().flat_map(|(hulls, m)| m.points().iter().map(move |p| (hulls, m, p))).collect();
    assert_eq!(found.len(), expected.len());
    for (found, (hulls, manifold, point)) in found.iter().zip(&expected) {
        assert_eq!(found.parts.map(|part| part as usize), **hulls);
        same(
            &(found.normal, found.point_a, found.point_b, found.local_b, found.depth),
            &(manifold.normal(), point.point_a, point.point_b, point.local_b, point.depth),
        );
        assert_eq!((found.impulse, found.user_data, found.age), (point.impulse, point.user_data, point.age));
        assert_eq!((found.feature_a, found.status), (point.id.on_a().into(), manifold.status()));
    }
    found.len()
}
