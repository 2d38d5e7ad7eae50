//! The README tells the truth.

use std::path::Path;

use hullmap_tests::command::bake_in;

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).expect(path)
}

/// What lies between the fences that begin with `opening`, line by line.
fn fences<'t>(lines: impl Iterator<Item = &'t str>, opening: &str) -> Vec<Vec<&'t str>> {
    let mut found = Vec::new();
    let mut open: Option<Vec<&str>> = None;
    for line in lines {
        match &mut open {
            Some(_) if line == "```" => found.extend(open.take()),
            Some(inside) => inside.push(line),
            None if line == opening => open = Some(Vec::new()),
            None => {}
        }
    }
    found
}

/// The examples in the README are those in the crate's documentation, which are compiled and run.
#[test]
fn the_examples_are_the_doctests() {
    let (readme, lib) = (read("README.md"), read("crates/hullmap/src/lib.rs"));
    let doc = lib.lines().filter_map(|line| line.strip_prefix("//!")).map(|l| l.strip_prefix(' ').unwrap_or(l));
    let doctests = fences(doc.filter(|line| !line.starts_with("# ")), "```");
    assert!(doctests.len() == 2 && doctests.iter().all(|lines| lines.len() > 10), "{doctests:?}");
    assert_eq!(fences(readme.lines(), "```rust"), doctests);
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

/// The rows that the README shows are those that its first command prints, but for the time it took.
#[test]
fn the_table_is_what_the_command_prints() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::create_dir(folder.path().join("assets")).unwrap();
    for entry in std::fs::read_dir(root.join("assets")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.path().join("assets").join(path.file_name().unwrap())).unwrap();
        }
    }
    let ran = bake_in(folder.path(), "build assets --out baked --verify".split_whitespace()).expect(0);
    // Words, without the next to last column: milliseconds.
    let cells = |line: &str| -> Vec<String> {
        let mut cells: Vec<String> =
            line.split("  ").filter(|cell| !cell.is_empty()).map(|cell| cell.trim().to_owned()).collect();
        if cells.len() > 2 {
            cells.remove(cells.len() - 2);
        }
        cells
    };
    let printed: Vec<Vec<String>> = ran.stdout.lines().map(cells).collect();
    let readme = read("README.md");
    let shown = readme.lines().filter_map(|line| line.strip_prefix("    "));
    let rows: Vec<&str> = shown.filter(|line| line.starts_with("assets/") || line.starts_with("18 baked")).collect();
    assert!(rows.len() >= 5, "{rows:?}");
    for row in rows {
        assert!(printed.contains(&cells(row)), "{row}\nis not in\n{}", ran.stdout);
    }
}
