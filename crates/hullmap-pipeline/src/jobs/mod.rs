//! Jobs: the meshes to bake, their options, and their packs.
//!
//! | module | concept |
//! |---|---|
//! | [`job`] | one mesh, its pack, and the options |
//! | [`selection`] | the inputs, and what leaves some of their meshes out |
//! | [`search`] | the meshes that inputs name |
//! | [`filter`] | the meshes that `--exclude` and `--ext` leave |
//! | [`pack_names`] | the names of their packs |
//! | [`shard`] | the meshes of one of several machines |
//! | [`batch`] | meshes that are baked together elsewhere |
//! | [`key`] | everything that the bytes of a pack depend on |
//! | [`task`] | a batch as JSON, which another machine can bake |

pub mod batch;
pub mod filter;
pub mod job;
pub mod key;
pub mod pack_names;
pub mod search;
pub mod selection;
pub mod shard;
pub mod task;

use std::path::{Path, PathBuf};

use hullmap_format::header::FileKind;
use hullmap_import::height_field::is_grid;
use hullmap_import::{NAMES, is_source};

use crate::config::{Chosen, Configs};
use crate::options::{BuildOptions, flag};
use crate::outcome::Failure;
use filter::Filter;
pub use job::Job;
use pack_names::{PackName, Unnamed};
use search::{Found, Mesh, in_words};
pub use selection::Selection;

#[derive(Debug)]
pub struct Jobs {
    pub jobs: Vec<Job>,
    /// Meshes in input folders whose formats are not supported.
    pub unread: Vec<Unread>,
    /// Input folders without meshes. They do not stop the others.
    pub empty: Vec<PathBuf>,
    /// All folders that were searched.
    pub folders: Vec<PathBuf>,
}

#[derive(Debug)]
pub struct Unread {
    pub source: PathBuf,
    pub place: String,
}

/// A message about a selection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Needs action.
    Warning(String),
    /// Needs no action.
    Note(String),
    /// For a user who wants to know about every mesh.
    Detail(String),
}

impl Jobs {
    /// Keeps only these meshes, and meshes in these folders; all if the list is empty.
    fn keep(&mut self, only: &[PathBuf]) -> Result<(), Failure> {
        let Some(first) = only.first() else { return Ok(()) };
        let only: Vec<PathBuf> = only.iter().filter_map(|path| path.canonicalize().ok()).collect();
        let is_chosen =
            |path: &Path| path.canonicalize().is_ok_and(|path| only.iter().any(|folder| path.starts_with(folder)));
        self.jobs.retain(|job| is_chosen(&job.source));
        self.unread.retain(|unread| is_chosen(&unread.source));
        self.empty.retain(|folder| is_chosen(folder));
        if self.jobs.is_empty() && self.unread.is_empty() && self.empty.is_empty() {
            return Err(Failure::usage(format!(
                "{}: the build of the project has no mesh here; to bake others, name the folder of the packs with --out",
                first.display()
            )));
        }
        Ok(())
    }
}

/// The jobs of a build. Writes no file. `say` receives messages, also before an error.
///
/// # Errors
/// An input or `hullmap.toml` cannot be read, no mesh is left, or an option on the command line
/// affects no mesh.
pub fn jobs(selection: &Selection, out: &Path, say: &mut dyn FnMut(Message)) -> Result<Jobs, Failure> {
    if out.is_file() {
        return Err(Failure::usage(format!(
            "{}: is a file, but --out requires a folder; name a folder for the packs",
            out.display()
        )));
    }
    let mut filter = Filter::new(selection);
    let mut configs = Configs::new(selection.config.as_deref())?;
    let is_terrain = selection.options.kind() == FileKind::HeightField;
    let mut is_meant = |path: &Path| match is_source(path) {
        false if is_grid(path) => {
            Ok(selection.options.laid_over(&configs.layer(path)?.layer).kind() == FileKind::HeightField)
        }
        is_mesh => Ok(is_mesh && !is_terrain),
    };
    let found = search::search(&selection.inputs, out, &mut filter, selection.no_ignore, &mut is_meant)?;
    if let Some(passed_over) = found.passed_over() {
        say(Message::Note(passed_over));
    }
    let Found { meshes, unread: unsupported, empty, folders, .. } = found;
    for glob in filter.unused() {
        say(Message::Warning(format!("--exclude: no mesh matches `{glob}`")));
    }
    let mut chosen = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let Chosen { layer, skips, config } = configs.layer(&mesh.source)?;
        let config = config.map(|config| config.path.clone());
        if !skips {
            chosen.push((mesh, selection.options.laid_over(&layer).resolve(), config));
        } else {
            let (source, config) = (mesh.source.display(), config.unwrap_or_default());
            let text = format!("{source}: left out, because {} sets skip = true", config.display());
            let is_named = selection.inputs.iter().chain(&selection.only).any(|input| *input == mesh.source);
            say(if is_named { Message::Note(text) } else { Message::Detail(text) });
        }
    }
    let mut unread = Vec::with_capacity(unsupported.len());
    for mesh in unsupported {
        if !configs.layer(&mesh.source)?.skips {
            unread.push(Unread { place: place(&mesh, out), source: mesh.source });
        }
    }
    let names: Vec<Unnamed> = chosen
        .iter()
        .map(|(mesh, options, _)| Unnamed {
            mesh,
            keeps_extension: options.keeps_extension(),
            kind: options.file_kind(),
        })
        .collect();
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
    let jobs = chosen.into_iter().zip(names).map(job).collect();
    let mut found = Jobs { jobs, unread, empty, folders };
    found.keep(&selection.only)?;
    let Jobs { jobs, unread, .. } = &found;
    let unused = selection.options.without_effect(jobs.iter().map(|job| &job.options));
    if let Some(unused) = unused.filter(|_| !jobs.is_empty()) {
        return Err(Failure::usage(unused.message(flag)));
    }
    options_without_effect(selection, &configs, jobs).into_iter().for_each(&mut *say);
    if let Some(unread) = in_words(unread.iter().map(|unread| unread.source.as_path())) {
        say(Message::Note(format!("not read: {unread}; export them as {NAMES}, or leave them out with --exclude")));
    }
    Ok(found)
}

/// Messages about options of `hullmap.toml` that have no effect. A build of some meshes does not
/// warn of the others' rules.
fn options_without_effect(selection: &Selection, configs: &Configs, jobs: &[Job]) -> Vec<Message> {
    let mut messages: Vec<Message> = configs.overridden(&selection.options).into_iter().map(Message::Note).collect();
    let is_cut_by = |config: &Path| {
        jobs.iter().any(|job| job.config.as_deref() == Some(config) && job.options.decompose().is_some())
    };
    if selection.only.is_empty() {
        messages.extend(configs.warnings(&selection.inputs, is_cut_by).into_iter().map(Message::Warning));
    }
    messages
}

fn place(mesh: &Mesh, out: &Path) -> String {
    let folder = mesh.folder.strip_prefix(out).unwrap_or(Path::new(""));
    slashed(&folder.join(mesh.source.file_name().unwrap_or_default()))
}

/// A path with `/` between its components. Names that are not UTF-8 are replaced where they differ.
pub fn slashed(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}
