//! The documents name files that exist: each path in back quotes is the end of a tracked path.

use std::{collections::BTreeSet, fs, path::Path};

use hullmap_house::tracked;
use hullmap_testkit::files::workspace;

/// Documents outside of `docs`. All documents in `docs` are checked, except the guides, which name
/// files of their readers.
const DOCUMENTS: [&str; 4] = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "benches/README.md"];

/// Words that look like paths of the repository and are not.
const PLACEHOLDERS: [&str; 10] = [
    // The character, and the start of a comment.
    "/",
    "//",
    // A shard.
    "I/N",
    // Files that a user names.
    "FILE.md",
    "hullmap.toml",
    "DIR/hullmap.toml",
    // Files that the recipes in CONTRIBUTING.md add.
    "crates/hullmap-import/src/YOUR_FORMAT.rs",
    "tools/shapes/src/YOUR_FORMAT.rs",
    "crates/hullmap/src/shapes/YOUR_SHAPE.rs",
    "crates/hullmap-cli/src/commands/YOUR_COMMAND.rs",
];

/// Text between back quotes, outside of fenced blocks. It may span lines.
fn quoted(text: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut in_fence = false;
    for line in text.lines() {
        if line.starts_with("```") {
            in_fence = !in_fence;
        } else if !in_fence {
            prose.push_str(line);
            prose.push('\n');
        }
    }
    prose.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Whether a word looks like a path of the repository.
fn is_path(word: &str) -> bool {
    word.contains('/') || [".rs", ".md", ".toml"].iter().any(|ending| word.ends_with(ending))
}

#[test]
fn paths_in_back_quotes_exist() {
    let files = tracked();
    if files.is_empty() && !workspace().join(".git").exists() {
        println!("skipped: paths_in_back_quotes_exist: this is not a git checkout");
        return;
    }
    // Every file, and every folder above it.
    let known: BTreeSet<&Path> = files.iter().flat_map(|file| Path::new(file).ancestors()).collect();
    let in_docs = files.iter().map(String::as_str).filter(|file| file.starts_with("docs/") && file.ends_with(".md"));
    let in_docs = in_docs.filter(|file| !file.starts_with("docs/guides/"));
    let (mut count, mut stale) = (0, Vec::new());
    for document in DOCUMENTS.into_iter().chain(in_docs) {
        let text = fs::read_to_string(workspace().join(document)).expect(document);
        for span in quoted(&text) {
            let words = span.split_whitespace().filter(|word| is_path(word) && !PLACEHOLDERS.contains(word));
            for word in words {
                count += 1;
                // `Path::ends_with` compares whole components.
                if !known.iter().any(|path| path.ends_with(word)) {
                    stale.push(format!("{document}: `{word}`"));
                }
            }
        }
    }
    assert!(stale.is_empty(), "no tracked path ends with these:\n{}", stale.join("\n"));
    assert!(count > 100, "only {count} paths found");
}

/// The scan finds what the rule is about.
#[test]
fn paths_are_found_in_back_quotes_only() {
    let text = "See `a/b.rs`, `run --out x/y\nand z.md`.\n```\nint `c/d.rs`;\n```\n1/2 and `no_path`.\n";
    let spans = quoted(text);
    assert_eq!(spans, ["a/b.rs", "run --out x/y\nand z.md", "no_path"]);
    let words: Vec<&str> = spans.iter().flat_map(|span| span.split_whitespace()).filter(|w| is_path(w)).collect();
    assert_eq!(words, ["a/b.rs", "x/y", "z.md"]);
}
