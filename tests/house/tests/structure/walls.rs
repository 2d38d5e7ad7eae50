//! The walls of the workspace: which crate may depend on which, and where code may be unsafe.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use hullmap_house::sources;
use hullmap_outside::{command::cargo, files::workspace};

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

/// Packages that `package` depends on, itself included, without packages for its tests; `more` are
/// words for `cargo tree`.
fn tree(package: &str, edges: &str, more: &[&str]) -> BTreeSet<String> {
    let words = ["tree", "--locked", "--prefix", "none", "--format", "{p}", "--package", package, "--edges", edges];
    let output = cargo(words.iter().chain(more));
    let text = String::from_utf8(output.stdout).unwrap();
    let names: BTreeSet<String> = text.lines().filter_map(|l| l.split_whitespace().next()).map(str::to_owned).collect();
    assert!(names.contains(package), "{text}");
    names
}

fn assert_unseen(package: &str, others: &[&str]) {
    assert_unseen_with(package, others, &[&[][..], &["--no-default-features"], &["--all-features"]]);
}

/// As [`assert_unseen`], for each list of further words in `features`.
fn assert_unseen_with(package: &str, others: &[&str], features: &[&[&str]]) {
    for more in features {
        let seen = tree(package, "normal,build", more);
        for other in others {
            assert!(!seen.contains(*other), "{package} {more:?} sees {other}: {seen:?}");
        }
    }
}

#[test]
fn the_runtime_depends_neither_on_the_baker_nor_on_its_libraries() {
    assert_unseen(
        "hullmap",
        &["parry3d", "parry3d-f64", "tobj", "clap", "hullmap-bake", "hullmap-cli", "shapes", "serde"],
    );
    assert!(!tree("hullmap", "normal,build", &[]).contains("rayon"), "only the feature starts threads");
}

#[test]
fn the_runtime_has_few_dependencies() {
    let seen = tree("hullmap", "normal,no-proc-macro", &["--all-features"]);
    println!("hullmap links {seen:?}");
    let strangers: Vec<&String> = seen.iter().filter(|name| !RUNTIME.contains(&name.as_str())).collect();
    assert!(strangers.is_empty(), "new in the runtime: {strangers:?}; is each worth it?");
    assert!(!tree("hullmap", "normal", &["--no-default-features"]).contains("memmap2"), "only the feature maps files");
}

#[test]
fn the_format_depends_neither_on_reader_nor_on_writer() {
    assert_unseen("hullmap-format", &["hullmap", "hullmap-bake", "hullmap-pipeline", "parry3d", "rayon", "memmap2"]);
}

#[test]
fn the_baker_depends_neither_on_the_runtime_nor_on_the_command_line() {
    assert_unseen(
        "hullmap-bake",
        &["hullmap", "hullmap-pipeline", "tobj", "clap", "indicatif", "memmap2", "serde_json"],
    );
    assert!(tree("hullmap-bake", "normal", &[]).contains("hullmap-format"));
}

/// `png` reads heights; `image` would decode textures.
#[test]
fn import_depends_on_neither_half_nor_on_the_command() {
    assert_unseen(
        "hullmap-import",
        &["hullmap", "hullmap-bake", "hullmap-cli", "indicatif", "memmap2", "image", "notify", "shapes"],
    );
    assert!(!tree("hullmap-import", "normal", &[]).contains("clap"), "only the feature adds flags");
}

#[test]
fn the_report_depends_neither_on_the_baker_nor_on_the_command() {
    assert_unseen(
        "hullmap-report",
        &["hullmap-bake", "hullmap-import", "hullmap-cli", "clap", "parry3d-f64", "tobj", "notify"],
    );
    let seen = tree("hullmap-report", "normal", &[]);
    assert!(seen.contains("hullmap") && seen.contains("hullmap-format"), "{seen:?}");
}

#[test]
fn the_adapter_depends_neither_on_the_baker_nor_on_an_engine() {
    assert_unseen_with(
        "hullmap-parry",
        &["hullmap-bake", "hullmap-import", "hullmap-cli", "rapier3d", "shapes", "clap"],
        &[&[][..], &["--no-default-features", "--features", "f64"], &["--all-features"]],
    );
    assert!(tree("hullmap-parry", "normal", &[]).contains("parry3d"));
    assert!(
        !tree("hullmap-parry", "normal", &[]).contains("parry3d-f64"),
        "only the feature adds the second precision"
    );
}

#[test]
fn the_c_interface_depends_on_the_runtime_alone() {
    assert_unseen(
        "hullmap-c",
        &["hullmap-bake", "hullmap-import", "hullmap-cli", "shapes", "clap", "serde", "parry3d"],
    );
    assert!(tree("hullmap-c", "normal", &[]).contains("hullmap"));
}

#[test]
fn the_decomposition_for_c_depends_on_the_baker_alone() {
    let others = ["hullmap", "hullmap-import", "hullmap-cli", "hullmap-c", "shapes", "clap", "serde", "parry3d"];
    assert_unseen("hullmap-decompose-c", &others);
    assert!(tree("hullmap-decompose-c", "normal", &[]).contains("hullmap-bake"));
}

