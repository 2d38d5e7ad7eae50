//! The exported functions from Rust: the same bits as `hullmap`, panics that do not pass, and calls
//! that break the rules. `tests/c` has the same from C.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};
use std::sync::Arc;

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Compound, SupportMap, SupportPoint, compound};
use hullmap_random::SplitMix64;
use hullmap_testkit::packs;

use crate::exports::batch::{
    Pair, hullmap_batch_contact, hullmap_batch_distance, hullmap_batch_intersects, hullmap_batch_manifolds,
};
use crate::exports::{cache::*, manifold::*, pack::*, pose::*, query::*, shape::*, version::*};
use crate::handles::{Cache, Kind, Manifold, Pack, Shape};
use crate::types::{self, Result as Code};

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
    let v = |x, y, z| types::Vec3 { x, y, z };
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
            make(&|out| hullmap_shape_half_space(v(0.25, 0.5, 1.0), -0.25, out)),
        ]
    }
}

/// The same shapes, by the crate for Rust.
enum Twin<'p> {
    Convex(Box<dyn hullmap::Shape + 'p>),
    Compound(Box<Compound<'p>>),
    HalfSpace(hullmap::shapes::HalfSpace),
}

fn all_twins(pack: &hullmap::Pack) -> Vec<Twin<'_>> {
    use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Scaled, Sphere};
    let (left, right) = (pack.hull(0).unwrap(), pack.hull(1).unwrap());
    vec![
        Twin::Convex(Box::new(left)),
        Twin::Convex(Box::new(right)),
        Twin::Convex(Box::new(Scaled::new(right, DVec3::new(1.0, -0.5, 2.0)).unwrap())),
        Twin::Compound(Box::new(Compound::new(pack))),
        Twin::Convex(Box::new(Sphere::new(0.75).unwrap())),
        Twin::Convex(Box::new(Cuboid::new(DVec3::new(0.5, 0.75, 1.0)).unwrap())),
        Twin::Convex(Box::new(Capsule::new(0.5, 0.25).unwrap())),
        Twin::Convex(Box::new(Cylinder::new(0.5, 0.75).unwrap())),
        Twin::Convex(Box::new(Cone::new(1.0, 0.5).unwrap())),
        Twin::HalfSpace(HalfSpace::new(DVec3::new(0.25, 0.5, 1.0), -0.25).unwrap()),
    ]
}

/// Asserts that fields have the same bits.
macro_rules! same {
    ($found:expr, $expected:expr; $($number:ident)*; $($vector:ident)*; $($count:ident)*) => {
        $(assert_eq!($found.$number.to_bits(), $expected.$number.to_bits(), stringify!($number));)*
        $(assert_eq!(bits($found.$vector), $expected.$vector.to_array().map(f64::to_bits), stringify!($vector));)*
        $(assert_eq!($found.$count, $expected.$count, stringify!($count));)*
        assert_eq!(format!("{:?}", $found.status), format!("{:?}", $expected.status));
    };
}

fn bits(v: types::Vec3) -> [u64; 3] {
    [v.x, v.y, v.z].map(f64::to_bits)
}

fn vector(v: DVec3) -> types::Vec3 {
    types::Vec3 { x: v.x, y: v.y, z: v.z }
}

/// A pose, and the same pose for C: not normalised, to show that both sides do the same with it.
fn random_pose(rng: &mut SplitMix64, reach: f64) -> (hullmap::Pose, types::Pose) {
    let mut next = |size: f64| rng.between(-size, size);
    let translation = DVec3::new(next(reach), next(reach), next(reach));
    let rotation = DQuat::from_xyzw(next(3.0), next(3.0), next(3.0), next(3.0));
    let [x, y, z, w] = rotation.to_array();
    let pose = hullmap::Pose::new(translation, rotation).unwrap();
    (pose, types::Pose { translation: vector(translation), rotation: types::Quat { x, y, z, w } })
}

fn same_contact(found: &types::Contact, expected: &hullmap::Contact) {
    same!(found, expected; depth depth_lower depth_upper; normal point_a point_b; hit iterations support_calls);
}

fn same_distance(found: &types::Distance, expected: &hullmap::Distance) {
    same!(found, expected; distance lower upper; normal point_a point_b; iterations support_calls);
}

