//! The `bake` command.

#[allow(dead_code, reason = "the commands that use it follow")]
mod import;
mod options;

fn main() {}
