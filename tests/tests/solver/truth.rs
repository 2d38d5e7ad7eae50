//! Compares the solver on baked hulls of many kinds with the truth in f64. The program
//! `solver-truth` does the same for any number of pairs.

use glam::{DQuat, DVec3};
use hullmap::Pose;
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    depth::{signed_depth, signed_depth_by_points},
    gap::{distance_by_features, gap},
    packs,
    polytope::Polytope,
};
use hullmap_tests::truth::{
    scene::{Class, Detail, Scene},
    verdict::{Answers, Tally},
};

const SEED: u64 = 20_261_121;

/// Maximum share of intervals wider than the tolerance.
const WIDE_SHARE: f64 = 2e-3;

fn judged(pairs: u64, detail: Detail) -> Tally {
    let (mut scene, mut tally) = (Scene::new(SEED, detail), Tally::default());
    for index in 0..pairs {
        let (pair, bodies) = scene.pair(index);
        tally.judge(&pair, bodies, &Answers::to(&pair, bodies));
    }
    println!("seed {SEED}, {detail:?}\n{tally}");
    if let Some(miss) = tally.misses.first() {
        panic!("seed {SEED}, {detail:?}: {} misses, the first: {miss}", tally.misses.len());
    }
    assert!((0.4..=0.6).contains(&tally.overlapping()), "one-sided: {} overlap", tally.overlapping());
    assert!(tally.unsure * 7 < tally.pairs, "the sample is all about touching: {}", tally.unsure);
    let [of_touching, touching_hits] = tally.classes[&Class::Touching];
    assert!((of_touching / 4..=of_touching * 3 / 4).contains(&touching_hits), "{touching_hits} of {of_touching}");
    assert!(tally.loose_truths * 200 < tally.pairs, "{} distances with a loose truth", tally.loose_truths);
    for (wide, sure) in tally.wide.into_iter().zip(tally.sure) {
        assert!(wide as f64 <= WIDE_SHARE * sure as f64, "{wide} of {sure} intervals are wide");
        assert!(sure * 3 > tally.pairs, "{sure} of {} are sure", tally.pairs);
    }
    assert_eq!(tally.undecided, 0);
    tally
}

#[test]
fn many_kinds_of_hulls() {
    let tally = judged(6_000, Detail::Few);
    assert!(tally.twins.iter().all(|twins| *twins > 500), "{:?}", tally.twins);
    assert_eq!(tally.families.len(), 12, "{:?}", tally.families);
}

#[test]
fn detailed_hulls() {
    judged(30, Detail::Many);
}

#[test]
fn wrong_answers_are_misses() {
    let mut scene = Scene::new(SEED, Detail::Few);
    let (mut hits, mut apart) = (0, 0);
    for index in 0..300 {
        let (pair, bodies) = scene.pair(index);
        if pair.class == Class::Touching {
            continue;
        }
        let right = Answers::to(&pair, bodies);
        let misses = |change: &dyn Fn(&mut Answers)| {
            let (mut answers, mut tally) = (right, Tally::default());
            change(&mut answers);
            tally.judge(&pair, bodies, &answers);
            tally.misses.len()
        };
        assert_eq!(misses(&|_| {}), 0, "pair {index}");
        if right.deep.hit {
            hits += 1;
            assert!(misses(&|wrong| wrong.deep.hit = false) > 0, "pair {index}");
            let factors = [(1.0 - 1e-4, "small"), (1.0 + 1e-4, "large")];
            for (factor, what) in factors {
                let scaled = misses(&|wrong| {
                    let c = &mut wrong.deep;
                    (c.depth_lower, c.depth, c.depth_upper) =
                        (c.depth_lower * factor, c.depth * factor, c.depth_upper * factor);
                });
                assert!(scaled > 0, "pair {index}: a depth too {what}");
            }
        } else {
            apart += 1;
            assert!(misses(&|wrong| wrong.deep.normal = -wrong.deep.normal) > 0, "pair {index}");
            for factor in [1.0 - 1e-4, 1.0 + 1e-4] {
                let scaled = misses(&|wrong| {
                    let d = &mut wrong.near;
                    (d.lower, d.distance, d.upper) = (d.lower * factor, d.distance * factor, d.upper * factor);
                });
                assert!(scaled > 0, "pair {index}: a distance times {factor}");
            }
        }
    }
    assert!(hits >= 80 && apart >= 80, "{hits} {apart}");
}

#[test]
fn truth_of_two_cubes() {
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })).collect();
    let pack = packs::pack("cube", &corners, IndexKind::Tree);
    let cube = Polytope::new(&pack.hull(0).unwrap());
    assert_eq!((cube.points.len(), cube.normals.len(), cube.edges.len()), (8, 6, 12));
    let quarter = std::f64::consts::FRAC_PI_4;
    // A face, an edge and a vertex of B towards A.
    let turns = [
        (DQuat::IDENTITY, 1.0),
        (DQuat::from_rotation_z(quarter), 2.0_f64.sqrt()),
        (DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_X), 3.0_f64.sqrt()),
    ];
    for (turn, reach) in turns {
        for expected in [0.25, 1e-3, 1e-9, -1e-9, -1e-3, -0.5] {
            let b = cube.placed(Pose::new(DVec3::X * (1.0 + reach - expected), turn).unwrap());
            let (depth, normal) = signed_depth(&cube, &b, f64::NEG_INFINITY);
            assert!((depth - expected).abs() < 1e-14 && normal.distance(DVec3::X) < 1e-14, "{depth} {expected}");
            assert!((signed_depth_by_points(&cube.points, &b.points) - expected).abs() < 1e-14);
            let far = gap(&cube, &b);
            if expected < 0.0 {
                assert!(far.lower <= -expected + 1e-14 && -expected <= far.upper + 1e-14, "{far:?} {expected}");
                assert!(far.upper + expected < 1e-14, "{far:?} {expected}");
                assert!((distance_by_features(&cube.points, &b.points) + expected).abs() < 1e-14);
            } else {
                assert!(far.upper < 1e-14, "{far:?} {expected}");
            }
        }
    }
}

/// A polygon has a depth too: perpendicular to its plane.
#[test]
fn truth_of_a_square_through_a_cube() {
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })).collect();
    let square: Vec<[f32; 3]> = corners.iter().take(4).map(|p| [p[0] * 3.0, p[1] * 3.0, 0.0]).collect();
    let packs = [packs::pack("cube", &corners, IndexKind::Tree), packs::pack("square", &square, IndexKind::Tree)];
    let [cube, square] = packs.each_ref().map(|pack| Polytope::new(&pack.hull(0).unwrap()));
    assert_eq!((square.points.len(), square.normals.len(), square.edges.len()), (4, 6, 8));
    let pose = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.1, z)).unwrap();
    for (x, z, expected) in [(0.0, 0.25, 0.75), (3.5, 0.0, 0.5), (3.5, 0.75, 0.25), (4.125, 0.0, -0.125)] {
        let b = square.placed(pose(x, z));
        let (depth, _) = signed_depth(&cube, &b, f64::NEG_INFINITY);
        assert!((depth - expected).abs() < 1e-14, "{x} {z}: {depth}");
    }
}
