//! Compares the solver with parry3d (in f64) on baked hulls, in seeded poses of many pairs:
//! intersection, depth and distance.

use glam::{DQuat, DVec3};
use hullmap::{Cache, Overlap, Pack, Pose, Settings, contact, distance, intersects};
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, hull, write_pack};
use hullmap_engine_tests as parry;
use hullmap_testkit::faceless::Faceless;
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_121;

/// Poses of each pair: a third penetrating, a third nearly touching, a third separated.
const POSES: usize = 1_300;

/// Depth or distance, relative to the sum of the diameters, below which parry and the solver may
/// disagree on intersection.
const UNSURE: f64 = 1e-4;

/// Error of parry's own depths and distances, relative to the size. Measurements found up to 2e-3.
const PARRY_ERROR: f64 = 3e-3;

fn bake(family: Family, n: usize, stretch: [f32; 3]) -> Pack {
    let positions: Vec<[f32; 3]> =
        family.points(n, SEED).iter().map(|p| [p[0] * stretch[0], p[1] * stretch[1], p[2] * stretch[2]]).collect();
    let source_vertices = (0..positions.len() as u32).collect();
    let points = PointSet { name: family.name().to_owned(), positions, source_vertices, ..PointSet::default() };
    let baked = bake_hull(&points, IndexKind::Tree).unwrap();
    Pack::from_bytes(&write_pack(&[baked], &SourceRecord::default()).unwrap()).unwrap()
}

#[derive(Default)]
struct Tally {
    pairs: usize,
    overlapping: usize,
    unsure: usize,
    depths: usize,
    distances: usize,
    worst_depth: f64,
    worst_distance: f64,
}

#[test]
fn yes_no_depth_and_distance_agree() {
    let one = [1.0; 3];
    let pairs = [
        (bake(Family::Rock, 60, one), bake(Family::Sphere, 40, one)),
        (bake(Family::Sphere, 300, one), bake(Family::ClusteredEllipsoid, 200, one)),
        (bake(Family::CubeGrid, 27, one), bake(Family::CubeGrid, 8, [0.5; 3])),
        (bake(Family::Prism, 40, one), bake(Family::Cone, 33, one)),
        (bake(Family::Lens, 100, one), bake(Family::Rock, 100, one)),
        (bake(Family::RotatedPrism, 64, one), bake(Family::UvSphere, 120, one)),
        (bake(Family::Rock, 50, [1.0, 1.0, 0.05]), bake(Family::Sphere, 50, [0.02, 1.0, 0.3])),
        (bake(Family::Rock, 80, [100.0; 3]), bake(Family::Cone, 20, one)),
    ];
    let mut rng = SplitMix64::new(SEED);
    let mut tally = Tally::default();
    for (pack_a, pack_b) in &pairs {
        check_pair(pack_a, pack_b, &mut rng, &mut tally);
    }
    let overlapping = tally.overlapping as f64 / tally.pairs as f64;
    println!(
        "{} poses, {:.0} % overlap, {} within {UNSURE:e} of touching; {} depths, worst difference {:.1e}; \
         {} distances, worst difference {:.1e} of the size",
        tally.pairs,
        overlapping * 100.0,
        tally.unsure,
        tally.depths,
        tally.worst_depth,
        tally.distances,
        tally.worst_distance,
    );
    assert!(tally.pairs >= 10_000);
    assert!((0.3..=0.7).contains(&overlapping), "the sample is one-sided: {overlapping}");
    assert!(tally.unsure < tally.pairs / 10, "the sample is all about touching");
}

