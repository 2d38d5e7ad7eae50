//! Names of packs: `x.hullmap` for `x.obj`, or `x.obj.hullmap` beside `x.stl`. The names of
//! triangle meshes differ in their extension alone.
//!
//! A mesh keeps its extension if another mesh of the build would otherwise have the same pack, or
//! one whose name differs in case alone, which is the same file on some systems.

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use hullmap_format::header::FileKind;

use super::search::Mesh;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PackName {
    pub output: PathBuf,
    /// Why its name has the extension of the mesh, if that was not requested.
    pub note: Option<String>,
    /// Another pack is the same file on systems that ignore case.
    pub warning: Option<String>,
    /// Another mesh has the same pack, so neither is baked.
    pub clash: Option<String>,
}

#[derive(Clone, Copy, Debug)]
pub struct Unnamed<'a> {
    pub mesh: &'a Mesh,
    /// Whether the name keeps the extension of the mesh; `None` if the other names decide.
    pub keeps_extension: Option<bool>,
    pub kind: FileKind,
}

/// The packs of all meshes of a build. Complexity: O(meshes), apart from meshes of the same stem.
pub fn pack_names(meshes: &[Unnamed]) -> Vec<PackName> {
    // The meshes with a stem, or with a name, in a folder of packs; case is ignored.
    let mut by_stem: HashMap<(&Path, String), Vec<usize>> = HashMap::new();
    let mut by_name: HashMap<(&Path, String), Vec<usize>> = HashMap::new();
    let full = |mesh: &Mesh| lower(mesh.source.file_name().map(Path::new));
    let stem = |mesh: &Mesh| lower(mesh.source.file_stem().map(Path::new));
    for (index, Unnamed { mesh, .. }) in meshes.iter().enumerate() {
        by_stem.entry((&mesh.folder, stem(mesh))).or_default().push(index);
        by_name.entry((&mesh.folder, full(mesh))).or_default().push(index);
    }
    let rival = |index: usize| {
        let mesh = meshes[index].mesh;
        let key = (mesh.folder.as_path(), stem(mesh));
        let others = [by_stem.get(&key), by_name.get(&key)].into_iter().flatten().flatten();
        // The extension cannot distinguish meshes whose whole names are equal.
        others.copied().find(|&other| full(meshes[other].mesh) != full(mesh))
    };
    let name = |(index, unnamed): (usize, &Unnamed)| {
        let Unnamed { mesh, keeps_extension, kind } = *unnamed;
        let rival = if keeps_extension.is_none() { rival(index) } else { None };
        let output = mesh.folder.join(file_name(&mesh.source, keeps_extension.unwrap_or(rival.is_some()), kind));
        let note = rival.map(|rival| {
            let rival = meshes[rival].mesh.source.display();
            format!("its pack {} keeps the extension, to differ from the pack of {rival}", output.display())
        });
        PackName { output, note, ..PackName::default() }
    };
    let mut names: Vec<PackName> = meshes.iter().enumerate().map(name).collect();
    let mut by_output: HashMap<String, Vec<usize>> = HashMap::new();
    for (index, name) in names.iter().enumerate() {
        by_output.entry(lower(Some(&name.output))).or_default().push(index);
    }
    for same in by_output.into_values().filter(|same| same.len() > 1) {
        for &index in &same {
            let other = |is_equal: bool| {
                let is_same = |&other: &usize| (names[other].output == names[index].output) == is_equal;
                same.iter().copied().filter(|&other| other != index).find(is_same)
            };
            let (source, output) = (meshes[index].mesh.source.display(), names[index].output.display());
            let clash = other(true).map(|other| {
                let [first, second] = [index.min(other), index.max(other)].map(|index| &meshes[index].mesh.source);
                let or_full =
                    if first.file_name() == second.file_name() { "" } else { ", or use --set pack_names=full" };
                let (first, second) = (first.display(), second.display());
                format!(
                    "{first} and {second} would both become {output}; rename one, or bake them into separate \
                     folders{or_full}"
                )
            });
            let warning = other(false).map(|other| {
                let (other, theirs) = (meshes[other].mesh.source.display(), names[other].output.display());
                format!("{output} and {theirs} are one file on systems that ignore case; rename {source} or {other}")
            });
            (names[index].clash, names[index].warning) = (clash, warning);
        }
    }
    names
}

