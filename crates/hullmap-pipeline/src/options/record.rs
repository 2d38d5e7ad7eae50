//! The text in which a pack records its options: `split none, vertices referenced, index tree 8,
//! unit_scale 0.01`.
//!
//! Equal options have equal texts in every version of the tool: a pack is fresh only if its header
//! holds the hash of this text. Options that are newer than the first packs are recorded only if
//! they differ from their defaults.

use std::fmt;

use hullmap_bake::IndexKind;

use super::removed::{VHACD, instead_of_record, may_be_recorded};
use super::table::{OPTIONS, Record, position};
use super::{BuildOptions, OptionLayer};

impl fmt::Display for BuildOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (index, option) in OPTIONS.iter().enumerate() {
            let text = match (option.record, &self.0.value_at(index)) {
                (Record::Never, _) | (_, None) => continue,
                (Record::Always, Some(_)) if option.key == "index" => recorded_index(self.index()),
                (Record::Always, Some(value)) => value.to_string(),
                (Record::IfChanged, Some(value)) if option.syntax.parse(option.default).as_ref() == Ok(value) => {
                    continue;
                }
                (Record::IfChanged, Some(_)) if option.key == "decompose" => COVER.to_owned(),
                (Record::IfChanged, Some(value)) => value.to_string(),
            };
            write!(f, "{separator}{} {text}", option.key)?;
            separator = ", ";
        }
        Ok(())
    }
}

/// The record of a decomposition: its method, since there were others.
const COVER: &str = "cover";

fn recorded_index(kind: IndexKind) -> String {
    if kind.is_tree() { format!("tree {}", kind.leaf_size()) } else { kind.to_string() }
}

impl BuildOptions {
    /// Recorded options for people: the index has its name on the command line, if this version has
    /// it.
    pub fn recorded_in_words(text: &str) -> String {
        match Self::from_recorded(text).filter(|options| options.to_string() == text) {
            Some(options) => text.replacen(&recorded_index(options.index()), &options.index().to_string(), 1),
            None => text.to_owned(),
        }
    }

    /// The parameters of a recorded decomposition, if there was one with known options.
    pub fn recorded_cover(text: &str) -> Option<hullmap_bake::decompose::Cover> {
        Self::from_recorded(text)?.decompose()
    }

    /// The inverse of [`Display`](fmt::Display), except that an index of earlier versions becomes
    /// the one most like it, so that old packs can be verified. `None` if this version does not
    /// have the options.
    pub fn from_recorded(text: &str) -> Option<Self> {
        if instead_of_record(text) == Some(VHACD) {
            return None;
        }
        let mut layer = OptionLayer::default();
        for part in text.split(", ") {
            let (key, value) = part.split_once(' ')?;
            if position(key).is_some_and(|index| OPTIONS[index].record == Record::Never) {
                return None;
            }
            match (key, value) {
                ("index", _) => set_index(&mut layer, value)?,
                _ if may_be_recorded(key) => {}
                ("decompose", COVER) => layer.set(key, "true").ok()?,
                _ => layer.set(key, value).ok()?,
            }
        }
        // The first packs had these two already.
        let is_whole = layer.get("split").is_some() && layer.get("vertices").is_some();
        (is_whole && layer.get("index").is_some()).then(|| layer.resolve())
    }
}

