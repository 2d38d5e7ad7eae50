//! Time to open a pack, with each degree of checking.

use std::{error::Error, path::PathBuf};

use clap::Parser;
use hullmap_bench::{
    csv::Csv,
    machine::Machine,
    matrix::Matrix,
    opening::{self, Sample, WAYS},
    output,
};
use shapes::families::Family;

/// Times the functions that open a pack, on packs of 10 kB to 100 MB and on one of 100,000 hulls.
///
/// The files are in memory. With the feature `parallel`, opening uses all processors. Tables go to
/// standard output.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin opening-table -- --rounds 21")]
struct Arguments {
    /// Number of rounds; the result is the median
    #[arg(long, default_value_t = 11)]
    rounds: usize,
    /// Only packs of up to a few MB
    #[arg(long)]
    quick: bool,
    /// Also write the table as markdown, with facts about the machine, and as CSV beside it
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
    let mut table = Matrix::new("Opening, ms (ms per GB)", "pack");
    let ways: Vec<String> = WAYS.iter().map(|(name, _)| format!("{name}_ms")).collect();
    let facts = ["family", "points", "hulls", "megabytes"].map(str::to_owned);
    let header: Vec<String> = facts.into_iter().chain(ways).collect();
    let mut csv = Csv::new(&header.iter().map(String::as_str).collect::<Vec<_>>());
    for sample in samples {
        let file = sample.bake()?;
        let timings = opening::time(&file, folder.path(), rounds.max(1))?;
        let megabytes = file.len() as f64 / 1e6;
        let Sample { family, points, hulls } = sample;
        let row = format!("{} {points} × {hulls}, {megabytes:.2} MB", family.name());
        let megabytes_text = format!("{megabytes:.2}");
        let mut line = vec![family.name().to_owned(), points.to_string(), hulls.to_string(), megabytes_text];
        for ((name, _), timing) in WAYS.iter().zip(timings) {
            let milliseconds = timing.median_ns / 1e6;
            line.push(format!("{milliseconds:.4}"));
            table.set(&row, name, format!("{milliseconds:.3} ({:.0})", milliseconds * 1e3 / megabytes));
        }
        csv.line(&line);
        eprintln!("{row}");
    }
    println!("{}", table.to_text());
    let machine = Machine::here().to_markdown();
    let threads = if cfg!(feature = "parallel") { "all processors" } else { "one thread" };
    eprint!("{machine}");
    if let Some(path) = out {
        output::write(&path, &format!("# Opening, {threads}\n\n{machine}\n{}", table.to_markdown()))?;
        output::write(&path.with_extension("csv"), csv.as_str())?;
    }
    Ok(())
}
