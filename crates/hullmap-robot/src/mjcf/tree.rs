//! A model and the files that it includes, as one tree.

use std::collections::BTreeSet;
use std::path::PathBuf;

use roxmltree::Node;

use super::model::Includes;
use crate::document::Document;
use crate::error::RobotError;
use crate::places::{Name, Places, Unresolved, folder_of};

const MAX_FILES: usize = 1000;

/// Names are relative to the folder of the model or, as in newer versions of MuJoCo, of the
/// including file. Fails for a file that is included twice, as in a cycle.
pub fn load(model: Document, places: &Places) -> Result<(Vec<Document>, Includes), RobotError> {
    let root = folder_of(model.path()).to_owned();
    let canonical = |path: &std::path::Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut seen: BTreeSet<PathBuf> = BTreeSet::from([canonical(model.path())]);
    let (mut documents, mut includes) = (vec![model], Includes::new());
    let mut next = 0;
    while next < documents.len() {
        let mut found = Vec::new();
        let document = &documents[next];
        for node in document.parse()?.descendants().filter(|node| node.has_tag_name("include")) {
            let at = node.range().start;
            let Some(file) = node.attribute("file") else {
                return Err(document.error(at, "this include names no file; add file=\"…\""));
            };
            let find = |folder| {
                places.find(Name { remedy: Some("restore it, or remove this include"), ..Name::of_mesh(file, folder) })
            };
            let path = find(&root).or_else(|error| find(folder_of(document.path())).map_err(|_| error));
            let path = path.map_err(|error| match error {
                Unresolved::Failed(message) => document.error(at, message),
                _ => document.error(at, format!("`{file}` is not on this machine; save it here")),
            })?;
            if !seen.insert(canonical(&path)) {
                let message = format!(
                    "`{file}` is included already; MuJoCo includes a file once, so this may be a cycle: remove one include"
                );
                return Err(document.error(at, message));
            }
            if seen.len() > MAX_FILES {
                return Err(document
                    .error(at, format!("includes more than {MAX_FILES} files; this is not a robot description")));
            }
            found.push((at, path));
        }
        for (at, path) in found {
            includes.insert((next, at), documents.len());
            documents.push(Document::read(&path)?);
        }
        next += 1;
    }
    Ok((documents, includes))
}

pub struct Tree<'a> {
    pub parsed: &'a [roxmltree::Document<'a>],
    pub includes: &'a Includes,
}

#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    pub document: usize,
    pub node: Node<'a, 'a>,
}

impl<'a> Element<'a> {
    pub fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }
}

impl<'a> Tree<'a> {
    pub fn root(&self) -> Element<'a> {
        Element { document: 0, node: self.parsed[0].root_element() }
    }

    /// The children of an element; an `include` stands for the children of the included root.
    pub fn children(&self, of: Element<'a>) -> Vec<Element<'a>> {
        let mut found = Vec::new();
        let mut waiting = self.own(of);
        while let Some(child) = waiting.pop() {
            match self.includes.get(&(child.document, child.node.range().start)) {
                Some(&document) => {
                    waiting.extend(self.own(Element { document, node: self.parsed[document].root_element() }))
                }
                None => found.push(child),
            }
        }
        found
    }

    /// The child elements in reverse, `include` among them.
    fn own(&self, of: Element<'a>) -> Vec<Element<'a>> {
        let children = of.node.children().filter(Node::is_element);
        children.rev().map(|node| Element { document: of.document, node }).collect()
    }

    /// The children of the root's sections with this name, for instance of all `asset`.
    pub fn section(&self, name: &str) -> Vec<Element<'a>> {
        let sections = self.children(self.root()).into_iter().filter(|section| section.name() == name);
        sections.flat_map(|section| self.children(section)).collect()
    }

    pub fn all(&self) -> impl Iterator<Item = Element<'a>> {
        let elements = |(document, parsed): (usize, &'a roxmltree::Document<'a>)| {
            parsed.descendants().filter(Node::is_element).map(move |node| Element { document, node })
        };
        self.parsed.iter().enumerate().flat_map(elements)
    }
}
