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
    /// outside of `--out`.
    pub fn new(args: &RobotArgs, description: &Description) -> Result<Self, Failure> {
        let input = description.path();
        let fail = |path: &Path, error: &dyn std::fmt::Display| {
            Failure::usage(format!("{}: cannot determine this path: {error}; check the path", path.display()))
        };
        let source = folder_of(input).canonicalize().map_err(|error| fail(input, &error))?;
        let out = if is_file(args) { folder_of(&args.out).to_owned() } else { args.out.clone() };
        let out = canonical_of_gone(&out).ok_or_else(|| fail(&out, &"a folder above it cannot be read"))?;
        let out = std::path::absolute(&out).map(|out| plain(&out)).map_err(|error| fail(&out, &error))?;
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
        let mut beside = Path::new(name).file_stem().unwrap_or_default().to_owned();
        beside.push("_collision");
        let meshes = description.mesh_folder(&folder).unwrap_or_else(|| folder.join(beside));
        Ok(Self { file: folder.join(name), meshes: plain(&meshes), folder, source })
    }

    /// Whether files that the description names by relative paths are elsewhere.
    pub fn is_elsewhere(&self) -> bool {
        self.folder != self.source
    }
}

pub fn is_file(args: &RobotArgs) -> bool {
    let extension = args.out.extension().and_then(|extension| extension.to_str());
    !args.out.is_dir() && extension.is_some_and(|own| EXTENSIONS.iter().any(|known| own.eq_ignore_ascii_case(known)))
}
