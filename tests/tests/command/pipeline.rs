//! `bake build` as part of a project: stale and fresh packs, configuration, depfiles, and
//! leftovers.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use hullmap_outside::command::{Run, bake_in, binary};
use serde_json::Value;
use tempfile::TempDir;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        write(&folder, name, text);
    }
    folder
}

fn write(folder: &TempDir, name: &str, text: &str) {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

/// `pack: status` of each row, in order.
fn statuses(run: &Run) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    run.json().iter().map(|row| format!("{}: {}", text(&row["output"]), text(&row["status"]))).collect()
}

/// All files below a folder, relative to it, sorted.
fn files(folder: &Path) -> Vec<String> {
    fn walk(folder: &Path, root: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, root, found);
            } else {
                found.push(path.strip_prefix(root).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    let mut found = Vec::new();
    walk(folder, folder, &mut found);
    found.sort();
    found
}

/// Flips a bit in the middle of a file.
fn damage(path: PathBuf) {
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_check_bakes_nothing_and_names_what_is_stale_and_why() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", CUBE), ("in/c.obj", CUBE), ("in/d/e.obj", CUBE)]);
    let run = bake(&folder, "build in --out o --check --json").expect(1);
    assert!(run.json().iter().all(|row| row["status"] == "missing"));
    assert!(!folder.path().join("o").exists(), "nothing was made");
    bake(&folder, "build in --out o").expect(0);
    assert_eq!(bake(&folder, "build in --out o --check").expect(0).stdout, "4 fresh, 0 stale, 0 missing\n");

    // Time stamps do not count: a touched source is fresh, a changed one with its old stamp is not.
    let b = folder.path().join("in/b.obj");
    let stamp = fs::metadata(&b).unwrap().modified().unwrap();
    write(&folder, "in/a.obj", CUBE);
    write(&folder, "in/b.obj", &CUBE.replace("1 1 1", "1 1 2"));
    fs::File::options().write(true).open(&b).unwrap().set_modified(stamp).unwrap();
    damage(folder.path().join("o/c.hullmap"));
    fs::remove_file(folder.path().join("o/d/e.hullmap")).unwrap();
    let before: Vec<Vec<u8>> = files(folder.path()).iter().map(|f| fs::read(folder.path().join(f)).unwrap()).collect();
    let run = bake(&folder, "build in --out o --check --json").expect(1);
    let expected = ["o/a.hullmap: fresh", "o/b.hullmap: stale", "o/c.hullmap: stale", "o/d/e.hullmap: missing"];
    assert_eq!(statuses(&run), expected);
    for (row, reason) in [(1, "the source has changed"), (2, "checksum"), (3, "there is no pack yet")] {
        assert!(run.json()[row]["reason"].as_str().unwrap().contains(reason), "{}", run.stdout);
    }
    let table = bake(&folder, "build in --out o --check").expect(1).stdout;
    assert!(table.contains("stale") && table.contains("o/c.hullmap") && table.contains("checksum"), "{table}");
    assert!(!table.contains("o/a.hullmap") && table.ends_with("1 fresh, 2 stale, 1 missing\n"), "{table}");
    let after: Vec<Vec<u8>> = files(folder.path()).iter().map(|f| fs::read(folder.path().join(f)).unwrap()).collect();
    assert_eq!(before, after, "a check changes nothing");

    let run = bake(&folder, "build in --out o --check --json --index compact").expect(1);
    let reason = run.json()[0]["reason"].as_str().unwrap().to_owned();
    assert!(reason.contains("index tree`") && reason.contains("index compact`"), "{reason}");
    assert_eq!(
        bake(&folder, "build in --out o").expect(0).stdout.lines().last().unwrap().split(';').next(),
        Some("3 baked, 1 fresh, 0 failed")
    );
    bake(&folder, "build in --out o --check").expect(0);
}

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

#[test]
fn packs_without_a_source_are_named_and_removed_only_with_prune() {
    let folder = folder(&[
        ("in/a.obj", CUBE),
        ("in/gone.obj", CUBE),
        ("in/deep/er/gone.obj", CUBE),
        ("other/mesh.obj", CUBE),
        ("o/notes.hullmap", "no pack at all"),
        ("o/deep/readme.txt", "mine"),
    ]);
    bake(&folder, "build in --out o").expect(0);
    bake(&folder, "build other --out o").expect(0);
    fs::remove_file(folder.path().join("in/gone.obj")).unwrap();
    fs::remove_dir_all(folder.path().join("in/deep")).unwrap();
    let whole = files(&folder.path().join("o"));
    for line in ["build in --out o --json", "build in --out o --check --json"] {
        let run = bake(&folder, line).expect(0);
        let expected = ["o/a.hullmap: fresh", "o/deep/er/gone.hullmap: orphaned", "o/gone.hullmap: orphaned"];
        assert_eq!(statuses(&run), expected, "another build's packs are its own");
        assert!(run.stderr.contains("o/gone.hullmap: its source in/gone.obj is gone (--prune removes it)"));
        assert_eq!(files(&folder.path().join("o")), whole);
    }
    bake(&folder, "build in --out o --check --prune").expect(1);
    let run = bake(&folder, "build in/a.obj --out o --prune").expect(2);
    assert!(run.stderr.contains("error: --prune has no effect"), "{}", run.stderr);
    assert_eq!(files(&folder.path().join("o")), whole, "neither a check nor a build of files removes anything");
    let run = bake(&folder, "build in --out o --prune --json").expect(0);
    assert_eq!(statuses(&run), ["o/a.hullmap: fresh", "o/deep/er/gone.hullmap: pruned", "o/gone.hullmap: pruned"]);
    let left = ["a.hullmap", "deep/readme.txt", "mesh.hullmap", "notes.hullmap"];
    assert_eq!(files(&folder.path().join("o")), left);
    assert!(!folder.path().join("o/deep/er").exists(), "a folder that is empty then goes too");
    bake(&folder, "build in --out o --check --prune").expect(0);
}

/// A copy at another depth misses its source's path. It was removed although the source existed.
#[test]
fn a_pack_that_was_copied_or_moved_is_not_pruned() {
    let folder = folder(&[("art/props/cube.obj", CUBE), ("art/props/gone.obj", CUBE), ("art/rock.obj", CUBE)]);
    bake(&folder, "build art --out packs").expect(0);
    let packs = folder.path().join("packs");
    // Renamed and copied, each as far up or down as it may go, and one whose source is truly gone.
    let copies = ["foreign", "cube", "deep/er/cube", "props/renamed"];
    for copy in copies.map(|name| packs.join(format!("{name}.hullmap"))) {
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(packs.join("props/cube.hullmap"), copy).unwrap();
    }
    fs::copy(packs.join("props/gone.hullmap"), packs.join("props/other.hullmap")).unwrap();
    fs::remove_file(folder.path().join("art/props/gone.obj")).unwrap();
    let run = bake(&folder, "build art --out packs --prune --json").expect(0);
    let row = |name: &str| run.json().into_iter().find(|row| row["output"] == format!("packs/{name}.hullmap"));
    let gone = row("props/gone").unwrap();
    assert_eq!((&gone["status"], &gone["source"]), (&"pruned".into(), &"art/props/gone.obj".into()), "{gone}");
    for name in ["foreign", "cube", "deep/er/cube", "props/other"] {
        let row = row(name).unwrap();
        assert_eq!(row["status"], "orphaned", "{row}");
        let note = row["notes"][0].as_str().unwrap();
        // Directly in `packs`, the path leads above the folder where bake was started.
        let reason = if name.contains('/') { "would not write it here" } else { "leads out of the project" };
        assert!(note.contains(reason), "{row}");
        assert!(run.stderr.contains(&format!("note: packs/{name}.hullmap: its source ")), "{}", run.stderr);
    }
    assert!(row("props/renamed").is_none(), "its source is where it says");
    assert!(copies.iter().all(|name| packs.join(format!("{name}.hullmap")).exists()));
    bake(&folder, "build art --out packs --check --prune").expect(0);
}

/// From outside, packs record no folder of their source: they may be another build's and are not
/// removed.
#[test]
fn a_pack_of_another_build_is_not_removed() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/gone.obj", CUBE), ("elsewhere/x", "")]);
    let outside = |words: &str| bake_in(&folder.path().join("elsewhere"), words.split_whitespace());
    // The project of these packs does not hold their sources.
    outside("build ../in --out ../far/o").expect(0);
    fs::remove_file(folder.path().join("in/gone.obj")).unwrap();
    let run = outside("build ../in --out ../far/o --prune").expect(0);
    assert!(run.stderr.contains("not pruned"), "{}", run.stderr);
    assert!(folder.path().join("far/o/gone.hullmap").exists());
    // Next to their sources there is no ambiguity.
    outside("build ../in --out ../in").expect(0);
    fs::remove_file(folder.path().join("in/a.obj")).unwrap();
    write(&folder, "in/b.obj", CUBE);
    outside("build ../in --out ../in --prune").expect(0);
    assert_eq!(files(&folder.path().join("in")), ["b.hullmap", "b.obj"]);
}

