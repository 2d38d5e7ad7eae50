//! Untrusted packs, meshes and names: files that they must not make the command read or write, and
//! text that it must not print.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::header::source_hash;
use hullmap_outside::command::{Run, bake_in, command};
use hullmap_outside::files::{folder, workspace};
use hullmap_testkit::packs::{self, point_set};

const CUBE: &str = "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

/// Longest time for a run. A run that waits for a pipe would never end.
const LIMIT: Duration = Duration::from_secs(60);

/// Runs `bake` and kills it after [`LIMIT`].
#[track_caller]
fn bake(folder: &Path, line: &str, code: i32) -> Run {
    let mut child = command(folder, line.split_whitespace());
    let mut child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            panic!("bake {line} did not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let run = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let run = Run { code: run.status.code().unwrap(), stdout: text(run.stdout), stderr: text(run.stderr) };
    run.expect(code)
}

fn make_pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// The record of a pack of [`CUBE`], with this index.
fn record(path: &str, index: &str) -> SourceRecord {
    SourceRecord {
        path: path.to_owned(),
        hash: source_hash(CUBE.as_bytes()),
        options: format!("split none, vertices referenced, index {index}"),
        ..SourceRecord::default()
    }
}

/// Writes the pack of a tetrahedron of this height that records this source.
fn write_tetrahedron(path: &Path, height: f32, record: &SourceRecord) {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]];
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, packs::bytes(&[point_set("x", &corners)], IndexKind::Tree, record).unwrap()).unwrap();
}

/// A pack that recorded `../../../dev/zero` was read until the memory was full. A pipe blocked the
/// command, and the message revealed whether a file existed.
#[test]
fn a_recorded_path_is_followed_only_inside_the_project() {
    let folder = folder(&[("x.obj", CUBE), ("home/project/art/x.obj", CUBE)]);
    let project = folder.path().join("home/project");
    let pack = project.join("baked/p.hullmap");
    make_pipe(&folder.path().join("pipe"));
    make_pipe(&project.join("art/pipe"));
    for (target, link) in [("../../../x.obj", "link"), ("../../../nothing", "broken"), ("/dev/zero", "zero")] {
        symlink(target, project.join("art").join(link)).unwrap();
    }
    let up = "../".repeat(folder.path().components().count() + 4);
    for (path, reason) in [
        (format!("{up}dev/zero"), "leads out"),
        (format!("{up}etc/hostname"), "leads out"),
        (format!("{up}etc/no such file"), "leads out"),
        ("../../../x.obj".to_owned(), "leads out"),
        ("../../../nothing.obj".to_owned(), "leads out"),
        ("../../../pipe".to_owned(), "leads out"),
        ("../art/link".to_owned(), "leads out"),
        ("../art/broken".to_owned(), "leads out"),
        ("../art/zero".to_owned(), "leads out"),
        ("../art/pipe".to_owned(), "is not a regular file"),
        ("../art".to_owned(), "is not a regular file"),
    ] {
        write_tetrahedron(&pack, 1.0, &record(&path, "none"));
        let ending = match reason {
            "leads out" => "leads out of the pack's project, so it was not followed",
            _ => "is not a regular file, so it was not read",
        };
        let message = format!("baked/p.hullmap: the recorded path `{path}` {ending}");
        let run = bake(&project, "verify baked", 0);
        let expected = format!("note: {message}; compared with the stored hull only (name the source with --source)\n");
        assert_eq!(run.stderr, expected, "the same words whether or not a file is there");
        let run = bake(&project, "verify baked --require-source", 1);
        assert_eq!(run.stderr, format!("error: {message}; name the source with --source\n"));
        bake(&project, "report baked/p.hullmap --out page.html", 0);
        let page = fs::read_to_string(project.join("page.html")).unwrap();
        assert!(page.contains("name the source with --source"), "{path}");
    }
    // A source that the user names is read, wherever it lies.
    let run = bake(&project, "verify baked --source ../../x.obj --json", 0);
    assert_eq!(run.json()[0]["against"], "source");
    // Inside the project, and through a link that stays inside, everything works as before.
    symlink("art", project.join("linked")).unwrap();
    for path in ["../art/x.obj", "../linked/x.obj"] {
        write_tetrahedron(&pack, 1.0, &record(path, "none"));
        for (start, line) in
            [(".", "verify baked"), ("baked", "verify ."), ("baked", "verify p.hullmap"), ("art", "verify ../baked")]
        {
            let run = bake(&project.join(start), &format!("{line} --require-source --json"), 0);
            assert_eq!(run.json()[0]["against"], "source", "{start}: {line}");
        }
    }
}

