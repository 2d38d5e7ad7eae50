//! Throughput of batches on one and on all threads, and the gain from each stage of the cascade.
//!
//!     cargo run --release --example throughput --package hullmap-bench --features parallel
//!
//! Each time is the minimum over many short runs. The variants run in turn, so that other load on
//! the machine affects them equally.

use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use hullmap::batch::{self, Pair};
use hullmap::cascade::{self, OuterHulls, Stage, Stages};
use hullmap::{Cache, Contact, Hull, Manifold, ManifoldSettings, Pack, Pose, Settings, SupportMap, intersects};
use hullmap_bake::{IndexKind, PointSet, bake_hull, write_pack};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 7;
const PAIRS: usize = 2_000;
const RUNS: usize = 200;

fn pack(positions: &[[f32; 3]], index: IndexKind) -> Result<Pack, Box<dyn std::error::Error>> {
    let source_vertices = (0..positions.len() as u32).collect();
    let points =
        PointSet { name: "hull".into(), positions: positions.to_vec(), source_vertices, ..PointSet::default() };
    let baked = bake_hull(&points, index)?;
    Ok(Pack::from_bytes(&write_pack(&[baked], &Default::default())?)?)
}

/// Random pairs. `reach` is the maximum distance between interior points, relative to the sum of
/// the outer radii.
fn pairs<'s, 'p>(hulls: &'s [Hull<'p>], reach: f64) -> Result<Vec<Pair<'s, Hull<'p>, Hull<'p>>>, hullmap::PoseError> {
    let mut rng = SplitMix64::new(SEED);
    (0..PAIRS)
        .map(|_| {
            let (a, b) = (&hulls[rng.below(hulls.len())], &hulls[rng.below(hulls.len())]);
            let turn = DQuat::from_axis_angle(DVec3::from_array(rng.direction()), rng.between(0.0, 6.3));
            let far =
                DVec3::from_array(rng.direction()) * rng.between(0.0, reach) * (a.outer_radius() + b.outer_radius());
            let b_in_a = Pose::new(a.interior_point() + far - turn * b.interior_point(), turn)?;
            Ok(Pair { a, b, b_in_a })
        })
        .collect()
}

/// Minimum time of each of `variants`, which run in turn.
fn min_times<const N: usize>(mut variants: [Box<dyn FnMut() + '_>; N]) -> [Duration; N] {
    let mut min = [Duration::MAX; N];
    for _ in 0..RUNS {
        for (variant, min) in variants.iter_mut().zip(&mut min) {
            let start = Instant::now();
            variant();
            *min = start.elapsed().min(*min);
        }
    }
    min
}

fn threads(hulls: &[Hull], cores: usize) -> Result<(), Box<dyn std::error::Error>> {
    let pairs = pairs(hulls, 0.7)?;
    let (one, all) = (
        rayon::ThreadPoolBuilder::new().num_threads(1).build()?,
        rayon::ThreadPoolBuilder::new().num_threads(cores).build()?,
    );
    let settings = Settings::default();
    let contact = |pool: &rayon::ThreadPool| {
        let (mut caches, mut out) = (vec![Cache::new(); PAIRS], vec![Contact::default(); PAIRS]);
        pool.install(|| batch::contact(&pairs, &settings, &mut caches, &mut out)).expect("equal lengths");
    };
    let manifold = |pool: &rayon::ThreadPool| {
        let (mut caches, mut out) = (vec![Cache::new(); PAIRS], vec![Manifold::new(); PAIRS]);
        pool.install(|| batch::manifolds(&pairs, &ManifoldSettings::default(), &mut caches, &mut out))
            .expect("equal lengths");
    };
    let times = min_times([
        Box::new(|| contact(&one)),
        Box::new(|| contact(&all)),
        Box::new(|| manifold(&one)),
        Box::new(|| manifold(&all)),
    ]);
    let [a, b, c, d] = times.map(|t| t.as_secs_f64() / PAIRS as f64 * 1e9);
    println!("contact:  {a:6.0} ns per pair on 1 thread, {b:6.0} on {cores}: speedup {:.2}", a / b);
    println!("manifold: {c:6.0} ns per pair on 1 thread, {d:6.0} on {cores}: speedup {:.2}", c / d);
    Ok(())
}

fn cascade_stages(hulls: &[Hull]) -> Result<(), Box<dyn std::error::Error>> {
    for reach in [0.7, 1.2] {
        let pairs = pairs(hulls, reach)?;
        let all = |stages: Stages| {
            let mut decided = [0; 4];
            for p in &pairs {
                decided[cascade::intersects(p.a, p.b, p.b_in_a, stages, &mut Cache::new()).stage as usize] += 1;
            }
            decided
        };
        let (none, boxes, outer) = (
            Stages { boxes: false, outer: OuterHulls::Never },
            Stages { boxes: true, outer: OuterHulls::Never },
            Stages { boxes: true, outer: OuterHulls::Always },
        );
        let times = min_times([
            Box::new(|| {
                pairs.iter().for_each(|p| {
                    std::hint::black_box(intersects(p.a, p.b, p.b_in_a, &mut Cache::new()));
                });
            }),
            Box::new(|| _ = std::hint::black_box(all(none))),
            Box::new(|| _ = std::hint::black_box(all(boxes))),
            Box::new(|| _ = std::hint::black_box(all(outer))),
        ]);
        let [full, balls, boxed, outered] = times.map(|t| t.as_secs_f64() / PAIRS as f64 * 1e9);
        let decided = all(outer).map(|n| 100.0 * f64::from(n) / PAIRS as f64);
        println!(
            "distance up to {reach} radii; decided by balls {:.1} %, boxes {:.1} %, outer hulls {:.1} %, hulls {:.1} %",
            decided[Stage::Balls as usize],
            decided[Stage::Boxes as usize],
            decided[Stage::Outer as usize],
            decided[Stage::Full as usize]
        );
        println!(
            "  ns per pair: hulls alone {full:.0}, with balls {balls:.0}, and boxes {boxed:.0}, and outer hulls {outered:.0}"
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cores = std::thread::available_parallelism()?.get();
    for (count, n, index) in [
        (8, 128, IndexKind::Tree),
        (8, 2_048, IndexKind::Tree),
        (400, 2_048, IndexKind::Tree),
        (8, 2_048, IndexKind::None),
    ] {
        println!("{count} hulls of {n} points, {index:?}");
        let families = [Family::Rock, Family::ClusteredEllipsoid, Family::Lens, Family::Needle];
        let packs = (0..count)
            .map(|i| pack(&families[i % families.len()].points(n, i as u64), index))
            .collect::<Result<Vec<_>, _>>()?;
        let hulls = packs.iter().map(|pack| pack.hull(0)).collect::<Result<Vec<_>, _>>()?;
        if count == 8 && index == IndexKind::Tree {
            threads(&hulls, cores)?;
        }
        cascade_stages(&hulls)?;
    }
    Ok(())
}
