//! Jobs: the meshes to bake, their options, and their packs.
//!
//! | module | concept |
//! |---|---|
//! | [`search`] | the meshes that inputs name |
//! | [`filter`] | the meshes that `--exclude` and `--ext` leave |
//! | [`pack_names`] | the names of their packs |
//! | [`shard`] | the meshes of one of several machines |
//! | [`batch`] | meshes that are baked together elsewhere |
//! | [`key`] | everything that the bytes of a pack depend on |
//! | [`task`] | a batch as JSON, which another machine can bake |
//!
//! [`jobs`] puts the first three together. Local builds, shards, plans and remote builds start from
//! its list.

pub mod batch;
pub mod filter;
pub mod key;
pub mod pack_names;
pub mod search;
pub mod shard;
pub mod task;

use std::io;
use std::path::{Path, PathBuf};

use hullmap_import::NAMES;

use crate::args::MeshArgs;
use crate::config::{Chosen, Configs};
use crate::options::{BuildOptions, RecordSource, flag};
use crate::outcome::{Exit, Failure};
use crate::pack_file::{folder_of, recorded_path};
use crate::terminal;
use filter::Filter;
use key::Input;
use pack_names::PackName;
use search::{Found, Mesh, in_words, without_meshes};

/// One mesh, its pack, and the options.
#[derive(Clone, Debug)]
pub struct Job {
    /// The mesh, as named or found.
    pub source: PathBuf,
    /// Its path relative to the input folder, with `/`; the file name of a mesh that is itself an
    /// input. The same on all machines.
    pub place: String,
    /// The pack.
    pub output: PathBuf,
    /// Remarks on the name of the pack.
    pub name: PackName,
    /// The options that shape the pack.
    pub options: BuildOptions,
    /// The `hullmap.toml` they come from, if any.
    pub config: Option<PathBuf>,
    /// The path of the source that the pack must record; `None` if the options decide.
    pub records: Option<String>,
    /// The files that the pack must be baked from; empty if any bytes will do.
    pub inputs: Vec<Input>,
    /// The key that the pack must have; empty if any will do.
    pub key: String,
}

impl Job {
    /// The source's path, as the pack records it. `project` is the folder where `bake` was started.
    /// Fails if the canonical path of the source or of the pack's folder cannot be determined.
    pub fn recorded_path(&self, project: &Path) -> io::Result<String> {
        let name = || self.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match (&self.records, self.options.record_source()) {
            (Some(path), _) => Ok(path.clone()),
            (None, RecordSource::Relative) => recorded_path(&self.source, folder_of(&self.output), project),
            (None, RecordSource::Name) => Ok(name()),
            (None, RecordSource::None) => Ok(String::new()),
        }
    }

    /// Bytes of the mesh and of its buffers that were planned; `None` if any will do.
    pub fn planned_bytes(&self) -> Option<u64> {
        let sum = self.inputs.iter().fold(0_u64, |sum, input| sum.saturating_add(input.bytes));
        (!self.inputs.is_empty()).then_some(sum)
    }

    /// Bytes of the mesh and of its buffers, without reading buffers. 0 for files that cannot be
    /// read: baking them fails with an error. Complexity: one look at the file, unless it is
    /// planned; a glTF file is read, to find its buffers.
    pub fn source_bytes(&self) -> u64 {
        if let Some(planned) = self.planned_bytes() {
            return planned;
        }
        let length = |path: &Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
        // A GLB file contains its buffer; finding others would require reading all of it.
        let is_gltf = self.source.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
        let buffers = if is_gltf { hullmap_import::buffers_of(&self.source).unwrap_or_default() } else { Vec::new() };
        length(&self.source) + buffers.iter().map(|path| length(path)).sum::<u64>()
    }
}

/// The jobs of a build, and what it does not bake.
#[derive(Debug)]
pub struct Jobs {
    /// The meshes to bake.
    pub jobs: Vec<Job>,
    /// Meshes in input folders whose formats are not supported.
    pub unread: Vec<Unread>,
    /// Input folders without meshes. They do not stop the others.
    pub empty: Vec<PathBuf>,
}

/// A mesh whose format is not supported.
#[derive(Debug)]
pub struct Unread {
    /// The mesh.
    pub source: PathBuf,
    /// See [`Job::place`].
    pub place: String,
}

