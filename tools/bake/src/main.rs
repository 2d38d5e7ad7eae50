//! The `bake` command: meshes to `.hullmap` packs, and questions about them.
//!
//! `args` says what may be asked, `commands` answers it. `config` reads `hullmap.toml`; `option_layer` and `options` hold what
//! shapes a bake. `verification` measures how exact a pack is, `advice` says what a user should look at. The work itself is done by
//! the crates `hullmap-import`, `hullmap-bake` (in `baker`) and `hullmap` (in `open` and `pair`).

#![forbid(unsafe_code)]

mod advice;
mod args;
mod baker;
mod commands;
mod config;
mod depfile;
mod interrupt;
mod messages;
mod open;
mod option_layer;
mod options;
mod outcome;
mod pack_file;
mod packs;
mod pair;
mod pose;
mod selection;
mod source;
mod table;
mod verification;

use std::io::{BufWriter, Write, stdout};
use std::process::ExitCode;

use args::{Cli, Command};
use outcome::{Exit, Failure, end};

fn main() -> ExitCode {
    let cli = args::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    let mut out = BufWriter::new(stdout().lock());
    let result = run(&cli, &mut out).and_then(|exit| end(exit, out.flush().map_err(Into::into)));
    match result {
        Ok(exit) => exit.into(),
        Err(failure) => {
            if !failure.message.is_empty() {
                // What was written before the failure stands before its message.
                let _ = out.flush();
                messages::error(&failure);
            }
            failure.exit.into()
        }
    }
}

fn run(cli: &Cli, out: &mut dyn Write) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Build(args) => commands::build::run(args, out),
        Command::Verify(args) => commands::verify::run(args, out),
        Command::Inspect(args) => commands::inspect::run(args, out),
        Command::Query(args) => commands::query::run(args, out),
        Command::Report(args) => commands::report::run(args, out),
        Command::Init(args) => commands::init::run(args, out),
        Command::Completions(args) => commands::completions::run(args, out),
    }
}
