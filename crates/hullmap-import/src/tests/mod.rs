//! Import of files of each format: here of literal OBJ texts, and of damaged texts.

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

const WHOLE: ImportOptions = ImportOptions::DEFAULT;
const WHOLE_ALL: ImportOptions = ImportOptions { vertices: Vertices::All, ..WHOLE };
const OBJECTS: ImportOptions = ImportOptions { split: Split::Object, ..WHOLE };
const OBJECTS_ALL: ImportOptions = ImportOptions { vertices: Vertices::All, ..OBJECTS };
const AUTO: ImportOptions = ImportOptions { split: Split::Auto, ..WHOLE };

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn import_within(limits: &Limits, name: &str, bytes: impl AsRef<[u8]>) -> Result<Imported, ImportError> {
    super::import(name, "shape", Path::new(name), &SourceFile::alone(bytes.as_ref().to_vec()), &WHOLE, limits)
}

fn import_file(name: &str, bytes: impl AsRef<[u8]>, options: ImportOptions) -> Result<Imported, ImportError> {
    import_source(name, &SourceFile::alone(bytes.as_ref().to_vec()), options)
}

fn import_source(name: &str, source: &SourceFile, options: ImportOptions) -> Result<Imported, ImportError> {
    super::import(name, "shape", Path::new(name), source, &options, &Limits::DEFAULT)
}

fn import(text: impl AsRef<[u8]>, options: ImportOptions) -> Imported {
    import_file("shape.obj", text, options).unwrap()
}

/// Asserts that an import failed with a message of some words.
#[track_caller]
fn fails(result: Result<Imported, ImportError>, words: &str) {
    let message = result.map(|imported| imported.vertex_count).expect_err(words).to_string();
    assert!(message.contains(words) && message.len() < 500, "{message}\nexpected: {words}");
}

/// Asserts that each change of a good file, a row of `damages.txt`, has its message.
fn check_damages(file: &str, good: &str, mut import: impl FnMut(&str) -> Result<Imported, ImportError>) {
    let sections = include_str!("damages.txt").split("\n# ").skip(1);
    let section = sections.filter_map(|section| section.strip_prefix(file)).next().unwrap();
    for row in section.lines().filter(|row| !row.is_empty()) {
        let columns: Vec<&str> = row.split(" | ").collect();
        let (changes, words) = columns.as_chunks::<2>();
        let mut text = good.to_owned();
        for [from, to] in changes {
            assert!(text.contains(from), "{from} in {text}");
            text = text.replace(from, to);
        }
        println!("{row}");
        fails(import(&text), words[0]);
    }
}