fn same_points(found: &types::ManifoldPoints, expected: &[([usize; 2], &hullmap::Manifold)]) -> usize {
    // SAFETY: the manifold was updated last by this thread, and is not freed.
    let found = unsafe { std::slice::from_raw_parts(found.points, found.count) };
    let expected: Vec<_> =
        expected.iter().flat_map(|(hulls, m)| m.points().iter().map(move |p| (hulls, m, p))).collect();
    assert_eq!(found.len(), expected.len());
    for (found, (hulls, manifold, point)) in found.iter().zip(&expected) {
        assert_eq!([found.hull_a, found.hull_b].map(|hull| hull as usize), **hulls);
        assert_eq!(bits(found.normal), manifold.normal().to_array().map(f64::to_bits));
        assert_eq!(bits(found.point_a), point.point_a.to_array().map(f64::to_bits));
        assert_eq!(bits(found.point_b), point.point_b.to_array().map(f64::to_bits));
        assert_eq!(bits(found.local_b), point.local_b.to_array().map(f64::to_bits));
        assert_eq!(found.depth.to_bits(), point.depth.to_bits());
        assert_eq!((found.impulse, found.user_data, found.age), (point.impulse, point.user_data, point.age));
        assert_eq!(found.feature_a, point.id.on_a().into());
    }
    found.len()
}

/// Every pair of kinds along random walks, with and without caches.
#[test]
fn answers_have_the_bits_of_the_crate_for_rust() {
    let (pack, file) = (open(), file());
    let twin_pack = hullmap::Pack::from_bytes(&file).unwrap();
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (settings, mut rng) = (hullmap::Settings::default(), SplitMix64::new(1));
    let (mut hits, mut total, mut points) = (0, 0, 0);
    for (a, twin_a) in shapes.iter().zip(&twins) {
        for (b, twin_b) in shapes.iter().zip(&twins) {
            let (warm, manifold) = (cache(), manifold());
            let mut twin_caches = [hullmap::Cache::new(), hullmap::Cache::new()];
            let mut twin_compound = hullmap::CompoundCache::default();
            let (mut twin_manifold, mut twin_manifolds) =
                (hullmap::Manifold::new(), hullmap::CompoundManifolds::new(8));
            let mut twin_pose;
            let (_, mut pose) = random_pose(&mut rng, 1.4);
            for step in 0..12 {
                if step % 4 == 0 {
                    (twin_pose, pose) = random_pose(&mut rng, 1.4);
                } else {
                    pose.translation.x += 0.01;
                    let by = DVec3::new(pose.translation.x, pose.translation.y, pose.translation.z);
                    let types::Quat { x, y, z, w } = pose.rotation;
                    twin_pose = hullmap::Pose::new(by, DQuat::from_xyzw(x, y, z, w)).unwrap();
                }
                let mut hit = types::Intersection::new(hullmap::Intersection::default(), [9, 9]);
                let mut contact = types::Contact::separated();
                let mut gap = types::Distance::new(hullmap::Distance::default(), [9, 9]);
                let mut shown = types::ManifoldPoints {
                    points: null_mut(),
                    count: 9,
                    touching: 9,
                    dropped: 9,
                    pairs: 9,
                    iterations: 9,
                    support_calls: 9,
                };
                // SAFETY: the pointers are valid.
                let codes = unsafe {
                    [
                        hullmap_intersects(a.0, b.0, &raw const pose, warm.0, &raw mut hit),
                        hullmap_distance(a.0, b.0, &raw const pose, null(), warm.0, &raw mut gap),
                        hullmap_contact(a.0, b.0, &raw const pose, null(), warm.0, &raw mut contact),
                        hullmap_manifold_update(manifold.0, a.0, b.0, &raw const pose, null(), &raw mut shown),
                    ]
                };
                let expected = if let Twin::HalfSpace(_) = twin_b { Code::Unsupported } else { Code::Ok };
                assert_eq!(codes, [expected; 4], "{}", message());
                if expected != Code::Ok {
                    continue;
                }
                let [twin_cache, manifold_cache] = &mut twin_caches;
                let manifold_settings = hullmap::ManifoldSettings::default();
                macro_rules! check_compound {
                    ($a:expr, $b:expr) => {{
                        let (a, b) = ($a, $b);
                        let found = compound::intersects(a, b, twin_pose, &mut twin_compound);
                        same!(hit, found.answer; ; ; iterations support_calls);
                        assert_eq!([hit.hull_a as usize, hit.hull_b as usize], found.hulls);
                        let found = compound::distance(a, b, twin_pose, &settings, &mut twin_compound);
                        same_distance(&gap, &found.answer);
                        assert_eq!([gap.hull_a as usize, gap.hull_b as usize], found.hulls);
                        match compound::contact(a, b, twin_pose, &settings, &mut twin_compound) {
                            Some(found) => {
                                same_contact(&contact, &found.answer);
                                assert_eq!([contact.hull_a as usize, contact.hull_b as usize], found.hulls);
                            }
                            None => assert!(!contact.hit && contact.status == types::Status::Separated),
                        }
                        let counts = twin_manifolds.update(a, b, twin_pose, &manifold_settings);
                        assert_eq!((shown.touching, shown.pairs), (counts.touching, counts.pairs));
                        points += same_points(&shown, &twin_manifolds.iter().collect::<Vec<_>>());
                    }};
                }
                // A single hull counts as a compound of one hull, which the solver knows as a hull.
                let as_compound = |index: usize| {
                    let own = shapes.get(index).filter(|_| index < 2);
                    own.map(|_| Compound::from(twin_pack.hull(index).unwrap()))
                };
                let at = |shape: *mut Shape| shapes.iter().position(|other| other.0 == shape).unwrap();
                match (twin_a, twin_b) {
                    (Twin::Convex(a), Twin::Convex(b)) => {
                        let found = hullmap::intersects(&**a, &**b, twin_pose, twin_cache);
                        same!(hit, found; ; ; iterations support_calls);
                        same_distance(&gap, &hullmap::distance(&**a, &**b, twin_pose, &settings, twin_cache));
                        same_contact(&contact, &hullmap::contact(&**a, &**b, twin_pose, &settings, twin_cache));
                        twin_manifold.update(&**a, &**b, twin_pose, &manifold_settings, manifold_cache);
                        points += same_points(&shown, &[([0, 0], &twin_manifold)]);
                    }
                    (Twin::Compound(a), Twin::Compound(b)) => check_compound!(&**a, &**b),
                    (Twin::Compound(a), Twin::Convex(convex)) => match as_compound(at(b.0)) {
                        Some(b) => check_compound!(&**a, &b),
                        None => check_compound!(&**a, &**convex),
                    },
                    (Twin::Convex(convex), Twin::Compound(b)) => match as_compound(at(a.0)) {
                        Some(a) => check_compound!(&a, &**b),
                        None => check_compound!(&**convex, &**b),
                    },
                    (Twin::HalfSpace(a), Twin::Convex(b)) => {
                        same!(hit, a.intersects(&**b, twin_pose); ; ; iterations support_calls);
                        same_distance(&gap, &a.distance(&**b, twin_pose));
                        same_contact(&contact, &a.contact(&**b, twin_pose));
                        twin_manifold.update_half_space(a, &**b, twin_pose, &manifold_settings);
                        points += same_points(&shown, &[([0, 0], &twin_manifold)]);
                    }
                    (Twin::HalfSpace(a), Twin::Compound(b)) => {
                        let found = compound::half_space::intersects(a, &**b, twin_pose);
                        same!(hit, found.answer; ; ; iterations support_calls);
                        same_distance(&gap, &compound::half_space::distance(a, &**b, twin_pose).answer);
                        same_contact(&contact, &compound::half_space::contact(a, &**b, twin_pose).answer);
                        twin_manifolds.update_half_space(a, &**b, twin_pose, &manifold_settings);
                        points += same_points(&shown, &twin_manifolds.iter().collect::<Vec<_>>());
                    }
                    (_, Twin::HalfSpace(_)) => unreachable!("checked above"),
                }
                total += 1;
                hits += usize::from(hit.hit);
            }
        }
    }
    assert!(total == 10 * 9 * 12 && hits * 10 > total * 3 && hits * 10 < total * 9, "{hits} of {total}");
    assert!(points > 500, "{points}");
}

