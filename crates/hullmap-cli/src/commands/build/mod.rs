//! `bake build`: bakes meshes into packs.
//!
//! 1. [`jobs`](hullmap_pipeline::jobs) finds the meshes, their options and the names of their
//!    packs.
//! 2. [`runner`](hullmap_pipeline::runner) finds packs that are up to date, and bakes the others.
//! 3. [`orphans`] finds packs whose source is gone.

mod once;
mod orphans;
#[cfg(test)]
mod tests;
mod watch;

use std::path::Path;

use crate::args::BuildArgs;
use crate::interrupt;
use crate::terminal::Output;
use hullmap_pipeline::baker::bake_pack;
use hullmap_pipeline::outcome::{Exit, Failure};

/// Runs the command. Fails if an input or `hullmap.toml` cannot be read; found before any work.
/// Failures of single files are reported in their rows and in the exit code.
pub fn run(args: &BuildArgs, out: &mut Output) -> Result<Exit, Failure> {
    interrupt::catch();
    let project = Path::new(".");
    if args.watch {
        return watch::run(args, project, &bake_pack, out);
    }
    once::run(args, project, &bake_pack, out)
}
