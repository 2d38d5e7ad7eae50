//! Contacts in a model: `exclude`, `pair` and `flag`.
//!
//! New `exclude` elements are in a section of their own at the end, which MuJoCo merges.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#contact>

use std::collections::{BTreeSet, HashMap};

use super::tree::{Element, Tree};
use crate::description::{Contacts, Link};
use crate::edit::Edit;
use crate::element::{escaped, lead};

/// Contacts, with the `pair` elements that name a geom which is no collision of `links`.
pub fn contacts<'a>(tree: &Tree<'a>, links: &[Link]) -> (Contacts, Vec<Element<'a>>) {
    let flag = |name: &str| {
        let flags = tree.section("option").into_iter().filter(|element| element.name() == "flag");
        flags.filter_map(|flag| flag.node.attribute(name)).next_back() == Some("disable")
    };
    let mut geoms: HashMap<&str, [usize; 2]> = HashMap::new();
    for (link, own) in links.iter().enumerate() {
        let named = own.collisions.iter().enumerate().filter(|(_, shape)| !shape.name.is_empty());
        geoms.extend(named.map(|(index, shape)| (shape.name.as_str(), [link, index])));
    }
    let (mut paired, mut unknown) = (Vec::new(), Vec::new());
    for element in pairs(tree) {
        let geom = |name| element.node.attribute(name).and_then(|name| geoms.get(name)).copied();
        match (geom("geom1"), geom("geom2")) {
            (Some(a), Some(b)) => paired.push([a, b]),
            _ => unknown.push(element),
        }
    }
    let contacts = Contacts {
        excluded: excluded(tree, links),
        paired,
        tests_parents: flag("filterparent"),
        is_disabled: flag("contact") || flag("constraint"),
    };
    (contacts, unknown)
}

fn pairs<'a>(tree: &Tree<'a>) -> impl Iterator<Item = Element<'a>> + use<'a> {
    tree.section("contact").into_iter().filter(|element| element.name() == "pair")
}

/// The names of all geoms of pairs, which collide whatever their masks are.
pub fn paired_geoms<'a>(tree: &Tree<'a>) -> BTreeSet<&'a str> {
    pairs(tree).flat_map(|element| ["geom1", "geom2"].map(|name| element.node.attribute(name))).flatten().collect()
}

fn excluded(tree: &Tree, links: &[Link]) -> Vec<[usize; 2]> {
    let index: HashMap<&str, usize> = links.iter().enumerate().map(|(at, link)| (link.name.as_str(), at)).collect();
    let excludes = tree.section("contact").into_iter().filter(|element| element.name() == "exclude");
    let pairs = excludes.filter_map(|element| {
        let body = |name| element.node.attribute(name).and_then(|name| index.get(name)).copied();
        Some([body("body1")?, body("body2")?])
    });
    pairs.collect()
}

/// Pairs that the model does not exclude yet, of bodies with names.
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
