//! The `bake` command as a library: bakes meshes into `.hullmap` packs, and verifies, inspects,
//! exports, queries and reports on packs.
//!
//! [`run`] is the whole command. Bindings call it, or bake in memory with [`bake_arrays`] and
//! [`bake_file`]. Without the feature `command` only the latter remain, also for WebAssembly.
//!
//! | module | concept |
//! |---|---|
//! | `args` | subcommands and flags |
//! | `commands` | one module per subcommand |
//! | `jobs` | the meshes to bake, with options and packs; in shards, batches and tasks |
//! | `runner` | bakes jobs, or takes their packs from a cache |
//! | `options` | the options that shape a pack, in one table with their defaults |
//! | `config` | `hullmap.toml` |
//! | `glob` | globs that select meshes |
//! | `baker` | all calls into `hullmap-bake` |
//! | `content` | what a source holds, a mesh or a terrain: read, imported, verified |
//! | `triangle_mesh` | triangle meshes: how they are baked, and what is counted |
//! | `budget` | what physics engines accept of a hull |
//! | `in_memory` | bakes that write no file, for bindings |
//! | `mesh_file` | hulls as files of meshes: OBJ, GLB, STL, USD |
//! | `scene` | colliders that are added to glTF files |
//! | `principal_axes` | principal axes of an inertia tensor |
//! | `packs`, `selection` | packs and hulls named on the command line |
//! | `source` | finds the source of a pack |
//! | `project` | the folder outside of which no source is read |
//! | `terminal` | all text output, escaped |
//! | `pack_file`, `interrupt` | files that are complete or absent at every moment |

#![forbid(unsafe_code)]
// Bakes in memory use a part of the modules that they share with the command.
#![cfg_attr(not(feature = "command"), allow(dead_code))]
// All text is printed by `terminal`.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

#[cfg(feature = "command")]
mod args;
mod baker;
mod budget;
#[cfg(feature = "command")]
mod commands;
#[cfg(feature = "command")]
mod config;
#[cfg(feature = "command")]
mod content;
#[cfg(feature = "command")]
mod depfile;
#[cfg(feature = "command")]
mod glob;
mod in_memory;
#[cfg(feature = "command")]
mod interrupt;
#[cfg(feature = "command")]
mod jobs;
#[cfg(feature = "command")]
mod mesh_file;
#[cfg(feature = "command")]
mod open;
mod options;
#[cfg(feature = "command")]
mod outcome;
#[cfg(feature = "command")]
mod pack_file;
#[cfg(feature = "command")]
mod packs;
#[cfg(feature = "command")]
mod pair;
#[cfg(feature = "command")]
mod pose;
#[cfg(feature = "command")]
mod principal_axes;
#[cfg(feature = "command")]
mod project;
#[cfg(feature = "command")]
mod runner;
#[cfg(feature = "command")]
mod scene;
#[cfg(feature = "command")]
mod selection;
#[cfg(feature = "command")]
mod source;
#[cfg(feature = "command")]
mod source_mesh;
#[cfg(feature = "command")]
mod table;
#[cfg(feature = "command")]
mod terminal;
mod triangle_mesh;

#[cfg(feature = "command")]
use std::ffi::OsString;

#[cfg(feature = "command")]
use args::export::Target;
#[cfg(feature = "command")]
use args::{Cli, Command};
pub use baker::BakedPack;
pub use hullmap_bake::progress::{Progress, Stage};
pub use hullmap_verify::estimates::{DecomposedObject, PartsEstimates};
pub use in_memory::{InMemoryError, bake_arrays, bake_file, bake_level, bake_source, without_flags};
#[cfg(feature = "command")]
pub use mesh_file::usda;
#[cfg(feature = "command")]
use outcome::{Exit, Failure, end};
#[cfg(feature = "command")]
use terminal::Output;
pub use triangle_mesh::{BakedTriangles, EdgeCounts, MeshSummary};

/// Runs the command with these words, the name of the program (for help texts) first, and returns
/// its exit code.
///
/// Results go to standard output, messages to standard error. While meshes are baked, Ctrl-C ends
/// the process with exit code 130, and unfinished packs are removed.
#[cfg(feature = "command")]
pub fn run<W: Into<OsString> + Clone>(words: impl IntoIterator<Item = W>) -> u8 {
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    let cli = match args::parse(&words) {
        Ok(cli) => cli,
        Err(error) => {
            // A closed terminal is no reason to panic.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(Exit::Usage as u8);
        }
    };
    let mut out = Output::standard();
    let result =
        dispatch(&cli, &args::program(&words), &mut out).and_then(|exit| end(exit, out.flush().map_err(Into::into)));
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

#[cfg(feature = "command")]
fn dispatch(cli: &Cli, program: &str, out: &mut Output) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Build(args) | Command::Terrain(args) => commands::build::run(args, out),
        Command::Decompose(args) => commands::decompose::run(args, out),
        Command::Key(args) => commands::key::run(args, out),
        Command::Plan(args) => commands::plan::run(args, out),
        Command::Task(args) => commands::task::run(args, out),
        Command::Status(args) => commands::status::run(args, out),
        Command::Verify(args) => commands::verify::run(args, out),
        Command::Inspect(args) => commands::inspect::run(args, out),
        Command::Export(args) if args.target == Some(Target::Usd) => commands::export::usd::run(args, out),
        Command::Export(args) => commands::export::run(args, out),
        Command::Robot(args) => commands::robot::run(args, out),
        Command::Query(args) => commands::query::run(args, out),
        Command::Report(args) => commands::report::run(args, out),
        Command::Init(args) => commands::init::run(args, out),
        Command::Completions(args) => commands::completions::run(args, program, out),
    }
}
