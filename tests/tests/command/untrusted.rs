//! Untrusted packs and names: packs that claim another source, and text that the command must not
//! print.

use std::fs;
use std::path::Path;

use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::header::{HEADER_LEN, Header, source_hash};
use hullmap_testkit::command::{bake_in, bake_line as bake};
use hullmap_testkit::files::folder;
use hullmap_testkit::packs::{self, point_set};

const CUBE: &str = "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

/// Writes the pack of a tetrahedron of this height that claims the source `in/x.obj`, [`CUBE`].
fn write_tetrahedron(path: &Path, height: f32, warnings: Vec<String>) {
    let options = "split none, vertices referenced, index tree 8".to_owned();
    let record = SourceRecord { path: "../in/x.obj".to_owned(), hash: source_hash(CUBE.as_bytes()), options, warnings };
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]];
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, packs::bytes(&[point_set("x", &corners)], IndexKind::Tree, &record).unwrap()).unwrap();
}

/// Everything that a terminal obeys instead of showing it, in one name.
const NAME: &str = "x\x1b[2J\x1b]0;t\x07\r\n9 forged\u{9b}31m\u{202e}\u{2066}\u{200f}\u{2028}é漢";

/// [`NAME`] in one harmless line.
const ESCAPED: &str =
    "x\\u{1b}[2J\\u{1b}]0;t\\u{7}\\u{d}\\u{a}9 forged\\u{9b}31m\\u{202e}\\u{2066}\\u{200f}\\u{2028}é漢";

#[track_caller]
fn assert_harmless(text: &str) {
    let obeyed = |letter: &char| {
        letter.is_control() && *letter != '\n'
            || ['\u{202e}', '\u{2066}', '\u{200f}', '\u{2028}', '\u{2029}'].contains(letter)
    };
    assert_eq!(text.chars().find(obeyed), None, "{text:?}");
    assert!(!text.lines().any(|line| line.starts_with("9 forged")), "a forged row: {text:?}");
}

/// Names of files, objects and hulls reached the terminal as they were.
#[test]
fn names_cannot_control_the_terminal() {
    let folder = folder(&[]);
    let words = |line: &str| -> Vec<String> { line.split(' ').map(|word| word.replace("NAME", NAME)).collect() };
    let obj =
        CUBE.replacen("o cube", "o hull\x1b[31m\u{202e}", 1) + "o flat\u{9b}\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 5 6 7\n";
    fs::create_dir_all(folder.path().join("in")).unwrap();
    fs::write(folder.path().join("in").join(format!("{NAME}.obj")), obj).unwrap();
    fs::write(folder.path().join("in").join(format!("{NAME}2.obj")), "v 0 0\n").unwrap();
    fs::write(folder.path().join("in").join(format!("{NAME}.gltf")), "{}").unwrap();
    fs::write(folder.path().join("poses"), "0 0 0 0 0 0 1\n").unwrap();
    let mut seen = 0;
    for line in [
        "build in --out o --split object",
        "build in --out o --split object --check",
        "build in/NAME.obj in/NAME2.obj --out p --split object --verbose",
        "build in/NAME.obj --out p --split object --verbose --verify",
        "build gone/NAME --out p",
        "build in/NAME2.obj --out p/NAME.hullmap",
        "build in --out o --NAME",
        "build in --out o --set index=NAME",
        "build in --out o --config NAME",
        "build in/NAME.obj --out p --depfile deps",
        "inspect p",
        "inspect in/NAME.obj",
        "verify p",
        "verify p --source in/NAME2.obj",
        "verify p --source NAME",
        "query p/NAME.hullmap p/NAME.hullmap",
        "query p/NAME.hullmap#NAME p/NAME.hullmap",
        "query p/NAME.hullmap p/NAME.hullmap --pose NAME",
        "query p/NAME.hullmap p/NAME.hullmap --poses NAME",
        "report p --out NAME.html",
        "report p/NAME.hullmap --out page.html --source NAME",
        "init NAME",
    ] {
        let run = bake_in(folder.path(), words(line));
        assert_harmless(&run.stdout);
        assert_harmless(&run.stderr);
        seen += usize::from(run.stdout.contains(ESCAPED)) + usize::from(run.stderr.contains(ESCAPED));
    }
    assert!(seen >= 20, "{seen} outputs with the name");
    // An orphan, whose name comes from a pack.
    fs::remove_file(folder.path().join("in").join(format!("{NAME}.obj"))).unwrap();
    for line in ["build in --out p", "build in --out p --prune"] {
        let run = bake_in(folder.path(), words(line));
        assert_harmless(&(run.stdout + &run.stderr));
    }
}

