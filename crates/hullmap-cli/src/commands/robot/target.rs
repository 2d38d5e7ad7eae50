//! Where a description is written, and its hulls.

use std::path::{Component, Path, PathBuf};

use hullmap_robot::Description;

use crate::args::RobotArgs;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::pack_file::{canonical_of_gone, folder_of, plain};

/// Extensions of descriptions: an `--out` with one of these is a file.
const EXTENSIONS: [&str; 6] = ["urdf", "xml", "mjcf", "sdf", "world", "xacro"];

#[derive(Debug)]
pub struct Target {
    /// The description, absolute.
    pub file: PathBuf,
    pub folder: PathBuf,
    pub meshes: PathBuf,
    pub source: PathBuf,
}

impl Target {
    /// Links in the description's folder are resolved, so that relative paths hold.
    ///
    /// In another folder than the input's, files that it names by relative paths are copied. If
    /// such a path climbs, the folders above the description are kept, so that nothing is written
    /// outside of `--out`. Descriptions of one name keep their folders. A description that another
    /// one of the run attaches has its place there.
    pub fn new(args: &RobotArgs, description: &Description, all: &[&Description]) -> Result<Self, Failure> {
        let is_named = |own: &Description| all.iter().any(|other| place_in(other, own).is_some());
        let namer =
            all.iter().filter(|other| !is_named(other)).find_map(|other| Some((other, place_in(other, description)?)));
        let Some((namer, place)) = namer else { return Self::alone(args, description, all) };
        let input = folder_of(description.path());
        let source = input.canonicalize().map_err(|error| undetermined(input, &error))?;
        Ok(Self::of(description, plain(&Self::alone(args, namer, all)?.folder.join(place)), source))
    }

    fn alone(args: &RobotArgs, description: &Description, all: &[&Description]) -> Result<Self, Failure> {
        let input = description.path();
        let source = folder_of(input).canonicalize().map_err(|error| undetermined(input, &error))?;
        let out = if is_file(args) { folder_of(&args.out).to_owned() } else { args.out.clone() };
        let out = canonical_of_gone(&out).ok_or_else(|| undetermined(&out, &"a folder above it cannot be read"))?;
        let out = std::path::absolute(&out).map(|out| plain(&out)).map_err(|error| undetermined(&out, &error))?;
        let out = out.join(below_common(&source, input, all));
        let name = if is_file(args) { args.out.file_name() } else { input.file_name() }.unwrap_or_default();
        let climbs = |path: &Path| path.components().take_while(|part| *part == Component::ParentDir).count();
        let up = description.references.iter().map(|reference| climbs(&reference.path)).max().unwrap_or_default();
        let mut folder = out.clone();
        if out != source && up > 0 {
            if is_file(args) {
                let climbing = description.references.iter().find(|reference| climbs(&reference.path) > 0);
                let climbing = climbing.map_or_else(PathBuf::new, |reference| reference.path.clone());
                return Err(Failure::usage(format!(
                    "{}: names {}, which would lie outside of {}; write it to the folder of the input, or name a folder with --out",
                    input.display(),
                    climbing.display(),
                    out.display()
                )));
            }
            let kept: Vec<Component> = source.components().rev().take(up).collect();
            folder.extend(kept.into_iter().rev());
        }
        Ok(Self::of(description, folder.join(name), source))
    }

    fn of(description: &Description, file: PathBuf, source: PathBuf) -> Self {
        let folder = folder_of(&file).to_owned();
        let mut beside = file.file_stem().unwrap_or_default().to_owned();
        beside.push("_collision");
        let meshes = description.mesh_folder(&folder).unwrap_or_else(|| folder.join(beside));
        Self { file, meshes: plain(&meshes), folder, source }
    }

    /// Whether files that the description names by relative paths are elsewhere.
    pub fn is_elsewhere(&self) -> bool {
        self.folder != self.source
    }
}

/// The path to `source`, the folder of `input`, from the common folder of all inputs of that name.
fn below_common(source: &Path, input: &Path, all: &[&Description]) -> PathBuf {
    let same = all.iter().map(|own| own.path()).filter(|own| own.file_name() == input.file_name());
    let folders = same.filter_map(|own| folder_of(own).canonicalize().ok());
    let common = folders.fold(source.to_owned(), |common, folder| {
        common.ancestors().find(|above| folder.starts_with(above)).map(Path::to_owned).unwrap_or_default()
    });
    source.strip_prefix(&common).unwrap_or(Path::new("")).to_owned()
}

/// The path from a description's folder to another description, if it names that one: by a relative
/// path, or by the name of its model, whose folder Gazebo looks for in the folder of the output.
fn place_in(namer: &Description, other: &Description) -> Option<PathBuf> {
    let is_other = |file: &Path| is_same_file(file, other.path()) && !is_same_file(file, namer.path());
    if let Some(reference) = namer.references.iter().find(|own| is_other(&own.file)) {
        return Some(reference.path.clone());
    }
    let other = other.path().canonicalize().ok()?;
    namer.others.iter().find_map(|own| {
        let model = own.path.as_ref()?;
        let below = other.strip_prefix(model).ok().filter(|below| *below != Path::new(""))?;
        Some(Path::new(model.file_name()?).join(below))
    })
}

fn undetermined(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::usage(format!("{}: cannot determine this path: {error}; check the path", path.display()))
}

pub fn is_same_file(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

pub fn is_file(args: &RobotArgs) -> bool {
    let extension = args.out.extension().and_then(|extension| extension.to_str());
    !args.out.is_dir() && extension.is_some_and(|own| EXTENSIONS.iter().any(|known| own.eq_ignore_ascii_case(known)))
}
