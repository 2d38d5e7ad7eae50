//! `bake build --height-field`: bakes grids of heights into height fields.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullmap::HeightField;
use hullmap_bake::SourceRecord;
use hullmap_bake::height_field::write_height_field;
use hullmap_format::header::options_hash;
use hullmap_format::height_field::EXTENSION;
use serde::Serialize;

use super::bake::FieldSource;
use super::options::FieldOptions;
use crate::args::BuildArgs;
use crate::interrupt;
use crate::options::OptionLayer;
use crate::outcome::{Exit, Failure, end};
use crate::pack_file::{folder_of, make_folder, put_in_place, recorded_path, records_source, sweep, write_beside};
use crate::terminal::{self, Output};
use hullmap_bake::number::grouped;

/// Result of a file. Field names are the JSON's.
#[derive(Debug, Serialize)]
struct Row {
    source: String,
    output: String,
    /// `baked`, `fresh`, `stale`, `missing` or `failed`.
    status: &'static str,
    columns: usize,
    rows: usize,
    holes: usize,
    bytes: usize,
    millis: f64,
    warnings: Vec<String>,
    error: Option<String>,
}

pub fn run(args: &BuildArgs, out: &mut Output) -> Result<Exit, Failure> {
    interrupt::catch();
    let sources = check_flags(args)?;
    let options = FieldOptions::from_args(&args.height_field);
    if !args.check {
        make_folder(&args.out).map_err(|error| {
            Failure::usage(format!("{}: cannot create this folder: {error}; check the path", args.out.display()))
        })?;
        sweep(&args.out);
    }
    let mut exit = Exit::Done;
    for (source, target) in sources {
        let (start, shown) = (Instant::now(), source.display().to_string());
        let mut row = Row {
            source: shown,
            output: target.display().to_string(),
            status: "failed",
            columns: 0,
            rows: 0,
            holes: 0,
            bytes: 0,
            millis: 0.0,
            warnings: Vec::new(),
            error: None,
        };
        match build(args, &source, &target, &options, &mut row) {
            Ok(own) => exit = exit.max(own),
            Err(failure) => {
                exit = exit.max(failure.exit);
                terminal::error(&failure);
                row.error = Some(failure.message);
            }
        }
        row.warnings.iter().filter(|_| !args.run.quiet).for_each(terminal::warning);
        row.millis = (start.elapsed().as_secs_f64() * 1e4).round() / 10.0;
        end(exit, write_row(args, &row, out))?;
    }
    Ok(exit)
}

fn check_flags(args: &BuildArgs) -> Result<Vec<(PathBuf, PathBuf)>, Failure> {
    let unsupported = [
        (args.watch, "--watch"),
        (args.prune, "--prune"),
        (args.depfile.is_some(), "--depfile"),
        (args.shard.is_some(), "--shard"),
        (args.meshes.config.is_some(), "--config"),
        (!args.meshes.exclude.is_empty(), "--exclude"),
        (args.cache.is_some(), "--cache"),
        (!args.meshes.ext.is_empty(), "--ext"),
    ];
    if let Some((_, flag)) = unsupported.iter().find(|(is_set, _)| *is_set) {
        return Err(Failure::usage(format!("{flag} has no effect on height fields; leave it out")));
    }
    if args.meshes.options != OptionLayer::default() {
        let message = "options of packs have no effect on height fields; leave them out";
        return Err(Failure::usage(message));
    }
    let mut sources: HashMap<PathBuf, &Path> = HashMap::new();
    let mut jobs = Vec::new();
    for source in &args.meshes.inputs {
        if source.is_dir() {
            let message = format!("{}: is a folder; name the files of heights", source.display());
            return Err(Failure::usage(message));
        }
        let mut name = source.file_stem().unwrap_or_default().to_owned();
        name.push(".");
        name.push(EXTENSION);
        let target = args.out.join(name);
        if let Some(other) = sources.insert(target.clone(), source) {
            return Err(Failure::usage(format!(
                "{} and {} would both become {}; rename one, or bake them into separate folders",
                other.display(),
                source.display(),
                target.display()
            )));
        }
        jobs.push((source.clone(), target));
    }
    Ok(jobs)
}

fn build(
    args: &BuildArgs,
    source: &Path,
    target: &Path,
    options: &FieldOptions,
    row: &mut Row,
) -> Result<Exit, Failure> {
    let files = FieldSource::read(source, options, &args.meshes.limits.limits())?;
    let path = recorded_path(source, folder_of(target), Path::new("."))
        .map_err(|error| Failure::usage(format!("{}: cannot resolve the path: {error}", source.display())))?;
    let record = SourceRecord { path, hash: files.hash(), options: options.to_string(), warnings: Vec::new() };
    if let Some(field) = HeightField::open(target).ok().filter(|_| !args.force) {
        let header = field.header();
        let is_fresh = header.source_hash == record.hash
            && header.options_hash == options_hash(&record.options)
            && (field.source_path() == record.path || records_source(field.source_path(), source, folder_of(target)));
        (row.columns, row.rows) = (field.layout().columns, field.layout().rows);
        (row.holes, row.bytes) = (field.hole_count(), field.bytes().len());
        if is_fresh {
            if options.hole.is_some() {
                row.warnings.extend(files.warning(&files.import(options)?.0, options));
            }
            row.status = "fresh";
            return Ok(Exit::Done);
        }
    }
    if args.check {
        row.status = if target.exists() { "stale" } else { "missing" };
        return Ok(Exit::Rejected);
    }
    let (heights, holes) = files.import(options)?;
    row.warnings.extend(files.warning(&heights, options));
    let baked = files.bake(&heights, &holes, options)?;
    drop((files, heights, holes));
    let counts = baked.counts();
    let bytes = write_height_field(baked, &record)
        .map_err(|error| Failure::rejected(format!("{}: {error}", source.display())))?;
    if args.verify {
        HeightField::from_bytes(&bytes)
            .map_err(|error| Failure::rejected(format!("{}: {error}; please report this file", source.display())))?;
    }
    write_beside(target, &bytes)
        .and_then(|file| put_in_place(file, target))
        .map_err(|error| Failure::usage(format!("{}: cannot write: {error}; check the folder", target.display())))?;
    row.status = "baked";
    (row.columns, row.rows, row.holes, row.bytes) = (counts.columns, counts.rows, counts.holes, bytes.len());
    Ok(Exit::Done)
}

fn write_row(args: &BuildArgs, row: &Row, out: &mut Output) -> Result<(), Failure> {
    if args.run.json {
        return Ok(out.json(row)?);
    }
    if args.run.quiet || row.status == "failed" || row.status == "fresh" && !args.run.verbose {
        return Ok(());
    }
    let Row { output, status, columns, rows, .. } = row;
    if matches!(*status, "stale" | "missing") {
        return Ok(out.line(format_args!("{status:<8} {output}"))?);
    }
    let cells = (columns.saturating_sub(1) * rows.saturating_sub(1)).max(1);
    Ok(out.line(format_args!(
        "{status:<8} {output}: {} x {} vertices, {} holes, {} bytes ({:.1} per cell), {:.0} ms",
        grouped(*columns as u64),
        grouped(*rows as u64),
        grouped(row.holes as u64),
        grouped(row.bytes as u64),
        row.bytes as f64 / cells as f64,
        row.millis
    ))?)
}
