//! The `bake` command. All of its code is in the library beside it.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(hullmap_cli::run(std::env::args_os()))
}
