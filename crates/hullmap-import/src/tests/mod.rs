//! Import of literal OBJ texts.

mod collada;
mod draco;
mod formats;
mod gltf;
mod growth;
mod limits;
mod meshopt;
mod physics;

use std::path::Path;

use shapes::{mesh::Mesh, solids};

use super::fault::Fault;
use super::*;
use crate::options::Split;

/// A prism, moved so that no coordinate is an integer.
fn prism(sides: usize) -> Mesh {
    let mut mesh = solids::extrusion(&solids::regular_polygon(sides, 1.0), -0.3, 0.7);
    mesh.vertices.iter_mut().for_each(|v| *v = [v[0] + 0.1, v[1] - 7.3, v[2] * 1.7]);
    mesh
}

/// Triangles by position, each from its lowest corner, sorted: independent of vertex indices.
fn outline(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[[u32; 3]; 3]> {
    let from_lowest = |triangle: &[u32; 3]| {
        let mut at = triangle.map(|corner| points[corner as usize].map(|x| (x + 0.0).to_bits()));
        let lowest = (0..3).min_by_key(|&corner| at[corner]).unwrap();
        at.rotate_left(lowest);
        at
    };
    let mut all: Vec<_> = triangles.iter().map(from_lowest).collect();
    all.sort_unstable();
    all
}

const WHOLE: ImportOptions =
    ImportOptions { split: Split::None, vertices: Vertices::Referenced, ..ImportOptions::DEFAULT };
const WHOLE_ALL: ImportOptions =
    ImportOptions { split: Split::None, vertices: Vertices::All, ..ImportOptions::DEFAULT };
const OBJECTS: ImportOptions =
    ImportOptions { split: Split::Object, vertices: Vertices::Referenced, ..ImportOptions::DEFAULT };
const OBJECTS_ALL: ImportOptions =
    ImportOptions { split: Split::Object, vertices: Vertices::All, ..ImportOptions::DEFAULT };

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn import_obj(file: &str, stem: &str, bytes: &[u8], options: ImportOptions) -> Result<Imported, ImportError> {
    let source = SourceFile::alone(bytes.to_vec());
    super::import(file, stem, Path::new("shape.obj"), &source, &options, &Limits::DEFAULT)
}

fn import(text: impl AsRef<[u8]>, options: ImportOptions) -> Imported {
    import_obj("shape.obj", "shape", text.as_ref(), options).unwrap()
}

fn vertices(text: impl AsRef<[u8]>) -> Vec<u32> {
    let imported = import(text, WHOLE);
    assert_eq!(imported.point_sets.len(), 1);
    assert_eq!(imported.point_sets[0].name, "shape");
    imported.point_sets[0].source_vertices.clone()
}

fn fault(text: impl AsRef<[u8]>) -> (Option<usize>, Fault) {
    let error = import_obj("shape.obj", "shape", text.as_ref(), WHOLE).unwrap_err();
    let message = error.to_string();
    let place = error.line.map_or("shape.obj: ".to_owned(), |line| format!("shape.obj:{line}: "));
    assert!(message.starts_with(&place), "{message}");
    (error.line, error.fault)
}

fn square_with(lines: &str) -> String {
    format!("{SQUARE}{lines}")
}

fn sets_of(imported: &Imported) -> Vec<(&str, &[u32])> {
    imported.point_sets.iter().map(|set| (set.name.as_str(), set.source_vertices.as_slice())).collect()
}

#[test]
fn elements_select_the_vertices_that_they_reference() {
    let with = square_with;
    for (text, expected) in [
        (with("f 1 2 3\n"), &[0, 1, 2][..]),
        (with("f 4 3 2 1\n"), &[0, 1, 2, 3]),
        (with("v 2 2 2\nv 3 3 3\nf 1 2 3 4 5\n"), &[0, 1, 2, 3, 4]),
        (with("f 1/1 2/ 3//\n"), &[0, 1, 2]),
        (with("vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 +4/1\n"), &[0, 1, 3]),
        // Negative references count from their line, others may point ahead.
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\n".into(), &[0, 1, 2]),
        ("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3//-1 -2//-1 -1//-1\n".into(), &[1, 2, 3]),
        ("f 1 2 3\no later\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".into(), &[0, 1, 2]),
        // Points and lines.
        (with("p 2\n"), &[1]),
        (with("p 2 -1\nl 1 2/1\n"), &[0, 1, 3]),
        (with("l 1 2 3\n"), &[0, 1, 2]),
        ("v 1 2 3".into(), &[0]),
        // Continued lines. Comments and names that end in a backslash do not continue.
        ("v 0 \\\n0 0\nv 1 0 0\r\nv 1 1 0\nf 1 \\ \r\n 2 \\\n\\\n3\n".into(), &[0, 1, 2]),
        (with("f 1 2 3 \\"), &[0, 1, 2]),
        ("# C:\\meshes\\\nv 0 0 0\no C:\\\nv 1 0 0\nusemtl a\\\nv 2 0 0\nmtllib b\\\nf 1 2 3\n".into(), &[0, 1, 2]),
        ("#v 9 9 9\n# f 1\nv 0 0 0 # here\nv 1 0 0 #\nl 1 2 #3\n".into(), &[0, 1]),
        // Materials, and lines without effect on a hull.
        (with("mtllib nowhere.mtl\nusemtl gold\nf 1 2 3\nusemtl\nf 1 3 4\n"), &[0, 1, 2, 3]),
        (with("vt x\nvn\nvn nan nan nan\nvt 0 0\nf 1/9/-9 2/-77 3\nsomething else\n"), &[0, 1, 2]),
    ] {
        assert_eq!(vertices(&text), expected, "{text:?}");
    }
    assert_eq!(vertices(b"# caf\xE9 \xFF\no stra\xDFe\nv 0 0 0\nv 1 0 0\n# \xE9\nl 1 2\n"), [0, 1]);
}

#[test]
fn positions_are_parsed_to_the_nearest_float() {
    let imported = import("v 0.1 -2.5e-3 16777217\nv +1 .5 5.\nv -0 1e-50 3.4028235e38\n", WHOLE);
    assert_eq!(imported.point_sets[0].positions[0], [0.1, -0.0025, 16777216.0]);
    assert_eq!(imported.point_sets[0].positions[1], [1.0, 0.5, 5.0]);
    assert_eq!(imported.point_sets[0].positions[2].map(f32::to_bits), [-0.0, 0.0, f32::MAX].map(f32::to_bits));
}

#[test]
fn a_bare_cloud_takes_every_vertex() {
    let imported = import(SQUARE, WHOLE);
    assert_eq!(imported.point_sets[0].source_vertices, [0, 1, 2, 3]);
    assert_eq!(imported.unreferenced_count, 4);
    assert!(imported.notes.iter().any(|note| note.contains("point cloud")), "{:?}", imported.notes);
}

#[test]
fn unreferenced_vertices_are_counted_and_left_out() {
    let text = square_with("f 1 2 3\n");
    let imported = import(&text, WHOLE);
    assert_eq!((imported.vertex_count, imported.unreferenced_count, imported.point_count()), (4, 1, 3));
    assert!(imported.notes.iter().any(|note| note.contains("1 vertex that no element")), "{:?}", imported.notes);
    assert_eq!(import(&text, WHOLE_ALL).point_sets[0].source_vertices, [0, 1, 2, 3]);
}

#[test]
fn duplicates_are_kept_and_counted() {
    let imported = import("v 0 0 0\nv 1 0 0\nv -0 0 0\nv 1 0 0\nv 7 7 7\nv 7 7 7\nf 1 2 3\nl 3 4\n", WHOLE);
    assert_eq!(imported.point_sets[0].source_vertices, [0, 1, 2, 3]);
    assert_eq!(imported.duplicate_count, 2);
}

#[test]
fn every_line_ending_and_blank() {
    let unix = square_with("f 1 2 3\n");
    for text in [
        unix.replace('\n', "\r\n"),
        unix.replace('\n', "\r"),
        unix.replace('\n', "\n\n  \n"),
        unix.replace(' ', "\t "),
        unix.replace("v ", " \tv "),
        unix.trim_end().to_owned(),
        format!("\u{FEFF}{unix}"),
        format!("\u{FEFF}{}", unix.replace('\n', "\r\n")),
    ] {
        assert_eq!(vertices(&text), [0, 1, 2], "{text:?}");
    }
}

#[test]
fn colours_and_weights() {
    let imported = import("v 1 2 3 0.5 0.5 0.5\nv 1 2 3\nv 1 2 3 r g b\nv 1 2 3 1.0\nf 1 2 3 4\n", WHOLE);
    assert_eq!(imported.point_sets[0].positions, [[1.0, 2.0, 3.0]; 4]);
    assert!(!imported.warnings.iter().any(|text| text.contains("weight")), "{:?}", imported.warnings);
}

/// Points were divided by their weights without a message: a cube of 2 units became one of 20.
#[test]
fn weights_are_ignored_with_one_warning() {
    let text = "v 1 2 3 1\nv 1 2 3 0.1\nv 1 2 3 0\nv 1 2 3 nan\nv 1 2 3\n";
    for options in [WHOLE, ImportOptions { recentre: true, ..WHOLE }] {
        let imported = import(text, options);
        let set = &imported.point_sets[0];
        assert!(set.positions.iter().all(|&position| position == set.positions[0]), "{:?}", set.positions);
        let [warning] = imported.warnings.iter().filter(|text| text.contains("weight")).collect::<Vec<_>>()[..] else {
            panic!("{:?}", imported.warnings)
        };
        assert!(warning.starts_with("line 2: 3 vertices have a weight"), "{warning}");
    }
    assert_eq!(import(text, WHOLE).point_sets[0].positions, [[1.0, 2.0, 3.0]; 5]);
    assert!(import("v 1 2 3 5\n", WHOLE).warnings[0].starts_with("line 1: 1 vertex has a weight"));
}

/// Windows PowerShell writes `>` as UTF-16.
#[test]
fn utf_16_with_a_byte_order_mark_is_decoded() {
    let text = "# é\r\nv 0 0 0\r\nv 1 0 0\r\nl 1 2\r\nv 1 x\r\n";
    let units: Vec<u16> = std::iter::once(0xFEFF).chain(text.encode_utf16()).collect();
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes = |units: &[u16]| units.iter().flat_map(|&unit| bytes(unit)).collect::<Vec<u8>>();
        assert_eq!(vertices(bytes(&units[..units.len() - 7])), [0, 1]);
        assert_eq!(fault(bytes(&units)), (Some(5), Fault::TooFewCoordinates { found: 2 }));
        assert_eq!(fault(bytes(&units[..1])), (None, Fault::Empty));
    }
}

