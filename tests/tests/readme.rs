//! The README tells the truth.

use std::path::Path;

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).expect(path)
}

/// Lines of the first `rust` fence of a text.
fn example(text: &str) -> Vec<&str> {
    text.lines().skip_while(|line| *line != "```rust").skip(1).take_while(|line| *line != "```").collect()
}

/// The example in the README is the one in the crate's documentation, which is compiled and run.
#[test]
fn the_example_is_the_doctest() {
    let readme = read("README.md");
    let lib = read("crates/hullmap/src/lib.rs");
    let doctest: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.strip_prefix("//!"))
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .skip_while(|line| *line != "```")
        .skip(1)
        .take_while(|line| *line != "```")
        .filter(|line| !line.starts_with("# "))
        .collect();
    assert!(doctest.len() > 10);
    assert_eq!(example(&readme), doctest);
}

/// Every file and folder that the documents link to or name in a table is there.
#[test]
fn what_it_names_is_there() {
    let readme = read("README.md");
    let linked = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let named = readme.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let mut count = 0;
    for path in linked.chain(named.filter(|name| !name.starts_with("cargo"))) {
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path).exists(), "{path}");
        count += 1;
    }
    assert!(count >= 8);
}
