//! Atomic writing of packs, and the recorded path from a pack to its source.
//!
//! A pack is written to a temporary file beside its target and synced; the file is renamed and its
//! folder synced. The temporary file stays locked while its process lives, so that [`sweep`]
//! removes only files of killed processes.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use ignore::WalkBuilder;
use tempfile::{Builder, NamedTempFile};

use crate::unfinished;

/// Attempts to create a temporary file, as a sweep may remove it before it is locked.
const MAX_ATTEMPTS: usize = 100;

/// End of a temporary file's name. The name starts with a dot and the stem of the target, followed
/// by [`PACK`] and six letters or digits: `.rock.hullmapAbCdEf.tmp`.
const SUFFIX: &str = ".tmp";

/// Maximum length of the stem in a temporary file's name, in bytes. File systems limit names to 255
/// bytes, some to 143, and the target's name may be as long as that.
const MAX_STEM: usize = 100;

const PACK: &str = ".hullmap";

/// A complete temporary file beside its target. Dropping it removes the file.
#[derive(Debug)]
pub struct Unplaced {
    file: Option<NamedTempFile>,
    path: PathBuf,
}

impl Unplaced {
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Unplaced {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            unfinished::settle(&self.path, || drop(file));
        }
    }
}

/// Writes and syncs. The file is removed unless [`put_in_place`] is called.
pub fn write_beside(target: &Path, bytes: &[u8]) -> io::Result<Unplaced> {
    let mut unplaced = make_locked(target)?;
    if let Some(file) = &mut unplaced.file {
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
    }
    Ok(unplaced)
}

fn make_locked(target: &Path) -> io::Result<Unplaced> {
    let name = target.file_name().unwrap_or(OsStr::new("pack")).to_string_lossy();
    let stem = name.strip_suffix(PACK).unwrap_or(&name);
    let end = (0..=stem.len().min(MAX_STEM)).rfind(|&end| stem.is_char_boundary(end)).unwrap_or_default();
    let prefix = format!(".{}{PACK}", &stem[..end]);
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // A pack has the permissions of the umask, not of temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    for _ in 0..MAX_ATTEMPTS {
        let file = unfinished::make(|| builder.tempfile_in(folder_of(target)), NamedTempFile::path)?;
        let unplaced = Unplaced { path: file.path().to_owned(), file: Some(file) };
        // On a file system without locks, a sweep cannot lock the file either, and leaves it alone.
        let is_locked = unplaced.file.as_ref().is_some_and(|file| lock(file.as_file()).is_ok());
        if !is_locked || unplaced.path.try_exists().unwrap_or(true) {
            return Ok(unplaced);
        }
    }
    Err(io::Error::other("another process keeps removing the temporary file"))
}

fn lock(file: &File) -> io::Result<()> {
    loop {
        match file.lock() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

/// Renames a temporary file to `target`. If that fails, it is removed; if only the folder could not
/// be synced, `target` is the new file, as the error states.
pub fn put_in_place(mut unplaced: Unplaced, target: &Path) -> io::Result<()> {
    if let Some(file) = unplaced.file.take() {
        unfinished::settle(&unplaced.path, || file.persist(target).map(drop)).map_err(|error| error.error)?;
    }
    sync_in_place(target)
}

/// Like [`put_in_place`], but never replaces a file.
pub fn put_in_free_place(mut unplaced: Unplaced, target: &Path) -> io::Result<()> {
    if let Some(file) = unplaced.file.take() {
        unfinished::settle(&unplaced.path, || file.persist_noclobber(target).map(drop)).map_err(|error| error.error)?;
    }
    sync_in_place(target)
}

fn sync_in_place(target: &Path) -> io::Result<()> {
    sync_folder(folder_of(target)).map_err(|error| {
        io::Error::new(error.kind(), format!("the file was written, but its folder could not be synced: {error}"))
    })
}

pub fn make_folder(folder: &Path) -> io::Result<()> {
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => return Ok(()),
        Err(error) if !matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Err(error);
        }
        // A file may be in the way. Creating the folder then fails with a clear error.
        _ => {}
    }
    let is_missing = |folder: &&Path| *folder != Path::new("") && matches!(folder.try_exists(), Ok(false));
    let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
    std::fs::create_dir_all(folder)?;
    missing.into_iter().try_for_each(|made| sync_folder(folder_of(made)))
}

fn sync_folder(folder: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Windows does not open folders, some file systems do not sync them, and some folders are
        // write-only.
        Err(error) if matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Ok(()),
        result => result,
    }
}

pub fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        sweep_file(&entry.path());
    }
}

/// Like [`sweep`], in `folder` and all folders below it. Links are not followed.
pub fn sweep_below(folder: &Path) {
    walk(folder).build().flatten().for_each(|entry| sweep_file(entry.path()));
}

