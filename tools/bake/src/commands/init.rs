//! `bake init`: a `hullmap.toml` to start from.

use std::fs::OpenOptions;
use std::io::{self, Write};

use crate::args::InitArgs;
use crate::config::{FILE_NAME, TEMPLATE};
use crate::outcome::{Exit, Failure, end};

/// Runs the command.
///
/// # Errors
/// The file is there already, or cannot be written.
pub fn run(args: &InitArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    let path = args.folder.join(FILE_NAME);
    let shown = path.strip_prefix(".").unwrap_or(&path).display();
    let made = OpenOptions::new().write(true).create_new(true).open(&path);
    let mut file = made.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => {
            Failure::usage(format!("{shown}: is there already and was left as it is; remove it first to start anew"))
        }
        _ => Failure::usage(format!("{shown}: cannot write: {error}; name a folder that is there")),
    })?;
    file.write_all(TEMPLATE.as_bytes())
        .and_then(|()| file.sync_all())
        .map_err(|error| Failure::usage(format!("{shown}: cannot write: {error}")))?;
    end(Exit::Done, writeln!(out, "{shown} written: every option with its default, commented out").map_err(Into::into))
}
