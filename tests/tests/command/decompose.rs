//! `bake decompose`: one mesh file in, one file of convex parts out.

use std::fs;

use glam::DVec3;
use hullmap::Pack;
use hullmap_outside::{
    command::{Run, bake_in},
    files::workspace,
};
use tempfile::TempDir;

/// A U of three boxes that share faces, as one outline in x and y, in a unit of its own.
const HORSESHOE: &str = "o u
v 100 10 0\nv 103 10 0\nv 103 13 0\nv 102 13 0\nv 102 11 0\nv 101 11 0\nv 101 13 0\nv 100 13 0
v 100 10 1\nv 103 10 1\nv 103 13 1\nv 102 13 1\nv 102 11 1\nv 101 11 1\nv 101 13 1\nv 100 13 1
f 6 5 2 1\nf 8 7 6 1\nf 5 4 3 2
f 9 10 13 14\nf 9 14 15 16\nf 10 11 12 13
f 1 2 10 9\nf 2 3 11 10\nf 3 4 12 11\nf 4 5 13 12\nf 5 6 14 13\nf 6 7 15 14\nf 7 8 16 15\nf 8 1 9 16
";

/// A tetrahedron that follows 16 vertices.
const TETRAHEDRON: &str = "o tip
v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1
f 17 19 18\nf 17 18 20\nf 17 20 19\nf 18 19 20
";

fn folder(text: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("in.obj"), text).unwrap();
    folder
}

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

fn open(folder: &TempDir, pack: &str) -> Pack {
    Pack::open(folder.path().join(pack)).unwrap()
}

/// Names and positions of the objects of an OBJ file.
fn objects(text: &str) -> Vec<(String, Vec<DVec3>)> {
    let mut objects: Vec<(String, Vec<DVec3>)> = Vec::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("o ") {
            objects.push((name.to_owned(), Vec::new()));
        } else if let Some(numbers) = line.strip_prefix("v ") {
            let mut numbers = numbers.split(' ').map(|number| number.parse().unwrap());
            let point = DVec3::from_array(std::array::from_fn(|_| numbers.next().unwrap()));
            objects.last_mut().unwrap().1.push(point);
        }
    }
    objects
}

/// The parts are the hulls of the pack that a build makes, in the frame and unit of the mesh.
#[test]
fn each_mesh_becomes_named_parts_in_its_own_frame() {
    let folder = folder(&(HORSESHOE.to_owned() + TETRAHEDRON));
    let run = bake(&folder, "decompose in.obj new/parts.obj --json").expect(0);
    let report = &run.json()[0];
    let names: Vec<&str> = report["meshes"].as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["u", "tip"], "{report}");
    bake(&folder, "build in.obj --out . --split object --decompose").expect(0);
    let pack = open(&folder, "in.hullmap");
    let objects = objects(&fs::read_to_string(folder.path().join("new/parts.obj")).unwrap());
    assert!(objects.len() >= 3 && objects[0].0 == "u_part_00", "{report}");
    assert_eq!(objects.last().unwrap().0, "tip");
    assert_eq!(report["parts"], objects.len());
    assert_eq!(objects.len(), pack.hull_count());
    for ((name, points), hull) in objects.iter().zip(pack.hulls()) {
        assert_eq!(name, hull.name());
        let expected: Vec<DVec3> = hull.vertices().map(|vertex| vertex.as_dvec3()).collect();
        assert_eq!(points, &expected, "{name}");
    }
    // The volume of the U is 7, and its parts protrude by at most 2 %.
    let u = &report["meshes"][0];
    let diagonal = 19.0_f64.sqrt();
    assert!((u["diagonal"].as_f64().unwrap() - diagonal).abs() < 1e-6, "{u}");
    assert!(u["protrusion"].as_f64().unwrap() <= 0.02 * diagonal * (1.0 + 1e-6), "{u}");
    assert!(u["uncovered"].as_f64().unwrap() <= 1e-6 * diagonal, "{u}");
    assert_eq!(u["solid"], "watertight");
    // Estimates by samples differ from the true volumes by about 1 %.
    let volume: f64 = pack.hulls().take(objects.len() - 1).map(|hull| hull.volume()).sum();
    let union = volume / (1.0 + u["overlap"].as_f64().unwrap());
    assert!((6.8..7.4).contains(&union), "{volume} {union}");
    let run = bake(&folder, "decompose in.obj text.glb").expect(0);
    assert!(run.stdout.starts_with(&format!("u: {} parts, ", objects.len() - 1)), "{run:?}");
    assert!(run.stdout.contains("\ntip: 1 part, 4 vertices; protrusion at most "), "{run:?}");
}

#[test]
fn both_formats_hold_the_same_parts() {
    let folder = folder(HORSESHOE);
    for format in ["obj", "glb"] {
        bake(&folder, &format!("decompose in.obj parts.{format}")).expect(0);
        bake(&folder, &format!("build parts.{format} --out {format} --split object")).expect(0);
    }
    let hulls = |pack: &Pack| -> Vec<(String, Vec<[f32; 3]>)> {
        pack.hulls().map(|hull| (hull.name().to_owned(), hull.vertices().map(|v| v.to_array()).collect())).collect()
    };
    let [obj, glb] = ["obj", "glb"].map(|format| hulls(&open(&folder, &format!("{format}/parts.hullmap"))));
    assert!(obj.len() >= 2);
    assert_eq!(obj, glb);
}

