//! The element `compiler`, and the files that names in a model lead to.
//!
//! MuJoCo applies the folders of assets twice, by rules that differ:
//! 1. While it reads a name in an included file, it looks in the *probed* folder: the last
//!    `meshdir` of all files, or the last `assetdir` if that one is empty. If there is no such
//!    file, the name starts from the folder of the included file.
//! 2. Other names start from the *opened* folder. There, a later `assetdir` overrides an earlier
//!    `meshdir`.
//!
//! Paths are those of a model that is loaded by its absolute path: otherwise, names in included
//! files may depend on the current folder.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#compiler>, and MuJoCo's `xml_util.cc`
//! (`ResolveFilePath`) and `xml_native_reader.cc` (`Compiler`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use roxmltree::Node;

use super::pose::Angles;
use crate::places::{Name, Places};

/// A folder of assets, and the attribute that states it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Folder<'a> {
    /// Relative to the folder of the model.
    pub path: &'a str,
    attribute: &'static str,
}

impl<'a> Folder<'a> {
    fn set(&mut self, compiler: Node<'a, 'a>, attribute: &'static str) {
        if let Some(path) = compiler.attribute(attribute) {
            *self = Self { path, attribute };
        }
    }

    /// This folder, or the other one if it is empty.
    fn or(self, other: Self) -> Self {
        if self.path.is_empty() { other } else { self }
    }

    /// The attribute with its value; empty if none states this folder.
    pub fn stated_by(&self) -> String {
        if self.path.is_empty() { String::new() } else { format!("{}=\"{}\"", self.attribute, self.path) }
    }
}

/// Settings of all `compiler` elements; later ones override earlier ones.
#[derive(Debug, Default)]
pub struct Compiler<'a> {
    stated: BTreeMap<&'a str, &'a str>,
    /// Opened folders of meshes and of textures.
    opened: [Folder<'a>; 2],
    /// The last `meshdir`, `texturedir` and `assetdir`.
    last: [Folder<'a>; 3],
}

/// Where a file is looked for.
#[derive(Clone, Debug)]
pub struct Start<'n> {
    /// The folder from which the name starts.
    pub folder: PathBuf,
    /// The name, without its folders if MuJoCo removes them.
    pub name: &'n str,
    /// The attribute that states the folder.
    pub stated_by: String,
}

impl Start<'_> {
    /// The name and its folder.
    pub fn name(&self) -> Name<'_> {
        Name { stated_by: &self.stated_by, ..Name::of_mesh(self.name, &self.folder) }
    }
}

impl<'a> Compiler<'a> {
    /// The settings that these elements state, in the order of the model.
    pub fn new(compilers: impl Iterator<Item = Node<'a, 'a>>) -> Self {
        let mut all = Self::default();
        for compiler in compilers {
            all.stated.extend(compiler.attributes().map(|own| (own.name(), own.value())));
            for (folder, attribute) in all.opened.iter_mut().zip(["meshdir", "texturedir"]) {
                folder.set(compiler, "assetdir");
                folder.set(compiler, attribute);
            }
            for (folder, attribute) in all.last.iter_mut().zip(["meshdir", "texturedir", "assetdir"]) {
                folder.set(compiler, attribute);
            }
        }
        all
    }

    /// Whether a setting has this value.
    pub fn is(&self, key: &str, value: &str) -> bool {
        self.stated.get(key) == Some(&value)
    }

    /// Whether folders are removed from names.
    pub fn strips(&self) -> bool {
        self.is("strippath", "true")
    }

    /// How angles are stated.
    pub fn angles(&self) -> Angles<'a> {
        let sequence = self.stated.get("eulerseq").copied().unwrap_or("xyz");
        Angles { are_degrees: !self.is("angle", "radian"), sequence }
    }

    /// The folder from which names of files of these elements start; `None` if it is the folder of
    /// the model.
    pub fn opened(&self, element: &str) -> Option<Folder<'a>> {
        match element {
            "mesh" | "skin" | "hfield" | "flexcomp" => Some(self.opened[0]),
            "texture" => Some(self.opened[1]),
            _ => None,
        }
    }

    /// The folder in which names in included files are looked for first.
    pub fn probed(&self, element: &str) -> Folder<'a> {
        let [meshes, textures, assets] = self.last;
        match element {
            "mesh" => meshes.or(assets),
            "texture" => textures.or(assets),
            "skin" | "hfield" => assets,
            _ => Folder::default(),
        }
    }

    /// Where a name in an `element` starts. `root` is the folder of the model. `included` is the
    /// folder of the file with the element, if the model includes it.
    pub fn start<'n>(
        &self,
        element: &str,
        name: &'n str,
        (root, included): (&Path, Option<&Path>),
        places: &Places,
    ) -> Start<'n> {
        let name = name.trim();
        let opened = self.opened(element);
        let folder = opened.unwrap_or_default();
        let from_opened = |name| Start { folder: root.join(folder.path), name, stated_by: folder.stated_by() };
        if self.strips() && opened.is_some() {
            return from_opened(name.rsplit(['/', '\\']).next().unwrap_or(name));
        }
        let is_probed = || places.resolve(name, &root.join(self.probed(element).path)).is_ok();
        match included {
            Some(included) if !Path::new(name).has_root() && !is_probed() => {
                Start { folder: included.to_owned(), name, stated_by: String::new() }
            }
            _ => from_opened(name),
        }
    }
}
