//! Builds of folders: started elsewhere, and with files that are no meshes of the project.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use hullmap_outside::command::{Run, bake_in};
use tempfile::TempDir;

const TET: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| write(&folder, name, text));
    folder
}

fn write(folder: &TempDir, name: &str, text: &str) {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

fn bake(folder: &Path, line: &str) -> Run {
    bake_in(folder, line.split_whitespace())
}

/// A check from another folder called every pack stale, and `verify` and `report` did not find the
/// sources of a build that was started elsewhere.
#[test]
fn packs_are_fresh_and_have_sources_wherever_the_command_is_started() {
    let elsewhere = folder(&[]);
    for (out, mark) in [("baked", None), ("build/packs", None), ("build/packs", Some(".git/HEAD"))] {
        let folder = folder(&[("p/assets/sub/a.obj", TET), ("p/assets/b.obj", TET), ("p/tools/x", "")]);
        let config = if mark.is_some() { "p/hullmap.toml" } else { "p/assets/hullmap.toml" };
        write(&folder, config, "[defaults]\nindex = \"none\"\n");
        mark.iter().for_each(|mark| write(&folder, &format!("p/{mark}"), ""));
        let project = folder.path().join("p");
        let starts = [&project, &project.join("assets"), &project.join("tools"), Path::new("/"), elsewhere.path()];
        for start in starts {
            let (input, packs) = (project.join("assets"), project.join(out));
            let _ = fs::remove_dir_all(project.join("build"));
            let build = format!("build {} --out {}", input.display(), packs.display());
            bake(start, &build).expect(0);
            for other in starts {
                let at = format!("{out}, baked in {}, checked in {}", start.display(), other.display());
                let run = bake(other, &format!("{build} --check"));
                assert_eq!((run.code, run.stdout.as_str()), (0, "2 fresh, 0 stale, 0 missing\n"), "{at}");
                // Without a mark, only the folder beside the packs is trusted.
                if out == "baked" || mark.is_some() {
                    bake(other, &format!("verify {} --require-source --directions 10", packs.display())).expect(0);
                    let page = folder.path().join("page.html");
                    bake(other, &format!("report {} --out {}", packs.display(), page.display())).expect(0);
                    assert!(!fs::read_to_string(page).unwrap().contains("name the source with --source"), "{at}");
                }
            }
        }
        // A pack that was moved to another source's place is stale all the same.
        write(&folder, "p/assets/sub/b.obj", TET);
        fs::copy(project.join(out).join("b.hullmap"), project.join(out).join("sub/b.hullmap")).unwrap();
        let line = format!("build {} --out {} --check", project.join("assets").display(), project.join(out).display());
        assert!(bake(&project, &line).code <= 1);
    }
}

/// A dangling link or the lock of an editor stopped the whole folder, and the shadow files of macOS
/// were baked.
#[test]
fn hidden_and_ignored_files_are_passed_over_and_dangling_links_fail_alone() {
    let folder = folder(&[
        ("in/a.obj", TET),
        ("in/.hidden.obj", TET),
        ("in/._a.obj", "AppleDouble"),
        ("in/.cache/c.obj", TET),
        ("in/.gitignore", "gen/\nscratch*\n"),
        ("in/gen/g.obj", TET),
        ("in/scratch.obj", TET),
        ("in/scratch.txt", ""),
        ("in/.git/g.obj", TET),
    ]);
    let path = folder.path();
    symlink("user@host.1234:99", path.join("in/.#a.obj")).unwrap();
    let outputs = |line: &str, code: i32| -> Vec<String> {
        let run = bake(path, &format!("{line} --json")).expect(code);
        run.json().iter().map(|row| row["output"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(outputs("build in --out o", 0), ["o/a.hullmap"]);
    let note = "note: meshes passed over: 3 hidden, 2 named by .gitignore (--no-ignore bakes them)\n";
    for line in ["build in --out o", "status in --out o", "plan in --out o", "key in"] {
        assert_eq!(bake(path, line).expect(0).stderr, note, "{line}");
    }
    assert_eq!(bake(path, "build in --out o --quiet").expect(0).stderr, "");
    // Files that are named are always taken.
    assert_eq!(outputs("build in/.hidden.obj in/scratch.obj --out p", 0), ["p/.hidden.hullmap", "p/scratch.hullmap"]);
    assert_eq!(outputs("build in/gen --out p", 0), ["p/g.hullmap"]);
    let all = outputs("build in --out o --no-ignore --exclude ._*", 0);
    assert_eq!(all, ["o/.cache/c.hullmap", "o/.hidden.hullmap", "o/a.hullmap", "o/gen/g.hullmap", "o/scratch.hullmap"]);
    let run = bake(path, "build in/.cache in/gen --out q --ext stl").expect(2);
    assert!(!run.stderr.contains("passed over"), "{}", run.stderr);
    write(&folder, "only/.x.obj", TET);
    let run = bake(path, "build only --out q").expect(2);
    assert!(run.stderr.contains("only: no meshes") && run.stderr.contains("passed over: 1 hidden"), "{}", run.stderr);

    symlink("nothing.obj", path.join("in/gone.obj")).unwrap();
    let run = bake(path, "build in --out o --json").expect(2);
    let statuses: Vec<&str> = run.stdout.lines().map(|line| line.split("\"status\":\"").nth(1).unwrap()).collect();
    assert!(statuses[0].starts_with("fresh") && statuses[1].starts_with("failed"), "{statuses:?}");
    assert!(run.stderr.contains("error: in/gone.obj: cannot read: "), "{}", run.stderr);
}

/// `bake plan` accepted a name that `bake task` then refused.
#[test]
fn a_name_with_a_backslash_cannot_be_planned() {
    let folder = folder(&[("in/a\\b.obj", TET), ("in/c.obj", TET)]);
    let run = bake(folder.path(), "plan in --out o").expect(2);
    assert!(run.stderr.starts_with("error: in/a\\b.obj: its pack would have a `\\` in its path"), "{}", run.stderr);
    assert_eq!(run.stdout.lines().count(), 1);
    write(&folder, "tasks", &run.stdout);
    let rows = bake(folder.path(), "task tasks --json").expect(0).json();
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0]["output"], "o/c.hullmap");
    bake(folder.path(), "build in --out o").expect(0);
}

/// The export of a folder with a level ended with exit code 2.
#[test]
fn an_export_of_a_folder_leaves_levels_out_where_they_do_not_fit() {
    let grid = "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n";
    let folder = folder(&[("in/a.obj", TET), ("in/level.obj", TET), ("in/z.obj", TET), ("in/dem.asc", grid)]);
    let rules = "[[rule]]\nfiles = \"level.obj\"\nkeep_triangles = true\n[[rule]]\nfiles = \"*.asc\"\nterrain = true\n";
    write(&folder, "in/hullmap.toml", rules);
    let path = folder.path();
    bake(path, "build in --out o").expect(0);
    for (target, files) in [
        ("--for unreal --out u", ["u/a.glb", "u/z.glb"]),
        ("--for mjcf --out m", ["m/a/a.xml", "m/z/z.xml"]),
        ("--parts --format obj --out p", ["p/a/a.obj", "p/z/z.obj"]),
        ("--for usd --prim /World --out layer.usda", ["layer.usda", "layer.usda"]),
        ("--format obj --out all", ["all/dem.obj", "all/level.obj"]),
    ] {
        let run = bake(path, &format!("export o {target}")).expect(0);
        assert!(files.iter().all(|file| path.join(file).exists()), "{target}: {}", run.stdout);
        for (file, noun) in [("level.hullmesh", "triangle mesh"), ("dem.hullfield", "height field")] {
            let is_left_out = run.stderr.contains(&format!("note: o/{file}: left out, because it is a {noun}"));
            assert_eq!(is_left_out, !target.ends_with("all"), "{target}: {}", run.stderr);
        }
    }
    let run = bake(path, "export o/level.hullmesh --for unreal --out x.glb").expect(2);
    assert!(run.stderr.contains("is a triangle mesh, which has no hulls; leave out --for"), "{}", run.stderr);
    fs::create_dir(path.join("levels")).unwrap();
    fs::copy(path.join("o/level.hullmesh"), path.join("levels/level.hullmesh")).unwrap();
    assert!(bake(path, "export levels --for unreal --out y").expect(2).stderr.contains("nothing to export"));
}

/// "closed triangles with 18.8 % of its area", where nothing was open, and no word where the mass
/// was dropped.
#[test]
fn a_reversed_triangle_is_called_that() {
    let text = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nv 0 0 .5\nv 3 0 .5\nv 3 1 .5\nv 1 1 .5\nv 1 3 .5\nv 0 3 .5\n\
                f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
    let one = text.replace("f 2 3 9 8", "f 2 3 9\nf 2 8 9");
    let folder = folder(&[("ell.obj", text), ("one.obj", &one), ("two.obj", &text.replace("f 1 2 8 7", "f 7 8 2 1"))]);
    let path = folder.path();
    for (file, words) in [
        ("ell.obj", None),
        ("one.obj", Some("one: triangle 11 (at 3 0.3333333 0.3333333) is reversed: it faces the other way")),
        ("two.obj", Some("two: 2 triangles are reversed, the first is 8 (at ")),
    ] {
        for flags in ["", " --decompose"] {
            let run = bake(path, &format!("build {file} --out o --json{flags}")).expect(0);
            let row = &run.json()[0];
            let warnings = row["warnings"].to_string();
            match words {
                Some(words) => assert!(warnings.contains(words) && warnings.contains("mass"), "{file}: {warnings}"),
                None => assert_eq!(warnings, "[]"),
            }
            assert!(!run.stdout.contains("holes were closed"), "{file}: {}", run.stdout);
            let text = bake(path, &format!("inspect o/{}", file.replace("obj", "hullmap"))).expect(0).stdout;
            assert_eq!(text.contains("mass unknown"), words.is_some(), "{file}: {text}");
            assert!(!text.contains("not a closed mesh"), "{text}");
            if !flags.is_empty() {
                assert!(text.contains("solid              watertight"), "{file}: {text}");
            }
        }
        let run = bake(path, &format!("build {file} --out o --keep-triangles --force")).expect(0);
        assert_eq!(run.stderr.contains("reversed: triangle 11 is reversed;"), file == "one.obj", "{}", run.stderr);
    }
    // An open mesh has no mass in any case.
    write(&folder, "open.obj", &one.replace("f 6 5 4 3 2 1\n", ""));
    let run = bake(path, "build open.obj --out o").expect(0);
    assert!(!run.stderr.contains("reversed"), "{}", run.stderr);
}
