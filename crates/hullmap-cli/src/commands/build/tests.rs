use std::path::Path;

use hullmap_bake::progress::Stage;
use hullmap_bake::{PointSet, SourceRecord};

use super::once::run;
use crate::args::{Command, parse};
use crate::terminal::Output;
use hullmap_pipeline::baker::BakedPack;
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::{Exit, Failure};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn write_text(sets: &[PointSet], options: &BuildOptions, source: &SourceRecord, _: Stage) -> Result<BakedPack, String> {
    if source.path.ends_with("rejected.obj") {
        return Err("hull x: lost a point".to_owned());
    }
    assert!(!source.path.ends_with("panics.obj"), "on purpose");
    let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
    let text = format!("{} {:x} {options} {names:?}", source.path, source.hash);
    let vertex_count = sets.iter().map(|set| set.positions.len()).sum();
    let (bytes, ranks) = (text.into_bytes(), vec![2; sets.len()]);
    Ok(BakedPack { bytes, ranks, vertex_count, ..BakedPack::default() })
}

fn build(folder: &Path, files: &[(&str, &str)], words: &[&str]) -> (Result<Exit, Failure>, String) {
    for (name, text) in files {
        let path = folder.join("in").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let (input, output) = (folder.join("in"), folder.join("out"));
    let mut line = vec!["bake", "build", input.to_str().unwrap(), "--out", output.to_str().unwrap()];
    line.extend(words);
    let Command::Build(args) = parse(line).unwrap().command else { unreachable!() };
    let mut out = Vec::new();
    let result = run(&args, folder, &write_text, &mut Output::new(&mut out));
    (result, String::from_utf8(out).unwrap())
}

fn json_rows(text: &str) -> Vec<serde_json::Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn one_bad_file_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("a.obj", TRIANGLE),
        ("b.obj", "v 0 0 0\nv 0 nan 0\n"),
        ("panics.obj", TRIANGLE),
        ("rejected.obj", TRIANGLE),
        ("sub/z.obj", TRIANGLE),
    ];
    let (result, text) = build(folder.path(), &files, &["--json"]);
    assert_eq!(result.unwrap(), Exit::Rejected);
    let rows = json_rows(&text);
    let statuses: Vec<_> = rows.iter().map(|row| row["status"].as_str().unwrap()).collect();
    assert_eq!(statuses, ["baked", "failed", "failed", "failed", "baked"]);
    assert!(rows[1]["error"].as_str().unwrap().contains("b.obj:2: coordinate `nan`"), "{}", rows[1]);
    assert!(rows[2]["error"].as_str().unwrap().contains("internal error (on purpose)"), "{}", rows[2]);
    assert!(rows[3]["error"].as_str().unwrap().contains("rejected.obj: hull x: lost a point"), "{}", rows[3]);
    assert!(rows[0]["error"].is_null());
    for key in ["source", "output", "status", "hulls", "vertices_in", "vertices_hull", "bytes", "millis", "error"] {
        assert!(rows.iter().all(|row| row.get(key).is_some()), "{key}");
    }
    assert_eq!(
        (&rows[0]["hulls"], &rows[0]["vertices_in"], &rows[0]["vertices_hull"]),
        (&1.into(), &3.into(), &3.into())
    );
    assert!(folder.path().join("out/sub/z.hullmap").is_file());
    let names: Vec<_> = std::fs::read_dir(folder.path().join("out")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "nothing but a.hullmap and sub: {names:?}");
}

#[test]
fn rows_have_the_order_of_the_inputs_for_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..40).map(|index| format!("{index:02}.obj")).collect();
    let files: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), TRIANGLE)).collect();
    for jobs in ["1", "4"] {
        let (result, text) = build(folder.path(), &files, &["--json", "--jobs", jobs]);
        assert_eq!(result.unwrap(), Exit::Done);
        for (row, name) in json_rows(&text).iter().zip(&names) {
            assert!(row["source"].as_str().unwrap().ends_with(name));
        }
    }
}
