//! `bake completions`: completion scripts for shells.

use std::io::Write;

use clap::CommandFactory;

use crate::args::{Cli, CompletionsArgs};
use crate::outcome::{Exit, Failure, end};

/// Runs the command.
///
/// # Errors
/// The script cannot be written.
pub fn run(args: &CompletionsArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    // Into memory first: the generator panics if it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "bake", &mut script);
    end(Exit::Done, out.write_all(&script).map_err(Into::into))
}
