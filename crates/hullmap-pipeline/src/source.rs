//! Finds the mesh that a pack was baked from.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use hullmap::Asset;

use crate::content::{Content, read};
use crate::open::open_asset;
use crate::options::BuildOptions;
use crate::options::removed::instead_of_record;
use crate::outcome::Failure;
use crate::pack_file::{folder_of, plain, resolve_recorded, shown_from};
use crate::packs::PackPlace;
use crate::project::{Found, Project};
use hullmap_format::header::FileKind;
use hullmap_import::height_field::is_grid;
use hullmap_import::{EXTENSIONS, Limits, ReadError, SourceFile, is_source};

/// A pack's source, found and imported as it was when the pack was baked.
#[derive(Debug)]
pub struct Source {
    pub path: PathBuf,
    pub content: Content,
}

#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// XXH3-128 of all bytes it was baked from: see [`SourceFile::hash`].
    pub hash: u128,
    /// Its path relative to the pack's folder, or its name; empty if no source was recorded.
    pub path: &'a str,
    pub options: &'a str,
}

impl<'a> Recorded<'a> {
    pub fn from_asset(asset: &'a Asset) -> Self {
        Self { hash: asset.header().source_hash, path: asset.source_path(), options: asset.options() }
    }

    pub fn from_pack(pack: &'a hullmap::Pack) -> Self {
        Self { hash: pack.header().source_hash, path: pack.source_path(), options: pack.options() }
    }
}

#[derive(Debug)]
pub enum SourceSearch {
    Found(Box<Source>),
    /// No source. If a file was not followed or read, the reason.
    Absent(Option<String>),
}

/// Meshes in folders, by the name of their pack. A folder is read once: reading it again for each
/// of its packs would take time that grows with the square of their number.
#[derive(Debug, Default)]
pub struct Folders(RefCell<HashMap<PathBuf, HashMap<OsString, BTreeSet<PathBuf>>>>);

impl Folders {
    /// The mesh files in `folder` with the stem of `pack`, or the grids of heights, sorted;
    /// extensions in any case.
    fn with_stem(&self, folder: &Path, pack: &Path, is_terrain: bool) -> Vec<PathBuf> {
        let Some(stem) = pack.file_stem() else { return Vec::new() };
        let mut folders = self.0.borrow_mut();
        let meshes = match folders.get(folder) {
            Some(meshes) => meshes,
            None => folders.entry(folder.to_owned()).or_insert(meshes_by_name(folder)),
        };
        meshes.get(stem).into_iter().flatten().filter(|path| is_grid(path) == is_terrain).cloned().collect()
    }
}

/// Mesh files by the stems that their packs may have: with and without the extension.
fn meshes_by_name(folder: &Path) -> HashMap<OsString, BTreeSet<PathBuf>> {
    let mut meshes: HashMap<OsString, BTreeSet<PathBuf>> = HashMap::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()).filter(|path| is_source(path) || is_grid(path)) {
        for name in [path.file_stem(), path.file_name()].into_iter().flatten() {
            meshes.entry(name.to_owned()).or_default().insert(path.clone());
        }
    }
    meshes
}

