//! One file of a build: read, import, bake, verify, put in place.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use hullmap_bake::{PointSet, SourceRecord};
use hullmap_format::header::options_hash;
use serde::Serialize;

use super::plan::Job;
use crate::args::DEFAULT_DIRECTIONS;
use crate::baker::BakedPack;
use crate::commands::verify::{self, Truth};
use crate::import::{self, Imported, Limits, ReadError, SourceFile};
use crate::open::{open_pack, read_header};
use crate::options::{BuildOptions, Simplify};
use crate::pack_file::{folder_of, put_in_place, recorded_path, write_beside};

/// How a file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It was baked.
    Baked,
    /// The pack that was there is what a bake would make.
    Fresh,
    /// It was not baked, or the pack did not pass.
    Failed,
}

/// What is said of a file; `None` where it did not get that far. The names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The source file.
    pub source: String,
    /// The pack.
    pub output: String,
    /// How it ended.
    pub status: Status,
    /// Hulls in the pack.
    pub hulls: Option<usize>,
    /// Source points over all hulls.
    pub vertices_in: Option<usize>,
    /// Vertices in the source.
    pub vertices_source: Option<usize>,
    /// Vertices that no element references.
    pub vertices_unreferenced: Option<usize>,
    /// Points that an earlier one equals.
    pub vertices_duplicate: Option<usize>,
    /// Hull vertices over all hulls.
    pub vertices_hull: Option<usize>,
    /// Rank of each hull: 3 solid, 2 polygon, 1 segment, 0 point.
    pub ranks: Option<Vec<u32>>,
    /// Size of the pack.
    pub bytes: Option<u64>,
    /// Time from start to end in milliseconds. A thread that waits for others works on another file meanwhile, so the
    /// times of many files add up to more than the whole took.
    pub millis: f64,
    /// What the user may want to know of the source.
    pub notes: Vec<String>,
    /// What the user should look at, with the remedy.
    pub warnings: Vec<String>,
    /// Why it failed.
    pub error: Option<String>,
}

/// Bakes point sets into a pack; [`bake_pack`](crate::baker::bake_pack), but for tests.
pub type Baker = dyn Fn(&[PointSet], &BuildOptions, &SourceRecord) -> Result<BakedPack, String> + Sync;

/// What all files of a build share.
pub struct Build<'a> {
    /// The options that shape the packs.
    pub options: BuildOptions,
    /// What a source file may ask for.
    pub limits: Limits,
    /// Verify each pack.
    pub verify: bool,
    /// Bake even what is fresh.
    pub force: bool,
    /// The folder that `bake` was started in: packs record paths inside it alone.
    pub project: &'a Path,
    /// What bakes.
    pub baker: &'a Baker,
}

