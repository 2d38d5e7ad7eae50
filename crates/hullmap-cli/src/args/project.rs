//! A build without arguments: the nearest `hullmap.toml` names the meshes and the folder of packs.
//! A build of some of its meshes writes their packs where the whole build does.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgMatches, Command};

use hullmap_pipeline::config::Configs;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::pack_file::folder_of;

/// The words with the arguments that `error` misses; `None` if no `hullmap.toml` has them. The file
/// is the one that applies to the inputs, or to the current folder if there are none.
pub fn completed(words: &[OsString], error: &clap::Error, command: Command) -> Result<Option<Vec<OsString>>, Failure> {
    let missing = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(missing)) if error.kind() == ErrorKind::MissingRequiredArgument => missing,
        _ => return Ok(None),
    };
    let is_missing = |own: &str| missing.iter().any(|name| name.starts_with(own));
    let Some(given) = optional(command).try_get_matches_from(words).ok().map(innermost) else { return Ok(None) };
    // Only commands that search for meshes.
    if given.try_get_one::<bool>("no_ignore").ok().flatten().is_none() {
        return Ok(None);
    }
    let mut configs = Configs::new(given.get_one::<PathBuf>("config").map(PathBuf::as_path))?;
    let inputs = given.get_many::<PathBuf>("inputs").unwrap_or_default();
    let folder = |input: &PathBuf| if input.is_dir() { input.clone() } else { folder_of(input).to_owned() };
    let mut folders: Vec<PathBuf> = inputs.map(folder).collect();
    if folders.is_empty() {
        folders.push(Path::new(".").to_owned());
    }
    let found = folders.iter().map(|folder| configs.of_folder(folder)).collect::<Result<Vec<_>, _>>()?;
    let [Some(config), others @ ..] = found.as_slice() else { return Ok(None) };
    let is_same = |other: &Option<_>| other.as_ref().is_some_and(|other| Arc::ptr_eq(config, other));
    if !others.iter().all(is_same) {
        return Ok(None);
    }
    let mut words = words.to_vec();
    if is_missing("--out ") {
        let Some(output) = config.output()? else { return Ok(None) };
        let sources = config.sources();
        let mut below = folders.iter().map(|folder| below(folder, &sources).unwrap_or_default());
        let first = below.next().unwrap_or_default();
        if below.any(|other| other != first) {
            return Err(Failure::usage(
                "the inputs lie in different folders of the project; run `bake build` without inputs, which bakes only \
                 what changed, or name the folder of the packs with --out",
            ));
        }
        let mut out = OsString::from("--out=");
        out.push(output.join(first));
        let end = words.iter().position(|word| word == "--").unwrap_or(words.len());
        words.insert(end, out);
    }
    if is_missing("<INPUT>") {
        if !words.iter().any(|word| word == "--") {
            words.push("--".into());
        }
        words.extend(config.sources().into_iter().map(OsString::from));
    }
    Ok(Some(words))
}

/// The path of a folder below the first of the sources that holds it.
fn below(folder: &Path, sources: &[PathBuf]) -> Option<PathBuf> {
    let folder = folder.canonicalize().ok()?;
    let roots = sources.iter().filter_map(|source| source.canonicalize().ok());
    roots.filter_map(|root| folder.strip_prefix(root).ok().map(Path::to_owned)).next()
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
