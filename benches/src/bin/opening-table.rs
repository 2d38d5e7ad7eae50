//! Opening a pack, the three ways.

use std::{error::Error, path::PathBuf};

use clap::Parser;
use hullmap_bench::{
    machine::Machine,
    matrix::Matrix,
    opening::{self, Sample, WAYS},
    output,
};
use shapes::families::Family;

/// Times Pack::open, Pack::open_skipping_contents and Pack::open_skipping_checks on packs of 10 kB to 100 MB, and of 100,000 hulls.
///
/// The files are in memory. With the feature `parallel`, opening uses all processors. Tables go to standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin opening-table -- --rounds 21")]
struct Arguments {
    /// Times each way is timed; the median counts
    #[arg(long, default_value_t = 11)]
    rounds: usize,
    /// Packs up to some MB alone
    #[arg(long)]
    quick: bool,
    /// Also write the table as markdown, with the machine's name
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { rounds, quick, out } = Arguments::parse();
    let sample = |family, points, hulls| Sample { family, points, hulls };
    let mut samples = Vec::new();
    for family in [Family::Sphere, Family::Rock, Family::Prism] {
        samples.extend([sample(family, 128, 1), sample(family, 4096, 4)]);
        if !quick {
            samples.extend([sample(family, 16_384, 20), sample(family, 16_384, 60)]);
        }
    }
    samples.push(sample(Family::Sphere, 8, if quick { 1000 } else { 100_000 }));

    let folder = tempfile::tempdir()?;
    let mut table = Matrix::new("Opening, ms (ms a GB)", "pack");
    for sample in samples {
        let file = sample.bake()?;
        let timings = opening::time(&file, folder.path(), rounds.max(1))?;
        let megabytes = file.len() as f64 / 1e6;
        let Sample { family, points, hulls } = sample;
        let row = format!("{} {points} × {hulls}, {megabytes:.2} MB", family.name());
        for ((name, _), timing) in WAYS.iter().zip(timings) {
            let milliseconds = timing.median_ns / 1e6;
            table.set(&row, name, format!("{milliseconds:.3} ({:.0})", milliseconds * 1e3 / megabytes));
        }
        eprintln!("{row}");
    }
    println!("{}", table.to_text());
    let machine = Machine::here().to_markdown();
    let threads = if cfg!(feature = "parallel") { "all processors" } else { "one thread" };
    eprint!("{machine}");
    if let Some(path) = out {
        output::write(&path, &format!("# Opening, {threads}\n\n{machine}\n{}", table.to_markdown()))?;
    }
    Ok(())
}
