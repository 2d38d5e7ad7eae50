//! `HullDispatcher` against brute force in f64, and against parry's dispatcher on polyhedra of the
//! same vertices.

use hullmap::glam::DVec3;
use hullmap_parry::{BakedHull, HullDispatcher};
use hullmap_random::SplitMix64;
use hullmap_testkit::depth::signed_depth;
use hullmap_testkit::gap::gap;
use hullmap_testkit::polytope::Polytope;
use parry3d::math::{IVector, Pose, Vector};
use parry3d::query::details::ShapeCastOptions;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, QueryDispatcher};
use parry3d::shape::{
    Ball, Capsule, Compound, Cone, Cuboid, Cylinder, HalfSpace, HeightField, RoundCone, RoundCuboid, RoundCylinder,
    RoundTriangle, Segment, Shape, SharedShape, TriMesh, Triangle, Voxels,
};
use shapes::families;

use crate::bodies::{hull, pose, wide_pose};
use crate::judge::{check, time};

/// Every primitive that a hull can meet, about 1 in size, with its name.
pub fn primitives() -> Vec<(&'static str, SharedShape)> {
    let corners = [Vector::new(-1.0, 0.0, -0.5), Vector::new(1.0, 0.1, -0.5), Vector::new(0.0, -0.1, 1.0)];
    let [a, b, c] = corners;
    vec![
        ("ball", SharedShape::new(Ball::new(0.8))),
        ("capsule", SharedShape::new(Capsule::new(Vector::new(-0.5, 0.1, 0.0), Vector::new(0.4, 0.3, 0.2), 0.3))),
        ("cone", SharedShape::new(Cone::new(0.7, 0.5))),
        ("cuboid", SharedShape::new(Cuboid::new(Vector::new(0.5, 0.8, 0.3)))),
        ("cylinder", SharedShape::new(Cylinder::new(0.6, 0.5))),
        (
            "round cuboid",
            SharedShape::new(RoundCuboid { inner_shape: Cuboid::new(Vector::splat(0.4)), border_radius: 0.1 }),
        ),
        ("round cone", SharedShape::new(RoundCone { inner_shape: Cone::new(0.6, 0.4), border_radius: 0.1 })),
        (
            "round cylinder",
            SharedShape::new(RoundCylinder { inner_shape: Cylinder::new(0.5, 0.4), border_radius: 0.1 }),
        ),
        ("round triangle", SharedShape::new(RoundTriangle { inner_shape: Triangle::new(a, b, c), border_radius: 0.1 })),
        ("segment", SharedShape::new(Segment::new(a, b))),
        ("triangle", SharedShape::new(Triangle::new(a, b, c))),
    ]
}

#[test]
fn two_hulls_agree_with_brute_force() {
    let (a, b) = (hull(&families::rock(60, 1)), hull(&families::prism(16, 1)));
    let solids = [&a, &b].map(|hull| Polytope::new(hull.hull()));
    let mut rng = SplitMix64::new(1);
    let mut hits = 0;
    for _ in 0..400 {
        let distance = rng.between(0.2, 2.6);
        let pose = pose(&mut rng, distance);
        let placed = solids[1].placed(wide_pose(&pose));
        let apart = gap(&solids[0], &placed);
        let overlapping = apart.upper < 1e-9;
        hits += usize::from(overlapping);
        let truth = if overlapping { -signed_depth(&solids[0], &placed, 0.0).0 } else { apart.upper };
        check("two hulls", &a, &b, &pose, truth, [2e-5, 1e-4]);
        assert_eq!(HullDispatcher.intersection_test(&pose, &a, &b).unwrap().intersecting, overlapping);
        let theirs = DefaultQueryDispatcher
            .contact(&pose, &a.to_convex_polyhedron().unwrap(), &b.to_convex_polyhedron().unwrap(), 100.0)
            .unwrap()
            .unwrap();
        assert!(f64::from(theirs.dist) < truth + 1e-3, "{} {truth}", theirs.dist);
    }
    assert!((100..300).contains(&hits), "{hits}");
}

