//! Edits of a model: assets for the new meshes, geoms that name them, and copies of the old geoms
//! that are drawn and have mass.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::contacts::exclude;
use super::model::Geom;
use super::tree::{Element, Tree};
use crate::description::{Change, Description};
use crate::document::Document;
use crate::edit::{Edit, edited};
use crate::element::{lead, removed, set, unique, without};
use crate::error::RobotError;

/// Attributes of an asset that do not apply to a hull: arrays and a limit on vertices.
const NOT_OF_HULLS: [&str; 6] = ["content_type", "maxhullvert", "vertex", "normal", "texcoord", "face"];

/// Attributes of an `inertial` that `pos` and `fullinertia` replace.
const OTHER_INERTIA: [&str; 6] = ["quat", "axisangle", "xyaxes", "zaxis", "euler", "diaginertia"];

/// The group of the new geoms: hidden by default, as is usual for collisions.
const GROUP: &str = "3";

pub(crate) fn edits(description: &Description, changes: &[Change]) -> Result<Vec<Vec<Edit>>, RobotError> {
    let documents = &description.documents;
    let mut result: Vec<Vec<Edit>> = documents.iter().map(|_| Vec::new()).collect();
    let Some(model) = &description.mjcf else { return Ok(result) };
    let parsed: Vec<roxmltree::Document> = documents.iter().map(Document::parse).collect::<Result<_, _>>()?;
    let tree = Tree { parsed: &parsed, includes: &model.includes };
    let nodes: BTreeMap<(usize, usize), Element> =
        tree.all().map(|element| ((element.document, element.node.range().start), element)).collect();
    let mut assets = Assets {
        documents,
        are_in_model: model.assets_in_model,
        taken: names_of_meshes(&tree),
        named: BTreeMap::new(),
        edits: Vec::new(),
        in_model: Vec::new(),
    };
    let named = tree.all().filter(|element| element.name() == "geom").filter_map(|geom| geom.node.attribute("name"));
    let mut geoms: BTreeSet<String> = named.map(str::to_owned).collect();
    for change in changes {
        if let Change::Exclude { pairs, comment } = change {
            result[0].extend(exclude(&tree, documents[0].text(), &description.links, pairs, comment));
        }
        if let Change::Inertia { link, center, inertia } = change {
            let link = &description.links[*link];
            let body = nodes.get(&(link.document, link.at));
            let inertial = body.and_then(|body| tree.children(*body).into_iter().find(|own| own.name() == "inertial"));
            if let Some(own) = inertial {
                let writer = Writer { element: own, text: documents[own.document].text() };
                result[own.document].extend(writer.inertial(*center, *inertia));
            }
        }
        let Some((_, shape, meshes)) = change.parts(&description.links) else { continue };
        let key = (shape.document, shape.at);
        let (Some(&element), Some(geom)) = (nodes.get(&key), model.geoms.get(&key)) else { continue };
        let names = assets.add_copies(geom, &nodes, meshes.unwrap_or_default());
        let writer = Writer { element, text: documents[shape.document].text() };
        let own = &mut result[shape.document];
        match change {
            Change::Inertia { .. } | Change::Exclude { .. } => {}
            Change::Remove { .. } if geom.keeps_copy || geom.is_named => {
                let off = ["contype", "conaffinity"].map(|name| (name, Some("0".to_owned())));
                own.extend(writer.merged(off.to_vec()));
            }
            Change::Remove { .. } => own.push(removed(element.node, writer.text)),
            Change::Replace { .. } => writer.replace(geom, &names, &mut geoms, own),
            Change::FromVisual { meshes: None, .. } => own.push(writer.as_collision(None)),
            Change::FromVisual { .. } => own.extend(names.iter().map(|name| writer.as_collision(Some(name)))),
        }
    }
    result[0].extend(assets.section(&tree));
    for (document, edit) in assets.edits {
        result[document].push(edit);
    }
    Ok(result)
}

fn names_of_meshes(tree: &Tree) -> BTreeSet<String> {
    let meshes = tree.all().filter(|element| element.name() == "mesh");
    let name = |mesh: Element| {
        let stem = || Some(Path::new(mesh.node.attribute("file")?).file_stem()?.to_string_lossy().into_owned());
        mesh.node.attribute("name").map(str::to_owned).or_else(stem)
    };
    meshes.filter_map(name).collect()
}

struct Assets<'a> {
    documents: &'a [Document],
    taken: BTreeSet<String>,
    /// By the old asset and the new file.
    named: BTreeMap<((usize, usize), String), String>,
    edits: Vec<(usize, Edit)>,
    are_in_model: bool,
    in_model: Vec<String>,
}