#[test]
fn damaged_texts_are_errors_with_their_place() {
    let files: Vec<&str> = include_str!("damaged.txt").split("\n=== ").skip(1).collect();
    assert!(files.len() > 55, "{}", files.len());
    let mut wrong = Vec::new();
    for file in files {
        let (expected, text) = file.split_once('\n').unwrap_or((file, ""));
        let (place, words) = expected.split_once(": ").unwrap();
        let name = place.split(':').next().unwrap();
        let message =
            import_file(name, format!("{text}\n"), WHOLE).map_or_else(|error| error.to_string(), |_| "imported".into());
        if !message.starts_with(&format!("{place}: ")) || !message.contains(words) || message.len() > 500 {
            wrong.push(format!("{expected}\nfound: {message}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn vertices(text: impl AsRef<[u8]>) -> Vec<u32> {
    let imported = import(text, WHOLE);
    assert_eq!(names(&imported), ["shape"]);
    imported.point_sets[0].source_vertices.clone()
}

fn square_with(lines: &str) -> String {
    format!("{SQUARE}{lines}")
}

fn names(imported: &Imported) -> Vec<&str> {
    imported.point_sets.iter().map(|set| set.name.as_str()).collect()
}

/// Triangles of the first object, by indices of its points.
fn triangles(imported: &Imported) -> Vec<[u32; 3]> {
    imported.faces[0].triangles(&imported.point_sets[0].positions)
}

#[track_caller]
fn has_note(imported: &Imported, words: &str) {
    assert!(imported.notes.iter().any(|note| note.contains(words)), "{:?}", imported.notes);
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
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
    has_note(&imported, "point cloud");
}

#[test]
fn unreferenced_vertices_are_counted_and_left_out() {
    let text = square_with("f 1 2 3\n");
    let imported = import(&text, WHOLE);
    assert_eq!((imported.vertex_count, imported.unreferenced_count, imported.point_count()), (4, 1, 3));
    has_note(&imported, "1 vertex that no element");
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
    let text = "o é 😀\r\nv 0 0 0\r\nv 1 0 0\r\nl 1 2\r\nv 1 x\r\n";
    let units: Vec<u16> = std::iter::once(0xFEFF).chain(text.encode_utf16()).collect();
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes = |units: &[u16]| units.iter().flat_map(|&unit| bytes(unit)).collect::<Vec<u8>>();
        let imported = import(bytes(&units[..units.len() - 7]), OBJECTS);
        assert_eq!(sets_of(&imported), [("é 😀", &[0, 1][..])]);
        fails(import_file("a.obj", bytes(&units), WHOLE), "a.obj:5: `v` has 2 of 3 coordinates");
        fails(import_file("a.obj", bytes(&units[..1]), WHOLE), "a.obj: the file is empty");
    }
}

#[test]
fn odd_bytes_and_ends_of_obj_files_are_errors() {
    for (bytes, words) in [
        (&b" \r\n\t\n"[..], "a.obj: the file is empty"),
        (b"\xEF\xBB\xBF", "a.obj: the file is empty"),
        (b"v 0 0 0\nf", "a.obj:2: `f` references no vertices"),
        (b"v 0 0 0\nv 1 0", "a.obj:2: `v` has 2 of 3 coordinates"),
        (b"v 0 \xE9 0\n", "a.obj:1: coordinate `\u{FFFD}` is not a number"),
    ] {
        fails(import_file("a.obj", bytes, WHOLE), words);
    }
    let long = import_file("a.obj", format!("v 0 0 {}\n", "x".repeat(5000)), WHOLE).unwrap_err().to_string();
    assert!(long.len() < 200, "{long}");
}

#[test]
fn faces_of_two_vertices_are_elements_with_a_note() {
    let imported = import(square_with("f 1 2\n"), WHOLE);
    assert_eq!(imported.point_sets[0].source_vertices, [0, 1]);
    has_note(&imported, "fewer than 3");
}

const TWO: &str =
    "v 9 9 9\no left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no empty\no right\nv 5 0 0\nv 5 1 0\nf -1 -2 3\n";

#[test]
fn objects_become_point_sets() {
    let imported = import(TWO, OBJECTS);
    assert_eq!(sets_of(&imported), [("left", &[0, 1, 2][..]), ("right", &[2, 4, 5][..])]);
    assert_eq!(imported.point_sets[1].positions, [[1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
    assert_eq!(imported.unreferenced_count, 1);
    has_note(&imported, "skipped: 1 (empty)");
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
    let text = "v 0 0 0\np 1\no\np 1\no  two words \np 1\no two words\np 1\n\to\tx#1\np 1\n";
    assert_eq!(names(&import(text, OBJECTS)), ["shape", "shape_2", "two words", "two words_2", "x#1"]);
}

#[test]
fn groups_are_not_objects() {
    let imported = import(square_with("g one\nf 1 2 3\ng two\nf 1 3 4\n"), OBJECTS);
    assert_eq!(sets_of(&imported), [("shape", &[0, 1, 2, 3][..])]);
    has_note(&imported, "groups");
}

#[test]
fn free_form_surfaces_are_noted() {
    let imported = import(square_with("p 1\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\n"), WHOLE);
    has_note(&imported, "line 7: free-form");
}