#[test]
fn faults_have_their_line() {
    use Fault::*;
    let (with, text) = (square_with, |text: &str| text.to_owned());
    let bad = |word: &str| (with(&format!("f 1 2 {word}\n")), Some(5), BadReference { text: text(word) });
    for (file, line, expected) in [
        ("v 1 2 3 1 1\n".into(), Some(1), CoordinateCount { found: 5 }),
        ("v 1 2 3 1 1 1 1\n".into(), Some(1), CoordinateCount { found: 7 }),
        ("v 1 2 3 x\n".into(), Some(1), BadNumber { text: text("x") }),
        ("v 0 0 0\nv 1 nan 0\n".into(), Some(2), NotANumber { text: text("nan") }),
        ("\n\nv 1 0 -Inf\n".into(), Some(3), Infinite { text: text("-Inf") }),
        ("v 1e39 0 0\n".into(), Some(1), Overflow { text: text("1e39") }),
        ("v 0 0 0\r\nv 0 zero 0\r\n".into(), Some(2), BadNumber { text: text("zero") }),
        // In continued lines, their first line. Later lines keep their numbers.
        ("v 0 \\\n0 x\n".into(), Some(1), BadNumber { text: text("x") }),
        ("v 0 \\\n0 0\nv 1 x 0\n".into(), Some(3), BadNumber { text: text("x") }),
        // Truncated files.
        ("v 0 0 0\nv 1 0".into(), Some(2), TooFewCoordinates { found: 2 }),
        ("v\n".into(), Some(1), TooFewCoordinates { found: 0 }),
        (with("f"), Some(5), NoReferences { keyword: text("f") }),
        (with("p #1"), Some(5), NoReferences { keyword: text("p") }),
        // References.
        (with("f 0 1 2\n"), Some(5), ZeroIndex { text: text("0") }),
        (with("\nf 1 2 5\nf 1 2 3\n"), Some(6), IndexTooLarge { text: text("5"), count: 4 }),
        ("f 1 2 3\nv 0 0 0\n".into(), Some(1), IndexTooLarge { text: text("2"), count: 1 }),
        (with("p 99999999999\n"), Some(5), IndexTooLarge { text: text("99999999999"), count: 4 }),
        (with("f -1 -2 -5\n"), Some(5), IndexBeforeFirst { text: text("-5"), declared: 4 }),
        (
            with("p -9223372036854775808\n"),
            Some(5),
            IndexBeforeFirst { text: text("-9223372036854775808"), declared: 4 },
        ),
        bad("x"),
        bad("1.0"),
        bad("/1"),
        bad("1/x"),
        bad("1/1/1/1"),
        bad("99999999999999999999"),
        bad("//"),
        // Files that are not OBJ.
        (text(""), None, Empty),
        (" \r\n\t\n".into(), None, Empty),
        ("\u{FEFF}".into(), None, Empty),
        ("# nothing\no nothing\n".into(), None, NoVertices),
        ("f 1 2 3\n".into(), None, NoVertices),
    ] {
        assert_eq!(fault(&file), (line, expected), "{file:?}");
    }
    assert!(fault("v 1,5 0 0\n").1.to_string().contains("comma"));
    assert_eq!(fault(b"v 0 \xE9 0\n"), (Some(1), BadNumber { text: text("\u{FFFD}") }));
    assert!(fault(b"\x89PNG\r\n\x1A\n\0\0\0").1.to_string().starts_with("the file is an image; expected OBJ"));
    // Long words are truncated.
    let message = fault(format!("v 0 0 {}\n", "x".repeat(5000))).1.to_string();
    assert!(message.len() < 200, "{message}");
    let message = |text: &str| import_obj("a.obj", "a", text.as_bytes(), WHOLE).unwrap_err().to_string();
    for (text, expected) in [
        ("v 0 0 0\nf 2\n", "(the file has 1 vertex)"),
        ("f 2\nv 0 0 0\nv 0 0 0\nf 3\n", "(the file has 2 vertices)"),
        ("f -1\nv 0 0 0\n", "(0 vertices above this line)"),
        ("v 0 0 0\nf -2\n", "(1 vertex above this line)"),
    ] {
        assert!(message(text).contains(expected), "{text:?}");
    }
}

