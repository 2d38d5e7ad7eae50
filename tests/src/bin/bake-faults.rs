//! Runs any number of bakes with injected faults.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use hullmap_testkit::command::binary;

/// Injects every fault at every system call of a bake, and cuts the power after each operation.
///
/// Counts and failures go to standard output. Exits with 1 if a check fails. Linux only; temporary
/// folders take a few MB.
#[derive(Parser)]
#[command(after_help = "Example:\n  cargo program bake-faults -- --only kill,power")]
struct Arguments {
    /// The command to test [default: built from this workspace]
    #[arg(long)]
    bake: Option<PathBuf>,
    /// Faults to try [default: all]: kill, torn, short, errno=4, errno=5, errno=13, full=28,
    /// full=30, power
    #[arg(long, value_name = "WORD", value_delimiter = ',')]
    only: Vec<String>,
    /// Number of threads [default: all processors]
    #[arg(long)]
    threads: Option<usize>,
    /// Maximum number of failures to print
    #[arg(long, default_value_t = 20)]
    report: usize,
}

fn main() -> ExitCode {
    let Arguments { bake, only, threads, report } = Arguments::parse();
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let bake = bake.unwrap_or_else(|| binary().to_owned());
    let bake = bake.canonicalize().unwrap_or(bake);
    let start = Instant::now();
    let mut wrong = Vec::new();
    let is_tried = |word: &str| only.is_empty() || only.iter().any(|tried| tried == word);

    #[cfg(target_os = "linux")]
    {
        use hullmap_tests::faults::{
            calls,
            inject::{Fault, Injector},
            power,
            project::Project,
        };
        match Injector::build() {
            Err(why) => println!("skipped: faults at system calls, and cuts of the power: {why}"),
            Ok(injector) => {
                for fault in Fault::ALL.into_iter().filter(|fault| is_tried(&fault.to_string())) {
                    let tally = calls::at_every_call(&bake, &injector, threads, |_| fault);
                    println!("{:7.1} s  {fault}: {tally}", start.elapsed().as_secs_f64());
                    wrong.extend(tally.wrong);
                }
                if is_tried("power") {
                    let project = Project::new(&bake);
                    let tally = power::cut(&project, &power::record(&project, &injector), 1);
                    println!("{:7.1} s  {tally}", start.elapsed().as_secs_f64());
                    wrong.extend(tally.wrong);
                }
            }
        }
    }
    wrong.iter().take(report).for_each(|wrong| println!("\n{wrong}"));
    if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