#[test]
fn json_keeps_every_character() {
    let folder = folder(&[]);
    fs::write(folder.path().join(format!("{NAME}.obj")), CUBE).unwrap();
    for line in ["build . --out . --json", "inspect . --json", "verify . --json"] {
        let row = bake_in(folder.path(), line.split(' ')).expect(0).json().remove(0);
        let file = row["output"].as_str().or(row["file"].as_str()).unwrap();
        assert_eq!(Path::new(file), Path::new("./").join(format!("{NAME}.hullmap")), "{line}");
    }
}

/// A pack of another mesh that records the right source passes `--check`, and `verify` rejects it.
#[test]
fn a_forged_pack_can_be_fresh() {
    let folder = folder(&[("in/x.obj", CUBE)]);
    write_tetrahedron(&folder.path().join("o/x.hullmap"), 1.5, Vec::new());
    for (line, code) in [("build in --out o --check", 0), ("verify o", 1), ("build in --out o --verify", 1)] {
        bake(&folder, line).expect(code);
    }
}

/// Recorded warnings are bounded, and forge no line.
#[test]
fn untrusted_warnings_do_no_harm() {
    let folder = folder(&[("in/x.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    for (warnings, count) in [(vec!["a\nb\u{1b}[2J".to_owned()], 1), (vec!["x".repeat(20_000); 200], 100)] {
        write_tetrahedron(&folder.path().join("o/x.hullmap"), 1.0, warnings);
        let run = bake(&folder, "build in --out o --json").expect(0);
        assert_eq!(run.json()[0]["status"], "fresh");
        assert_eq!(run.json()[0]["warnings"].as_array().unwrap().len(), count);
        assert_eq!(run.stderr.lines().count(), count);
        assert!(run.stderr.len() < 2_000_000 && !run.stderr.contains('\u{1b}'), "{}", run.stderr.len());
    }
}

/// An entry of a cache with the right header and a correct checksum, but the hull of another mesh.
#[test]
fn an_entry_of_another_mesh_fails_its_verification() {
    let mesh = |height: u8| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {height}\n");
    let folder = folder(&[("in/0.obj", &mesh(1)), ("in/3.obj", &mesh(4))]);
    let build = "build in --out o --cache cache --json --force";
    let rows = bake(&folder, "farm key in --out o --json").expect(0).json();
    bake(&folder, build).expect(0);
    let entry = |row: usize| {
        let key = rows[row]["key"].as_str().unwrap();
        folder.path().join(format!("cache/{}/{key}.hullmap", &key[..2]))
    };
    let [honest, mut other] = [0, 1].map(|row| fs::read(entry(row)).unwrap());
    // The recorded path has the same length.
    let at = other.windows(5).position(|window| window == b"3.obj").unwrap();
    other[at] = b'0';
    let right = Header::read(&honest).unwrap();
    let header = Header::for_payload(right.source_hash, right.options_hash, &other[HEADER_LEN..]);
    other[..HEADER_LEN].copy_from_slice(&header.to_bytes());
    fs::write(entry(0), other).unwrap();
    fs::remove_dir_all(folder.path().join("o")).unwrap();
    let run = bake(&folder, "build in --out o --cache cache --json --verify").expect(0);
    let origins: Vec<String> = run.json().iter().map(|row| row["origin"].to_string()).collect();
    assert_eq!(origins, ["\"local\"", "\"cache\""], "{}", run.stderr);
    assert!(run.stderr.contains("verification failed"), "{}", run.stderr);
    assert_eq!(fs::read(entry(0)).unwrap(), honest);
    assert_eq!(fs::read(folder.path().join("o/0.hullmap")).unwrap(), honest);
}
