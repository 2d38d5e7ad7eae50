//! The walls of the workspace: which crate may depend on which, and where code may be unsafe.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use hullmap_house::sources;
use hullmap_testkit::{command::cargo, files::workspace};

/// All packages that the runtime with all its features brings into an engine, except macros that
/// run in the compiler.
const RUNTIME: [&str; 26] = [
    "hullmap",
    "hullmap-format",
    "glam",
    // Arrays with a length, in place of the heap.
    "arrayvec",
    "libc",
    "memmap2",
    // The archive, as slices.
    "bytecheck",
    "bytemuck",
    "hashbrown",
    "munge",
    "ptr_meta",
    "rancor",
    "rend",
    "rkyv",
    "self_cell",
    "simdutf8",
    // Sines with the same bits on all platforms.
    "libm",
    // Signs of areas and volumes without rounding: whether a point is inside a mesh.
    "robust",
    // Errors and checksums.
    "thiserror",
    "twox-hash",
    // Threads, with the feature `parallel` alone.
    "crossbeam-deque",
    "crossbeam-epoch",
    "crossbeam-utils",
    "either",
    "rayon",
    "rayon-core",
];

/// Packages that `package` depends on, itself included; `more` are words for `cargo tree`.
fn tree(package: &str, more: &[&str]) -> BTreeSet<String> {
    let words = ["tree", "--locked", "--prefix", "none", "--format", "{p}", "--package", package];
    let text = String::from_utf8(cargo(words.iter().chain(more)).stdout).unwrap();
    let names: BTreeSet<String> = text.lines().filter_map(|l| l.split_whitespace().next()).map(str::to_owned).collect();
    assert!(names.contains(package), "{text}");
    names
}

/// A package, words for `cargo tree`, packages that it must not bring, and packages that it brings.
type Wall = (&'static str, &'static str, &'static str, &'static str);

/// The walls. Without further words, they hold with the default features, without them, and with
/// all features.
const WALLS: [Wall; 18] = [
    ("hullmap", "", "parry3d parry3d-f64 tobj clap hullmap-bake hullmap-pipeline shapes serde hullmap-verify", ""),
    ("hullmap", "", "hullmap-planning hullmap-robot", "hullmap-format"),
    // Only features start threads and map files.
    ("hullmap", "--edges normal,build", "rayon", "memmap2"),
    ("hullmap", "--no-default-features", "memmap2", ""),
    ("hullmap-format", "", "hullmap hullmap-bake hullmap-pipeline parry3d rayon memmap2", ""),
    (
        "hullmap-bake",
        "",
        "hullmap hullmap-pipeline hullmap-verify tobj clap indicatif memmap2 serde_json",
        "hullmap-format",
    ),
    // `png` reads heights; `image` would decode textures.
    ("hullmap-import", "", "hullmap hullmap-bake hullmap-verify indicatif memmap2 image notify shapes", ""),
    ("hullmap-import", "--edges normal,build", "clap", "png"),
    (
        "hullmap-report",
        "",
        "hullmap-bake hullmap-import hullmap-cli clap parry3d-f64 tobj notify",
        "hullmap hullmap-format",
    ),
    // Only the feature adds the second precision.
    ("hullmap-parry", "--edges normal,build", "parry3d-f64", "parry3d"),
    ("hullmap-parry", "--all-features", "hullmap-bake hullmap-import hullmap-cli rapier3d shapes clap", ""),
    ("hullmap-c", "", "hullmap-bake hullmap-import hullmap-cli shapes clap serde parry3d", "hullmap"),
    (
        "hullmap-decompose-c",
        "",
        "hullmap hullmap-import hullmap-cli hullmap-c shapes clap serde parry3d",
        "hullmap-bake",
    ),
    ("hullmap-robot", "", "hullmap hullmap-bake hullmap-format hullmap-import clap rayon", ""),
    // Files are verified without the code that read options or wrote them.
    (
        "hullmap-verify",
        "",
        "hullmap-cli hullmap-report hullmap-robot clap parry3d tempfile",
        "hullmap hullmap-bake hullmap-import",
    ),
    // Planners need no command.
    (
        "hullmap-planning",
        "",
        "hullmap-cli hullmap-report clap parry3d indicatif tempfile",
        "hullmap hullmap-bake hullmap-import hullmap-robot",
    ),
    // Both halves may depend on it.
    ("hullmap-geometry", "", "hullmap hullmap-format hullmap-bake rayon serde", "glam"),
    // Bindings bake by the pipeline, also in WebAssembly.
    ("hullmap-pipeline", "", "hullmap-cli clap ctrlc hullmap-report indicatif notify", "hullmap-bake"),
];