#[test]
fn the_options_of_a_decomposition_apply() {
    let folder = folder(HORSESHOE);
    let report = |options: &str| {
        let line = format!("decompose in.obj parts.obj --force --json {options}");
        bake(&folder, &line).expect(0).json()[0].clone()
    };
    assert_eq!(report("--max-parts 1")["parts"], 1);
    assert!(report("--max-vertices 8 --max-error 5%")["vertices"].as_u64().unwrap() <= 8 * 8);
    let scaled = report("--unit-scale 10 --up-axis y-to-z");
    assert!((scaled["meshes"][0]["diagonal"].as_f64().unwrap() - 1900.0_f64.sqrt()).abs() < 1e-4);
    let objects = objects(&fs::read_to_string(folder.path().join("parts.obj")).unwrap());
    let points = || objects.iter().flat_map(|(_, points)| points);
    let low = points().copied().fold(DVec3::INFINITY, DVec3::min);
    assert!(low.distance(DVec3::new(1000.0, -10.0, 100.0)) < 0.02 * 45.0, "{low}");
    let run = bake(&folder, "decompose in.obj new.obj --max-hulls 4").expect(2);
    assert!(run.stderr.contains("use --max-parts N"), "{run:?}");
}

#[test]
fn outputs_are_checked_before_the_work() {
    let folder = folder(HORSESHOE);
    let kept = folder.path().join("kept.obj");
    fs::write(&kept, "kept").unwrap();
    for (line, words) in [
        ("decompose in.obj kept.obj", "kept.obj: already exists and was not changed"),
        ("decompose in.obj parts.stl", "parts.stl: the format is unknown"),
        ("decompose in.obj parts", "parts: the format is unknown"),
        ("decompose gone.obj parts.obj", "gone.obj: cannot read"),
        ("decompose in.obj ./in.obj --force", "is the mesh itself"),
    ] {
        let run = bake(&folder, line).expect(2);
        assert!(run.stderr.contains(words) && run.stdout.is_empty(), "{line}: {run:?}");
    }
    assert_eq!(fs::read_to_string(&kept).unwrap(), "kept");
    assert_eq!(fs::read_to_string(folder.path().join("in.obj")).unwrap(), HORSESHOE);
    bake(&folder, "decompose in.obj kept.obj --force").expect(0);
    assert!(fs::read_to_string(kept).unwrap().contains("o u_part_00"));
    // Faces are required for parts, and a cloud of points has its hull.
    fs::write(folder.path().join("cloud.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n").unwrap();
    let run = bake(&folder, "decompose cloud.obj cloud.glb").expect(0);
    assert!(run.stdout.contains("1 part, 4 vertices; protrusion unmeasured"), "{run:?}");
    assert!(run.stderr.contains("has no faces"), "{run:?}");
    // A faulty mesh leaves nothing behind.
    fs::write(folder.path().join("bad.obj"), "v 0\n").unwrap();
    let run = bake(&folder, "decompose bad.obj bad.glb").expect(1);
    assert!(run.stderr.contains("bad.obj:1: ") && !folder.path().join("bad.glb").exists(), "{run:?}");
}

/// A box without a lid becomes solid, which a warning says. A small hole in a ring gets none.
#[test]
fn large_openings_that_were_closed_are_warnings() {
    let corner = |i: usize| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
    let open = (0..8).map(corner).collect::<String>() + "f 1 3 4 2\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let folder = folder(&open);
    let run = bake(&folder, "decompose in.obj box.obj").expect(0);
    // One side of five.
    let words = "warning: in: its holes were closed by triangles with 20% of its area";
    assert!(run.stderr.contains(words), "{run:?}");
    fs::write(folder.path().join("torn.obj"), torn_capsule()).unwrap();
    let run = bake(&folder, "decompose torn.obj torn.glb").expect(0);
    assert!(!run.stderr.contains("warning"), "{run:?}");
}

/// A capsule without one of its hundreds of triangles, so that it is not convex.
fn torn_capsule() -> String {
    let capsule = fs::read_to_string(workspace().join("assets/capsule.obj")).unwrap();
    let lines: Vec<&str> = capsule.lines().collect();
    let last = lines.iter().rposition(|line| line.starts_with("f ")).unwrap();
    lines[..last].join("\n") + "\n"
}

#[test]
fn parts_beyond_the_hull_of_a_round_mesh_are_noted() {
    let folder = folder(&torn_capsule());
    let outside = |line: &str| {
        let row = bake(&folder, line).expect(0).json()[0].clone();
        (row["objects"][0]["outside_hull"].as_f64().unwrap(), row["notes"].to_string())
    };
    let few = outside("build in.obj --out few --decompose --json");
    let words = "beyond the convex hull of the mesh, because 64 vertices cannot follow its round faces";
    assert!(few.1.contains(words) && few.1.contains("increase --max-vertices"), "{few:?}");
    let many = outside("build in.obj --out many --decompose --max-vertices 256 --json");
    assert!(!many.1.contains("beyond the convex hull") && many.0 < 0.6 * few.0, "{many:?} {few:?}");
}