#[test]
fn options_come_from_hullmap_toml_by_rule_and_flags_win() {
    let toml = "[defaults]\nindex = \"none\"\n\n[[rule]]\nfiles = \"props/*\"\nsplit = \"object\"\nindex = \"binary\"\n\n\
                [[rule]]\nfiles = \"*_all.obj\"\nvertices = \"all\"\n";
    let folder = folder(&[
        ("in/a.obj", CUBE),
        ("in/props/b.obj", CUBE),
        ("in/props/c_all.obj", CUBE),
        ("in/hullmap.toml", toml),
    ]);
    let options = |line: &str| -> Vec<String> {
        let rows = bake(&folder, line).expect(0).json();
        rows.iter().map(|row| row["options"].as_str().unwrap().to_owned()).collect()
    };
    let expected = [
        "split none, vertices referenced, index none",
        "split object, vertices referenced, index binary",
        "split object, vertices all, index binary",
    ];
    assert_eq!(options("build in --out o --json"), expected);
    let inspected = bake(&folder, "inspect o --json").expect(0).json();
    let recorded: Vec<&str> = inspected.iter().map(|report| report["options"].as_str().unwrap()).collect();
    assert_eq!(recorded, expected, "the reported options are the recorded ones");
    assert_eq!(options("build in/props --out o2 --json"), expected[1..], "however the mesh is named");
    let flags = options("build in --out o3 --index compact --json");
    assert!(flags.iter().all(|text| text.ends_with("index tree 32")) && flags[1].starts_with("split object"));
    assert!(options("build in --out o4 --no-config --json").iter().all(|text| text.ends_with("index tree 8")));
    write(&folder, "conf/other.toml", "[defaults]\nindex = \"cubemap\"\n");
    let other = options("build in --out o5 --config conf/other.toml --json");
    assert!(other.iter().all(|text| text.ends_with("index cubemap 64")), "{other:?}");

    // A changed rule makes only its own meshes stale; a changed comment makes no mesh stale.
    write(&folder, "in/hullmap.toml", &format!("# remark\n{}", toml.replace("vertices = \"all\"", "index = \"none\"")));
    let run = bake(&folder, "build in --out o --json").expect(0);
    let expected = ["o/a.hullmap: fresh", "o/props/b.hullmap: fresh", "o/props/c_all.hullmap: baked"];
    assert_eq!(statuses(&run), expected);
}

