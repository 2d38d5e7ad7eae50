//! `bake build --remote`, with a server of the Remote Execution API in this process.

mod build;
mod farm_server;
mod hostile;
mod tls;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use hullmap_outside::command::{Run, built, finished};

/// The command with the feature `remote`.
fn binary() -> &'static Path {
    static BINARY: LazyLock<PathBuf> = LazyLock::new(|| built(&["--features", "hullmap-cli/remote"]));
    &BINARY
}

fn run(folder: &Path, line: &str) -> Run {
    finished(Command::new(binary()).args(line.split_whitespace()).current_dir(folder))
}
