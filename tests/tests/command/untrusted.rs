//! Untrusted packs: packs that claim another source, and warnings that the command must not print.
//! `tests/cases/untrusted.md` has files and names.

use std::fs;
use std::path::Path;

use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::header::{HEADER_LEN, Header, source_hash};
use hullmap_testkit::command::bake_line as bake;
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
