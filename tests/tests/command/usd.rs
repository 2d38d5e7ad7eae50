//! `bake export --for usd`: a layer over a stage. `tests/usd/check.py` reads such layers.

use std::fs;

use hullmap_bake::{IndexKind, PointSet, SourceRecord};
use hullmap_outside::command::{Run, bake_in};
use hullmap_testkit::packs::{self, point_set};
use tempfile::TempDir;

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

fn write_pack(folder: &TempDir, path: &str, sets: &[PointSet]) {
    let bytes = packs::bytes(sets, IndexKind::None, &SourceRecord::default()).unwrap();
    fs::write(folder.path().join(path), bytes).unwrap();
}

fn tetrahedron(name: &str) -> PointSet {
    point_set(name, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]])
}

#[test]
fn hulls_of_all_packs_are_beside_their_meshes() {
    let folder = tempfile::tempdir().unwrap();
    write_pack(&folder, "a.hullmap", &[tetrahedron("seat"), tetrahedron("leg")]);
    write_pack(&folder, "b.hullmap", &[tetrahedron("back rest")]);
    let line = "export a.hullmap b.hullmap --for usd --prim /World/chair --asset ./chair.usd";
    let run = bake(&folder, &format!("{line} --meters-per-unit 0.01 --stage-up y --out deep/hulls.usda")).expect(0);
    assert!(run.stdout.starts_with("deep/hulls.usda: 3 hulls, 12 vertices, 12 triangles"), "{run:?}");
    assert!(run.stderr.contains("/World/chair/seat: the mass comes from its hulls"), "{run:?}");
    let text = fs::read_to_string(folder.path().join("deep/hulls.usda")).unwrap();
    for part in [
        "#usda 1.0\n(\n    defaultPrim = \"World\"\n",
        "@./chair.usd@",
        "metersPerUnit = 0.01",
        "upAxis = \"Y\"",
        "over \"World\"",
        "over \"back_rest\"",
        "def Xform \"back_rest_hulls\"",
        "def Xform \"seat_hulls\"",
        "bool physics:collisionEnabled = 0",
        "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0.1)]",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    // The density is the density of water, in cubic centimetres.
    let mass: f64 = text.split("physics:mass = ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
    assert!((mass / (0.1 / 6.0 * 1e-3) - 1.0).abs() < 1e-6, "{mass}");
    let run = bake(&folder, &format!("{line} --out deep/hulls.usda")).expect(2);
    assert!(run.stderr.contains("already exists"), "{run:?}");
    let printed = bake(&folder, line).expect(0).stdout;
    assert!(printed.contains("metersPerUnit = 1\n") && printed.contains("upAxis = \"Z\"\n"), "{printed}");
}

/// The names in a pack are untrusted.
#[test]
fn untrusted_names_stay_names() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["a\"\n}\ndef Mesh \"evil", "@x@", "größe", "", "2nd", "../up", "tail\\"];
    write_pack(&folder, "x.hullmap", &names.map(tetrahedron));
    let text = bake(&folder, "export x.hullmap --for usd --prim /W").expect(0).stdout;
    assert_eq!(text.matches("def Xform \"").count(), names.len());
    assert_eq!(text.matches("def Mesh \"").count(), names.len());
    assert!(!text.contains("\"evil") && text.contains("def Xform \"a____def_Mesh__evil_hulls\""), "{text}");
    let names = ["seat@", "seat!"];
    write_pack(&folder, "y.hullmap", &names.map(tetrahedron));
    let run = bake(&folder, "export y.hullmap --for usd --prim /W --out y.usda").expect(1);
    assert!(run.stderr.contains("both stand for the prim /W/seat_"), "{run:?}");
    assert!(!folder.path().join("y.usda").exists());
}

#[test]
fn wrong_usage_names_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    write_pack(&folder, "x.hullmap", &[tetrahedron("a")]);
    write_pack(&folder, "flat.hullmap", &[point_set("b", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])]);
    for (line, message) in [
        ("x.hullmap --for usd", "add --prim"),
        ("x.hullmap --for usd --prim World", "is not the path of a prim"),
        ("x.hullmap --for usd --prim /a{v=b}c", "is not the path of a prim"),
        ("x.hullmap --for usd --prim /W --format obj", "leave out --format"),
        ("x.hullmap --for usd --prim /W --parts --out y", "one file"),
        ("x.hullmap --for usd --prim /W --out .", "one file"),
        ("x.hullmap --for usd --prim /W --out y.glb", ".usda"),
        ("x.hullmap flat.hullmap --for usd --prim /W --name c", "--name: several packs"),
        ("x.hullmap --for usd --prim /W --meters-per-unit 0", "above 0"),
        ("x.hullmap --format obj --prim /W", "--prim: only for USD"),
        ("x.hullmap --for godot --out y.glb --stage-up y", "--stage-up: only for USD"),
    ] {
        let run = bake(&folder, &format!("export {line}")).expect(2);
        assert!(run.stderr.contains(message) && run.stdout.is_empty(), "{line}: {run:?}");
    }
    let run = bake(&folder, "export flat.hullmap --for usd --prim /W").expect(1);
    assert!(run.stderr.contains("USD takes solids only"), "{run:?}");
    let text = bake(&folder, "export x.hullmap --for usd --prim / --name mesh").expect(0).stdout;
    assert!(text.contains("\ndef Xform \"mesh_hulls\"") && !text.contains("defaultPrim"), "{text}");
}
