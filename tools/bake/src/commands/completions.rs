//! `bake completions`: completion scripts for shells.

use clap::CommandFactory;

use crate::args::{Cli, CompletionsArgs};
use crate::outcome::{Exit, Failure, end};
use crate::terminal::Output;

/// Runs the command.
///
/// # Errors
/// The script cannot be written.
pub fn run(args: &CompletionsArgs, out: &mut Output) -> Result<Exit, Failure> {
    // Into memory first: the generator panics if it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "bake", &mut script);
    end(Exit::Done, out.verbatim(&script).map_err(Into::into))
}
