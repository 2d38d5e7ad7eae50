//! From a pack back to the mesh it was baked from.

use std::path::{Path, PathBuf};

use hullmap_bake::PointSet;

use crate::options::BuildOptions;
use crate::outcome::Failure;
use crate::pack_file::{folder_of, resolve_recorded, shown_from};
use crate::packs::PackPlace;
use hullmap_import::{self as import, EXTENSIONS, Imported, Limits, Polygons, ReadError, SourceFile};

/// A pack's source, found and imported as it was when the pack was baked.
#[derive(Debug)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// The point sets that the pack's hulls must be of, in the same order.
    pub point_sets: Vec<PointSet>,
    /// For each set the faces over it, by the numbers of its own points.
    pub faces: Vec<Polygons>,
    /// What the import notes, a sentence each.
    pub notes: Vec<String>,
    /// What the import warns of, a sentence each.
    pub warnings: Vec<String>,
}

/// What a pack says of its source.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// XXH3-128 of all bytes that it was baked from: see [`SourceFile::hash`].
    pub hash: u128,
    /// Its path relative to the pack's folder, or its name; empty where none was recorded.
    pub path: &'a str,
    /// The options that shaped the bake.
    pub options: &'a str,
}

impl<'a> Recorded<'a> {
    /// What `pack` says.
    pub fn of(pack: &'a hullmap::Pack) -> Self {
        Self { hash: pack.header().source_hash, path: pack.source_path(), options: pack.options() }
    }
}

/// Finds and imports the source of a pack.
///
/// `asked` is what `--source` says: the file, or a folder that holds it, mirrored or flat. Without it, the files beside
/// the pack with the pack's stem and the extension of a source are tried, then the recorded path. Of several files the
/// first with the recorded hash counts. `None` if nothing was asked for and no file is there.
///
/// # Errors
/// `--source` names nothing, or no file of the right name (usage); the files that are there have other bytes than the
/// pack was baked from, or do not import (wanting): the first one tells.
pub fn find_source(place: &PackPlace, recorded: Recorded, asked: Option<&Path>) -> Result<Option<Source>, Failure> {
    let candidates = match asked {
        Some(asked) if asked.is_dir() => in_folder(place, recorded.path, asked),
        Some(asked) => vec![asked.to_owned()],
        None => {
            let mut paths = with_stem(folder_of(&place.path), &place.path);
            paths.extend(resolve_recorded(recorded.path, folder_of(&place.path)));
            paths
        }
    };
    // A recorded path leads over the pack's folder.
    let shown = |path: &Path| {
        let path =
            if asked.is_none() && path.is_absolute() { shown_from(path, Path::new(".")) } else { path.to_owned() };
        path.display().to_string()
    };
    let mut wanting = None;
    for path in candidates {
        // What was baked once was within the limits of that time, whatever they were.
        let source = match import::read(&shown(&path), &path, &NO_LIMITS) {
            Ok(source) => source,
            Err(ReadError::Io(error)) if asked == Some(&path) => {
                return Err(Failure::usage(format!("{}: cannot read the source: {error}", path.display())));
            }
            Err(ReadError::Io(_)) => continue,
            // A file that is there, but with a buffer gone or damaged: in the words of `bake build`.
            Err(ReadError::Import(error)) => {
                wanting.get_or_insert(error.to_string());
                continue;
            }
        };
        if source.hash == recorded.hash {
            let Imported { point_sets, faces, notes, warnings, .. } = import(&path, &source, recorded.options)?;
            return Ok(Some(Source { path, point_sets, faces, notes, warnings }));
        }
        wanting.get_or_insert_with(|| {
            let (pack, path) = (place.path.display(), shown(&path));
            format!("{pack}: stale: {path} is not the file it was baked from, or has changed since; bake it again")
        });
    }
    match (wanting, asked) {
        (Some(message), _) => Err(Failure::wanting(message)),
        (None, Some(asked)) => Err(Failure::usage(format!(
            "{}: no source for it in {}; expected {}.{}",
            place.path.display(),
            asked.display(),
            place.path.file_stem().unwrap_or_default().display(),
            EXTENSIONS.join("|")
        ))),
        (None, None) => Ok(None),
    }
}