/// A build reported whether a file outside the project existed: only packs without a source are
/// listed.
#[test]
fn orphans_do_not_reveal_which_files_exist() {
    let folder = folder(&[("secret.obj", CUBE), ("home/project/in/a.obj", CUBE)]);
    let project = folder.path().join("home/project");
    for name in ["secret", "nothing"] {
        let record = record(&format!("../../../{name}.obj"), "none");
        write_tetrahedron(&project.join("o").join(format!("{name}.hullmap")), 1.0, &record);
    }
    let run = bake(&project, "build in --out o --prune --json", 0);
    let rows: Vec<String> =
        run.json().iter().skip(1).map(|row| format!("{} {}", row["status"], row["notes"])).collect();
    assert_eq!(rows.len(), 2, "{}", run.stdout);
    assert!(rows[0] == rows[1] && rows[0].contains("leads out of the project"), "{rows:?}");
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
        "build in --out o --index NAME",
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

/// All text is printed through `terminal.rs`, which escapes every line.
#[test]
fn text_is_printed_by_one_file() {
    fn search(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                search(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
                found.push(path);
            }
        }
    }
    let mut files = Vec::new();
    for folder in ["cli", "pipeline", "report", "import"].map(|name| format!("crates/hullmap-{name}/src")) {
        search(&workspace().join(folder), &mut files);
    }
    let exits =
        ["print!", "println!", "eprint!", "eprintln!", "dbg!", "stdout()", "stderr()", "dyn Write", "io::Stdout"];
    let mut count = 0;
    for path in files.iter().filter(|path| path.parent().is_none_or(|folder| !folder.ends_with("tests"))) {
        let text = fs::read_to_string(path).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let code: Vec<&str> = code.take_while(|line| !line.starts_with("mod tests")).collect();
        let uses = |word: &&&str| code.iter().any(|line| line.contains(**word));
        let found: Vec<&&str> = exits.iter().filter(uses).collect();
        count += 1;
        if path.ends_with("hullmap-cli/src/terminal.rs") {
            assert_eq!(found, [&"stdout()", &"stderr()", &"dyn Write"]);
        } else {
            assert!(found.is_empty(), "{} prints by {found:?}; use terminal::Output or terminal::say", path.display());
        }
    }
    assert!(count > 60, "{count} files");
}

/// A pack of another mesh that records the right source passes `--check`, and `verify` rejects it.
#[test]
fn a_forged_pack_can_be_fresh() {
    let folder = folder(&[("in/x.obj", CUBE)]);
    write_tetrahedron(&folder.path().join("o/x.hullmap"), 1.5, &record("../in/x.obj", "tree 8"));
    bake(folder.path(), "build in --out o --check", 0);
    bake(folder.path(), "verify o", 1);
    bake(folder.path(), "build in --out o --verify", 1);
}

/// Recorded warnings are bounded, and forge no line.
#[test]
fn untrusted_warnings_do_no_harm() {
    let folder = folder(&[("in/x.obj", CUBE)]);
    bake(folder.path(), "build in --out o", 0);
    for (warnings, count) in [(vec!["a\nb\u{1b}[2J".to_owned()], 1), (vec!["x".repeat(20_000); 200], 100)] {
        let record = SourceRecord { warnings, ..record("../in/x.obj", "tree 8") };
        write_tetrahedron(&folder.path().join("o/x.hullmap"), 1.0, &record);
        let run = bake_in(folder.path(), ["build", "in", "--out", "o", "--json"]).expect(0);
        assert_eq!(run.json()[0]["status"], "fresh");
        assert_eq!(run.json()[0]["warnings"].as_array().unwrap().len(), count);
        assert_eq!(run.stderr.lines().count(), count);
        assert!(run.stderr.len() < 2_000_000 && !run.stderr.contains('\u{1b}'), "{}", run.stderr.len());
    }
}
