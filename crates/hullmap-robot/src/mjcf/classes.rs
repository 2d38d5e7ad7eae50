//! Default classes of MJCF: attributes that elements do not state.

use std::collections::{BTreeMap, HashMap};

use super::tree::{Element, Tree};

type Attributes = BTreeMap<(&'static str, String), String>;

const KINDS: [&str; 3] = ["geom", "mesh", "joint"];

#[derive(Debug, Default)]
pub struct Classes {
    root: Attributes,
    named: HashMap<String, Attributes>,
}

impl Classes {
    pub fn read(tree: &Tree) -> Self {
        let mut classes = Self::default();
        let sections = tree.children(tree.root()).into_iter().filter(|section| section.name() == "default");
        for section in sections {
            classes.update_root(tree, section);
        }
        classes
    }

    fn update_root(&mut self, tree: &Tree, section: Element) {
        update(&mut self.root, tree, section);
        if let Some(name) = section.node.attribute("class") {
            self.named.insert(name.to_owned(), self.root.clone());
        }
        self.named.insert("main".to_owned(), self.root.clone());
        let mut waiting: Vec<(Element, Attributes)> = vec![(section, self.root.clone())];
        while let Some((parent, inherited)) = waiting.pop() {
            for child in tree.children(parent).into_iter().filter(|child| child.name() == "default") {
                let mut own = inherited.clone();
                update(&mut own, tree, child);
                if let Some(name) = child.node.attribute("class") {
                    self.named.insert(name.to_owned(), own.clone());
                }
                waiting.push((child, own));
            }
        }
    }

    pub fn has(&self, name: &str) -> bool {
        name == "main" || self.named.contains_key(name)
    }

    /// The attribute, from the class that the element states, or of the nearest body or frame with
    /// `childclass`.
    pub fn get<'b>(&'b self, element: &'b Element, childclass: Option<&str>, name: &str) -> Option<&'b str> {
        if let Some(own) = element.node.attribute(name) {
            return Some(own);
        }
        let class = element.node.attribute("class").or(childclass);
        let attributes = class.and_then(|class| self.named.get(class)).unwrap_or(&self.root);
        let kind = KINDS.into_iter().find(|kind| *kind == element.name())?;
        attributes.get(&(kind, name.to_owned())).map(String::as_str)
    }
}

fn update(attributes: &mut Attributes, tree: &Tree, class: Element) {
    for child in tree.children(class) {
        if let Some(kind) = KINDS.into_iter().find(|kind| *kind == child.name()) {
            let stated = child.node.attributes().map(|own| ((kind, own.name().to_owned()), own.value().to_owned()));
            attributes.extend(stated);
        }
    }
}