impl Assets<'_> {
    /// The section of the assets in the model's own file. MuJoCo merges sections of the same name.
    fn section(&self, tree: &Tree) -> Option<Edit> {
        let last = tree.root().node.last_element_child().filter(|_| !self.in_model.is_empty())?;
        let line = &self.documents[0].text()[lead(last, self.documents[0].text())];
        let assets: String = self.in_model.iter().map(|asset| format!("{line}  {asset}")).collect();
        Some(Edit::insert(last.range().end, format!("{line}<asset>{assets}{line}</asset>")))
    }

    /// The names of the assets of these files, for a geom. An asset is added once for each file and
    /// old asset. It is a copy of the old one, with its scale and class.
    fn add_copies(&mut self, geom: &Geom, nodes: &BTreeMap<(usize, usize), Element>, files: &[String]) -> Vec<String> {
        let Some((key, asset)) = geom.asset.and_then(|key| Some((key, nodes.get(&key)?))) else { return Vec::new() };
        let text = self.documents[asset.document].text();
        let mut names = Vec::new();
        for file in files {
            if let Some(name) = self.named.get(&(key, file.clone())) {
                names.push(name.clone());
                continue;
            }
            let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let name = unique(&stem, &mut self.taken);
            let node = asset.node;
            let mut own = vec![set(node, text, "name", &name), set(node, text, "file", file)];
            own.extend(NOT_OF_HULLS.iter().filter_map(|name| without(node, text, name)));
            let copy = edited(text, node.range(), own);
            if self.are_in_model && asset.document != 0 {
                self.in_model.push(copy);
            } else {
                let copy = text[lead(node, text)].to_owned() + &copy;
                self.edits.push((asset.document, Edit::insert(node.range().end, copy)));
            }
            self.named.insert((key, file.clone()), name.clone());
            names.push(name);
        }
        names
    }
}

struct Writer<'a> {
    element: Element<'a>,
    text: &'a str,
}

impl Writer<'_> {
    /// The geom gets the first mesh, and keeps its name and all else. Copies get the other meshes.
    /// The last copy is drawn or keeps the mass, if the geom was or did.
    fn replace(&self, geom: &Geom, meshes: &[String], taken: &mut BTreeSet<String>, edits: &mut Vec<Edit>) {
        let Some((first, others)) = meshes.split_first() else { return };
        let name = self.element.node.attribute("name").unwrap_or_default();
        edits.extend(self.merged(self.hull(geom, first)));
        for (index, mesh) in (1..).zip(others) {
            let mut own = self.hull(geom, mesh);
            if !name.is_empty() {
                own.push(("name", Some(unique(&format!("{name}_part_{index:02}"), taken))));
            }
            edits.push(self.copy(own));
        }
        if geom.keeps_copy {
            edits.push(self.copy(self.without_contact()));
        }
    }

    fn hull(&self, geom: &Geom, mesh: &str) -> Vec<(&'static str, Option<String>)> {
        let mut own = vec![("mesh", Some(mesh.to_owned()))];
        if geom.keeps_copy {
            own.extend([("group", Some(GROUP.to_owned())), ("mass", Some("0".to_owned()))]);
        }
        own
    }

    /// Edits of an `inertial`: the centre of mass, and the tensor in the axes of the body.
    fn inertial(&self, [x, y, z]: [f64; 3], tensor: [[f64; 3]; 3]) -> Vec<Edit> {
        let [[xx, xy, xz], [_, yy, yz], [.., zz]] = tensor;
        let mut own: Vec<(&'static str, Option<String>)> = OTHER_INERTIA.map(|name| (name, None)).to_vec();
        own.push(("pos", Some(format!("{x} {y} {z}"))));
        own.push(("fullinertia", Some(format!("{xx} {yy} {zz} {xy} {xz} {yz}"))));
        self.merged(own)
    }

    fn without_contact(&self) -> Vec<(&'static str, Option<String>)> {
        let none = || Some("0".to_owned());
        vec![("name", None), ("contype", none()), ("conaffinity", none())]
    }

    /// A collision with the pose of a geom that is drawn: it collides, is hidden, and has no mass.
    fn as_collision(&self, mesh: Option<&String>) -> Edit {
        let value = |text: &str| Some(text.to_owned());
        let mut own = vec![("name", None), ("contype", value("1")), ("conaffinity", value("1"))];
        own.extend([("group", value(GROUP)), ("mass", value("0"))]);
        own.extend(mesh.map(|mesh| ("mesh", Some(mesh.clone()))));
        self.copy(own)
    }

    /// Attributes that are set, or removed, in the element itself. Added ones are one insertion.
    fn merged(&self, attributes: Vec<(&'static str, Option<String>)>) -> Vec<Edit> {
        let edit = |(name, value): (&'static str, Option<String>)| match value {
            Some(value) => Some(set(self.element.node, self.text, name, &value)),
            None => without(self.element.node, self.text, name),
        };
        attributes.into_iter().filter_map(edit).collect()
    }

    fn copy(&self, attributes: Vec<(&'static str, Option<String>)>) -> Edit {
        let node = self.element.node;
        let copy = edited(self.text, node.range(), self.merged(attributes));
        Edit::insert(node.range().end, self.text[lead(node, self.text)].to_owned() + &copy)
    }
}