/// Queries of one shape, and casts.
#[test]
fn rays_casts_points_and_bounds_have_the_same_bits() {
    let (pack, file) = (open(), file());
    let twin_pack = hullmap::Pack::from_bytes(&file).unwrap();
    let (shapes, twins) = (all_shapes(&pack), all_twins(&twin_pack));
    let (mut rng, warm) = (SplitMix64::new(2), cache());
    let mut next = |size: f64| rng.between(-size, size);
    let (mut hits, mut total) = (0, 0);
    let other = &shapes[5];
    let twin_other = hullmap::shapes::Cuboid::new(DVec3::new(0.5, 0.75, 1.0)).unwrap();
    for (shape, twin) in shapes.iter().zip(&twins) {
        let mut twin_cache = hullmap::Cache::new();
        // SAFETY: the pointer is valid.
        assert_eq!(unsafe { hullmap_cache_clear(warm.0) }, Code::Ok);
        for _ in 0..20 {
            let (origin, target) =
                (DVec3::new(next(4.0), next(4.0), next(4.0)), DVec3::new(next(0.7), next(0.7), next(0.7)));
            let direction = target - origin;
            let by = [next(1.0), next(1.0), next(1.0), next(1.0)];
            let pose = types::Pose {
                translation: vector(origin),
                rotation: types::Quat { x: by[0], y: by[1], z: by[2], w: by[3] },
            };
            let twin_pose = hullmap::Pose::new(origin, DQuat::from_array(by)).unwrap();
            let along_x = hullmap::Ray::new(DVec3::ZERO, DVec3::X).unwrap();
            let any = hullmap::ray(&twin_other, &along_x, &hullmap::CastSettings::default());
            let mut hit = types::RayHit::new(any, 9);
            let mut impact = types::Impact::new(hullmap::Impact::default(), [9, 9]);
            let (mut bounds, mut support) = (types::Bounds::default(), [types::Support::default(); 2]);
            let mut point = hullmap::signed_distance(
                &twin_other,
                DVec3::ZERO,
                &hullmap::Settings::default(),
                &mut hullmap::Cache::new(),
            )
            .map(types::SignedDistance::from)
            .unwrap();
            let directions = [vector(direction), vector(origin)];
            // SAFETY: the pointers are valid.
            let codes = unsafe {
                [
                    hullmap_ray(shape.0, vector(origin), vector(direction), null(), &raw mut hit),
                    hullmap_signed_distance(shape.0, vector(target), null(), warm.0, &raw mut point),
                    hullmap_cast(shape.0, other.0, &raw const pose, vector(direction), null(), warm.0, &raw mut impact),
                    hullmap_bounds(shape.0, &raw const pose, &raw mut bounds),
                    hullmap_support(shape.0, directions.as_ptr(), 2, support.as_mut_ptr()),
                ]
            };
            let (ray, motion) =
                (hullmap::Ray::new(origin, direction).unwrap(), hullmap::Motion::new(direction).unwrap());
            let (settings, cast_settings) = (hullmap::Settings::default(), hullmap::CastSettings::default());
            match twin {
                Twin::Convex(twin) => {
                    assert_eq!(codes, [Code::Ok; 5]);
                    let expected = hullmap::ray(&**twin, &ray, &cast_settings);
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    let expected = hullmap::signed_distance(&**twin, target, &settings, &mut twin_cache).unwrap();
                    same!(point, expected; distance lower upper; point normal; iterations support_calls);
                    let expected =
                        hullmap::cast(&**twin, &twin_other, twin_pose, motion, &cast_settings, &mut twin_cache);
                    same!(impact, expected; t t_lower t_upper; normal point_a point_b; hit iterations support_calls);
                    let expected = twin.bounds_under(twin_pose);
                    assert_eq!(
                        [bits(bounds.min), bits(bounds.max)],
                        [expected.min, expected.max].map(|v| bits(vector(v)))
                    );
                    for (found, direction) in support.iter().zip([direction, origin]) {
                        let expected = twin.support_point(direction);
                        assert_eq!(
                            (bits(found.point), found.feature),
                            (bits(vector(expected.point)), expected.feature)
                        );
                    }
                    total += 1;
                    hits += usize::from(hit.hit);
                }
                Twin::HalfSpace(twin) => {
                    assert_eq!(codes, [Code::Ok, Code::Ok, Code::Ok, Code::Unsupported, Code::Unsupported]);
                    let expected = twin.ray(&ray, &cast_settings);
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    same!(point, twin.signed_distance(target).unwrap(); distance lower upper; point normal; iterations);
                    let expected = twin.cast(&twin_other, twin_pose, motion, &cast_settings);
                    same!(impact, expected; t t_lower t_upper; normal point_a point_b; hit iterations support_calls);
                }
                Twin::Compound(twin) => {
                    let none = Code::Unsupported;
                    assert_eq!(codes, [Code::Ok, none, Code::Ok, Code::Ok, none]);
                    let expected = compound::ray(&**twin, &ray, &cast_settings);
                    assert_eq!(hit.hull as usize, expected.hulls[0]);
                    let expected = expected.answer;
                    same!(hit, expected; t t_lower t_upper; point normal; hit iterations support_calls);
                    let mut cache = hullmap::CompoundCache::default();
                    let expected = compound::cast(&**twin, &twin_other, twin_pose, motion, &cast_settings, &mut cache);
                    assert_eq!([impact.hull_a as usize, impact.hull_b as usize], expected.hulls);
                    assert_eq!((impact.hit, impact.status), (expected.answer.hit, expected.answer.status.into()));
                    // The other one has a warm cache.
                    let same = |x: f64, y: f64| x == y || (x - y).abs() < 1e-5 * (1.0 + y.abs());
                    assert!(same(impact.t, expected.answer.t), "{impact:?}, {expected:?}");
                    assert!(message().contains("hullmap_shape_hull"), "{}", message());
                    let all: Vec<_> = twin_pack.hulls().map(|hull| hull.bounds_under(twin_pose)).collect();
                    assert_eq!(bits(bounds.min), bits(vector(all[0].min.min(all[1].min))));
                    assert_eq!(bits(bounds.max), bits(vector(all[0].max.max(all[1].max))));
                }
            }
        }
    }
    assert!(hits * 10 > total * 3, "{hits} of {total}");
}

