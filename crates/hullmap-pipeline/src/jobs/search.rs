use std::collections::{BTreeMap, HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use ignore::{DirEntry, Error, WalkBuilder};

use super::filter::Filter;
use crate::outcome::Failure;
use crate::project::ROOT_MARKS;
use hullmap_import::height_field::is_grid;
use hullmap_import::{NAMES, is_source, unread_format};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    pub source: PathBuf,
    pub folder: PathBuf,
}

/// Whether a file in a folder is baked: a mesh, or a grid of heights that a rule chooses.
pub type IsMeant<'a> = dyn FnMut(&Path) -> Result<bool, Failure> + 'a;

#[derive(Debug, Default)]
pub struct Found {
    /// The meshes in the order of the inputs, sorted by name within each folder.
    pub meshes: Vec<Mesh>,
    /// Meshes in folders whose formats are not supported, in the same order.
    pub unread: Vec<Mesh>,
    pub empty: Vec<PathBuf>,
    /// All folders that were searched, except folders of packs.
    pub folders: Vec<PathBuf>,
    /// Number of meshes in folders that are hidden, or in hidden folders.
    pub hidden: usize,
    /// Number of other meshes in folders that a `.gitignore` names.
    pub ignored: usize,
}

impl Found {
    /// The meshes in folders that are passed over, with the reason and the remedy.
    pub fn passed_over(&self) -> Option<String> {
        let reasons = [(self.hidden, "hidden"), (self.ignored, "named by .gitignore")];
        let counts = reasons.iter().filter(|(count, _)| *count > 0).map(|(count, reason)| format!("{count} {reason}"));
        let counts: Vec<String> = counts.collect();
        (!counts.is_empty()).then(|| format!("meshes passed over: {} (--no-ignore bakes them)", counts.join(", ")))
    }
}

/// The meshes that inputs name.
///
/// Packs of files lie in `out`; files in a folder keep their path relative to it. Links to folders
/// are followed, except in cycles. A file that is reached twice with the same folder is baked once.
/// In folders, hidden files and files that a `.gitignore` names are passed over, unless `is_all`;
/// `is_meant` decides which of the others are baked. Fails if an input is missing or cannot be
/// read, or no mesh is left.
pub fn search(
    inputs: &[PathBuf],
    out: &Path,
    filter: &mut Filter,
    is_all: bool,
    is_meant: &mut IsMeant,
) -> Result<Found, Failure> {
    let mut found = Found::default();
    let mut left_out = 0;
    for input in inputs {
        let kind = std::fs::metadata(input).map_err(|error| {
            Failure::usage(format!("{}: cannot read this input: {error}; check the path", input.display()))
        })?;
        if kind.is_dir() {
            let before = found.meshes.len();
            let count = search_folder(input, out, filter, is_all, is_meant, &mut found)?;
            if count == 0 {
                found.empty.push(input.clone());
            }
            left_out += count - (found.meshes.len() - before);
        } else if filter.keeps(None, input) {
            found.meshes.push(Mesh { source: input.clone(), folder: out.to_owned() });
        } else {
            left_out += 1;
        }
    }
    if let Some(empty) = found.empty.first().filter(|_| found.meshes.is_empty() && left_out == 0) {
        let unread = in_words(found.unread.iter().map(|mesh| mesh.source.as_path()));
        let unread = unread.map_or(String::new(), |unread| format!("; not read: {unread}"));
        let passed_over = found.passed_over().map_or(String::new(), |passed_over| format!("; {passed_over}"));
        return Err(Failure::usage(format!("{}{unread}{passed_over}", without_meshes(empty))));
    }
    if found.meshes.is_empty() {
        return Err(Failure::usage(format!(
            "--exclude and --ext leave no mesh to bake (left out: {left_out}); change one of them"
        )));
    }
    let (meshes, unread) = (without_repeats(found.meshes), without_repeats(found.unread));
    Ok(Found { meshes, unread, ..found })
}

pub fn without_meshes(folder: &Path) -> String {
    format!("{}: no meshes ({NAMES}) in this folder; name a folder of meshes", folder.display())
}

/// Unsupported files, counted by extension: `2 .fbx (FBX), 53 .usd (USD)`.
pub fn in_words<'a>(files: impl Iterator<Item = &'a Path>) -> Option<String> {
    let mut counts: BTreeMap<(String, &str), usize> = BTreeMap::new();
    for file in files {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        *counts.entry((extension, unread_format(file).unwrap_or_default())).or_default() += 1;
    }
    let words = counts.iter().map(|((extension, format), count)| format!("{count} .{extension} ({format})"));
    Some(words.collect::<Vec<_>>().join(", ")).filter(|text| !text.is_empty())
}