/// Finds and imports the source of a pack, within `limits`. `folders` remembers the folders that
/// were read for other packs.
///
/// `given` is the path of `--source`: the file, or a folder that holds it, mirrored or flat.
/// Without it, the files beside the pack with its stem are tried, then the recorded path, all only
/// inside the pack's [`Project`]. The first file with the recorded hash is the source.
///
/// # Errors
/// Usage: `--source` leads to no file. Rejected: the files found differ from the one the pack was
/// baked from, or cannot be imported; the error is about the first of them.
pub fn find_source(
    place: &PackPlace,
    recorded: Recorded,
    given: Option<&Path>,
    limits: &Limits,
    folders: &Folders,
) -> Result<SourceSearch, Failure> {
    let folder = folder_of(&place.path);
    let options = BuildOptions::from_recorded(recorded.options);
    let is_terrain = options.as_ref().is_some_and(|options| options.file_kind() == FileKind::HeightField);
    // `..` is removed here: the system resolves it after links, `Project` before them.
    let followed = resolve_recorded(recorded.path, folder).map(|path| plain(&path));
    let candidates = match given {
        Some(given) if given.is_dir() => in_folder(place, recorded.path, given, folders, is_terrain),
        Some(given) => vec![given.to_owned()],
        None => folders.with_stem(folder, &place.path, is_terrain).into_iter().chain(followed.clone()).collect(),
    };
    let project = Project::of_pack(place, Path::new(".")).filter(|_| given.is_none());
    let context = Candidates { place, recorded, options: options.as_ref(), given, project, followed };
    let (mut rejected, mut not_followed) = (None, None);
    for path in candidates {
        match context.check(&path, limits)? {
            Candidate::IsSource(file) => {
                let options = options.as_ref().ok_or_else(|| unknown_options(&path, recorded))?;
                let content = Content::import(&path, &file, options, limits)?;
                return Ok(SourceSearch::Found(Box::new(Source { path, content })));
            }
            Candidate::Rejected(reason) => _ = rejected.get_or_insert(reason),
            Candidate::NotFollowed(reason) => _ = not_followed.get_or_insert(reason),
            Candidate::Missing => {}
        }
    }
    match (rejected, given) {
        (Some(message), _) => Err(Failure::rejected(message)),
        (None, Some(given)) => {
            let (pack, given) = (place.path.display(), given.display());
            let stem = place.path.file_stem().unwrap_or_default();
            let extensions = EXTENSIONS.join("|");
            let name = if is_source(Path::new(stem)) {
                stem.display().to_string()
            } else {
                format!("{}.{extensions}", stem.display())
            };
            let below = place.below.join(name);
            Err(Failure::usage(format!(
                "{pack}: no source found in {given}; expected {} there, or leave out --source",
                below.display()
            )))
        }
        (None, None) => Ok(SourceSearch::Absent(not_followed)),
    }
}

enum Candidate {
    IsSource(Box<SourceFile>),
    Rejected(String),
    /// Outside the project, or no regular file: the reason.
    NotFollowed(String),
    Missing,
}

struct Candidates<'a> {
    place: &'a PackPlace,
    recorded: Recorded<'a>,
    /// `None` if this version does not have them.
    options: Option<&'a BuildOptions>,
    given: Option<&'a Path>,
    /// `None` if `--source` names the files.
    project: Option<Project>,
    followed: Option<PathBuf>,
}

impl Candidates<'_> {
    /// Reads a file inside the project, and compares its hash. Fails if `--source` names an
    /// unreadable file.
    fn check(&self, path: &Path, limits: &Limits) -> Result<Candidate, Failure> {
        let is_followed = self.followed.as_deref() == Some(path);
        let absolute = match folder_of(&self.place.path).canonicalize() {
            Ok(folder) if !is_followed => folder.join(path.file_name().unwrap_or_default()),
            _ => path.to_owned(),
        };
        if let Some(reason) = why_not_read(self.project.as_ref(), &absolute) {
            let name =
                if is_followed { format!("the recorded path `{}`", self.recorded.path) } else { self.shown(path) };
            return Ok(Candidate::NotFollowed(format!("{name} {reason}")));
        }
        let options = self.options.cloned().unwrap_or_default();
        let source = match read(&self.shown(path), path, &options, limits) {
            Ok(source) => source,
            Err(ReadError::Io(error)) if self.given == Some(path) => {
                return Err(Failure::usage(format!(
                    "{}: cannot read: {error}; name the source mesh, or a folder of meshes",
                    path.display()
                )));
            }
            Err(ReadError::Io(_)) => return Ok(Candidate::Missing),
            // The file is there, but one of its buffers is missing or damaged.
            Err(ReadError::Import(error)) => return Ok(Candidate::Rejected(error.to_string())),
        };
        let buffer_outside = |(name, _): &(String, Vec<u8>)| {
            let reason = why_not_read(self.project.as_ref(), &absolute.with_file_name(name))?;
            Some(format!("buffer {name} {reason}"))
        };
        if let Some(reason) = source.beside.iter().find_map(buffer_outside) {
            let path = self.shown(path);
            return Ok(Candidate::Rejected(format!("{path}: {reason}; name the mesh with --source")));
        }
        if source.hash == self.recorded.hash {
            return Ok(Candidate::IsSource(Box::new(source)));
        }
        let (pack, path) = (self.place.path.display(), self.shown(path));
        Ok(Candidate::Rejected(format!(
            "{pack}: stale: {path} has changed since it was baked, or is another file; bake it again"
        )))
    }

    /// A path as messages show it. A recorded path is absolute here.
    fn shown(&self, path: &Path) -> String {
        let is_absolute = self.given.is_none() && path.is_absolute();
        let path = if is_absolute { shown_from(path, Path::new(".")) } else { path.to_owned() };
        path.display().to_string()
    }
}

