//! Contact, intersection and distance beside parry3d on the same hulls, in one run.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_bench::{
    machine::Machine,
    output,
    solver::{
        race::{self, Effort, Record},
        tables, targets,
    },
};
use shapes::families::MIN_POINTS;

/// Vertex counts of a quick table.
const QUICK_COUNTS: [usize; 3] = [8, 128, 2_048];

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
    /// Print the project's goals for these times, too; a missed goal is not an error
    #[arg(long)]
    goals: bool,
    /// Also write the tables as markdown, with facts about the machine, and as CSV beside it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let records = measure(&arguments);
    let tables = tables::all(&records);
    tables.iter().for_each(|table| println!("{}", table.to_text()));
    if arguments.goals {
        let [reached, of] = tables::reached(&records);
        println!("{}\n{reached} of {of} goals reached", tables::goals(&records).to_text());
    }
    let machine = Machine::here();
    eprint!("{}", machine.to_markdown());
    let sections: Vec<String> = tables.iter().map(|table| table.to_markdown()).collect();
    let markdown = format!("# Contact, intersects and distance\n\n{}\n{}", machine.to_markdown(), sections.join("\n"));
    let write = |path: PathBuf| {
        output::write(&path, &markdown)?;
        let answers = path.with_file_name(format!("{}-answers.csv", path.file_stem().unwrap_or_default().display()));
        output::write(&answers, tables::answers_to_csv(&records).as_str())?;
        output::write(&path.with_extension("csv"), tables::to_csv(&records).as_str())
    };
    match arguments.out.map_or(Ok(()), write) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn measure(arguments: &Arguments) -> Vec<Record> {
    let counts: Vec<usize> = match (arguments.n.is_empty(), arguments.quick) {
        (false, _) => arguments.n.iter().map(|&n| n as usize).collect(),
        (true, true) => QUICK_COUNTS.to_vec(),
        (true, false) => targets::COUNTS.to_vec(),
    };
    let start = Instant::now();
    let record = |n: usize| {
        eprintln!("{:5.1} s  {n}", start.elapsed().as_secs_f64());
        race::run(n, if arguments.quick { Effort::QUICK } else { Effort::full(n) })
    };
    let records = counts.into_iter().map(record).collect();
    eprintln!("{:5.1} s  done", start.elapsed().as_secs_f64());
    records
}
