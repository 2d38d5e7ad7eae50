//! `bake build` as part of a project: damaged packs, depfiles as Make and Ninja read them, and
//! folders without permission.

use std::{fs, process::Command};

use hullmap_outside::command::{bake_line as bake, binary};
use hullmap_outside::files::{folder, write};
use tempfile::TempDir;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// Every byte of a pack counts: if any byte is damaged, the pack is stale.
#[test]
fn no_damaged_pack_passes_as_fresh() {
    let folder = folder(&[("in/a.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    let path = folder.path().join("o/a.hullmap");
    let good = fs::read(&path).unwrap();
    let offsets: Vec<usize> = (0..64).chain((64..good.len()).step_by(41)).collect();
    for &offset in &offsets {
        let mut bad = good.clone();
        bad[offset] ^= 1 << (offset % 8);
        fs::write(&path, bad).unwrap();
        let run = bake(&folder, "build in --out o --check --json").expect(1);
        assert_eq!(run.json()[0]["status"], "stale", "byte {offset}");
    }
    for bad in [&good[..good.len() - 1], &good[..64], &good[..7], &[]] {
        fs::write(&path, bad).unwrap();
        bake(&folder, "build in --out o --check").expect(1);
    }
    bake(&folder, "build in --out o").expect(0);
    assert_eq!(fs::read(&path).unwrap(), good);
}

/// Whether a program can be started. Prints a message if it cannot.
fn has(program: &str) -> bool {
    let is_there = Command::new(program).arg("--version").output().is_ok();
    if !is_there {
        println!("skipped: there is no {program} here");
    }
    is_there
}

/// Names with all characters that are special in Make and Ninja.
const NAMES: [&str; 5] = ["plain.obj", "with space.obj", "hash#tag.obj", "cash$.obj", "12:30.obj"];

fn project_with_odd_names() -> TempDir {
    let folder = folder(&[("in/hullmap.toml", "[defaults]\nindex = \"none\"\n")]);
    for name in NAMES {
        write(&folder, &format!("in/{name}"), CUBE);
    }
    folder
}

/// Make reads the depfile. A changed mesh or a changed `hullmap.toml` triggers the rule, nothing
/// else does, and a removed mesh is not an error.
#[test]
fn make_understands_the_depfile() {
    if !has("make") {
        return;
    }
    let folder = project_with_odd_names();
    let bake = binary().display();
    let rule = format!(
        "o/stamp:\n\t{bake} build in --out o --quiet --depfile o.d --depfile-target o/stamp && touch o/stamp\n-include o.d\n"
    );
    write(&folder, "Makefile", &rule);
    let make = || {
        let run = Command::new("make").current_dir(folder.path()).output().unwrap();
        let output = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success(), "{output}");
        !output.contains("up to date")
    };
    assert!(make() && !make());
    let date = |name: &str, seconds: i64| {
        let now = std::time::SystemTime::now();
        let age = std::time::Duration::from_secs(seconds.unsigned_abs());
        let file = fs::File::options().write(true).open(folder.path().join(name)).unwrap();
        file.set_modified(if seconds < 0 { now - age } else { now + age }).unwrap();
    };
    for name in NAMES.map(|name| format!("in/{name}")).iter().map(String::as_str).chain(["in/hullmap.toml"]) {
        // Seconds apart, for file systems with coarse time stamps.
        date(name, 5);
        assert!(make(), "{name}");
        date(name, -60);
        date("o/stamp", 5);
        assert!(!make(), "{name}");
        date("o/stamp", -1);
    }
    fs::remove_file(folder.path().join("in/with space.obj")).unwrap();
    make();
    // A new mesh in a folder that had none. The clock of a file system has steps of milliseconds.
    let wait = || std::thread::sleep(std::time::Duration::from_millis(20));
    wait();
    fs::create_dir(folder.path().join("in/later")).unwrap();
    assert!(make() && !make());
    wait();
    write(&folder, "in/later/new.obj", CUBE);
    assert!(make() && !make());
    assert!(folder.path().join("o/later/new.hullmap").exists());
}

#[test]
fn ninja_understands_the_depfile() {
    if !has("ninja") {
        return;
    }
    let folder = project_with_odd_names();
    let bake = binary().display().to_string().replace('$', "$$").replace(' ', "$ ");
    let rules = format!(
        "rule bake\n  command = {bake} build in --out o --quiet --depfile $out.d --depfile-target $out && touch $out\n  \
         depfile = $out.d\nbuild stamp: bake\n"
    );
    write(&folder, "build.ninja", &rules);
    let ninja = || {
        let run = Command::new("ninja").current_dir(folder.path()).output().unwrap();
        let output = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success(), "{output}");
        !output.contains("no work to do")
    };
    assert!(ninja() && !ninja());
    for name in NAMES.map(|name| format!("in/{name}")).iter().map(String::as_str).chain(["in/hullmap.toml"]) {
        std::thread::sleep(std::time::Duration::from_millis(20));
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        write(&folder, name, &text);
        assert!(ninja(), "{name}");
        assert!(!ninja(), "{name}");
    }
    fs::remove_file(folder.path().join("in/with space.obj")).unwrap();
    assert!(ninja());
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_reported() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder(&[("in/a.obj", CUBE), ("o/x", "")]);
    let out = folder.path().join("o");
    fs::set_permissions(&out, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(out.join("probe"), "").is_ok() {
        println!("skipped: this user may write anywhere");
        return;
    }
    let run = bake(&folder, "build in --out o").expect(2);
    assert!(run.stderr.contains("o/a.hullmap: cannot write: Permission denied"), "{}", run.stderr);
    fs::set_permissions(&out, fs::Permissions::from_mode(0o755)).unwrap();
    let source = folder.path().join("in/a.obj");
    fs::set_permissions(&source, fs::Permissions::from_mode(0o000)).unwrap();
    let run = bake(&folder, "build in --out o").expect(2);
    assert!(run.stderr.contains("in/a.obj: cannot read: Permission denied"), "{}", run.stderr);
}
