//! Every example in a document is run by a test or a script.

use std::{fs, path::Path};

use hullmap_testkit::files::workspace;

use crate::readme::documents;

/// Whole sections that `.ci/examples` follows: the script names the document and the heading.
const FOLLOWERS: [&str; 2] = [".ci/nightly", "crates/hullmap-wasm/tests/run"];

/// Documents whose examples in a language are run by a test, which names the document.
const TESTED: [(&str, &str, &str); 7] = [
    ("crates/hullmap-c/README.md", "c", "crates/hullmap-c/tests/programs.rs"),
    ("crates/hullmap-c/README.md", "cpp", "crates/hullmap-c/tests/programs.rs"),
    ("crates/hullmap-python/README.md", "python", "crates/hullmap-python/tests/test_package.py"),
    ("docs/python.md", "python", "crates/hullmap-python/tests/test_package.py"),
    ("docs/usd.md", "python", "tests/usd/check.py"),
    ("docs/triangle-meshes.md", "rust", "tests/house/tests/prose/readme.rs"),
    ("docs/height-fields.md", "rust", "tests/house/tests/prose/readme.rs"),
];

/// The fenced blocks of a document that name a language, with the headings above them.
fn blocks(text: &str) -> Vec<(String, Vec<&str>)> {
    let (mut headings, mut found, mut is_open): (Vec<(usize, &str)>, _, _) = (Vec::new(), Vec::new(), false);
    for line in text.lines() {
        let depth = line.len() - line.trim_start_matches('#').len();
        if let Some(language) = line.trim_start().strip_prefix("```") {
            is_open = !is_open;
            if is_open && !language.is_empty() {
                let language = language.split(',').next().unwrap_or_default().to_owned();
                found.push((language, headings.iter().map(|(_, heading)| *heading).collect()));
            }
        } else if !is_open && depth > 0 && line[depth..].starts_with(' ') {
            headings.retain(|(above, _)| *above < depth);
            headings.push((depth, &line[depth + 1..]));
        }
    }
    found
}

#[test]
fn every_example_is_run() {
    let read = |path: &str| fs::read_to_string(workspace().join(path)).expect(path);
    let followers = FOLLOWERS.map(read).concat();
    let is_followed = |document: &str, heading: &str| {
        let quoted = if heading.contains(' ') { format!("\"{heading}\"") } else { heading.to_owned() };
        let named =
            |line: &str| line.split_once(document).is_some_and(|(_, rest)| rest.contains(&format!(" {quoted}")));
        followers.lines().any(named)
    };
    let is_tested = |document: &str, language: &str| {
        // `tests/tests/command/cases.rs` runs the cases, and lists their files.
        let is_case = document.starts_with("tests/cases/") && language == "console";
        // `guides.rs` requires that each command of a guide is a step of its case.
        let is_guide = document.starts_with("docs/guides/") && language == "sh";
        is_case
            || is_guide
            || TESTED.iter().any(|(tested, by_language, test)| {
                let name = Path::new(document).file_name().unwrap_or_default().to_string_lossy();
                (*tested, *by_language) == (document, language) && read(test).contains(&*name)
            })
    };
    let (mut count, mut missing) = (0, Vec::new());
    for file in documents() {
        let document = file.strip_prefix(workspace()).unwrap_or(&file).to_string_lossy().into_owned();
        for (language, headings) in blocks(&fs::read_to_string(&file).unwrap()) {
            count += 1;
            if !is_tested(&document, &language) && !headings.iter().any(|heading| is_followed(&document, heading)) {
                missing.push(format!("{document}: {language} under {headings:?}"));
            }
        }
    }
    assert!(missing.is_empty(), "nothing runs these examples:\n{}", missing.join("\n"));
    assert!(count > 50 || !workspace().join(".git").exists(), "{count} examples");
}

#[test]
fn blocks_have_the_headings_above_them() {
    let text = "# A\n```\n# no heading\n```\n## B\n```rust,no_run\n```\n### C\n## D\n```sh\n```\n";
    let expected = [("rust".to_owned(), vec!["A", "B"]), ("sh".to_owned(), vec!["A", "D"])];
    assert_eq!(blocks(text), expected);
}