/// If the command started below the file, it silently ignored it.
#[test]
fn a_hullmap_toml_above_the_start_is_read() {
    let folder = folder(&[("art/props/rock.obj", CUBE), ("art/hullmap.toml", "[defaults]\nindex = \"none\"\n")]);
    let below = |line: &str| bake_in(&folder.path().join("art/props"), line.split_whitespace()).expect(0);
    let run = below("build rock.obj --out ../../packs --json");
    assert!(run.json()[0]["options"].as_str().unwrap().ends_with("index none"), "{}", run.stdout);
    below("build rock.obj --out ../../packs --check");
    let run = below("build rock.obj --out ../../packs --no-config --json");
    assert!(run.json()[0]["options"].as_str().unwrap().ends_with("index tree 8"), "{}", run.stdout);
    bake(&folder, "build art/props --out packs --check --no-config").expect(0);
}

#[test]
fn rules_that_match_nothing_are_warnings() {
    let toml = "[defaults]\ndecompose = true\n[[rule]]\nfiles = \"propz/**\"\nindex = \"none\"\n";
    let folder = folder(&[("in/a.obj", CUBE), ("in/hullmap.toml", toml)]);
    let run = bake(&folder, "build in --out o --max-parts 4 --json").expect(0);
    let options = run.json()[0]["options"].to_string();
    assert!(options.contains("decompose"), "the file requests it: {options}");
    assert!(run.stderr.contains("warning: in/hullmap.toml:4: no mesh matches `propz/**`\n"), "{}", run.stderr);
    assert!(!run.stderr.contains("has no effect"), "{}", run.stderr);
    write(&folder, "in/hullmap.toml", "[defaults]\nmax_parts = 4\n");
    let run = bake(&folder, "build in --out o").expect(0);
    assert!(run.stderr.contains("warning: in/hullmap.toml: max_parts has no effect"), "{}", run.stderr);
    let run = bake(&folder, "build in --out o --decompose").expect(0);
    assert!(!run.stderr.contains("has no effect"), "{}", run.stderr);
    let run = bake(&folder, "build in --out in/a.obj").expect(2);
    assert!(run.stderr.contains("in/a.obj: is a file"), "{}", run.stderr);
}

