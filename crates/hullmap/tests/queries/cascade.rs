//! The stages of the cascade never change an answer, and each stage decides some of the pairs.

use glam::{DQuat, DVec3};
use hullmap::cascade::{self, OuterHulls, Stage, Stages};
use hullmap::{Cache, Overlap, Pack, Pose, SupportMap, intersects};
use hullmap_bake::{IndexKind, PointSet, bake_hull, write_pack};
use hullmap_testkit::packs::tree_pack;
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0x005e_ed07;

/// Hulls of all ranks: round, long and flat, at the origin of their frame or far from it.
fn packs() -> Vec<Pack> {
    let mut packs = vec![tree_pack(&[[0.1, 0.2, 0.3]]), tree_pack(&[[-0.5, 0.0, 0.1], [0.6, 0.3, 0.0]])];
    for (i, family) in Family::ALL.into_iter().enumerate() {
        for n in [20, 500] {
            let far = if i % 2 == 0 { 0.0 } else { 3.0 };
            let long = if i % 3 == 0 { 4.0 } else { 1.0 };
            let place = |p: &[f32; 3]| [p[0] + far, p[1] * long, p[2]];
            packs.push(tree_pack(&family.points(n, 1).iter().map(place).collect::<Vec<_>>()));
        }
    }
    packs
}

/// A pose in which the hulls overlap, nearly touch or are separated, with equal probability.
fn pose(a: &hullmap::Hull, b: &hullmap::Hull, rng: &mut SplitMix64) -> Pose {
    let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.3));
    let way = DVec3::from_array(rng.direction());
    let at = |far: f64| Pose::new(a.interior_point() + way * far - turn * b.interior_point(), turn).unwrap();
    let max_distance = a.outer_radius() + b.outer_radius();
    let (mut near, mut separated) = (0.0, max_distance);
    for _ in 0..20 {
        let middle = 0.5 * (near + separated);
        if intersects(a, b, at(middle), &mut Cache::new()).is_hit() { near = middle } else { separated = middle }
    }
    match rng.below(3) {
        0 => at(near * rng.between(0.1, 0.98)),
        1 => at(near * rng.between(0.98, 1.02)),
        _ => at(near + (max_distance * 1.1 - near) * rng.between(0.02, 1.0)),
    }
}

#[test]
fn cascade_never_changes_an_answer() {
    println!("seed {SEED:#x}");
    let packs = packs();
    let hulls: Vec<_> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let mut rng = SplitMix64::new(SEED);
    let all = Stages { boxes: true, outer: OuterHulls::Always };
    let (mut hits, mut total) = (0, 0);
    let mut decided = [[0; 4]; 2];
    for a in &hulls {
        for b in &hulls {
            for _ in 0..12 {
                let pose = pose(a, b, &mut rng);
                let full = intersects(a, b, pose, &mut Cache::new());
                hits += usize::from(full.is_hit());
                total += 1;
                for stages in [all, Stages::default(), Stages { boxes: false, outer: OuterHulls::Always }] {
                    let mut cache = Cache::new();
                    let cold = cascade::intersects(a, b, pose, stages, &mut cache);
                    let at = format!("{} {} {pose:?} {stages:?}: {cold:?} {full:?}", a.name(), b.name());
                    assert_eq!(cold.intersection.status, full.status, "{at}");
                    assert!(cold.stage != Stage::Boxes || stages.boxes, "{at}");
                    assert!(cold.stage != Stage::Outer || stages.outer == OuterHulls::Always, "{at}");
                    assert!(cold.stage == Stage::Full || cold.intersection.support_calls == 0, "{at}");
                    // The same query with a warm cache. An axis that a stage stored separates the
                    // hulls too.
                    let warm = cascade::intersects(a, b, pose, stages, &mut cache);
                    assert_eq!(warm.intersection.status, full.status, "{at} {warm:?}");
                    if full.status == Overlap::Separated && warm.stage == Stage::Full {
                        assert_eq!(warm.intersection.support_calls, 1, "{at} {warm:?}");
                    }
                    if stages == all {
                        decided[usize::from(full.is_hit())][cold.stage as usize] += 1;
                    }
                }
            }
        }
    }
    for (name, counts) in ["separated", "hits"].into_iter().zip(decided) {
        let sum: usize = counts.iter().sum();
        let [balls, boxes, outer, rest] = counts.map(|n| 100.0 * n as f64 / sum as f64);
        println!("{name}: balls {balls:.1} %, boxes {boxes:.1} %, outer hulls {outer:.1} %, hulls {rest:.1} %");
    }
    let share = hits as f64 / total as f64;
    assert!((0.3..0.7).contains(&share), "not representative: {share} of the pairs overlap");
    assert!(
        decided[0].iter().all(|n| *n > total / 100),
        "not representative: a stage decides too few pairs, {decided:?}"
    );
}

#[test]
fn outer_hulls_serve_only_large_hulls_without_an_index() {
    let points = Family::ClusteredEllipsoid.points(26_000, 1);
    let point_set = PointSet {
        name: "hull".into(),
        source_vertices: (0..points.len() as u32).collect(),
        positions: points,
        ..PointSet::default()
    };
    let mut rng = SplitMix64::new(SEED + 1);
    for (kind, expected) in [(IndexKind::Tree, false), (IndexKind::None, true)] {
        let baked = bake_hull(&point_set, kind).unwrap();
        let pack = Pack::from_bytes(&write_pack(&[baked], &Default::default()).unwrap()).unwrap();
        let hull = pack.hull(0).unwrap();
        let mut queried = 0;
        for _ in 0..100 {
            let pose = pose(&hull, &hull, &mut rng);
            let found = cascade::intersects(&hull, &hull, pose, Stages::default(), &mut Cache::new());
            assert_eq!(found.intersection.status, intersects(&hull, &hull, pose, &mut Cache::new()).status);
            queried += usize::from(found.stage == Stage::Outer);
        }
        assert_eq!(queried > 0, expected, "{kind:?}: {queried}");
    }
}

/// Boxes are their own bounding boxes, so a gap of a few ulps could mislead a stage.
#[test]
fn one_ulp_gap_between_boxes() {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
    let (pack, stages) = (tree_pack(&cube), Stages { boxes: true, outer: OuterHulls::Always });
    let hull = pack.hull(0).unwrap();
    for turn in [DQuat::IDENTITY, DQuat::from_rotation_z(0.3), DQuat::from_xyzw(0.1, 0.7, -0.2, 0.5).normalize()] {
        let way = turn * DVec3::Y;
        let low = SupportMap::support_point(&hull, turn.inverse() * -way).point;
        for ulps in -40..40 {
            let on = way * (1.0 + f64::from(ulps) * f64::EPSILON) - turn * low + DVec3::new(0.2, 0.0, 0.3);
            let pose = Pose::new(on, turn).unwrap();
            let full = intersects(&hull, &hull, pose, &mut Cache::new());
            let found = cascade::intersects(&hull, &hull, pose, stages, &mut Cache::new());
            assert_eq!(found.intersection.is_hit(), full.is_hit(), "{ulps}: {found:?} {full:?}");
        }
    }
}