#[test]
fn facts_and_arrays_are_those_of_the_pack() {
    let (pack, file) = (open(), file());
    let twin = hullmap::Pack::from_bytes(&file).unwrap();
    // SAFETY: the pointers are valid, and the arrays live as long as the pack.
    unsafe {
        assert_eq!(hullmap_pack_hull_count(pack.0), 2);
        let (mut index, name) = (7, CString::new("right").unwrap());
        assert_eq!((hullmap_pack_find(pack.0, name.as_ptr(), &raw mut index), index), (Code::Ok, 1));
        let mut facts = std::mem::zeroed::<types::HullFacts>();
        facts.struct_size = size_of::<types::HullFacts>();
        assert_eq!(hullmap_pack_hull_facts(pack.0, 1, &raw mut facts), Code::Ok);
        let hull = twin.hull(1).unwrap();
        assert_eq!(std::slice::from_raw_parts(facts.name.data.cast::<u8>(), facts.name.length), b"right");
        assert_eq!((facts.vertex_count, facts.face_count), (hull.vertex_count(), hull.face_count()));
        assert_eq!((facts.volume, facts.diameter), (hull.volume(), hull.diameter()));
        assert_eq!((facts.surface_area, facts.rank, facts.part), (hull.surface_area(), 3, 0));
        assert_eq!(facts.centroid, hull.centroid().into());
        let tensor = hull.inertia_tensor();
        assert_eq!((facts.inertia[1], facts.inertia[8]), (tensor.y_axis.x, tensor.z_axis.z));
        assert_eq!((facts.inner_radius, facts.outer_radius), (hull.inner_radius(), hull.outer_radius()));
        assert_eq!(facts.bounds.max, hull.bounds()[1].as_dvec3().into());
        let unmeasured = (facts.part_count, facts.solid, facts.uncovered, facts.protrusion);
        assert_eq!(unmeasured, (0, types::Solid::Unmeasured as u32, 0.0, 0.0));
        let mut arrays = std::mem::zeroed::<types::HullArrays>();
        assert_eq!(hullmap_pack_hull_arrays(pack.0, 1, &raw mut arrays), Code::Ok);
        let vertices = std::slice::from_raw_parts(arrays.vertices, 3 * arrays.vertex_count);
        assert!(vertices.iter().copied().eq(hull.vertices().flat_map(|v| v.to_array())));
        let faces = std::slice::from_raw_parts(arrays.face_vertices, arrays.face_vertex_count);
        assert!(faces.iter().copied().eq(hull.faces().flatten()));
        let neighbours = std::slice::from_raw_parts(arrays.neighbours, arrays.neighbour_count);
        let all = (0..hull.vertex_count() as u32).flat_map(|vertex| hull.neighbours(vertex));
        assert!(neighbours.iter().copied().eq(all));
    }
}

