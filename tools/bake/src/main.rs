//! The `bake` command: bakes meshes into `.hullmap` packs, and verifies, inspects, exports,
//! queries and reports on packs.
//!
//! | module | concept |
//! |---|---|
//! | `args` | subcommands and flags |
//! | `commands` | one module per subcommand |
//! | `options` | the options that shape a pack, in one table with their defaults |
//! | `config` | `hullmap.toml` |
//! | `glob` | globs that select meshes |
//! | `baker` | all calls into `hullmap-bake` |
//! | `verification` | how exact a pack is |
//! | `advice` | warnings about hulls |
//! | `geometry` | vertices and faces as lists |
//! | `packs`, `selection` | packs and hulls named on the command line |
//! | `source` | the way back from a pack to its source |
//! | `project` | the folder that the way back must not leave |
//! | `terminal` | the only way out for text |
//! | `pack_file`, `interrupt` | files that are complete or absent at every moment |

#![forbid(unsafe_code)]
// Text leaves through `terminal` alone.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod advice;
mod args;
mod baker;
mod commands;
mod config;
mod depfile;
mod geometry;
mod glob;
mod interrupt;
mod open;
mod options;
mod outcome;
mod pack_file;
mod packs;
mod pair;
mod pose;
mod project;
mod selection;
mod source;
mod table;
mod terminal;
mod verification;

use std::process::ExitCode;

use args::{Cli, Command};
use outcome::{Exit, Failure, end};
use terminal::Output;

fn main() -> ExitCode {
    let cli = args::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    let mut out = Output::standard();
    let result = run(&cli, &mut out).and_then(|exit| end(exit, out.flush().map_err(Into::into)));
    match result {
        Ok(exit) => exit.into(),
        Err(failure) => {
            if !failure.message.is_empty() {
                // Output written before the failure comes before its message.
                let _ = out.flush();
                terminal::error(&failure);
            }
            failure.exit.into()
        }
    }
}

fn run(cli: &Cli, out: &mut Output) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Build(args) => commands::build::run(args, out),
        Command::Verify(args) => commands::verify::run(args, out),
        Command::Inspect(args) => commands::inspect::run(args, out),
        Command::Export(args) => commands::export::run(args, out),
        Command::Query(args) => commands::query::run(args, out),
        Command::Report(args) => commands::report::run(args, out),
        Command::Init(args) => commands::init::run(args, out),
        Command::Completions(args) => commands::completions::run(args, out),
    }
}
