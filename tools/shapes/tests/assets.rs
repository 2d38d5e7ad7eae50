//! The committed files equal the generated ones, and `make-assets` reports differences.

use shapes::assets::{self, Difference};
use shapes::models;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn committed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

/// An empty folder of the test's own, under Cargo's folder for that.
fn scratch(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if dir.exists() {
        fs::remove_dir_all(&dir).unwrap();
    }
    fs::create_dir_all(&dir).unwrap();
    dir
}

fn make_assets(args: &[&str], dir: Option<&Path>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_make-assets"));
    command.args(args).args(dir).output().unwrap()
}

#[test]
fn committed_files_are_the_generated_ones() {
    let differences = assets::compare(&committed()).unwrap();
    assert!(differences.is_empty(), "run `cargo run -p shapes --bin make-assets -- assets`: {differences:?}");
}

#[test]
fn generating_twice_gives_the_same_bytes() {
    assert_eq!(assets::generate(), assets::generate());
}

/// A plain reader of `v` lines, as the slow twin of the writer.
#[test]
fn committed_vertices_read_back_to_the_same_bits() {
    for model in models::all() {
        let text = fs::read_to_string(committed().join(model.file_name)).unwrap();
        let read: Vec<[u32; 3]> = text
            .lines()
            .filter_map(|line| line.strip_prefix("v "))
            .map(|numbers| {
                let mut bits = numbers.split_whitespace().map(|number| number.parse::<f32>().unwrap().to_bits());
                core::array::from_fn(|_| bits.next().unwrap())
            })
            .collect();
        let made: Vec<[u32; 3]> = model
            .document
            .objects
            .iter()
            .flat_map(|object| object.mesh().vertices)
            .map(|vertex| vertex.map(f32::to_bits))
            .collect();
        assert_eq!(read, made, "{}", model.file_name);
    }
}

#[test]
fn differences_are_named_by_kind() {
    let dir = scratch("differences");
    assert_eq!(assets::write(&dir).unwrap().len(), assets::generate().len());
    assert_eq!(assets::compare(&dir).unwrap(), []);
    assert!(assets::write(&dir).unwrap().is_empty());

    let cube = fs::read_to_string(dir.join("cube.obj")).unwrap();
    fs::write(dir.join("cube.obj"), cube.replacen("v -1", "v -2", 1)).unwrap();
    fs::remove_file(dir.join("gear.obj")).unwrap();
    fs::write(dir.join("stray.obj"), "v 0 0 0\n").unwrap();
    let line = cube.lines().position(|l| l.starts_with("v ")).unwrap() + 1;
    let expected = [
        ("cube.obj".to_owned(), Difference::Changed { line }),
        ("gear.obj".to_owned(), Difference::Missing),
        ("stray.obj".to_owned(), Difference::Unexpected),
    ];
    assert_eq!(assets::compare(&dir).unwrap(), expected);

    assert_eq!(assets::write(&dir).unwrap(), ["cube.obj", "gear.obj"]);
    assert!(dir.join("stray.obj").exists(), "only the owner deletes files");
}

#[test]
fn check_exits_1_and_names_the_file() {
    let dir = scratch("check");
    let wrote = make_assets(&[], Some(&dir));
    assert_eq!(wrote.status.code(), Some(0));
    assert!(wrote.stdout.is_empty());

    let good = make_assets(&["--check"], Some(&dir));
    assert_eq!(good.status.code(), Some(0));
    assert!(good.stdout.is_empty());

    fs::write(dir.join("lens.obj"), "# blank\n").unwrap();
    let bad = make_assets(&["--check"], Some(&dir));
    assert_eq!(bad.status.code(), Some(1));
    let names = String::from_utf8(bad.stdout).unwrap();
    assert_eq!(names.lines().count(), 1, "{names}");
    assert!(names.contains("lens.obj: differs from line 1 on"), "{names}");
}

#[test]
fn wrong_usage_and_missing_folders_exit_2() {
    let missing = scratch("missing").join("nowhere");
    let cases = [
        (make_assets(&[], None), "missing argument DIR"),
        (make_assets(&["--czech", "x"], None), "unknown option --czech"),
        (make_assets(&["x", "y"], None), "unexpected argument y"),
        (make_assets(&["--check"], Some(&missing)), "nowhere"),
    ];
    for (output, message) in cases {
        assert_eq!(output.status.code(), Some(2), "{message}");
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(errors.contains(message), "{errors}");
    }
    let help = make_assets(&["--help"], None);
    assert_eq!(help.status.code(), Some(0));
    assert!(String::from_utf8(help.stdout).unwrap().starts_with("Usage"));
}
