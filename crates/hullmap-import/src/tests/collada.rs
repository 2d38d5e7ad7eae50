use std::path::Path;

use super::super::*;

const CORNERS: &str = "0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1";

fn file(asset: &str, primitives: &str, scene: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
         <COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n<asset>{asset}</asset>\n\
         <library_geometries><geometry id=\"g\"><mesh>\n<source id=\"s\"><float_array id=\"a\" count=\"24\">{CORNERS}</float_array>\n\
         <technique_common><accessor source=\"#a\" count=\"8\" stride=\"3\"><param name=\"X\"/><param name=\"Y\"/>\
         <param name=\"Z\"/></accessor></technique_common></source>\n\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#s\"/></vertices>\n{primitives}\n</mesh></geometry></library_geometries>\n\
         <library_visual_scenes><visual_scene id=\"vs\">{scene}</visual_scene></library_visual_scenes>\n\
         <scene><instance_visual_scene url=\"#vs\"/></scene>\n</COLLADA>\n"
    )
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

fn read(text: &str) -> Result<Imported, String> {
    let source = SourceFile::alone(text.as_bytes().to_vec());
    let options = ImportOptions { split: Split::Object, ..ImportOptions::DEFAULT };
    let imported = import("a.dae", "a", Path::new("a.dae"), &source, &options, &Limits::DEFAULT);
    imported.map_err(|error| error.to_string())
}

fn triangles(text: &str) -> Vec<[u32; 3]> {
    let mut imported = read(text).unwrap_or_else(|error| panic!("{error}"));
    imported.give_triangles();
    let set = &imported.point_sets[0];
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
    let lines = read(&file("", &primitive("lines", &[&[0, 7]], ""), NODE)).unwrap();
    assert_eq!(lines.point_sets[0].positions, [[0.0; 3], [1.0; 3]]);
}

#[test]
fn polygons_with_holes_keep_their_outline() {
    let polygon = format!("<polygons>{INPUTS}<ph><p>7 0 7 1 7 3 7 2</p><h>7 4 7 5 7 6</h></ph></polygons>");
    let text = file("", &polygon, NODE);
    assert_eq!(triangles(&text), [[0, 1, 3], [0, 3, 2]]);
    assert!(read(&text).unwrap().warnings.iter().any(|warning| warning.contains("polygons have holes")));
}

fn corner(asset: &str, transforms: &str) -> [f32; 3] {
    let scene = format!("<node>{transforms}<instance_geometry url=\"#g\"/></node>");
    read(&file(asset, &primitive("triangles", &[&[1, 0, 2]], ""), &scene)).unwrap().point_sets[0].positions[0]
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
    let notes =
        read(&file("<unit meter=\"0.001\"/><up_axis>Y_UP</up_axis>", &primitive("triangles", &[&[1, 0, 2]], ""), NODE));
    let notes = notes.unwrap().notes.join("; ");
    assert!(notes.contains("unit is 0.001 m") && notes.contains("up axis Y_UP, which is not applied"), "{notes}");
}

#[test]
fn instances_are_objects_and_mirrors_turn_faces() {
    let scene = "<node name=\"a\"><instance_geometry url=\"#g\"/></node>\
                 <node name=\"b\"><scale>-1 1 1</scale><instance_geometry url=\"#g\"/></node>\
                 <node name=\"c\"><instance_node url=\"#far\"/></node><node id=\"far\" name=\"d\"><translate>9 0 0</translate>\
                 <instance_geometry url=\"#g\"/></node>";
    let mut imported = read(&file("", &primitive("triangles", &[&[0, 1, 2]], ""), scene)).unwrap();
    imported.give_triangles();
    let names: Vec<&str> = imported.point_sets.iter().map(|set| set.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "d", "d_2"], "one for each instance");
    assert_eq!(imported.point_sets[1].triangles, [[2, 1, 0]]);
    assert_eq!(imported.point_sets[2].positions[0], [9.0, 0.0, 0.0]);
}

#[test]
fn a_file_without_a_scene_shows_all_geometries() {
    let text = file("", &primitive("triangles", &[&[0, 1, 2]], ""), NODE);
    let (head, rest) = text.split_once("<library_visual_scenes>").unwrap();
    let tail = rest.split_once("</scene>").unwrap().1;
    assert_eq!(triangles(&format!("{head}{tail}")), [[0, 1, 2]]);
}

#[test]
fn damaged_files_are_errors_with_lines() {
    let usual = primitive("triangles", &[&[0, 1, 2]], "");
    let cycle = "<node id=\"x\"><instance_node url=\"#y\"/></node><node id=\"y\"><instance_node url=\"#x\"/></node>";
    for (text, expected) in [
        (file("", &primitive("triangles", &[&[0, 1, 8]], ""), NODE), "a.dae:8: vertex index `8` is out of range"),
        (file("", &primitive("triangles", &[&[0, 1]], ""), NODE), "does not end with a face"),
        (file("", &primitive("polylist", &[&[0, 1, 2]], "<vcount>4</vcount>"), NODE), "does not end with a face"),
        (file("", &primitive("polylist", &[&[0, 1, 2]], ""), NODE), "does not end with a face"),
        (file("<unit meter=\"0\"/>", &usual, NODE), "correct `unit meter`"),
        (file("", &usual, cycle), "instances may form a cycle"),
        (file("", &usual, "<node><instance_geometry url=\"#gone\"/></node>"), "there is no geometry `gone`"),
        (file("", &usual, "<node><instance_geometry url=\"b.dae#g\"/></node>"), "does not name a part of this file"),
        (file("", &usual, "<node><skew>1 2 3 4 5 6 7</skew></node>"), "`skew`, which is not supported"),
        (file("", &usual, "<node><matrix>1 2 3</matrix></node>"), "`matrix` has 3 numbers; expected 16"),
        (file("", &usual, ""), "the scene shows no geometry"),
        (
            file("", &usual, NODE).replace("1 1 1</float_array>", "1 1 nan</float_array>"),
            "`nan` is not a finite number",
        ),
        (file("", &usual, NODE).replace("1 1 1</float_array>", "</float_array>"), "the accessor states 8 positions"),
        ("<COLLADA>".to_owned(), "invalid XML"),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><COLLADA/>".to_owned(), "remove <!DOCTYPE>"),
        ("<robot/>".to_owned(), "the root is `robot`, not `COLLADA`"),
        (" ".to_owned(), "the file is empty"),
        ("<a>".repeat(3_000_000), "XML"),
    ] {
        let error = read(&text).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn instances_are_limited() {
    let doubled = (0..24).map(|level| {
        let inner = format!("<instance_node url=\"#n{}\"/>", level + 1).repeat(2);
        format!("<node id=\"n{level}\">{inner}</node>")
    });
    let scene = doubled.collect::<String>() + "<node id=\"n24\"><instance_geometry url=\"#g\"/></node>";
    let error = read(&file("", &primitive("triangles", &[&[0, 1, 2]], ""), &scene)).unwrap_err();
    assert!(error.contains("nodes") || error.contains("instances add more"), "{error}");
}
