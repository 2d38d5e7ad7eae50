//! Writing a pack so that nobody ever sees half of one, and the way back from it to its source.
//!
//! A pack is written to a temporary file beside its place, synced, renamed, and its folder is synced. The temporary file is
//! locked while its process lives: [`sweep`] removes those that a killed process left, and no others.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use tempfile::{Builder, NamedTempFile};
use walkdir::WalkDir;

use crate::interrupt;

/// How often a temporary file is made anew after a sweep took it in the moment before it was locked.
const MOST_ATTEMPTS: usize = 100;

/// End of a temporary file's name; it starts with a point and the name of what it becomes. In between is [`PACK`], whatever it
/// becomes, and six letters or digits.
const SUFFIX: &str = ".tmp";

/// What a pack's name ends in.
const PACK: &str = ".hullmap";

/// A whole file on the disk beside its place. Dropped, it vanishes.
#[derive(Debug)]
pub struct Unplaced {
    /// `None` once it is in place.
    file: Option<NamedTempFile>,
    path: PathBuf,
}

impl Unplaced {
    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Unplaced {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            interrupt::settle(&self.path, || drop(file));
        }
    }
}

/// Writes `bytes` to a temporary file beside `target`, down to the disk. It vanishes unless [`put_in_place`] is called.
///
/// # Errors
/// The folder cannot be written to.
pub fn write_beside(target: &Path, bytes: &[u8]) -> io::Result<Unplaced> {
    let mut unplaced = make_locked(target)?;
    if let Some(file) = &mut unplaced.file {
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
    }
    Ok(unplaced)
}

/// A temporary file that no sweep takes.
fn make_locked(target: &Path) -> io::Result<Unplaced> {
    let name = target.file_name().unwrap_or(OsStr::new("pack"));
    let mut prefix = OsStr::new(".").to_owned();
    prefix.push(name);
    if !name.to_string_lossy().ends_with(PACK) {
        prefix.push(PACK);
    }
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // Temporary files are private by default; a pack is a file like any other, and the umask decides.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    for _ in 0..MOST_ATTEMPTS {
        let file = interrupt::make(|| builder.tempfile_in(folder_of(target)), NamedTempFile::path)?;
        let unplaced = Unplaced { path: file.path().to_owned(), file: Some(file) };
        // A file system without locks has no sweep either: it cannot lock what it finds.
        let is_locked = unplaced.file.as_ref().is_some_and(|file| lock(file.as_file()).is_ok());
        if !is_locked || unplaced.path.try_exists().unwrap_or(true) {
            return Ok(unplaced);
        }
    }
    Err(io::Error::other("another process keeps removing the temporary file"))
}

/// Waits for the lock; a signal meanwhile does not matter.
fn lock(file: &File) -> io::Result<()> {
    loop {
        match file.lock() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

/// Renames a temporary file to `target`, over what was there.
///
/// # Errors
/// The rename failed, and the temporary file is gone and `target` is as it was; or it did not reach the disk, which the error
/// says: then `target` is the new file.
pub fn put_in_place(mut unplaced: Unplaced, target: &Path) -> io::Result<()> {
    if let Some(file) = unplaced.file.take() {
        interrupt::settle(&unplaced.path, || file.persist(target).map(drop)).map_err(|error| error.error)?;
    }
    sync_in_place(target)
}

/// As [`put_in_place`], where nothing is there yet.
///
/// # Errors
/// As there; and something is there already, which is left as it was.
pub fn put_in_free_place(mut unplaced: Unplaced, target: &Path) -> io::Result<()> {
    if let Some(file) = unplaced.file.take() {
        interrupt::settle(&unplaced.path, || file.persist_noclobber(target).map(drop)).map_err(|error| error.error)?;
    }
    sync_in_place(target)
}

fn sync_in_place(target: &Path) -> io::Result<()> {
    sync_folder(folder_of(target)).map_err(|error| {
        io::Error::new(error.kind(), format!("it is in place, but a power cut might undo that: {error}"))
    })
}

/// Makes a folder and those above it, down to the disk.
///
/// # Errors
/// It is not there and cannot be made, or does not reach the disk.
pub fn make_folder(folder: &Path) -> io::Result<()> {
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => return Ok(()),
        Err(error) if !matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Err(error);
        }
        // Something else is in its place, which the attempt to make it tells best.
        _ => {}
    }
    let is_missing = |folder: &&Path| *folder != Path::new("") && matches!(folder.try_exists(), Ok(false));
    let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
    std::fs::create_dir_all(folder)?;
    missing.into_iter().try_for_each(|made| sync_folder(folder_of(made)))
}

