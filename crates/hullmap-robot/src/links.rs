//! The links of URDF and SDF, which differ in how they write names, meshes, poses and masses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use roxmltree::Node;

use crate::chain::Chain;
use crate::description::{
    Contacts, Description, Format, Geometry, Link, MeshNames, MeshUse, Reference, Shape, Submesh, mesh_use, packages_of,
};
use crate::document::Document;
use crate::edit::Edit;
use crate::element::{child, children};
use crate::error::RobotError;
use crate::frame::Frame;
use crate::places::Unresolved;
use crate::primitive::{NamedPrimitive, Primitive};

pub(crate) type Find<'f> = dyn Fn(&str) -> Result<PathBuf, Unresolved> + 'f;

pub(crate) type OfInertial = fn(Node, &str, [f64; 3], [[f64; 3]; 3]) -> Vec<Edit>;

pub(crate) struct Dialect {
    pub(crate) format: Format,
    pub(crate) primitives: &'static [&'static str],
    /// The name of a link in messages, from its element and the name there.
    pub(crate) link_name: fn(Node, &str) -> String,
    /// The file and the scale that a `mesh` element states.
    pub(crate) mesh: for<'a> fn(Node<'a, 'a>) -> [Option<&'a str>; 2],
    pub(crate) submesh: fn(Node) -> Option<Submesh>,
    /// The pose of an element in its link; `None` if it is not known.
    pub(crate) pose: fn(Node) -> Option<Frame>,
    /// The numbers of an attribute or element of a primitive; empty if it is missing.
    pub(crate) sizes: fn(Node, &str) -> Vec<f64>,
    pub(crate) mass: fn(Node) -> Option<f64>,
    /// Whether each collision needs a name that no other collision of its link has.
    pub(crate) needs_names: bool,
    /// Elements of a visual that a collision must not have.
    pub(crate) only_visual: &'static [&'static str],
    /// Edits of a shape that give it another mesh.
    pub(crate) with_mesh: fn(Node, &str, &str) -> Vec<Edit>,
    /// Edits of an `inertial`: the centre of mass, and the tensor about it in the axes of the link.
    pub(crate) of_inertial: OfInertial,
}

impl Dialect {
    /// `find` returns the files of meshes.
    pub(crate) fn links<'t>(
        &self,
        nodes: impl Iterator<Item = Node<'t, 't>>,
        document: &Document,
        find: &Find,
    ) -> Result<Vec<Link>, RobotError> {
        let mut links: Vec<Link> = Vec::new();
        let mut lines: BTreeMap<String, u32> = BTreeMap::new();
        for node in nodes {
            let at = node.range().start;
            let own = node.attribute("name").ok_or_else(|| document.error(at, "this link has no name; add one"))?;
            let name = (self.link_name)(node, own);
            let line = document.line(at);
            if let Some(first) = lines.insert(name.clone(), line) {
                return Err(
                    document.error(at, format!("link `{name}` exists already, in line {first}; rename one of them"))
                );
            }
            let shapes = |kind: &'static str| -> Vec<Shape> {
                children(node, kind).map(|node| self.shape(node, kind == "visual", document, find)).collect()
            };
            let (collisions, visuals) = (shapes("collision"), shapes("visual"));
            let mass = (self.mass)(node);
            links.push(Link { name, document: 0, line, at, collisions, visuals, takes_visuals: true, mass });
        }
        Ok(links)
    }

    fn shape(&self, node: Node, is_drawn: bool, document: &Document, find: &Find) -> Shape {
        let geometry = child(node, "geometry").and_then(|geometry| geometry.first_element_child());
        let geometry = match geometry {
            None => Geometry::Other("it has no geometry".to_owned()),
            Some(element) => match element.tag_name().name() {
                "mesh" => {
                    let [file, scale] = (self.mesh)(element);
                    let own = mesh_use(file.unwrap_or_default(), scale, find);
                    Geometry::Mesh(MeshUse { submesh: (self.submesh)(element), ..own })
                }
                name if self.primitives.contains(&name) => {
                    let shape = Primitive::of_lengths(name, |size| (self.sizes)(element, size));
                    Geometry::Primitive(NamedPrimitive { name: name.to_owned(), shape })
                }
                name => Geometry::Other(format!("`{name}` is not a mesh")),
            },
        };
        let at = node.range().start;
        let name = node.attribute("name").unwrap_or_default().to_owned();
        let pose = (self.pose)(node);
        Shape {
            name,
            document: 0,
            line: document.line(at),
            geometry,
            pose,
            contact_bits: [1, 1],
            is_drawn,
            stays_single: None,
            at,
        }
    }

    pub(crate) fn description(
        &self,
        (name, document): (String, Document),
        links: Vec<Link>,
        references: BTreeSet<Reference>,
        chain: Chain,
    ) -> Description {
        let mesh_names = MeshNames { packages: packages_of(&links), ..MeshNames::default() };
        Description {
            format: self.format,
            name,
            documents: vec![document],
            links,
            references: references.into_iter().collect(),
            notes: Vec::new(),
            others: Vec::new(),
            contacts: Contacts::default(),
            unread: Vec::new(),
            warnings: Vec::new(),
            chain: chain.without_circular_couplings(),
            mesh_names,
            mjcf: None,
        }
    }
}