/// Adds the meshes in a folder; returns how many it holds, before `filter` leaves any out.
fn search_folder(
    folder: &Path,
    out: &Path,
    filter: &mut Filter,
    is_all: bool,
    is_meant: &mut IsMeant,
    found: &mut Found,
) -> Result<usize, Failure> {
    let is_mesh = |path: &Path| is_source(path) || is_grid(path) || unread_format(path).is_some();
    let is_folder = |entry: &DirEntry| entry.file_type().is_some_and(|kind| kind.is_dir());
    let searched = (!is_all).then(|| {
        let path = |entry: Result<DirEntry, Error>| match entry {
            Ok(entry) => (is_folder(&entry) || is_mesh(entry.path())).then(|| entry.into_path()),
            Err(error) => dangling(&error).map(Path::to_owned),
        };
        walk(folder, false).build().filter_map(path).collect::<HashSet<PathBuf>>()
    });
    let is_searched = |path: &Path| searched.as_ref().is_none_or(|searched| searched.contains(path));
    let mut count = 0;
    for entry in walk(folder, true).build() {
        let path = match entry {
            Ok(entry) if is_folder(&entry) => {
                let is_input = is_searched(entry.path()) && !entry.path().starts_with(out);
                found.folders.extend(is_input.then(|| entry.into_path()));
                continue;
            }
            // Neither a pipe nor a device.
            Ok(entry) if !entry.file_type().is_some_and(|kind| kind.is_file()) => continue,
            Ok(entry) => entry.into_path(),
            Err(error) => match dangling(&error) {
                // Its bake fails, and does not stop the others. A hidden one is an editor's lock.
                Some(path) if !is_hidden(path.file_name()) => path.to_owned(),
                Some(_) => continue,
                None if is_loop(&error) => continue,
                None => {
                    return Err(Failure::usage(format!(
                        "{}: cannot search: {error}; check its permissions",
                        folder.display()
                    )));
                }
            },
        };
        let below = path.strip_prefix(folder).unwrap_or(&path);
        if !is_mesh(&path) {
            continue;
        }
        let is_meant = is_meant(&path)?;
        if !filter.keeps(Some(below), &path) {
            count += usize::from(is_meant);
            continue;
        }
        if !is_searched(&path) {
            let is_hidden = below.iter().any(|part| is_hidden(Some(part)));
            *(if is_hidden { &mut found.hidden } else { &mut found.ignored }) += usize::from(is_meant);
            continue;
        }
        if !is_meant && unread_format(&path).is_none() {
            continue;
        }
        let folder = out.join(below.parent().unwrap_or(Path::new("")));
        let meshes = if is_meant { &mut found.meshes } else { &mut found.unread };
        count += usize::from(is_meant);
        meshes.push(Mesh { source: path, folder });
    }
    Ok(count)
}

/// A walk through a folder in the order of names, also through links to folders: everything except
/// the data of version control, or what is neither hidden nor named by a `.gitignore`. Settings of
/// the user and the machine have no influence.
fn walk(folder: &Path, is_all: bool) -> WalkBuilder {
    let mut walk = WalkBuilder::new(folder);
    walk.standard_filters(false).follow_links(true).sort_by_file_name(OsStr::cmp);
    if is_all {
        walk.filter_entry(|entry| !ROOT_MARKS.iter().any(|mark| entry.file_name() == *mark));
    } else {
        walk.hidden(true).parents(true).git_ignore(true).require_git(false);
    }
    walk
}

fn is_hidden(name: Option<&OsStr>) -> bool {
    name.is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn dangling(error: &Error) -> Option<&Path> {
    match error {
        Error::WithDepth { err, .. } => dangling(err),
        Error::WithPath { path, .. } => Some(path.as_path()).filter(|path| path.is_symlink()),
        _ => None,
    }
}

fn is_loop(error: &Error) -> bool {
    match error {
        Error::WithDepth { err, .. } | Error::WithPath { err, .. } => is_loop(err),
        _ => matches!(error, Error::Loop { .. }),
    }
}

fn without_repeats(meshes: Vec<Mesh>) -> Vec<Mesh> {
    let mut known: HashMap<PathBuf, Vec<PathBuf>> = HashMap::new();
    let mut kept = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let others = known.entry(mesh.folder.join(mesh.source.file_name().unwrap_or_default())).or_default();
        let is_same = |other: &PathBuf| match (other.canonicalize(), mesh.source.canonicalize()) {
            (Ok(a), Ok(b)) => a == b,
            _ => *other == mesh.source,
        };
        if !others.iter().any(is_same) {
            others.push(mesh.source.clone());
            kept.push(mesh);
        }
    }
    kept
}