/// Why the file at an absolute path is not read; `None` if it may be read, or is not there, or
/// `--source` names it. The answer is the same whether or not there is a file outside the project.
fn why_not_read(project: Option<&Project>, path: &Path) -> Option<&'static str> {
    match project?.find(path) {
        Found::File | Found::Missing => None,
        Found::Outside => Some("leads out of the pack's project, so it was not followed"),
        Found::NotRegular => Some("is not a regular file, so it was not read"),
    }
}

/// The path that `--source` gives for each pack. A folder counts for every pack, a mesh for the
/// packs with its own or recorded name. Fails if `--source` names a mesh, and none of several packs
/// has its name.
pub fn given_sources<'a>(given: Option<&'a Path>, places: &[PackPlace]) -> Result<Vec<Option<&'a Path>>, Failure> {
    let Some(mesh) = given.filter(|path| !path.is_dir() && places.len() > 1) else {
        return Ok(vec![given; places.len()]);
    };
    let is_meant = |place: &PackPlace| {
        // A pack that does not open is reported later.
        let pack = open_asset(&place.path).ok();
        let recorded = pack.as_ref().and_then(|pack| pack.source_path().rsplit('/').next());
        has_name_of(mesh, &place.path) || recorded.is_some_and(|name| mesh.file_name().is_some_and(|file| file == name))
    };
    let sources: Vec<Option<&Path>> = places.iter().map(|place| given.filter(|_| is_meant(place))).collect();
    if sources.iter().all(Option::is_none) {
        return Err(Failure::usage(format!(
            "--source {}: none of the {} packs has this name; name the pack of this mesh, or a folder of meshes",
            mesh.display(),
            places.len()
        )));
    }
    Ok(sources)
}

/// At the pack's relative path, or directly in the folder; with its stem, or the recorded name.
fn in_folder(place: &PackPlace, recorded: &str, folder: &Path, folders: &Folders, is_terrain: bool) -> Vec<PathBuf> {
    let recorded_name = recorded.rsplit('/').next().filter(|name| !name.is_empty() && *name != "..");
    let mut paths = Vec::new();
    for folder in [folder.join(&place.below), folder.to_owned()] {
        paths.extend(folders.with_stem(&folder, &place.path, is_terrain));
        paths.extend(recorded_name.map(|name| folder.join(name)));
    }
    paths
}

fn has_name_of(mesh: &Path, pack: &Path) -> bool {
    [mesh.file_stem(), mesh.file_name()].contains(&pack.file_stem())
}

