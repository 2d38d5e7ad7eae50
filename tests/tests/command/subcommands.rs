//! The interface of the command: exit codes, messages, output streams, and the fields that other
//! programs read.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use glam::DVec3;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::{header::source_hash, slot::Slot};
use hullmap_outside::command::{Run, bake_in};
use hullmap_testkit::packs::{self, point_set};
use serde_json::Value;
use shapes::families::Family;
use tempfile::TempDir;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

/// `points` as the bare `v` lines of an OBJ file.
fn cloud(points: &[[f32; 3]]) -> String {
    points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

#[track_caller]
fn assert_fields(value: &Value, names: &[&str]) {
    let found: BTreeSet<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    let missing: Vec<_> = names.iter().filter(|name| !found.contains(*name)).collect();
    assert!(missing.is_empty(), "without {missing:?}: {value}");
}

fn packs_in(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

#[test]
fn wrong_usage_exits_with_2_and_prints_nothing_to_stdout() {
    let folder = folder(&[("a.obj", CUBE), ("empty/note.txt", "")]);
    for line in [
        "",
        "bake",
        "build",
        "build a.obj",
        "build a.obj --out o --index octree",
        "build gone.obj --out o",
        "build empty --out o",
        "verify gone.hullmap",
        "verify empty",
        "inspect gone.hullmap",
        "query gone.hullmap gone.hullmap",
    ] {
        let run = bake(&folder, line).expect(2);
        assert!(run.stdout.is_empty() && !run.stderr.is_empty(), "{line}: {run:?}");
    }
    assert!(!folder.path().join("o").exists(), "nothing was made");
    let help = bake(&folder, "--help").expect(0);
    assert!(help.stdout.contains("build") && help.stderr.is_empty());
}

#[test]
fn good_files_are_baked_and_bad_ones_are_reported_with_their_line() {
    let folder = folder(&[
        ("in/good.obj", CUBE),
        ("in/deep/also_good.OBJ", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\n"),
        ("in/nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
        ("in/infinite.obj", "v 0 0 0\nv 1 0 0\n\nv 0 -inf 0\n"),
        ("in/huge.obj", "v 1e39 0 0\n"),
        ("in/out_of_range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n# 4\nf 1 2 4\n"),
        ("in/before_first.obj", "v 0 0 0\nf -1 -1 -2\n"),
        ("in/zero.obj", "v 0 0 0\nv 1 0 0\nf 0 1 2\n"),
        ("in/empty.obj", ""),
        ("in/no_vertices.obj", "# nothing\no x\n"),
        ("in/malformed.obj", "v 0 0 0\nv 1 two 3\n"),
        ("in/cut.obj", "v 0 0 0\nv 1 0"),
    ]);
    let run = bake(&folder, "build in --out o --json").expect(1);
    let rows = run.json();
    let failed = [
        "nan:2",
        "infinite:4",
        "huge:1",
        "out_of_range:5",
        "before_first:2",
        "zero:3",
        "empty",
        "no_vertices",
        "malformed:2",
        "cut:2",
    ];
    assert_eq!(rows.len(), failed.len() + 2);
    for row in &rows {
        assert_fields(
            row,
            &["source", "output", "status", "hulls", "vertices_in", "vertices_hull", "bytes", "millis", "error"],
        );
        let source = row["source"].as_str().unwrap();
        let is_good = source.contains("good");
        assert_eq!(row["status"], if is_good { "baked" } else { "failed" }, "{row}");
        assert_eq!(row["error"].is_null(), is_good, "{row}");
        assert_eq!(folder.path().join(row["output"].as_str().unwrap()).exists(), is_good, "{row}");
    }
    for name in failed {
        let (stem, line) = name.split_once(':').unwrap_or((name, ""));
        let location = if line.is_empty() { format!("in/{stem}.obj: ") } else { format!("in/{stem}.obj:{line}: ") };
        let row = rows.iter().find(|row| row["source"].as_str().unwrap().ends_with(&format!("{stem}.obj"))).unwrap();
        let error = row["error"].as_str().unwrap();
        assert!(error.starts_with(&location), "{location} in {error}");
        assert!(run.stderr.contains(error), "stderr says so too");
    }
    assert!(folder.path().join("o/deep/also_good.hullmap").exists(), "the output mirrors the input");
    let left = packs_in(&folder.path().join("o"));
    assert_eq!(left.len(), 2, "no half-written file is left: {left:?}");
}

#[test]
fn a_second_build_is_fresh_until_something_changes() {
    let folder = folder(&[("in/a.obj", CUBE), ("in/b.obj", "v 1 2 3\n")]);
    let status = |line: &str| -> Vec<String> {
        let rows = bake(&folder, line).expect(0).json();
        rows.iter().map(|row| row["status"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(status("build in --out o --json"), ["baked", "baked"]);
    let bytes = fs::read(folder.path().join("o/a.hullmap")).unwrap();
    assert_eq!(status("build in --out o --json"), ["fresh", "fresh"]);
    assert_eq!(status("build in --out o --json --verify"), ["fresh", "fresh"]);
    assert_eq!(status("build in --out o --json --force"), ["baked", "baked"]);
    assert_eq!(fs::read(folder.path().join("o/a.hullmap")).unwrap(), bytes, "baked again, the same");
    fs::write(folder.path().join("in/b.obj"), "v 1 2 4\n").unwrap();
    assert_eq!(status("build in --out o --json"), ["fresh", "baked"], "another source");
    assert_eq!(status("build in --out o --json --index none"), ["baked", "baked"], "other options");
    let mut damaged = bytes;
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    assert_eq!(status("build in --out o --json"), ["baked", "baked"]);
    fs::write(folder.path().join("o/a.hullmap"), damaged).unwrap();
    assert_eq!(status("build in --out o --json"), ["baked", "fresh"], "a damaged pack");
}

/// A second build of a flat mesh was silent, as if the mesh had been repaired.
#[test]
fn warnings_are_shown_again_while_a_pack_is_fresh() {
    let flat = "v 0 0 0 0.5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let folder = folder(&[("in/flat.obj", flat), ("in/cube.obj", CUBE)]);
    let built = bake(&folder, "build in --out o --json").expect(0);
    let warnings = |row: &Value| row["warnings"].as_array().unwrap().clone();
    let expected = warnings(&built.json()[1]);
    let texts: Vec<&str> = expected.iter().map(|text| text.as_str().unwrap()).collect();
    assert!(texts.len() == 2 && texts[0].contains("weight") && texts[1].contains("is flat"), "{texts:?}");
    assert_eq!(warnings(&built.json()[0]), [Value::Null; 0]);
    let bytes = fs::read(folder.path().join("o/flat.hullmap")).unwrap();
    for line in ["--json", "--json --check", "--json --verify", "--json --force"] {
        let run = bake(&folder, &format!("build in --out o {line}")).expect(0);
        let row = &run.json()[1];
        let status = if line.ends_with("force") { "baked" } else { "fresh" };
        assert_eq!((row["status"].as_str(), warnings(row)), (Some(status), expected.clone()), "{line}");
        for text in &texts {
            assert!(run.stderr.contains(&format!("warning: in/flat.obj: {text}\n")), "{line}: {}", run.stderr);
        }
        assert_eq!(fs::read(folder.path().join("o/flat.hullmap")).unwrap(), bytes, "{line}");
    }
    assert!(bake(&folder, "build in --out o --quiet").expect(0).stderr.is_empty());
    let inspected = bake(&folder, "inspect o --json").expect(0).json();
    assert_eq!((warnings(&inspected[1]), warnings(&inspected[0])), (expected.clone(), Vec::new()));
    assert_eq!(inspected[0]["options"], inspected[1]["options"], "warnings are no options");
    let present = bake(&folder, "status in --out o --json").expect(0).json();
    assert!(present.iter().all(|row| row["status"] == "present"), "{present:?}");
    // The options of such a pack are still compared.
    bake(&folder, "status in --out o --index none").expect(1);
    let row = bake(&folder, "build in --out o --check --json --index none").expect(1).json().remove(1);
    let reason = row["reason"].as_str().unwrap();
    assert!(reason.starts_with("the options have changed from `split none") && !reason.contains("flat"), "{reason}");
    assert_eq!(warnings(&row), [Value::Null; 0]);
}

/// A pack may be hostile: its recorded warnings are bounded, and forge no line.
#[test]
fn untrusted_warnings_do_no_harm() {
    let folder = folder(&[("in/cube.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    let options = bake(&folder, "inspect o --json").expect(0).json()[0]["options"].as_str().unwrap().to_owned();
    let points: Vec<[f32; 3]> = (0..8).map(|i| [0, 1, 2].map(|axis| (i >> axis & 1) as f32)).collect();
    let record = |warnings: Vec<String>| SourceRecord {
        path: "../in/cube.obj".into(),
        hash: source_hash(CUBE.as_bytes()),
        options: options.clone(),
        warnings,
    };
    for (warnings, count) in [(vec!["a\nb\u{1b}[2J".to_owned()], 1), (vec!["x".repeat(20_000); 200], 100)] {
        let bytes = packs::bytes(&[point_set("cube", &points)], IndexKind::Tree, &record(warnings)).unwrap();
        fs::write(folder.path().join("o/cube.hullmap"), bytes).unwrap();
        let run = bake(&folder, "build in --out o --json").expect(0);
        assert_eq!(run.json()[0]["status"], "fresh");
        assert_eq!(run.json()[0]["warnings"].as_array().unwrap().len(), count);
        assert_eq!(run.stderr.lines().count(), count);
        assert!(run.stderr.len() < 2_000_000 && !run.stderr.contains('\u{1b}'), "{}", run.stderr.len());
    }
}

#[test]
fn verify_fails_if_the_source_has_changed() {
    let folder = folder(&[("a.obj", CUBE)]);
    bake(&folder, "build a.obj --out .").expect(0);
    let report = &bake(&folder, "verify a.hullmap --json").expect(0).json()[0];
    assert_fields(report, &["file", "hull", "vertices", "rank", "directions", "max_regret", "mismatches", "max_nodes"]);
    assert_fields(report, &["max_dots", "index_bytes_per_vertex", "pass"]);
    assert_eq!((&report["pass"], &report["against"]), (&Value::from(true), &Value::from("source")));
    fs::write(folder.path().join("a.obj"), CUBE.replacen("1 1 1", "1 1 2", 1)).unwrap();
    for line in ["verify a.hullmap --json", "verify a.hullmap --json --source a.obj", "verify . --json"] {
        let run = bake(&folder, line).expect(1);
        assert_eq!(run.json()[0]["pass"], false);
        assert!(run.stdout.contains("stale"), "{run:?}");
    }
    assert!(bake(&folder, "verify a.hullmap").expect(1).stderr.contains("stale"));
}

/// The pack records its source's hash and has an exact index, but its hull lacks one of the
/// source's points.
#[test]
fn verify_finds_each_point_that_a_hull_lost() {
    let points = Family::Rock.points(30, 5);
    let text = cloud(&points);
    let folder = folder(&[("a.obj", &text), ("cut.obj", &text)]);
    bake(&folder, "build a.obj --out . --index none").expect(0);
    let honest = bake(&folder, "inspect a.hullmap --json").expect(0).json().remove(0);
    assert_eq!(honest["hulls"][0]["vertices"], 30, "every point is extreme, so each can be lost");
    let options = honest["options"].as_str().unwrap().to_owned();
    let source =
        SourceRecord { path: "cut.obj".into(), hash: source_hash(text.as_bytes()), options, ..SourceRecord::default() };
    let write = |kept: &dyn Fn(usize) -> bool| {
        let mut set = point_set("cut", &points);
        set.source_vertices.retain(|v| kept(*v as usize));
        set.positions = set.source_vertices.iter().map(|v| points[*v as usize]).collect();
        let bytes = packs::bytes(&[set], IndexKind::None, &source).unwrap();
        fs::write(folder.path().join("cut.hullmap"), bytes).unwrap();
    };
    write(&|_| true);
    let whole = bake(&folder, "verify cut.hullmap --json").expect(0).json().remove(0);
    assert_eq!((&whole["pass"], &whole["against"]), (&Value::from(true), &Value::from("source")), "{whole}");
    for lost in 0..points.len() {
        write(&|v| v != lost);
        let report = bake(&folder, "verify cut.hullmap --json").expect(1).json().remove(0);
        assert_eq!((&report["pass"], &report["against"]), (&Value::from(false), &Value::from("source")), "{report}");
        assert!(report["max_regret"].as_f64().unwrap() > 1e-4, "{report}");
        assert!(report["mismatches"].as_u64().unwrap() > 0, "{report}");
    }
    // The stored hull alone does not show the error.
    fs::remove_file(folder.path().join("cut.obj")).unwrap();
    let run = bake(&folder, "verify cut.hullmap --json").expect(0);
    assert_eq!(run.json()[0]["against"], "stored hull");
}

/// A vertex differs from its source vertex by one unit in the last place. The regret is too small
/// to show this.
#[test]
fn verify_finds_a_vertex_that_is_not_in_the_source() {
    let points = Family::Rock.points(30, 6);
    let text = cloud(&points);
    let folder = folder(&[("a.obj", &text)]);
    let options = "split none, vertices referenced, index tree".to_owned();
    let source =
        SourceRecord { path: "a.obj".into(), hash: source_hash(text.as_bytes()), options, ..SourceRecord::default() };
    for (vertex, component) in [(0, 0), (17, 1), (29, 2)] {
        for moves in [false, true] {
            let mut set = point_set("a", &points);
            if moves {
                set.positions[vertex][component] = set.positions[vertex][component].next_up();
            }
            fs::write(folder.path().join("a.hullmap"), packs::bytes(&[set], IndexKind::Tree, &source).unwrap())
                .unwrap();
            let run = bake(&folder, "verify a.hullmap --json").expect(i32::from(moves));
            let report = &run.json()[0];
            assert_eq!((&report["pass"], &report["against"]), (&Value::from(!moves), &Value::from("source")));
            assert_eq!(report["problems"].as_array().unwrap().len(), usize::from(moves), "{report}");
        }
    }
}

/// Each leaf in turn refers to another leaf's candidates. The pack opens, since nothing in it is
/// out of range; only verification detects the error.
#[test]
fn verify_finds_a_wrong_index() {
    let points = Family::Sphere.points(60, 8);
    let text = cloud(&points);
    let folder = folder(&[("a.obj", &text)]);
    bake(&folder, "build a.obj --out .").expect(0);
    let path = folder.path().join("a.hullmap");
    let file = fs::read(&path).unwrap();
    let is_block = |word: u32| matches!(Slot::decode(word), Slot::Block(block) if block < 100);
    let (mut opened, mut found) = (0, 0);
    // A word that only looks like a leaf is rejected when it is changed, or has little effect.
    for at in (64..file.len()).step_by(4) {
        let word = u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        if !is_block(word) {
            continue;
        }
        let mut changed = file.clone();
        changed[at..at + 4].copy_from_slice(&(word ^ 1).to_le_bytes());
        packs::reseal(&mut changed);
        if hullmap::Pack::from_bytes(&changed).is_ok() {
            fs::write(&path, changed).unwrap();
            let run = bake(&folder, "verify a.hullmap --json --seed 4");
            opened += 1;
            found += usize::from(run.code == 1 && run.json()[0]["mismatches"].as_u64().unwrap() > 0);
        }
    }
    println!("{found} of {opened} wrong leaves found in 10,000 directions each");
    assert!(opened > 20 && found * 10 >= opened * 9, "{found} of {opened}");
}

#[test]
fn verify_without_a_source_reports_it_and_passes() {
    let folder = folder(&[("in/a.obj", CUBE)]);
    bake(&folder, "build in --out o").expect(0);
    fs::remove_file(folder.path().join("in/a.obj")).unwrap();
    let run = bake(&folder, "verify o --json").expect(0);
    assert_eq!((&run.json()[0]["pass"], &run.json()[0]["against"]), (&Value::from(true), &Value::from("stored hull")));
    assert!(run.stderr.contains("no source found"), "{}", run.stderr);
    // A requested source that is missing is an error.
    let report = bake(&folder, "verify o --source in --json").expect(2).json().remove(0);
    assert_eq!(report["pass"], false);
}

#[test]
fn verify_and_inspect_reject_damaged_packs_with_1() {
    let folder = folder(&[("a.obj", CUBE)]);
    bake(&folder, "build a.obj --out .").expect(0);
    let mut bytes = fs::read(folder.path().join("a.hullmap")).unwrap();
    bytes[200] ^= 4;
    fs::write(folder.path().join("a.hullmap"), bytes).unwrap();
    for line in ["verify a.hullmap", "inspect a.hullmap", "query a.hullmap a.hullmap"] {
        let run = bake(&folder, line).expect(1);
        assert!(run.stderr.contains("a.hullmap") && run.stderr.contains("checksum"), "{line}: {}", run.stderr);
    }
}

#[test]
fn inspect_prints_the_documented_fields() {
    let folder = folder(&[("two.obj", &format!("{CUBE}o dot\nv 3 3 3\np -1\n"))]);
    bake(&folder, "build two.obj --out . --split object --index cubemap").expect(0);
    let run = bake(&folder, "inspect two.hullmap --json").expect(0);
    assert!(run.stderr.is_empty());
    let report = &run.json()[0];
    assert_fields(report, &["file", "format_version", "bytes", "source", "hulls"]);
    let size = fs::metadata(folder.path().join("two.hullmap")).unwrap().len();
    assert_eq!((&report["bytes"], &report["source"]), (&Value::from(size), &Value::from("two.obj")));
    assert_eq!(report["format_version"], hullmap_format::FORMAT_VERSION);
    let [cube, dot] = report["hulls"].as_array().unwrap().as_slice() else { panic!("{report}") };
    for hull in [cube, dot] {
        assert_fields(hull, &["name", "rank", "vertices", "faces", "volume", "surface_area", "centroid", "bounds"]);
        assert_fields(hull, &["diameter", "containment_error", "index"]);
        assert_fields(&hull["index"], &["kind", "bytes", "max_nodes", "max_dots"]);
        assert_eq!(hull["index"]["kind"], "cubemap");
    }
    let near = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 1e-9;
    assert_eq!(
        (&cube["name"], &cube["rank"], &cube["vertices"], &cube["faces"]),
        (&"cube".into(), &3.into(), &8.into(), &6.into())
    );
    assert!(near(&cube["volume"], 1.0) && near(&cube["surface_area"], 6.0) && near(&cube["diameter"], 3_f64.sqrt()));
    // Two of its six faces do not close the cube.
    assert!([cube, dot].iter().all(|hull| hull["mesh_volume"].is_null() && hull["mesh_inertia"].is_null()));
    assert!((0..3).all(|i| near(&cube["centroid"][i], 0.5)
        && near(&cube["bounds"][0][i], 0.0)
        && near(&cube["bounds"][1][i], 1.0)));
    assert_eq!((&dot["name"], &dot["rank"], &dot["vertices"]), (&"dot".into(), &0.into(), &1.into()));
    let text = bake(&folder, "inspect two.hullmap").expect(0);
    assert!(text.stdout.contains("cube") && text.stdout.contains("dot"));
    assert!(text.stdout.contains("mass unknown: it is open, or some triangles are reversed"), "{}", text.stdout);
    let closed = format!("{CUBE}f 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n").replace("f 1 2 4 3\n", "f 3 4 2 1\n");
    fs::write(folder.path().join("closed.obj"), closed).unwrap();
    bake(&folder, "build closed.obj --out .").expect(0);
    let report = &bake(&folder, "inspect closed.hullmap --json").expect(0).json()[0];
    let cube = &report["hulls"][0];
    assert!(near(&cube["mesh_volume"], 1.0) && near(&cube["mesh_centroid"][2], 0.5), "{cube}");
    assert!(near(&cube["mesh_inertia"][0][0], 1.0 / 6.0) && near(&cube["mesh_inertia"][0][1], 0.0), "{cube}");
}

/// Two unit cubes, the second moved along x; most of them overlap in y and z. The expected answer
/// follows from the pose itself.
#[test]
fn query_answers_a_file_of_poses_in_every_mode() {
    let gaps = [-0.75, -0.5, -0.125, 0.25, 1.0, 4.0];
    let mut poses = "# b_in_a: tx ty tz qx qy qz qw\n\n".to_owned();
    for gap in gaps {
        poses += &format!("{} 0.125 -0.0625 0 0 0 1  # gap {gap}\n", 1.0 + gap);
    }
    let folder = folder(&[("cube.obj", CUBE), ("poses.txt", &poses)]);
    bake(&folder, "build cube.obj --out .").expect(0);
    let vector = |value: &Value| -> DVec3 {
        let numbers: Vec<f64> = value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        DVec3::from_slice(&numbers)
    };
    for mode in ["intersect", "distance", "contact"] {
        let run =
            bake(&folder, &format!("query cube.hullmap cube.hullmap#cube --poses poses.txt --mode {mode} --json"));
        let answers = run.expect(0).json();
        assert_eq!(answers.len(), gaps.len(), "{mode}: one line per pose");
        for (pose, (answer, gap)) in answers.iter().zip(gaps).enumerate() {
            assert_fields(
                answer,
                &["hit", "status", "depth", "depth_lower", "depth_upper", "distance", "distance_lower"],
            );
            assert_fields(answer, &["distance_upper", "normal", "point_a", "point_b", "iterations", "support_calls"]);
            assert_eq!(answer["pose"], pose);
            assert_eq!(answer["hit"], gap < 0.0, "{mode}: {answer}");
            assert!(!answer["status"].as_str().unwrap().is_empty());
            let (value, truth) = match mode {
                "distance" => ("distance", f64::max(gap, 0.0)),
                "contact" => ("depth", f64::max(-gap, 0.0)),
                _ => {
                    assert!(answer["depth"].is_null() && answer["distance"].is_null() && answer["normal"].is_null());
                    continue;
                }
            };
            let number = |suffix: &str| answer[format!("{value}{suffix}")].as_f64().unwrap();
            let close = 1e-5 * truth.max(1e-9);
            assert!((number("") - truth).abs() <= close, "{mode}: {answer}");
            assert!(number("_lower") <= truth + 1e-12 && truth <= number("_upper") + 1e-12, "{mode}: {answer}");
            let is_found = if mode == "distance" { gap > 0.0 } else { gap < 0.0 };
            if is_found {
                let normal = vector(&answer["normal"]);
                assert!(normal.abs_diff_eq(DVec3::X, 1e-5), "from A to B: {answer}");
                // The nearest or the deepest points: their separation along the normal is the gap.
                let between = vector(&answer["point_b"]) - vector(&answer["point_a"]);
                assert!((between.x - gap).abs() < 1e-5, "{mode}: {answer}");
            }
        }
    }
    let table = bake(&folder, "query cube.hullmap cube.hullmap --poses poses.txt").expect(0);
    assert_eq!(table.stdout.lines().count(), 1 + gaps.len());
}

#[test]
fn query_rejects_invalid_poses_with_2_before_any_answer() {
    let folder = folder(&[("cube.obj", CUBE), ("poses.txt", "0 0 0 0 0 0 1\n\n0 0 0 0 0 1\n")]);
    bake(&folder, "build cube.obj --out .").expect(0);
    let run = bake(&folder, "query cube.hullmap cube.hullmap --poses poses.txt --json").expect(2);
    assert!(run.stdout.is_empty() && run.stderr.contains("poses.txt:3"), "{run:?}");
    for pose in ["0 0 0 0 0 0 0", "0 0 nan 0 0 0 1", "0 0 0", "a b c d e f g"] {
        let run = bake_in(folder.path(), ["query", "cube.hullmap", "cube.hullmap", "--pose", pose]).expect(2);
        assert!(run.stdout.is_empty() && run.stderr.contains(pose), "{run:?}");
    }
    let run = bake(&folder, "query cube.hullmap#ball cube.hullmap").expect(2);
    assert!(run.stdout.is_empty() && run.stderr.contains("ball"), "{run:?}");
}

#[test]
fn stdout_is_only_data() {
    let folder = folder(&[("in/cloud.obj", "v 0 0 0\nv 1 0 0\n"), ("in/bad.obj", "v 0 0\n")]);
    let run = bake(&folder, "build in --out o --json --verify").expect(1);
    assert_eq!(run.json().len(), 2);
    assert!(run.stderr.contains("note:") && run.stderr.contains("error:"), "{}", run.stderr);
    for line in ["build in --out o", "verify o --source in"] {
        let run = bake(&folder, line);
        assert!(!run.stdout.contains("note:") && !run.stdout.contains("error:"), "{line}: {}", run.stdout);
    }
    for line in ["inspect o/cloud.hullmap --json", "query o/cloud.hullmap o/cloud.hullmap --json", "verify o --json"] {
        assert_eq!(bake(&folder, line).expect(0).json().len(), 1, "{line}");
    }
}

/// The recorded path and the hull's name are part of a pack. A renamed copy of both files was
/// reported as fresh.
#[test]
fn a_renamed_pack_is_not_fresh() {
    let folder = folder(&[("a.obj", CUBE), ("b.obj", CUBE)]);
    bake(&folder, "build a.obj --out .").expect(0);
    fs::copy(folder.path().join("a.hullmap"), folder.path().join("b.hullmap")).unwrap();
    let status = || bake(&folder, "build b.obj --out . --json").expect(0).json()[0]["status"].clone();
    assert_eq!(status(), "baked");
    assert_eq!(status(), "fresh");
    let report = &bake(&folder, "inspect b.hullmap --json").expect(0).json()[0];
    assert_eq!((&report["source"], &report["hulls"][0]["name"]), (&Value::from("b.obj"), &Value::from("b")));
}

#[test]
fn a_folder_is_not_a_pack() {
    let folder = folder(&[("in/a.obj", CUBE)]);
    let run = bake(&folder, "inspect in").expect(2);
    assert!(run.stderr.contains("folder"), "{}", run.stderr);
}