/// In both orders, with points and normals of either shape.
#[test]
fn primitives_agree_with_parry() {
    let hull = hull(&families::rock(200, 3));
    let polyhedron = hull.to_convex_polyhedron().unwrap();
    let mut rng = SplitMix64::new(2);
    for (name, shape) in primitives() {
        for _ in 0..100 {
            let distance = rng.between(0.3, 3.0);
            let pose = pose(&mut rng, distance);
            let theirs = DefaultQueryDispatcher.contact(&pose, &polyhedron, &*shape, 100.0).unwrap().unwrap();
            let ours = HullDispatcher.contact(&pose, &hull, &*shape, 100.0).unwrap().unwrap();
            // parry's depth is along the normal that its polytope ended with; ours is the minimum.
            // On curved surfaces its distance is up to 3e-3 above the truth.
            let slight = if ours.dist < 0.0 { 0.02 } else { 1e-2 };
            assert!((ours.dist - theirs.dist).abs() < slight, "{name}: {} {}", ours.dist, theirs.dist);
            check(name, &hull, &*shape, &pose, f64::from(ours.dist), [1e-4, 5e-3]);
        }
    }
}

#[test]
fn half_spaces_agree_with_the_lowest_vertex() {
    let hull = hull(&families::rock(200, 3));
    let plane = HalfSpace::new(Vector::Y);
    let mut rng = SplitMix64::new(3);
    for _ in 0..100 {
        let pose = pose(&mut rng, 1.0);
        let lowest = hull.hull().vertices().map(|v| (pose * v).y).fold(f32::INFINITY, f32::min);
        let contact = HullDispatcher.contact(&pose, &plane, &hull, 100.0).unwrap().unwrap();
        assert!((contact.dist - lowest).abs() < 1e-5 && contact.normal1 == Vector::Y);
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        HullDispatcher.contact_manifolds(&pose, &plane, &hull, 0.05, &mut manifolds, &mut None).unwrap();
        let deepest = manifolds[0].points.iter().map(|p| p.dist).fold(f32::INFINITY, f32::min);
        assert!(lowest > 0.05 || (deepest - lowest).abs() < 1e-4, "{deepest} {lowest}");
    }
}

#[test]
fn casts_agree_with_parry() {
    let hull = hull(&families::rock(200, 3));
    let polyhedron = hull.to_convex_polyhedron().unwrap();
    let mut rng = SplitMix64::new(4);
    for target_distance in [0.0, 0.1] {
        let options = ShapeCastOptions { max_time_of_impact: 10.0, target_distance, ..Default::default() };
        let mut hits = 0;
        for (name, shape) in primitives() {
            for _ in 0..50 {
                let pose = pose(&mut rng, 4.0);
                let aim = (DVec3::from_array(rng.direction()) * 0.7).as_vec3();
                let velocity = (aim - pose.translation) * 0.5;
                let theirs =
                    DefaultQueryDispatcher.cast_shapes(&pose, velocity, &polyhedron, &*shape, options).unwrap();
                let ours = HullDispatcher.cast_shapes(&pose, velocity, &hull, &*shape, options).unwrap();
                let turned = -(pose.rotation.inverse() * velocity);
                let swapped = HullDispatcher.cast_shapes(&pose.inverse(), turned, &*shape, &hull, options).unwrap();
                let (Some(ours), Some(swapped)) = (ours, swapped) else {
                    assert!(ours.is_none() && swapped.is_none(), "{name}");
                    continue;
                };
                hits += 1;
                assert!((ours.time_of_impact - swapped.time_of_impact).abs() < 1e-4, "{name}");
                // Where they first meet, they are at the target distance.
                let met = Pose::from_parts(pose.translation + velocity * ours.time_of_impact, pose.rotation);
                let apart = HullDispatcher.contact(&met, &hull, &*shape, 1.0).unwrap().unwrap();
                assert!((apart.dist - target_distance).abs() < 1e-4, "{name}: {}", apart.dist);
                if let Some(theirs) = theirs {
                    assert!((ours.time_of_impact - theirs.time_of_impact).abs() < 0.02, "{name}");
                }
            }
        }
        assert!((100..550).contains(&hits), "{hits}");
    }
}

/// The ground of boxes of 1 m below y = 0, as voxels.
fn voxels() -> Voxels {
    let boxes: Vec<IVector> = (-5..5).flat_map(|x| (-5..5).map(move |z| IVector::new(x, -1, z))).collect();
    Voxels::new(Vector::splat(1.0), &boxes)
}

