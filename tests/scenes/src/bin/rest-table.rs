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
use hullmap_scenes::pit::Pit;
use hullmap_scenes::relief::load_terrain;
use hullmap_scenes::rest::{Outcome, STEP_SECONDS, drop, rotations};
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
    /// Mesh file of a scanned body, whose relief is the floor "terrain"
    #[arg(long)]
    terrain: Option<PathBuf>,
    /// Also prisms of 3 to 500 sides, alone and in stacks of ten
    #[arg(long)]
    stacks: bool,
    /// Also a pit with this many bodies of each mesh, for three times as long
    #[arg(long, default_value_t = 0)]
    pit: usize,
    /// Half the width of the pit in m
    #[arg(long, default_value_t = 3.0)]
    half_width: f32,
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
    if let Some(path) = &arguments.terrain {
        load_terrain(path);
    }
    let is_known = |floor: &&Floor| **floor != Floor::Terrain || arguments.terrain.is_some();
    let mut rows: Vec<(String, Floor, f32, &[Model])> = Floor::ALL
        .iter()
        .filter(is_known)
        .map(|floor| (floor.name().to_owned(), *floor, 1.0, large.as_slice()))
        .collect();
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
            let is_bad = outcome.lost || outcome.is_stuck() || outcome.has_gained();
            if is_bad || outcome.asleep_after.is_none() || outcome.deepest > 0.06 * job.size.max(0.4) {
                println!(
                    "{} | {} | {} orientation {} | {}speed {:.4} | deepest {:.1} mm, in the end {:.1} mm | gained {:.1} mJ/kg",
                    rows[job.row].0,
                    job.way.name(),
                    job.model.name,
                    job.orientation,
                    if outcome.lost { "lost | " } else { "" },
                    outcome.speed,
                    outcome.deepest * 1e3,
                    outcome.final_depth * 1e3,
                    outcome.gained * 1e3,
                );
            }
        }
    }
    println!("{} bodies, after {} s\n", large.len() * turns.len(), arguments.seconds);
    println!(
        "| floor | hulls | asleep | lost | stuck | deepest, mm | deepest at the end, mm | gained energy | most, mJ/kg |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut totals = vec![[0; 5]; ways.len()];
    for (row, (name, ..)) in rows.iter().enumerate() {
        for (way, totals) in ways.iter().zip(&mut totals) {
            let of: Vec<&Outcome> = jobs
                .iter()
                .zip(&outcomes)
                .filter(|(job, _)| job.row == row && job.way == *way)
                .map(|(_, outcome)| outcome)
                .collect();
            let count = |is: &dyn Fn(&Outcome) -> bool| of.iter().filter(|outcome| is(outcome)).count();
            let greatest = |value: fn(&Outcome) -> f32| {
                of.iter().filter(|outcome| !outcome.lost).map(|outcome| value(outcome) * 1e3).fold(0.0, f32::max)
            };
            let counts = [
                of.len(),
                count(&|outcome| outcome.asleep_after.is_some() && !outcome.lost),
                count(&|outcome| outcome.lost),
                count(&Outcome::is_stuck),
                count(&Outcome::has_gained),
            ];
            totals.iter_mut().zip(counts).for_each(|(total, count)| *total += count);
            let [_, asleep, lost, stuck, gained] = counts;
            println!(
                "| {name} | {} | {asleep} | {lost} | {stuck} | {:.1} | {:.1} | {gained} | {:.1} |",
                way.name(),
                greatest(|outcome| outcome.deepest),
                greatest(|outcome| outcome.final_depth),
                greatest(|outcome| outcome.gained),
            );
        }
    }
    println!();
    for (way, [count, asleep, lost, stuck, gained]) in ways.iter().zip(totals) {
        let share = 100.0 * asleep as f64 / count as f64;
        let way = way.name();
        println!(
            "{way}: {asleep} of {count} asleep ({share:.1} %), {lost} lost, {stuck} stuck, {gained} gained energy"
        );
    }
    if arguments.pit > 0 {
        pits(&arguments, &ways, &large);
    }
    if arguments.stacks {
        stacks(&arguments, &ways);
    }
}

/// Prints the table of pits, one for each mesh.
fn pits(arguments: &Arguments, ways: &[Way], models: &[Model]) {
    let jobs: Vec<(&Model, Way)> = models.iter().flat_map(|model| ways.iter().map(move |way| (model, *way))).collect();
    let seconds = 3.0 * arguments.seconds;
    let ends = in_parallel(arguments.threads, &jobs, |(model, way)| {
        let models = std::slice::from_ref(*model);
        let mut pit = Pit::new(models, arguments.pit, arguments.half_width, arguments.seed, *way);
        (0..(seconds / STEP_SECONDS).round() as u32).for_each(|_| pit.world.step());
        (pit.asleep(), pit.lost(), pit.deepest() * 1e3)
    });
    println!("\npits of {} bodies, after {seconds} s: asleep (lost; deepest at the end, mm)\n", arguments.pit);
    println!("| mesh |{}", ways.iter().map(|way| format!(" {} |", way.name())).collect::<String>());
    println!("|---|{}", "---|".repeat(ways.len()));
    for (jobs, ends) in jobs.chunks(ways.len()).zip(ends.chunks(ways.len())) {
        let cell = |(asleep, lost, deepest): &(usize, usize, f32)| format!(" {asleep} ({lost}; {deepest:.1}) |");
        println!("| {} |{}", jobs[0].0.name, ends.iter().map(cell).collect::<String>());
    }
    for (i, way) in ways.iter().enumerate() {
        let asleep: usize = ends.iter().skip(i).step_by(ways.len()).map(|(asleep, ..)| asleep).sum();
        println!("{}: {asleep} of {} asleep", way.name(), arguments.pit * models.len());
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
