//! `bake report`: packs on pages that any browser opens, without a network.
//!
//! 1. [`analysis`] opens a pack, finds its source, verifies it, counts what queries cost, and gathers what is drawn.
//! 2. [`mod@pack_page`] makes one page of that; [`mod@folder_page`] one of many packs, each with a page beside it.
//! 3. Pages are written to temporary files and renamed, the folder's last, so that it links to what is there.
//!
//! | module | concept |
//! |---|---|
//! | [`index_reader`] | a direction index, and the leaf of a direction |
//! | [`mod@cells`] | the index's cells, as lines on the cube |
//! | [`mod@gauss_map`] | support vertices and leaves over the unfolded cube |
//! | [`mod@census`] | what queries cost over the sphere |
//! | [`shape`], [`source_mesh`] | triangles to look at |
//! | [`mod@picture`] | a still picture of them |
//! | [`sizes`], [`warnings`] | bytes by section, and what may surprise |
//! | [`html`], [`encode`] | text and numbers in a page |

mod analysis;
mod cells;
mod census;
mod encode;
mod folder_page;
mod gauss_map;
mod html;
mod index_reader;
mod pack_page;
mod picture;
mod shape;
mod sizes;
mod source_mesh;
mod warnings;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::args::ReportArgs;
use crate::commands::verify::asked_sources;
use crate::messages;
use crate::outcome::{Exit, Failure, end};
use crate::pack_file::{folder_of, make_folder, put_in_place, sweep, write_beside};
use crate::packs::{PackPlace, find_packs};
use crate::table::grouped;
use analysis::{Analysis, analyse};
use folder_page::{Card, Content, folder_page};
use pack_page::{pack_page, verdict};

/// Runs the command.
///
/// # Errors
/// The input cannot be read, holds no pack, or is one that does not open; the page cannot be written. What is wrong with
/// packs that open, or with single ones of a folder, is told on the pages.
pub fn run(args: &ReportArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    if args.out.is_dir() || args.out.file_name().is_none() {
        let message = format!("{}: a folder, where the page's file is expected; name one in it", args.out.display());
        return Err(Failure::usage(message));
    }
    let places = find_packs(std::slice::from_ref(&args.input))?;
    let sources = asked_sources(args.source.as_deref(), &places)?;
    // What a killed report has left.
    sweep(folder_of(&args.out));
    sweep(&args.out.with_file_name(pages_folder(&args.out)));
    if args.input.is_dir() {
        return report_folder(args, &places, &sources, out);
    }
    let mut exit = Exit::Done;
    for (place, asked) in places.iter().zip(sources) {
        let pack = analyse(place, asked, args)?;
        let page = pack_page(&pack, None);
        write_page(&args.out, &page)?;
        tell(&pack);
        exit = exit.max(pack.exit());
        let written = writeln!(out, "{}: {} bytes", args.out.display(), grouped(page.len() as u64));
        end(exit, written.map_err(Failure::from))?;
    }
    Ok(exit)
}

fn report_folder(
    args: &ReportArgs,
    places: &[PackPlace],
    sources: &[Option<&Path>],
    out: &mut dyn Write,
) -> Result<Exit, Failure> {
    let pages = pages_folder(&args.out);
    let mut exit = Exit::Done;
    let mut bytes = 0;
    let mut cards = Vec::new();
    for (place, asked) in places.iter().zip(sources) {
        let below = place.path.strip_prefix(&args.input).unwrap_or(&place.path);
        let name = slashed(&below.with_extension(""));
        match analyse(place, *asked, args) {
            Ok(pack) => {
                let mut file = below.as_os_str().to_owned();
                file.push(".html");
                let target = folder_of(&args.out).join(&pages).join(&file);
                let up = "../".repeat(below.components().count());
                let index = up + &args.out.file_name().unwrap_or_default().to_string_lossy();
                let page = pack_page(&pack, Some(&index));
                write_page(&target, &page)?;
                bytes += page.len();
                tell(&pack);
                exit = exit.max(pack.exit());
                cards.push(card(name, &pack, slashed(&PathBuf::from(&pages).join(file))));
            }
            Err(failure) => {
                messages::error(&failure);
                exit = exit.max(failure.exit);
                let verdict = "<span class=\"chip bad\">not opened</span>".to_owned();
                cards.push(Card {
                    name,
                    verdict,
                    is_faulty: true,
                    is_exact: false,
                    remarks: vec![failure.message],
                    content: None,
                });
            }
        }
    }
    let page = folder_page(&args.input.display().to_string(), &cards);
    write_page(&args.out, &page)?;
    bytes += page.len();
    let packs = if cards.len() == 1 { "pack" } else { "packs" };
    let written =
        writeln!(out, "{}: {} {packs}, {} bytes in all", args.out.display(), cards.len(), grouped(bytes as u64));
    end(exit, written.map_err(Failure::from))
}

/// The folder of the packs' pages, beside `page`: `report.html` has `report.pages`.
fn pages_folder(page: &Path) -> OsString {
    let mut name = page.file_stem().unwrap_or_default().to_owned();
    name.push(".pages");
    name
}

/// A path as it stands in a link: `/` between its parts.
fn slashed(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

fn card(name: String, pack: &Analysis, page: String) -> Card {
    Card {
        name,
        verdict: verdict(pack),
        is_faulty: !pack.faults.is_empty(),
        is_exact: pack.is_exact(),
        remarks: pack.faults.iter().chain(&pack.warnings).cloned().collect(),
        content: Some(Content {
            page,
            picture: pack.picture.clone(),
            hulls: pack.hull_count,
            vertices: pack.vertex_count,
            bytes: pack.bytes,
        }),
    }
}

/// Says on standard error what is wrong with a pack.
fn tell(pack: &Analysis) {
    for fault in &pack.faults {
        let place = if fault.starts_with(&pack.file) { String::new() } else { format!("{}: ", pack.file) };
        messages::error(format_args!("{place}{fault}"));
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
    fn pages_stand_beside_their_index() {
        assert_eq!(pages_folder(Path::new("out/report.html")), "report.pages");
        assert_eq!(pages_folder(Path::new("report")), "report.pages");
        assert_eq!(slashed(&Path::new("a").join("b c").join("d")), "a/b c/d");
    }
}
