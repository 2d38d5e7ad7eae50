//! The project of a pack: the folder outside of which its source is not read.
//!
//! A pack may come from an untrusted author, who chose the path that it records. So that path is
//! followed only to regular files below one folder. Otherwise a pack could make `bake verify` read
//! a device without end, wait for a pipe, or reveal which files exist.

use std::path::{Path, PathBuf};

use crate::config::FILE_NAME;
use crate::pack_file::{canonical_of_gone, folder_of, plain};
use crate::packs::PackPlace;

pub const ROOT_MARKS: [&str; 2] = [".git", ".hg"];

#[derive(Clone, Debug)]
pub struct Project {
    /// Canonical.
    root: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    File,
    Missing,
    /// A folder, pipe, socket or device.
    NotRegular,
    /// The path, or a link on it, leads out of the project. Whether a file is there is unknown.
    Outside,
}

impl Project {
    /// The widest of these folders above the pack:
    /// 1. `start`, where `bake` was started, unless it is the root of the file system;
    /// 2. the nearest folder with `.git`, `.hg` or a `hullmap.toml`;
    /// 3. the parent of the folder that was searched for packs, or of the pack's own folder, unless
    ///    it is the root. So packs in `baked` find their sources in `assets` beside it.
    ///
    /// `bake build` records the paths of sources inside it. The pack's folder may not exist yet;
    /// `None` if it cannot be resolved.
    pub fn of_pack(place: &PackPlace, start: &Path) -> Option<Self> {
        let folder = canonical_of_gone(folder_of(&place.path))?;
        let is_marked = |above: &&Path| ROOT_MARKS.iter().chain([&FILE_NAME]).any(|mark| above.join(mark).exists());
        let depth = place.below.components().count();
        let searched = folder.ancestors().nth(depth + 1).filter(|above| above.parent().is_some());
        let start = start.canonicalize().ok().filter(|start| folder.starts_with(start) && start.parent().is_some());
        let candidates = [start.as_deref(), folder.ancestors().find(is_marked), searched];
        // All of them lie on one path, so the shortest is the widest.
        let widest = candidates.into_iter().flatten().min_by_key(|folder| folder.components().count());
        Some(Self { root: widest.unwrap_or(&folder).to_owned() })
    }

    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Follows an absolute path. `..` is resolved before links are.
    pub fn find(&self, path: &Path) -> Found {
        let path = plain(path);
        if !path.starts_with(&self.root) {
            return Found::Outside;
        }
        for step in path.ancestors() {
            match step.canonicalize() {
                Ok(real) if !real.starts_with(&self.root) => return Found::Outside,
                Ok(real) if step == path => return if real.is_file() { Found::File } else { Found::NotRegular },
                Ok(_) => return Found::Missing,
                // A broken link may lead anywhere.
                Err(_) if step.is_symlink() => return Found::Outside,
                Err(_) => {}
            }
        }
        Found::Missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(pack: &Path, below: &str, start: &Path) -> PathBuf {
        let place = PackPlace { path: pack.to_owned(), below: below.into() };
        Project::of_pack(&place, start).unwrap().root
    }

    #[test]
    fn the_widest_folder_counts() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let packs = root.join("a/b/baked/deep");
        std::fs::create_dir_all(&packs).unwrap();
        let (pack, elsewhere) = (packs.join("x.hullmap"), Path::new("/"));
        let elsewhere = if packs.starts_with(elsewhere) { &root.join("other") } else { elsewhere };
        assert_eq!(project(&pack, "", elsewhere), root.join("a/b/baked"));
        assert_eq!(project(&pack, "", Path::new("/")), root.join("a/b/baked"), "not the whole file system");
        assert_eq!(project(&pack, "deep", elsewhere), root.join("a/b"), "beside the folder that was searched");
        assert_eq!(project(&pack, "deep", &packs), root.join("a/b"), "started inside");
        assert_eq!(project(&pack, "", &root.join("a")), root.join("a"), "started above");
        std::fs::write(root.join("a/b").join(FILE_NAME), "").unwrap();
        assert_eq!(project(&pack, "", elsewhere), root.join("a/b"));
        std::fs::create_dir(root.join("a/.git")).unwrap();
        std::fs::remove_file(root.join("a/b").join(FILE_NAME)).unwrap();
        assert_eq!(project(&pack, "", elsewhere), root.join("a"));
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_inside_are_found() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let outer = folder.path().canonicalize().unwrap();
        let root = outer.join("project");
        std::fs::create_dir_all(root.join("sub")).unwrap();
        for file in ["secret", "project/sub/x.obj"] {
            std::fs::write(outer.join(file), "").unwrap();
        }
        for (target, link) in [
            ("sub/x.obj", "inner"),
            ("../secret", "outer"),
            ("../nothing", "broken"),
            ("..", "up"),
            ("/dev/zero", "zero"),
            ("sub", "folder"),
        ] {
            symlink(target, root.join(link)).unwrap();
        }
        let project = Project { root: root.clone() };
        for (path, expected) in [
            ("sub/x.obj", Found::File),
            ("inner", Found::File),
            ("folder/x.obj", Found::File),
            ("sub/../inner", Found::File),
            ("gone", Found::Missing),
            ("gone/x.obj", Found::Missing),
            ("folder/gone", Found::Missing),
            ("sub", Found::NotRegular),
            ("outer", Found::Outside),
            ("broken", Found::Outside),
            ("up/secret", Found::Outside),
            ("up/nothing", Found::Outside),
            ("zero", Found::Outside),
            ("../secret", Found::Outside),
            ("../nothing", Found::Outside),
        ] {
            assert_eq!(project.find(&root.join(path)), expected, "{path}");
        }
    }
}
