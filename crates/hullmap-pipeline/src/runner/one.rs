//! One file of a build: read, import, bake, verify, rename.
//!
//! The source is read once: the bytes that are hashed are the bytes that are baked. A mesh that
//! changes meanwhile leads to a pack of its old bytes, which the next build finds stale.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use hullmap::Asset;
use hullmap::height_field::Layout;
use hullmap_bake::height_field::{FieldCounts, HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::progress::Stage;
use hullmap_bake::{PointSet, SourceRecord};
use hullmap_format::header::FileKind;

use super::cache::{Cache, Entry};
use super::freshness::{Expected, Found, judge};
use super::rows::{FieldSummary, MAX_OBJECTS, Origin, Row, Status};
use crate::baker::BakedPack;
use crate::content::{Content, DEFAULT_DIRECTIONS, Terrain, verify};
use crate::jobs::Job;
use crate::jobs::key::{KeyInputs, check_planned, read};
use crate::open::{kept_warnings, open_asset};
use crate::options::BuildOptions;
use crate::outcome::{Exit, Failure};
use crate::pack_file::{folder_of, link_below, make_folder, put_in_place, through_link, write_beside};
use crate::project;
use crate::triangle_mesh::{MeshSummary, bake_triangles};
use hullmap_import::{Limits, SourceFile};
use hullmap_verify::height_field::SourceHeights;

pub type Baker = dyn Fn(&[PointSet], &BuildOptions, &SourceRecord, Stage) -> Result<BakedPack, String> + Sync;

/// Shares of the time of a job after which its source is read, and its pack is baked.
const READ: f64 = 0.1;
const BAKED: f64 = 0.9;

#[derive(Clone, Copy)]
pub struct Build<'a> {
    pub limits: Limits,
    pub verify: bool,
    pub force: bool,
    pub check: bool,
    /// Finished packs by key.
    pub cache: Option<&'a Cache>,
    pub out: &'a Path,
    /// The folder where `bake` was started: packs record only paths inside it.
    pub project: &'a Path,
    pub baker: &'a Baker,
}

enum Cached {
    Taken,
    /// Its pack is not what a bake would write; the warning states why.
    Rejected(String),
    Missing,
}