/// Overlaps and casts agree with one cuboid of the same extent.
#[test]
fn voxels_are_boxes() {
    let (hull, voxels) = (hull(&families::rock(100, 1)), voxels());
    let slab = Compound::new(vec![(
        Pose::translation(0.0, -0.5, 0.0),
        SharedShape::new(Cuboid::new(Vector::new(5.0, 0.5, 5.0))),
    )]);
    let options = ShapeCastOptions { max_time_of_impact: 10.0, ..Default::default() };
    let (mut rng, mut overlaps, mut hits) = (SplitMix64::new(7), 0, 0);
    for _ in 0..100 {
        let pose = pose(&mut rng, 2.0);
        let of_voxels = HullDispatcher.intersection_test(&pose, &voxels, &hull).unwrap().intersecting;
        let of_slab = HullDispatcher.intersection_test(&pose, &slab, &hull).unwrap().intersecting;
        let swapped = HullDispatcher.intersection_test(&pose.inverse(), &hull, &voxels).unwrap().intersecting;
        assert_eq!([of_voxels, swapped], [of_slab; 2]);
        overlaps += usize::from(of_slab);
        let velocity = (DVec3::from_array(rng.direction()) * 2.0).as_vec3() - pose.translation;
        let on_voxels = HullDispatcher.cast_shapes(&pose, velocity, &voxels, &hull, options).unwrap();
        let on_slab = HullDispatcher.cast_shapes(&pose, velocity, &slab, &hull, options).unwrap();
        let turned = -(pose.rotation.inverse() * velocity);
        let swapped = HullDispatcher.cast_shapes(&pose.inverse(), turned, &hull, &voxels, options).unwrap();
        let [first, second, third] = [on_voxels, on_slab, swapped].map(time);
        for other in [second, third] {
            assert!(first == other || (first - other).abs() < 1e-4, "{first} {other}");
        }
        hits += usize::from(second < f32::INFINITY);
    }
    assert!((20..80).contains(&overlaps) && hits > overlaps, "{overlaps} overlaps, {hits} hits");
}

/// The points of shapes that moved by less than a millimetre stay where they are on both shapes.
#[test]
fn shapes_that_barely_move_keep_their_points() {
    let (slab, cube) = (Cuboid::new(Vector::new(5.0, 1.0, 5.0)), hull(&families::cube_grid(8, 1)));
    let half = cube.compute_local_aabb().half_extents().y;
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let mut workspace = None;
    let mut points_at = |x: f32, y: f32| -> Vec<[Vector; 2]> {
        let pos12 = Pose::translation(x, 1.0 + half + y, 0.7);
        HullDispatcher.contact_manifolds(&pos12, &slab, &cube, 0.05, &mut manifolds, &mut workspace).unwrap();
        let points = &manifolds[0].points;
        assert!(points.len() >= 4 && points.iter().all(|point| (point.dist - y).abs() < 1e-5), "{points:?}");
        points.iter().map(|point| [point.local_p1, point.local_p2]).collect()
    };
    let first = points_at(0.3, -0.01);
    assert_eq!(points_at(0.3005, -0.0105), first);
    assert_ne!(points_at(0.32, -0.0105), first);
}

/// A box on every kind of floor has four points at the right depth, in both orders, alone and as
/// the part of a compound, and the data of a point stays with it.
#[test]
fn manifolds_of_a_resting_cube() {
    let cube = hull(&families::cube_grid(8, 1));
    let compound = Compound::new(vec![(Pose::IDENTITY, cube.clone().into())]);
    for body in [&cube as &dyn Shape, &compound] {
        rest(body, &cube);
    }
}

