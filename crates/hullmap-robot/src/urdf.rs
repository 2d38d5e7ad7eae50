//! URDF: `robot` / `link` / `collision` / `geometry` / `mesh filename`.
//!
//! # Reference
//! <https://wiki.ros.org/urdf/XML/link>

mod joints;
mod origin;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use roxmltree::Node;

use crate::description::{Description, Format, Link, Reference, number, numbers, reference};
use crate::document::Document;
use crate::edit::Edit;
use crate::element::{child, children, lead, set};
use crate::error::RobotError;
use crate::links::Dialect;
use crate::mjcf::compiler::{Compiler, Start};
use crate::places::{Places, Unresolved, folder_of};

pub(crate) const DIALECT: Dialect = Dialect {
    format: Format::Urdf,
    primitives: &["box", "cylinder", "sphere", "capsule"],
    link_name: |_, name| name.to_owned(),
    mesh: |mesh| ["filename", "scale"].map(|name| mesh.attribute(name)),
    submesh: |_| None,
    pose: origin::pose,
    sizes: |node, name| node.attribute(name).and_then(numbers).unwrap_or_default(),
    mass,
    needs_names: false,
    only_visual: &["material"],
    with_mesh,
    of_inertial,
};

pub(crate) fn read(document: Document, places: &Places) -> Result<Description, RobotError> {
    let tree = document.parse()?;
    let root = tree.root_element();
    let compiler = child(root, "mujoco").and_then(|own| child(own, "compiler"));
    let names = MeshFiles { compiler: Compiler::new(compiler.into_iter()), folder: folder_of(document.path()), places };
    let links = DIALECT.links(children(root, "link"), &document, &|name| names.find(name))?;
    let named = tree.descendants().filter_map(|node| node.attribute("filename"));
    let references: BTreeSet<Reference> = named.flat_map(|name| names.references(name)).collect();
    let chain = joints::chain(root, &links, &document);
    let name = root.attribute("name").unwrap_or_default().to_owned();
    let written: BTreeSet<&str> = links.iter().flat_map(Link::meshes).map(|mesh| mesh.written.as_str()).collect();
    let warnings: Vec<String> = written.iter().filter_map(|name| names.ambiguity(name)).collect();
    let start = names.folder_of_names(&written);
    let only_folder = names.compiler.strips().then(|| names.meshes().to_owned());
    drop(tree);
    let mut description = DIALECT.description((name, document), links, references, chain);
    description.warnings = warnings;
    (description.mesh_names.folder, description.mesh_names.only_folder) = (start, only_folder);
    Ok(description)
}

/// The files of the meshes of a robot. MuJoCo reads an element `mujoco`, whose `compiler` may state
/// a folder of meshes, or remove folders from their names. Other programs ignore it.
struct MeshFiles<'a> {
    compiler: Compiler<'a>,
    folder: &'a Path,
    places: &'a Places,
}

impl MeshFiles<'_> {
    /// The folder of meshes that MuJoCo adds to names, relative to the description.
    fn meshes(&self) -> &str {
        self.compiler.opened("mesh").unwrap_or_default().path
    }

    /// Where MuJoCo looks for a mesh, if elsewhere than other programs.
    fn start<'n>(&self, name: &'n str) -> Option<Start<'n>> {
        let starts_from_root = name.contains("://") || Path::new(name.trim()).has_root();
        let differs = self.compiler.strips() || !self.meshes().is_empty() && !starts_from_root;
        differs.then(|| self.compiler.start("mesh", name, (self.folder, None), self.places))
    }

    /// The file of a mesh: MuJoCo's, if there is one.
    fn find(&self, name: &str) -> Result<PathBuf, Unresolved> {
        let by_mujoco = self.start(name).map(|start| self.places.find(start.name()));
        match by_mujoco {
            Some(Ok(file)) => Ok(file),
            None => self.places.resolve(name, self.folder),
            Some(Err(error)) => self.places.resolve(name, self.folder).map_err(|other| match other {
                // The folder that the description states is part of the cause.
                Unresolved::Failed(_) if !name.contains("://") => error,
                other => other,
            }),
        }
    }

    fn ambiguity(&self, name: &str) -> Option<String> {
        let by_mujoco = self.places.find(self.start(name)?.name()).ok()?;
        let by_others = self.places.resolve(name, self.folder).ok()?;
        (by_mujoco.canonicalize().ok()? != by_others.canonicalize().ok()?).then(|| {
            format!(
                "`{name}` is {} for MuJoCo, which is used here, and {} for programs that ignore the element `mujoco`; \
                 remove one of the files",
                by_mujoco.display(),
                by_others.display()
            )
        })
    }

    /// The folder from which new names start: MuJoCo's, if a name leads to a file only from there.
    /// Other names lead to the same file in all programs.
    fn folder_of_names(&self, written: &BTreeSet<&str>) -> String {
        let needs_folder = |name: &&str| {
            let is_found = self.start(name).is_some_and(|start| self.places.find(start.name()).is_ok());
            is_found && (!self.compiler.strips() || self.places.resolve(name, self.folder).is_err())
        };
        if written.iter().any(needs_folder) { self.meshes().to_owned() } else { String::new() }
    }

    fn references<'n>(&self, name: &'n str) -> impl Iterator<Item = Reference> + use<'n> {
        let by_mujoco = self.start(name).and_then(|start| {
            let own = reference(start.name, self.places, &start.folder, self.folder)?;
            Some(Reference { written: name.to_owned(), ..own })
        });
        by_mujoco.into_iter().chain(reference(name, self.places, self.folder, self.folder))
    }
}

fn mass(link: Node) -> Option<f64> {
    let value = child(child(link, "inertial")?, "mass")?.attribute("value")?;
    number(value).filter(|mass| *mass > 0.0)
}

/// Edits of an `inertial`: the origin is the centre of mass, with the axes of the link.
fn of_inertial(node: Node, text: &str, [x, y, z]: [f64; 3], tensor: [[f64; 3]; 3]) -> Vec<Edit> {
    let centre = format!("{x} {y} {z}");
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = tensor;
    let entries = [("ixx", xx), ("ixy", xy), ("ixz", xz), ("iyy", yy), ("iyz", yz), ("izz", zz)];
    let mut edits = Vec::new();
    match child(node, "origin") {
        Some(origin) => edits.extend([set(origin, text, "xyz", &centre), set(origin, text, "rpy", "0 0 0")]),
        None => {
            let mass = child(node, "mass").unwrap_or(node);
            let origin = format!("<origin xyz=\"{centre}\" rpy=\"0 0 0\"/>{}", &text[lead(mass, text)]);
            edits.push(Edit::insert(mass.range().start, origin));
        }
    }
    match child(node, "inertia") {
        Some(inertia) => edits.extend(entries.map(|(name, value)| set(inertia, text, name, &value.to_string()))),
        None => {
            let mass = child(node, "mass").unwrap_or(node);
            let values: String = entries.iter().map(|(name, value)| format!(" {name}=\"{value}\"")).collect();
            edits.push(Edit::insert(mass.range().end, format!("{}<inertia{values}/>", &text[lead(mass, text)])));
        }
    }
    edits
}

fn with_mesh(node: Node, text: &str, name: &str) -> Vec<Edit> {
    let mesh = child(node, "geometry").and_then(|geometry| child(geometry, "mesh"));
    mesh.map(|mesh| set(mesh, text, "filename", name)).into_iter().collect()
}
