//! URDF: `robot` / `link` / `collision` / `geometry` / `mesh filename`.
//!
//! # Reference
//! <https://wiki.ros.org/urdf/XML/link>

mod joints;
mod origin;

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use crate::description::{Change, Description, Format, Link, Reference, numbers, reference};
use crate::document::Document;
use crate::edit::{Edit, edited};
use crate::element::{child, children, lead, removed, rename, set, unique};
use crate::error::RobotError;
use crate::links::Dialect;
use crate::places::{Places, folder_of};

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

/// Finds the links of a description.
///
/// # Errors
/// Two links have one name, or a link has none.
pub(crate) fn read(document: Document, places: &Places) -> Result<Description, RobotError> {
    let tree = document.parse()?;
    let links = DIALECT.links(children(tree.root_element(), "link"), &document, places)?;
    let folder = folder_of(document.path());
    let named = tree.descendants().filter_map(|node| node.attribute("filename"));
    let references: BTreeSet<Reference> = named.filter_map(|name| reference(name, places, folder)).collect();
    let chain = joints::chain(tree.root_element(), &links, &document);
    let name = tree.root_element().attribute("name").unwrap_or_default().to_owned();
    drop(tree);
    Ok(DIALECT.description((name, document), links, references, Vec::new(), chain))
}

/// The edits that make these changes.
///
/// # Errors
/// The document can no longer be parsed.
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

/// The mass that a link states.
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

/// The name of a part, if the element has a name.
fn renamed(node: Node, text: &str, index: Option<usize>, names: &mut BTreeSet<String>) -> Option<Edit> {
    let name = node.attribute("name").filter(|name| !name.is_empty())?;
    let name = index.map_or_else(|| name.to_owned(), |index| format!("{name}_part_{index:02}"));
    Some(set(node, text, "name", &unique(&name, names)))
}

/// A collision with the pose of a visual.
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
