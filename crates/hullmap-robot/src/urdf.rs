//! URDF: `robot` / `link` / `collision` / `geometry` / `mesh filename`.
//!
//! # Reference
//! <https://wiki.ros.org/urdf/XML/link>

mod joints;
mod origin;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use roxmltree::Node;

use crate::description::{Change, Description, Format, Link, Reference, numbers, reference};
use crate::document::Document;
use crate::edit::{Edit, edited};
use crate::element::{child, children, lead, removed, rename, set, unique};
use crate::error::RobotError;
use crate::links::Dialect;
use crate::mjcf::compiler::{Compiler, Start};
use crate::places::{Places, Unresolved, folder_of};

const DIALECT: Dialect = Dialect {
    format: Format::Urdf,
    primitives: &["box", "cylinder", "sphere", "capsule"],
    link_name: |_, name| name.to_owned(),
    mesh: |mesh| ["filename", "scale"].map(|name| mesh.attribute(name)),
    submesh: |_| None,
    pose: origin::pose,
    sizes: |node, name| node.attribute(name).and_then(numbers).unwrap_or_default(),
    mass,
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
    let mut description = DIALECT.description((name, document), links, references, Vec::new(), chain);
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

pub(crate) fn edits(document: &Document, links: &[Link], changes: &[Change]) -> Result<Vec<Edit>, RobotError> {
    let tree = document.parse()?;
    let nodes: BTreeMap<usize, Node> =
        tree.descendants().filter(Node::is_element).map(|node| (node.range().start, node)).collect();
    let text = document.text();
    let mut edits = Vec::new();
    for change in changes {
        let Some((link, shape, meshes)) = change.parts(links) else {
            if let Change::Inertia { link, center, inertia } = change {
                let inertial = nodes.get(&links[*link].at).and_then(|link| child(*link, "inertial"));
                edits.extend(inertial.into_iter().flat_map(|node| of_inertial(node, text, *center, *inertia)));
            }
            continue;
        };
        let node = nodes[&shape.at];
        let mut names: BTreeSet<String> = link.collisions.iter().map(|shape| shape.name.clone()).collect();
        match change {
            Change::Remove { .. } => edits.push(removed(node, text)),
            Change::Inertia { .. } | Change::Exclude { .. } => {}
            Change::Replace { .. } => {
                let copy = |index: usize, mesh: &String| part(node, text, mesh, Some(index), &mut names);
                edits.extend(replace(node, text, meshes.unwrap_or_default(), copy));
            }
            Change::FromVisual { .. } => {
                let last = link.visuals.last().map_or(shape.at, |last| last.at);
                let at = nodes[&last].range().end;
                let one = [None];
                let each: Vec<Option<&String>> =
                    meshes.map_or(one.to_vec(), |meshes| meshes.iter().map(Some).collect());
                let is_single = each.len() == 1;
                for (index, mesh) in each.into_iter().enumerate() {
                    let index = if is_single { None } else { Some(index) };
                    edits.push(Edit::insert(at, from_visual(node, text, mesh, index, &mut names)));
                }
            }
        }
    }
    Ok(edits)
}

fn mass(link: Node) -> Option<f64> {
    let value = child(child(link, "inertial")?, "mass")?.attribute("value")?;
    value.trim().parse().ok().filter(|mass: &f64| *mass > 0.0 && mass.is_finite())
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

/// The first mesh replaces the old one. Each other mesh gets a copy of the element.
fn replace(node: Node, text: &str, meshes: &[String], mut copy: impl FnMut(usize, &String) -> String) -> Vec<Edit> {
    let Some((first, others)) = meshes.split_first() else { return Vec::new() };
    let mut edits: Vec<Edit> = mesh_of(node).map(|mesh| set(mesh, text, "filename", first)).into_iter().collect();
    edits.extend((1..).zip(others).map(|(index, mesh)| Edit::insert(node.range().end, copy(index, mesh))));
    edits
}

fn mesh_of<'a, 'input>(node: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
    child(child(node, "geometry")?, "mesh")
}

/// A copy of a collision with another mesh, for part `index`.
fn part(node: Node, text: &str, mesh: &str, index: Option<usize>, names: &mut BTreeSet<String>) -> String {
    let mut edits: Vec<Edit> = mesh_of(node).map(|node| set(node, text, "filename", mesh)).into_iter().collect();
    edits.extend(renamed(node, text, index, names));
    text[lead(node, text)].to_owned() + &edited(text, node.range(), edits)
}

fn renamed(node: Node, text: &str, index: Option<usize>, names: &mut BTreeSet<String>) -> Option<Edit> {
    let name = node.attribute("name").filter(|name| !name.is_empty())?;
    let name = index.map_or_else(|| name.to_owned(), |index| format!("{name}_part_{index:02}"));
    Some(set(node, text, "name", &unique(&name, names)))
}

fn from_visual(
    node: Node,
    text: &str,
    mesh: Option<&String>,
    index: Option<usize>,
    names: &mut BTreeSet<String>,
) -> String {
    let mut edits = rename(node, text, "collision");
    edits.extend(children(node, "material").map(|material| removed(material, text)));
    edits.extend(mesh.and_then(|mesh| Some(set(mesh_of(node)?, text, "filename", mesh))));
    edits.extend(renamed(node, text, index, names));
    text[lead(node, text)].to_owned() + &edited(text, node.range(), edits)
}