impl Build<'_> {
    /// Does one job. Whatever goes wrong, panics in the libraries below included, ends in the row's `error`.
    pub fn run(&self, job: &Job) -> Row {
        let start = Instant::now();
        let mut row = Row {
            source: job.source.display().to_string(),
            output: job.output.display().to_string(),
            status: Status::Failed,
            hulls: None,
            vertices_in: None,
            vertices_source: None,
            vertices_unreferenced: None,
            vertices_duplicate: None,
            vertices_hull: None,
            ranks: None,
            bytes: None,
            millis: 0.0,
            notes: Vec::new(),
            warnings: Vec::new(),
            error: None,
        };
        // The row is only ever filled in further, so a panic leaves nothing half done in it.
        let result = catch_unwind(AssertUnwindSafe(|| self.bake(job, &mut row)));
        match result {
            Ok(Ok(status)) => row.status = status,
            Ok(Err(error)) => row.error = Some(error),
            Err(panic) => {
                let text = panic.downcast_ref::<&str>().copied();
                let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
                let text = text.unwrap_or("no message");
                row.error = Some(format!("{}: internal error ({text}); please report it with the file", row.source));
            }
        }
        row.millis = (start.elapsed().as_secs_f64() * 1e4).round() / 10.0;
        row
    }

    fn bake(&self, job: &Job, row: &mut Row) -> Result<Status, String> {
        if let Some(option) = without_effect(&self.options) {
            return Err(format!("{}: {option} has no effect in this version; leave it out", row.source));
        }
        let source = import::read(&row.source, &job.source, &self.limits).map_err(|error| match error {
            ReadError::Io(error) => format!("{}: cannot read: {error}", row.source),
            ReadError::Import(error) => error.to_string(),
        })?;
        let hash = source.hash;
        if !self.force && self.is_fresh(&job.output, hash) && self.fill_from_pack(job, row) {
            if self.verify {
                let imported = self.import(job, row, &source)?;
                verify_pack(&job.output, &imported).map_err(|error| format!("{error}; bake it again with --force"))?;
            }
            return Ok(Status::Fresh);
        }

        let imported = self.import(job, row, &source)?;
        drop(source);
        let cannot_write = |error| format!("{}: cannot write: {error}", row.output);
        let folder = folder_of(&job.output);
        std::fs::create_dir_all(folder).map_err(cannot_write)?;
        let record = SourceRecord {
            path: recorded_path(&job.source, folder, self.project),
            hash,
            options: self.options.to_string(),
        };
        let pack = (self.baker)(&imported.point_sets, &self.options, &record)
            .map_err(|error| format!("{}: {error}", row.source))?;
        let file = write_beside(&job.output, &pack.bytes).map_err(cannot_write)?;
        if self.verify {
            verify_pack(file.path(), &imported)?;
        }
        put_in_place(file, &job.output).map_err(cannot_write)?;

        row.hulls = Some(pack.ranks.len());
        row.vertices_hull = Some(pack.vertex_count);
        row.ranks = Some(pack.ranks);
        row.bytes = Some(pack.bytes.len() as u64);
        row.notes.extend(pack.notes);
        row.warnings.extend(pack.warnings);
        Ok(Status::Baked)
    }

    fn import(&self, job: &Job, row: &mut Row, source: &SourceFile) -> Result<Imported, String> {
        let stem = job.source.file_stem().unwrap_or_default().to_string_lossy();
        let mut imported = import::import(&row.source, &stem, &job.source, source, &self.options.import, &self.limits)
            .map_err(|e| e.to_string())?;
        row.vertices_in = Some(imported.point_count());
        row.vertices_source = Some(imported.vertex_count);
        row.vertices_unreferenced = Some(imported.unreferenced_count);
        row.vertices_duplicate = Some(imported.duplicate_count);
        row.notes = std::mem::take(&mut imported.notes);
        row.warnings = std::mem::take(&mut imported.warnings);
        Ok(imported)
    }

    fn is_fresh(&self, output: &Path, source_hash: u128) -> bool {
        read_header(output).is_some_and(|header| {
            header.source_hash == source_hash && header.options_hash == options_hash(&self.options.to_string())
        })
    }

    /// Fills in the row from a pack; false where it does not open or records another path of its source, so that it is
    /// baked again.
    fn fill_from_pack(&self, job: &Job, row: &mut Row) -> bool {
        let Ok(pack) = open_pack(&job.output) else {
            return false;
        };
        if pack.source_path() != recorded_path(&job.source, folder_of(&job.output), self.project) {
            return false;
        }
        row.hulls = Some(pack.hull_count());
        row.vertices_in = Some(pack.hulls().map(|hull| hull.source_point_count() as usize).sum());
        row.vertices_hull = Some(pack.hulls().map(|hull| hull.vertex_count()).sum());
        row.ranks = Some(pack.hulls().map(|hull| hull.rank()).collect());
        row.bytes = Some(pack.byte_len() as u64);
        true
    }
}

/// The first option that is known but that nothing acts on yet: better refused than silently ignored.
fn without_effect(options: &BuildOptions) -> Option<&'static str> {
    let import = options.import;
    [
        (import.recentre, "recentre"),
        (options.decompose.is_some(), "decompose"),
        (options.simplify != Simplify::None, "max_vertices or max_error"),
    ]
    .into_iter()
    .find_map(|(is_asked, name)| is_asked.then_some(name))
}

/// Verifies as `bake verify` does with its defaults.
fn verify_pack(path: &Path, imported: &Imported) -> Result<(), String> {
    let pack = open_pack(path).map_err(|failure| failure.message)?;
    let reports = verify::verify_hulls(&pack, &Truth::Source(&imported.point_sets), DEFAULT_DIRECTIONS, 0)?;
    match reports.into_iter().find(|report| !report.pass) {
        Some(report) => Err(format!("verification failed: {}", report.verdict())),
        None => Ok(()),
    }
}
