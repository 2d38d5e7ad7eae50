use super::*;

/// A file of the corners of a cube, with these elements.
fn file(asset: &str, primitives: &str, nodes: &str) -> String {
    include_str!("cube.dae").replace("ASSET", asset).replace("PRIMITIVES", primitives).replace("NODES", nodes)
}

const INPUTS: &str =
    "<input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/><input semantic=\"NORMAL\" source=\"#n\" offset=\"0\"/>";

/// A primitive whose corners are these, each with the index of a normal before it.
fn primitive(kind: &str, lists: &[&[u32]], more: &str) -> String {
    let list = |corners: &&[u32]| {
        let words: Vec<String> = corners.iter().map(|corner| format!("7 {corner}")).collect();
        format!("<p>{}</p>", words.join(" "))
    };
    format!("<{kind}>{INPUTS}{more}{}</{kind}>", lists.iter().map(list).collect::<String>())
}

const NODE: &str = "<node id=\"n\" name=\"part\"><instance_geometry url=\"#g\"/></node>";

fn triangle() -> String {
    primitive("triangles", &[&[0, 1, 2]], "")
}

fn read(text: &str) -> Imported {
    let mut imported = import_file("a.dae", text, OBJECTS).unwrap();
    imported.give_triangles();
    imported
}

fn triangles(text: &str) -> Vec<[u32; 3]> {
    let set = &read(text).point_sets[0];
    set.triangles.iter().map(|corners| corners.map(|corner| set.source_vertices[corner as usize])).collect()
}

#[test]
fn every_primitive_has_its_faces() {
    let square = [[0, 1, 3], [0, 3, 2]];
    for (kind, lists, more, expected) in [
        ("triangles", &[&[0, 1, 3, 0, 3, 2][..]][..], "", &square[..]),
        ("polylist", &[&[0, 1, 3, 0, 3, 2]], "<vcount>3 3</vcount>", &square),
        ("polylist", &[&[0, 1, 3, 2]], "<vcount>4</vcount>", &square),
        ("polygons", &[&[0, 1, 3, 2]], "", &square),
        ("trifans", &[&[0, 1, 3, 2]], "", &square),
        ("tristrips", &[&[0, 1, 2, 3]], "", &[[0, 1, 2], [2, 1, 3]]),
        ("trifans", &[&[0, 1, 3], &[0, 3, 2]], "", &square),
    ] {
        assert_eq!(triangles(&file("", &primitive(kind, lists, more), NODE)), expected, "{kind}");
    }
    let lines = read(&file("", &primitive("lines", &[&[0, 7]], ""), NODE));
    assert_eq!(lines.point_sets[0].positions, [[0.0; 3], [1.0; 3]]);
}

#[test]
fn polygons_with_holes_keep_their_outline() {
    let polygon = format!("<polygons>{INPUTS}<ph><p>7 0 7 1 7 3 7 2</p><h>7 4 7 5 7 6</h></ph></polygons>");
    let text = file("", &polygon, NODE);
    assert_eq!(triangles(&text), [[0, 1, 3], [0, 3, 2]]);
    assert!(read(&text).warnings.iter().any(|warning| warning.contains("polygons have holes")));
}

fn corner(asset: &str, transforms: &str) -> [f32; 3] {
    let scene = format!("<node>{transforms}<instance_geometry url=\"#g\"/></node>");
    read(&file(asset, &triangle(), &scene)).point_sets[0].positions[0]
}

#[test]
fn transforms_are_applied_in_their_order_and_units_last() {
    for (asset, transforms, expected) in [
        ("", "", [0.0, 0.0, 0.0]),
        ("", "<translate>1 2 3</translate><rotate>0 0 1 90</rotate>", [1.0, 2.0, 3.0]),
        ("", "<rotate>0 0 1 90</rotate><translate>1 2 3</translate>", [-2.0, 1.0, 3.0]),
        ("", "<scale>2 3 4</scale><translate>1 1 1</translate>", [2.0, 3.0, 4.0]),
        ("", "<matrix>0 -1 0 5  1 0 0 6  0 0 1 7  0 0 0 1</matrix>", [5.0, 6.0, 7.0]),
        ("", "<lookat>4 5 6  4 5 0  0 1 0</lookat>", [4.0, 5.0, 6.0]),
        ("<unit name=\"inch\" meter=\"0.0254\"/>", "<translate>100 0 0</translate>", [2.54, 0.0, 0.0]),
        ("<unit meter=\"0.001\"/><up_axis>Y_UP</up_axis>", "<translate>0 1000 0</translate>", [0.0, 1.0, 0.0]),
    ] {
        let found = corner(asset, transforms);
        let is_near = found.iter().zip(expected).all(|(a, b)| (a - b as f32).abs() < 1e-6);
        assert!(is_near, "{asset}{transforms}: {found:?}, {expected:?}");
    }
    let imported = read(&file("<unit meter=\"0.001\"/><up_axis>Y_UP</up_axis>", &triangle(), NODE));
    has_note(&imported, "unit is 0.001 m");
    has_note(&imported, "up axis Y_UP, which is not applied");
}

#[test]
fn instances_are_objects_and_mirrors_turn_faces() {
    let scene = "<node name=\"a\"><instance_geometry url=\"#g\"/></node>\
                 <node name=\"b\"><scale>-1 1 1</scale><instance_geometry url=\"#g\"/></node>\
                 <node name=\"c\"><instance_node url=\"#far\"/></node><node id=\"far\" name=\"d\"><translate>9 0 0</translate>\
                 <instance_geometry url=\"#g\"/></node>";
    let imported = read(&file("", &triangle(), scene));
    assert_eq!(names(&imported), ["a", "b", "d", "d_2"], "one for each instance");
    assert_eq!(imported.point_sets[1].triangles, [[2, 1, 0]]);
    assert_eq!(imported.point_sets[2].positions[0], [9.0, 0.0, 0.0]);
}

#[test]
fn a_file_without_a_scene_shows_all_geometries() {
    let text = file("", &triangle(), NODE);
    let (head, rest) = text.split_once("<library_visual_scenes>").unwrap();
    let tail = rest.split_once("</scene>").unwrap().1;
    assert_eq!(triangles(&format!("{head}{tail}")), [[0, 1, 2]]);
}

#[test]
fn damaged_files_are_errors_with_lines() {
    let good = file("", &primitive("polylist", &[&[0, 1, 2]], "<vcount>3</vcount>"), NODE);
    check_damages("collada", &good, |text| import_file("a.dae", text, OBJECTS));
    fails(import_file("a.dae", "<a>".repeat(3_000_000), OBJECTS), "XML");
}

#[test]
fn instances_are_limited() {
    let doubled = (0..24).map(|level| {
        let inner = format!("<instance_node url=\"#n{}\"/>", level + 1).repeat(2);
        format!("<node id=\"n{level}\">{inner}</node>")
    });
    let scene = doubled.collect::<String>() + "<node id=\"n24\"><instance_geometry url=\"#g\"/></node>";
    let error = import_file("a.dae", file("", &triangle(), &scene), OBJECTS).unwrap_err().to_string();
    assert!(error.contains("nodes") || error.contains("instances add more"), "{error}");
}