/// Where the source may lie in a folder: at the pack's place below it, or right in it; by the pack's stem or by the
/// recorded name.
fn in_folder(place: &PackPlace, recorded: &str, folder: &Path) -> Vec<PathBuf> {
    let recorded_name = recorded.rsplit('/').next().filter(|name| !name.is_empty() && *name != "..");
    let mut paths = Vec::new();
    for folder in [folder.join(&place.below), folder.to_owned()] {
        paths.extend(with_stem(&folder, &place.path));
        paths.extend(recorded_name.map(|name| folder.join(name)));
    }
    paths
}

/// The source files in `folder` with the stem of `pack`, whatever the case of their extension, sorted.
fn with_stem(folder: &Path, pack: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let is_candidate = |path: &PathBuf| path.file_stem() == pack.file_stem() && import::is_source(path);
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_candidate).collect();
    paths.sort_unstable();
    paths
}

/// Nothing is too large.
const NO_LIMITS: Limits = Limits { input_bytes: u64::MAX, objects: usize::MAX, repeated_vertices: usize::MAX };

fn import(path: &Path, source: &SourceFile, recorded: &str) -> Result<Imported, Failure> {
    let name = path.display().to_string();
    let options = BuildOptions::from_recorded(recorded).ok_or_else(|| {
        Failure::wanting(format!("{name}: its pack was baked with options unknown to this version; bake it again"))
    })?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let imported = import::import(&name, &stem, path, source, &options.import, &NO_LIMITS);
    let mut imported = imported.map_err(|error| Failure::wanting(error.to_string()))?;
    if options.decompose.is_some() {
        imported.give_triangles();
    }
    Ok(imported)
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

    /// A folder with these files, and the place of a pack `out/sub/x.hullmap` in it.
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
    fn sources_are_found_where_they_may_be() {
        for (file, path, asked) in [
            ("out/sub/x.obj", "", None),
            ("out/sub/x.OBJ", "gone.obj", None),
            ("meshes/other.obj", "../../meshes/other.obj", None),
            ("meshes/any.txt", "", Some("meshes/any.txt")),
            ("meshes/x.obj", "", Some("meshes")),
            ("meshes/sub/x.Obj", "", Some("meshes")),
            ("meshes/y.obj", "../elsewhere/y.obj", Some("meshes")),
        ] {
            let (folder, place) = folder(&[(file, CLOUD)]);
            let asked = asked.map(|asked| folder.path().join(asked));
            let source = find_source(&place, recorded(path), asked.as_deref()).unwrap();
            let source = source.unwrap_or_else(|| panic!("{file}"));
            assert_eq!(source.path.canonicalize().unwrap(), folder.path().join(file).canonicalize().unwrap());
            let names: Vec<_> = source.point_sets.iter().map(|set| set.name.as_str()).collect();
            assert_eq!(names, ["a", "b"], "imported with the pack's options");
        }
    }

    #[test]
    fn a_matching_file_wins_over_a_namesake() {
        let (folder, place) =
            folder(&[("m/x.obj", "v 0 0 0\n"), ("m/sub/x.obj", CLOUD), ("out/sub/x.obj", "v 0 0 0\n")]);
        let asked = folder.path().join("m");
        assert!(find_source(&place, recorded(""), Some(&asked)).unwrap().is_some());
        assert!(find_source(&place, recorded("../../m/sub/x.obj"), None).unwrap().is_some());
    }

    #[test]
    fn changed_sources_are_stale() {
        let (folder, place) = folder(&[("out/sub/x.obj", "v 0 0 0\n")]);
        let asked = folder.path().join("out/sub/x.obj");
        for asked in [None, Some(asked.as_path())] {
            let failure = find_source(&place, recorded(""), asked).unwrap_err();
            assert_eq!(failure.exit, Exit::Wanting);
            assert!(failure.message.contains("stale"), "{failure}");
        }
    }

    #[test]
    fn no_source_is_an_error_only_if_one_was_asked_for() {
        let (folder, place) = folder(&[("meshes/z.obj", CLOUD)]);
        assert!(find_source(&place, recorded("../gone.obj"), None).unwrap().is_none());
        for asked in ["meshes", "nowhere"] {
            let failure = find_source(&place, recorded(""), Some(&folder.path().join(asked))).unwrap_err();
            assert_eq!(failure.exit, Exit::Usage, "{asked}");
        }
    }
}
