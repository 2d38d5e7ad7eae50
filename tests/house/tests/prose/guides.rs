//! The guides in `docs/guides` are short, and their commands are the steps of their cases.
//!
//! `tests/cases/guides.md` has one case per guide, which `tests/tests/command/cases.rs` runs.

use std::{collections::BTreeMap, fs};

use hullmap_testkit::files::workspace;

/// Lines of a guide.
const LIMIT: usize = 60;

/// Calls of `bake` in the code blocks of a document: fenced ones, and indented ones such as
/// workflows.
fn commands(text: &str) -> Vec<&str> {
    let (mut found, mut is_open) = (Vec::new(), false);
    for line in text.lines() {
        is_open ^= line.starts_with("```");
        let code = line.trim_start();
        let code = code.strip_prefix("- run: ").unwrap_or(code);
        if code.starts_with("bake ") && (is_open || line.starts_with("    ")) {
            found.push(code);
        }
    }
    found
}

/// Steps of each case by its heading.
fn steps(text: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut cases: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut heading = "";
    for line in text.lines() {
        heading = line.strip_prefix("## ").unwrap_or(heading);
        cases.entry(heading).or_default().extend(line.strip_prefix("$ "));
    }
    cases
}

#[test]
fn every_command_of_a_guide_is_run_by_its_case() {
    let root = workspace();
    let cases = fs::read_to_string(root.join("tests/cases/guides.md")).unwrap();
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let cases = steps(&cases);
    let mut faults = Vec::new();
    let guides: Vec<_> = fs::read_dir(root.join("docs/guides")).unwrap().map(|entry| entry.unwrap().path()).collect();
    for path in &guides {
        let name = path.file_name().unwrap().to_str().unwrap();
        let text = fs::read_to_string(path).unwrap();
        let mut run = cases.get(name).map_or(&[][..], Vec::as_slice).iter();
        let written = commands(&text);
        if written.is_empty() {
            faults.push(format!("{name}: no command"));
        }
        // In the same order.
        let missing = written.into_iter().filter(|command| !run.any(|step| step == command));
        faults.extend(missing.map(|command| format!("{name}: its case does not run `{command}`, or too early")));
        if text.lines().count() > LIMIT {
            faults.push(format!("{name}: more than {LIMIT} lines"));
        }
        if !readme.contains(&format!("](docs/guides/{name})")) {
            faults.push(format!("{name}: the README has no link"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(guides.len() >= 11, "{} guides", guides.len());
}

#[test]
fn commands_are_found_in_code_alone() {
    let text = "bake a\n```sh\nbake b\ncargo c\n```\n`bake d`\n    - run: bake e\n";
    assert_eq!(commands(text), ["bake b", "bake e"]);
}
