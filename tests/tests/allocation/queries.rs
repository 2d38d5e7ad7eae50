//! No query of the runtime allocates, with warm or cold caches. The allocator counts.

use std::hint::black_box;

use glam::{DQuat, DVec3, Vec3};
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Rounded, Scaled, Segment, Sphere, Triangle};
use hullmap::{
    Cache, CastSettings, Compound, CompoundManifolds, Feature, Hull, Manifold, ManifoldSettings, Minkowski, Motion,
    Pack, Pose, Ray, Settings, Shape, cast, contact, distance, intersects, ray, signed_distance,
};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{self, pack};
use hullmap_testkit::random::RandomPoses;
use shapes::{families::Family, rng::SplitMix64};

use crate::alone;

const SEED: u64 = 0xa110c;

/// Rounds of each query that are counted together.
const ROUNDS: usize = 300;

/// Number of allocations of `query` over all rounds, from the first call on.
fn allocations(mut query: impl FnMut(usize)) -> usize {
    crate::allocations(|| (0..ROUNDS).for_each(&mut query))
}

fn pose(rng: &mut SplitMix64) -> Pose {
    let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0) + 1e-9));
    Pose::new(rng.unit_vector() * rng.between(0.0, 2.5), rotation).unwrap()
}

#[test]
fn queries_allocate_nothing() {
    let _alone = alone();
    println!("seed {SEED:#x}");
    // Control: the counter counts an allocation.
    assert!(allocations(|_| drop(black_box(vec![0_u8; 100]))) >= ROUNDS);

    let opened: Vec<Pack> = packs::ALL_INDICES
        .into_iter()
        .flat_map(|index| {
            [Family::Rock, Family::RotatedPrism].map(|family| pack("hull", &family.points(400, 1), index))
        })
        .chain([pack("sheet", &Family::FlatSheet.points(30, 1), IndexKind::Tree)])
        .collect();
    let hulls: Vec<Hull<'_>> = opened.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let hull = hulls[0];
    let sets = [Family::Rock, Family::Cone, Family::CubeGrid].map(|family| {
        let moved = |p: [f32; 3]| [p[0] + family as u32 as f32, p[1], p[2]];
        packs::point_set("part", &family.points(40, 1).into_iter().map(moved).collect::<Vec<_>>())
    });
    let parts = packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap();
    let parts = Pack::from_bytes(&parts).unwrap();
    let mut shapes: Vec<Box<dyn Shape + Sync + '_>> = vec![
        Box::new(Sphere::new(0.8).unwrap()),
        Box::new(Cuboid::new(DVec3::new(0.5, 0.8, 1.0)).unwrap()),
        Box::new(Capsule::new(0.5, 0.3).unwrap()),
        Box::new(Cylinder::new(0.5, 0.7).unwrap()),
        Box::new(Cone::new(0.5, 0.7).unwrap()),
        Box::new(Capsule::between(DVec3::ZERO, DVec3::ONE, 0.2).unwrap()),
        Box::new(Segment::new(DVec3::NEG_X, DVec3::ONE).unwrap()),
        Box::new(Triangle::new([DVec3::X, DVec3::Y, DVec3::NEG_ONE]).unwrap()),
        Box::new(Rounded::new(hull, 0.1).unwrap()),
        Box::new(Scaled::new(hull, DVec3::new(-1.0, 0.5, 0.7)).unwrap()),
    ];
    hulls.iter().for_each(|hull| shapes.push(Box::new(*hull)));
    let mut rng = SplitMix64::new(SEED);
    let dirs: Vec<Vec3> = (0..ROUNDS).map(|_| rng.unit_vector().as_vec3()).collect();
    let poses: Vec<Pose> = (0..ROUNDS).map(|_| pose(&mut rng)).collect();
    let settings = Settings::default();
    let exact = Settings { tolerance: 0.0, ..settings };
    let hull_at = |i: usize| &hulls[i % hulls.len()];
    // All pairs of shapes occur, because the steps are coprime to the numbers of shapes and rounds.
    let pair_at = |i: usize| (&*shapes[i % shapes.len()], &*shapes[(i / shapes.len() + i) % shapes.len()]);
    let mut counts: Vec<(&str, usize)> = Vec::new();
    let mut count = |name: &'static str, found: usize| counts.push((name, found));
    // Counts the allocations of expressions of a round.
    macro_rules! count {
        ($name:literal, $i:ident: $($query:expr);+) => {
            count($name, allocations(|$i| { $(let _ = black_box($query);)+ }))
        };
    }
    let (wall, mut none) = (HalfSpace::new(DVec3::ONE, 0.2).unwrap(), Cache::new());
    let (mut on_wall, mut feature) = (vec![Manifold::new(); ROUNDS], Feature::new());
    let extremes = [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::MAX), Vec3::splat(1e-45)];
    count!("pack", _i: opened[0].hulls().map(|hull| hull.rank()).sum::<u32>());
    count!("support", i: hull_at(i).support(dirs[i]));
    count!("support_from", i: hull_at(i).support_from(dirs[i], i as u32));
    count!("support of extremes", i: hull_at(i).support(extremes[i % 4]));
    count!("support of shapes", i: pair_at(i).0.support_point(dirs[i].as_dvec3()));
    count!("facts", i:
        (hull_at(i).support_cost(dirs[i]), hull_at(i).face_towards(dirs[i].as_dvec3()));
        (hull_at(i).centroid(), hull_at(i).name(), hull_at(i).bounds());
        (hull_at(i).vertices().count(), hull_at(i).faces().map(|face| face.len()).sum::<usize>());
        (hull_at(i).neighbours(i as u32).count(), hull_at(i).faces_at(i as u32).count()));
    count!("half-space", i:
        intersects(&wall, pair_at(i).0, poses[i], &mut none);
        distance(pair_at(i).0, &wall, poses[i], &settings, &mut none);
        on_wall[i].update_half_space(&wall, pair_at(i).0, poses[i], &ManifoldSettings::default()));
    count!("bounds_under", i: pair_at(i).0.bounds_under(poses[i]).to_f32());
    count!("feature", i: pair_at(i).0.feature(dirs[i].as_dvec3(), &mut feature));
    count!("minkowski", i: Minkowski::new(pair_at(i).0, pair_at(i).1, poses[i]).support(dirs[i].as_dvec3()));
    for warm in [false, true] {
        let mut caches = vec![Cache::new(); ROUNDS];
        let mut each = |name: &'static str, query: &mut dyn FnMut(usize, &mut Cache)| {
            caches.iter_mut().for_each(Cache::clear);
            let found = allocations(|i| {
                if !warm {
                    caches[i].clear();
                }
                query(i, &mut caches[i]);
            });
            count(name, found);
        };
        each("intersects", &mut |i, cache| {
            black_box(intersects(pair_at(i).0, pair_at(i).1, poses[i], cache));
            black_box(intersects(hull_at(i), hull_at(i / 2), poses[i], cache));
        });
        each("contact", &mut |i, cache| {
            black_box(contact(pair_at(i).0, pair_at(i).1, poses[i], &settings, cache));
            black_box(contact(hull_at(i), hull_at(i / 2), poses[i], &exact, cache));
        });
        each("distance", &mut |i, cache| {
            black_box(distance(pair_at(i).0, pair_at(i).1, poses[i], &settings, cache));
            black_box(distance(hull_at(i), hull_at(i / 2), poses[i], &exact, cache));
        });
        each("rays, casts and points", &mut |i, cache| {
            let ((a, b), along) = (pair_at(i), dirs[i].as_dvec3());
            let motion = Motion::new(along).unwrap();
            for settings in [CastSettings::default(), CastSettings { tolerance: 0.0, ..CastSettings::default() }] {
                black_box(cast(a, b, poses[i], motion, &settings, cache));
                black_box(cast(hull_at(i), hull_at(i / 2), poses[i], motion, &settings, cache));
                black_box(ray(a, &Ray::new(poses[i].translation(), along).unwrap(), &settings));
            }
            black_box(signed_distance(a, poses[i].translation(), &exact, cache).unwrap());
        });
        let mut manifolds = vec![Manifold::new(); ROUNDS];
        each("manifold", &mut |i, cache| {
            let (a, b) = pair_at(i);
            black_box(manifolds[i].update(a, b, poses[i], &ManifoldSettings::default(), cache));
        });
    }
    let whole = Compound::new(&parts);
    let (mut cache, mut manifolds) = (Cache::with_pairs(8), CompoundManifolds::new(4));
    let (at_rest, limits) = (ManifoldSettings::default(), CastSettings::default());
    let motion = |i: usize| Motion::new(-poses[i].translation()).unwrap();
    count!("compound", i:
        intersects(&whole, pair_at(i).0, poses[i], &mut cache);
        distance(&whole, &whole, poses[i], &settings, &mut cache);
        contact(pair_at(i).0, &whole, poses[i], &settings, &mut cache);
        contact(&wall, &whole, poses[i], &settings, &mut cache);
        cast(&whole, pair_at(i).0, poses[i], motion(i), &limits, &mut cache);
        ray(&whole, &Ray::new(poses[i].translation(), DVec3::X).unwrap(), &limits);
        cast(&whole, &wall, poses[i], motion(i), &limits, &mut cache);
        signed_distance(&whole, poses[i].translation(), &settings, &mut cache).unwrap();
        manifolds.update(&whole, pair_at(i).0, poses[i], &at_rest);
        manifolds.update(&wall, &whole, poses[i], &at_rest);
        manifolds.update(&whole, &wall, poses[i], &at_rest);
        manifolds.iter_mut().count());
    println!("{counts:?}");
    let guilty: Vec<_> = counts.iter().filter(|(_, count)| *count > 0).collect();
    assert!(guilty.is_empty(), "allocations in {ROUNDS} calls: {guilty:?}");
    assert_eq!(counts.len(), 11 + 2 * 5);
}
