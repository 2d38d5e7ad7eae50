//! Height fields in the commands: `bake build --height-field`, and `.hullfield` files as inputs of
//! `inspect`, `verify`, `export` and `report`.

mod bake;
mod build;
mod export;
mod inspect;
mod open;
mod options;
mod report;
mod source;
mod verify;

use std::path::{Path, PathBuf};

use hullmap_format::height_field::EXTENSION;

use crate::args::Command;
use crate::outcome::{Exit, Failure};
use crate::terminal::Output;

/// Runs a command whose inputs are height fields; `None` if they are not.
pub fn run(command: &Command, out: &mut Output) -> Option<Result<Exit, Failure>> {
    let inputs: &[PathBuf] = match command {
        Command::Build(args) if args.height_field.is_set => return Some(build::run(args, out)),
        Command::Inspect(args) => &args.inputs,
        Command::Verify(args) => &args.inputs,
        Command::Export(args) => &args.packs,
        Command::Report(args) => std::slice::from_ref(&args.input),
        _ => return None,
    };
    match inputs.iter().filter(|input| is_field(input)).count() {
        0 => return None,
        count if count < inputs.len() => {
            let message = format!("height fields and other files: name the .{EXTENSION} files in a run of their own");
            return Some(Err(Failure::usage(message)));
        }
        _ => {}
    }
    Some(match command {
        Command::Inspect(args) => inspect::run(args, out),
        Command::Verify(args) => verify::run(args, out),
        Command::Export(args) => export::run(args, out),
        Command::Report(args) => report::run(args, out),
        _ => return None,
    })
}

fn is_field(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION) && !path.is_dir()
}