impl Jobs {
    /// Reports the folders without meshes, and returns the jobs with the exit code that this
    /// leaves.
    pub fn report_empty(self) -> (Vec<Job>, Exit) {
        self.empty.iter().for_each(|folder| terminal::error(without_meshes(folder)));
        (self.jobs, if self.empty.is_empty() { Exit::Done } else { Exit::Usage })
    }
}

/// Messages that [`jobs`] prints while it searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Talk {
    /// Nothing.
    Silent,
    /// Warnings about options without effect, and how many meshes have formats that are not
    /// supported.
    Warnings,
    /// Also a note for each mesh that is left out.
    All,
}

/// The meshes to bake, each with its options and its pack in `out`. `project` is the folder where
/// `bake` was started. Writes no file. Fails if an input or `hullmap.toml` cannot be read, no mesh
/// is left, or an option on the command line has no effect on any mesh.
pub fn jobs(args: &MeshArgs, out: &Path, project: &Path, talk: Talk) -> Result<Jobs, Failure> {
    let warns = talk != Talk::Silent;
    if out.is_file() {
        return Err(Failure::usage(format!(
            "{}: is a file, but --out requires a folder; name a folder for the packs",
            out.display()
        )));
    }
    let mut filter = Filter::new(args);
    let Found { meshes, unread: unsupported, empty } = search::search(&args.inputs, out, &mut filter)?;
    for glob in filter.unused().filter(|_| warns) {
        terminal::warning(format_args!("--exclude: no mesh matches `{glob}`"));
    }
    let mut configs = Configs::new(args.config.as_deref(), args.no_config, project)?;
    let mut chosen = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let Chosen { layer, skips, config } = configs.layer(&mesh.source)?;
        let config = config.map(|config| config.path.clone());
        if !skips {
            chosen.push((mesh, args.options.over(&layer).resolve(), config));
        } else if talk == Talk::All || warns && args.inputs.contains(&mesh.source) {
            let (source, config) = (mesh.source.display(), config.unwrap_or_default());
            terminal::note(format_args!("{source}: left out, because {} sets skip = true", config.display()));
        }
    }
    let mut unread = Vec::with_capacity(unsupported.len());
    for mesh in unsupported {
        if !configs.layer(&mesh.source)?.skips {
            unread.push(Unread { place: place(&mesh, out), source: mesh.source });
        }
    }
    let names: Vec<_> = chosen.iter().map(|(mesh, options, _)| (mesh, options.keeps_extension())).collect();
    let names = pack_names::pack_names(&names);
    let job = |((mesh, options, config), name): ((Mesh, BuildOptions, _), PackName)| Job {
        place: place(&mesh, out),
        source: mesh.source,
        output: name.output.clone(),
        name,
        options,
        config,
        records: None,
        inputs: Vec::new(),
        key: String::new(),
    };
    let jobs: Vec<Job> = chosen.into_iter().zip(names).map(job).collect();
    let unused = args.options.without_effect(jobs.iter().map(|job| &job.options));
    if let Some(unused) = unused.filter(|_| !jobs.is_empty()) {
        return Err(Failure::usage(unused.message(|key| format!("--{}", flag(key)))));
    }
    if warns {
        let is_cut_by = |config: &Path| {
            jobs.iter().any(|job| job.config.as_deref() == Some(config) && job.options.decompose().is_some())
        };
        configs.warnings(&args.inputs, is_cut_by).iter().for_each(terminal::warning);
        if let Some(unread) = in_words(unread.iter().map(|unread| unread.source.as_path())) {
            terminal::note(format_args!(
                "not read: {unread}; export them as {NAMES}, or leave them out with --exclude"
            ));
        }
    }
    Ok(Jobs { jobs, unread, empty })
}

/// Folder of the pack relative to `out`, and name of the mesh.
fn place(mesh: &Mesh, out: &Path) -> String {
    let folder = mesh.folder.strip_prefix(out).unwrap_or(Path::new(""));
    slashed(&folder.join(mesh.source.file_name().unwrap_or_default()))
}

/// A path with `/` between its components. Names that are not UTF-8 are replaced where they differ.
pub fn slashed(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}
