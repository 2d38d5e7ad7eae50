//! Batches as actions: the inputs of a worker, and the paths in its folder.
//!
//! | path | file |
//! |---|---|
//! | `bake` | the program of `--remote-worker`, if it is given |
//! | `task.jsonl` | the [`Task`]: resolved options and paths |
//! | `in/…` | meshes at their places, and their buffers beside them |
//! | `out/…` | packs, and [`RESULTS`] |
//!
//! Places are relative to the input folders, so checkouts in different folders have equal actions.
//! `hullmap.toml` is not an input: an edit of it that changes no option changes no action.

use std::path::{Component, Path};

use hullmap_import as import;
use hullmap_remote::{Action, ActionSpec, Blob, Data, Digest, InputFile, RemoteError};

use crate::args::RemoteArgs;
use crate::jobs::key::inputs;
use crate::jobs::task::{Task, TaskMesh};
use crate::jobs::{Job, slashed};
use crate::outcome::Failure;
use crate::packs::is_baked;
use crate::runner::one::Build;
use crate::runner::rows::{Row, Status};
use crate::terminal;

/// Path of the rows in the worker's folder.
pub const RESULTS: &str = "out/results.jsonl";

/// Folder of the packs in the worker's folder.
const OUT: &str = "out";

/// A job of a batch.
#[derive(Debug)]
pub struct Member<'j> {
    /// Index of the job in the build.
    pub index: usize,
    /// The job.
    pub job: &'j Job,
    /// XXH3-128 of its source.
    pub hash: u128,
    /// Path of its source in the worker's folder.
    pub source: String,
    /// Path of its pack in the worker's folder.
    pub pack: String,
    /// Whether its pack is not fresh.
    pub is_wanted: bool,
}

impl Member<'_> {
    /// A row without results.
    pub fn row(&self) -> Row {
        let (source, output) = (self.job.source.display().to_string(), self.job.output.display().to_string());
        let mut row = Row::new(source, output, Status::Failed);
        row.options = Some(self.job.options.to_string());
        row
    }
}

/// Jobs that are baked together, as an action.
#[derive(Debug)]
pub struct Batch<'j> {
    /// The jobs, by place.
    pub members: Vec<Member<'j>>,
    /// The action.
    pub action: Action,
}

/// Inputs that all actions share.
pub struct Worker {
    /// The program, if it is an input.
    program: Option<Blob>,
    platform: Vec<(String, String)>,
    timeout: std::time::Duration,
    /// Flags of `bake task`.
    limits: Vec<String>,
}

impl Worker {
    /// Reads the program that `--remote-worker` names. Fails if it cannot be read.
    pub fn new(remote: &RemoteArgs, build: &Build) -> Result<Self, Failure> {
        let program = match &remote.worker {
            Some(path) => {
                let bytes = read("--remote-worker", path)?;
                // It is read again only if the server lacks it.
                Some(Blob { digest: Digest::from_bytes(&bytes), data: Data::File(path.clone()) })
            }
            None => None,
        };
        let limits = [
            ("--max-input-bytes", build.limits.input_bytes.to_string()),
            ("--max-objects", build.limits.objects.to_string()),
            ("--max-instanced", build.limits.repeated_vertices.to_string()),
        ];
        Ok(Self {
            program,
            platform: remote.properties.clone(),
            timeout: std::time::Duration::from_secs(remote.timeout),
            limits: limits.into_iter().flat_map(|(flag, value)| [flag.to_owned(), value]).collect(),
        })
    }
}

/// Whether a job can be described to another machine.
pub fn is_portable(job: &Job, build: &Build) -> bool {
    let is_plain = |path: &str| {
        let is_inside = Path::new(path).components().all(|part| matches!(part, Component::Normal(_)));
        is_inside && !path.contains(['\\', '\0', '\u{fffd}'])
    };
    let pack = job.output.strip_prefix(build.out).unwrap_or(&job.output);
    job.name.clash.is_none() && is_plain(&job.place) && is_baked(pack) && is_plain(&slashed(pack))
}