pub fn is_name_of(pack: &Path, source: &Path) -> bool {
    let is_name = |keeps: bool, kind: FileKind| pack.file_name() == Some(&file_name(source, keeps, kind));
    FileKind::ALL.iter().any(|kind| is_name(true, *kind) || is_name(false, *kind))
}

/// The stem keeps its inner dots.
fn file_name(source: &Path, keeps_extension: bool, kind: FileKind) -> OsString {
    let name = if keeps_extension { source.file_name() } else { source.file_stem() };
    let mut name = name.unwrap_or_default().to_owned();
    name.push(".");
    name.push(kind.extension());
    name
}

fn lower(path: Option<&Path>) -> String {
    path.map_or_else(String::new, |path| path.to_string_lossy().to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(meshes: &[&str], keeps_extension: Option<bool>) -> Vec<String> {
        names_of(meshes, keeps_extension, |_| FileKind::Pack)
    }

    fn names_of(meshes: &[&str], keeps_extension: Option<bool>, kind: impl Fn(&Path) -> FileKind) -> Vec<String> {
        let meshes: Vec<Mesh> = meshes
            .iter()
            .map(|mesh| Mesh { source: mesh.into(), folder: Path::new("o").join(Path::new(mesh).parent().unwrap()) })
            .collect();
        let unnamed = |mesh| Unnamed { mesh, keeps_extension, kind: kind(&mesh.source) };
        let choices: Vec<_> = meshes.iter().map(unnamed).collect();
        let shown = |name: PackName| {
            let mark = if name.clash.is_some() {
                "!"
            } else if name.warning.is_some() {
                "?"
            } else {
                ""
            };
            format!("{}{mark}", name.output.to_str().unwrap().replace('\\', "/"))
        };
        pack_names(&choices).into_iter().map(shown).collect()
    }

    #[test]
    fn triangle_meshes_have_an_extension_of_their_own() {
        let kind = |source: &Path| if source.ends_with("level.obj") { FileKind::TriangleMesh } else { FileKind::Pack };
        assert_eq!(names_of(&["level.obj", "y.obj"], None, kind), ["o/level.hullmesh", "o/y.hullmap"]);
        // The stem alone does not distinguish their sources.
        let both = ["o/level.obj.hullmesh", "o/level.stl.hullmap"];
        assert_eq!(names_of(&["level.obj", "level.stl"], None, kind), both);
        assert_eq!(names_of(&["level.obj", "level.stl"], Some(false), kind), ["o/level.hullmesh", "o/level.hullmap"]);
    }

    #[test]
    fn automatic_names_never_clash_and_do_not_depend_on_the_order() {
        let all = ["a.obj", "A.stl", "a.obj.ply", "a.obj.ply.glb", "b.stl", "b.obj.stl", "b", "a.b.obj", "a.b"];
        for chosen in 0..1_u32 << all.len() {
            let mut meshes: Vec<&str> =
                (0..all.len()).filter(|bit| chosen >> bit & 1 == 1).map(|bit| all[bit]).collect();
            let mut forwards = names(&meshes, None);
            assert!(!forwards.iter().any(|name| name.ends_with(['!', '?'])), "{meshes:?}: {forwards:?}");
            meshes.reverse();
            forwards.reverse();
            assert_eq!(names(&meshes, None), forwards);
        }
    }

    #[test]
    fn a_pack_has_one_of_two_names() {
        for (pack, source, expected) in [
            ("o/x.hullmap", "in/x.obj", true),
            ("o/x.obj.hullmap", "in/x.obj", true),
            ("o/x.hullmesh", "in/x.obj", true),
            ("o/x.obj.hullmesh", "in/x.obj", true),
            ("o/x.stl.hullmap", "in/x.obj", false),
            ("o/renamed.hullmap", "in/x.obj", false),
        ] {
            assert_eq!(is_name_of(Path::new(pack), Path::new(source)), expected, "{pack} {source}");
        }
    }
}