#[test]
fn no_package_sees_another_over_a_wall() {
    let features = ["", "--no-default-features", "--all-features"];
    for (package, more, unseen, seen) in WALLS {
        for more in if more.is_empty() { &features[..] } else { std::slice::from_ref(&more) } {
            let more: Vec<&str> = more.split_whitespace().collect();
            let edges: &[&str] = if more.contains(&"--edges") { &[] } else { &["--edges", "normal,build"] };
            let found = tree(package, &[&more, edges].concat());
            for other in unseen.split_whitespace() {
                assert!(!found.contains(other), "{package} {more:?} sees {other}: {found:?}");
            }
            let missing = seen.split_whitespace().find(|other| !found.contains(*other));
            assert_eq!(missing, None, "{package} {more:?}: {found:?}");
        }
    }
    // Control for the table: the command depends on both sides.
    let found = tree("hullmap-cli", &["--edges", "normal"]);
    for name in ["hullmap", "hullmap-bake", "hullmap-format", "hullmap-report", "hullmap-robot", "tobj", "clap"] {
        assert!(found.contains(name), "{found:?}");
    }
}

#[test]
fn the_runtime_has_few_dependencies() {
    let seen = tree("hullmap", &["--edges", "normal,no-proc-macro", "--all-features"]);
    let strangers: Vec<&String> = seen.iter().filter(|name| !RUNTIME.contains(&name.as_str())).collect();
    assert!(strangers.is_empty(), "new in the runtime: {strangers:?}; is each worth it?");
}

/// Code that two commands share lies outside `commands/`.
#[test]
fn commands_do_not_import_from_each_other() {
    let commands = Path::new("crates/hullmap-cli/src/commands");
    let mut count = 0;
    for path in sources().iter().filter(|path| path.starts_with(commands)) {
        count += 1;
        let text = fs::read_to_string(workspace().join(path)).unwrap();
        assert!(!text.contains("commands::"), "{} imports from another command", path.display());
    }
    assert!(count >= 15, "{count}");
}

