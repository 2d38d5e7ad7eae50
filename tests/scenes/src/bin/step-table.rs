//! Prints the time of a step with many bodies: parry's own hulls, baked hulls with the default
//! dispatcher, and with `HullDispatcher`. The three worlds take turns, so that a busy machine slows
//! all of them alike.

use clap::Parser;
use hullmap_scenes::model::Model;
use hullmap_scenes::steps::Pile;
use hullmap_scenes::way::Way;
use shapes::families::rock;

/// Time of a step in Rapier with baked hulls, beside parry's own.
#[derive(Parser)]
struct Arguments {
    /// Piles as BODIESxVERTICES
    #[arg(long, num_args = 1.., default_values = ["200x32", "200x128", "200x512", "200x2048", "200x8192", "1000x512"])]
    piles: Vec<String>,
    /// Steps while the bodies fall
    #[arg(long, default_value_t = 180)]
    falling: usize,
    /// Steps before the pile counts as settled
    #[arg(long, default_value_t = 600)]
    settling: usize,
    /// Steps of the settled pile
    #[arg(long, default_value_t = 120)]
    settled: usize,
    /// Steps that a world takes before the next one does
    #[arg(long, default_value_t = 30)]
    turn: usize,
    /// Only these ways: parry, A, B
    #[arg(long, num_args = 1.., default_values = ["parry", "A", "B"])]
    ways: Vec<String>,
}

fn main() {
    let arguments = Arguments::parse();
    println!("milliseconds of processor time a step, median of turns: falling | settled\n");
    let ways: Vec<Way> =
        Way::ALL.into_iter().filter(|way| arguments.ways.iter().any(|name| name == way.name())).collect();
    println!("| bodies × vertices |{}", ways.iter().map(|way| format!(" {} |", way.name())).collect::<String>());
    println!("|---|{}", "---|".repeat(ways.len()));
    for pile in &arguments.piles {
        let (bodies, vertices) = pile.split_once('x').expect("BODIESxVERTICES");
        let (bodies, vertices): (usize, usize) = (bodies.parse().expect("bodies"), vertices.parse().expect("vertices"));
        let models: Vec<Model> =
            (0..4).map(|seed| Model::sized("rock", &rock(vertices, seed), 1.0).expect("a solid")).collect();
        let mut piles: Vec<Pile> = ways.iter().map(|way| Pile::new(&models, bodies, *way)).collect();
        let mut phase = |steps: usize| {
            let mut times = vec![Vec::new(); ways.len()];
            for _ in 0..steps.div_ceil(arguments.turn) {
                for (pile, times) in piles.iter_mut().zip(&mut times) {
                    times.push(pile.step(arguments.turn).as_secs_f64() * 1e3 / arguments.turn as f64);
                }
            }
            let median = |times: &mut Vec<f64>| {
                times.sort_by(f64::total_cmp);
                times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
            };
            times.iter_mut().map(median).collect::<Vec<f64>>()
        };
        let falling = phase(arguments.falling);
        phase(arguments.settling.saturating_sub(arguments.falling));
        let settled = phase(arguments.settled);
        let cells: String = falling.iter().zip(&settled).map(|(f, s)| format!(" {f:.2} \\| {s:.2} |")).collect();
        println!("| {bodies} × {vertices} |{cells}");
    }
}
