//! SRDF: pairs of links that MoveIt does not test for collisions.
//!
//! # Reference
//! <https://wiki.ros.org/srdf>; reasons as in MoveIt's setup assistant.

use std::path::Path;

use crate::document::Document;
use crate::element::{children, escaped};
use crate::error::RobotError;

/// The first line of files of [`srdf`].
pub const SRDF_FIRST_LINE: &str = "<?xml version=\"1.0\"?><!-- Written by bake robot: pairs only. -->\n";

/// A pair of links that is not tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DisabledPair<'a> {
    /// Names of the links.
    pub links: [&'a str; 2],
    /// `Adjacent`, `Default`, `Always` or `Never`.
    pub reason: &'a str,
}

/// The text of an SRDF file.
///
/// ```
/// use hullmap_robot::{DisabledPair, srdf};
///
/// let text = srdf("arm", "Seed 0.", &[DisabledPair { links: ["a", "b"], reason: "Adjacent" }]);
/// assert!(text.contains("<robot name=\"arm\">\n  <!-- Seed 0. -->\n"));
/// assert!(text.contains("<disable_collisions link1=\"a\" link2=\"b\" reason=\"Adjacent\"/>\n"));
/// ```
pub fn srdf(robot: &str, comment: &str, pairs: &[DisabledPair]) -> String {
    let mut text = format!("{SRDF_FIRST_LINE}<robot name=\"{}\">\n", escaped(robot));
    text += &format!("  <!-- {} -->\n", escaped(comment).replace("--", "- -"));
    for DisabledPair { links: [a, b], reason } in pairs {
        let [a, b, reason] = [a, b, reason].map(|text| escaped(text));
        text += &format!("  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>\n");
    }
    text + "</robot>\n"
}

/// The pairs of links that an SRDF file disables, by the names of the links.
///
/// # Errors
/// The file cannot be read, is not SRDF, or an element does not name two links.
pub fn disabled_pairs(path: &Path) -> Result<Vec<[String; 2]>, RobotError> {
    let document = Document::read(path)?;
    let tree = document.parse()?;
    let root = tree.root_element();
    if root.tag_name().name() != "robot" {
        let message = "the root of an SRDF file is `robot`; name the SRDF file of the robot";
        return Err(document.error(root.range().start, message));
    }
    let pairs = children(root, "disable_collisions").map(|node| {
        let link = |name| node.attribute(name).map(str::to_owned);
        match (link("link1"), link("link2")) {
            (Some(a), Some(b)) => Ok([a, b]),
            _ => {
                Err(document.error(node.range().start, "`disable_collisions` must name two links; add link1 and link2"))
            }
        }
    });
    pairs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm.srdf");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            disabled_pairs(&path)
        };
        let pair = DisabledPair { links: ["a<b", "c"], reason: "Never" };
        assert_eq!(read(&srdf("arm", "--", &[pair])).unwrap(), [["a<b", "c"]]);
        let error = read("<robot>\n<disable_collisions link1='a'/></robot>").unwrap_err();
        assert!(error.line == Some(2) && error.message.contains("link2"), "{error}");
        assert!(read("<mujoco/>").unwrap_err().message.contains("SRDF"));
    }
}