/// A thousand pairs of all kinds, in one call and one by one.
#[test]
fn batches_have_the_bits_of_single_queries() {
    let pack = open();
    let shapes = all_shapes(&pack);
    let mut rng = SplitMix64::new(3);
    let mut pairs = Vec::new();
    for i in 0..1000 {
        let (a, b) = (&shapes[i % shapes.len()], &shapes[(i / 7) % (shapes.len() - 1)]);
        pairs.push(Pair { a: a.0, b: b.0, b_in_a: random_pose(&mut rng, 1.4).1 });
    }
    let count = pairs.len();
    let (caches, twin_caches): (Vec<_>, Vec<_>) = (0..count).map(|_| (cache(), cache())).unzip();
    let (manifolds, twin_manifolds): (Vec<_>, Vec<_>) = (0..count).map(|_| (manifold(), manifold())).unzip();
    let handles: Vec<*mut Cache> = caches.iter().map(|cache| cache.0).collect();
    let manifold_handles: Vec<*mut Manifold> = manifolds.iter().map(|manifold| manifold.0).collect();
    let mut contacts = vec![types::Contact::separated(); count];
    let mut gaps = vec![types::Distance::new(hullmap::Distance::default(), [9, 9]); count];
    let mut hits = vec![types::Intersection::new(hullmap::Intersection::default(), [9, 9]); count];
    // Cold, warm, and without caches.
    for handles in [handles.as_ptr(), handles.as_ptr(), null()] {
        // SAFETY: the pointers are valid.
        unsafe {
            let p = pairs.as_ptr();
            assert_eq!(hullmap_batch_intersects(p, count, handles, hits.as_mut_ptr()), Code::Ok);
            assert_eq!(hullmap_batch_distance(p, count, null(), handles, gaps.as_mut_ptr()), Code::Ok);
            assert_eq!(hullmap_batch_contact(p, count, null(), handles, contacts.as_mut_ptr()), Code::Ok);
        }
        for (i, pair) in pairs.iter().enumerate() {
            let (mut hit, mut gap, mut contact) = (hits[i], gaps[i], contacts[i]);
            let cache = if handles.is_null() { null_mut() } else { twin_caches[i].0 };
            let pose = &raw const pair.b_in_a;
            // SAFETY: the pointers are valid.
            unsafe {
                assert_eq!(hullmap_intersects(pair.a, pair.b, pose, cache, &raw mut hit), Code::Ok);
                assert_eq!(hullmap_distance(pair.a, pair.b, pose, null(), cache, &raw mut gap), Code::Ok);
                assert_eq!(hullmap_contact(pair.a, pair.b, pose, null(), cache, &raw mut contact), Code::Ok);
            }
            assert_eq!((hit, gap, contact), (hits[i], gaps[i], contacts[i]), "pair {i}");
        }
    }
    // SAFETY: zeros are a valid value.
    let mut shown = vec![unsafe { std::mem::zeroed::<types::ManifoldPoints>() }; count];
    // SAFETY: the pointers are valid.
    let code = unsafe {
        hullmap_batch_manifolds(pairs.as_ptr(), count, null(), manifold_handles.as_ptr(), shown.as_mut_ptr())
    };
    assert_eq!(code, Code::Ok, "{}", message());
    let mut points = 0;
    for (i, pair) in pairs.iter().enumerate() {
        let mut single = shown[i];
        // SAFETY: the pointers are valid, and the points live until the next update.
        unsafe {
            let manifold = twin_manifolds[i].0;
            let pose = &raw const pair.b_in_a;
            assert_eq!(hullmap_manifold_update(manifold, pair.a, pair.b, pose, null(), &raw mut single), Code::Ok);
            let [found, expected] =
                [shown[i], single].map(|shown| std::slice::from_raw_parts(shown.points, shown.count));
            assert_eq!(found, expected, "pair {i}");
            points += found.len();
        }
    }
    assert!(points > 500, "{points}");
}

