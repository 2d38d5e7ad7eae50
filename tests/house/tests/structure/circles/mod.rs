//! No circular dependencies between source files: no file uses another that uses it in turn,
//! directly or through others. Then each can be read and tested after the files that it uses. Tests
//! inside a file do not count.

mod graph;
mod rust;
mod scripts;

use std::fs;
use std::path::{Path, PathBuf};

use hullmap_house::tracked;
use hullmap_testkit::files::workspace;

use graph::{Graph, Sources};

fn graph(sources: &Sources) -> Graph {
    let mut graph = Graph::default();
    rust::add_edges(sources, &mut graph);
    scripts::add_edges(sources, &mut graph);
    graph
}

/// The module of the baker, directly below its root, that a file belongs to. The root re-exports.
fn module_of_baker(file: &Path) -> Option<PathBuf> {
    let below = file.strip_prefix("crates/hullmap-bake/src").ok()?.with_extension("");
    below.iter().next().filter(|module| *module != "lib").map(PathBuf::from)
}

/// In the baker, modules do, too: each can be read after those below it.
#[test]
fn files_import_in_one_direction() {
    let files = tracked();
    if files.is_empty() && !workspace().join(".git").exists() {
        println!("skipped: files_import_in_one_direction: this is not a git checkout");
        return;
    }
    let is_source = |file: &&String| [".rs", ".py", ".pyi", ".js", ".mjs"].iter().any(|ending| file.ends_with(ending));
    let text = |file: &String| fs::read_to_string(workspace().join(file)).expect("a tracked file can be read");
    let sources = files.iter().filter(is_source).map(|file| (file.into(), text(file))).collect();
    let graph = graph(&sources);
    assert!(graph.edge_count() > 1000, "only {} edges", graph.edge_count());
    let baker = graph.grouped(module_of_baker);
    assert!(baker.edge_count() > 50, "only {} edges in the baker", baker.edge_count());
    let circles = [graph.circles(), baker.circles()].concat();
    assert!(circles.is_empty(), "move what both sides need to a file below them:\n{}", circles.join("\n"));
}

/// The circles of files with these paths and texts.
fn circles(files: &[(&str, &str)]) -> Vec<String> {
    graph(&files.iter().map(|(file, text)| (file.into(), (*text).to_owned())).collect()).circles()
}

#[test]
fn circles_of_rust_files_are_found() {
    let root = ("src/lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::*;");
    let a = |text| ("src/a.rs", text);
    for (uses_b, uses_a) in [
        ("use crate::b::B; pub struct A(B);", "use super::a::A; pub struct B(A);"),
        // Through re-exports, by a name of its own, and in a group.
        ("use crate::{B as Other}; pub struct A(Other);", "use crate::{A}; pub struct B(A);"),
        // In place, in a macro, in an attribute, and by a module.
        ("pub struct A(crate::b::B);", "use super::a; pub struct B(a::A);"),
        ("pub fn A() { assert!(crate::b::B() > 0) }", "#[error(\"{}\", crate::a::A)] pub fn B() {}"),
        // A block in a file.
        ("pub mod inner { use super::super::b::B; } pub struct A;", "use crate::a::A; pub struct B;"),
    ] {
        let found = circles(&[root, a(uses_b), ("src/b.rs", uses_a)]);
        assert_eq!(found.len(), 1, "{uses_b} {uses_a}");
        assert!(found[0].contains("a circle of 2 files") && found[0].contains("src/b.rs -> src/a.rs"), "{found:?}");
    }
    // Parent and child, and three files.
    let child = ("src/a/c.rs", "use super::A; pub struct C(A);");
    assert_eq!(circles(&[("src/lib.rs", "mod a;"), a("mod c; use c::C; pub struct A(C);"), child]).len(), 1);
    let root = ("src/main.rs", "mod a; mod b; mod c;");
    let files = [a("use crate::b::B; pub struct A;"), ("src/b.rs", "use crate::c::C; pub struct B;")];
    let found = circles(&[root, files[0], files[1], ("src/c.rs", "fn c() { crate::a::A; } pub struct C;")]);
    assert!(found.len() == 1 && found[0].contains("a circle of 3 files"), "{found:?}");
    // A module beside it, which re-exports the item and uses it.
    let parent = ("src/a/mod.rs", "mod c; pub use c::C; use crate::b::B; pub struct A(B);");
    let files = [parent, ("src/a/c.rs", "pub struct C;"), ("src/b.rs", "use crate::a::C; pub struct B(C);")];
    let found = circles(&[("src/lib.rs", "mod a; mod b;"), files[0], files[1], files[2]]);
    assert!(found.len() == 1 && found[0].contains("a circle of 2 files"), "{found:?}");
}

#[test]
fn re_exports_tests_and_texts_are_no_circles() {
    let child = ("src/a/c.rs", "use super::A; pub struct C(A);");
    for parent in [
        "mod c; pub use c::C; pub struct A;",
        "mod c; /// [`c::C`]\n// c::C\npub struct A(\"c::C\");",
        "mod c; #[cfg(test)] mod tests { use super::c::C; } #[cfg(test)] fn f() { c::C; } pub struct A;",
        "mod c; pub struct A; fn f(x: X) { x.C; other::c::C; ::c::C; }",
    ] {
        assert_eq!(circles(&[("src/lib.rs", "mod a;"), ("src/a.rs", parent), child]), [""; 0], "{parent}");
    }
    // The same names in another crate, and a file of tests.
    let other = [("other/src/lib.rs", "mod b; pub struct A;"), ("other/src/b.rs", "use crate::A; pub struct B;")];
    let tests = ("src/tests.rs", "use super::*; fn f(a: A) {}");
    let root = ("src/lib.rs", "pub struct A; use other::b::B; #[cfg(test)] mod tests;");
    assert_eq!(circles(&[root, tests, other[0], other[1]]), [""; 0]);
}

#[test]
fn circles_of_scripts_are_found() {
    for (uses_b, uses_a) in [
        ("from .b import B", "from . import a"),
        ("from .b import (\n    B,\n    C,\n)", "def f():\n    from ..pack.a import A"),
        ("import pack.b", "from pack import (\n    a,\n)"),
    ] {
        assert_eq!(circles(&[("x/pack/a.py", uses_b), ("x/pack/b.py", uses_a)]).len(), 1, "{uses_b} {uses_a}");
    }
    for (uses_b, uses_a) in [
        ("import { b } from \"./b.js\";", "import {\n  a,\n} from '../page/a.js';"),
        ("import \"./b.js\";", "const a = await import(\"./a.js\");"),
    ] {
        assert_eq!(circles(&[("page/a.js", uses_b), ("page/b.js", uses_a)]).len(), 1, "{uses_b} {uses_a}");
    }
    assert_eq!(circles(&[("a.py", "import b\n# import a"), ("b.py", "text = 'import a'")]), [""; 0]);
    assert_eq!(circles(&[("a.js", "import \"./b.js\""), ("b.js", "new URL(\"./a.js\", import.meta.url)")]), [""; 0]);
}
