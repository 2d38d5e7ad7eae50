//! Make and Ninja read depfiles: a changed mesh or a changed `hullmap.toml` triggers the rule,
//! nothing else does, and a removed mesh is not an error.

use std::fs;
use std::process::Command;
use std::time::Duration;

use hullmap_testkit::command::binary;
use hullmap_testkit::files::{folder, write};

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// Names with all characters that are special in Make and Ninja.
const NAMES: [&str; 5] = ["plain.obj", "with space.obj", "hash#tag.obj", "cash$.obj", "12:30.obj"];

/// Runs `program` in a folder whose `rules` build a stamp. Skipped if there is no such program.
/// `idle` is what it prints if there is nothing to do.
fn understands_the_depfile(program: &str, (rules, text): (&str, String), idle: &str) {
    if Command::new(program).arg("--version").output().is_err() {
        println!("skipped: there is no {program} here");
        return;
    }
    let folder = folder(&[("in/hullmap.toml", "[defaults]\nindex = \"none\"\n"), (rules, &text), ("o/x", "")]);
    NAMES.iter().for_each(|name| write(&folder, &format!("in/{name}"), CUBE));
    let builds = || {
        let run = Command::new(program).current_dir(folder.path()).output().unwrap();
        let output = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success(), "{output}");
        !output.contains(idle)
    };
    assert!(builds() && !builds());
    // The clock of a file system has steps of milliseconds.
    let wait = || std::thread::sleep(Duration::from_millis(20));
    for name in NAMES.map(|name| format!("in/{name}")).iter().map(String::as_str).chain(["in/hullmap.toml"]) {
        wait();
        write(&folder, name, fs::read(folder.path().join(name)).unwrap());
        assert!(builds() && !builds(), "{program}: {name}");
    }
    fs::remove_file(folder.path().join("in/with space.obj")).unwrap();
    builds();
    // A new mesh in a folder that had none.
    wait();
    write(&folder, "in/later/new.obj", CUBE);
    assert!(builds() && !builds(), "{program}");
    assert!(folder.path().join("o/later/new.hullmap").exists());
}

#[test]
fn make_understands_the_depfile() {
    let words = "build in --out o --quiet --depfile o.d --set depfile_target=o/stamp";
    let rules = format!("o/stamp:\n\t{} {words} && touch o/stamp\n-include o.d\n", binary().display());
    understands_the_depfile("make", ("Makefile", rules), "up to date");
}

#[test]
fn ninja_understands_the_depfile() {
    let bake = binary().display().to_string().replace('$', "$$").replace(' ', "$ ");
    let words = "build in --out o --quiet --depfile $out.d --set depfile_target=$out && touch $out";
    let rules = format!("rule bake\n  command = {bake} {words}\n  depfile = $out.d\nbuild o/stamp: bake\n");
    understands_the_depfile("ninja", ("build.ninja", rules), "no work to do");
}