/// What the caller writes into the points is there after the next update.
#[test]
fn impulses_of_manifold_points_are_kept() {
    let pack = open();
    let shapes = all_shapes(&pack);
    // A cuboid on a half-space, and a compound on it.
    for b in [&shapes[5], &shapes[3]] {
        let manifold = manifold();
        let mut pose = types::Pose { rotation: types::Quat { w: 1.0, ..Default::default() }, ..Default::default() };
        // SAFETY: the pointers are valid, and the points live until the next update.
        unsafe {
            let mut shown = std::mem::zeroed::<types::ManifoldPoints>();
            let mut update = |pose: &types::Pose| {
                let code = hullmap_manifold_update(manifold.0, shapes[9].0, b.0, pose, null(), &raw mut shown);
                assert_eq!(code, Code::Ok);
                std::slice::from_raw_parts_mut(shown.points, shown.count)
            };
            let points = update(&pose);
            assert!(!points.is_empty());
            let address = points.as_ptr();
            for (i, point) in points.iter_mut().enumerate() {
                assert_eq!((point.impulse, point.user_data, point.age), ([0.0; 3], 0, 0));
                (point.impulse, point.user_data) = ([i as f64 + 1.0, 2.0, f64::NAN], 100 + i as u64);
                // Not the caller's: the library keeps its own.
                point.depth = f64::NAN;
            }
            let count = points.len();
            pose.translation.z -= 1e-4;
            let points = update(&pose);
            assert_eq!((points.len(), points.as_ptr()), (count, address));
            for (i, point) in points.iter().enumerate() {
                assert_eq!((point.impulse[0], point.user_data, point.age), (i as f64 + 1.0, 100 + i as u64, 1));
                assert!(point.depth.is_finite());
            }
            assert_eq!(hullmap_manifold_clear(manifold.0), Code::Ok);
            assert_eq!(update(&pose)[0].age, 0);
        }
    }
}

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
    let broken = Shape { kind: Kind::Convex(Box::new(Broken)) };
    let pose = types::Pose { rotation: types::Quat { w: 1.0, ..Default::default() }, ..Default::default() };
    let (warm, manifold) = (cache(), manifold());
    let mut contact = types::Contact::separated();
    // SAFETY: the pointers are valid.
    unsafe {
        let pose = &raw const pose;
        let found = hullmap_contact(shapes[0].0, &raw const broken, pose, null(), warm.0, &raw mut contact);
        assert_eq!(found, Code::Panic);
        assert!(message().contains("broken shape"), "{}", message());
        assert_eq!(contact, types::Contact::separated());
        let mut shown = std::mem::zeroed::<types::ManifoldPoints>();
        let a = shapes[3].0;
        let found = hullmap_manifold_update(manifold.0, a, &raw const broken, pose, null(), &raw mut shown);
        assert_eq!(found, Code::Panic);
        let pairs = vec![Pair { a, b: &raw const broken, b_in_a: *pose }; 200];
        let mut contacts = vec![contact; 200];
        let out = contacts.as_mut_ptr();
        assert_eq!(hullmap_batch_contact(pairs.as_ptr(), 200, null(), null(), out), Code::Panic);
        let direction = types::Vec3::default();
        let mut support = types::Support::default();
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
    let b_in_a = types::Pose { rotation: types::Quat { w: 1.0, ..Default::default() }, ..Default::default() };
    let pairs = [Pair { a: shapes[0].0, b: shapes[1].0, b_in_a }; 2];
    let mut contacts = [types::Contact::separated(); 2];
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

/// Shapes keep their pack; names of results and versions are there.
#[test]
fn shapes_outlive_their_pack() {
    let pack = open();
    // SAFETY: the handle is valid.
    let pack_handle = Arc::downgrade(unsafe { &*pack.0 }.pack());
    let shapes = all_shapes(&pack);
    drop(pack);
    assert!(pack_handle.upgrade().is_some());
    let b_in_a = types::Pose { rotation: types::Quat { w: 1.0, ..Default::default() }, ..Default::default() };
    let mut contact = types::Contact::separated();
    // SAFETY: the pointers are valid.
    let code =
        unsafe { hullmap_contact(shapes[0].0, shapes[3].0, &raw const b_in_a, null(), null_mut(), &raw mut contact) };
    assert!(code == Code::Ok && contact.hit);
    drop(shapes);
    assert!(pack_handle.upgrade().is_none());

    // SAFETY: the texts end with NUL.
    let text = |text| unsafe { CStr::from_ptr(text) }.to_str().unwrap();
    assert_eq!(text(hullmap_version()), env!("CARGO_PKG_VERSION"));
    assert_eq!((hullmap_abi_version(), hullmap_format_version()), (types::ABI_VERSION, hullmap::FORMAT_VERSION));
    assert_eq!(text(hullmap_result_name(Code::Panic as u32)), "panic");
    assert_eq!(text(hullmap_result_name(Code::NotFound as u32)), "not_found");
    assert_eq!(text(hullmap_result_name(9)), "unknown");
    let mut relative = b_in_a;
    let far = types::Pose { translation: types::Vec3 { x: 1e9, y: 0.0, z: 2.0 }, ..b_in_a };
    let a = types::Pose { translation: types::Vec3 { x: 1e9, y: 0.0, z: 0.0 }, ..b_in_a };
    // SAFETY: the pointers are valid.
    assert_eq!(unsafe { hullmap_pose_relative(&raw const a, &raw const far, &raw mut relative) }, Code::Ok);
    assert_eq!(relative.translation, types::Vec3 { x: 0.0, y: 0.0, z: 2.0 });
}

/// Prints nanoseconds a query through the interface and through the crate for Rust: medians over
/// interleaved rounds.
///
///     cargo test --release --package hullmap-c --lib overhead -- --ignored --nocapture
#[test]
#[ignore = "prints times, in a release build"]
fn overhead() {
    use std::{hint::black_box, time::Instant};
    const POSES: usize = 256;
    /// Median nanoseconds of each function, called in turn.
    fn measure<const N: usize>(mut functions: [&mut dyn FnMut(usize); N]) -> [f64; N] {
        let mut times: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
        for _ in 0..81 {
            for (function, times) in functions.iter_mut().zip(&mut times) {
                let start = Instant::now();
                (0..POSES).for_each(&mut **function);
                times.push(start.elapsed().as_nanos() as f64 / POSES as f64);
            }
        }
        times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
    }
    // Through pointers that the compiler does not know, as from C.
    type Shapes = *const Shape;
    type Query<S, T> = unsafe extern "C" fn(Shapes, Shapes, *const types::Pose, *const S, *mut Cache, *mut T) -> Code;
    let contact: Query<types::Settings, types::Contact> = black_box(hullmap_contact);
    let distance: Query<types::Settings, types::Distance> = black_box(hullmap_distance);
    let intersects: unsafe extern "C" fn(_, _, _, _, _) -> _ = black_box(hullmap_intersects);
    let support: unsafe extern "C" fn(_, _, _, _) -> _ = black_box(hullmap_support);
    let update: unsafe extern "C" fn(_, _, _, _, _, _) -> _ = black_box(hullmap_manifold_update);
    println!("| vertices | query | C, ns | Rust, ns | difference, ns |\n|---|---|---|---|---|");
    for count in [8, 32, 512, 8192] {
        let sets = [1, 2].map(|seed| packs::point_set("ball", &shapes::families::sphere(count, seed)));
        let file = packs::bytes(&sets, hullmap_bake::IndexKind::Tree, &hullmap_bake::SourceRecord::default()).unwrap();
        let twin = hullmap::Pack::from_bytes(&file).unwrap();
        let (left, right) = (twin.hull(0).unwrap(), twin.hull(1).unwrap());
        // SAFETY: the pointers are valid.
        let pack =
            Owned::new(hullmap_pack_free, |out| unsafe { hullmap_pack_from_memory(file.as_ptr(), file.len(), 0, out) });
        // SAFETY: the pointers are valid.
        let [a, b] =
            [0, 1].map(|index| Owned::new(hullmap_shape_free, |out| unsafe { hullmap_shape_hull(pack.0, index, out) }));
        for (name, x) in [("touching", 1.9), ("apart", 2.5)] {
            let mut rng = SplitMix64::new(7);
            let poses: Vec<types::Pose> = (0..POSES)
                .map(|step| {
                    let (_, mut pose) = random_pose(&mut rng, 0.01);
                    // A slow walk, as in a simulation.
                    pose.translation.x = x + 1e-4 * step as f64;
                    pose.rotation = types::Quat { x: 0.1, y: 1e-3 * step as f64, z: 0.2, w: 1.0 };
                    pose
                })
                .collect();
            let pose_of = |pose: types::Pose| {
                let types::Quat { x, y, z, w } = pose.rotation;
                hullmap::Pose::new(pose.translation.into(), DQuat::from_xyzw(x, y, z, w)).unwrap()
            };
            let settings = hullmap::Settings::default();
            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Contact::separated();
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { contact(a.0, b.0, &raw const poses[i], null(), warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::contact(&left, &right, pose, &settings, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | contact, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Distance::new(hullmap::Distance::default(), [0, 0]);
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { distance(a.0, b.0, &raw const poses[i], null(), warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::distance(&left, &right, pose, &settings, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | distance, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (warm, mut twin_cache) = (cache(), hullmap::Cache::new());
            let mut out = types::Intersection::new(hullmap::Intersection::default(), [0, 0]);
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { intersects(a.0, b.0, &raw const poses[i], warm.0, &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let pose = pose_of(poses[i]);
                black_box(hullmap::intersects(&left, &right, pose, &mut twin_cache));
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | intersects, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);

            let (manifold, mut twin_cache) = (manifold(), hullmap::Cache::new());
            let mut twin_manifold = hullmap::Manifold::new();
            // SAFETY: zeros are a valid value.
            let mut out = unsafe { std::mem::zeroed::<types::ManifoldPoints>() };
            let mut by_c = |i: usize| {
                // SAFETY: the pointers are valid.
                let code = unsafe { update(manifold.0, a.0, b.0, &raw const poses[i], null(), &raw mut out) };
                assert!(code == Code::Ok);
                black_box(&out);
            };
            let mut by_rust = |i: usize| {
                let settings = hullmap::ManifoldSettings::default();
                twin_manifold.update(&left, &right, pose_of(poses[i]), &settings, &mut twin_cache);
                black_box(twin_manifold.points());
            };
            let [c, rust] = measure([&mut by_c, &mut by_rust]);
            println!("| {count} | manifold, {name} | {c:.0} | {rust:.0} | {:.0} |", c - rust);
        }
        let mut rng = SplitMix64::new(8);
        let directions: Vec<types::Vec3> = (0..POSES).map(|_| vector(DVec3::from_array(rng.direction()))).collect();
        let mut out = vec![types::Support::default(); POSES];
        let mut one = out.clone();
        let mut by_c = |i: usize| {
            // SAFETY: the pointers are valid.
            assert!(unsafe { support(a.0, &raw const directions[i], 1, one.as_mut_ptr()) } == Code::Ok);
            black_box(&one);
        };
        let mut all = |i: usize| {
            if i == 0 {
                // SAFETY: the pointers are valid.
                let code = unsafe { support(a.0, directions.as_ptr(), POSES, out.as_mut_ptr()) };
                assert!(code == Code::Ok);
                black_box(&out);
            }
        };
        let mut by_rust = |i: usize| {
            black_box(left.support_point(directions[i].into()));
        };
        let [c, many, rust] = measure([&mut by_c, &mut all, &mut by_rust]);
        println!("| {count} | support | {c:.1} | {rust:.1} | {:.1} |", c - rust);
        println!("| {count} | support, {POSES} in one call | {many:.1} | {rust:.1} | {:.1} |", many - rust);
    }
}
