//! Colliders of physics extensions, read with `--split auto`.

use shapes::gltf;
use shapes::solids::{extrusion, regular_polygon};

use super::*;

fn read(text: &str) -> Imported {
    import_file("a.gltf", text, AUTO).unwrap()
}

fn file(nodes: &str, roots: &str, members: &str) -> String {
    let ring = extrusion(&regular_polygon(12, 2.0), 0.0, 1.0);
    let prism = extrusion(&regular_polygon(5, 1.0), -0.5, 0.5);
    let text = gltf::parts(&[("ring", &ring), ("prism", &prism)], nodes, roots).text_with_data();
    text.replacen('{', &format!("{{{members}"), 1)
}

fn bounds(imported: &Imported, index: usize) -> [[f32; 3]; 2] {
    let points = &imported.point_sets[index].positions;
    let pick =
        |by: fn(f32, f32) -> f32| [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).reduce(by).unwrap());
    [pick(f32::min), pick(f32::max)]
}

const OMI_SHAPES: &str = r#""extensions":{"OMI_physics_shape":{"shapes":[{"type":"convex","convex":{"mesh":1}},{"type":"trimesh","trimesh":{"mesh":1}},{"type":"box","box":{"size":[2,4,6]}},{"type":"capsule"},{"type":"capsule","capsule":{"radius":2,"height":3}}]}},"extensionsRequired":["OMI_physics_shape","OMI_physics_body"],"#;