fn unknown_options(path: &Path, recorded: Recorded) -> Failure {
    let why = instead_of_record(recorded.options).map_or_else(String::new, |instead| format!(" ({instead})"));
    let message = format!("its pack was baked with options that this version does not have{why}; bake it again");
    Failure::rejected(format!("{}: {message}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Exit;
    use hullmap_format::header::source_hash;

    const CLOUD: &str = "o a\nv 1 2 3\no b\nv 4 5 6\n";

    fn recorded(path: &str) -> Recorded<'_> {
        let options = "split object, vertices referenced, index cubemap 5";
        Recorded { hash: source_hash(CLOUD.as_bytes()), path, options }
    }

    fn search(place: &PackPlace, recorded: Recorded, given: Option<&Path>) -> Result<Option<Source>, Failure> {
        find_source(place, recorded, given, &Limits::DEFAULT, &Folders::default()).map(|search| match search {
            SourceSearch::Found(source) => Some(*source),
            SourceSearch::Absent(_) => None,
        })
    }

    fn folder(files: &[(&str, &str)]) -> (tempfile::TempDir, PackPlace) {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files.iter().chain(&[("out/sub/x.hullmap", "")]) {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let path = folder.path().join("out/sub/x.hullmap");
        (folder, PackPlace { path, below: "sub".into() })
    }

    #[test]
    fn sources_are_found_in_every_supported_place() {
        for (file, path, requested) in [
            ("out/sub/x.obj", "", None),
            ("out/sub/x.OBJ", "gone.obj", None),
            ("meshes/other.obj", "../../meshes/other.obj", None),
            ("meshes/any.txt", "", Some("meshes/any.txt")),
            ("meshes/x.obj", "", Some("meshes")),
            ("meshes/sub/x.Obj", "", Some("meshes")),
            ("meshes/y.obj", "../elsewhere/y.obj", Some("meshes")),
        ] {
            let (folder, place) = folder(&[(file, CLOUD)]);
            let requested = requested.map(|requested| folder.path().join(requested));
            let source = search(&place, recorded(path), requested.as_deref()).unwrap();
            let source = source.unwrap_or_else(|| panic!("{file}"));
            assert_eq!(source.path.canonicalize().unwrap(), folder.path().join(file).canonicalize().unwrap());
            let names: Vec<_> = source.content.point_sets().iter().map(|set| set.name.as_str()).collect();
            assert_eq!(names, ["a", "b"], "imported with the pack's options");
        }
    }

    #[test]
    fn meshes_are_found_as_by_a_search_of_the_folder() {
        let names = ["x.obj", "x.OBJ", "x.obj.stl", "x.stl", "x", "x.obj.obj", "y.gltf", "x.hullmap", "x.txt", ".obj"];
        let (folder, _) = folder(&names.map(|name| (name, "")));
        let folders = Folders::default();
        for name in names {
            let pack = folder.path().join(name).with_extension("hullmap");
            let entries = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
            let is_candidate = |path: &PathBuf| has_name_of(path, &pack) && is_source(path);
            let mut slow: Vec<PathBuf> = entries.filter(is_candidate).collect();
            slow.sort_unstable();
            assert_eq!(folders.with_stem(folder.path(), &pack, false), slow, "{name}");
        }
        assert!(folders.with_stem(&folder.path().join("gone"), Path::new("x.hullmap"), false).is_empty());
    }

    #[test]
    fn the_file_with_the_recorded_hash_is_chosen() {
        let (folder, place) =
            folder(&[("m/x.obj", "v 0 0 0\n"), ("m/sub/x.obj", CLOUD), ("out/sub/x.obj", "v 0 0 0\n")]);
        let requested = folder.path().join("m");
        assert!(search(&place, recorded(""), Some(&requested)).unwrap().is_some());
        assert!(search(&place, recorded("../../m/sub/x.obj"), None).unwrap().is_some());
    }

    #[test]
    fn changed_sources_are_stale() {
        let (folder, place) = folder(&[("out/sub/x.obj", "v 0 0 0\n")]);
        let requested = folder.path().join("out/sub/x.obj");
        for requested in [None, Some(requested.as_path())] {
            let failure = search(&place, recorded(""), requested).unwrap_err();
            assert_eq!(failure.exit, Exit::Rejected);
            assert!(failure.message.contains("stale"), "{failure}");
        }
    }

    #[test]
    fn a_missing_source_is_an_error_only_if_it_was_named() {
        let (folder, place) = folder(&[("meshes/z.obj", CLOUD)]);
        assert!(search(&place, recorded("../gone.obj"), None).unwrap().is_none());
        for requested in ["meshes", "nowhere"] {
            let failure = search(&place, recorded(""), Some(&folder.path().join(requested))).unwrap_err();
            assert_eq!(failure.exit, Exit::Usage, "{requested}");
        }
    }
}