fn check_pair(pack_a: &Pack, pack_b: &Pack, rng: &mut SplitMix64, tally: &mut Tally) {
    let (a, b) = (pack_a.hull(0).unwrap(), pack_b.hull(0).unwrap());
    let (parry_a, parry_b) = (parry::polyhedron(&a), parry::polyhedron(&b));
    let size = a.diameter() + b.diameter();
    let settings = Settings::default();
    // One cache for all poses: it may change the cost, never the answer.
    let mut cache = Cache::default();
    for index in 0..POSES {
        let rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
        let direction = DVec3::from_array(rng.direction());
        let at = |reach: f64| Pose::new(a.centroid() - rotation * b.centroid() + direction * reach, rotation).unwrap();
        // The touching distance along the direction.
        let (mut inside, mut outside) = (0.0, size);
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            if parry::overlap(&parry_a, &parry_b, at(middle)) { inside = middle } else { outside = middle }
        }
        let share = match index % 3 {
            0 => rng.between(0.0, 0.9),
            1 => rng.between(0.98, 1.02),
            _ => rng.between(1.05, 2.0),
        };
        let pose = at(inside * share);
        let what = format!("{} / {}, pose {index}, seed {SEED}: {pose:?}", a.name(), b.name());
        let truth = parry::opinion(&parry_a, &parry_b, pose);
        let signed = truth.signed_distance.unwrap_or(truth.distance);
        let hit = intersects(&a, &b, pose, &mut cache);
        let touch = contact(&a, &b, pose, &settings, &mut cache);
        let gap = distance(&a, &b, pose, &settings, &mut cache);
        tally.pairs += 1;
        tally.overlapping += usize::from(truth.intersects);
        if signed.abs() <= UNSURE * size {
            tally.unsure += 1;
            continue;
        }
        assert_ne!(hit.status, Overlap::Undecided, "{what}");
        assert_eq!(hit.is_hit(), truth.intersects, "{what}: parry {truth:?}");
        assert_eq!(touch.hit, truth.intersects, "{what}: parry {truth:?}");
        assert!((touch.normal.length() - 1.0).abs() < 1e-12, "{what}");
        if truth.intersects {
            let difference = (touch.depth + signed) / size;
            // parry's EPA may stop at a face that is not the nearest. Its depth is then larger.
            assert!(difference < PARRY_ERROR, "{what}: depth {} against parry's {}", touch.depth, -signed);
            assert!(touch.depth_lower <= touch.depth && touch.depth <= touch.depth_upper, "{what}");
            assert_eq!(gap.distance, 0.0, "{what}");
            // Moving B by the depth along the normal separates them.
            let moved = Pose::new(pose.translation() + touch.normal * (touch.depth_upper + 1e-9 * size), rotation);
            assert!(!intersects(&a, &b, moved.unwrap(), &mut Cache::default()).is_hit(), "{what}: {touch:?}");
            tally.depths += 1;
            tally.worst_depth = tally.worst_depth.max(difference.abs());
        } else {
            let difference = (gap.distance - truth.distance).abs() / size;
            assert!(difference < PARRY_ERROR, "{what}: distance {} against parry's {}", gap.distance, truth.distance);
            assert!(gap.lower <= gap.distance && gap.distance <= gap.upper, "{what}");
            assert!((gap.point_a.distance(gap.point_b) - gap.distance).abs() < 1e-9 * size, "{what}");
            tally.distances += 1;
            tally.worst_distance = tally.worst_distance.max(difference);
        }
    }
}

/// Maximum ratio of support calls with the cache of the previous frame to calls without it: for
/// contact, distance and intersection.
const WARM_SHARES: [f64; 3] = [0.5, 0.65, 0.9];

/// Each frame moves B by 1 % of the diameter and 1°. The answers equal a cold start's, at a
/// fraction of its cost. Contacts are counted against the general path: the separating axis test of
/// small hulls takes few support calls from any start.
#[test]
fn consecutive_frames_are_cheap() {
    let settings = Settings::default();
    let mut rng = SplitMix64::new(SEED);
    let one = [1.0; 3];
    for n in [8, 32, 128, 512, 2048] {
        let packs =
            [bake(Family::Sphere, n, one), bake(Family::ClusteredEllipsoid, n, one), bake(Family::Rock, n, one)];
        let hulls = packs.each_ref().map(|pack| pack.hull(0).unwrap());
        let mut calls = [[0_u32; 2]; 3];
        let (mut hits, mut frames) = (0, 0);
        for pair in 0..12 {
            let (a, b) = (&hulls[pair % 3], &hulls[pair / 3 % 3]);
            let size = 0.5 * (a.diameter() + b.diameter());
            let (axis, beside) = (DVec3::from_array(rng.direction()), DVec3::from_array(rng.direction()) * 0.2);
            let from = DVec3::from_array(rng.direction());
            let mut rotation = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
            let mut caches = [(); 3].map(|()| Cache::default());
            for frame in 0..160 {
                rotation = (DQuat::from_axis_angle(axis, 1_f64.to_radians()) * rotation).normalize();
                let offset = (from * (1.4 - 0.01 * f64::from(frame)) + beside) * size;
                let pose = Pose::new(a.centroid() - rotation * b.centroid() + offset, rotation).unwrap();
                let what = format!("{} / {}, n {n}, pair {pair}, frame {frame}, seed {SEED}", a.name(), b.name());

                let warm = contact(a, b, pose, &settings, &mut caches[0]);
                let general = contact(&Faceless(*a), &Faceless(*b), pose, &settings, &mut Cache::default());
                for cold in [contact(a, b, pose, &settings, &mut Cache::default()), general] {
                    assert_eq!(warm.hit, cold.hit, "{what}: {warm:?} {cold:?}");
                    let meet = warm.depth_lower <= cold.depth_upper && cold.depth_lower <= warm.depth_upper;
                    assert!(meet, "{what}: {warm:?} {cold:?}");
                }
                let cold = general;
                calls[0] = [calls[0][0] + warm.support_calls, calls[0][1] + cold.support_calls];
                (hits, frames) = (hits + usize::from(cold.hit), frames + 1);

                let warm = distance(a, b, pose, &settings, &mut caches[1]);
                let cold = distance(a, b, pose, &settings, &mut Cache::default());
                assert!(warm.lower <= cold.upper && cold.lower <= warm.upper, "{what}: {warm:?} {cold:?}");
                calls[1] = [calls[1][0] + warm.support_calls, calls[1][1] + cold.support_calls];

                let warm = intersects(a, b, pose, &mut caches[2]);
                let cold = intersects(a, b, pose, &mut Cache::default());
                assert_eq!(warm.is_hit(), cold.is_hit(), "{what}: {warm:?} {cold:?}");
                calls[2] = [calls[2][0] + warm.support_calls, calls[2][1] + cold.support_calls];
            }
        }
        let share = hits as f64 / frames as f64;
        assert!((0.3..=0.8).contains(&share), "n {n}: the sample is one-sided: {share}");
        let shares = calls.map(|[warm, cold]| f64::from(warm) / f64::from(cold));
        println!("n {n}: {hits} of {frames} frames overlap; support calls, warm over cold {shares:.2?}");
        assert!(shares.iter().zip(WARM_SHARES).all(|(share, max)| *share <= max), "n {n}: {shares:?}");
    }
}

