//! A pile of 1,000 detailed bodies, and a stack of ten prisms, in Rapier.
//!
//! The same scene runs with parry's own convex polyhedra, with baked hulls, and with baked hulls
//! and `HullDispatcher`. A table compares the time of a step and the bodies that come to rest. This
//! is the dynamic scene of Kenwright, section 5.
//!
//! ```text
//! cargo run --release -p hullmap-parry --all-features --example pile
//! ```

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use shapes::families::Family;
use stage::floor::Floor;
use stage::model::{Model, mesh};
use stage::pit::Pit;
use stage::stack::stand;
use stage::way::Way;

#[path = "../tests/scenes/stage/mod.rs"]
mod stage;

/// Half the width of the pit.
const HALF_WIDTH: f32 = 6.0;

/// Steps a second.
const RATE: usize = 60;

/// A pile of detailed bodies, and a stack of ten prisms, with parry's hulls and with baked hulls.
#[derive(Parser)]
struct Arguments {
    /// Number of bodies
    #[arg(long, default_value_t = 1000)]
    bodies: usize,
    /// Vertices of each body
    #[arg(long, default_value_t = 512)]
    vertices: usize,
    /// Mesh of all bodies instead of generated rocks: OBJ, glTF, STL or PLY
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Seconds to simulate
    #[arg(long, default_value_t = 15)]
    seconds: usize,
    /// Ways to compare
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Way::Parry, Way::Shapes, Way::Dispatcher])]
    ways: Vec<Way>,
}

/// The name of a way in the table, and on the command line.
fn name(way: Way) -> String {
    way.to_possible_value().expect("no way is hidden").get_name().to_owned()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();
    let models = match &arguments.mesh {
        Some(path) => vec![mesh(path, 1.0).ok_or("the mesh is flat: a body needs a volume")?],
        None => (0..4).map(|seed| rock(arguments.vertices, seed)).collect(),
    };
    let vertices = models.iter().map(|model| model.hull.hull().vertex_count()).max().unwrap_or(0);
    println!("{} bodies of up to {vertices} vertices, {} seconds", arguments.bodies, arguments.seconds);
    println!("{:12} {:>15} {:>15} {:>8} {:>6}", "", "falling ms/step", "settled ms/step", "asleep", "lost");
    for &way in &arguments.ways {
        let outcome = pile(&arguments, &models, way);
        let [falling, settled] = [outcome.falling, outcome.settled].map(|time| time.as_secs_f64() * 1e3);
        println!("{:12} {falling:>15.2} {settled:>15.2} {:>8} {:>6}", name(way), outcome.asleep, outcome.lost);
    }
    println!("\na stack of ten prisms with 64 sides, after 10 seconds");
    println!("{:12} {:>15} {:>15} {:>8}", "", "tilt in degrees", "drift in mm", "asleep");
    for &way in &arguments.ways {
        let stack = stand(64, 10, Floor::Cuboid, way, 10.0);
        println!("{:12} {:>15.2} {:>15.1} {:>8}", name(way), stack.tilt_degrees, stack.drift * 1e3, stack.asleep);
    }
    Ok(())
}

/// A rock of `vertices` vertices, 1 m long.
fn rock(vertices: usize, seed: u64) -> Model {
    let points = Family::Rock.points(vertices.max(8), seed);
    Model::sized("rock", &points, 1.0).expect("a rock is solid")
}

/// How the pile ended.
struct Outcome {
    /// Median time of a step in the first quarter of the time.
    falling: Duration,
    /// Median time of a step in the last second.
    settled: Duration,
    asleep: usize,
    lost: usize,
}

fn pile(arguments: &Arguments, models: &[Model], way: Way) -> Outcome {
    let mut pit = Pit::new(models, arguments.bodies, HALF_WIDTH, 7, way);
    let steps = arguments.seconds.max(1) * RATE;
    let step = |_| {
        let start = Instant::now();
        pit.world.step();
        start.elapsed()
    };
    let mut times: Vec<Duration> = (0..steps).map(step).collect();
    let falling = median(&mut times[..steps / 4]);
    let settled = median(&mut times[steps - RATE..]);
    Outcome { falling, settled, asleep: pit.asleep(), lost: pit.lost() }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times[times.len() / 2]
}
