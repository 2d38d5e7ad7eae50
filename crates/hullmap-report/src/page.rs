//! Parts shared by all pages: the head, the title, the style, and the script that counts errors.

use crate::html::{escape, fill, link};

const HEAD: &str = include_str!("page/head.html");
const FOOT: &str = include_str!("page/foot.html");
const STYLE: &str = include_str!("page/style.css");
const SCRIPT_SOURCE: &str = include_str!("page/script-source.txt");
const FAULTS: &str = include_str!("page/faults.js");

pub struct Page {
    /// Its name, which scripts read.
    pub kind: &'static str,
    /// The command that writes it.
    pub generator: &'static str,
    /// Style of this kind alone, after the style of all pages.
    pub style: &'static str,
    /// Template of what is below the title.
    pub contents: &'static str,
    pub scripts: &'static [&'static str],
}

impl Page {
    /// Every page needs `title`, `headline` and `footer`; `crumb` and `verdict` may be missing.
    pub fn fill(&self, values: &[(&str, &str)]) -> String {
        let (script, script_source) = if self.scripts.is_empty() {
            (String::new(), "")
        } else {
            ([&[FAULTS], self.scripts].concat().concat(), SCRIPT_SOURCE)
        };
        let shared = [
            ("kind", self.kind),
            ("generator", self.generator),
            ("style", STYLE),
            ("own_style", self.style),
            ("script", script.as_str()),
            ("script_source", script_source),
            ("crumb", ""),
            ("verdict", ""),
        ];
        // The first value of a name counts.
        fill(&[HEAD, self.contents, FOOT].concat(), &[values, &shared].concat())
    }
}

/// The line above the title: a link to the page of the folder, if there is one.
pub fn crumb(index: Option<&str>) -> String {
    index.map_or_else(String::new, |index| {
        format!("<p class=\"crumb\"><a href=\"{}\">← all files</a></p>\n", escape(&link(index)))
    })
}
