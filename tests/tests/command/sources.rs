//! Folders of meshes in all formats, as in a project: baked, verified, found again, changed, and
//! commented on in warnings.

use std::fs;
use std::path::Path;

use hullmap::Pack;
use hullmap::glam::Vec3;
use hullmap_outside::command::{Run, bake_in};
use serde_json::Value;
use shapes::mesh::Mesh;
use shapes::{gltf, ply, solids, stl};

fn bake(folder: &Path, line: &str) -> Run {
    bake_in(folder, line.split_whitespace())
}

fn column<'a>(run: &'a [Value], key: &str) -> Vec<&'a Value> {
    run.iter().map(|row| &row[key]).collect()
}

fn prism() -> Mesh {
    solids::extrusion(&solids::regular_polygon(7, 1.0), -0.5, 0.5)
}

/// A mesh in every format; one of them has its buffer in a file of its own.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| {
        let path = folder.path().join("meshes").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    };
    let mesh = prism();
    let parts = gltf::parts(&[("prism", &mesh)], r#"{"mesh":0,"name":"node"}"#, "0");
    put("binary.glb", &parts.glb());
    put("deep/text.gltf", parts.text("buffers/text.bin").as_bytes());
    put("deep/buffers/text.bin", &parts.buffer);
    put("solid.stl", &stl::binary(&mesh, "solid but binary"));
    put("words.STL", stl::text(&[("prism", &mesh)]).as_bytes());
    put("big.ply", &ply::file(&mesh, ply::Encoding::Big));
    put("cube.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n");
    put("readme.txt", b"no mesh");
    folder
}