#[test]
fn faces_of_two_vertices_are_elements_with_a_note() {
    let imported = import(square_with("f 1 2\n"), WHOLE);
    assert_eq!(imported.point_sets[0].source_vertices, [0, 1]);
    assert!(imported.notes.iter().any(|note| note.contains("fewer than 3")), "{:?}", imported.notes);
}

const TWO: &str =
    "v 9 9 9\no left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no empty\no right\nv 5 0 0\nv 5 1 0\nf -1 -2 3\n";

#[test]
fn objects_become_point_sets() {
    let imported = import(TWO, OBJECTS);
    assert_eq!(sets_of(&imported), [("left", &[0, 1, 2][..]), ("right", &[2, 4, 5][..])]);
    assert_eq!(imported.point_sets[1].positions, [[1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
    assert_eq!(imported.unreferenced_count, 1);
    assert!(imported.notes.iter().any(|note| note.contains("skipped: 1 (empty)")), "{:?}", imported.notes);
    assert_eq!(vertices(TWO), [0, 1, 2, 4, 5]);
}

#[test]
fn unreferenced_vertices_belong_to_the_object_that_declares_them() {
    assert_eq!(sets_of(&import(TWO, OBJECTS_ALL)), [("left", &[0, 1, 2, 3][..]), ("right", &[2, 4, 5][..])]);
    let cloud = "v 0 0 0\no a\nv 1 0 0\no b\nv 2 0 0\n";
    for options in [OBJECTS, OBJECTS_ALL] {
        assert_eq!(sets_of(&import(cloud, options)), [("shape", &[0][..]), ("a", &[1][..]), ("b", &[2][..])]);
    }
}

#[test]
fn object_names() {
    let names =
        |text: &str| -> Vec<String> { import(text, OBJECTS).point_sets.into_iter().map(|set| set.name).collect() };
    assert_eq!(
        names("v 0 0 0\np 1\no\np 1\no  two words \np 1\no two words\np 1\n"),
        ["shape", "shape_2", "two words", "two words_2"]
    );
    assert_eq!(names("\to\tx#1\nv 0 0 0\np 1\n"), ["x#1"]);
}

#[test]
fn groups_are_not_objects() {
    let imported = import(square_with("g one\nf 1 2 3\ng two\nf 1 3 4\n"), OBJECTS);
    assert_eq!(sets_of(&imported), [("shape", &[0, 1, 2, 3][..])]);
    assert!(imported.notes.iter().any(|note| note.contains("groups")), "{:?}", imported.notes);
}

#[test]
fn free_form_surfaces_are_noted() {
    let imported = import(square_with("p 1\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\n"), WHOLE);
    assert!(imported.notes.iter().any(|note| note.contains("line 7: free-form")), "{:?}", imported.notes);
}
