//! `bake decompose`: one mesh file in, one file of convex parts out.

use std::fs;

use glam::DVec3;
use hullmap::Pack;
use hullmap_outside::command::bake_line as bake;
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