/// A tree without its leaf size, as in the first packs, is the default tree.
fn set_index(layer: &mut OptionLayer, text: &str) -> Option<()> {
    if let Some(leaf_size) = text.strip_prefix("tree ") {
        let leaf_size: u32 = leaf_size.parse().ok()?;
        let tree = IndexKind::NAMED.into_iter().find(|kind| kind.is_tree() && kind.leaf_size() == leaf_size)?;
        return layer.set("index", tree.as_str()).ok();
    }
    if text.starts_with("budget ") {
        return layer.set("index", "tree").ok();
    }
    let kind = text.parse().ok().filter(|kind: &IndexKind| kind.to_string() == text)?;
    layer.set("index", kind.as_str()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::resolved::tests::options;

    /// Options and their record, from rows such as `split=auto lean=true | split auto, …`. The
    /// records decide which packs are fresh: a change of the rows makes all existing packs stale.
    fn records() -> Vec<(BuildOptions, &'static str)> {
        let row = |row: &'static str| {
            let (pairs, record) = row.split_once(" | ").unwrap();
            let pairs: Vec<_> = pairs.split_whitespace().filter_map(|pair| pair.split_once('=')).collect();
            (options(&pairs), record)
        };
        include_str!("records.txt").lines().map(row).collect()
    }

    #[test]
    fn records_never_change() {
        for (options, record) in records() {
            assert_eq!(options.to_string(), record);
        }
    }

    #[test]
    fn records_round_trip() {
        for (options, text) in records() {
            assert_eq!(BuildOptions::from_recorded(text), Some(options.clone()), "{text}");
            let words = BuildOptions::recorded_in_words(text);
            assert_eq!(BuildOptions::from_recorded(&words), Some(options), "{words}");
            assert!(!words.contains("tree "), "{words}");
        }
        for text in [
            "",
            "split convex, vertices all, index tree 8",
            "split none, index tree 8",
            "split none, vertices all",
            "split none, vertices all, index tree 12",
            "split none, vertices all, index cubemap",
            "split none, vertices all, index tree 8, mirror x",
            "split none, vertices all, index tree 8, unit_scale 0",
            "split none, vertices all, index tree 8, unit_scale nan",
            "split none, vertices all, index tree 8, recentre",
            "split none, vertices all, index none, terrain true, hole_image ../x",
            "split none, vertices all, index none, terrain true, origin 1",
            "split none, vertices all, index tree 8, pack_names full",
            "split none, vertices all, index tree 8, decompose true",
            "split none, vertices all, index tree 8, decompose true, vhacd_resolution 32",
            "split none, vertices all, index tree 8, decompose cover, reachable 5%",
        ] {
            assert_eq!(BuildOptions::from_recorded(text), None, "{text}");
        }
    }

    #[test]
    fn records_with_another_index_are_read() {
        for (index, is_removed) in [("tree 16", false), ("budget 40", true), ("cubemap 7", true), ("cubemap 64", false)]
        {
            let text = format!("split auto, vertices referenced, index {index}, decompose cover, max_parts 2");
            let found = BuildOptions::from_recorded(&text).unwrap();
            let expected = options(&[("split", "auto"), ("decompose", "true"), ("max_parts", "2")]);
            assert_eq!((found.decompose(), found.import()), (expected.decompose(), expected.import()), "{index}");
            assert_eq!(
                (found.to_string() != text, instead_of_record(&text).is_some()),
                (is_removed, is_removed),
                "{index}"
            );
            assert_eq!(BuildOptions::recorded_in_words(&text) == text, index != "tree 16", "{index}");
        }
        assert_eq!(
            BuildOptions::recorded_cover("split none, vertices all, index tree 8, decompose true"),
            None,
            "V-HACD"
        );
    }

    /// Packs that were made with such options can be verified, but are not fresh.
    #[test]
    fn options_that_change_no_bound_may_be_recorded() {
        let usual = "split none, vertices referenced, index tree 8, decompose cover";
        for removed in ["overlap 0.1", "overlap none", "symmetry none", "fill true"] {
            let text = format!("{usual}, {removed}");
            assert_eq!(BuildOptions::from_recorded(&text).unwrap().to_string(), usual);
            assert!(instead_of_record(&text).is_some(), "{removed}");
        }
        let reachable = format!("{usual}, reachable 5%");
        assert!(instead_of_record(&reachable).unwrap().contains("delete inner walls"));
    }

    #[test]
    fn names_of_packs_are_not_recorded() {
        assert_eq!(options(&[("pack_names", "full")]).to_string(), BuildOptions::default().to_string());
    }

    #[test]
    fn the_first_packs_recorded_the_tree_without_leaf_size() {
        let text = "split none, vertices referenced, index tree";
        assert_eq!(BuildOptions::from_recorded(text), Some(BuildOptions::default()));
    }
}
