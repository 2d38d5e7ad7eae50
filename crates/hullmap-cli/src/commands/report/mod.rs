//! `bake report`: baked files on HTML pages.
//!
//! 1. [`input`] opens a pack, finds its source, verifies it and collects remarks.
//! 2. The crate `hullmap-report` turns that into a page; a folder of packs gets a page of cards
//!    that link to them. [`shards`] merges the cards of several machines.
//! 3. Pages are written to temporary files and renamed, the folder's page last, so that its links
//!    are never broken.

mod input;
mod remarks;
mod shards;
mod source;
mod surface;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use hullmap_format::header::FileKind;
use hullmap_report::{Card, folder_page};

use crate::args::ReportArgs;
use crate::terminal::{self, Output};
use hullmap_geometry::number::grouped;
use hullmap_pipeline::jobs::slashed;
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::pack_file::{
    folder_of, link_below, make_folder, put_in_place, sweep, through_link, write_beside,
};
use hullmap_pipeline::packs::{PackPlace, find_packs, kind_by_name};
use hullmap_pipeline::source::{Folders, given_sources};
use input::{Analysed, analyse_file};
use shards::ShardCards;

/// Pages report faults of packs that open, and packs of a folder that do not open.
pub fn run(args: &ReportArgs, out: &mut Output) -> Result<Exit, Failure> {
    if args.out.is_dir() || args.out.file_name().is_none() {
        let message = format!("--out {}: is a folder; name the HTML file to write", args.out.display());
        return Err(Failure::usage(message));
    }
    let places = find_packs(std::slice::from_ref(&args.input))?;
    let sources = given_sources(args.source.as_deref(), &places)?;
    // Temporary files of a killed report.
    sweep(folder_of(&args.out));
    sweep(&args.out.with_file_name(pages_folder(&args.out)));
    if args.input.is_dir() {
        return if args.merge { merge(args, &places, out) } else { report_folder(args, &places, &sources, out) };
    }
    if args.merge || args.shard.is_some() {
        return Err(Failure::usage(format!(
            "{}: is a pack, but --shard and --merge require a folder of packs",
            args.input.display()
        )));
    }
    let mut exit = Exit::Done;
    for (place, given) in places.iter().zip(sources) {
        let pack = analyse_file(place, given, args, &Folders::default())?;
        let page = pack.page(None);
        write_page(&args.out, &page)?;
        print_faults(&pack);
        exit = exit.max(exit_of(&pack));
        let written = out.line(format_args!("{}: {} bytes", args.out.display(), grouped(page.len() as u64)));
        end(exit, written.map_err(Failure::from))?;
    }
    Ok(exit)
}

fn report_folder(
    args: &ReportArgs,
    places: &[PackPlace],
    sources: &[Option<&Path>],
    out: &mut Output,
) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    let mut bytes = 0;
    let mut cards = Vec::new();
    let folders = Folders::default();
    for (place, given) in places.iter().zip(sources) {
        let below = place.path.strip_prefix(&args.input).unwrap_or(&place.path);
        let name = name_of(args, place);
        if args.shard.is_some_and(|shard| !shard.holds(&name)) {
            continue;
        }
        match analyse_file(place, *given, args, &folders) {
            Ok(pack) => {
                let (link, page) = page_in_folder(&pack, below, &args.out);
                let target = folder_of(&args.out).join(&link);
                let pages = folder_of(&args.out).join(pages_folder(&args.out));
                if let Some(link) = link_below(&pages, folder_of(&target)) {
                    return Err(Failure::usage(through_link(&target, &link)));
                }
                write_page(&target, &page)?;
                bytes += page.len();
                print_faults(&pack);
                exit = exit.max(exit_of(&pack));
                cards.push(pack.card(name, slashed(&link)));
            }
            Err(failure) => {
                terminal::error(&failure);
                exit = exit.max(failure.exit);
                cards.push(Card::unopened(name, failure.message));
            }
        }
    }
    let count = cards.len();
    let (target, page) = match args.shard {
        Some(shard) => {
            let target = shards::file(&args.out.with_file_name(pages_folder(&args.out)), shard);
            let cards = ShardCards::new(shard, cards);
            (target, serde_json::to_string(&cards).map_err(|error| Failure::usage(error.to_string()))?)
        }
        None => (args.out.clone(), folder_page(&args.input.display().to_string(), &cards)),
    };
    write_page(&target, &page)?;
    end(exit, print_written(&target, count, bytes + page.len(), out))
}

fn merge(args: &ReportArgs, places: &[PackPlace], out: &mut Output) -> Result<Exit, Failure> {
    let names: Vec<String> = places.iter().map(|place| name_of(args, place)).collect();
    let cards = shards::merged(&args.out.with_file_name(pages_folder(&args.out)), &names)?;
    let page = folder_page(&args.input.display().to_string(), &cards);
    write_page(&args.out, &page)?;
    let exit = if cards.iter().any(Card::is_faulty) { Exit::Rejected } else { Exit::Done };
    end(exit, print_written(&args.out, cards.len(), page.len(), out))
}

/// Path below the folder, without extension. Files other than packs keep it, to differ from these.
fn name_of(args: &ReportArgs, place: &PackPlace) -> String {
    let below = place.path.strip_prefix(&args.input).unwrap_or(&place.path);
    match kind_by_name(below) {
        Some(FileKind::Pack) | None => slashed(&below.with_extension("")),
        Some(FileKind::TriangleMesh | FileKind::HeightField) => slashed(below),
    }
}

fn print_written(file: &Path, count: usize, bytes: usize, out: &mut Output) -> Result<(), Failure> {
    let packs = if count == 1 { "pack" } else { "packs" };
    let file = file.display();
    out.line(format_args!("{file}: {count} {packs}, {} bytes in total", grouped(bytes as u64)))?;
    Ok(())
}

/// The page of the pack at `below` the input folder, and its path relative to the page at `index`.
fn page_in_folder(pack: &Analysed, below: &Path, index: &Path) -> (PathBuf, String) {
    let mut file = below.as_os_str().to_owned();
    file.push(".html");
    let up = "../".repeat(below.components().count());
    let index_link = up + &index.file_name().unwrap_or_default().to_string_lossy();
    (PathBuf::from(pages_folder(index)).join(file), pack.page(Some(&index_link)))
}

fn pages_folder(page: &Path) -> OsString {
    let mut name = page.file_stem().unwrap_or_default().to_owned();
    name.push(".pages");
    name
}

fn exit_of(pack: &Analysed) -> Exit {
    if pack.faults().is_empty() { Exit::Done } else { Exit::Rejected }
}

fn print_faults(pack: &Analysed) {
    for fault in pack.faults() {
        let file = if fault.starts_with(pack.file()) { String::new() } else { format!("{}: ", pack.file()) };
        terminal::error(format_args!("{file}{fault}"));
    }
}

fn write_page(target: &Path, page: &str) -> Result<(), Failure> {
    let failure = |error| Failure::usage(format!("{}: cannot write the page: {error}", target.display()));
    make_folder(folder_of(target)).map_err(failure)?;
    write_beside(target, page.as_bytes()).and_then(|file| put_in_place(file, target)).map_err(failure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_lie_beside_their_index() {
        assert_eq!(pages_folder(Path::new("out/report.html")), "report.pages");
        assert_eq!(pages_folder(Path::new("report")), "report.pages");
        assert_eq!(slashed(&Path::new("a").join("b c").join("d")), "a/b c/d");
    }
}