/// `cargo test` in a fresh clone compiles no engines.
#[test]
fn default_members_do_not_depend_on_engines() {
    let output = cargo(["tree", "--locked", "--prefix", "none", "--format", "{p}", "--edges", "normal,build,dev"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let seen: BTreeSet<&str> = text.lines().filter_map(|line| line.split_whitespace().next()).collect();
    for package in ["hullmap-format", "hullmap-bake", "hullmap-import", "hullmap", "hullmap-cli", "hullmap-tests"] {
        assert!(seen.contains(package), "{package}");
    }
    for package in ["parry3d", "parry3d-f64", "rapier3d", "pyo3"] {
        assert!(!seen.contains(package), "{package}");
    }
}

/// Whether `text` uses the word as code: not within a longer word, nor in a comment that has a line
/// of its own.
fn uses(text: &str, word: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .any(|line| line.split(|c| !is_word(c)).any(|found| found == word))
}

#[test]
fn unsafe_code_is_in_few_files() {
    // In two parts, so that this file does not match.
    let (word, lint) = (concat!("un", "safe"), concat!("un", "safe_code"));
    let sources = sources();
    let text = |path: &PathBuf| fs::read_to_string(workspace().join(path)).unwrap();
    let found: Vec<&PathBuf> = sources.iter().filter(|path| uses(&text(path), word)).collect();
    let allowed = [
        "crates/hullmap/src/file/map.rs",
        "crates/hullmap/src/pack/map.rs",
        "crates/hullmap/src/support/simd/avx2.rs",
        "crates/hullmap/src/triangle_mesh/map.rs",
        // The border to C: pointers come in, and tests call the exported functions.
        "crates/hullmap-c/src/border.rs",
        "crates/hullmap-c/src/exports",
        "crates/hullmap-c/src/tests",
        "crates/hullmap-decompose-c/src/exports.rs",
        // Memory of a pack lent to NumPy.
        "crates/hullmap-python/src/memory.rs",
    ];
    // A test that maps files and writes to them.
    let tests = "tests/tests/packs/live_mapping.rs";
    let is_in = |path: &PathBuf, places: &[&str]| places.iter().any(|place| path.starts_with(place));
    let strangers: Vec<_> = found.iter().filter(|path| !is_in(path, &allowed) && !path.ends_with(tests)).collect();
    assert!(strangers.is_empty(), "{strangers:?} of {} files", sources.len());
    let unused = allowed.iter().find(|place| !found.iter().any(|path| path.starts_with(place)));
    assert!(sources.len() > 50 && unused.is_none(), "{unused:?}");

    // Every crate root except in tests also has the lint.
    let roots: Vec<&PathBuf> = sources
        .iter()
        .filter(|path| ["lib.rs", "main.rs"].iter().any(|root| path.ends_with(Path::new("src").join(root))))
        .filter(|path| !path.starts_with("tests"))
        .collect();
    assert!(roots.len() >= 5, "{roots:?}");
    for root in roots {
        let denies = ["crates/hullmap", "crates/hullmap-c", "crates/hullmap-decompose-c", "crates/hullmap-python"]
            .iter()
            .any(|package| root.starts_with(package));
        let level = if denies { "deny" } else { "forbid" };
        assert!(text(root).contains(&format!("#![{level}({lint})]")), "{}: no {level}({lint})", root.display());
    }
    let mut allowing = sources.iter().filter(|path| text(path).contains(&format!("allow({lint})")));
    assert_eq!(allowing.find(|path| !is_in(path, &allowed)), None);
}

/// Crates that read files never unwrap, and justify each indexing expression.
#[test]
fn crates_that_read_files_justify_their_indexing() {
    let deny = "#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing))]";
    let sources = sources();
    let text = |path: &Path| fs::read_to_string(workspace().join(path)).unwrap();
    for name in ["hullmap", "hullmap-c", "hullmap-format", "hullmap-import"] {
        let folder = Path::new("crates").join(name).join("src");
        let root = folder.join("lib.rs");
        assert!(text(&root).lines().any(|line| line == deny), "{}: no {deny}", root.display());

        // Two modules of the runtime only compute. No other file may allow these lints without a
        // checked reason.
        let code = text(&root);
        let pairs = code.lines().zip(code.lines().skip(1));
        let allowed: Vec<&str> = pairs.filter(|(line, _)| allows(line)).map(|(_, module)| module).collect();
        let expected: &[&str] = if name == "hullmap" { &["pub mod manifold;", "pub mod solver;"] } else { &[] };
        assert_eq!(allowed, expected, "{}", root.display());
        let others = sources.iter().filter(|path| path.starts_with(&folder) && **path != root);
        let others: Vec<_> = others.filter(|path| text(path).lines().any(allows)).collect();
        assert!(others.is_empty(), "{others:?}: expect it with a reason");
    }
}

/// Whether a line switches one of the three lints off.
fn allows(line: &str) -> bool {
    let lints = ["clippy::unwrap_used", "clippy::expect_used", "clippy::indexing_slicing", "clippy::restriction"];
    line.contains("allow(") && lints.iter().any(|lint| line.contains(lint))
}

/// Methods that libraries and machines compute with different last digits: the platform's own
/// functions, and functions of glam that use them. Roots, sums and products are exact everywhere;
/// `mul_add` is too.
const INEXACT: &str = "sin cos tan sin_cos asin acos atan atan2 sinh cosh tanh exp exp2 exp_m1 ln ln_1p log log2 \
    log10 powf hypot cbrt from_axis_angle from_scaled_axis from_rotation_x from_rotation_y \
    from_rotation_z from_euler to_axis_angle slerp angle_between";

/// Code before a file's own tests, without comments.
fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Whether `code` calls the function, as a method or by its type. The functions of libm do not
/// count: they are the same everywhere.
fn calls(code: &str, function: &str) -> bool {
    [format!(".{function}("), format!("::{function}(")]
        .iter()
        .any(|call| code.match_indices(call.as_str()).any(|(at, _)| !code[..at].ends_with("libm")))
}

/// All text is printed through `terminal.rs`, which escapes every line.
#[test]
fn text_is_printed_by_one_file() {
    let exits =
        ["print!", "println!", "eprint!", "eprintln!", "dbg!", "stdout()", "stderr()", "dyn Write", "io::Stdout"];
    let folders = ["cli", "pipeline", "report", "import"].map(|name| format!("crates/hullmap-{name}/src"));
    let is_test = |path: &Path| path.ends_with("tests.rs") || path.iter().any(|folder| folder == "tests");
    let mut count = 0;
    for path in sources().iter().filter(|path| folders.iter().any(|folder| path.starts_with(folder))) {
        if is_test(path) {
            continue;
        }
        count += 1;
        let text = fs::read_to_string(workspace().join(path)).unwrap();
        let code = || text.lines().take_while(|line| !line.starts_with("mod tests"));
        let uses = |exit: &&str| code().any(|line| line.contains(*exit) && !line.trim_start().starts_with("//"));
        let found: Vec<&str> = exits.into_iter().filter(uses).collect();
        let is_terminal = path.ends_with("hullmap-cli/src/terminal.rs");
        let expected: &[&str] = if is_terminal { &["stdout()", "stderr()", "dyn Write"] } else { &[] };
        assert_eq!(found, expected, "{} prints; use terminal::Output or terminal::say", path.display());
    }
    assert!(count > 60, "{count} files");
}

/// Baked bytes and answers are the same on every machine.
#[test]
fn hashed_code_calls_no_platform_function() {
    let sources = sources();
    let hashed = |path: &&PathBuf| {
        [
            "crates/hullmap/src",
            "crates/hullmap-bake/src",
            "crates/hullmap-format/src",
            "crates/hullmap-random/src",
            "tools/shapes/src",
            "tests/golden/src",
        ]
        .iter()
        .any(|folder| path.starts_with(folder))
    };
    let hashed: Vec<&PathBuf> = sources.iter().filter(hashed).collect();
    assert!(hashed.len() > 40, "{}", hashed.len());
    for path in hashed {
        let code = code(&fs::read_to_string(workspace().join(path)).unwrap());
        for function in INEXACT.split(' ') {
            assert!(!calls(&code, function), "{} calls {function}: take libm's, or a root", path.display());
        }
        // The precision of `powi` is unspecified too. The baker only squares by it, which is exact.
        let is_baker = path.starts_with("crates/hullmap-bake");
        assert!(is_baker || !calls(&code, "powi"), "{} calls powi", path.display());
    }
}

#[test]
fn calls_of_inexact_functions_are_found() {
    assert!(calls(&code("let x = y.sin();"), "sin") && calls(&code("DQuat::from_rotation_x(1.0)"), "from_rotation_x"));
    assert!(!calls(&code("libm::sin(y)"), "sin") && !calls(&code("y.sinister()"), "sin"));
    assert!(!calls(&code("// y.sin()\n#[cfg(test)]\ny.sin()"), "sin"));
}

#[test]
fn words_in_comments_and_longer_words_do_not_count() {
    assert!(uses("let x = 1;\n  odd { f() }", "odd"));
    assert!(!uses("// odd\n  /// odd { }\nodd_code, very_odd", "odd"));
}