impl<'j> Batch<'j> {
    /// The batch of some jobs, each with its index and whether its pack is wanted. Jobs whose
    /// sources cannot be read are left out; `None` if no job is left, or none is wanted.
    pub fn new(jobs: Vec<(usize, &'j Job, bool)>, build: &Build, worker: &Worker) -> Option<Self> {
        let (mut members, mut meshes, mut files) = (Vec::with_capacity(jobs.len()), Vec::new(), Vec::new());
        for (index, job, is_wanted) in jobs {
            let Some((member, mesh)) = member(index, job, is_wanted, build, &mut files) else { continue };
            members.push(member);
            meshes.push(mesh);
        }
        if !members.iter().any(|member| member.is_wanted) {
            return None;
        }
        let outputs = members.iter().map(|member| member.pack.clone()).chain([RESULTS.to_owned()]).collect();
        let mut task = Task::new(0, Path::new(OUT), meshes);
        // The inputs state sizes and hashes already.
        task.key = String::new();
        let task = Blob::from_bytes(serde_json::to_vec(&task).ok()?);
        files.push(InputFile { path: "task.jsonl".to_owned(), blob: task, is_executable: false });
        let program = match &worker.program {
            Some(blob) => {
                files.push(InputFile { path: "bake".to_owned(), blob: blob.clone(), is_executable: true });
                "./bake"
            }
            None => "bake",
        };
        let words = [program, "task", "task.jsonl", "--results", RESULTS, "--quiet"].map(str::to_owned);
        // Actions share the cores of a machine; a mesh that is alone may take as many as it finds.
        let threads: &[&str] = if members.len() > 1 { &["--jobs", "1"] } else { &[] };
        let threads = threads.iter().map(|word| (*word).to_owned());
        let spec = ActionSpec {
            arguments: words.into_iter().chain(threads).chain(worker.limits.iter().cloned()).collect(),
            // Another version may bake other packs.
            environment: vec![("HULLMAP_BAKER".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
            inputs: files,
            outputs,
            platform: worker.platform.clone(),
            timeout: Some(worker.timeout),
        };
        match spec.action() {
            Ok(action) => Some(Self { members, action }),
            Err(error) => {
                terminal::warning(format_args!("{error}; baking {} meshes here", members.len()));
                None
            }
        }
    }

    /// The jobs whose packs are not fresh.
    pub fn wanted(&self) -> impl Iterator<Item = &Member<'j>> {
        self.members.iter().filter(|member| member.is_wanted)
    }
}

/// A job as a member of a batch, and as a mesh of a task; its files are added to `files`. `None` if
/// they cannot be read: a bake here reports that.
fn member<'j>(
    index: usize,
    job: &'j Job,
    is_wanted: bool,
    build: &Build,
    files: &mut Vec<InputFile>,
) -> Option<(Member<'j>, TaskMesh)> {
    let source = import::read(&job.source.display().to_string(), &job.source, &build.limits).ok()?;
    let records = job.recorded_path(build.project).ok()?;
    let place = format!("in/{}", job.place);
    let (folder, name) = place.rsplit_once('/')?;
    let own: Result<Vec<InputFile>, RemoteError> = inputs(name, &source)
        .into_iter()
        .map(|input| {
            let digest = Digest::new(&input.sha256, input.bytes)?;
            let path = format!("{folder}/{}", input.path);
            let data = Data::File(job.source.with_file_name(&input.path));
            Ok(InputFile { path, blob: Blob { digest, data }, is_executable: false })
        })
        .collect();
    let own = own.ok()?;
    // A buffer that is not below its mesh has no place.
    if own.iter().any(|file| Path::new(&file.path).components().any(|part| !matches!(part, Component::Normal(_)))) {
        return None;
    }
    files.extend(own);
    let pack = slashed(job.output.strip_prefix(build.out).unwrap_or(&job.output));
    let mesh = TaskMesh {
        source: place.clone(),
        pack: pack.clone(),
        options: job.options.to_string(),
        records,
        key: String::new(),
        inputs: Vec::new(),
    };
    let member = Member { index, job, hash: source.hash, source: place, pack: format!("{OUT}/{pack}"), is_wanted };
    Some((member, mesh))
}

/// The bytes of a file that a flag names.
pub fn read(flag: &str, path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path)
        .map_err(|error| Failure::usage(format!("{flag} {}: cannot read: {error}; check the path", path.display())))
}