#[test]
fn two_cubes_and_a_point() {
    let cube = bake(Family::CubeGrid, 8, [1.0; 3]);
    let cube = cube.hull(0).unwrap();
    let side = f64::from(cube.bounds()[1].x - cube.bounds()[0].x);
    let point = {
        let points = PointSet {
            name: "point".into(),
            positions: vec![[0.0; 3]],
            source_vertices: vec![0],
            ..PointSet::default()
        };
        let baked = bake_hull(&points, IndexKind::Tree).unwrap();
        Pack::from_bytes(&write_pack(&[baked], &SourceRecord::default()).unwrap()).unwrap()
    };
    let point = point.hull(0).unwrap();
    let settings = Settings::default();
    let shifted = |x: f64, y: f64, z: f64| Pose::from_translation(DVec3::new(x, y, z)).unwrap();
    for share in [0.05, 0.4, 0.75, 0.95] {
        let c = contact(&cube, &cube, shifted(share * side, 0.0, 0.0), &settings, &mut Cache::default());
        assert!(c.hit && (c.depth - (1.0 - share) * side).abs() < 1e-6 * side, "{share}: {c:?}");
        assert!((c.normal - DVec3::X).length() < 1e-6, "{share}: {c:?}");
        let d = distance(&cube, &cube, shifted(0.0, (1.0 + share) * side, 0.0), &settings, &mut Cache::default());
        assert!((d.distance - share * side).abs() < 1e-6 * side && (d.normal - DVec3::Y).length() < 1e-6, "{d:?}");
        let centre = cube.centroid();
        let inside = centre + DVec3::new(0.0, 0.0, 0.5 * share * side);
        let c = contact(&cube, &point, shifted(inside.x, inside.y, inside.z), &settings, &mut Cache::default());
        assert!(c.hit && (c.depth - 0.5 * (1.0 - share) * side).abs() < 1e-6 * side, "{share}: {c:?}");
        let corner = centre + DVec3::splat(0.5 * side) + DVec3::splat(share);
        let d = distance(&cube, &point, shifted(corner.x, corner.y, corner.z), &settings, &mut Cache::default());
        assert!((d.distance - share * 3_f64.sqrt()).abs() < 1e-6 * side, "{share}: {d:?}");
    }
}

/// Families whose points are either inside or extreme by more than parry's tolerances.
#[test]
fn parry_finds_the_same_hull_vertices() {
    for family in [Family::Sphere, Family::Ball, Family::Rock, Family::Prism, Family::Cone, Family::Lens] {
        let positions = family.points(400, 8);
        let points: Vec<DVec3> = positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let source_vertices = (0..positions.len() as u32).collect();
        let set = PointSet { positions, source_vertices, ..PointSet::default() };
        let bits = |p: DVec3| p.to_array().map(|c| (c + 0.0).to_bits());
        let mut ours: Vec<_> = hull::build(&set).unwrap().positions().into_iter().map(bits).collect();
        let (theirs, _) = parry3d_f64::transformation::try_convex_hull(&points).expect("parry builds a hull");
        let mut theirs: Vec<_> = theirs.into_iter().map(bits).collect();
        ours.sort_unstable();
        theirs.sort_unstable();
        assert!(ours.len() > 40);
        assert_eq!(ours, theirs, "{}", family.name());
    }
}
