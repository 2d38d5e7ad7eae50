//! `bake init`: writes a `hullmap.toml` with every option commented out.

use std::io;

use crate::args::InitArgs;
use crate::terminal::Output;
use hullmap_pipeline::config::FILE_NAME;
use hullmap_pipeline::options::template;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{put_in_free_place, write_beside};

pub fn run(args: &InitArgs, out: &mut Output) -> Result<Exit, Failure> {
    let path = args.folder.join(FILE_NAME);
    let shown = path.strip_prefix(".").unwrap_or(&path).display();
    // Atomically: a partial file would block the next attempt.
    let made = write_beside(&path, template().as_bytes()).and_then(|file| put_in_free_place(file, &path));
    made.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => {
            Failure::usage(format!("{shown}: already exists and was not changed; remove it first"))
        }
        _ => Failure::usage(format!("{shown}: cannot write: {error}; name an existing folder")),
    })?;
    end(
        Exit::Done,
        out.line(format_args!("{shown}: written, with every option at its default and commented out"))
            .map_err(Into::into),
    )
}
