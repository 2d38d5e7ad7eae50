//! Support queries beside parry3d: time in four modes, regret, bytes and build time, of all index
//! kinds in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bench::{
    directions,
    eviction::Eviction,
    machine::Machine,
    measure::{self, Effort, Mode},
    output,
    query::Contestant,
    regret::Truth,
    report::{Record, Report},
    rivals,
    subject::{FAMILIES, SEED, Subject},
};
use shapes::families::{Family, MIN_POINTS};

/// Vertex counts of the full table, and of the quick one.
const COUNTS: [usize; 10] = [8, 32, 128, 256, 512, 1024, 2048, 8192, 32_768, 65_536];
const QUICK_COUNTS: [usize; 4] = [8, 128, 1024, 8192];

/// Families of the quick table.
const QUICK_FAMILIES: [Family; 3] = [Family::Sphere, Family::Rock, Family::Prism];

/// Number of directions in which answers are judged, and in a quick table.
const JUDGED: usize = 4_000;
const QUICK_JUDGED: usize = 1_000;

/// Compares support queries with parry3d's, in one run.
///
/// Tables go to standard output, progress to standard error.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  cargo run --release -p hullmap-bench --bin support-table -- --families rock,prism --n 128,8192"
)]
struct Arguments {
    /// Short table: three families, four vertex counts, less time each
    #[arg(long)]
    quick: bool,
    /// Families, separated by commas [default: all eight; with --quick: sphere,rock,prism]
    #[arg(long, value_delimiter = ',', value_parser = family)]
    families: Vec<Family>,
    /// Point counts, separated by commas [default: 8 to 65536]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(MIN_POINTS as i64..))]
    n: Vec<u32>,
    /// Also write one table for each family as markdown, with facts about the machine, and as CSV
    /// beside it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn family(name: &str) -> Result<Family, String> {
    Family::from_name(name).filter(|f| FAMILIES.contains(f)).ok_or_else(|| {
        let names: Vec<&str> = FAMILIES.iter().map(|f| f.name()).collect();
        format!("unknown family; expected one of {}", names.join(", "))
    })
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let report = measure_all(&arguments);
    print!("{}", report.to_text());
    let machine = Machine::here();
    eprint!("{}", machine.to_markdown());
    let markdown = || format!("# Support queries\n\n{}\n{}", machine.to_markdown(), report.to_markdown());
    let write = |path: &PathBuf| {
        output::write(path, &markdown())?;
        output::write(&path.with_extension("csv"), report.to_csv().as_str())
    };
    match arguments.out.as_ref().map_or(Ok(()), write) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn measure_all(arguments: &Arguments) -> Report {
    let quick = arguments.quick;
    let families = match (arguments.families.is_empty(), quick) {
        (false, _) => arguments.families.clone(),
        (true, true) => QUICK_FAMILIES.to_vec(),
        (true, false) => FAMILIES.to_vec(),
    };
    let counts: Vec<usize> = match (arguments.n.is_empty(), quick) {
        (false, _) => arguments.n.iter().map(|&n| n as usize).collect(),
        (true, true) => QUICK_COUNTS.to_vec(),
        (true, false) => COUNTS.to_vec(),
    };
    let effort = if quick { Effort::QUICK } else { Effort::FULL };
    let judged = if quick { QUICK_JUDGED } else { JUDGED };
    let mut eviction = Eviction::new();
    let mut report = Report::default();
    let start = Instant::now();
    for family in families {
        for &n in &counts {
            eprintln!("{:5.1} s  {} {n}", start.elapsed().as_secs_f64(), family.name());
            report.records.extend(measure_one(family, n, effort, judged, &mut eviction));
        }
    }
    eprintln!("{:5.1} s  done", start.elapsed().as_secs_f64());
    report
}

fn measure_one(family: Family, n: usize, effort: Effort, judged: usize, eviction: &mut Eviction) -> Vec<Record> {
    let subject = Subject::new(family, n, SEED);
    let mut entries = rivals::enter(&subject);
    let truth = Truth::new(&subject, directions::awkward(&subject, judged, SEED));
    let record = |entry: &dyn Contestant| Record {
        family,
        n,
        vertices: subject.vertex_count(),
        rival: entry.name().to_owned(),
        index_bytes: entry.index_bytes(),
        build_ms: entry.build_time().map(|time| time.as_secs_f64() * 1e3),
        max_regret: truth.max_regret(&entry.answers(truth.dirs())),
        timings: Vec::new(),
    };
    let mut records: Vec<Record> = entries.iter().map(|entry| record(entry.as_ref())).collect();
    for mode in Mode::ALL {
        let timings = measure::time(&mut entries, mode, effort, eviction, SEED);
        for (record, timing) in records.iter_mut().zip(timings) {
            record.timings.push((mode, timing));
        }
    }
    records
}
