//! `bake verify` finds each kind of wrong pack, and `bake query` answers as the poses imply.

use std::{collections::BTreeSet, fs};

use glam::DVec3;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::{header::source_hash, slot::Slot};
use hullmap_outside::command::bake_line as bake;
use hullmap_outside::files::folder;
use hullmap_testkit::packs::{self, point_set};
use serde_json::Value;
use shapes::families::Family;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

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
