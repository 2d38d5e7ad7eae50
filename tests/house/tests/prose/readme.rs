//! The README and the guides in `docs` agree with the code, the files and the command.

use std::path::{Path, PathBuf};

use hullmap_house::tracked;
use hullmap_testkit::{command::bake_in, files::workspace};

fn read(path: &str) -> String {
    std::fs::read_to_string(workspace().join(path)).expect(path)
}

fn empty_folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).expect("the target folder can be written");
    folder
}

/// The lines between fences that begin with `opening`.
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

/// Every Rust example in these guides is a module's doctest, which is compiled and run.
#[test]
fn the_examples_are_doctests() {
    let modules = [
        ("docs/rust.md", "lib.rs", 2),
        ("docs/triangle-meshes.md", "triangle_mesh/mod.rs", 1),
        ("docs/height-fields.md", "height_field/mod.rs", 1),
    ];
    for (guide, module, least) in modules {
        let (text, code) = (read(guide), read(&format!("crates/hullmap/src/{module}")));
        let doc = code.lines().filter_map(|line| line.strip_prefix("//!")).map(|l| l.strip_prefix(' ').unwrap_or(l));
        let doctests = fences(doc.filter(|line| !line.starts_with("# ")), "```");
        let examples = fences(text.lines(), "```rust");
        assert!(examples.len() >= least, "{guide}: {examples:?}");
        for example in examples {
            assert!(doctests.contains(&example), "{guide}: not in {module}: {example:#?}");
        }
    }
}

/// The rows in the README equal the output of its first command, except for the time.
#[test]
fn the_table_is_what_the_command_prints() {
    let folder = empty_folder("the_table_is_what_the_command_prints");
    let root = workspace();
    std::fs::create_dir(folder.join("assets")).unwrap();
    for entry in std::fs::read_dir(root.join("assets")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.join("assets").join(path.file_name().unwrap())).unwrap();
        }
    }
    let ran = bake_in(&folder, "build assets --out baked --verify".split_whitespace()).expect(0);
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

/// The first bake in the README makes the parts that the text states, of the mesh in the picture.
#[test]
fn the_teapot_has_the_stated_numbers() {
    let folder = empty_folder("the_teapot_has_the_stated_numbers");
    let mesh = "tests/meshes/vhacd_teapot.obj";
    std::fs::create_dir_all(folder.join("tests/meshes")).unwrap();
    std::fs::copy(workspace().join(mesh), folder.join(mesh)).unwrap();
    let readme = read("README.md");
    let commands =
        readme.lines().filter_map(|line| line.strip_prefix("    bake ")).filter(|line| line.contains("teapot"));
    let printed: Vec<String> =
        commands.map(|line| bake_in(&folder, line.split_whitespace()).expect(0).stdout).collect();
    let [build, _export] = &printed[..] else { panic!("{} commands", printed.len()) };
    let row = build.lines().find(|line| line.starts_with(mesh)).expect(build);
    let cells: Vec<&str> = row.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
    let triangles = read(mesh).lines().filter(|line| line.starts_with("f ")).count();
    let words: Vec<&str> = readme.split_whitespace().collect();
    for stated in [
        format!("{} parts with {} vertices", cells[2], cells[4]),
        format!("{},{:03} triangles", triangles / 1000, triangles % 1000),
    ] {
        assert!(words.join(" ").contains(&stated), "the README lacks: {stated}");
    }
}

#[test]
fn the_citation_has_the_version() {
    let manifest = read("Cargo.toml");
    let version = manifest.lines().find_map(|line| line.strip_prefix("version = ")).unwrap().trim_matches('"');
    let line = format!("version: {version}");
    assert!(read("CITATION.cff").lines().any(|stated| stated == line), "CITATION.cff lacks: {line}");
}

/// The README fits on two screens.
#[test]
fn the_readme_is_short() {
    let count = read("README.md").lines().count();
    assert!(count <= 120, "{count} lines; move details to docs");
}

/// A reader looks a word up; a longer list is not read.
#[test]
fn the_glossary_is_short() {
    let count = read("docs/GLOSSARY.md").lines().count();
    assert!(count <= 80, "{count} lines; common words need no row");
}

/// "Closed" stood for three things: filled holes, a property of a mesh, and a set with its border.
#[test]
fn meshes_without_holes_are_watertight_in_documents() {
    for file in tracked().into_iter().filter(|file| file.ends_with(".md") && !file.contains("contributors/intervals")) {
        let text = read(&file).split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        for words in ["closed mesh", "closed shell", "not closed", "mesh is closed", "triangles are closed"] {
            assert!(!text.contains(words), "{file}: {words}: a mesh without a hole is watertight");
        }
    }
}

/// The first line of each file states what it does, so the table only lists where to start.
#[test]
fn the_table_of_files_is_short() {
    let count = read("docs/contributors/ARCHITECTURE.md").lines().filter(|line| line.contains("? | `")).count();
    assert!((10..=20).contains(&count), "{count} questions");
}

/// The exports that `docs/baking.md` shows run as they are, once a mesh is baked.
#[test]
fn the_exports_run() {
    let folder = empty_folder("the_exports_run");
    let rock = workspace().join("assets/rock.obj");
    bake_in(&folder, ["build", rock.to_str().unwrap(), "--out", "baked", "--quiet"]).expect(0);
    let guide = read("docs/baking.md");
    let lines: Vec<&str> = guide.lines().filter_map(|line| line.strip_prefix("    bake export ")).collect();
    assert!(lines.len() >= 5, "{lines:?}");
    for line in lines {
        bake_in(&folder, ["export"].into_iter().chain(line.split_whitespace())).expect(0);
    }
}

/// Markdown files of the project, with their absolute paths.
pub fn documents() -> impl Iterator<Item = PathBuf> {
    let files = tracked().into_iter().filter(|file| file.ends_with(".md"));
    files.map(|file| workspace().join(file)).filter(|path| !path.is_symlink())
}

/// Anchor of a heading, as code hosts make it.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
    kept.replace(' ', "-")
}

#[test]
fn links_between_documents_resolve() {
    let (mut count, mut broken) = (0, Vec::new());
    for file in documents() {
        let text = std::fs::read_to_string(&file).unwrap();
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for link in links.filter(|link| !link.contains("://")) {
            let (path, heading) = link.split_once('#').map_or((link, None), |(path, heading)| (path, Some(heading)));
            let target = if path.is_empty() { file.clone() } else { file.parent().unwrap().join(path) };
            let found = match heading {
                None => target.exists(),
                Some(heading) => std::fs::read_to_string(&target).is_ok_and(|text| {
                    let headings = text.lines().filter_map(|line| line.trim_start_matches('#').strip_prefix(' '));
                    headings.map(anchor).any(|anchor| anchor == heading)
                }),
            };
            count += 1;
            if !found {
                broken.push(format!("{}: {link}", file.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(count > 80 || !workspace().join(".git").exists(), "{count} links");
}
