//! COLLADA files whose import is not in `imports.txt`.

use super::*;

const TRIANGLE: &str = "<polylist><input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/>\
                        <input semantic=\"NORMAL\" source=\"#n\" offset=\"0\"/><vcount>3</vcount><p>7 0 7 1 7 2</p></polylist>";

const NODE: &str = "<node id=\"n\" name=\"part\"><instance_geometry url=\"#g\"/></node>";

/// A file of a triangle, with these nodes.
fn file(nodes: &str) -> String {
    section_file("a.dae", &format!("ASSET \nPRIMITIVES {TRIANGLE}\nNODES {nodes}"))
}

#[test]
fn a_file_without_a_scene_shows_all_geometries() {
    let text = file(NODE);
    let (head, rest) = text.split_once("<library_visual_scenes>").unwrap();
    let (_, tail) = rest.split_once("</scene>").unwrap();
    let imported = import_file("a.dae", format!("{head}{tail}"), OBJECTS).unwrap();
    assert_eq!(triangles(&imported), [[0, 1, 2]]);
}

#[test]
fn damaged_files_are_errors_with_lines() {
    check_damages("collada", &file(NODE), |text| import_file("a.dae", text, OBJECTS));
    fails(import_file("a.dae", "<a>".repeat(3_000_000), OBJECTS), "XML");
}

#[test]
fn instances_are_limited() {
    let doubled = (0..24).map(|level| {
        let inner = format!("<instance_node url=\"#n{}\"/>", level + 1).repeat(2);
        format!("<node id=\"n{level}\">{inner}</node>")
    });
    let nodes = doubled.collect::<String>() + "<node id=\"n24\"><instance_geometry url=\"#g\"/></node>";
    let error = import_file("a.dae", file(&nodes), OBJECTS).unwrap_err().to_string();
    assert!(error.contains("nodes") || error.contains("instances add more"), "{error}");
}
