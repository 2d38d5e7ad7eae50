//! Key of a pack: a hash of everything that its bytes depend on. Packs with equal keys are equal,
//! wherever they are baked, so the key can name a pack in a cache.
//!
//! SHA-256, because caches are shared: with the faster hash that a pack records, an attacker could
//! construct two meshes with the same key.

use std::path::Path;

use hullmap_import::{Limits, ReadError, SourceFile};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::job::{Input, Job};
use crate::content;
use crate::outcome::Failure;

/// The key is SHA-256 of this value as compact JSON, with the fields in this order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KeyInputs {
    /// Version of the command: versions may choose other parts or other indices.
    pub baker: String,
    pub format_version: u32,
    /// File name of the mesh: its stem names hulls, and its extension decides the format.
    pub name: String,
    pub options: String,
    pub records: String,
    /// The mesh, then its buffers in the order of the document.
    pub inputs: Vec<Input>,
}

impl KeyInputs {
    /// Reads the sources of a job; `project` is the folder where `bake` was started. Fails if they
    /// cannot be read, exceed the limits, or differ from the planned files.
    pub fn new(job: &Job, limits: &Limits, project: &Path) -> Result<Self, Failure> {
        Self::of_source(job, &read(job, limits)?, project)
    }

    pub fn of_source(job: &Job, source: &SourceFile, project: &Path) -> Result<Self, Failure> {
        let name = job.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let records = job.recorded_path(project).map_err(|error| {
            let file = job.source.display();
            Failure::usage(format!(
                "{file}: cannot determine its path relative to its pack: {error}; check both folders"
            ))
        })?;
        Ok(Self {
            baker: env!("CARGO_PKG_VERSION").to_owned(),
            format_version: job.options.format_version(),
            options: job.options.to_string(),
            records,
            inputs: inputs(&name, source),
            name,
        })
    }

    /// The key: 64 hexadecimal digits.
    pub fn key(&self) -> String {
        // Plain numbers and texts can always be written.
        sha256(&serde_json::to_vec(self).unwrap_or_default())
    }
}

/// Reads the sources of a job. For a planned job, reads at most one byte more than the plan states.
/// Fails if they cannot be read, exceed the limits, or are larger than planned.
pub fn read(job: &Job, limits: &Limits) -> Result<SourceFile, Failure> {
    let file = job.source.display().to_string();
    let mut limits = *limits;
    let planned = job.planned_bytes().filter(|bytes| *bytes <= limits.input_bytes);
    if let Some(planned) = planned {
        // Files that are missing or not regular get their errors from the reader.
        let has_grown = |input: &Input| {
            let metadata = std::fs::metadata(job.source.with_file_name(&input.path));
            metadata.is_ok_and(|metadata| metadata.is_file() && metadata.len() > input.bytes)
        };
        if job.inputs.iter().any(has_grown) {
            return Err(changed(job));
        }
        limits.input_bytes = planned;
    }
    content::read(&file, &job.source, &job.options, &limits).map_err(|error| match error {
        error if planned.is_some() && error.is_too_large() => changed(job),
        ReadError::Io(error) => Failure::usage(format!("{file}: cannot read: {error}; check the file")),
        ReadError::Import(error) => Failure::rejected(error.to_string()),
    })
}

/// Fails if the bytes of a source, or the key of its pack, differ from what was planned.
pub fn check_planned(job: &Job, source: &SourceFile, project: &Path) -> Result<(), Failure> {
    if job.inputs.is_empty() && job.key.is_empty() {
        return Ok(());
    }
    let found = KeyInputs::of_source(job, source, project)?;
    if !job.inputs.is_empty() && found.inputs != job.inputs {
        return Err(changed(job));
    }
    if !job.key.is_empty() && found.key() != job.key {
        return Err(Failure::rejected(format!(
            "{}: its pack would not have the planned key: the plan was edited, or is by another version of bake; plan again",
            job.source.display()
        )));
    }
    Ok(())
}

fn changed(job: &Job) -> Failure {
    Failure::rejected(format!("{}: it has changed since it was planned; plan again", job.source.display()))
}

/// The files of a source: the mesh, which has this name, and its buffers.
pub fn inputs(name: &str, source: &SourceFile) -> Vec<Input> {
    let input =
        |path: &str, bytes: &[u8]| Input { path: path.to_owned(), bytes: bytes.len() as u64, sha256: sha256(bytes) };
    let beside = source.beside.iter().map(|(path, bytes)| input(path, bytes));
    std::iter::once(input(name, &source.bytes)).chain(beside).collect()
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_match_the_standard() {
        assert_eq!(sha256(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn every_ingredient_changes_the_key() {
        let usual = KeyInputs {
            baker: "1".to_owned(),
            format_version: 5,
            name: "a.obj".to_owned(),
            options: "index tree 8".to_owned(),
            records: "../a.obj".to_owned(),
            inputs: vec![Input { path: "a.obj".to_owned(), bytes: 3, sha256: sha256(b"abc") }],
        };
        let mut keys = vec![usual.key()];
        let changes: [fn(&mut KeyInputs); 7] = [
            |of| of.baker.push('1'),
            |of| of.format_version += 1,
            |of| of.name.push('x'),
            |of| of.options.push('x'),
            |of| of.records.push('x'),
            |of| of.inputs[0].sha256.push('x'),
            |of| of.inputs.push(of.inputs[0].clone()),
        ];
        for change in changes {
            let mut other = usual.clone();
            change(&mut other);
            keys.push(other.key());
        }
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), 8);
    }
}