fn omi(shape: i32) -> String {
    format!(r#""extensions":{{"OMI_physics_body":{{"collider":{{"shape":{shape}}}}}}}"#)
}

fn khr(geometry: &str) -> String {
    format!(r#""extensions":{{"KHR_physics_rigid_bodies":{{"collider":{{"geometry":{geometry}}}}}}}"#)
}

/// The parts are those that the extension names, wherever their meshes are, and stand for the mesh
/// of the nearest node above.
#[test]
fn omi_colliders_are_parts() {
    let nodes = format!(
        r#"{{"name":"body","mesh":0,"children":[1,2]}},{{"name":"hull","translation":[10,0,0],{}}},{{"name":"box",{}}},{{"name":"join",{}}}"#,
        omi(0),
        omi(2),
        omi(-1)
    );
    let imported = read(&file(&nodes, "0,3", OMI_SHAPES));
    assert_eq!(names(&imported), ["hull", "box"]);
    assert_eq!(imported.point_sets[0].positions.len(), 10);
    assert_eq!(bounds(&imported, 1), [[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]]);
    assert!(bounds(&imported, 0)[0][0] > 8.0);
    for set in &imported.point_sets {
        assert_eq!(set.stands_for.as_ref().unwrap().name, "body");
    }
    let notes = imported.notes.join("; ");
    assert!(notes.contains("one hull each: 2") && notes.contains("left out: 1"), "{notes}");
    assert!(!notes.contains("meshes outside the scene"), "{notes}");
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    // Without --split auto, colliders are no part of the shape.
    for options in [WHOLE, OBJECTS] {
        let imported = import_file("a.gltf", file(&nodes, "0,3", OMI_SHAPES), options).unwrap();
        assert_eq!(imported.point_sets.len(), 1);
        assert_eq!(imported.point_sets[0].positions.len(), 24);
    }
}

#[test]
fn khr_colliders_are_parts() {
    let shapes = r#""extensions":{"KHR_implicit_shapes":{"shapes":[{"type":"sphere","sphere":{"radius":2}},{"type":"cylinder","cylinder":{"height":4,"radiusTop":0,"radiusBottom":1}},{"type":"box"},{"type":"capsule","capsule":{"height":2,"radiusTop":0.5,"radiusBottom":1}},{"type":"plane","plane":{"sizeX":2,"sizeZ":3}},{"type":"plane"}]}},"extensionsRequired":["KHR_implicit_shapes","KHR_physics_rigid_bodies"],"#;
    let parts = [
        ("mesh", r#"{"mesh":1,"convexHull":true}"#),
        ("node", r#"{"node":10,"convexHull":true}"#),
        ("tree", r#"{"node":11,"convexHull":true}"#),
        ("sphere", r#"{"shape":0}"#),
        ("cone", r#"{"shape":1}"#),
        ("box", r#"{"shape":2}"#),
        ("capsule", r#"{"shape":3}"#),
        ("sheet", r#"{"shape":4}"#),
        ("plane", r#"{"shape":5}"#),
    ];
    let mut nodes = vec![r#"{"name":"body","mesh":0}"#.to_owned()];
    nodes.extend(
        parts.iter().map(|(name, geometry)| format!(r#"{{"name":"{name}","scale":[-1,1,2],{}}}"#, khr(geometry))),
    );
    nodes.push(r#"{"name":"holder","mesh":1,"translation":[50,0,0]}"#.to_owned());
    nodes.push(r#"{"name":"top","mesh":1,"children":[12]}"#.to_owned());
    nodes.push(r#"{"name":"below","mesh":1,"translation":[0,7,0]}"#.to_owned());
    let imported = read(&file(&nodes.join(","), "0,1,2,3,4,5,6,7,8,9", shapes));
    assert_eq!(names(&imported), ["mesh", "node", "tree", "sphere", "cone", "box", "capsule", "sheet"]);
    assert_eq!(bounds(&imported, 0), bounds(&imported, 1));
    assert_eq!(bounds(&imported, 2)[1][1], bounds(&imported, 0)[1][1] + 7.0);
    assert_eq!(bounds(&imported, 3), [[-2.0, -2.0, -4.0], [2.0, 2.0, 4.0]]);
    assert_eq!(bounds(&imported, 4), [[-1.0, -2.0, -2.0], [1.0, 2.0, 2.0]]);
    assert_eq!(bounds(&imported, 5), [[-0.5, -0.5, -1.0], [0.5, 0.5, 1.0]]);
    assert_eq!(bounds(&imported, 6), [[-1.0, -2.0, -2.0], [1.0, 1.5, 2.0]]);
    assert_eq!(bounds(&imported, 7), [[-1.0, 0.0, -3.0], [1.0, 0.0, 3.0]]);
    assert_eq!(imported.warnings.len(), 1);
    assert!(imported.warnings[0].contains("(plane) has a plane without end"), "{:?}", imported.warnings);
    has_note(&imported, "2 % of the radius inside: 3");
}

/// The extension alone names the mesh: no node draws it. `--split none` reports the remedy.
#[test]
fn files_of_colliders_alone_are_read() {
    let text = file(&format!(r#"{{"name":"only",{}}}"#, omi(0)), "0", OMI_SHAPES);
    let imported = read(&text);
    assert_eq!(names(&imported), ["only"]);
    assert!(imported.point_sets[0].stands_for.is_none());
    fails(import_file("a.gltf", text, WHOLE), "has colliders: add --split auto");
}

#[test]
fn a_collider_of_both_extensions_is_one_part() {
    let both = format!(
        r#""extensions":{{"KHR_physics_rigid_bodies":{{"collider":{{"geometry":{{"mesh":1,"convexHull":true}}}}}},{}"#,
        &omi(2)["\"extensions\":{".len()..]
    );
    let imported = read(&file(&format!(r#"{{"name":"a",{both}}}"#), "0", OMI_SHAPES));
    assert_eq!(names(&imported), ["a"]);
    assert_eq!(imported.point_sets[0].positions.len(), 10);
    // Older drafts have one radius. A trigger is not a collider.
    let nodes = format!(
        r#"{{"name":"old",{}}},{{"name":"t","extensions":{{"OMI_physics_body":{{"trigger":{{"shape":0}}}}}}}}"#,
        omi(4)
    );
    let imported = read(&file(&nodes, "0,1", OMI_SHAPES));
    assert_eq!(names(&imported), ["old"]);
    assert_eq!(bounds(&imported, 0), [[-2.0, -3.5, -2.0], [2.0, 3.5, 2.0]]);
}

#[test]
fn colliders_of_triangles_have_a_warning() {
    let nodes = format!(r#"{{"name":"t",{}}},{{"name":"k",{}}}"#, omi(1), khr(r#"{"mesh":1}"#));
    let imported = read(&file(&nodes, "0,1", OMI_SHAPES));
    assert_eq!(names(&imported), ["t", "k"]);
    assert!(imported.warnings[0].contains("2 colliders are of triangles (the first is t)"), "{:?}", imported.warnings);
}

#[test]
fn faulty_extensions_are_rejected_only_if_they_are_read() {
    for (collider, words) in [
        (omi(9), "collider shape 9, which does not exist (OMI_physics_shape has 5)"),
        (khr(r#"{"shape":0}"#), "KHR_implicit_shapes has 0"),
        (khr("{}"), "without a shape, a mesh or a node"),
        (khr("[1]"), "cannot be read"),
        (khr(r#"{"mesh":7}"#), "mesh index 7, which is out of range"),
        (khr(r#"{"node":7}"#), "node index 7, which is out of range"),
        (khr(r#"{"node":1}"#), "cycle of nodes"),
    ] {
        let nodes = format!(r#"{{"name":"a",{collider}}},{{"children":[2]}},{{"children":[1]}},{{"mesh":0}}"#);
        let text = file(&nodes, "0,3", OMI_SHAPES);
        let error = import_file("a.gltf", &text, AUTO).expect_err(words).to_string();
        assert!(error.contains(words) && error.contains("node 0 (a)"), "{error}");
        assert_eq!(import_file("a.gltf", &text, WHOLE).unwrap().vertex_count, 24);
    }
}

#[test]
fn colliders_count_against_the_limit_on_repetition() {
    let node = format!("{{{}}}", khr(r#"{"mesh":1}"#));
    let nodes = vec![node; 30_000].join(",");
    let roots = (0..30_000).map(|index| index.to_string()).collect::<Vec<_>>().join(",");
    let limits = Limits { repeated_vertices: 10_000, ..Limits::DEFAULT };
    let source = SourceFile::alone(file(&nodes, &roots, "").into_bytes());
    fails(crate::import("a.gltf", "a", Path::new("a.gltf"), &source, &AUTO, &limits), "max_instanced");
}