impl Build<'_> {
    /// Every failure, including a panic in a library, ends in the row's `error`; the exit code
    /// distinguishes rejected meshes from files that could not be read or written.
    pub fn run(&self, job: &Job, stage: Stage) -> (Row, Exit) {
        let start = Instant::now();
        let (source, output) = (job.source.display().to_string(), job.output.display().to_string());
        let mut row = Row::new(source, output, Status::Failed);
        row.options = Some(job.options.to_string());
        let link = || link_below(self.out, folder_of(&job.output)).map(|link| through_link(&job.output, &link));
        if let Some(obstacle) = job.name.clash.clone().or_else(link) {
            row.error = Some(obstacle);
            return (row, Exit::Usage);
        }
        // Fields of the row are only ever added, so a panic leaves it consistent.
        let result = catch_unwind(AssertUnwindSafe(|| self.bake(job, &mut row, stage)));
        let exit = match result {
            Ok(Ok(status)) => {
                row.status = status;
                if matches!(status, Status::Stale | Status::Missing) { Exit::Rejected } else { Exit::Done }
            }
            Ok(Err(failure)) => {
                row.error = Some(failure.message);
                failure.exit
            }
            Err(panic) => {
                let text = panic.downcast_ref::<&str>().copied();
                let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
                let text = text.unwrap_or("no message");
                row.error = Some(format!("{}: internal error ({text}); please report it, with the file", row.source));
                row.is_internal = true;
                Exit::Rejected
            }
        };
        // Notes about a fresh pack need no action; warnings apply until something is done.
        if row.status != Status::Fresh {
            row.notes.extend(job.name.note.clone());
        }
        row.warnings.extend(job.name.warning.clone());
        row.millis = (start.elapsed().as_secs_f64() * 1e4).round() / 10.0;
        (row, exit)
    }

    fn bake(&self, job: &Job, row: &mut Row, stage: Stage) -> Result<Status, Failure> {
        let source = read(job, &self.limits)?;
        check_planned(job, &source, self.project)?;
        let hash = source.hash;
        let folder = folder_of(&job.output);
        if let Some(status) = self.judge(job, hash, row)? {
            if self.verify && status == Status::Fresh {
                let kept = std::mem::take(&mut row.warnings);
                let imported = self.import(job, row, &source)?;
                row.warnings = kept;
                verify_file(&job.output, &imported).map_err(|failure| {
                    row.is_internal = true;
                    Failure { message: format!("{failure}; bake it again with --force"), ..failure }
                })?;
            }
            return Ok(status);
        }
        let replaced = replaced(job, hash, self.project);
        let key = match self.cache {
            Some(_) if job.key.is_empty() => KeyInputs::of_source(job, &source, self.project)?.key(),
            // The planned key was checked.
            _ => job.key.clone(),
        };
        let entry = self.cache.map(|cache| cache.entry(&key, job.options.file_kind()));
        let mut rejected = None;
        if let Some(entry) = &entry
            && !self.force
        {
            rejected = match self.take_cached(entry, job, &source, row)? {
                Cached::Taken => {
                    row.warnings.extend(replaced);
                    return Ok(Status::Baked);
                }
                Cached::Rejected(reason) => Some(reason),
                Cached::Missing => None,
            };
        }

        let imported = self.import(job, row, &source)?;
        drop(source);
        let output = row.output.clone();
        let cannot_write = |error| cannot_write(&output, &error);
        make_folder(folder).map_err(cannot_write)?;
        let record = SourceRecord {
            path: self.recorded_path(job)?,
            hash,
            options: job.options.to_string(),
            warnings: row.warnings.clone(),
        };
        stage.reach(READ);
        let bytes = self
            .bytes(job, &imported, &record, row, stage)
            .map_err(|error| Failure::rejected(format!("{}: {error}", row.source)))?;
        stage.reach(BAKED);
        let file = write_beside(&job.output, &bytes).map_err(cannot_write)?;
        if self.verify {
            verify_file(file.path(), &imported).inspect_err(|_| row.is_internal = true)?;
        }
        put_in_place(file, &job.output).map_err(cannot_write)?;
        row.origin = Some(Origin::Local);
        // After the bake: warnings that precede it become a part of the pack.
        row.warnings.extend(replaced);
        row.warnings.extend(rejected);
        if let Some(entry) = &entry {
            entry.write(&bytes);
        }
        Ok(Status::Baked)
    }

    /// Puts the pack of a cache's entry in place, if it is what a bake would write, and with
    /// `--verify` if its hulls match the source. The entry is copied first, so that another process
    /// cannot change what was judged.
    fn take_cached(&self, entry: &Entry, job: &Job, source: &SourceFile, row: &mut Row) -> Result<Cached, Failure> {
        let Some(bytes) = entry.read() else { return Ok(Cached::Missing) };
        let output = row.output.clone();
        let cannot_write = |error| cannot_write(&output, &error);
        let rejected = |reason: &dyn std::fmt::Display| {
            let entry = entry.path().display();
            Ok(Cached::Rejected(format!("{entry}: this pack in the cache was rejected, and baked again: {reason}")))
        };
        make_folder(folder_of(&job.output)).map_err(cannot_write)?;
        let recorded_path = self.recorded_path(job)?;
        let expected = Expected { source_hash: source.hash, job, recorded_path: &recorded_path };
        let file = write_beside(&job.output, &bytes).map_err(cannot_write)?;
        drop(bytes);
        let found = match judge(file.path(), &expected) {
            Found::Fresh(found) => found,
            Found::Stale(reason) => return rejected(&reason),
            Found::Missing => return Err(cannot_write(std::io::ErrorKind::NotFound.into())),
        };
        if self.verify {
            let mut own = Row::new(row.source.clone(), String::new(), Status::Failed);
            let imported = self.import(job, &mut own, source)?;
            if let Err(failure) = verify_file(file.path(), &imported) {
                return rejected(&failure);
            }
        }
        fill_from_file(&found, row);
        put_in_place(file, &job.output).map_err(cannot_write)?;
        row.origin = Some(Origin::Cache);
        Ok(Cached::Taken)
    }

    fn bytes(
        &self,
        job: &Job,
        content: &Content,
        record: &SourceRecord,
        row: &mut Row,
        stage: Stage,
    ) -> Result<Vec<u8>, String> {
        let (bytes, notes, warnings) = match content {
            Content::Terrain(Terrain { source: SourceHeights { layout, heights, holes }, .. }) => {
                let grid = HeightGrid { layout: *layout, heights, holes, materials: &[] };
                let baked = bake_height_field(&grid).map_err(|error| error.to_string())?;
                let FieldCounts { columns, rows, holes, .. } = baked.counts();
                row.height_field = Some(FieldSummary { columns, rows, holes });
                let bytes = write_height_field(baked, record).map_err(|error| error.to_string())?;
                (bytes, Vec::new(), record.warnings.clone())
            }
            Content::Mesh(mesh) if job.options.file_kind() == FileKind::TriangleMesh => {
                let mesh = bake_triangles(mesh, record)?;
                row.triangle_mesh = Some(mesh.summary);
                (mesh.bytes, mesh.notes, mesh.warnings)
            }
            Content::Mesh(mesh) => {
                let pack = (self.baker)(&mesh.point_sets, &job.options, record, stage.from_to(READ, BAKED))?;
                row.hulls = Some(pack.ranks.len());
                row.vertices_hull = Some(pack.vertex_count);
                row.ranks = Some(pack.ranks);
                row.objects = Some(pack.objects.into_iter().take(MAX_OBJECTS).collect());
                (pack.bytes, pack.notes, pack.warnings)
            }
        };
        row.bytes = Some(bytes.len() as u64);
        row.notes.extend(notes);
        row.warnings = warnings;
        Ok(bytes)
    }

    /// Status of a file that needs no bake; `None` if it must be baked, with the reason in the row.
    fn judge(&self, job: &Job, source_hash: u128, row: &mut Row) -> Result<Option<Status>, Failure> {
        if self.force {
            row.reason = Some("--force".to_owned());
            return Ok(None);
        }
        // A missing folder has no pack either.
        let found = if folder_of(&job.output).try_exists().map_err(|error| cannot_place(job, &error))? {
            let recorded_path = self.recorded_path(job)?;
            let expected = Expected { source_hash, job, recorded_path: &recorded_path };
            judge(&job.output, &expected)
        } else {
            Found::Missing
        };
        let (status, reason) = match found {
            Found::Fresh(pack) => {
                fill_from_file(&pack, row);
                return Ok(Some(Status::Fresh));
            }
            Found::Stale(reason) => (Status::Stale, reason),
            Found::Missing => (Status::Missing, "there is no pack yet".to_owned()),
        };
        row.reason = Some(reason);
        Ok(self.check.then_some(status))
    }

    fn recorded_path(&self, job: &Job) -> Result<String, Failure> {
        job.recorded_path(self.project).map_err(|error| cannot_place(job, &error))
    }

    fn import(&self, job: &Job, row: &mut Row, source: &SourceFile) -> Result<Content, Failure> {
        let content = Content::import(&job.source, source, &job.options, &self.limits)?;
        match &content {
            Content::Mesh(mesh) => {
                row.vertices_in = Some(mesh.point_count());
                row.vertices_source = Some(mesh.vertex_count);
                row.vertices_unreferenced = Some(mesh.unreferenced_count);
                row.vertices_duplicate = Some(mesh.duplicate_count);
            }
            Content::Terrain(terrain) => row.vertices_in = Some(terrain.source.heights.len()),
        }
        [row.notes, row.warnings] = content.remarks().map(<[String]>::to_vec);
        Ok(content)
    }
}

