use std::path::{Path, PathBuf};

use hullmap::HeightField;

use crate::outcome::Failure;
use crate::pack_file::{folder_of, plain, resolve_recorded};
use crate::packs::PackPlace;
use crate::project::{Found, Project};

/// The source at the path of `--source`, or the recorded path inside the file's [`Project`];
/// otherwise, the reason why there is none. `image` names the image of holes beside the source.
pub fn find(
    path: &Path,
    field: &HeightField,
    given: Option<&Path>,
    image: Option<&str>,
) -> Result<Result<PathBuf, String>, Failure> {
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
    let Some(project) = Project::of_pack(&place, Path::new(".")) else {
        return Ok(Err("its folder cannot be resolved".to_owned()));
    };
    let beside = image.map(|name| (found.with_file_name(name), name));
    let named = [(found.clone(), field.source_path())].into_iter().chain(beside);
    let reason = named.into_iter().find_map(|(file, name)| {
        Some(match project.find(&file) {
            Found::File => return None,
            Found::Missing => format!("no source found at the recorded path `{name}`"),
            Found::NotRegular => format!("the recorded path `{name}` is not a regular file, so it was not read"),
            Found::Outside => {
                format!("the recorded path `{name}` leads out of the file's project, so it was not followed")
            }
        })
    });
    Ok(reason.map_or(Ok(found), Err))
}