#[test]
fn robot_descriptions_depend_neither_on_meshes_nor_on_the_command() {
    assert_unseen("hullmap-robot", &["hullmap", "hullmap-bake", "hullmap-format", "hullmap-import", "clap", "rayon"]);
    assert!(tree("hullmap-cli", "normal", &[]).contains("hullmap-robot"));
}

/// What is verified must not depend on how the command read options or wrote files.
#[test]
fn verification_depends_on_both_sides_and_not_on_the_command() {
    assert_unseen("hullmap-verify", &["hullmap-cli", "hullmap-report", "hullmap-robot", "clap", "parry3d", "tempfile"]);
    let seen = tree("hullmap-verify", "normal", &[]);
    for name in ["hullmap", "hullmap-bake", "hullmap-import"] {
        assert!(seen.contains(name), "{seen:?}");
    }
    for package in ["hullmap", "hullmap-bake", "hullmap-import"] {
        assert_unseen(package, &["hullmap-verify"]);
    }
}

/// Both halves may depend on it.
#[test]
fn geometry_depends_on_glam_alone() {
    let seen = tree("hullmap-geometry", "normal,build", &["--all-features"]);
    assert_eq!(seen, ["glam", "hullmap-geometry"].map(str::to_owned).into());
}

/// Whole robots are not in the runtime, and planners need no command.
#[test]
fn robots_for_planning_depend_on_the_runtime_and_not_on_the_command() {
    assert_unseen("hullmap-planning", &["hullmap-cli", "hullmap-report", "clap", "parry3d", "indicatif", "tempfile"]);
    let seen = tree("hullmap-planning", "normal", &[]);
    for name in ["hullmap", "hullmap-bake", "hullmap-import", "hullmap-robot"] {
        assert!(seen.contains(name), "{seen:?}");
    }
    assert_unseen("hullmap", &["hullmap-planning", "hullmap-robot"]);
}

/// Bindings bake by the pipeline, also in WebAssembly.
#[test]
fn the_pipeline_does_not_depend_on_the_command() {
    assert_unseen("hullmap-pipeline", &["hullmap-cli", "clap", "ctrlc", "hullmap-report", "indicatif", "notify"]);
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

/// Control for the tests above: the command depends on both sides.
#[test]
fn the_command_depends_on_both_sides() {
    let seen = tree("hullmap-cli", "normal", &[]);
    for name in ["hullmap", "hullmap-bake", "hullmap-format", "hullmap-report", "tobj", "clap"] {
        assert!(seen.contains(name), "{seen:?}");
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
        // The border to C: pointers come in.
        "crates/hullmap-c/src/border.rs",
        "crates/hullmap-c/src/exports/batch.rs",
        "crates/hullmap-c/src/exports/cache.rs",
        "crates/hullmap-c/src/exports/height_field.rs",
        "crates/hullmap-c/src/exports/manifold.rs",
        "crates/hullmap-c/src/exports/motion.rs",
        "crates/hullmap-c/src/exports/pack.rs",
        "crates/hullmap-c/src/exports/pose.rs",
        "crates/hullmap-c/src/exports/query.rs",
        "crates/hullmap-c/src/exports/shape.rs",
        "crates/hullmap-c/src/exports/sheet.rs",
        "crates/hullmap-c/src/exports/triangle_mesh.rs",
        "crates/hullmap-c/src/exports/version.rs",
        // Calls of the exported functions.
        "crates/hullmap-c/src/tests/batches.rs",
        "crates/hullmap-c/src/tests/facts.rs",
        "crates/hullmap-c/src/tests/lifetimes.rs",
        "crates/hullmap-c/src/tests/manifolds.rs",
        "crates/hullmap-c/src/tests/meshes.rs",
        "crates/hullmap-c/src/tests/misuse.rs",
        "crates/hullmap-c/src/tests/mod.rs",
        "crates/hullmap-c/src/tests/motions.rs",
        "crates/hullmap-c/src/tests/overhead.rs",
        "crates/hullmap-c/src/tests/pairs.rs",
        "crates/hullmap-c/src/tests/single.rs",
        "crates/hullmap-decompose-c/src/exports.rs",
        // Memory of a pack lent to NumPy.
        "crates/hullmap-python/src/memory.rs",
    ]
    .map(Path::new);
    // A test that maps files and writes to them.
    let tests = [Path::new("tests/tests/packs/live_mapping.rs")];
    assert_eq!(found, [&allowed[..], &tests].concat(), "of {} files", sources.len());
    assert!(sources.len() > 50);

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
    let allowing = sources.iter().filter(|path| text(path).contains(&format!("allow({lint})")));
    assert_eq!(allowing.collect::<Vec<_>>(), allowed);
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
const INEXACT: [&str; 31] = [
    "sin",
    "cos",
    "tan",
    "sin_cos",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "exp2",
    "exp_m1",
    "ln",
    "ln_1p",
    "log",
    "log2",
    "log10",
    "powf",
    "hypot",
    "cbrt",
    "from_axis_angle",
    "from_scaled_axis",
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "from_euler",
    "to_axis_angle",
    "slerp",
    "angle_between",
];

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
        for function in INEXACT {
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
