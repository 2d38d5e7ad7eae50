//! `bake man`: manual pages for `man`, one for each command.

use crate::args::{self, ManArgs};
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::pack_file::make_folder;

pub fn run(args: &ManArgs, program: &str) -> Result<Exit, Failure> {
    let program = program.rsplit(' ').next().unwrap_or(program).to_owned();
    let command = args::whole(args::options::without_keys(&args::command(&program))).name(program);
    let made = make_folder(&args.folder).and_then(|()| clap_mangen::generate_to(command, &args.folder));
    made.map(|_| Exit::Done).map_err(|error| {
        Failure::usage(format!("{}: cannot write the manual pages: {error}; check the path", args.folder.display()))
    })
}
