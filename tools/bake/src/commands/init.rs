//! `bake init`: a `hullmap.toml` to start from.

use std::io::{self, Write};

use crate::args::InitArgs;
use crate::config::{FILE_NAME, TEMPLATE};
use crate::outcome::{Exit, Failure, end};
use crate::pack_file::{put_in_free_place, write_beside};

/// Runs the command.
///
/// # Errors
/// The file is there already, or cannot be written.
pub fn run(args: &InitArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    let path = args.folder.join(FILE_NAME);
    let shown = path.strip_prefix(".").unwrap_or(&path).display();
    // Whole or not at all: half a file would stand in the way of the next try.
    let made = write_beside(&path, TEMPLATE.as_bytes()).and_then(|file| put_in_free_place(file, &path));
    made.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => {
            Failure::usage(format!("{shown}: is there already and was left as it is; remove it first to start anew"))
        }
        _ => Failure::usage(format!("{shown}: cannot write: {error}; name a folder that is there")),
    })?;
    end(Exit::Done, writeln!(out, "{shown} written: every option with its default, commented out").map_err(Into::into))
}
