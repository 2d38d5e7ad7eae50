//! The element `compiler`, and the files that names in a model lead to.
//!
//! MuJoCo applies the folders of assets twice, by rules that differ:
//! 1. While it reads a name in an included file, it looks in the *probed* folder: the last
//!    `meshdir` of all files, or the last `assetdir` if that one is empty. If there is no such
//!    file, the name starts from the folder of the included file.
//! 2. Other names start from the *opened* folder. There, a later `assetdir` overrides an earlier
//!    `meshdir`.
//!
//! Paths are read as if the model were loaded by its absolute path: otherwise, names in included
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
    last: [Folder<'a>; 3],
}

#[derive(Clone, Debug)]
pub struct Start<'n> {
    pub folder: PathBuf,
    /// The name, without its folders if MuJoCo removes them.
    pub name: &'n str,
    pub stated_by: String,
}

impl Start<'_> {
    pub fn name(&self) -> Name<'_> {
        Name { stated_by: &self.stated_by, ..Name::of_mesh(self.name, &self.folder) }
    }
}

impl<'a> Compiler<'a> {
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

    pub fn is(&self, key: &str, value: &str) -> bool {
        self.stated.get(key) == Some(&value)
    }

    pub fn strips(&self) -> bool {
        self.is("strippath", "true")
    }

    pub fn angles(&self) -> Angles<'a> {
        let sequence = self.stated.get("eulerseq").copied().unwrap_or("xyz");
        Angles { are_degrees: !self.is("angle", "radian"), sequence }
    }

    /// The folder from which file names of these elements start, unless it is the model's.
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

    /// `root` is the folder of the model, and `included` belongs to a file that it includes.
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
