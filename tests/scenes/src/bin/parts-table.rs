//! Prints how bodies of convex parts behave in a pit in Rapier: bodies fall, pile up, and come to
//! rest. The parts come from folders of OBJ files with one object for each part, for instance of
//! `bake decompose` and of `benches/peers/decompose.py`. The worlds of the folders take turns, so
//! that a busy machine slows all of them alike.

use std::path::PathBuf;

use clap::Parser;
use hullmap_scenes::{
    model::{Model, bodies_of_parts},
    pit::Pit,
    steps::timed_steps,
    way::Way,
};

/// Bodies of convex parts in a pit, in Rapier with HullDispatcher.
#[derive(Parser)]
struct Arguments {
    /// Folders of OBJ files with an object for each part; only names that all have are used
    #[arg(required = true, num_args = 1..)]
    folders: Vec<PathBuf>,
    /// Number of bodies
    #[arg(long, default_value_t = 200)]
    bodies: usize,
    /// Half the width of the pit, in lengths of a body
    #[arg(long, default_value_t = 4.0)]
    half_width: f32,
    /// Steps of 1/60 s
    #[arg(long, default_value_t = 900)]
    steps: usize,
    /// Steps that a world takes before the next one does
    #[arg(long, default_value_t = 30)]
    turn: usize,
    /// Seed of the rotations
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() {
    let arguments = Arguments::parse();
    let mut all: Vec<Vec<Model>> = arguments.folders.iter().map(|folder| bodies_of_parts(folder, 1.0)).collect();
    let names: Vec<Vec<String>> =
        all.iter().map(|models| models.iter().map(|model| model.name.clone()).collect()).collect();
    for models in &mut all {
        models.retain(|model| names.iter().all(|names| names.contains(&model.name)));
    }
    println!("{} bodies of {} meshes, 1 m long; {} steps", arguments.bodies, all[0].len(), arguments.steps);
    let new = |models| Pit::new(models, arguments.bodies, arguments.half_width, arguments.seed, Way::Dispatcher);
    let mut pits: Vec<Pit> = all.iter().map(|models| new(models)).collect();
    let mut times = vec![Vec::new(); pits.len()];
    let mut deepest = vec![0.0_f32; pits.len()];
    for _ in 0..arguments.steps.div_ceil(arguments.turn) {
        for (index, pit) in pits.iter_mut().enumerate() {
            times[index].push(timed_steps(&mut pit.world, arguments.turn).as_secs_f64() * 1e3 / arguments.turn as f64);
            deepest[index] = deepest[index].max(pit.deepest());
        }
    }
    println!(
        "| folder | parts | vertices | ms a step: first quarter | last quarter | deepest mm: ever | at the end | slower than 10 mm/s | lost |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let rows = arguments.folders.iter().zip(&all).zip(&pits).zip(times.iter().zip(&deepest));
    for (((folder, models), pit), (times, deepest)) in rows {
        let quarter = times.len().div_ceil(4);
        let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
        let vertices = |model: &Model| model.parts.iter().map(|part| part.hull().vertex_count()).sum::<usize>();
        println!(
            "| {} | {} | {} | {:.2} | {:.2} | {:.1} | {:.1} | {} | {} |",
            folder.display(),
            models.iter().map(|model| model.parts.len()).sum::<usize>(),
            models.iter().map(vertices).sum::<usize>(),
            mean(&times[..quarter]),
            mean(&times[times.len() - quarter..]),
            1e3 * deepest,
            1e3 * pit.deepest(),
            pit.slower_than(0.01),
            pit.lost(),
        );
    }
}
