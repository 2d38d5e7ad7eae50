//! Runs the jobs of a build with progress, and prints its messages and rows.

use std::collections::BTreeMap;
use std::path::Path;

use hullmap_geometry::number::grouped;
use hullmap_pipeline::jobs::search::without_meshes;
use hullmap_pipeline::jobs::{self, Job, Jobs, Message};
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::runner::one::Build;
use hullmap_pipeline::runner::rows::{Origin, Row, Status};
use hullmap_pipeline::runner::{self, Resources};

use crate::args::running::RunArgs;
use crate::args::{DEFAULT_MEMORY, MeshArgs};
use crate::progress::Progress;
use crate::table::{Table, or_dash};
use crate::terminal::{self, Output};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Messages {
    Silent,
    Warnings,
    All,
}

/// The jobs of the meshes that arguments name.
pub fn find_jobs(args: &MeshArgs, out: &Path, printed: Messages) -> Result<Jobs, Failure> {
    jobs::jobs(&args.selection(), out, &mut |message| match message {
        _ if printed == Messages::Silent => {}
        Message::Warning(text) => terminal::warning(text),
        Message::Detail(_) if printed != Messages::All => {}
        Message::Note(text) | Message::Detail(text) => terminal::note(text),
    })
}

/// As [`find_jobs`]; reports folders without meshes at once.
pub fn jobs_of_folders(args: &MeshArgs, out: &Path) -> Result<(Vec<Job>, Exit), Failure> {
    let Jobs { jobs, empty, .. } = find_jobs(args, out, Messages::Warnings)?;
    empty.iter().for_each(|folder| terminal::error(without_meshes(folder)));
    Ok((jobs, if empty.is_empty() { Exit::Done } else { Exit::Usage }))
}

pub fn run_jobs(jobs: &[&Job], build: &Build, args: &RunArgs) -> Result<Vec<(Row, Exit)>, Failure> {
    let resources = Resources { threads: args.threads.jobs, memory: args.memory.unwrap_or(DEFAULT_MEMORY) };
    let results = runner::run(jobs, build, resources, Progress::new)?;
    if let Some(cache) = build.cache
        && let Some(trouble) = cache.take_trouble()
    {
        terminal::warning(trouble);
    }
    Ok(results)
}

/// Prints messages in the order of the rows. `prunes`: orphans were to be removed.
pub fn print_messages(rows: &[Row], args: &RunArgs, prunes: bool) {
    let noted = |row: &&Row| row.status != Status::Orphaned;
    let mut notes = Notes::new(rows.iter().filter(noted).map(|row| (&*row.source, &*row.notes)), args.verbose);
    for row in rows {
        if row.status == Status::Orphaned {
            let remedy = match row.notes.first() {
                Some(kept) => format!(", but {kept}"),
                None if prunes => String::new(),
                None => " (--prune removes it)".to_owned(),
            };
            let reason = row.reason.as_deref().unwrap_or_default();
            terminal::note(format_args!("{}: {reason}{remedy}", row.output));
        } else {
            notes.print(&row.source, &row.notes);
        }
        for warning in &row.warnings {
            terminal::warning(format_args!("{}: {warning}", row.source));
        }
        if let Some(error) = &row.error {
            terminal::error(error);
        }
    }
}

/// Notes of several files. Without `--verbose`, only those that give advice are printed, and the
/// same advice once.
pub struct Notes<'r> {
    is_verbose: bool,
    /// The files that get each advice.
    advised: BTreeMap<&'r str, Vec<&'r str>>,
}

impl<'r> Notes<'r> {
    /// The notes of `rows`: files and their notes.
    pub fn new(rows: impl Iterator<Item = (&'r str, &'r [String])>, is_verbose: bool) -> Self {
        let mut advised: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (file, note) in rows.flat_map(|(file, notes)| notes.iter().map(move |note| (file, note))) {
            advised.entry(advice(note).unwrap_or_default()).or_default().push(file);
        }
        Self { is_verbose, advised }
    }

    pub fn print(&mut self, file: &str, notes: &[String]) {
        for note in notes {
            if self.is_verbose {
                terminal::note(format_args!("{file}: {note}"));
            } else if let Some(files) = advice(note).and_then(|advice| self.advised.remove(advice)) {
                terminal::note(format_args!("{file}: {note}{}", others(&files[1..])));
            }
        }
    }
}

/// The remedy at the end of a note, if it names an option.
fn advice(note: &str) -> Option<&str> {
    note.rsplit_once("; ").map(|(_, remedy)| remedy).filter(|remedy| remedy.contains("--"))
}

fn others(sources: &[&str]) -> String {
    let Some(first) = sources.first() else { return String::new() };
    let more = if sources.len() > 1 { ", …" } else { "" };
    format!(" (and {} more like it: {first}{more}; --verbose lists them)", sources.len())
}

pub fn write_rows(rows: &[Row], args: &RunArgs, is_check: bool, out: &mut Output) -> Result<(), Failure> {
    if args.json { write_json(rows, out) } else { write_table(rows, args.verbose, is_check, out) }
}

