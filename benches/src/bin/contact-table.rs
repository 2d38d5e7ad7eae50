//! Contact, intersection and distance beside parry3d on the same hulls, in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bench::{
    rows::{Row, finish},
    solver::race::{self, Effort},
    solver::tables,
};
use shapes::families::MIN_POINTS;

/// Vertex counts of the full table, and of a quick one.
const COUNTS: [u32; 7] = [8, 32, 128, 512, 2_048, 8_192, 32_768];
const QUICK_COUNTS: [u32; 3] = [8, 128, 2_048];

/// Compares contact, intersects and distance with parry3d's, on sphere, ellipsoid and rock hulls.
///
/// A third of the poses penetrate, a third are within 2 % of touching, a third are separated.
/// Tables go to standard output, progress to standard error.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo run --release -p hullmap-bench --bin contact-table -- --n 128,8192")]
struct Arguments {
    /// Short table: three vertex counts, few poses and rounds
    #[arg(long)]
    quick: bool,
    /// Point counts, separated by commas [default: 8 to 32768; with --quick: 8,128,2048]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(MIN_POINTS as i64..))]
    n: Vec<u32>,
    /// Also write the times as CSV, and the comparison of the answers as FILE-answers.csv beside it
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let Arguments { quick, mut n, out } = Arguments::parse();
    if n.is_empty() {
        n = if quick { QUICK_COUNTS.to_vec() } else { COUNTS.to_vec() };
    }
    let start = Instant::now();
    let record = |n: u32| {
        eprintln!("{:5.1} s  {n}", start.elapsed().as_secs_f64());
        race::run(n as usize, if quick { Effort::QUICK } else { Effort::full(n as usize) })
    };
    let records: Vec<_> = n.into_iter().map(record).collect();
    let (times, answers) = (tables::times(&records), tables::answers(&records));
    let show = |title: &str, cell: &dyn Fn(Row<'_>) -> String| {
        println!("{}", times.table(title, &["query", "poses"], "n", |row| Some(cell(row))));
    };
    show("parry3d's time over hullmap's, cold", &|row| row.ratio("parry_ns", "hullmap_ns"));
    show("ns per query, hullmap / parry3d", &|row| {
        format!("{:.0} / {:.0}", row.number("hullmap_ns"), row.number("parry_ns"))
    });
    show("Support calls (maximum) / iterations per query, hullmap, cold", &|row| {
        let [calls, steps] = ["support_calls", "iterations"].map(|column| row.number(column));
        format!("{calls:.1} ({}) / {steps:.1}", row.text("max_support_calls"))
    });
    show("Along paths: ns warm (over cold); support calls cold / warm", &|row| {
        let calls = ["path_cold_support_calls", "path_warm_support_calls"].map(|column| row.number(column));
        let ratio = row.ratio("path_warm_ns", "path_cold_ns");
        format!("{:.0} ({ratio}); {:.1} / {:.1}", row.number("path_warm_ns"), calls[0], calls[1])
    });
    println!("{}", answers.table("Answers", &["measure"], "n", |row| Some(row.text("value").to_owned())));
    let files = out.map(|path| {
        let stem = path.file_stem().unwrap_or_default().display().to_string();
        [(path.with_file_name(format!("{stem}-answers.csv")), &answers), (path, &times)]
    });
    finish(files.as_ref().map_or(&[], |files| files))
}
