//! Packs and pairs for the tests, and the device on which they run.

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Cache, Pack, Pose, Settings, SupportMap};
use hullmap_bake::IndexKind;
use hullmap_testkit::{packs, random::RandomPoses};
use hullmap_wgpu::{Device, IndexedPair};
use shapes::{families, rng::SplitMix64};

/// The device, or `None` if there is none. `HULLMAP_REQUIRE_GPU=1` makes that a failure.
pub fn device() -> Option<Device> {
    match Device::open() {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("HULLMAP_REQUIRE_GPU").is_some_and(|value| value == "1") => panic!("{error}"),
        Err(error) => {
            println!("skipped: no Vulkan device ({error})");
            None
        }
    }
}

/// The device as it is, and with kernels that round as fused operations do; none if there is none.
pub fn devices() -> Vec<Device> {
    let plain = device();
    let fused = plain.is_some().then(|| Device::open_fused().expect("it compiles the kernels"));
    plain.into_iter().chain(fused).collect()
}

/// Number of pairs of a test, which `HULLMAP_GPU_PAIRS` overrides.
pub fn pair_count(default: usize) -> usize {
    std::env::var("HULLMAP_GPU_PAIRS").ok().and_then(|count| count.parse().ok()).unwrap_or(default)
}

/// Hulls of every rank, from 1 to 2,000 vertices: smooth ones, ones with large facets, thin ones.
pub fn pack(index: IndexKind) -> Pack {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| 2.0 * c as f32 - 1.0)).collect();
    let far: Vec<[f32; 3]> = families::rock(100, 3).iter().map(|p| p.map(|c| c + 100.0)).collect();
    let sets = [
        cube,
        families::sphere(12, 1),
        families::sphere(2000, 2),
        families::rock(300, 3),
        families::prism(256, 4),
        families::rotated_prism(512, 5),
        families::cone(200, 6),
        families::lens(400, 7),
        families::needle(60, 8),
        families::flat_sheet(40, 9),
        far,
        vec![[0.0, 0.0, 0.0], [1.0, 2.0, 2.0]],
        vec![[0.5, 0.25, 0.125]],
    ];
    let sets: Vec<_> = sets.iter().map(|positions| packs::point_set("hull", positions)).collect();
    let bytes = packs::bytes(&sets, index, &Default::default()).expect("the families can be baked");
    Pack::from_bytes(&bytes).expect("a baked pack opens")
}

/// Solids of few edges, so that brute force can look at all facets of a Minkowski difference.
pub fn small_pack() -> Pack {
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| 2.0 * c as f32 - 1.0)).collect();
    let sets = [cube, families::sphere(12, 1), families::rock(40, 3), families::prism(16, 4), families::cone(12, 6)];
    let sets: Vec<_> = sets.iter().map(|positions| packs::point_set("hull", positions)).collect();
    let bytes = packs::bytes(&sets, IndexKind::Tree, &Default::default()).expect("the families can be baked");
    Pack::from_bytes(&bytes).expect("a baked pack opens")
}

/// Hulls of many vertices. The base of the cone is a fan of thousands of steps: near its axis, a
/// query reads more than a pair may.
pub fn large_pack() -> Pack {
    let sets = [families::cone(20_000, 1), families::sphere(20_000, 2), families::lens(3_000, 3)];
    let sets: Vec<_> = sets.iter().map(|positions| packs::point_set("hull", positions)).collect();
    let bytes = packs::bytes(&sets, IndexKind::Tree, &Default::default()).expect("the families can be baked");
    Pack::from_bytes(&bytes).expect("a baked pack opens")
}

/// Random pairs of the hulls of `pack`, with centres at up to 1.3 times the sum of the radii. One
/// in four has axes that are parallel, so that faces and edges are, too.
pub fn pairs(pack: &Pack, count: usize, seed: u64) -> Vec<IndexedPair> {
    let mut rng = SplitMix64::new(seed);
    let hulls: Vec<_> = (0..pack.hull_count()).map(|index| pack.hull(index).expect("in range")).collect();
    let pair = |at: usize| {
        let (a, b) = (rng.below(hulls.len()), rng.below(hulls.len()));
        let rotation = if at.is_multiple_of(4) { DQuat::IDENTITY } else { rng.rotation() };
        let reach = hulls[a].outer_radius() + hulls[b].outer_radius();
        let mut apart = rng.unit_vector() * rng.between(0.0, 1.3 * reach);
        if at.is_multiple_of(8) {
            apart = DVec3::new(apart.x.round(), apart.y.round(), apart.z.round());
        }
        let translation = hulls[a].interior_point() + apart - rotation * hulls[b].interior_point();
        IndexedPair { a: a as u32, b: b as u32, b_in_a: Pose::new(translation, rotation).expect("finite") }
    };
    (0..count).map(pair).collect()
}

/// Pairs that only just touch, overlap or miss: random ones that are apart, moved by their
/// distance, and a little more or less.
pub fn touching_pairs(pack: &Pack, count: usize, seed: u64) -> Vec<IndexedPair> {
    const MORE: [f64; 7] = [0.0, 1e-8, -1e-8, 1e-6, -1e-6, 1e-4, -1e-4];
    let touch = |(at, pair): (usize, IndexedPair)| {
        let hull = |index: u32| pack.hull(index as usize).expect("in range");
        let (a, b) = (hull(pair.a), hull(pair.b));
        let found = hullmap::distance(&a, &b, pair.b_in_a, &Settings::default(), &mut Cache::new());
        let more = MORE[at % MORE.len()] * (a.outer_radius() + b.outer_radius());
        let translation = pair.b_in_a.translation() - found.normal * (found.lower + more);
        (found.lower > 0.0).then(|| moved(&pair, translation))
    };
    // About half of the random pairs are apart.
    pairs(pack, 3 * count, seed).into_iter().enumerate().filter_map(touch).take(count).collect()
}

/// The pairs a moment later: turned and moved by a hundredth.
pub fn a_frame_later(pairs: &[IndexedPair], seed: u64) -> Vec<IndexedPair> {
    let mut rng = SplitMix64::new(seed);
    let later = |pair: &IndexedPair| {
        let turn = DQuat::from_axis_angle(rng.unit_vector(), 0.01);
        let translation = pair.b_in_a.translation() + rng.unit_vector() * 0.01;
        IndexedPair { b_in_a: Pose::new(translation, turn * pair.b_in_a.rotation()).expect("finite"), ..*pair }
    };
    pairs.iter().map(later).collect()
}

fn moved(pair: &IndexedPair, translation: DVec3) -> IndexedPair {
    IndexedPair { b_in_a: Pose::new(translation, pair.b_in_a.rotation()).expect("finite"), ..*pair }
}
