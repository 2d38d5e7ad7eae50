//! The documents stay short enough to read.

use std::{cmp::Reverse, fs, path::PathBuf};

use hullmap_testkit::files::workspace;

use crate::readme::documents;

/// Maximum number of words in all Markdown files, apart from the cases. Links to files do not
/// count.
const LIMIT: usize = 90_000;

/// Number of words in a text, as `wc -w` counts them.
fn words(text: &str) -> usize {
    text.split_whitespace().count()
}

#[test]
fn the_documents_are_short() {
    let root = workspace();
    let files = documents().filter(|file| !file.starts_with(root.join("tests/cases")));
    let count = |file: &PathBuf| words(&fs::read_to_string(file).expect("a tracked file can be read"));
    let mut counts: Vec<_> = files.map(|file| (count(&file), file)).collect();
    counts.sort_by_key(|(count, _)| Reverse(*count));
    let total: usize = counts.iter().map(|(count, _)| count).sum();
    let name = |(count, file): &(usize, PathBuf)| {
        format!("{count:6} {}", file.strip_prefix(workspace()).unwrap_or(file).display())
    };
    let largest: Vec<_> = counts.iter().take(5).map(name).collect();
    assert!(total <= LIMIT, "{total} words; at most {LIMIT} are allowed. The largest files:\n{}", largest.join("\n"));
    assert!(total > LIMIT / 2 || !root.join(".git").exists(), "only {total} words found");
}

#[test]
fn words_are_separated_by_white_space() {
    assert_eq!(words("| a-b | `c` |\n\nd e.\n"), 7);
}
