//! The packs that arguments name: files, and all in folders. Triangle meshes and height fields
//! count as packs.

use std::path::{Path, PathBuf};

use hullmap_format::header::FileKind;

use crate::outcome::Failure;
use crate::pack_file::walk;

#[derive(Clone, Debug)]
pub struct PackPlace {
    pub path: PathBuf,
    /// Its folder relative to the one that was searched; empty for a pack that was named directly.
    pub below: PathBuf,
}

/// Packs by input, sorted by name within each folder. Fails if a folder has none.
pub fn find_packs(inputs: &[PathBuf]) -> Result<Vec<PackPlace>, Failure> {
    let mut places = Vec::new();
    for input in inputs {
        let kind = std::fs::metadata(input)
            .map_err(|error| Failure::usage(format!("{}: cannot read: {error}; check the path", input.display())))?;
        if !kind.is_dir() {
            places.push(PackPlace { path: input.clone(), below: PathBuf::new() });
            continue;
        }
        let before = places.len();
        for entry in walk(input).build() {
            let entry = entry.map_err(|error| {
                Failure::usage(format!("{}: cannot search: {error}; check its permissions", input.display()))
            })?;
            let path = entry.path();
            // A pipe would block. A broken link is an error when it is opened.
            if is_baked(path) && std::fs::metadata(path).map_or(true, |kind| kind.is_file()) {
                let below = path.strip_prefix(input).ok().and_then(|path| path.parent());
                places.push(PackPlace { path: path.to_owned(), below: below.unwrap_or(input).to_owned() });
            }
        }
        if places.len() == before {
            return Err(Failure::usage(format!(
                "{}: no .hullmap, .hullmesh or .hullfield files in this folder; name a folder of packs",
                input.display()
            )));
        }
    }
    Ok(places)
}

pub fn is_baked(path: &Path) -> bool {
    kind_by_name(path).is_some()
}

pub fn kind_by_name(path: &Path) -> Option<FileKind> {
    let extension = path.extension()?;
    FileKind::ALL.into_iter().find(|kind| extension == kind.extension())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Exit;

    #[test]
    fn packs_are_found_with_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let sub = folder.path().join("a/b");
        std::fs::create_dir_all(&sub).unwrap();
        for path in [sub.join("x.hullmap"), folder.path().join("y.hullmap"), sub.join("z.obj")] {
            std::fs::write(path, "").unwrap();
        }
        let places = find_packs(&[folder.path().to_owned(), sub.join("x.hullmap")]).unwrap();
        let below: Vec<_> = places.iter().map(|place| place.below.to_str().unwrap().replace('\\', "/")).collect();
        assert_eq!(below, ["a/b", "", ""]);
        assert!(places[1].path.ends_with("y.hullmap"));
        let empty = tempfile::tempdir().unwrap();
        assert_eq!(find_packs(&[empty.path().to_owned()]).unwrap_err().exit, Exit::Usage);
        assert_eq!(find_packs(&[empty.path().join("no.hullmap")]).unwrap_err().exit, Exit::Usage);
    }
}
