//! Prints how many bodies come to rest on each floor, beside parry's own hulls in the same run.
//!
//! ```text
//! cargo run --release -p hullmap-scenes --bin rest-table -- --meshes FOLDER --orientations 6
//! ```

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use hullmap_scenes::floor::Floor;
use hullmap_scenes::model::{Model, generated, mesh, meshes};
use hullmap_scenes::rest::{Outcome, drop, rotations};
use hullmap_scenes::stack::stand;
use hullmap_scenes::way::Way;

/// Bodies that come to rest: baked hulls in Rapier beside parry's own.
#[derive(Parser)]
struct Arguments {
    /// Folders of OBJ files, or OBJ files; without any, generated bodies
    #[arg(long, num_args = 0..)]
    meshes: Vec<PathBuf>,
    /// Number of random orientations of each body
    #[arg(long, default_value_t = 6)]
    orientations: usize,
    /// Seed of the orientations
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Simulated seconds
    #[arg(long, default_value_t = 10.0)]
    seconds: f32,
    /// Number of threads
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Print each body that is awake or lost at the end
    #[arg(long)]
    bodies: bool,
    /// Only these ways: parry, A, B
    #[arg(long, num_args = 1.., default_values = ["parry", "A", "B"])]
    ways: Vec<String>,
    /// Only bodies whose name contains this
    #[arg(long, default_value = "")]
    body: String,
    /// Only floors whose name contains this
    #[arg(long, default_value = "")]
    floor: String,
    /// Also prisms of 3 to 500 sides, alone and in stacks of ten
    #[arg(long)]
    stacks: bool,
}

/// One simulation.
struct Job<'m> {
    row: usize,
    way: Way,
    floor: Floor,
    size: f32,
    model: &'m Model,
    orientation: usize,
}

fn main() {
    let arguments = Arguments::parse();
    let ways: Vec<Way> =
        Way::ALL.into_iter().filter(|way| arguments.ways.iter().any(|name| name == way.name())).collect();
    let models = |size: f32| -> Vec<Model> {
        let found = match arguments.meshes.as_slice() {
            [] => generated(size),
            paths => paths
                .iter()
                .flat_map(
                    |path| if path.is_dir() { meshes(path, size) } else { mesh(path, size).into_iter().collect() },
                )
                .collect(),
        };
        found.into_iter().filter(|model| model.name.contains(&arguments.body)).collect()
    };
    let (large, small) = (models(1.0), models(0.1));
    let mut rows: Vec<(String, Floor, f32, &[Model])> =
        Floor::ALL.iter().map(|floor| (floor.name().to_owned(), *floor, 1.0, large.as_slice())).collect();
    rows.push(("cuboid, bodies of 0.1 m".to_owned(), Floor::Cuboid, 0.1, small.as_slice()));
    rows.retain(|row| row.0.contains(&arguments.floor));
    let turns = rotations(arguments.seed, arguments.orientations);
    let mut jobs = Vec::new();
    for (row, (_, floor, size, models)) in rows.iter().enumerate() {
        for model in *models {
            for orientation in 0..turns.len() {
                jobs.extend(ways.iter().map(|way| Job {
                    row,
                    way: *way,
                    floor: *floor,
                    size: *size,
                    model,
                    orientation,
                }));
            }
        }
    }
    let outcomes = in_parallel(arguments.threads, &jobs, |job| {
        drop(job.model, job.size, turns[job.orientation], job.floor, job.way, arguments.seconds)
    });
    if arguments.bodies {
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            if outcome.lost || outcome.asleep_after.is_none() || outcome.deepest > 0.06 * job.size.max(0.4) {
                println!(
                    "{} | {} | {} orientation {} | {}speed {:.4} | deepest {:.1} mm",
                    rows[job.row].0,
                    job.way.name(),
                    job.model.name,
                    job.orientation,
                    if outcome.lost { "lost | " } else { "" },
                    outcome.speed,
                    outcome.deepest * 1e3,
                );
            }
        }
    }
    println!("asleep after {} s of {} bodies (lost; deepest, mm)\n", arguments.seconds, large.len() * turns.len());
    println!("| floor |{}", ways.iter().map(|way| format!(" {} |", way.name())).collect::<String>());
    println!("|---|{}", "---|".repeat(ways.len()));
    for (row, (name, ..)) in rows.iter().enumerate() {
        let cell = |way: Way| {
            let of: Vec<&Outcome> = jobs
                .iter()
                .zip(&outcomes)
                .filter(|(job, _)| job.row == row && job.way == way)
                .map(|(_, outcome)| outcome)
                .collect();
            let asleep = of.iter().filter(|outcome| outcome.asleep_after.is_some() && !outcome.lost).count();
            let lost = of.iter().filter(|outcome| outcome.lost).count();
            let kept = of.iter().filter(|outcome| !outcome.lost);
            let deepest = kept.map(|outcome| outcome.deepest).fold(0.0, f32::max) * 1e3;
            format!(" {asleep} ({lost}; {deepest:.1}) |")
        };
        println!("| {name} |{}", ways.iter().map(|way| cell(*way)).collect::<String>());
    }
    if arguments.stacks {
        stacks(&arguments, &ways);
    }
}

/// Prints the table of upright prisms.
fn stacks(arguments: &Arguments, ways: &[Way]) {
    let sides = [3, 4, 5, 6, 8, 12, 16, 24, 32, 64, 128, 500];
    let mut jobs = Vec::new();
    for count in [1, 10] {
        for sides in sides {
            jobs.extend(ways.iter().map(|way| (count, sides, *way)));
        }
    }
    let standing = in_parallel(arguments.threads, &jobs, |(count, sides, way)| {
        stand(*sides, *count, Floor::Cuboid, *way, arguments.seconds)
    });
    println!("\nupright prisms: tilt in degrees, asleep, sunk in mm\n");
    println!("| sides | bodies |{}", ways.iter().map(|way| format!(" {} |", way.name())).collect::<String>());
    println!("|---|---|{}", "---|".repeat(ways.len()));
    for (jobs, standing) in jobs.chunks(ways.len()).zip(standing.chunks(ways.len())) {
        let (count, sides, _) = jobs[0];
        let cell = |s: &hullmap_scenes::stack::Standing| {
            format!(" {:.2}°, {}, {:.1} |", s.tilt_degrees, s.asleep, s.sunk * 1e3)
        };
        println!("| {sides} | {count} |{}", standing.iter().map(cell).collect::<String>());
    }
}

/// Runs `work` on all `jobs`, on some threads.
fn in_parallel<J: Sync, R: Send>(threads: usize, jobs: &[J], work: impl Fn(&J) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(index) else { break };
                    let result = work(job);
                    done.lock().expect("no panic").push((index, result));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no panic");
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