/// The warning that the existing pack was made of another file of the project, with another name. A
/// mesh that was renamed is no other file: the recorded one is gone, or has the same bytes.
fn replaced(job: &Job, source_hash: u128, start: &Path) -> Option<String> {
    let asset = open_asset(&job.output).ok()?;
    let was = Path::new(asset.source_path());
    if was.file_name()? == job.source.file_name()? || asset.header().source_hash == source_hash {
        return None;
    }
    let path = folder_of(&job.output).canonicalize().ok()?.join(was);
    let is_there = job.project(start)?.find(&path) == project::Found::File;
    is_there.then(|| {
        let was = was.display();
        format!("replaces the pack of `{was}`; bake one of them to another folder, or rename it")
    })
}

fn cannot_write(output: &str, error: &std::io::Error) -> Failure {
    let remedy = match error.kind() {
        std::io::ErrorKind::InvalidFilename => "give the mesh a shorter name",
        _ => "check the folder's permissions and free space",
    };
    Failure::usage(format!("{output}: cannot write: {error}; {remedy}"))
}

fn cannot_place(job: &Job, error: &std::io::Error) -> Failure {
    let (source, output) = (job.source.display(), job.output.display());
    Failure::usage(format!("{source}: cannot determine its path relative to {output}: {error}; check both folders"))
}

fn fill_from_file(asset: &Asset, row: &mut Row) {
    match asset {
        Asset::Pack(pack) => {
            row.hulls = Some(pack.hull_count());
            // Parts record their own points, not the mesh's.
            let has_parts = BuildOptions::from_recorded(pack.options()).is_none_or(|own| own.decompose().is_some());
            let points = pack.hulls().map(|hull| hull.source_point_count() as usize);
            row.vertices_in = (!has_parts).then(|| points.sum());
            row.vertices_hull = Some(pack.hulls().map(|hull| hull.vertex_count()).sum());
            row.ranks = Some(pack.hulls().map(|hull| hull.rank()).collect());
        }
        Asset::TriangleMesh(mesh) => _ = row.triangle_mesh.get_or_insert_with(|| MeshSummary::of_file(mesh)),
        Asset::HeightField(field) => {
            let Layout { columns, rows, .. } = *field.layout();
            row.height_field = Some(FieldSummary { columns, rows, holes: field.hole_count() });
        }
    }
    row.bytes = Some(asset.bytes().len() as u64);
    row.warnings = kept_warnings(asset);
}

/// Verifies a file as `bake verify` does with default arguments.
fn verify_file(path: &Path, content: &Content) -> Result<(), Failure> {
    let verified = verify(&open_asset(path)?, Some(content), DEFAULT_DIRECTIONS, 0).map_err(Failure::rejected)?;
    verified.verdict().map_or(Ok(()), |problems| Err(Failure::rejected(format!("verification failed: {problems}"))))
}