#[test]
fn a_mixed_folder_is_baked_verified_and_found_again() {
    let folder = folder();
    let rows = bake(folder.path(), "build meshes --out out --verify --json").expect(0).json();
    let hulls: Vec<(&str, u64)> =
        rows.iter().map(|row| (row["output"].as_str().unwrap(), row["vertices_hull"].as_u64().unwrap())).collect();
    let expected = [
        ("out/big.hullmap", 14),
        ("out/binary.hullmap", 14),
        ("out/cube.hullmap", 8),
        ("out/deep/text.hullmap", 14),
        ("out/solid.hullmap", 14),
        ("out/words.hullmap", 14),
    ];
    assert_eq!(hulls, expected);
    let verified = bake(folder.path(), "verify out --source meshes --require-source --directions 500 --json").expect(0);
    assert!(column(&verified.json(), "against").iter().all(|against| *against == "source"));

    // Every byte of every file that was read counts, and no other byte.
    let statuses = || -> Vec<String> {
        let rows = bake(folder.path(), "build meshes --out out --json --verbose").expect(0).json();
        column(&rows, "status").iter().map(|status| status.as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(statuses(), ["fresh"; 6]);
    let buffer = folder.path().join("meshes/deep/buffers/text.bin");
    let mut bytes = fs::read(&buffer).unwrap();
    bytes[0] ^= 1;
    fs::write(&buffer, &bytes).unwrap();
    let stale = bake(folder.path(), "verify out/deep --source meshes/deep").expect(1);
    assert!(stale.stderr.contains("stale") || stale.stdout.contains("stale"), "{stale:?}");
    assert_eq!(statuses().iter().filter(|status| *status == "baked").count(), 1);
    fs::remove_file(&buffer).unwrap();
    let missing = bake(folder.path(), "build meshes --out out").expect(1);
    let error = missing.stderr.lines().find(|line| line.contains("buffer buffers/text.bin cannot be read")).unwrap();
    assert!(error.starts_with("error: meshes/deep/text.gltf: "), "{error}");
    for line in ["verify out/deep", "verify out/deep --source meshes/deep", "verify out --source meshes"] {
        let verified = bake(folder.path(), line).expect(1);
        assert!(verified.stderr.lines().any(|line| line == error), "in the same words: {}", verified.stderr);
    }
}

#[test]
fn recentred_hulls_keep_the_digits_of_distant_points() {
    let folder = tempfile::tempdir().unwrap();
    let far = |x: &str, y: &str, z: &str| format!("v 1000000.{x} -2000000.{y} 3000000.{z}\n");
    let corners =
        ["0001", "0003"].map(|x| ["0010", "0040"].map(|y| ["0100", "0900"].map(|z| far(x, y, z)).concat()).concat());
    fs::write(folder.path().join("far.obj"), corners.concat()).unwrap();
    let plain = bake(folder.path(), "build far.obj --out plain --json").expect(0);
    let warnings = plain.json()[0]["warnings"].to_string();
    assert!(warnings.contains("--recentre"), "{warnings}");

    let moved = bake(folder.path(), "build far.obj --out moved --recentre --verify --json").expect(0);
    assert!(!moved.json()[0]["warnings"].to_string().contains("--recentre"));
    let pack = Pack::open(folder.path().join("moved/far.hullmap")).unwrap();
    let hull = pack.hull(0).unwrap();
    let (origin, point) = (hull.origin(), hull.support(Vec3::ONE).point);
    for (axis, expected) in [1.000_000_000_3e6, -2.000_000_001e6, 3.000_000_09e6].into_iter().enumerate() {
        let found = origin[axis] + f64::from(point[axis]);
        assert!((found - expected).abs() < 1e-8, "axis {axis}: {found} for {expected}");
    }
    bake(folder.path(), "verify moved --source . --require-source").expect(0);
}

#[test]
fn artists_parts_are_used_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = prism();
    let nodes = r#"{"mesh":0,"name":"Crate"},{"mesh":0,"name":"UCX_Crate_00","scale":[2,2,2]},{"mesh":0,"name":"UCX_Crate_01"}"#;
    let bytes = gltf::parts(&[("prism", &mesh)], nodes, "0,1,2").glb();
    fs::write(folder.path().join("crate.glb"), bytes).unwrap();
    let run = bake(
        folder.path(),
        "build crate.glb --out out --split auto --unit-scale 0.01 --up-axis y-to-z --verify --json",
    );
    let row = &run.expect(0).json()[0];
    assert_eq!((&row["hulls"], &row["vertices_hull"]), (&2.into(), &28.into()));
    assert!(row["notes"].to_string().contains("collision parts named as in Unreal"), "{row}");
    let pack = Pack::open(folder.path().join("out/crate.hullmap")).unwrap();
    let names: Vec<&str> = pack.hulls().map(|hull| hull.name()).collect();
    assert_eq!(names, ["UCX_Crate_00", "UCX_Crate_01"]);
    // The prism stood along z, which is now turned to -y, and is a hundredth of its size.
    let lowest = pack.hull(1).unwrap().support(Vec3::NEG_Y).point;
    assert!((lowest.y + 0.005).abs() < 1e-9, "{lowest}");
}

#[test]
fn warnings_name_the_hull_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let text = "o sheet\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no blade\nv 0 0 0\nv 100000 0 0\nv 0 1 0\nv 0 0 1\nf 4 5 6\nf 4 5 7\n";
    fs::write(folder.path().join("a.obj"), text).unwrap();
    let run = bake(folder.path(), "build a.obj --out out --split object").expect(0);
    for words in ["warning: a.obj: hull sheet is flat", "warning: a.obj: hull blade is thin"] {
        assert!(run.stderr.contains(words), "{words} in {}", run.stderr);
    }
    let rejected = bake(folder.path(), "build a.obj --out other --split object --max-objects 1").expect(1);
    assert!(rejected.stderr.contains("raise --max-objects"), "{}", rejected.stderr);
    let rejected = bake(folder.path(), "build a.obj --out other --max-input-bytes 10").expect(1);
    assert!(rejected.stderr.contains("raise --max-input-bytes"), "{}", rejected.stderr);
    bake(folder.path(), "build a.obj --out other --max-input-bytes none").expect(2);
}

#[test]
fn a_glb_of_another_format_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.glb"), "solid a\nendsolid a\n").unwrap();
    let run = bake(folder.path(), "build a.glb --out out").expect(1);
    assert!(run.stderr.contains("a.glb: not a glTF document: expected `{`, or `glTF` as in GLB"), "{}", run.stderr);
}

