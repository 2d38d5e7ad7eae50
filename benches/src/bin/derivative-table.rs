//! Prints the time of distance and contact queries alone, and with the derivatives of their
//! answers, for two equal hulls in random poses.
//!
//! The two alternate, and each has the least of its times, so that a busy machine changes little.
//! Caches start empty.

use std::hint::black_box;

use clap::Parser;
use glam::{DQuat, DVec3};
use hullmap::{Cache, Differentiability, Hull, Pose, Settings, contact, distance};
use hullmap_bench::clock;
use hullmap_testkit::packs::tree_pack;
use shapes::{families::rock, rng::SplitMix64};

/// Measures what derivatives cost beyond their queries.
///
/// The table goes to standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin derivative-table -- --rounds 61")]
struct Arguments {
    /// Number of poses for each number of vertices
    #[arg(long, default_value_t = 1_000)]
    poses: usize,
    /// Numbers of vertices
    #[arg(long, value_delimiter = ',', default_values_t = [12, 32, 128, 512])]
    vertices: Vec<usize>,
    /// Number of rounds
    #[arg(long, default_value_t = 61)]
    rounds: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = 7)]
    seed: u64,
}

/// Poses at distances between these, as fractions of the radius.
fn poses(count: usize, [near, far]: [f64; 2], rng: &mut SplitMix64) -> Vec<Pose> {
    let pose = |_| {
        let turn = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
        Pose::new(DVec3::from_array(rng.direction()) * rng.between(near, far), turn).expect("finite")
    };
    (0..count).map(pose).collect()
}

/// One answer, with derivatives or without: whether it has any.
fn answer(hull: &Hull<'_>, pose: Pose, is_contact: bool, with: bool, cache: &mut Cache) -> bool {
    let settings = Settings::default();
    cache.clear();
    let by = if is_contact {
        let found = black_box(contact(hull, hull, pose, &settings, cache));
        with.then(|| found.derivatives(hull, hull, pose, &settings, cache))
    } else {
        let found = black_box(distance(hull, hull, pose, &settings, cache));
        with.then(|| found.derivatives(hull, hull, pose))
    };
    black_box(by).is_some_and(|by| by.status == Differentiability::Unique)
}

fn main() {
    let arguments = Arguments::parse();
    println!("Processor time, least of {} rounds; seed {}\n", arguments.rounds, arguments.seed);
    println!("| query | vertices | ns | with derivatives, ns | more, % | unique, % |\n|---|---|---|---|---|---|");
    for is_contact in [false, true] {
        let (name, distances) = if is_contact { ("contact", [0.3, 1.0]) } else { ("distance", [2.2, 3.2]) };
        for &vertices in &arguments.vertices {
            let pack = tree_pack(&rock(vertices, 3));
            let hull = pack.hull(0).expect("one hull");
            let poses = poses(arguments.poses, distances, &mut SplitMix64::new(arguments.seed));
            let (mut cache, mut unique, mut least) = (Cache::new(), 0, [f64::INFINITY; 2]);
            for _ in 0..arguments.rounds {
                for (with, least) in [false, true].into_iter().zip(&mut least) {
                    let mut count = 0;
                    let all = || {
                        poses.iter().for_each(|p| count += usize::from(answer(&hull, *p, is_contact, with, &mut cache)))
                    };
                    *least = least.min(clock::time_ns(all) / poses.len() as f64);
                    unique = count;
                }
            }
            let [alone, both] = least;
            let (more, unique) = (100.0 * (both / alone - 1.0), 100.0 * unique as f64 / poses.len() as f64);
            println!("| {name} | {vertices} | {alone:.0} | {both:.0} | {more:.0} | {unique:.1} |");
        }
    }
}
