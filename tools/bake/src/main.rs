//! The `bake` command.
#![allow(dead_code)]

mod args;
mod import;
mod options;
mod outcome;
mod pose;
mod runtime;
mod table;
mod verification;

fn main() {}
