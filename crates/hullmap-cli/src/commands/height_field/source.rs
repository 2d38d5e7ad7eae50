//! Finds the source of a height field.

use std::path::{Path, PathBuf};

use hullmap::HeightField;

use crate::outcome::Failure;
use crate::pack_file::{folder_of, plain, resolve_recorded};
use crate::packs::PackPlace;
use crate::project::{Found, Project};

/// The source of a height field: the path that `--source` gives, or the recorded one, which is
/// followed only inside the file's [`Project`]. The error is the reason why there is none.
pub fn find(path: &Path, field: &HeightField, given: Option<&Path>) -> Result<Result<PathBuf, String>, Failure> {
    let recorded = Path::new(field.source_path());
    if let Some(given) = given {
        let file = if given.is_dir() { given.join(recorded.file_name().unwrap_or_default()) } else { given.to_owned() };
        if !file.is_file() {
            return Err(Failure::usage(format!("{}: no such file; name the source with --source", file.display())));
        }
        return Ok(Ok(file));
    }
    let Some(found) = resolve_recorded(field.source_path(), folder_of(path)).map(|found| plain(&found)) else {
        return Ok(Err("no source is recorded".to_owned()));
    };
    let place = PackPlace { path: path.to_owned(), below: PathBuf::new() };
    let shown = recorded.display();
    Ok(match Project::of_pack(&place, Path::new(".")).map(|project| project.find(&found)) {
        Some(Found::File) => Ok(found),
        Some(Found::Missing) | None => Err(format!("no source found at the recorded path `{shown}`")),
        Some(Found::NotRegular) => {
            Err(format!("the recorded path `{shown}` is not a regular file, so it was not read"))
        }
        Some(Found::Outside) => {
            Err(format!("the recorded path `{shown}` leads out of the file's project, so it was not followed"))
        }
    })
}
