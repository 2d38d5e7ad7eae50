//! A command without arguments: the nearest `hullmap.toml` names the meshes and the folder of
//! packs. A build of some of its meshes is a part of the whole build: packs have the same names and
//! places.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgMatches, Command};

use hullmap_pipeline::config::{Config, Configs};
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::pack_file::folder_of;
use hullmap_pipeline::project::ROOT_MARKS;

pub struct Completed {
    pub words: Vec<OsString>,
    /// The sources of the project, if the inputs are some of its meshes or folders.
    pub sources: Option<Vec<PathBuf>>,
}

/// The words with the arguments that `error` misses; `None` if no `hullmap.toml` has them. The file
/// is the nearest one with an output, at or above the inputs, or the current folder if there are
/// none.
pub fn completed(words: &[OsString], error: &clap::Error, command: Command) -> Result<Option<Completed>, Failure> {
    let missing = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(missing)) if error.kind() == ErrorKind::MissingRequiredArgument => missing,
        _ => return Ok(None),
    };
    let is_missing = |own: &str| missing.iter().any(|name| name.starts_with(own));
    let Some(given) = optional(command).try_get_matches_from(words).ok().map(innermost) else { return Ok(None) };
    // Only commands that search for meshes or for packs.
    let reads_packs = is_missing("<FILE|DIR>");
    if !reads_packs && given.try_get_one::<bool>("no_ignore").ok().flatten().is_none() {
        return Ok(None);
    }
    let named = given.try_get_one::<PathBuf>("config").ok().flatten();
    let mut configs = Configs::new(named.map(PathBuf::as_path))?;
    let inputs = given.try_get_many::<PathBuf>("inputs").ok().flatten();
    let inputs: Vec<PathBuf> = inputs.unwrap_or_default().cloned().collect();
    let folder = |input: &PathBuf| if input.is_dir() { input.clone() } else { folder_of(input).to_owned() };
    let mut folders: Vec<PathBuf> = inputs.iter().map(folder).collect();
    if folders.is_empty() {
        folders.push(Path::new(".").to_owned());
    }
    let found = folders.iter().map(|folder| with_output(&mut configs, folder)).collect::<Result<Vec<_>, _>>()?;
    let [Some(config), others @ ..] = found.as_slice() else { return Ok(None) };
    let is_same = |other: &Option<_>| other.as_ref().is_some_and(|other| Arc::ptr_eq(config, other));
    if !others.iter().all(is_same) {
        return Ok(None);
    }
    let (mut words, sources) = (words.to_vec(), config.sources());
    if reads_packs {
        let Some(output) = config.output()? else { return Ok(None) };
        push_last(&mut words, output.into());
        return Ok(Some(Completed { words, sources: None }));
    }
    if is_missing("--out ") {
        let Some(output) = config.output()? else { return Ok(None) };
        let mut out = OsString::from("--out=");
        out.push(output);
        let end = words.iter().position(|word| word == "--").unwrap_or(words.len());
        words.insert(end, out);
    }
    if is_missing("<INPUT>") {
        sources.iter().for_each(|source| push_last(&mut words, source.into()));
    }
    let is_part = !inputs.is_empty() && is_missing("--out ") && inputs.iter().all(|input| is_of(input, &sources));
    Ok(Some(Completed { words, sources: is_part.then_some(sources) }))
}

/// Adds a word that is no flag.
fn push_last(words: &mut Vec<OsString>, word: OsString) {
    if !words.iter().any(|word| word == "--") {
        words.push("--".into());
    }
    words.push(word);
}

/// The nearest file with an output; the nearest file if none has one.
fn with_output(configs: &mut Configs, folder: &Path) -> Result<Option<Arc<Config>>, Failure> {
    let nearest = configs.of_folder(folder)?;
    let mut found = nearest.clone();
    while let Some(config) = &found {
        if config.output()?.is_some() {
            return Ok(found);
        }
        let folder = folder_of(&config.path);
        if ROOT_MARKS.iter().any(|mark| folder.join(mark).exists()) {
            break;
        }
        let above = match folder.parent() {
            Some(above) if !above.as_os_str().is_empty() => above,
            _ if folder == Path::new(".") => Path::new(".."),
            _ => Path::new("."),
        };
        let next = configs.of_folder(above)?;
        let is_end = next.as_ref().is_some_and(|next| Arc::ptr_eq(config, next));
        found = next.filter(|_| !is_end);
    }
    Ok(nearest)
}

/// Whether an input is in one of the sources, or holds one.
fn is_of(input: &Path, sources: &[PathBuf]) -> bool {
    let Ok(input) = input.canonicalize() else { return false };
    let mut sources = sources.iter().filter_map(|source| source.canonicalize().ok());
    sources.any(|source| input.starts_with(&source) || source.starts_with(&input))
}

fn optional(command: Command) -> Command {
    command.mut_args(|arg| arg.required(false)).mut_subcommands(optional)
}

fn innermost(mut found: ArgMatches) -> ArgMatches {
    while let Some((_, inner)) = found.remove_subcommand() {
        found = inner;
    }
    found
}