/// A walk over everything in a folder, sorted by name. Links are not followed.
pub fn walk(folder: &Path) -> WalkBuilder {
    let mut walk = WalkBuilder::new(folder);
    walk.standard_filters(false).sort_by_file_name(OsStr::cmp);
    walk
}

fn sweep_file(path: &Path) {
    let is_file = || path.symlink_metadata().is_ok_and(|kind| kind.is_file());
    if path.file_name().is_some_and(is_temporary)
        && is_file()
        && let Ok(file) = OpenOptions::new().read(true).write(true).open(path)
        && file.try_lock().is_ok()
    {
        let _ = std::fs::remove_file(path);
    }
}

fn is_temporary(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let middle = name.strip_prefix('.').and_then(|name| name.strip_suffix(SUFFIX));
    let random = middle.and_then(|middle| middle.rsplit_once(PACK)).map(|(_, random)| random);
    random.is_some_and(|random| random.len() == 6 && random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// The first link among the folders below `root` on the way to `folder`. `root` itself may be one.
pub fn link_below(root: &Path, folder: &Path) -> Option<PathBuf> {
    let mut path = root.to_owned();
    folder.strip_prefix(root).ok()?.components().find_map(|part| {
        path.push(part);
        path.is_symlink().then(|| path.clone())
    })
}

pub fn through_link(file: &Path, link: &Path) -> String {
    format!(
        "{}: not written, because {} is a link; replace it by a folder, or name the folder it leads to with --out",
        file.display(),
        link.display()
    )
}

pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The path of `source` that a pack in `pack_folder`, which may not exist yet, records: relative to
/// that folder, with `/`, if both lie in the folder `project`; otherwise the bare file name.
///
/// So the bytes depend on the project alone, not on the rest of the machine. Fails if a canonical
/// path cannot be determined: the file name would be a different record.
pub fn recorded_path(source: &Path, pack_folder: &Path, project: &Path) -> io::Result<String> {
    let name = || source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (source, project) = (source.canonicalize()?, project.canonicalize()?);
    let folder = canonical_of_gone(pack_folder).map_or_else(|| pack_folder.canonicalize(), Ok)?;
    if source.starts_with(&project) && folder.starts_with(&project) {
        Ok(relative(&source, &folder).unwrap_or_else(name))
    } else {
        Ok(name())
    }
}

/// Canonical path, also of a folder that, like its parents, does not exist.
pub fn canonical_of_gone(folder: &Path) -> Option<PathBuf> {
    for above in folder.ancestors() {
        let place = if above == Path::new("") { Path::new(".") } else { above };
        match place.canonicalize() {
            Ok(canonical) => return Some(plain(&canonical.join(folder.strip_prefix(above).ok()?))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(_) => return None,
        }
    }
    None
}

/// The relative path from one absolute path to another, without access to the file system.
fn relative(target: &Path, from: &Path) -> Option<String> {
    let target: Vec<Component> = target.components().collect();
    let from: Vec<Component> = from.components().collect();
    let shared = target.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let is_step = |component: &Component| matches!(component, Component::Normal(_));
    // Paths on different drives have no common prefix.
    if shared == 0 || !target[shared..].iter().chain(&from[shared..]).all(is_step) {
        return None;
    }
    let mut steps = vec![".."; from.len() - shared];
    for component in &target[shared..] {
        steps.push(component.as_os_str().to_str()?);
    }
    Some(steps.join("/"))
}

/// Whether a pack in this folder may record `source` so: by its name, or by a path that leads to
/// it. Which of them a build records may depend on the folder where it was started.
pub fn records_source(recorded: &str, source: &Path, pack_folder: &Path) -> bool {
    let leads_to =
        |path: PathBuf| path.canonicalize().is_ok_and(|path| source.canonicalize().is_ok_and(|source| source == path));
    source.file_name().is_some_and(|name| name == recorded)
        || resolve_recorded(recorded, pack_folder).is_some_and(leads_to)
}

/// Resolves a recorded path from a pack's folder; `None` if the path is empty or not relative.
pub fn resolve_recorded(recorded: &str, pack_folder: &Path) -> Option<PathBuf> {
    let path = Path::new(recorded);
    if recorded.is_empty() || path.is_absolute() || path.has_root() {
        return None;
    }
    // Canonical first, because `..` from a symbolic link leads elsewhere.
    Some(pack_folder.canonicalize().ok()?.join(path))
}

/// An absolute path without `.` and `..`, without access to the file system.
pub fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

/// Path as seen from the folder `here`: relative if both share a folder, otherwise absolute.
pub fn shown_from(path: &Path, here: &Path) -> PathBuf {
    let path = plain(path);
    let way = here.canonicalize().ok().and_then(|here| relative(&path, &here));
    way.map_or(path, PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn relative_paths() {
        let way = |target: &str, from: &str| relative(Path::new(target), Path::new(from));
        assert_eq!(way("/a/b/x.obj", "/a/b").as_deref(), Some("x.obj"));
        assert_eq!(way("/a/b/x.obj", "/a/c/d").as_deref(), Some("../../b/x.obj"));
        assert_eq!(way("/x.obj", "/").as_deref(), Some("x.obj"));
        assert_eq!(way("x.obj", "/a"), None);
        assert_eq!(plain(Path::new("/a/./b/../../c/x.obj")), Path::new("/c/x.obj"));
    }

    #[test]
    fn recorded_paths_lead_back() {
        let root = tempfile::tempdir().unwrap();
        let (meshes, packs) = (root.path().join("meshes"), root.path().join("out/sub"));
        std::fs::create_dir_all(&meshes).unwrap();
        std::fs::create_dir_all(&packs).unwrap();
        let source = meshes.join("x.obj");
        std::fs::write(&source, "").unwrap();
        let recorded = |source: &Path, project: &Path| recorded_path(source, &packs, project).unwrap();
        let outside = recorded(&source, &meshes);
        assert_eq!(outside, "x.obj", "packs outside the project");
        assert_eq!(recorded(&source, &root.path().join("out")), "x.obj", "meshes outside the project");
        assert!(recorded_path(&meshes.join("gone.obj"), &packs, root.path()).is_err());
        let recorded = recorded(&source, root.path());
        assert_eq!(recorded, "../../meshes/x.obj");
        let found = resolve_recorded(&recorded, &packs).unwrap();
        assert_eq!(found.canonicalize().unwrap(), source.canonicalize().unwrap());
        assert_eq!(resolve_recorded("", &packs), None);
        assert_eq!(resolve_recorded("/etc/passwd", &packs), None);
    }

    #[test]
    fn packs_are_replaced_atomically() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.hullmap");
        let names =
            || -> Vec<_> { std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect() };
        put_in_place(write_beside(&target, b"one").unwrap(), &target).unwrap();
        drop(write_beside(&target, b"dropped").unwrap());
        assert_eq!(std::fs::read(&target).unwrap(), b"one");
        put_in_place(write_beside(&target, b"two").unwrap(), &target).unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"two");
        assert_eq!(names(), ["x.hullmap"]);
        assert!(write_beside(&folder.path().join("no/x.hullmap"), b"").is_err());
    }

    /// The temporary name was longer than the pack's, and too long for the file system.
    #[test]
    fn names_may_be_as_long_as_the_file_system_allows() {
        let folder = tempfile::tempdir().unwrap();
        for stem in ["x".repeat(247), "é".repeat(123), "x".to_owned() + &"é".repeat(123)] {
            let target = folder.path().join(format!("{stem}.hullmap"));
            let file = write_beside(&target, b"long").unwrap();
            assert!(is_temporary(file.path().file_name().unwrap()), "{}", file.path().display());
            put_in_place(file, &target).unwrap();
            assert_eq!(std::fs::read(&target).unwrap(), b"long");
        }
    }

    #[test]
    fn sweep_removes_files_of_dead_processes_only() {
        let folder = tempfile::tempdir().unwrap();
        let living = write_beside(&folder.path().join("x.hullmap"), b"living").unwrap();
        let dead = living.path().file_name().unwrap().to_str().unwrap().replace("x.hullmap", "dead.hullmap");
        let others = [".x.hullmap.tmp", ".notes.tmp", "x.hullmapAbCdEf.tmp", ".x.hullmapAbC-Ef.tmp", "x.hullmap"];
        for name in others.iter().chain([&dead.as_str()]) {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        sweep(folder.path());
        assert!(!folder.path().join(&dead).exists(), "{dead}");
        assert!(living.path().exists());
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
        put_in_place(living, &folder.path().join("x.hullmap")).unwrap();
        assert_eq!(std::fs::read(folder.path().join("x.hullmap")).unwrap(), b"living");
        sweep(&folder.path().join("no such folder"));
    }

    /// A sweep between creating and locking removes the file; the writer creates another.
    #[test]
    fn concurrent_writers_and_sweepers_are_safe() {
        let folder = tempfile::tempdir().unwrap();
        let is_done = std::sync::atomic::AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                    sweep(folder.path());
                }
            });
            for number in 0..60_u32 {
                let target = folder.path().join(format!("{}.hullmap", number % 3));
                put_in_place(write_beside(&target, &number.to_le_bytes()).unwrap(), &target).unwrap();
            }
            is_done.store(true, std::sync::atomic::Ordering::Relaxed);
        });
        let mut left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["0.hullmap", "1.hullmap", "2.hullmap"]);
        assert_eq!(std::fs::read(folder.path().join("2.hullmap")).unwrap(), 59_u32.to_le_bytes());
    }
}
