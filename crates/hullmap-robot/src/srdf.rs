//! SRDF: pairs of links that MoveIt does not test for collisions.
//!
//! # Reference
//! <https://wiki.ros.org/srdf>; reasons as in MoveIt's setup assistant.

use crate::element::escaped;

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
