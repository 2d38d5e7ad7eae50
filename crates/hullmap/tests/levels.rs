//! Levels of detail never change an answer, and each decides its share.

use glam::{DQuat, DVec3};
use hullmap::levels::{self, Level, Levels, OuterHulls};
use hullmap::{Cache, Overlap, Pack, Pose, SupportMap, intersects};
use hullmap_bake::{IndexKind, PointSet, bake_hull, write_pack};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 0x005e_ed07;

fn pack(positions: &[[f32; 3]]) -> Pack {
    let source_vertices = (0..positions.len() as u32).collect();
    let points =
        PointSet { name: "hull".into(), positions: positions.to_vec(), source_vertices, ..PointSet::default() };
    let baked = bake_hull(&points, IndexKind::TREE).unwrap();
    Pack::from_bytes(&write_pack(&[baked], &Default::default()).unwrap()).unwrap()
}

/// Hulls of all ranks, far from their origin or at it, round, long and flat.
fn packs() -> Vec<Pack> {
    let mut packs = vec![pack(&[[0.1, 0.2, 0.3]]), pack(&[[-0.5, 0.0, 0.1], [0.6, 0.3, 0.0]])];
    for (i, family) in Family::ALL.into_iter().enumerate() {
        for n in [20, 500] {
            let far = if i % 2 == 0 { 0.0 } else { 3.0 };
            let long = if i % 3 == 0 { 4.0 } else { 1.0 };
            let place = |p: &[f32; 3]| [p[0] + far, p[1] * long, p[2]];
            packs.push(pack(&family.points(n, 1).iter().map(place).collect::<Vec<_>>()));
        }
    }
    packs
}

/// A pose in which the hulls overlap, touch nearly or are apart: a third each.
fn pose(a: &hullmap::Hull, b: &hullmap::Hull, rng: &mut SplitMix64) -> Pose {
    let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.3));
    let way = DVec3::from_array(rng.direction());
    let at = |far: f64| Pose::new(a.interior_point() + way * far - turn * b.interior_point(), turn).unwrap();
    let most = a.outer_radius() + b.outer_radius();
    let (mut near, mut apart) = (0.0, most);
    for _ in 0..20 {
        let middle = 0.5 * (near + apart);
        if intersects(a, b, at(middle), &mut Cache::new()).is_hit() { near = middle } else { apart = middle }
    }
    match rng.below(3) {
        0 => at(near * rng.between(0.1, 0.98)),
        1 => at(near * rng.between(0.98, 1.02)),
        _ => at(near + (most * 1.1 - near) * rng.between(0.02, 1.0)),
    }
}

#[test]
fn levels_never_change_an_answer() {
    println!("seed {SEED:#x}");
    let packs = packs();
    let hulls: Vec<_> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let mut rng = SplitMix64::new(SEED);
    let all = Levels { boxes: true, outer: OuterHulls::Always };
    let (mut hits, mut total) = (0, 0);
    let mut decided = [[0; 4]; 2];
    for a in &hulls {
        for b in &hulls {
            for _ in 0..12 {
                let pose = pose(a, b, &mut rng);
                let full = intersects(a, b, pose, &mut Cache::new());
                hits += usize::from(full.is_hit());
                total += 1;
                for levels in [all, Levels::default(), Levels { boxes: false, outer: OuterHulls::Always }] {
                    let mut cache = Cache::new();
                    let cold = levels::intersects(a, b, pose, levels, &mut cache);
                    let at = format!("{} {} {pose:?} {levels:?}: {cold:?} {full:?}", a.name(), b.name());
                    assert_eq!(cold.intersection.status, full.status, "{at}");
                    assert!(cold.level != Level::Boxes || levels.boxes, "{at}");
                    assert!(cold.level != Level::Outer || levels.outer == OuterHulls::Always, "{at}");
                    assert!(cold.level == Level::Full || cold.intersection.support_calls == 0, "{at}");
                    // Once more, with what it remembers; the axis that a level kept separates the hulls too.
                    let warm = levels::intersects(a, b, pose, levels, &mut cache);
                    assert_eq!(warm.intersection.status, full.status, "{at} {warm:?}");
                    if full.status == Overlap::Separated && warm.level == Level::Full {
                        assert_eq!(warm.intersection.support_calls, 1, "{at} {warm:?}");
                    }
                    if levels == all {
                        decided[usize::from(full.is_hit())][cold.level as usize] += 1;
                    }
                }
            }
        }
    }
    for (name, counts) in ["apart", "hits"].into_iter().zip(decided) {
        let sum: usize = counts.iter().sum();
        let [balls, boxes, outer, rest] = counts.map(|n| 100.0 * n as f64 / sum as f64);
        println!("{name}: balls {balls:.1} %, boxes {boxes:.1} %, outer hulls {outer:.1} %, hulls {rest:.1} %");
    }
    let share = hits as f64 / total as f64;
    assert!((0.3..0.7).contains(&share), "not representative: {share} of the pairs overlap");
    assert!(decided[0].iter().all(|n| *n > total / 100), "each level has its share: {decided:?}");
}

/// By default outer hulls are asked of large hulls without an index, and of those alone.
#[test]
fn outer_hulls_are_asked_where_they_are_cheaper() {
    let points = Family::ClusteredEllipsoid.points(26_000, 1);
    let point_set = PointSet {
        name: "hull".into(),
        source_vertices: (0..points.len() as u32).collect(),
        positions: points,
        ..PointSet::default()
    };
    let mut rng = SplitMix64::new(SEED + 1);
    for (kind, expected) in [(IndexKind::TREE, false), (IndexKind::None, true)] {
        let baked = bake_hull(&point_set, kind).unwrap();
        let pack = Pack::from_bytes(&write_pack(&[baked], &Default::default()).unwrap()).unwrap();
        let hull = pack.hull(0).unwrap();
        let mut asked = 0;
        for _ in 0..100 {
            let pose = pose(&hull, &hull, &mut rng);
            let found = levels::intersects(&hull, &hull, pose, Levels::default(), &mut Cache::new());
            assert_eq!(found.intersection.status, intersects(&hull, &hull, pose, &mut Cache::new()).status);
            asked += usize::from(found.level == Level::Outer);
        }
        assert_eq!(asked > 0, expected, "{kind:?}: {asked}");
    }
}

/// Where a level alone could go wrong: gaps of a hair's breadth between boxes that are the hulls.
#[test]
fn one_ulp_gap_between_boxes() {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
    let (pack, levels) = (pack(&cube), Levels { boxes: true, outer: OuterHulls::Always });
    let hull = pack.hull(0).unwrap();
    for turn in [DQuat::IDENTITY, DQuat::from_rotation_z(0.3), DQuat::from_xyzw(0.1, 0.7, -0.2, 0.5).normalize()] {
        let way = turn * DVec3::Y;
        let low = SupportMap::support(&hull, turn.inverse() * -way).point;
        for ulps in -40..40 {
            let on = way * (1.0 + f64::from(ulps) * f64::EPSILON) - turn * low + DVec3::new(0.2, 0.0, 0.3);
            let pose = Pose::new(on, turn).unwrap();
            let full = intersects(&hull, &hull, pose, &mut Cache::new());
            let found = levels::intersects(&hull, &hull, pose, levels, &mut Cache::new());
            assert_eq!(found.intersection.is_hit(), full.is_hit(), "{ulps}: {found:?} {full:?}");
        }
    }
}
