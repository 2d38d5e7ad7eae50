//! Edits of the links of URDF and SDF.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use crate::description::{Change, Link};
use crate::document::Document;
use crate::edit::{Edit, edited};
use crate::element::{child, lead, removed, rename, set, unique};
use crate::error::RobotError;
use crate::links::Dialect;

impl Dialect {
    pub(crate) fn edits(
        &self,
        document: &Document,
        links: &[Link],
        changes: &[Change],
    ) -> Result<Vec<Edit>, RobotError> {
        let tree = document.parse()?;
        let elements = tree.descendants().filter(Node::is_element);
        let nodes: BTreeMap<usize, Node> = elements.map(|node| (node.range().start, node)).collect();
        let text = document.text();
        let mut edits = Vec::new();
        let mut names: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for change in changes {
            let Some((link, shape, meshes)) = change.parts(links) else {
                if let Change::Inertia { link, center, inertia } = change {
                    let inertial = nodes.get(&links[*link].at).and_then(|link| child(*link, "inertial"));
                    edits.extend(inertial.into_iter().flat_map(|own| (self.of_inertial)(own, text, *center, *inertia)));
                }
                continue;
            };
            let node = nodes[&shape.at];
            if !self.needs_names {
                names.clear();
            }
            let own_names = || link.collisions.iter().map(|shape| shape.name.clone()).collect();
            let names = names.entry(&link.name).or_insert_with(own_names);
            // The element with these edits, and the name of part `index`.
            let mut copy = |mut own: Vec<Edit>, index: Option<usize>| {
                if self.needs_names || !shape.name.is_empty() {
                    let name = index.map_or_else(String::new, |index| format!("_part_{index:02}"));
                    own.push(set(node, text, "name", &unique(&(shape.name.clone() + &name), names)));
                }
                text[lead(node, text)].to_owned() + &edited(text, node.range(), own)
            };
            match change {
                Change::Remove { .. } => edits.push(removed(node, text)),
                Change::Inertia { .. } | Change::Exclude { .. } => {}
                Change::Replace { .. } => {
                    // The first mesh replaces the old one. Each other mesh gets a copy of the
                    // element.
                    let Some((first, others)) = meshes.and_then(<[String]>::split_first) else { continue };
                    edits.extend((self.with_mesh)(node, text, first));
                    for (index, mesh) in (1..).zip(others) {
                        let part = copy((self.with_mesh)(node, text, mesh), Some(index));
                        edits.push(Edit::insert(node.range().end, part));
                    }
                }
                Change::FromVisual { .. } => {
                    let last = link.visuals.last().map_or(shape.at, |last| last.at);
                    let count = meshes.map_or(1, <[String]>::len);
                    for index in 0..count {
                        let mut own = rename(node, text, "collision");
                        let is_visual = |child: &Node| self.only_visual.contains(&child.tag_name().name());
                        own.extend(node.children().filter(is_visual).map(|child| removed(child, text)));
                        let mesh = meshes.and_then(|meshes| meshes.get(index));
                        own.extend(mesh.into_iter().flat_map(|mesh| (self.with_mesh)(node, text, mesh)));
                        let part = copy(own, (count > 1).then_some(index));
                        edits.push(Edit::insert(nodes[&last].range().end, part));
                    }
                }
            }
        }
        Ok(edits)
    }
}