/// Brings a folder's entries down to the disk. Not every system has a way to: where there is none, that is no error.
fn sync_folder(folder: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Windows opens no folders, some file systems sync none; and one may be written to that must not be read.
        Err(error) if matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Ok(()),
        result => result,
    }
}

/// Removes the temporary files that processes which live no more left in `folder`.
pub fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        sweep_file(&entry.path());
    }
}

/// [`sweep`] in `folder` and all folders below it. Links are not followed.
pub fn sweep_below(folder: &Path) {
    WalkDir::new(folder).into_iter().flatten().for_each(|entry| sweep_file(entry.path()));
}

/// Removes a file if it is temporary and its process lives no more.
fn sweep_file(path: &Path) {
    if path.file_name().is_some_and(is_temporary)
        && let Ok(file) = OpenOptions::new().read(true).write(true).open(path)
        && file.try_lock().is_ok()
    {
        let _ = std::fs::remove_file(path);
    }
}

/// Whether a file of this name can only be one of ours: `.rock.hullmapAbCdEf.tmp`.
fn is_temporary(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let middle = name.strip_prefix('.').and_then(|name| name.strip_suffix(SUFFIX));
    let random = middle.and_then(|middle| middle.rsplit_once(PACK)).map(|(_, random)| random);
    random.is_some_and(|random| random.len() == 6 && random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// The folder a file is in.
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The path that a pack in folder `pack_folder` records for `source`: relative to that folder, with `/`, where both lie
/// in `project`, the folder that `bake` was started in; else the file's name alone.
///
/// So what is recorded, and with it every byte of the pack, depends on how the project is laid out, and on nothing of
/// the machine around it.
///
/// # Errors
/// Where one of the three lies cannot be found out: a name alone would be another record.
pub fn recorded_path(source: &Path, pack_folder: &Path, project: &Path) -> io::Result<String> {
    let name = || source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (source, folder, project) = (source.canonicalize()?, pack_folder.canonicalize()?, project.canonicalize()?);
    if source.starts_with(&project) && folder.starts_with(&project) {
        Ok(relative(&source, &folder).unwrap_or_else(name))
    } else {
        Ok(name())
    }
}

/// The way from one absolute path to another, without asking the file system.
fn relative(target: &Path, from: &Path) -> Option<String> {
    let target: Vec<Component> = target.components().collect();
    let from: Vec<Component> = from.components().collect();
    let shared = target.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let is_step = |component: &Component| matches!(component, Component::Normal(_));
    // Different drives share nothing.
    if shared == 0 || !target[shared..].iter().chain(&from[shared..]).all(is_step) {
        return None;
    }
    let mut steps = vec![".."; from.len() - shared];
    for component in &target[shared..] {
        steps.push(component.as_os_str().to_str()?);
    }
    Some(steps.join("/"))
}

/// Where a recorded path leads from a pack's folder; `None` for one that is empty or not relative.
pub fn resolve_recorded(recorded: &str, pack_folder: &Path) -> Option<PathBuf> {
    let path = Path::new(recorded);
    if recorded.is_empty() || path.is_absolute() || path.has_root() {
        return None;
    }
    // Canonical first: `..` from a linked folder would otherwise lead elsewhere.
    Some(pack_folder.canonicalize().ok()?.join(path))
}

/// An absolute path without `.` and `..`, by its text alone.
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

/// An absolute path as the user would name it from the folder `here`: relative where both share a folder, else as it is.
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
    fn packs_are_replaced_whole_or_not_at_all() {
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

    #[test]
    fn a_sweep_takes_what_the_dead_left_and_nothing_else() {
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

    /// A sweep between making and locking takes the file; its maker makes another.
    #[test]
    fn writers_and_sweepers_do_not_disturb_each_other() {
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
