//! Contact beside MuJoCo and parry3d, on the same hulls and poses, interleaved in one run.

use std::{error::Error, hint::black_box, path::PathBuf, process::ExitCode};

use clap::Parser;
use hullmap::{Cache, Minkowski, Settings, contact};
use hullmap_bench::{
    clock::{median, time_ns},
    rows::{Row, Rows, finish, three_digits},
    solver::{
        mujoco::{ITERATIONS, MuJoCo, Session},
        pairs::{BakedPair, FAMILIES, Mix, Placed},
    },
    subject::SEED,
};
use parry3d::{math, query};
use shapes::rng::SplitMix64;

/// Differences of depths up to this fraction of the diameter come from MuJoCo's vertices, which are
/// moved to the centre of mass and rounded to f32.
const ROUNDING: f64 = 1e-6;

/// Number of frames of a path.
const FRAMES: usize = 33;

/// Compares contact with MuJoCo's and parry3d's, on sphere, ellipsoid and rock hulls.
///
/// A third of the poses penetrate, a third are within 2 % of touching, a third are separated.
/// MuJoCo comes from PyPI; without it the table is skipped. Tables go to standard output, progress
/// to standard error.
#[derive(Parser)]
#[command(after_help = "Example:\n  python3 -m venv target/venv && target/venv/bin/pip install mujoco\n  \
    cargo run --release -p hullmap-bench --bin peer-table -- --python target/venv/bin/python")]
struct Arguments {
    /// Python that has the package `mujoco`
    #[arg(long, value_name = "FILE", default_value = "python3")]
    python: PathBuf,
    /// Vertex counts, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "8,32,128,512,2048")]
    n: Vec<usize>,
    /// Number of poses of each class and family
    #[arg(long, default_value_t = 100)]
    poses: usize,
    /// Number of paths of each class and family
    #[arg(long, default_value_t = 10)]
    paths: usize,
    /// Number of rounds
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// Also write the times as CSV
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mujoco = match MuJoCo::find(&arguments.python) {
        Ok(mujoco) => mujoco,
        Err(reason) => {
            println!("skipped: MuJoCo is missing: {reason}");
            return ExitCode::SUCCESS;
        }
    };
    match run(&arguments, &mujoco) {
        Ok(rows) => finish(arguments.out.map(|path| (path, &rows)).as_slice()),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// An engine, and the order of its poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Engine {
    /// hullmap with empty caches.
    Cold,
    MuJoCo,
    Parry,
    /// hullmap along paths, with empty caches.
    PathCold,
    /// hullmap along paths, with a cache for each path.
    PathWarm,
    /// MuJoCo along paths. It keeps nothing from one query to the next.
    PathMuJoCo,
}

impl Engine {
    const ALL: [Engine; 6] =
        [Engine::Cold, Engine::MuJoCo, Engine::Parry, Engine::PathCold, Engine::PathWarm, Engine::PathMuJoCo];

    /// Order of the poses and name, in the CSV.
    const fn names(self) -> [&'static str; 2] {
        match self {
            Engine::Cold => ["random", "hullmap"],
            Engine::MuJoCo => ["random", "mujoco"],
            Engine::Parry => ["random", "parry"],
            Engine::PathCold => ["paths", "hullmap cold"],
            Engine::PathWarm => ["paths", "hullmap warm"],
            Engine::PathMuJoCo => ["paths", "mujoco"],
        }
    }
}

/// Differences of the answers, over all poses.
#[derive(Default)]
struct Differences {
    poses: usize,
    /// The engines disagree on overlap, and the depth exceeds a millionth of the diameter.
    verdicts: usize,
    /// Maximum length by which MuJoCo's depth is below hullmap's interval, and above it, relative
    /// to the diameter.
    below: f64,
    above: f64,
    /// MuJoCo's depth is below hullmap's interval.
    short: usize,
    /// Moving B along MuJoCo's normal by less than hullmap's lower bound separates the shapes.
    disproved: usize,
}

fn run(arguments: &Arguments, mujoco: &MuJoCo) -> Result<Rows, Box<dyn Error>> {
    println!("{}\n", mujoco.prove()?);
    let (mut rows, mut differences) = (Rows::new(&["n", "order", "poses", "engine", "ns"]), Differences::default());
    for &n in &arguments.n {
        eprintln!("{n} vertices");
        measure(arguments, mujoco, n, &mut rows, &mut differences)?;
    }
    let Differences { poses, verdicts, below, above, short, disproved } = differences;
    let labels = ["order", "poses", "engine"];
    let ns = |row: Row<'_>| Some(format!("{:.0}", row.number("ns")));
    println!("{}", rows.table("ns per query; random poses have empty caches", &labels, "n", ns));
    println!(
        "{}",
        rows.table("time over hullmap's, on paths over hullmap warm", &labels, "n", |row| {
            let ours = if row.text("order") == "paths" { "hullmap warm" } else { "hullmap" };
            let is_ours = |other: &Row<'_>| {
                other.text("engine") == ours
                    && ["n", "order", "poses"].iter().all(|name| other.text(name) == row.text(name))
            };
            Some(three_digits(row.number("ns") / rows.iter().find(is_ours)?.number("ns")))
        })
    );
    println!(
        "MuJoCo {}, at most {ITERATIONS} iterations, one point of contact. In {poses} poses, the engines disagree on \
         yes or no in {verdicts}. MuJoCo's depth is above hullmap's interval by at most {above:.0e} of the diameter. \
         It is below the interval in {short}, by at most {below:.0e}. MuJoCo's own normal disproves hullmap's lower \
         bound in {disproved}.\n",
        mujoco.version
    );
    Ok(rows)
}