/// Writes one JSON object per line.
pub fn write_json(rows: &[Row], out: &mut Output) -> Result<(), Failure> {
    for row in rows {
        out.json(row)?;
    }
    Ok(out.flush()?)
}

/// Rows of fresh packs and unread meshes are written only if `lists_all`.
pub fn write_table(rows: &[Row], lists_all: bool, is_check: bool, out: &mut Output) -> Result<(), Failure> {
    let is_usual = |row: &Row| matches!(row.status, Status::Fresh | Status::Unread);
    let listed: Vec<&Row> = rows.iter().filter(|row| lists_all || !is_usual(row)).collect();
    if !listed.is_empty() {
        let table = if is_check { check_table(&listed) } else { build_table(&listed) };
        table.write(out)?;
        out.line("")?;
    }
    out.line(summary(rows, is_check))?;
    Ok(out.flush()?)
}

fn build_table(rows: &[&Row]) -> Table {
    let has_triangles = rows.iter().any(|row| row.surface().is_some());
    let triangles = if has_triangles { "triangles | " } else { "" };
    let mut table =
        Table::headed(&format!("source: | pack: | hulls | points | vertices | rank | {triangles}bytes | ms | status:"));
    let number = |value: Option<usize>| or_dash(value, |value| grouped(value as u64));
    for row in rows {
        let [triangles, vertices] = row.surface().map_or([None; 2], |counts| counts.map(Some));
        let mut cells = vec![
            row.source.clone(),
            row.output.clone(),
            number(row.hulls),
            number(row.vertices_in),
            number(row.vertices_hull.or(vertices)),
            or_dash(row.ranks.as_deref(), ranks),
        ];
        if has_triangles {
            cells.push(number(triangles));
        }
        cells.extend([or_dash(row.bytes, grouped), format!("{:.1}", row.millis), row.status.word().to_owned()]);
        table.push(cells);
    }
    table
}

fn check_table(rows: &[&Row]) -> Table {
    let mut table = Table::headed("status: | pack: | why:");
    for row in rows {
        let why = row.error.as_ref().or(row.reason.as_ref());
        table.push(vec![row.status.word().to_owned(), row.output.clone(), or_dash(why, String::clone)]);
    }
    table
}

/// `3 baked, 9 fresh, 0 failed; 12 hulls in 34 567 bytes`. Triangles are counted if there are any.
fn summary(rows: &[Row], is_check: bool) -> String {
    let count = |status| rows.iter().filter(|row| row.status == status).count();
    let always = if is_check {
        [Status::Fresh, Status::Stale, Status::Missing].as_slice()
    } else {
        &[Status::Baked, Status::Fresh, Status::Failed]
    };
    let rare = [Status::Failed, Status::Orphaned, Status::Pruned, Status::Unread];
    let rare = rare.into_iter().filter(|status| !always.contains(status) && count(*status) > 0);
    let counts = always.iter().copied().chain(rare);
    let cached = rows.iter().filter(|row| row.origin == Some(Origin::Cache)).count() as u64;
    let counts: Vec<String> = counts
        .map(|status| {
            let text = format!("{} {}", grouped(count(status) as u64), status.word().to_lowercase());
            let has_cached = status == Status::Baked && cached > 0;
            if has_cached { format!("{text} ({} from the cache)", grouped(cached)) } else { text }
        })
        .collect();
    if is_check {
        return counts.join(", ");
    }
    let bytes: u64 = rows.iter().filter_map(|row| row.bytes).sum();
    let hulls: usize = rows.iter().filter_map(|row| row.hulls).sum();
    let noun = if hulls == 1 { "hull" } else { "hulls" };
    let triangles: usize = rows.iter().filter_map(Row::surface).map(|[triangles, _]| triangles).sum();
    let contents = match (hulls, triangles) {
        (_, 0) => format!("{} {noun}", grouped(hulls as u64)),
        (0, _) => format!("{} triangles", grouped(triangles as u64)),
        _ => format!("{} {noun} and {} triangles", grouped(hulls as u64), grouped(triangles as u64)),
    };
    format!("{}; {contents} in {} bytes", counts.join(", "), grouped(bytes))
}

fn ranks(ranks: &[u32]) -> String {
    match (ranks.iter().min(), ranks.iter().max()) {
        (Some(min), Some(max)) if min < max => format!("{min}-{max}"),
        (Some(min), _) => min.to_string(),
        _ => "-".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_notes_with_an_option_are_advice() {
        let note = "the mesh is concave; its hull has 29% more volume; for convex parts, use --decompose";
        assert_eq!(advice(note), Some("for convex parts, use --decompose"));
        assert_eq!(advice("a: --max-vertices decided; 22 parts; the whole surface is covered"), None);
        assert_eq!(advice("2 vertices that no element references, left out (--set vertices=all includes them)"), None);
        assert_eq!(others(&[]), "");
        assert_eq!(others(&["b.obj", "c.obj"]), " (and 2 more like it: b.obj, …; --verbose lists them)");
    }
}
