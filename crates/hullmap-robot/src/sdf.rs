//! SDF: `model` / `link` / `collision` / `geometry` / `mesh` / `uri`.
//!
//! # Reference
//! <http://sdformat.org/spec>

mod joints;
mod pose;

use std::collections::BTreeSet;
use std::ops::Range;

use roxmltree::Node;

use crate::description::{Description, Format, OtherModel, Reference, Submesh, Unread, number, numbers, reference};
use crate::document::Document;
use crate::edit::Edit;
use crate::element::{child, escaped, lead, removed, without};
use crate::error::RobotError;
use crate::links::Dialect;
use crate::places::{Places, folder_of};

pub(crate) const DIALECT: Dialect = Dialect {
    format: Format::Sdf,
    primitives: &["box", "cylinder", "sphere", "capsule", "ellipsoid", "cone"],
    link_name: qualified,
    mesh,
    submesh,
    pose: pose::in_link,
    sizes: |node, name| child(node, name).and_then(|size| numbers(size.text()?)).unwrap_or_default(),
    mass,
    needs_names: true,
    only_visual: &["material", "transparency", "cast_shadows", "visibility_flags", "lighting", "meta", "plugin"],
    with_mesh,
    of_inertial,
};

const FILES: [&str; 5] = ["uri", "script", "albedo_map", "normal_map", "filename"];

pub(crate) fn read(document: Document, places: &Places) -> Result<Description, RobotError> {
    let tree = document.parse()?;
    let folder = folder_of(document.path());
    let (mut others, mut unread) = (Vec::new(), Vec::new());
    let is_link = |node: &Node| {
        node.has_tag_name("link") && node.parent_element().is_some_and(|model| model.has_tag_name("model"))
    };
    let find = |name: &str| places.resolve(name, folder);
    let links = DIALECT.links(tree.descendants().filter(is_link), &document, &find)?;
    for node in tree.descendants().filter(|node| node.has_tag_name("include")) {
        let uri = child(node, "uri").and_then(|uri| uri.text()).unwrap_or_default().trim();
        let line = document.line(node.range().start);
        others.push(OtherModel { written: uri.to_owned(), line, path: places.folder_of_model(uri, folder) });
        let element = format!("the included model `{uri}`");
        unread.push(Unread { document: 0, line, element, reason: "it is another file; write its links into this one" });
    }
    let named = tree.descendants().filter(|node| FILES.iter().any(|name| node.has_tag_name(*name)));
    let references = named.filter_map(|node| reference(node.text()?, places, folder, folder));
    // Gazebo finds a model by this file beside it.
    let config = reference("model.config", places, folder, folder);
    let config = config.map(|own| Reference { written: String::new(), ..own });
    let references: BTreeSet<Reference> = references.chain(config).collect();
    let chain = joints::chain(tree.root_element(), &links, &document);
    let model = tree.descendants().find(|node| node.has_tag_name("model"));
    let name = model.and_then(|model| model.attribute("name")).unwrap_or_default().to_owned();
    drop(tree);
    Ok(Description { unread, others, ..DIALECT.description((name, document), links, references, chain) })
}

/// Preceded by the names of the models that contain it, unless there is only one.
fn qualified(link: Node, name: &str) -> String {
    let models: Vec<Node> = link.ancestors().filter(|node| node.has_tag_name("model")).collect();
    let is_alone = |model: &Node| {
        model.parent_element().is_none_or(|parent| !parent.has_tag_name("model") && !parent.has_tag_name("world"))
    };
    let outer = models.iter().rev().filter(|model| !is_alone(model)).filter_map(|model| model.attribute("name"));
    outer.chain(std::iter::once(name)).collect::<Vec<_>>().join("::")
}

fn mesh<'a>(mesh: Node<'a, 'a>) -> [Option<&'a str>; 2] {
    let text = |name: &str| child(mesh, name).and_then(|element| element.text());
    [text("uri").map(str::trim), text("scale")]
}

fn submesh(mesh: Node) -> Option<Submesh> {
    let submesh = child(mesh, "submesh")?;
    let text = |name: &str| child(submesh, name).and_then(|element| element.text()).map(str::trim);
    let is_centered = matches!(text("center"), Some("1" | "true"));
    Some(Submesh { name: text("name").unwrap_or_default().to_owned(), is_centered })
}

/// The mass that a link states, unless its inertia is computed from densities.
fn mass(link: Node) -> Option<f64> {
    let inertial = child(link, "inertial").filter(|node| node.attribute("auto") != Some("true"))?;
    let mass = child(inertial, "mass")?.text()?;
    number(mass).filter(|mass| *mass > 0.0)
}

/// Edits of an `inertial`: its pose is the centre of mass, with the axes of the link.
fn of_inertial(node: Node, text: &str, [x, y, z]: [f64; 3], tensor: [[f64; 3]; 3]) -> Vec<Edit> {
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = tensor;
    let entries = [("ixx", xx), ("ixy", xy), ("ixz", xz), ("iyy", yy), ("iyz", yz), ("izz", zz)];
    let entries: String = entries.iter().map(|(name, value)| format!("<{name}>{value}</{name}>")).collect();
    let (pose, inertia) = (format!("<pose>{x} {y} {z} 0 0 0</pose>"), format!("<inertia>{entries}</inertia>"));
    let mass = child(node, "mass").unwrap_or(node);
    let space = &text[lead(mass, text)];
    let pose = match child(node, "pose") {
        Some(old) => Edit::replace(old.range(), pose),
        None => Edit::insert(mass.range().start, format!("{pose}{space}")),
    };
    let inertia = match child(node, "inertia") {
        Some(old) => Edit::replace(old.range(), inertia),
        None => Edit::insert(mass.range().end, format!("{space}{inertia}")),
    };
    vec![pose, inertia]
}

/// Nothing that divides meshes applies to the new one, which is a whole file and convex.
fn with_mesh(node: Node, text: &str, name: &str) -> Vec<Edit> {
    let mut edits: Vec<Edit> = uri_of(node).map(|span| Edit::replace(span, escaped(name))).into_iter().collect();
    if let Some(mesh) = child(node, "geometry").and_then(|geometry| child(geometry, "mesh")) {
        let divisions = ["submesh", "convex_decomposition"].into_iter().filter_map(|name| child(mesh, name));
        edits.extend(divisions.map(|division| removed(division, text)));
        edits.extend(without(mesh, text, "optimization"));
    }
    edits
}

fn uri_of(node: Node) -> Option<Range<usize>> {
    let uri = child(child(child(node, "geometry")?, "mesh")?, "uri")?;
    Some(uri.first_child()?.range().start..uri.last_child()?.range().end)
}
