//! The stages before the solver never change an answer about two hulls in packs.

use glam::{DQuat, DVec3};
use hullmap::{Cache, Compound, Hull, Overlap, Pack, Pose, SupportMap, intersects};
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
fn pose(a: &Hull, b: &Hull, rng: &mut SplitMix64) -> Pose {
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
fn the_stages_never_change_an_answer() {
    println!("seed {SEED:#x}");
    let packs = packs();
    let hulls: Vec<_> = packs.iter().map(|pack| pack.hull(0).unwrap()).collect();
    let mut rng = SplitMix64::new(SEED);
    // Pairs by whether they hit, and by whether the solver was asked.
    let mut decided = [[0; 2]; 2];
    for a in &hulls {
        for b in &hulls {
            let parts = (Compound::from(*a), Compound::from(*b));
            for _ in 0..12 {
                let pose = pose(a, b, &mut rng);
                let full = intersects(a, b, pose, &mut Cache::new());
                let mut cache = Cache::with_pairs(1);
                let cold = intersects(&parts.0, &parts.1, pose, &mut cache);
                let at = format!("{} {} {pose:?}: {cold:?} {full:?}", a.name(), b.name());
                assert_eq!(cold.status, full.status, "{at}");
                // The same query with a warm cache. An axis that a stage stored separates the hulls
                // too.
                let warm = intersects(&parts.0, &parts.1, pose, &mut cache);
                assert_eq!(warm.status, full.status, "{at} {warm:?}");
                assert!(full.status != Overlap::Separated || warm.support_calls <= 1, "{at} {warm:?}");
                decided[usize::from(full.is_hit())][usize::from(cold.support_calls > 0)] += 1;
            }
        }
    }
    println!("decided by boxes or balls, and by the hulls: {decided:?}");
    let [separated, hits] = decided.map(|counts| counts.iter().sum::<i32>());
    assert!((3 * separated..7 * (separated + hits)).contains(&(10 * hits)), "not representative: {decided:?}");
    assert!(decided.as_flattened().iter().all(|n| *n > (separated + hits) / 100), "not representative: {decided:?}");
}

/// Boxes are their own bounding boxes, so a gap of a few ulps could mislead a stage.
#[test]
fn one_ulp_gap_between_boxes() {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
    let pack = tree_pack(&cube);
    let hull = pack.hull(0).unwrap();
    for turn in [DQuat::IDENTITY, DQuat::from_rotation_z(0.3), DQuat::from_xyzw(0.1, 0.7, -0.2, 0.5).normalize()] {
        let way = turn * DVec3::Y;
        let low = SupportMap::support_point(&hull, turn.inverse() * -way).point;
        for ulps in -40..40 {
            let on = way * (1.0 + f64::from(ulps) * f64::EPSILON) - turn * low + DVec3::new(0.2, 0.0, 0.3);
            let pose = Pose::new(on, turn).unwrap();
            let full = intersects(&hull, &hull, pose, &mut Cache::new());
            let found = intersects(&pack, &pack, pose, &mut Cache::with_pairs(1));
            assert_eq!(found.is_hit(), full.is_hit(), "{ulps}: {found:?} {full:?}");
        }
    }
}
