//! Prints the time of `cast_motion` beside parry3d's nonlinear cast, for hulls that move and turn
//! towards each other, and how often parry's answer is outside our proven interval.
//!
//! Ours and theirs alternate, so that a busy machine slows both down. Each motion is repeated, so
//! it finds caches and branches as it left them; the column *in a row* has the mean processor time
//! of one motion after another.

use std::hint::black_box;
use std::time::Instant;

use clap::Parser;
use glam::{DQuat, DVec3};
use hullmap::{Cache, MotionSettings, Pose, RigidMotion, TimeOfImpact, cast_motion};
use hullmap_bench::clock;
use hullmap_testkit::packs::tree_pack;
use parry3d::math;
use parry3d::query::{self, NonlinearRigidMotion, ShapeCastHit};
use parry3d::shape::ConvexPolyhedron;
use shapes::{families::rock, rng::SplitMix64};

/// Measures the first meeting of two hulls that turn, beside parry's.
///
/// The table goes to standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin motion-table -- --motions 2000")]
struct Arguments {
    /// Number of motions for each number of vertices and each angle
    #[arg(long, default_value_t = 2_000)]
    motions: usize,
    /// Numbers of vertices
    #[arg(long, value_delimiter = ',', default_values_t = [32, 128, 512, 2_048])]
    vertices: Vec<usize>,
    /// Angles in degrees by which both hulls turn
    #[arg(long, value_delimiter = ',', default_values_t = [0, 45, 360])]
    degrees: Vec<u32>,
    /// Number of rounds; each motion has the median of its times
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Seed of the motions
    #[arg(long, default_value_t = 40)]
    seed: u64,
}

/// Difference of times that parry's f32 may cause.
const SLACK: f64 = 1e-3;

/// Two motions, for both.
struct Motions {
    ours: [RigidMotion; 2],
    parry: [NonlinearRigidMotion; 2],
}

/// Bodies of diameter 2 that start apart, and of which about half meet.
fn motions(count: usize, angle: f64, rng: &mut SplitMix64) -> Vec<Motions> {
    let mut motion = |from: DVec3, to: DVec3| {
        let turn = DQuat::from_xyzw(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5).normalize();
        let (linear, angular) = (to - from, DVec3::from_array(rng.direction()) * angle);
        let start = Pose::new(from, turn).expect("finite");
        let parry = math::Pose::from_parts(from.as_vec3(), turn.as_quat());
        (
            RigidMotion::screw(start, linear, angular, from).expect("finite"),
            NonlinearRigidMotion::new(parry, math::Vector::ZERO, linear.as_vec3(), angular.as_vec3()),
        )
    };
    let mut places = SplitMix64::new(count as u64);
    (0..count)
        .map(|_| {
            let from = DVec3::from_array(places.direction()) * places.between(2.5, 4.0);
            let aim = DVec3::from_array(places.direction()) * places.between(0.0, 3.2);
            let (own, other) = (motion(DVec3::ZERO, DVec3::ZERO), motion(from, aim));
            Motions { ours: [own.0, other.0], parry: [own.1, other.1] }
        })
        .collect()
}

fn median(values: Vec<f64>) -> f64 {
    clock::median(values).unwrap_or_default()
}

/// Results for one number of vertices and one angle.
#[derive(Default)]
struct Row {
    ours: Vec<f64>,
    /// Mean time of one motion after another, when nothing is left of it from the last round.
    in_a_row: f64,
    parry: Vec<f64>,
    queries: Vec<f64>,
    hits: usize,
    missed: usize,
    late: usize,
    early: usize,
}

impl Row {
    fn count(&mut self, ours: &TimeOfImpact, parry: Option<ShapeCastHit>) {
        self.queries.push(f64::from(ours.iterations));
        let is_hit = ours.t_upper <= 1.0;
        self.hits += usize::from(is_hit);
        match parry.map(|hit| f64::from(hit.time_of_impact)) {
            None => self.missed += usize::from(is_hit && ours.t_upper < 1.0 - SLACK),
            Some(t) if t > ours.t_upper + SLACK => self.late += 1,
            Some(t) => self.early += usize::from(t < ours.t_lower - SLACK),
        }
    }
}

fn measure(vertices: usize, angle: f64, arguments: &Arguments) -> Row {
    let points: Vec<[f32; 3]> = rock(vertices, 3);
    let pack = tree_pack(&points);
    let hull = pack.hull(0).expect("one hull");
    let own: Vec<math::Vector> = points.iter().map(|p| math::Vector::from_array(*p)).collect();
    let parry = ConvexPolyhedron::from_convex_hull(&own).expect("parry takes the rock");
    let mut row = Row::default();
    let settings = MotionSettings::default();
    let motions = motions(arguments.motions, angle, &mut SplitMix64::new(arguments.seed));
    let rounds = (0..arguments.rounds).map(|_| {
        let all = || {
            for Motions { ours, .. } in &motions {
                black_box(cast_motion(&hull, &ours[0], &hull, &ours[1], &settings, &mut Cache::new()));
            }
        };
        clock::time_ns(all) * 1e-3 / motions.len() as f64
    });
    row.in_a_row = median(rounds.collect());
    for Motions { ours, parry: theirs } in motions {
        let (mut times, mut last) = ([Vec::new(), Vec::new()], None);
        for _ in 0..arguments.rounds {
            let start = Instant::now();
            let found = black_box(cast_motion(&hull, &ours[0], &hull, &ours[1], &settings, &mut Cache::new()));
            times[0].push(start.elapsed().as_secs_f64() * 1e6);
            let start = Instant::now();
            let hit = query::cast_shapes_nonlinear(&theirs[0], &parry, &theirs[1], &parry, 0.0, 1.0, true);
            times[1].push(start.elapsed().as_secs_f64() * 1e6);
            last = Some((found, black_box(hit).expect("parry takes hulls")));
        }
        let [own, other] = times.map(median);
        row.ours.push(own);
        row.parry.push(other);
        if let Some((found, hit)) = last {
            row.count(&found, hit);
        }
    }
    row
}

fn main() {
    let arguments = Arguments::parse();
    println!("µs a motion: median, and 99th percentile; seed {}\n", arguments.seed);
    let columns = ["vertices", "degrees", "hits of", "queries", "hullmap", "99 %", "in a row", "parry", "99 %"];
    println!("| {} | parry missed | late | early |", columns.join(" | "));
    println!("|{}", "---|".repeat(columns.len() + 3));
    for &vertices in &arguments.vertices {
        for &degrees in &arguments.degrees {
            let row = measure(vertices, f64::from(degrees).to_radians(), &arguments);
            let high = |times: &[f64]| {
                let mut sorted = times.to_vec();
                sorted.sort_by(f64::total_cmp);
                sorted.get(sorted.len() * 99 / 100).copied().unwrap_or_default()
            };
            let tails = [high(&row.ours), high(&row.parry)];
            println!(
                "| {vertices} | {degrees} | {} of {} | {:.0} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {} | {} | {} |",
                row.hits,
                row.queries.len(),
                median(row.queries),
                median(row.ours),
                tails[0],
                row.in_a_row,
                median(row.parry),
                tails[1],
                row.missed,
                row.late,
                row.early
            );
        }
    }
}
