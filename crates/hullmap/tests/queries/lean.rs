//! Lean packs: the same answers as full packs, except for hints, faces and manifolds.

use crate::any_shape::update;
use hullmap::glam::{DVec3, Vec3};
use hullmap::shapes::{Cuboid, TILT};
use hullmap::{
    Cache, CastSettings, Feature, Hull, Manifold, ManifoldSettings, Pack, Pose, Ray, Settings, Shape, SupportMap,
    contact, distance, intersects, ray,
};
use hullmap_bake::{IndexKind, SourceRecord, bake_hull, write_lean_pack, write_pack};
use hullmap_testkit::packs::point_set;
use hullmap_testkit::random::RandomPoses;
use shapes::{families::Family, rng::SplitMix64, solids};

const SEED: u64 = 0x1ea4;

/// The same hull in a full pack and in a lean one.
struct Twins([Pack; 2]);

impl Twins {
    fn new(positions: &[[f32; 3]]) -> Self {
        let baked = bake_hull(&point_set("hull", positions), IndexKind::Tree).unwrap();
        let full = write_pack(std::slice::from_ref(&baked), &SourceRecord::default()).unwrap();
        let lean = write_lean_pack(vec![baked], &SourceRecord::default()).unwrap();
        Self([full, lean].map(|file| Pack::from_bytes(&file).unwrap()))
    }

    fn hulls(&self) -> [Hull<'_>; 2] {
        self.0.each_ref().map(|pack| pack.hull(0).unwrap())
    }
}

fn twins() -> Vec<Twins> {
    let sheet: Vec<[f32; 3]> = (0..9).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.0]).collect();
    let sets = [
        Family::Rock.points(12, 1),
        Family::Sphere.points(32, 2),
        Family::Sphere.points(33, 3),
        Family::Rock.points(400, 4),
        Family::Prism.points(96, 5),
        sheet,
        vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.5]],
    ];
    sets.iter().map(|set| Twins::new(set)).collect()
}

/// A lean pack of a large hull takes less than half of the bytes.
#[test]
fn lean_packs_are_smaller() {
    let twins = Twins::new(&Family::Sphere.points(1000, 1));
    let [full, lean] = twins.0.each_ref().map(|pack| pack.byte_len() as f64 / 1000.0);
    assert!(2.0 * lean < full, "{lean} of {full} bytes per vertex");
    let [full, lean] = twins.hulls();
    assert!(lean.is_lean() && !full.is_lean());
    assert_eq!((lean.face_count(), lean.neighbours(3).len(), lean.faces_at(3).len()), (0, 0, 0));
    assert_eq!((lean.face_normal(0), lean.face_towards(DVec3::X)), (None, None));
    assert!(full.vertices().eq(lean.vertices()) && full.source_vertex(9) == lean.source_vertex(9));
}

#[test]
fn answers_have_the_same_bits() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED);
    let twins = twins();
    let (settings, casts) = (Settings::default(), CastSettings::default());
    let mut hits = 0;
    let mut count = 0;
    for first in &twins {
        for second in &twins {
            let ([a, lean_a], [b, lean_b]) = (first.hulls(), second.hulls());
            let mut caches = [Cache::new(), Cache::new()];
            let reach = a.outer_radius() + b.outer_radius();
            for _ in 0..60 {
                let middle = a.interior_point() - b.interior_point();
                let b_in_a = Pose::new(middle + rng.unit_vector() * rng.between(0.0, reach), rng.rotation()).unwrap();
                for caches in [&mut [Cache::new(), Cache::new()], &mut caches] {
                    let [cache, lean_cache] = caches;
                    let found = contact(&a, &b, b_in_a, &settings, cache);
                    let lean_found = contact(&lean_a, &lean_b, b_in_a, &settings, lean_cache);
                    assert_eq!(found, lean_found);
                    let gap = distance(&a, &b, b_in_a, &settings, cache);
                    assert_eq!(gap, distance(&lean_a, &lean_b, b_in_a, &settings, lean_cache));
                    let answer = intersects(&a, &b, b_in_a, cache);
                    assert_eq!(answer, intersects(&lean_a, &lean_b, b_in_a, lean_cache));
                    hits += u32::from(found.hit);
                    count += 1;
                }
                let to = a.interior_point() + rng.unit_vector() * a.outer_radius();
                let from = a.interior_point() + rng.unit_vector() * 3.0 * a.outer_radius();
                let way = Ray::new(from, to - from).unwrap();
                assert_eq!(ray(&a, &way, &casts), ray(&lean_a, &way, &casts));
                let dir = rng.unit_vector().as_vec3();
                let found = lean_a.support(dir);
                assert_eq!(a.support(dir), found);
                let near = dir + Vec3::new(1e-3, -2e-3, 1e-3);
                let [hinted, plain] = [lean_a.support_from(near, found.index), a.support(near)];
                assert_eq!(hinted.point.dot(near), plain.point.dot(near));
            }
        }
    }
    assert!((0.2..0.8).contains(&(f64::from(hits) / f64::from(count))), "{hits} hits of {count}");
}

/// Every face of a lean hull on a box is found that is within [`TILT`] of the contact normal.
/// Points of a manifold are on both shapes.
#[test]
fn manifolds_of_lean_hulls_lie_on_both_shapes() {
    println!("seed {SEED:#x}");
    let mut rng = SplitMix64::new(SEED);
    let ground = Cuboid::new(DVec3::new(20.0, 20.0, 1.0)).unwrap();
    let settings = ManifoldSettings::default();
    let mut flat = [0; 2];
    // Its caps have more corners than a feature, and it has too many vertices for faces.
    let twins = Twins::new(&solids::extrusion(&solids::regular_polygon(40, 1.0), -1.0, 1.0).vertices);
    let [full, lean] = twins.hulls();
    for _ in 0..200 {
        let tilt = rng.between(0.0, 0.5 * TILT);
        let turn = hullmap::glam::DQuat::from_axis_angle(DVec3::new(1.0, 0.3, 0.0).normalize(), tilt);
        let lowest = -(turn.inverse() * DVec3::NEG_Z).dot(full.support_point(turn.inverse() * DVec3::NEG_Z).point);
        let pose = Pose::new(DVec3::new(0.3, -0.2, 1.0 - lowest - 1e-3), turn).unwrap();
        let [mut expected, mut found] = [Manifold::new(), Manifold::new()];
        update(&mut expected, &ground, &full, pose, &settings, &mut Cache::new());
        update(&mut found, &ground, &lean, pose, &settings, &mut Cache::new());
        assert_eq!(found.normal(), expected.normal());
        assert!(!found.points().is_empty());
        for point in found.points() {
            assert!((point.point_a.z - 1.0).abs() < 1e-6, "{point:?}");
            let [x, y, z] = point.local_b.to_array();
            assert!(x.hypot(y) < 1.0 + 1e-6 && (z + 1.0).abs() < 1e-6, "{point:?}");
        }
        for (flat, manifold) in flat.iter_mut().zip([&expected, &found]) {
            *flat += usize::from(manifold.points().len() >= 3);
        }
    }
    println!("manifolds of three points or more: {flat:?} of 200");
    assert!(flat[1] >= 100 && 10 * flat[1] >= 9 * flat[0], "{flat:?}");
    let mut feature = Feature::new();
    self::twins().iter().for_each(|twins| {
        let [_, lean] = twins.hulls();
        lean.feature_within(DVec3::Z, f64::INFINITY, &mut feature);
        assert!(!feature.corners().is_empty());
    });
}