/// `--max-parts 4` without `--decompose` baked whole hulls, without a message.
#[test]
fn options_without_effect_are_errors() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", CUBE)]);
    for (line, flag) in [
        ("build in --out o --max-parts 4", "--max-parts"),
        ("build in --out o --quiet --decompose-seconds 2.5", "--decompose-seconds"),
        ("key in --max-parts 4", "--max-parts"),
        ("plan in --out o --max-parts none", "--max-parts"),
        ("status in --out o --max-parts 4", "--max-parts"),
    ] {
        let run = bake(&folder, line).expect(2);
        let message = format!("error: {flag} has no effect without --decompose; add it, or remove {flag}\n");
        assert!(run.stderr == message && run.stdout.is_empty(), "{line}: {run:?}");
    }
    assert!(!folder.path().join("o").exists(), "nothing was made");
    write(&folder, "in/hullmap.toml", "[[rule]]\nfiles = \"b.obj\"\ndecompose = true\n");
    bake(&folder, "build in --out o --max-parts 4").expect(0);
    bake(&folder, "build in/a.obj --out o --max-parts 4").expect(2);
}

#[test]
fn a_wrong_hullmap_toml_ends_before_any_work() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/sub/b.obj", CUBE)]);
    for (text, expected) in [
        ("[defaults]\n\nsplti = \"none\"\n", "in/sub/hullmap.toml:3: unknown key `splti`; did you mean `split`?"),
        ("[defaults]\nindex = \"tre\"\n", "in/sub/hullmap.toml:2: index = \"tre\": expected one of tree, "),
        ("[defaults\n", "in/sub/hullmap.toml:1: invalid TOML: "),
    ] {
        write(&folder, "in/sub/hullmap.toml", text);
        let run = bake(&folder, "build in --out o").expect(2);
        assert!(run.stderr.contains(expected) && run.stdout.is_empty(), "{}", run.stderr);
        assert!(!folder.path().join("o").exists(), "nothing was made");
    }
    assert!(bake(&folder, "build in --out o --config no.toml").expect(2).stderr.contains("no.toml"));
    bake(&folder, "build in --out o --no-config").expect(0);
}

