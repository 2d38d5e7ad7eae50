//! `bake report`: writes the page of a height field.

use hullmap_report::field_page;

use super::inspect;
use super::open::open;
use crate::args::ReportArgs;
use crate::outcome::{Exit, Failure};
use crate::pack_file::{folder_of, make_folder, put_in_place, write_beside};
use crate::terminal::Output;
use hullmap_bake::number::grouped;

pub fn run(args: &ReportArgs, out: &mut Output) -> Result<Exit, Failure> {
    if args.merge || args.shard.is_some() {
        let message = "--shard and --merge require a folder of packs; leave them out for a height field";
        return Err(Failure::usage(format!("{}: {message}", args.input.display())));
    }
    let field = open(&args.input)?;
    let file = args.input.display().to_string();
    let page = field_page(&file, &field, &inspect::facts(&file, &field));
    let target = &args.out;
    let cannot_write =
        |error: std::io::Error| Failure::usage(format!("{}: cannot write: {error}; check the path", target.display()));
    make_folder(folder_of(target)).map_err(cannot_write)?;
    write_beside(target, page.as_bytes()).and_then(|file| put_in_place(file, target)).map_err(cannot_write)?;
    out.line(format_args!("{}: {} bytes", target.display(), grouped(page.len() as u64)))?;
    Ok(Exit::Done)
}
