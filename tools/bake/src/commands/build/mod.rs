//! `bake build`: source files to packs, in parallel, each by itself.

mod job;
mod plan;
#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use crate::args::BuildArgs;
use crate::baker::bake_pack;
use crate::outcome::{Exit, Failure};
use crate::table::{Align, Table, grouped, or_dash};
use job::{Baker, Build, Row, Status};

/// Runs the command.
///
/// # Errors
/// An input that cannot be read, or two files that would become one pack: before any work. What goes wrong with one
/// file is told in its row, and the exit code is 1.
pub fn run(args: &BuildArgs, out: &mut dyn Write) -> Result<Exit, Failure> {
    run_with(args, Path::new("."), &bake_pack, out)
}

/// Runs the command with any baker, in any folder.
fn run_with(args: &BuildArgs, project: &Path, baker: &Baker, out: &mut dyn Write) -> Result<Exit, Failure> {
    let jobs = plan::plan(&args.inputs, &args.out)?;
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::usage(format!("{}: cannot make this folder: {error}", args.out.display())))?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(jobs) = args.jobs {
        pool = pool.num_threads(usize::from(jobs));
    }
    let pool = pool.build().map_err(|error| Failure::usage(format!("cannot start threads: {error}")))?;

    let build = Build {
        options: args.options.options(),
        verify: args.verify,
        force: args.force,
        limits: args.limits.limits(),
        project,
        baker,
    };
    let progress = progress_bar(jobs.len());
    let rows: Vec<Row> = pool.install(|| {
        let one = |job| {
            let row = build.run(job);
            progress.inc(1);
            row
        };
        // One job at a time may be stolen, so that a few great files among many small ones spread well.
        jobs.par_iter().with_max_len(1).map(one).collect()
    });
    progress.finish_and_clear();

    for row in &rows {
        for note in &row.notes {
            eprintln!("note: {}: {note}", row.source);
        }
        for warning in &row.warnings {
            eprintln!("warning: {}: {warning}", row.source);
        }
        if let Some(error) = &row.error {
            eprintln!("error: {error}");
        }
    }
    if args.json {
        for row in &rows {
            serde_json::to_writer(&mut *out, row).map_err(std::io::Error::from)?;
            writeln!(out)?;
        }
    } else {
        write_table(&rows, out)?;
    }
    let is_well = rows.iter().all(|row| row.status != Status::Failed);
    Ok(if is_well { Exit::Done } else { Exit::Wanting })
}

/// A progress bar on standard error if that is a terminal, else one that is never seen.
fn progress_bar(count: usize) -> ProgressBar {
    // The target draws only on terminals.
    let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed}");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn write_table(rows: &[Row], out: &mut dyn Write) -> Result<(), Failure> {
    let mut table = Table::new(&[
        ("source", Align::Left),
        ("pack", Align::Left),
        ("hulls", Align::Right),
        ("points", Align::Right),
        ("vertices", Align::Right),
        ("rank", Align::Right),
        ("bytes", Align::Right),
        ("ms", Align::Right),
        ("status", Align::Left),
    ]);
    let number = |value: Option<usize>| or_dash(value, |value| grouped(value as u64));
    for row in rows {
        table.push(vec![
            row.source.clone(),
            row.output.clone(),
            number(row.hulls),
            number(row.vertices_in),
            number(row.vertices_hull),
            or_dash(row.ranks.as_deref(), ranks),
            or_dash(row.bytes, grouped),
            format!("{:.1}", row.millis),
            match row.status {
                Status::Baked => "baked",
                Status::Fresh => "fresh",
                Status::Failed => "FAILED",
            }
            .to_owned(),
        ]);
    }
    table.write(out)?;
    let count = |status| rows.iter().filter(|row| row.status == status).count();
    let bytes: u64 = rows.iter().filter_map(|row| row.bytes).sum();
    let hulls: usize = rows.iter().filter_map(|row| row.hulls).sum();
    writeln!(
        out,
        "\n{} baked, {} fresh, {} failed; {} hulls in {} bytes",
        count(Status::Baked),
        count(Status::Fresh),
        count(Status::Failed),
        grouped(hulls as u64),
        grouped(bytes),
    )?;
    Ok(())
}

/// The one rank of all hulls, or the lowest and the highest.
fn ranks(ranks: &[u32]) -> String {
    match (ranks.iter().min(), ranks.iter().max()) {
        (Some(least), Some(greatest)) if least < greatest => format!("{least}-{greatest}"),
        (Some(least), _) => least.to_string(),
        _ => "-".to_owned(),
    }
}
