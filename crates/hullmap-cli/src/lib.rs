//! The `bake` command as a library, for bindings that run it in their own process.
//!
//! `hullmap-pipeline` bakes, verifies and writes; this crate reads arguments and prints rows.
//!
//! | module | concept |
//! |---|---|
//! | `args` | subcommands and flags |
//! | `commands` | one module per subcommand |
//! | `rows`, `progress` | what a build prints, and shows meanwhile |
//! | `scene` | colliders that are added to glTF files |
//! | `selection` | hulls named on the command line |
//! | `terminal`, `table` | all text output, escaped |
//! | `interrupt` | Ctrl-C |

#![forbid(unsafe_code)]
// All text is printed by `terminal`.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod args;
mod commands;
mod depfile;
mod interrupt;
mod pair;
mod pose;
mod progress;
mod rows;
mod scene;
mod selection;
mod source_mesh;
mod table;
mod terminal;

use std::ffi::OsString;

use args::export::Target;
use args::{Cli, Command, Farm};
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::runner;
use terminal::Output;

/// Runs the command with these words, the name of the program (for help texts) first, and returns
/// its exit code.
///
/// Results go to standard output, messages to standard error. While meshes are baked, Ctrl-C ends
/// the process with exit code 130, and unfinished packs are removed.
pub fn run<W: Into<OsString> + Clone>(words: impl IntoIterator<Item = W>) -> u8 {
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    terminal::paint(args::color(&words));
    let cli = match args::parse(&words) {
        Ok(cli) => cli,
        Err(error) => {
            // A closed terminal is no reason to panic.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(Exit::Usage as u8);
        }
    };
    terminal::silence(cli.command.is_quiet());
    let work = || run_command(&cli, &args::program(&words));
    match cli.command.threads().map(|count| runner::threads(Some(count))) {
        None => work(),
        Some(Ok(pool)) => pool.install(work),
        Some(Err(failure)) => {
            terminal::error(&failure);
            failure.exit as u8
        }
    }
}

fn run_command(cli: &Cli, program: &str) -> u8 {
    let mut out = Output::standard();
    let result = dispatch(cli, program, &mut out).and_then(|exit| end(exit, out.flush().map_err(Into::into)));
    match result {
        Ok(exit) => exit as u8,
        Err(failure) => {
            if !failure.message.is_empty() {
                // Output written before the failure comes before its message.
                let _ = out.flush();
                terminal::error(&failure);
            }
            failure.exit as u8
        }
    }
}

fn dispatch(cli: &Cli, program: &str, out: &mut Output) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Build(args) => commands::build::run(args, out),
        Command::Decompose(args) => commands::decompose::run(args, out),
        Command::Farm(Farm::Build(args)) => commands::build::run(&args.build, out),
        Command::Farm(Farm::Key(args)) => commands::key::run(args, out),
        Command::Farm(Farm::Plan(args)) => commands::plan::run(args, out),
        Command::Farm(Farm::Task(args)) => commands::task::run(args, out),
        Command::Farm(Farm::Status(args)) => commands::status::run(args, out),
        Command::Verify(args) => commands::verify::run(args, out),
        Command::Inspect(args) => commands::inspect::run(args, out),
        Command::Export(args) if args.target == Some(Target::Usd) => commands::export::usd::run(args, out),
        Command::Export(args) => commands::export::run(args, out),
        Command::Robot(args) => commands::robot::run(args, out),
        Command::Query(args) => commands::query::run(args, out),
        Command::Report(args) => commands::report::run(args, out),
        Command::Init(args) => commands::init::run(args, out),
        Command::Completions(args) => commands::completions::run(args, program, out),
        Command::Man(args) => commands::man::run(args, program),
    }
}
