//! Packs and rows that arrive from a farm. They are not trusted. Each pack is checked like one on
//! disk: digest, header, hash of the source, options, recorded path, checksum and structure; with
//! `--verify` also its hulls.

use std::collections::{HashMap, HashSet};
use std::sync::{Mutex, PoisonError};

use hullmap_format::header::MAX_PACK_LEN;
use hullmap_import as import;
use hullmap_remote::{Blob, Client, Outcome, OutputFile, RemoteError};

use super::action::{Batch, Member, RESULTS};
use crate::open::bounded_remarks;
use crate::outcome::Exit;
use crate::runner::freshness::{Expected, Found, judge};
use crate::runner::one::Build;
use crate::runner::rows::{Origin, Row, Status};
use crate::terminal;

/// Result of a job, by its index.
pub type Results = Vec<Option<(Row, Exit)>>;

/// Results of some jobs, each with the index of its job.
pub type Delivered = Vec<(usize, Row, Exit)>;

/// Maximum size of the rows of a batch in bytes. Honest rows have about one kilobyte each.
const MAX_RESULTS: u64 = 16 << 20;

/// Bytes of packs that are fetched at a time.
const MAX_AT_ONCE: u64 = 64 << 20;

/// Held while a pack of more than [`MAX_AT_ONCE`] is in memory, so that batches in flight do not
/// fill it with several of them.
static LARGE: Mutex<()> = Mutex::new(());

/// Checks the outcome of a batch and puts its packs in place; returns the results of the jobs whose
/// packs are not fresh. With `fallback`, a job whose pack was rejected has no result. Fails if the
/// server cannot be reached, the command failed on the worker, or the outcome lacks a pack and its
/// reason.
pub fn accept(
    client: &Client,
    batch: &Batch,
    outcome: &Outcome,
    build: &Build,
    fallback: bool,
) -> Result<Delivered, RemoteError> {
    if outcome.exit_code != 0 {
        let (code, error) = (outcome.exit_code, outcome.stderr.trim());
        return Err(RemoteError::Invalid(format!("the worker ended with exit code {code}: {error}")));
    }
    let origin = if outcome.is_cached { Origin::Cache } else { Origin::Worker };
    let rows = rows(client, batch, outcome)?;
    let mut results = Vec::new();
    let mut waiting: Vec<(&Member, Row, &OutputFile)> = Vec::new();
    for member in batch.wanted() {
        let found = rows.get(&member.source);
        let mut row = member.row();
        if let Some(found) = found {
            take(found, member, &mut row);
        }
        match outcome.files.get(&member.pack) {
            Some(file) => {
                row.error = None;
                row.origin = Some(origin);
                waiting.push((member, row, file));
            }
            None if row.error.is_some() => results.push((member.index, row, Exit::Rejected)),
            None => {
                let message = format!("the result has neither {} nor an error for it", member.pack);
                return Err(RemoteError::Invalid(message));
            }
        }
    }
    while !waiting.is_empty() {
        let mut bytes = 0;
        let fits = waiting.iter().take_while(|(_, _, file)| {
            bytes += file.digest.size();
            bytes <= MAX_AT_ONCE
        });
        let count = fits.count().max(1);
        let chunk: Vec<_> = waiting.drain(..count).collect();
        let digests: Vec<_> = chunk.iter().map(|(_, _, file)| file.digest.clone()).collect();
        let is_large = digests.iter().any(|digest| digest.size() > MAX_AT_ONCE);
        let _alone = is_large.then(|| LARGE.lock().unwrap_or_else(PoisonError::into_inner));
        let packs = client.fetch(&digests, MAX_PACK_LEN as u64)?;
        for (member, row, file) in chunk {
            let bytes = packs.get(&file.digest).ok_or_else(|| RemoteError::Missing(member.pack.clone()))?;
            let (mut row, exit) = build.place(member.job, member.hash, bytes, row);
            if exit == Exit::Rejected
                && let Some(error) = &mut row.error
            {
                if fallback {
                    // A job without a result is baked here.
                    terminal::warning(format_args!("{error}; baking it here"));
                    continue;
                }
                let action = batch.action.digest.hash();
                error.push_str(&format!(
                    "; remove the result of action {action} from the action cache, bake on a worker again with \
                     --force, or bake here with --remote-fallback"
                ));
            }
            results.push((member.index, row, exit));
        }
    }
    Ok(results)
}