#[test]
fn init_writes_a_file_that_changes_nothing_and_never_overwrites() {
    let folder = folder(&[("in/a.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    let run = bake(&folder, "init in").expect(0);
    assert!(run.stdout.starts_with("in/hullmap.toml: written"), "{}", run.stdout);
    bake(&folder, "build in --out o --check").expect(0);
    write(&folder, "in/hullmap.toml", "# mine\n");
    let run = bake(&folder, "init in").expect(2);
    assert!(run.stderr.contains("in/hullmap.toml: already exists"), "{}", run.stderr);
    assert_eq!(fs::read_to_string(folder.path().join("in/hullmap.toml")).unwrap(), "# mine\n");
    assert!(bake(&folder, "init nowhere").expect(2).stderr.contains("nowhere"));
    bake_in(&folder.path().join("o"), ["init"]).expect(0);
    assert!(folder.path().join("o/hullmap.toml").exists());
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

#[test]
fn a_depfile_names_the_sources_of_each_pack() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", CUBE), ("in/hullmap.toml", "")]);
    bake(&folder, "build in --out o --depfile deps.d").expect(0);
    let text = fs::read_to_string(folder.path().join("deps.d")).unwrap();
    assert!(text.starts_with("o/a.hullmap: \\\n  in/a.obj \\\n  in/hullmap.toml\no/b.hullmap: \\\n"), "{text}");
    let run = bake(&folder, "build in --out o --depfile no/deps.d").expect(2);
    assert!(run.stderr.contains("no/deps.d: cannot write the depfile"), "{}", run.stderr);
}

#[test]
fn quiet_prints_only_errors_and_verbose_lists_fresh_packs() {
    let folder = folder(&[("in/a.obj", "v 0 0 0\nv 1 0 0\nv 1 0 0\n"), ("bad/b.obj", "v 0 0\n")]);
    let run = bake(&folder, "build in --out o --quiet").expect(0);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let run = bake(&folder, "build bad --out o --quiet").expect(1);
    assert!(run.stdout.is_empty() && run.stderr.starts_with("error: bad/b.obj:1: "), "{run:?}");
    let run = bake(&folder, "build in --out o").expect(0);
    assert!(!run.stdout.contains("in/a.obj") && run.stdout.starts_with("0 baked, 1 fresh"), "{}", run.stdout);
    assert!(bake(&folder, "build in --out o --verbose").expect(0).stdout.contains("in/a.obj"));
    assert_eq!(bake(&folder, "build in --out o --quiet --json").expect(0).json().len(), 1);
}

/// An I/O error exits with 2, and the other meshes are still baked.
#[test]
fn an_unwritable_output_is_not_an_error_of_the_mesh() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/sub/b.obj", CUBE), ("o/sub", "a file where a folder must be")]);
    let run = bake(&folder, "build in --out o --json").expect(2);
    assert_eq!(statuses(&run), ["o/a.hullmap: baked", "o/sub/b.hullmap: failed"]);
    assert!(run.stderr.contains("o/sub/b.hullmap: cannot write: "), "{}", run.stderr);
    assert_eq!(files(&folder.path().join("o")), ["a.hullmap", "sub"]);
    // A folder at the path of a pack.
    write(&folder, "p/a.hullmap/x", "");
    let run = bake(&folder, "build in/a.obj --out p").expect(2);
    assert!(run.stderr.contains("p/a.hullmap"), "{}", run.stderr);
    assert_eq!(files(&folder.path().join("p")), ["a.hullmap/x"], "no temporary file is left");
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

#[test]
fn an_output_folder_inside_the_input_is_never_read_as_input() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/sub/b.obj", CUBE)]);
    for _ in 0..3 {
        bake(&folder, "build in --out in/baked --prune").expect(0);
    }
    let expected = ["a.obj", "baked/a.hullmap", "baked/sub/b.hullmap", "sub/b.obj"];
    assert_eq!(files(&folder.path().join("in")), expected);
    bake(&folder, "build in --out in --prune").expect(0);
    bake(&folder, "build in --out in/baked --check --prune").expect(0);
    bake(&folder, "verify in --require-source").expect(0);
}

#[test]
fn completions_for_every_shell_name_the_subcommands() {
    let folder = folder(&[]);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let run = bake(&folder, &format!("completions {shell}")).expect(0);
        for word in ["build", "inspect", "up-axis", "completions"] {
            assert!(run.stdout.contains(word), "{shell} without {word}");
        }
    }
    assert!(bake(&folder, "completions tcsh").expect(2).stderr.contains("Usage: bake completions"));
}

#[test]
fn verify_can_require_the_source() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    bake(&folder, "verify o --require-source").expect(0);
    fs::remove_file(folder.path().join("in/b.obj")).unwrap();
    bake(&folder, "verify o").expect(0);
    let run = bake(&folder, "verify o --require-source --json").expect(1);
    let passes: Vec<bool> = run.json().iter().map(|report| report["pass"].as_bool().unwrap()).collect();
    assert_eq!(passes, [true, false]);
    assert!(run.json()[1]["problems"][0].as_str().unwrap().contains("no source found"), "{}", run.stdout);
}

/// All other packs of the folder were reported as stale.
#[test]
fn one_mesh_is_the_source_of_packs_with_its_name() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", &CUBE.replace("1 1 1", "1 1 2")), ("x/c.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    let run = bake(&folder, "verify o --source in/a.obj --json").expect(0);
    let sources: Vec<Value> = run.json().iter().map(|report| report["source"].clone()).collect();
    assert_eq!(sources[0], "in/a.obj");
    assert!(sources[1].as_str().unwrap().ends_with("in/b.obj"), "the others are searched for as ever: {sources:?}");
    let run = bake(&folder, "verify o --source x/c.obj").expect(2);
    assert!(run.stderr.contains("none of the 2 packs has this name"), "{}", run.stderr);
    bake(&folder, "verify o/b.hullmap --source in/a.obj").expect(1);
}