/// The build reported "53 baked, 0 failed", and did not mention 53 meshes in another format.
#[test]
fn meshes_of_other_formats_are_counted_and_listed() {
    let folder = folder();
    for name in ["meshes/solid.usd", "meshes/deep/b.USD", "meshes/scene.fbx", "scans/a.step"] {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }
    let run = bake(folder.path(), "build meshes --out out").expect(0);
    assert!(run.stdout.contains("6 baked, 0 fresh, 0 failed, 3 not read; "), "{}", run.stdout);
    let note = "note: not read: 1 .fbx (FBX), 2 .usd (USD); export them as OBJ, glTF, GLB, STL, PLY, COLLADA or MSH";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    assert_eq!(bake(folder.path(), "build meshes --out out --quiet").expect(0).stderr, "");
    let unread = |line: &str, code: i32| -> Vec<String> {
        let rows = bake(folder.path(), line).expect(code).json();
        let rows = rows.iter().filter(|row| row["status"] == "unread");
        rows.map(|row| format!("{}: {}", row["source"].as_str().unwrap(), row["reason"].as_str().unwrap())).collect()
    };
    let all = [
        "meshes/deep/b.USD: USD is not supported",
        "meshes/scene.fbx: FBX is not supported",
        "meshes/solid.usd: USD is not supported",
    ];
    assert_eq!(unread("build meshes --out out --json", 0), all);
    assert_eq!(unread("build meshes --out out --json --check", 0), all);
    assert_eq!(unread("build meshes --out out --json --exclude *.usd", 0), all[1..2]);
    assert_eq!(unread("build meshes --out out --json --ext stl,obj", 0), [""; 0]);
    let shards: Vec<String> =
        (0..3).flat_map(|index| unread(&format!("build meshes --out out --json --shard {index}/3"), 0)).collect();
    assert_eq!(shards.len(), 3, "each in one shard: {shards:?}");
    fs::write(folder.path().join("meshes/hullmap.toml"), "[[rule]]\nfiles = \"*.fbx\"\nskip = true\n").unwrap();
    assert_eq!(unread("build meshes --out out --json", 0), [all[0], all[2]]);
}

#[test]
fn a_folder_without_meshes_does_not_stop_the_others() {
    let folder = folder();
    fs::create_dir(folder.path().join("textures")).unwrap();
    let run = bake(folder.path(), "build textures meshes --out out --json").expect(2);
    let rows = run.json();
    assert_eq!(rows.len(), 7, "{}", run.stdout);
    assert!(rows[..6].iter().all(|row| row["status"] == "baked"));
    assert_eq!((&rows[6]["status"], &rows[6]["source"]), (&Value::from("failed"), &Value::from("textures")));
    let error =
        "textures: no meshes (OBJ, glTF, GLB, STL, PLY, COLLADA or MSH) in this folder; name a folder of meshes";
    assert!(run.stderr.ends_with(&format!("\nerror: {error}\n")), "{}", run.stderr);
    for (line, others) in [
        ("key textures meshes", "meshes/cube.obj"),
        ("plan textures meshes --out out", "meshes/cube.obj"),
        ("status textures meshes --out out", "6 present"),
    ] {
        let run = bake(folder.path(), line).expect(2);
        assert!(run.stderr.contains(error) && run.stdout.contains(others), "{line}: {}", run.stdout);
    }
    // Alone, it is an error before any work.
    assert!(bake(folder.path(), "build textures --out new").expect(2).stderr.contains(error));
    assert!(!folder.path().join("new").exists());
    // A disk that is not mounted is a folder without meshes: packs of its meshes are kept.
    fs::rename(folder.path().join("meshes"), folder.path().join("disk")).unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    fs::write(folder.path().join("textures/new.obj"), "v 0 0 0\n").unwrap();
    bake(folder.path(), "build meshes textures --out out --prune").expect(2);
    assert!(folder.path().join("out/cube.hullmap").exists() && folder.path().join("out/new.hullmap").exists());
}

/// A stem of 240 characters failed: "cannot write: File name too long; check the folder's
/// permissions", because the temporary name was longer than the pack's.
#[test]
fn names_may_be_long() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x".repeat(247) + ".obj"), "v 0 0 0\n").unwrap();
    bake(folder.path(), "build . --out out").expect(0);
    bake(folder.path(), "build . --out out --check").expect(0);
    fs::write(folder.path().join("x".repeat(248) + ".obj"), "v 0 0 0\n").unwrap();
    let run = bake(folder.path(), "build . --out out").expect(2);
    assert!(run.stderr.contains("; give the mesh a shorter name"), "{}", run.stderr);
}