/// Measures one vertex count.
fn measure(
    arguments: &Arguments,
    mujoco: &MuJoCo,
    n: usize,
    rows: &mut Rows,
    differences: &mut Differences,
) -> Result<(), Box<dyn Error>> {
    let mut times: Vec<[Vec<f64>; Engine::ALL.len()]> = vec![Default::default(); Mix::ALL.len()];
    let mut rng = SplitMix64::new(SEED);
    for pair in FAMILIES.into_iter().filter_map(|family| BakedPair::bake(family, n, SEED)) {
        let poses = pair.poses(arguments.poses, &mut rng);
        let frames = pair.frames(arguments.paths, FRAMES, &mut rng);
        let both: Vec<&Placed> = poses.iter().chain(&frames).collect();
        let mut session = mujoco.start(pair.hulls(), &both)?;
        compare(&pair, &poses, &session, differences);
        for (mix, times) in Mix::ALL.into_iter().zip(&mut times) {
            let mut race = Race { pair: &pair, poses: &poses, frames: &frames, mix, session: &mut session };
            let rounds = (0..arguments.rounds).map(|_| race.round()).collect::<Result<Vec<_>, _>>()?;
            for (engine, times) in times.iter_mut().enumerate() {
                times.extend(median(rounds.iter().map(|round| round[engine]).collect()));
            }
        }
    }
    for (mix, times) in Mix::ALL.into_iter().zip(&times) {
        for (engine, times) in Engine::ALL.into_iter().zip(times) {
            let [order, name] = engine.names();
            // The mean over the families.
            let ns = format!("{:.1}", times.iter().sum::<f64>() / times.len() as f64);
            rows.push(vec![n.to_string(), order.to_owned(), mix.name().to_owned(), name.to_owned(), ns]);
        }
    }
    Ok(())
}

/// Counts the differences of the answers.
fn compare(pair: &BakedPair, poses: &[Placed], session: &Session, differences: &mut Differences) {
    let [a, b] = pair.hulls();
    for (placed, theirs) in poses.iter().zip(&session.contacts) {
        let ours = contact(&a, &b, placed.b_in_a, &Settings::default(), &mut Cache::default());
        let depth = theirs.map_or(0.0, |(depth, _)| depth);
        let is_clear = ours.depth_upper.max(depth) > 1e-6 * pair.diameter();
        differences.poses += 1;
        differences.verdicts += usize::from(ours.hit != theirs.is_some() && is_clear);
        if let Some((depth, normal)) = theirs.filter(|_| ours.hit) {
            differences.below = differences.below.max((ours.depth_lower - depth) / pair.diameter());
            differences.above = differences.above.max((depth - ours.depth_upper) / pair.diameter());
            // The length by which B must move along the normal to leave A.
            let needed = Minkowski::new(&a, &b, placed.b_in_a).support(normal).w.dot(normal);
            let allowed = ROUNDING * pair.diameter();
            differences.disproved += usize::from(needed < ours.depth_lower - allowed);
            differences.short += usize::from(depth < ours.depth_lower - allowed);
        }
    }
}

/// A pair of hulls, and a selection of its poses and paths. Classes alternate in both.
struct Race<'s> {
    pair: &'s BakedPair,
    poses: &'s [Placed],
    frames: &'s [Placed],
    mix: Mix,
    session: &'s mut Session,
}

impl Race<'_> {
    /// Nanoseconds per query, by engine.
    fn round(&mut self) -> Result<[f64; Engine::ALL.len()], Box<dyn Error>> {
        let ([a, b], [p, q]) = (self.pair.hulls(), self.pair.polyhedra());
        let (settings, identity) = (Settings::default(), math::Pose::IDENTITY);
        let (first, step) = self.mix.stride();
        let (poses, frames) = (self.mix.select(self.poses), self.mix.select(self.frames));
        let (count, all) = (self.poses.len(), self.poses.len() + self.frames.len());
        let mut caches = vec![Cache::default(); frames.len() / FRAMES];
        let paths = caches.len();
        let mut ns = [0.0; Engine::ALL.len()];
        for engine in Engine::ALL {
            let cold = |_: usize, placed: &Placed| {
                black_box(contact(&a, &b, placed.b_in_a, &settings, &mut Cache::default()));
            };
            ns[engine as usize] = match engine {
                Engine::Cold => second_pass(&poses, cold),
                Engine::PathCold => second_pass(&frames, cold),
                Engine::MuJoCo => self.session.time_ns(first, count, step)?,
                Engine::PathMuJoCo => self.session.time_ns(count + first, all, step)?,
                Engine::Parry => second_pass(&poses, |_, placed| {
                    let _ = black_box(query::contact(&identity, p, &placed.parry, q, 0.0));
                }),
                Engine::PathWarm => second_pass(&frames, |i, placed| {
                    let cache = &mut caches[i % paths];
                    if i < paths {
                        *cache = Cache::default();
                    }
                    black_box(contact(&a, &b, placed.b_in_a, &settings, cache));
                }),
            };
        }
        Ok(ns)
    }
}

/// Nanoseconds per item of the second of two passes, so that every engine finds its data and code
/// in the processor's caches.
fn second_pass(items: &[Placed], mut query: impl FnMut(usize, &Placed)) -> f64 {
    let mut pass = || items.iter().enumerate().for_each(|(i, placed)| query(i, placed));
    pass();
    time_ns(pass) / items.len() as f64
}