#[test]
fn hulls_with_a_hash_in_their_names_can_be_queried() {
    let two = "o left#2\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no right\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 4 5 6\n";
    let folder = folder(&[("two#x.obj", two)]);
    bake(&folder, "build two#x.obj --out . --split object").expect(0);
    let run = bake(&folder, "query two#x.hullmap#left#2 two#x.hullmap#right --mode distance --json").expect(0);
    assert!((run.json()[0]["distance"].as_f64().unwrap() - 4.0).abs() < 1e-9, "{}", run.stdout);
    let run = bake(&folder, "query two#x.hullmap#left#3 two#x.hullmap#right").expect(2);
    assert!(run.stderr.contains("no hull `left#3`"), "{}", run.stderr);
}

#[test]
fn inspect_takes_files_and_folders_and_continues_after_a_bad_one() {
    let folder = folder(&[("in/a.obj", &CUBE.replace("1 1 1", "1.1 1.2 1.3")), ("in/b.obj", CUBE), ("in/c.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    damage(folder.path().join("o/b.hullmap"));
    let run = bake(&folder, "inspect o/c.hullmap o --json").expect(1);
    let files: Vec<Value> = run.json().iter().map(|report| report["file"].clone()).collect();
    assert_eq!(files, ["o/c.hullmap", "o/a.hullmap", "o/c.hullmap"]);
    assert!(run.stderr.contains("o/b.hullmap") && run.stderr.contains("checksum"), "{}", run.stderr);
    // Text has the digits that matter, JSON has all of them.
    let text = bake(&folder, "inspect o/a.hullmap").expect(0).stdout;
    assert!(text.contains("bounds             0 0 0 to 1.1 1.2 1.3\n"), "{text}");
    let json = bake(&folder, "inspect o/a.hullmap --json").expect(0).json().remove(0);
    let diameter = json["hulls"][0]["diameter"].as_f64().unwrap();
    let truth = [1.1_f32, 1.2, 1.3].iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt();
    assert!((diameter - truth).abs() < 1e-12);
    assert!(text.contains("diameter           2.083267\n"), "{text}");
}

#[test]
fn index_kinds_have_the_same_names_everywhere() {
    let points: String =
        shapes::families::Family::Sphere.points(200, 3).iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let folder = folder(&[("a.obj", &points)]);
    for name in ["tree", "medium", "compact", "binary", "cubemap", "none"] {
        bake(&folder, &format!("build a.obj --out . --index {name}")).expect(0);
        let json = bake(&folder, "inspect a.hullmap --json").expect(0).json().remove(0);
        assert_eq!(json["hulls"][0]["index"]["kind"], name);
        let text = bake(&folder, "inspect a.hullmap").expect(0).stdout;
        assert!(text.contains(&format!("index              {name}, ")), "{text}");
        assert!(text.contains(&format!("vertices referenced, index {name}")), "{text}");
        bake(&folder, "report a.hullmap --out page.html").expect(0);
        let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
        assert!(page.contains(&format!("options: split none, vertices referenced, index {name}")), "{name}");
        let cell = if name == "cubemap" { ">cubemap 64<".to_owned() } else { format!(">{name}<") };
        assert!(page.contains(&cell) && !page.contains("leaves of"), "{name}");
        write(&folder, "hullmap.toml", &format!("[defaults]\nindex = \"{name}\"\n"));
        bake(&folder, "build a.obj --out . --check").expect(0);
        fs::remove_file(folder.path().join("hullmap.toml")).unwrap();
    }
}

/// A folder with a pack of 20 flat hulls printed 20 equal warnings and 20 rows.
#[test]
fn a_file_with_many_hulls_takes_one_line() {
    let sheet = |index: usize| {
        let corner = 3 * index;
        format!(
            "o s{index}\nv {index} 0 0\nv {index} 1 0\nv {index} 0 1\nf {} {} {}\n",
            corner + 1,
            corner + 2,
            corner + 3
        )
    };
    let folder = folder(&[("in/a.obj", &(0..20).map(sheet).collect::<String>()), ("in/b.obj", CUBE)]);
    let run = bake(&folder, "build in --out o --split object").expect(0);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert_eq!(lines.len(), 1, "{}", run.stderr);
    let names = "(and 19 more like it: s1, s2, s3, s4, s5, s6, s7, s8, …)";
    assert!(lines[0].starts_with("warning: in/a.obj: hull s0 is flat: ") && lines[0].ends_with(names), "{}", lines[0]);
    let rows = |line: &str| bake(&folder, line).expect(0).stdout.lines().filter(|row| row.starts_with("o/")).count();
    assert_eq!((rows("verify o"), rows("verify o --hulls")), (2, 21));
    assert!(bake(&folder, "verify o").expect(0).stdout.ends_with("\n21 exact, 0 failed\n"));
    assert_eq!(bake(&folder, "verify o --json").expect(0).json().len(), 21, "an object per hull, as ever");
}

/// `x.obj` beside `x.stl` ended the whole build, and nothing was baked.
#[test]
fn meshes_of_one_stem_get_packs_with_their_extensions() {
    let stl = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n";
    let folder = folder(&[("in/x.obj", CUBE), ("in/y.obj", CUBE), ("in/sub/x.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    assert_eq!(files(&folder.path().join("o")), ["sub/x.hullmap", "x.hullmap", "y.hullmap"]);

    // The pack of the old name is an orphan, and no other pack changes its name.
    write(&folder, "in/x.stl", stl);
    let run = bake(&folder, "build in --out o --json").expect(0);
    let expected = [
        "o/sub/x.hullmap: fresh",
        "o/x.obj.hullmap: baked",
        "o/x.stl.hullmap: baked",
        "o/y.hullmap: fresh",
        "o/x.hullmap: orphaned",
    ];
    assert_eq!(statuses(&run), expected);
    let note = "note: in/x.obj: its pack o/x.obj.hullmap keeps the extension, to differ from the pack of in/x.stl\n";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    let orphan = "note: o/x.hullmap: its source in/x.obj is now baked into o/x.obj.hullmap (--prune removes it)\n";
    assert!(run.stderr.contains(orphan), "{}", run.stderr);
    bake(&folder, "build in --out o --check --prune").expect(1);
    bake(&folder, "build in --out o --prune").expect(0);
    let packs = ["sub/x.hullmap", "x.obj.hullmap", "x.stl.hullmap", "y.hullmap"];
    assert_eq!(files(&folder.path().join("o")), packs);
    let run = bake(&folder, "build in --out o --check --prune").expect(0);
    assert!(!run.stderr.contains("note:"), "a fresh pack needs no note: {}", run.stderr);
    bake(&folder, "verify o --require-source").expect(0);
    let run = bake(&folder, "verify o --source in --require-source --json").expect(0);
    assert_eq!(run.json()[2]["source"], "in/x.stl", "{}", run.stdout);
    bake(&folder, "verify o/x.stl.hullmap --source in/x.stl").expect(0);

    // A third mesh of the stem changes nothing for the others.
    write(
        &folder,
        "in/x.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
    );
    let run = bake(&folder, "build in --out o --json").expect(0);
    assert_eq!(statuses(&run).iter().filter(|status| status.ends_with("fresh")).count(), 4, "{}", run.stdout);
    // The packs of gone sources are pruned under either name.
    for name in ["x.ply", "x.stl", "y.obj"] {
        fs::remove_file(folder.path().join("in").join(name)).unwrap();
    }
    bake(&folder, "build in --out o --prune").expect(0);
    assert_eq!(files(&folder.path().join("o")), ["sub/x.hullmap", "x.hullmap"]);
}

#[test]
fn names_of_packs_can_be_chosen() {
    let folder = folder(&[("in/x.obj", CUBE), ("in/X.ply", "ply\n"), ("in/y.obj", CUBE), ("other/y.obj", CUBE)]);
    let built = |line: &str, code: i32| {
        fs::remove_dir_all(folder.path().join("o")).ok();
        let run = bake(&folder, line).expect(code);
        (files(&folder.path().join("o")), run)
    };
    fs::remove_file(folder.path().join("in/X.ply")).unwrap();
    let (packs, _) = built("build in --out o --pack-names full", 0);
    assert_eq!(packs, ["x.obj.hullmap", "y.obj.hullmap"]);
    let recorded = fs::read(folder.path().join("o/x.obj.hullmap")).unwrap();
    let (packs, _) = built("build in --out o", 0);
    assert_eq!(packs, ["x.hullmap", "y.hullmap"]);
    assert_eq!(fs::read(folder.path().join("o/x.hullmap")).unwrap(), recorded, "the name does not change the bytes");

    // Only the meshes that clash are not baked.
    let (packs, run) = built("build in other --out o", 2);
    assert_eq!(packs, ["x.hullmap"]);
    let error = "error: in/y.obj and other/y.obj would both become o/y.hullmap; rename one";
    assert_eq!(run.stderr.matches(error).count(), 2, "{}", run.stderr);
    write(&folder, "in/x.stl", "solid x\nendsolid x\n");
    let (packs, run) = built("build in --out o --pack-names stem --json", 2);
    assert_eq!(packs, ["y.hullmap"]);
    assert_eq!(statuses(&run), ["o/x.hullmap: failed", "o/x.hullmap: failed", "o/y.hullmap: baked"]);
    fs::remove_file(folder.path().join("in/x.stl")).unwrap();

    write(&folder, "in/hullmap.toml", "[[rule]]\nfiles = \"y*\"\npack_names = \"full\"\n");
    let (packs, _) = built("build in --out o", 0);
    assert_eq!(packs, ["x.hullmap", "y.obj.hullmap"]);
}

#[test]
fn meshes_can_be_left_out() {
    let folder = folder(&[
        ("in/a.obj", CUBE),
        ("in/a_lod1.obj", CUBE),
        ("in/lods/b.obj", CUBE),
        (
            "in/c.STL",
            "solid c\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid c\n",
        ),
        ("cloud.txt", "v 0 0 0\n"),
    ]);
    let packs = |line: &str| -> Vec<String> {
        let run = bake(&folder, &format!("{line} --json")).expect(0);
        assert!(!run.stderr.contains("--exclude"), "{line}: {}", run.stderr);
        run.json().iter().map(|row| row["output"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(packs("build in --out o --exclude *_LOD?.obj --exclude lods/**"), ["o/a.hullmap", "o/c.hullmap"]);
    assert_eq!(packs("build in --out o --ext stl,GLB"), ["o/c.hullmap"]);
    assert_eq!(packs("build in --out o --ext obj --exclude a*"), ["o/lods/b.hullmap"]);
    let named = "build in/a.obj in/a_lod1.obj cloud.txt --out o --ext stl --exclude *_lod1.obj";
    assert_eq!(packs(named), ["o/a.hullmap", "o/cloud.hullmap"], "a named file may have any extension");
    // A mesh that is left out has a source, so its pack is not an orphan.
    bake(&folder, "build in --out o").expect(0);
    assert_eq!(packs("build in --out o --exclude *_lod1.obj --exclude lods/** --ext obj --prune"), ["o/a.hullmap"]);
    assert_eq!(files(&folder.path().join("o")).len(), 5);

    let run = bake(&folder, "build in --out o --exclude propz/**").expect(0);
    assert!(run.stderr.contains("warning: --exclude: no mesh matches `propz/**`"), "{}", run.stderr);
    let run = bake(&folder, "build in --out o --exclude **").expect(2);
    assert!(run.stderr.contains("--exclude and --ext leave no mesh to bake (left out: 4)"), "{}", run.stderr);
    assert!(bake(&folder, "build in --out o --exclude a[").expect(2).stderr.contains("invalid glob `a[`"));
    assert!(bake(&folder, "build in --out o --ext fbx").expect(2).stderr.contains("fbx"));

    let toml = "[[rule]]\nfiles = \"**/*.obj\"\nskip = true\n\n[[rule]]\nfiles = \"a.obj\"\nskip = false\n";
    write(&folder, "in/hullmap.toml", toml);
    assert_eq!(packs("build in --out o"), ["o/a.hullmap", "o/c.hullmap"], "later rules override earlier ones");
    assert_eq!(packs("build in --out o --no-config").len(), 4);
    let run = bake(&folder, "build in/a_lod1.obj --out o").expect(0);
    assert!(
        run.stderr.contains("note: in/a_lod1.obj: left out, because in/hullmap.toml sets skip = true"),
        "{}",
        run.stderr
    );
}