/// `body` rests on each floor. It has the shape of `cube`.
fn rest(body: &dyn Shape, cube: &BakedHull) {
    let kind = body.shape_type();
    let half = cube.compute_local_aabb().half_extents().y;
    let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|[x, z]| Vector::new(x, 0.0, z));
    let down = Pose::translation(0.0, -1.0, 0.0);
    let slab: SharedShape = SharedShape::new(Cuboid::new(Vector::new(5.0, 1.0, 5.0)));
    let heights = parry3d::utils::Array2::repeat(4, 4, 0.0);
    let floors: Vec<(&str, SharedShape, Pose)> = vec![
        ("cuboid", slab.clone(), down),
        ("hull", hull(&families::prism(64, 1)).scaled(Vector::new(5.0, 5.0, 1.0)).unwrap().into(), {
            Pose::new(Vector::new(0.0, -1.0, 0.0), Vector::X * -std::f32::consts::FRAC_PI_2)
        }),
        ("half-space", SharedShape::new(HalfSpace::new(Vector::Y)), Pose::IDENTITY),
        (
            "triangle mesh",
            SharedShape::new(TriMesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap()),
            Pose::IDENTITY,
        ),
        ("heightfield", SharedShape::new(HeightField::new(heights, Vector::new(10.0, 1.0, 10.0))), Pose::IDENTITY),
        ("compound", SharedShape::new(Compound::new(vec![(down, slab)])), Pose::IDENTITY),
        ("voxels", SharedShape::new(voxels()), Pose::IDENTITY),
    ];
    for (name, floor, at) in floors {
        for flipped in [false, true] {
            let mut manifolds: Vec<ContactManifold<(), u32>> = Vec::new();
            let mut workspace = None;
            let mut step = |x: f32, y: f32, manifolds: &mut Vec<_>| {
                let pos12 = at.inverse() * Pose::translation(x, half + y, 0.7);
                let answer = if flipped {
                    HullDispatcher.contact_manifolds(&pos12.inverse(), body, &*floor, 0.05, manifolds, &mut workspace)
                } else {
                    HullDispatcher.contact_manifolds(&pos12, &*floor, body, 0.05, manifolds, &mut workspace)
                };
                answer.unwrap();
            };
            step(0.3, -0.01, &mut manifolds);
            // A triangle under the rim of the cube's face may push it aside, and is less deep.
            let depths: Vec<f32> = manifolds.iter().flat_map(|m| &m.points).map(|point| -point.dist).collect();
            let full = depths.iter().filter(|depth| (**depth - 0.01).abs() < 1e-4).count();
            assert!(full >= 4 && depths.iter().all(|depth| *depth < 0.0101), "{kind:?} {name} {flipped}: {depths:?}");
            let mut stamp = 0;
            for point in manifolds.iter_mut().flat_map(|m| &mut m.points) {
                stamp += 1;
                point.data = stamp;
            }
            // Farther than the coherence test allows.
            step(0.32, -0.012, &mut manifolds);
            let kept = manifolds.iter().flat_map(|m| &m.points).filter(|p| p.data > 0).count();
            assert!(kept >= 4, "{kind:?} {name} {flipped}: {kept} points kept their data");
            step(0.32, 1.0, &mut manifolds);
            assert!(manifolds.iter().all(|m| m.points.is_empty()), "{kind:?} {name} {flipped}");
        }
    }
}

/// Queries of a compound agree with its nearest part.
#[test]
fn compounds_answer_as_their_nearest_part() {
    let (hull, rock) = (hull(&families::rock(100, 1)), hull(&families::rock(100, 2)));
    let places = [Pose::translation(-3.0, 0.0, 0.0), Pose::translation(3.0, 0.5, 0.0)];
    let parts = places.map(|place| (place, SharedShape::new(hull.clone())));
    let compound = Compound::new(parts.to_vec());
    let (mut rng, mut met) = (SplitMix64::new(5), 0);
    for _ in 0..100 {
        let pose = pose(&mut rng, 4.0);
        let of_parts = places
            .map(|place| HullDispatcher.contact(&place.inv_mul(&pose), &hull, &rock, 100.0).unwrap().unwrap().dist);
        let nearest = of_parts[0].min(of_parts[1]);
        check("compound", &compound, &rock, &pose, nearest.into(), [1e-4, 1e-3]);
        // Towards a place between the parts, and beside them.
        let options = ShapeCastOptions { max_time_of_impact: 10.0, ..Default::default() };
        let velocity = (Vector::new(rng.between(-3.0, 3.0) as f32, 0.0, 0.0) - pose.translation) * 0.4;
        let times = places.map(|place| {
            let (from, along) = (place.inv_mul(&pose), place.rotation.inverse() * velocity);
            time(HullDispatcher.cast_shapes(&from, along, &hull, &rock, options).unwrap())
        });
        let first = times[0].min(times[1]);
        let found = time(HullDispatcher.cast_shapes(&pose, velocity, &compound, &rock, options).unwrap());
        assert!(found == first || (found - first).abs() < 1e-4, "{found} {first}");
        met += usize::from(first < f32::INFINITY);
    }
    assert!((20..95).contains(&met), "{met}");
}

/// Queries with numbers that are not finite, or sizes of zero, end. Their answers are unspecified.
#[test]
fn invalid_numbers_are_harmless() {
    let hull = hull(&families::rock(50, 1));
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        for (_, shape) in primitives() {
            let pose = Pose::translation(bad, 1.0, 0.0);
            let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
            let _ = HullDispatcher.contact_manifolds(&pose, &hull, &*shape, bad, &mut manifolds, &mut None);
        }
        let flat = Cuboid::new(Vector::new(1.0, 1.0, bad));
        let _ = HullDispatcher.distance(&Pose::translation(0.0, 0.0, 3.0), &flat, &hull);
    }
}
