//! How many pairs a second: batches on one thread and on all of them, and what each level of detail is worth.
//!
//!     cargo run --release --example throughput --package hullmap --features parallel
//!
//! Times are the least of many short runs, one setting after the other in turn, so that a busy machine disturbs all alike and
//! some hardly.

use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use hullmap::batch::{self, Pair};
use hullmap::levels::{self, Level, Levels, OuterHulls};
use hullmap::{Cache, Hull, Manifold, ManifoldSettings, Pack, Pose, Settings, SupportMap, intersects};
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

/// `reach` is how far apart pairs are, in sums of their outer radii.
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

/// The least time of each of `ways`, in turn.
fn least<const N: usize>(mut ways: [Box<dyn FnMut() + '_>; N]) -> [Duration; N] {
    let mut least = [Duration::MAX; N];
    for _ in 0..RUNS {
        for (way, least) in ways.iter_mut().zip(&mut least) {
            let start = Instant::now();
            way();
            *least = start.elapsed().min(*least);
        }
    }
    least
}

fn threads(hulls: &[Hull], cores: usize) -> Result<(), Box<dyn std::error::Error>> {
    let pairs = pairs(hulls, 0.7)?;
    let (one, all) = (
        rayon::ThreadPoolBuilder::new().num_threads(1).build()?,
        rayon::ThreadPoolBuilder::new().num_threads(cores).build()?,
    );
    let settings = Settings::default();
    let some = hullmap::contact(pairs[0].a, pairs[0].b, pairs[0].b_in_a, &settings, &mut Cache::new());
    let contact = |pool: &rayon::ThreadPool| {
        let (mut caches, mut out) = (vec![Cache::new(); PAIRS], vec![some; PAIRS]);
        pool.install(|| batch::contact(&pairs, &settings, &mut caches, &mut out)).expect("equal lengths");
    };
    let manifold = |pool: &rayon::ThreadPool| {
        let (mut caches, mut out) = (vec![Cache::new(); PAIRS], vec![Manifold::new(); PAIRS]);
        pool.install(|| batch::manifolds(&pairs, &ManifoldSettings::default(), &mut caches, &mut out))
            .expect("equal lengths");
    };
    let times = least([
        Box::new(|| contact(&one)),
        Box::new(|| contact(&all)),
        Box::new(|| manifold(&one)),
        Box::new(|| manifold(&all)),
    ]);
    let [a, b, c, d] = times.map(|t| t.as_secs_f64() / PAIRS as f64 * 1e9);
    println!("contact:  {a:6.0} ns a pair on 1 thread, {b:6.0} on {cores}: {:.2} times as many pairs", a / b);
    println!("manifold: {c:6.0} ns a pair on 1 thread, {d:6.0} on {cores}: {:.2} times as many pairs", c / d);
    Ok(())
}

fn levels_of_detail(hulls: &[Hull]) -> Result<(), Box<dyn std::error::Error>> {
    for reach in [0.7, 1.2] {
        let pairs = pairs(hulls, reach)?;
        let all = |levels: Levels| {
            let mut decided = [0; 4];
            for p in &pairs {
                decided[levels::intersects(p.a, p.b, p.b_in_a, levels, &mut Cache::new()).level as usize] += 1;
            }
            decided
        };
        let (none, boxes, outer) = (
            Levels { boxes: false, outer: OuterHulls::Never },
            Levels { boxes: true, outer: OuterHulls::Never },
            Levels { boxes: true, outer: OuterHulls::Always },
        );
        let times = least([
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
            "up to {reach} radii apart: balls {:.1} %, boxes {:.1} %, outer hulls {:.1} %, hulls {:.1} %",
            decided[Level::Balls as usize],
            decided[Level::Boxes as usize],
            decided[Level::Outer as usize],
            decided[Level::Full as usize]
        );
        println!(
            "  ns a pair: full {full:.0}; by balls {balls:.0}; and boxes {boxed:.0}; and outer hulls {outered:.0}"
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cores = std::thread::available_parallelism()?.get();
    for (count, n, index) in [
        (8, 128, IndexKind::TREE),
        (8, 2_048, IndexKind::TREE),
        (400, 2_048, IndexKind::TREE),
        (8, 2_048, IndexKind::None),
    ] {
        println!("{count} hulls of {n} points, {index:?}");
        let families = [Family::Rock, Family::ClusteredEllipsoid, Family::Lens, Family::Needle];
        let packs = (0..count)
            .map(|i| pack(&families[i % families.len()].points(n, i as u64), index))
            .collect::<Result<Vec<_>, _>>()?;
        let hulls = packs.iter().map(|pack| pack.hull(0)).collect::<Result<Vec<_>, _>>()?;
        if count == 8 && index == IndexKind::TREE {
            threads(&hulls, cores)?;
        }
        levels_of_detail(&hulls)?;
    }
    Ok(())
}