/// The rows of an outcome, by the paths of meshes in the worker's folder. Rows of meshes that are
/// not in the batch are left out.
fn rows(client: &Client, batch: &Batch, outcome: &Outcome) -> Result<HashMap<String, Row>, RemoteError> {
    let file =
        outcome.files.get(RESULTS).ok_or_else(|| RemoteError::Invalid(format!("the result has no {RESULTS}")))?;
    let bytes = match &file.contents {
        Some(bytes) => bytes.clone(),
        None => client
            .fetch(std::slice::from_ref(&file.digest), MAX_RESULTS)?
            .remove(&file.digest)
            .ok_or_else(|| RemoteError::Missing(RESULTS.to_owned()))?,
    };
    let places: HashSet<&str> = batch.members.iter().map(|member| member.source.as_str()).collect();
    let mut rows = HashMap::new();
    for line in bytes.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()) {
        let row: Row =
            serde_json::from_slice(line).map_err(|error| RemoteError::Invalid(format!("{RESULTS}: {error}")))?;
        if places.contains(row.source.as_str()) {
            rows.insert(row.source.clone(), row);
        }
    }
    Ok(rows)
}

/// Takes the fields that only the worker can fill, with paths on this machine.
fn take(found: &Row, member: &Member, row: &mut Row) {
    let here = |text: &str| text.replace(&member.source, &row.source).replace(&member.pack, &row.output);
    let remarks = |list: &[String]| bounded_remarks(list.iter().map(String::as_str), here);
    let error = found.error.as_slice().iter().filter(|_| found.status == Status::Failed);
    let error = bounded_remarks(error.map(String::as_str), here).pop();
    let (notes, warnings) = (remarks(&found.notes), remarks(&found.warnings));
    (row.notes, row.warnings, row.error) = (notes, warnings, error);
    row.vertices_in = found.vertices_in;
    row.vertices_source = found.vertices_source;
    row.vertices_unreferenced = found.vertices_unreferenced;
    row.vertices_duplicate = found.vertices_duplicate;
    row.objects.clone_from(&found.objects);
}

/// The output files of a batch that was baked here, for others; `None` if they would mislead
/// others: a job failed for another reason than its mesh, a source has changed since the action was
/// described, or a pack cannot be read.
pub fn files(batch: &Batch, results: &Results, build: &Build) -> Option<Vec<(String, Blob)>> {
    let (mut files, mut text) = (Vec::with_capacity(batch.members.len() + 1), Vec::new());
    for member in &batch.members {
        let (row, exit) = results.get(member.index)?.as_ref()?;
        if *exit == Exit::Usage || row.is_internal || !is_of(member, row, build) {
            return None;
        }
        let there = |text: &String| {
            let text = text.replace(&row.source, &member.source).replace(&row.output, &member.pack);
            // Buffers lie beside their mesh.
            match (row.source.rsplit_once('/'), member.source.rsplit_once('/')) {
                (Some((here, _)), Some((there, _))) if !here.is_empty() => {
                    text.replace(&format!("{here}/"), &format!("{there}/"))
                }
                _ => text,
            }
        };
        let row = Row {
            source: member.source.clone(),
            output: member.pack.clone(),
            notes: row.notes.iter().map(there).collect(),
            warnings: row.warnings.iter().map(there).collect(),
            error: row.error.as_ref().map(there),
            // It differs from machine to machine.
            reason: None,
            origin: None,
            millis: 0.0,
            ..row.clone()
        };
        serde_json::to_writer(&mut text, &row).ok()?;
        text.push(b'\n');
        if row.status != Status::Failed {
            files.push((member.pack.clone(), Blob::from_bytes(std::fs::read(&member.job.output).ok()?)));
        }
    }
    files.push((RESULTS.to_owned(), Blob::from_bytes(text)));
    Some(files)
}

/// Whether a result belongs to the source for which the action was described.
fn is_of(member: &Member, row: &Row, build: &Build) -> bool {
    if row.status == Status::Failed {
        let read = import::read(&row.source, &member.job.source, &build.limits);
        return read.is_ok_and(|source| source.hash == member.hash);
    }
    let Ok(recorded_path) = member.job.recorded_path(build.project) else { return false };
    let expected = Expected { source_hash: member.hash, job: member.job, recorded_path: &recorded_path };
    matches!(judge(&member.job.output, &expected), Found::Fresh(_))
}
