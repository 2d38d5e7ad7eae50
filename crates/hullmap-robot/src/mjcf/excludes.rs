//! Pairs of bodies without contacts: `contact` / `exclude`.
//!
//! New ones are added in a separate section at the end of the model. MuJoCo merges sections of the
//! same name, so nothing else changes.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#contact-exclude>

use std::collections::{BTreeSet, HashMap};

use super::tree::Tree;
use crate::description::Link;
use crate::edit::Edit;
use crate::element::{escaped, lead};

/// The pairs of bodies that a model excludes.
pub fn excluded(tree: &Tree, links: &[Link]) -> Vec<[usize; 2]> {
    let index: HashMap<&str, usize> = links.iter().enumerate().map(|(at, link)| (link.name.as_str(), at)).collect();
    let excludes = tree.section("contact").into_iter().filter(|element| element.name() == "exclude");
    let pairs = excludes.filter_map(|element| {
        let body = |name| element.node.attribute(name).and_then(|name| index.get(name)).copied();
        Some([body("body1")?, body("body2")?])
    });
    pairs.collect()
}

/// The insertion of pairs that the model does not exclude yet. Bodies without a name are left out:
/// an element cannot name them.
pub fn exclude(tree: &Tree, text: &str, links: &[Link], pairs: &[[usize; 2]], comment: &str) -> Option<Edit> {
    let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let known: BTreeSet<[usize; 2]> = excluded(tree, links).into_iter().map(sorted).collect();
    let named: BTreeSet<&str> =
        tree.all().filter(|element| element.name() == "body").filter_map(|body| body.node.attribute("name")).collect();
    let name = |link: usize| Some(links[link].name.as_str()).filter(|name| named.contains(name));
    let new = pairs.iter().filter(|pair| !known.contains(&sorted(**pair)));
    let lines: Vec<String> = new
        .filter_map(|[a, b]| {
            let [a, b] = [name(*a)?, name(*b)?].map(escaped);
            Some(format!("<exclude body1=\"{a}\" body2=\"{b}\"/>"))
        })
        .collect();
    let last = tree.root().node.last_element_child().filter(|_| !lines.is_empty())?;
    let line = &text[lead(last, text)];
    let lines: String = lines.iter().map(|exclude| format!("{line}  {exclude}")).collect();
    let comment = format!("<!-- {} -->", escaped(comment).replace("--", "- -"));
    Some(Edit::insert(last.range().end, format!("{line}<contact>{line}  {comment}{lines}{line}</contact>")))
}
