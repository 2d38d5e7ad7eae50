//! Import of files of each format: here of literal OBJ texts, and of damaged texts.

mod collada;
mod draco;
mod formats;
mod gltf;
mod growth;
mod limits;
mod meshopt;

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
const OBJECTS: ImportOptions = ImportOptions { split: Split::Object, ..WHOLE };
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

/// The import of a file, as `imports.txt` has it.
fn described(imported: &Imported) -> String {
    let mut text = String::new();
    for (set, faces) in imported.point_sets.iter().zip(&imported.faces) {
        text += &set.name;
        set.stands_for.iter().for_each(|body| text += &format!(" for {}", body.name));
        if set.positions.len() > 9 {
            let bound = |choose: fn(f32, f32) -> f32| {
                [0, 1, 2].map(|axis| rounded(set.positions.iter().map(|point| point[axis]).reduce(choose).unwrap()))
            };
            text += &format!(": {} points, {:?} to {:?}\n", set.positions.len(), bound(f32::min), bound(f32::max));
            continue;
        }
        let vertices = set.source_vertices.iter().zip(&set.positions);
        text += &vertices.map(|(vertex, at)| format!("; {vertex} at {at:?}")).collect::<String>();
        let triangles = faces.triangles(&set.positions);
        text += &if triangles.is_empty() { "\n".to_owned() } else { format!("; triangles {triangles:?}\n") };
    }
    for (name, count) in [("unreferenced", imported.unreferenced_count), ("duplicate", imported.duplicate_count)] {
        text += &if count > 0 { format!("{name}: {count}\n") } else { String::new() };
    }
    let materials = imported.materials.names();
    if !materials.is_empty() || imported.materials.unknown_count() > 0 {
        let of_triangles = imported.materials.of_triangles(&imported.faces[0].ends);
        text += &format!(
            "materials: {materials:?}, of triangles {of_triangles:?}, {} unknown\n",
            imported.materials.unknown_count()
        );
    }
    imported.notes.iter().for_each(|note| text += &format!("note: {note}\n"));
    imported.warnings.iter().for_each(|warning| text += &format!("warning: {warning}\n"));
    text
}

/// Sines differ between machines in their last digits.
fn rounded(x: f32) -> f32 {
    (x * 1e4).round() / 1e4 + 0.0
}

/// Shapes of a glTF file: of the second mesh, and others.
const SHAPES: &str = r#""extensions":{"OMI_physics_shape":{"shapes":[{"type":"convex","convex":{"mesh":1}},{"type":"trimesh","trimesh":{"mesh":1}},{"type":"box","box":{"size":[2,4,6]}},{"type":"capsule"},{"type":"capsule","capsule":{"radius":2,"height":3}}]}},"extensionsRequired":["OMI_physics_shape","OMI_physics_body"]"#;

/// Accessors of the positions and indices of one triangle.
const TRIANGLE: &str = r#""asset":{"version":"2.0"},"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},{"bufferView":1,"componentType":5123,"type":"SCALAR","count":3}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"buffers":[{"byteLength":44,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA="}]"#;

/// The bytes of a section of `imports.txt`.
fn section_file(name: &str, text: &str) -> String {
    let text = text.replace('␍', "\r") + "\n";
    if name.ends_with(".dae") {
        let lines = text.lines().filter_map(|line| line.split_once(' '));
        return lines.fold(include_str!("cube.dae").to_owned(), |file, (word, own)| file.replace(word, own));
    }
    if name.ends_with(".gltf") {
        let ring = solids::extrusion(&solids::regular_polygon(12, 2.0), 0.0, 1.0);
        let prism = solids::extrusion(&solids::regular_polygon(5, 1.0), -0.5, 0.5);
        let document = shapes::gltf::parts(&[("ring", &ring), ("prism", &prism)], "", "").text_with_data();
        let (_, meshes) = document.split_once(r#""meshes":"#).unwrap();
        let meshes = format!(r#""asset":{{"version":"2.0"}},"scene":0,"meshes":{meshes}"#);
        return text.replace("MESHES}", &meshes).replace("SHAPES", SHAPES).replace("TRIANGLE", TRIANGLE);
    }
    text
}

/// Rows of a text below its head, cut into columns.
fn rows(text: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    text.split_once("\n\n").unwrap().1.lines().map(|row| row.split(" | ").collect())
}

/// A text with the escapes of JSON, and with quotes as they are.
fn unescaped(text: &str) -> String {
    serde_json::from_str(&format!("\"{}\"", text.replace('"', "\\\"")))
        .unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn files_have_the_imports_that_stand_below_them() {
    let sections: Vec<&str> = include_str!("imports.txt").split("\n=== ").skip(1).collect();
    assert!(sections.len() > 75, "{}", sections.len());
    let mut wrong = Vec::new();
    for section in sections {
        let (head, rest) = section.split_once('\n').unwrap();
        let (text, expected) = rest.split_once("\n---\n").unwrap();
        let mut words = head.split_once(": ").unwrap().0.split(", ");
        let (name, mut options) = (words.next().unwrap(), WHOLE);
        for word in words {
            match word {
                "split object" => options.split = Split::Object,
                "split auto" => options.split = Split::Auto,
                "vertices all" => options.vertices = Vertices::All,
                "recentre" => options.recentre = true,
                _ => panic!("{head}"),
            }
        }
        let found = import_file(name, section_file(name, text), options);
        let found = found.map_or_else(|error| format!("error: {error}\n"), |imported| described(&imported));
        if found.trim_end() != expected.trim_end() {
            wrong.push(format!("=== {head}\n{text}\n---\n{found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn vertices(text: impl AsRef<[u8]>) -> Vec<u32> {
    let imported = import_file("shape.obj", text, WHOLE).unwrap();
    assert_eq!(names(&imported), ["shape"]);
    imported.point_sets[0].source_vertices.clone()
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
fn every_line_ending_and_blank() {
    let unix = format!("{SQUARE}f 1 2 3\n");
    for text in [
        unix.replace('\n', "\r\n"),
        unix.replace('\n', "\r"),
        unix.replace('\n', "\n\n  \n"),
        unix.replace(' ', "\t "),
        unix.replace("v ", " \tv "),
        unix.trim_end().to_owned(),
        format!("{} \\", unix.trim_end()),
        format!("\u{FEFF}{unix}"),
        format!("\u{FEFF}{}", unix.replace('\n', "\r\n")),
    ] {
        assert_eq!(vertices(&text), [0, 1, 2], "{text:?}");
    }
    assert_eq!(vertices(b"# caf\xE9 \xFF\no stra\xDFe\nv 0 0 0\nv 1 0 0\n# \xE9\nl 1 2\n"), [0, 1]);
}

/// Windows PowerShell writes `>` as UTF-16.
#[test]
fn utf_16_with_a_byte_order_mark_is_decoded() {
    let text = "o é 😀\r\nv 0 0 0\r\nv 1 0 0\r\nl 1 2\r\nv 1 x\r\n";
    let units: Vec<u16> = std::iter::once(0xFEFF).chain(text.encode_utf16()).collect();
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes = |units: &[u16]| units.iter().flat_map(|&unit| bytes(unit)).collect::<Vec<u8>>();
        let imported = import_file("a.obj", bytes(&units[..units.len() - 7]), OBJECTS).unwrap();
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
