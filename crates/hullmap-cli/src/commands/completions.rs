//! `bake completions`: completion scripts for shells.

use crate::args::{self, CompletionsArgs};
use crate::terminal::Output;
use hullmap_pipeline::outcome::{Exit, Failure, end};

pub fn run(args: &CompletionsArgs, program: &str, out: &mut Output) -> Result<Exit, Failure> {
    let program = program.rsplit(' ').next().unwrap_or(program);
    // Into memory first: the generator panics if it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(
        args.shell,
        &mut args::options::without_keys(&args::command(program)),
        program,
        &mut script,
    );
    end(Exit::Done, out.verbatim(&script).map_err(Into::into))
}
