//! Tasks: batches of meshes as JSON, one per line, that any machine with the same files can bake.
//!
//! A task states resolved options, and needs no `hullmap.toml`. Paths are relative to the folder
//! where the plan was made; a pack's path is checked before anything is written.

use std::io::BufRead;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::batch::work;
use super::job::{Input, Job};
use super::key::{KeyInputs, sha256};
use super::pack_names::PackName;
use super::slashed;
use crate::options::BuildOptions;
use crate::packs::{is_baked, kind_by_name};

/// Maximum length of a task in bytes. A batch of 256 meshes takes about 200 KiB.
const MAX_BYTES: u64 = 64 << 20;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Task {
    pub task: usize,
    /// SHA-256 of the keys of its packs.
    pub key: String,
    pub out: String,
    pub bytes: u64,
    pub cost_ms: f64,
    pub meshes: Vec<TaskMesh>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct TaskMesh {
    pub source: String,
    pub pack: String,
    pub options: String,
    pub records: String,
    /// The key that the pack must have; empty if any will do.
    #[serde(default)]
    pub key: String,
    /// The files that the pack must be baked from; empty if any bytes will do.
    #[serde(default)]
    pub inputs: Vec<Input>,
}

impl TaskMesh {
    /// Fails if a path cannot be written as JSON, or would be another one on Windows.
    pub fn new(job: &Job, out: &Path, from: KeyInputs) -> Result<Self, String> {
        let text = |path: &Path| {
            path.to_str().map(str::to_owned).ok_or_else(|| {
                format!("{}: this path is not UTF-8, so it cannot be written to a plan; rename it", path.display())
            })
        };
        let pack = job.output.strip_prefix(out).unwrap_or(&job.output);
        if pack.components().any(|part| part.as_os_str().as_encoded_bytes().contains(&b'\\')) {
            return Err(format!(
                "{}: its pack would have a `\\` in its path, which divides folders on Windows, so it cannot be planned; \
                 rename it",
                job.source.display()
            ));
        }
        text(pack)?;
        Ok(Self {
            source: text(&job.source)?,
            pack: slashed(pack),
            key: from.key(),
            options: from.options,
            records: from.records,
            inputs: from.inputs,
        })
    }
}

impl Task {
    pub fn new(task: usize, out: &Path, meshes: Vec<TaskMesh>) -> Self {
        let keys: String = meshes.iter().map(|mesh| mesh.key.as_str()).collect();
        let bytes = |mesh: &TaskMesh| mesh.inputs.iter().map(|input| input.bytes).sum::<u64>();
        let work = |mesh: &TaskMesh| {
            let options = BuildOptions::from_recorded(&mesh.options).unwrap_or_default();
            work(bytes(mesh), &options) as f64
        };
        let cost_ms = MILLIS_PER_MESH * meshes.len() as f64 + MILLIS_PER_BYTE * meshes.iter().map(work).sum::<f64>();
        let bytes: u64 = meshes.iter().map(bytes).sum();
        Self {
            task,
            key: sha256(keys.as_bytes()),
            out: out.display().to_string(),
            bytes,
            cost_ms: (cost_ms * 10.0).round() / 10.0,
            meshes,
        }
    }

    /// Fails if a path leads out of `out`, or this version does not have the options.
    pub fn jobs(&self, out: &Path) -> Result<Vec<Job>, String> {
        self.meshes.iter().map(|mesh| mesh.job(out)).collect()
    }
}

impl TaskMesh {
    fn job(&self, out: &Path) -> Result<Job, String> {
        let pack = Path::new(&self.pack);
        let is_inside = pack.components().all(|part| matches!(part, Component::Normal(_)));
        if !is_inside || !is_baked(pack) || self.pack.contains('\\') {
            return Err(format!("`{}` is not the path of a pack below --out; plan again", self.pack));
        }
        let options = BuildOptions::from_recorded(&self.options)
            .filter(|options| options.to_string() == self.options)
            .ok_or_else(|| format!("unknown options `{}`; plan again with this version", self.options))?;
        if kind_by_name(pack) != Some(options.file_kind()) {
            let expected = options.file_kind().extension();
            return Err(format!("`{}` must end in .{expected} with these options; plan again", self.pack));
        }
        let output = out.join(pack);
        Ok(Job {
            source: PathBuf::from(&self.source),
            place: self.pack.clone(),
            name: PackName { output: output.clone(), ..PackName::default() },
            output,
            options,
            config: None,
            records: Some(self.records.clone()),
            inputs: self.inputs.clone(),
            key: self.key.clone(),
        })
    }
}

/// Estimated time that each mesh takes, whatever its size: 0.4 ms for a mesh of 8 vertices.
const MILLIS_PER_MESH: f64 = 0.4;

/// Estimated time for each byte of [`work`]: 18 ms for an OBJ file of 300 KB, half for its hull.
const MILLIS_PER_BYTE: f64 = 6e-5;

/// The next task; `None` at the end. `line` is the number of the last line that was read, and empty
/// lines are skipped. Fails if the line cannot be read, is too long, or is not a task.
pub fn read_task(reader: &mut impl BufRead, line: &mut usize) -> Result<Option<Task>, String> {
    loop {
        let mut bytes = Vec::new();
        let mut bounded = std::io::Read::take(&mut *reader, MAX_BYTES + 1);
        bounded.read_until(b'\n', &mut bytes).map_err(|error| format!("cannot read: {error}"))?;
        *line += 1;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(format!("line {line} has more than {MAX_BYTES} bytes; plan smaller batches"));
        }
        if bytes.is_empty() {
            return Ok(None);
        }
        if !bytes.trim_ascii().is_empty() {
            let task = serde_json::from_slice(&bytes);
            return task.map(Some).map_err(|error| format!("line {line} is not a task of `bake farm plan`: {error}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(pack: &str) -> TaskMesh {
        TaskMesh {
            source: "in/a.obj".to_owned(),
            pack: pack.to_owned(),
            options: BuildOptions::default().to_string(),
            records: "a.obj".to_owned(),
            key: String::new(),
            inputs: Vec::new(),
        }
    }

    #[test]
    fn packs_stay_below_the_folder() {
        for pack in ["a.hullmap", "deep/er/a.hullmap"] {
            let job = mesh(pack).job(Path::new("out")).unwrap();
            assert_eq!(job.output, Path::new("out").join(pack));
        }
        for pack in ["", "../a.hullmap", "/a.hullmap", "x/../../a.hullmap", "a.obj", "a\\..\\b.hullmap"] {
            assert!(mesh(pack).job(Path::new("out")).is_err(), "{pack}");
        }
        let unknown = TaskMesh { options: "index oak".to_owned(), ..mesh("a.hullmap") };
        assert!(unknown.job(Path::new("out")).unwrap_err().contains("index oak"));
    }

    #[test]
    fn tasks_are_read_line_by_line() {
        let task = Task::new(3, Path::new("out"), vec![mesh("a.hullmap")]);
        let text = format!("\n{}\n\nnonsense\n", serde_json::to_string(&task).unwrap());
        let (mut reader, mut line) = (text.as_bytes(), 0);
        assert_eq!(read_task(&mut reader, &mut line), Ok(Some(task)));
        assert!(read_task(&mut reader, &mut line).unwrap_err().starts_with("line 4 is not a task"));
        assert_eq!(read_task(&mut reader, &mut line), Ok(None));
    }
}
