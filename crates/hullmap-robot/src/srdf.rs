//! SRDF: pairs of links that MoveIt does not test for collisions.
//!
//! # Reference
//! <https://wiki.ros.org/srdf>; reasons as in MoveIt's setup assistant.

use std::path::Path;

use crate::document::Document;
use crate::element::{children, escaped};
use crate::error::RobotError;

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
    let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(robot));
    text += &format!("  <!-- {} -->\n", escaped(comment).replace("--", "- -"));
    for DisabledPair { links: [a, b], reason } in pairs {
        let [a, b, reason] = [a, b, reason].map(|text| escaped(text));
        text += &format!("  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>\n");
    }
    text + "</robot>\n"
}

/// Collisions in an SRDF file, by the names of the links. Pairs override links.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SrdfPairs {
    /// Pairs that are not tested: `disable_collisions`.
    pub disabled: Vec<[String; 2]>,
    /// Pairs that are tested: `enable_collisions`.
    pub enabled: Vec<[String; 2]>,
    /// Links whose other pairs are not tested: `disable_default_collisions`.
    pub disabled_links: Vec<String>,
}

/// The collisions in an SRDF file.
///
/// # Errors
/// The file cannot be read, is not SRDF, or an element does not name its links.
pub fn srdf_pairs(path: &Path) -> Result<SrdfPairs, RobotError> {
    let document = Document::read(path)?;
    let tree = document.parse()?;
    let root = tree.root_element();
    if root.tag_name().name() != "robot" {
        let message = "the root of an SRDF file is `robot`; name the SRDF file of the robot";
        return Err(document.error(root.range().start, message));
    }
    let names = |element: &'static str, attributes: &'static [&'static str]| {
        let names = children(root, element).map(|node| {
            let names: Option<Vec<String>> =
                attributes.iter().map(|name| node.attribute(*name).map(str::to_owned)).collect();
            let message = || format!("`{element}` must name its links; add {}", attributes.join(" and "));
            names.ok_or_else(|| document.error(node.range().start, message()))
        });
        names.collect::<Result<Vec<_>, _>>()
    };
    let pairs = |element| -> Result<Vec<[String; 2]>, RobotError> {
        let names = names(element, &["link1", "link2"])?;
        Ok(names.into_iter().filter_map(|names| names.try_into().ok()).collect())
    };
    Ok(SrdfPairs {
        disabled: pairs("disable_collisions")?,
        enabled: pairs("enable_collisions")?,
        disabled_links: names("disable_default_collisions", &["link"])?.concat(),
    })
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
            srdf_pairs(&path)
        };
        let pair = DisabledPair { links: ["a<b", "c"], reason: "Never" };
        let disabled = vec![["a<b", "c"].map(str::to_owned)];
        let expected = SrdfPairs { disabled, ..SrdfPairs::default() };
        assert_eq!(read(&srdf("arm", "--", &[pair])).unwrap(), expected);
        let found =
            read("<robot><disable_default_collisions link='x'/><enable_collisions link1='x' link2='y'/></robot>");
        let enabled = vec![["x", "y"].map(str::to_owned)];
        assert_eq!(found.unwrap(), SrdfPairs { enabled, disabled_links: vec!["x".to_owned()], disabled: Vec::new() });
        let error = read("<robot>\n<disable_collisions link1='a'/></robot>").unwrap_err();
        assert!(error.line == Some(2) && error.message.contains("link2"), "{error}");
        assert!(read("<mujoco/>").unwrap_err().message.contains("SRDF"));
    }
}
