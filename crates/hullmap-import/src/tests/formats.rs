//! glTF, STL and PLY: one mesh in every format, other readers, and the errors of bad files.

use std::path::Path;

use std::sync::Arc;

use shapes::mesh::Mesh;
use shapes::{collada, families::Family, gltf, msh, ply, solids, stl};

use super::super::*;
use super::{draco, outline, prism};
use crate::options::Split;
use shapes::rng::SplitMix64;

const WHOLE: ImportOptions = ImportOptions::DEFAULT;
const OBJECTS: ImportOptions = ImportOptions { split: Split::Object, ..WHOLE };

fn import_bytes(name: &str, bytes: &[u8], options: ImportOptions) -> Result<Imported, ImportError> {
    import(name, "shape", Path::new(name), &SourceFile::alone(bytes.to_vec()), &options, &Limits::DEFAULT)
}

fn fails(name: &str, bytes: &[u8], expected: &str) {
    let message = import_bytes(name, bytes, WHOLE).expect_err(expected).to_string();
    assert!(message.starts_with(name) && message.contains(expected), "{message}\nexpected: {expected}");
}

fn names(imported: &Imported) -> Vec<&str> {
    imported.point_sets.iter().map(|set| set.name.as_str()).collect()
}

/// The outlines of all point sets together.
fn triangles(imported: &Imported) -> Vec<[[u32; 3]; 3]> {
    let sets = imported.point_sets.iter().zip(&imported.faces);
    let mut all: Vec<_> =
        sets.flat_map(|(set, faces)| outline(&set.positions, &faces.triangles(&set.positions))).collect();
    all.sort_unstable();
    all
}

fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text: String = mesh.vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for face in &mesh.faces {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text.into_bytes()
}

fn files(mesh: &Mesh) -> Vec<(&'static str, Vec<u8>)> {
    let parts = gltf::parts(&[("prism", mesh)], r#"{"mesh":0,"name":"node"}"#, "0");
    vec![
        ("shape.obj", obj(mesh)),
        ("shape.glb", parts.glb()),
        ("shape.gltf", parts.text_with_data().into_bytes()),
        ("shape.stl", stl::binary(mesh, "solid in name only")),
        ("shape.STL", stl::binary(mesh, "")),
        ("text.stl", stl::text(&[("prism", mesh)]).into_bytes()),
        ("shape.ply", ply::file(mesh, ply::Encoding::Text)),
        ("little.ply", ply::file(mesh, ply::Encoding::Little)),
        ("big.ply", ply::file(mesh, ply::Encoding::Big)),
        ("shape.dae", collada::file(mesh).into_bytes()),
        ("shape.msh", msh::file(mesh)),
    ]
}

#[test]
fn every_format_gives_the_same_mesh() {
    let mesh = prism(5);
    let expected = triangles(&import_bytes("shape.obj", &obj(&mesh), WHOLE).unwrap());
    assert_eq!(expected.len(), 8 * 2);
    for (name, bytes) in files(&mesh) {
        let imported = import_bytes(name, &bytes, WHOLE).unwrap();
        assert_eq!(triangles(&imported), expected, "{name}");
        assert_eq!(names(&imported), ["shape"], "{name}");
        let set = &imported.point_sets[0];
        assert_eq!(set.source_vertices, (0..10).collect::<Vec<u32>>(), "{name}");
        if !name.to_lowercase().ends_with("stl") {
            assert_eq!(set.positions, mesh.vertices, "{name}");
        }
        assert_eq!((imported.vertex_count, imported.unreferenced_count, imported.duplicate_count), (10, 0, 0));
        assert!(imported.notes.is_empty() && imported.warnings.is_empty(), "{name}: {:?}", imported.notes);
    }
}

#[test]
fn independent_readers_agree() {
    let mesh = prism(5);
    let points = |imported: &Imported| -> Vec<[f32; 3]> {
        let set = &imported.point_sets[0];
        imported.faces[0]
            .triangles(&set.positions)
            .iter()
            .flatten()
            .map(|&corner| set.positions[corner as usize])
            .collect()
    };
    for (name, bytes) in files(&mesh) {
        let ours = import_bytes(name, &bytes, WHOLE).unwrap();
        let theirs: Vec<[f32; 3]> = if name.starts_with("shape.gl") {
            let document = ::gltf::Gltf::from_slice(&bytes).unwrap();
            let buffer = gltf::parts(&[("prism", &mesh)], "{}", "0").buffer;
            let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
            let reader = primitive.reader(|_| Some(&buffer));
            let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            reader.read_indices().unwrap().into_u32().map(|index| positions[index as usize]).collect()
        } else if name == "text.stl" || name == "shape.STL" {
            // It treats every file that starts with `solid ` as text.
            let read = stl_io::read_stl(&mut std::io::Cursor::new(&bytes)).unwrap();
            let corners = read.faces.iter().flat_map(|face| face.vertices);
            corners.map(|corner| read.vertices[corner]).map(|v| [v[0], v[1], v[2]]).collect()
        } else if name.ends_with(".ply") {
            let parser = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new();
            let read = parser.read_ply(&mut &bytes[..]).unwrap();
            let number = |element: &ply_rs_bw::ply::DefaultElement, name: &str| element[name].to_f32_lossy().unwrap();
            let vertex = |element| ["x", "y", "z"].map(|name| number(element, name));
            let vertices: Vec<[f32; 3]> = read.payload["vertex"].iter().map(vertex).collect();
            let faces = read.payload["face"].iter().map(|face| face["vertex_indices"].to_u32_list().unwrap());
            let fans = faces.flat_map(|face| {
                (2..face.len()).flat_map(move |i| [face[0], face[i - 1], face[i]]).collect::<Vec<_>>()
            });
            fans.map(|corner| vertices[corner as usize]).collect()
        } else {
            continue;
        };
        assert_eq!(points(&ours), theirs, "{name}");
    }
}

#[test]
fn nodes_are_transformed_in_f64_and_named() {
    let mesh = prism(5);
    // A mirrored child of a rotated parent, the same mesh twice, and two nodes without a name.
    let nodes = r#"{"children":[1,2],"rotation":[0,0,0.70710678,0.70710678],"translation":[10,0,0]},
        {"mesh":0,"name":"left","scale":[-2,1,1]},
        {"mesh":0,"matrix":[1,0,0,0, 0,0,1,0, 0,-1,0,0, 5,6,7,1]},
        {"mesh":1,"name":"left"},
        {"mesh":1,"name":"unseen"}"#;
    let cube = solids::extrusion(&solids::regular_polygon(4, 1.0), 0.0, 1.0);
    let bytes = gltf::parts(&[("prism", &mesh), ("cube", &cube)], nodes, "0,3").glb();
    let imported = import_bytes("a.glb", &bytes, OBJECTS).unwrap();
    assert_eq!(names(&imported), ["left", "prism", "left_2"]);
    assert_eq!(imported.vertex_count, 10 + 10 + 8);
    assert_eq!(imported.point_sets[1].source_vertices[0], 10);
    let near = |got: [f32; 3], expected: [f64; 3]| {
        assert!(got.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 3e-6), "{got:?} {expected:?}");
    };
    for (index, v) in mesh.vertices.iter().enumerate() {
        let [x, y, z] = v.map(f64::from);
        // A quarter turn about z after the transform of the child, then a translation along x.
        near(imported.point_sets[0].positions[index], [-y + 10.0, -2.0 * x, z]);
        let [x, y, z] = [x + 5.0, -z + 6.0, y + 7.0];
        near(imported.point_sets[1].positions[index], [-y + 10.0, x, z]);
    }
    // Faces wind outwards even where a transform mirrors.
    for (set, faces) in imported.point_sets.iter().zip(&imported.faces) {
        let faces = faces.triangles(&set.positions).iter().map(|corners| corners.to_vec()).collect();
        let mesh = Mesh { vertices: set.positions.clone(), faces };
        assert!(mesh.signed_volume() > 0.5, "{}", set.name);
    }
    assert!(
        imported.notes.iter().any(|note| note.contains("repeated instances of a mesh, all included: 1")),
        "{:?}",
        imported.notes
    );
    assert_eq!(import_bytes("a.glb", &bytes, WHOLE).unwrap().point_sets[0].positions.len(), 28);
}

#[test]
fn only_regular_files_within_the_limit_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    assert!(matches!(read("a.obj", &path, &Limits::DEFAULT), Err(ReadError::Io(_))));
    std::fs::write(&path, "v 1 2 3").unwrap();
    let limits = Limits { input_bytes: 6, ..Limits::DEFAULT };
    assert!(read("a.obj", &path, &limits).unwrap_err().is_too_large());
    assert_eq!(open_regular(folder.path()).unwrap_err().to_string(), "it is a folder, not a regular file");
}

#[test]
fn buffers_beside_the_file_are_read_and_hashed() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = prism(5);
    let parts = gltf::parts(&[("prism", &mesh)], r#"{"mesh":0}"#, "0");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, parts.text("data/a%20b.bin")).unwrap();
    let error = |expected: &str| match read("a.gltf", &path, &Limits::DEFAULT) {
        Err(ReadError::Import(error)) => assert!(error.to_string().contains(expected), "{error}"),
        other => panic!("{other:?}"),
    };
    error("buffer data/a b.bin cannot be read");
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let buffer = folder.path().join("data/a b.bin");
    std::fs::write(&buffer, &parts.buffer).unwrap();
    assert_eq!(buffers_of(&path).unwrap(), std::slice::from_ref(&buffer));
    let source = read("a.gltf", &path, &Limits::DEFAULT).unwrap();
    let imported = import("a.gltf", "a", &path, &source, &WHOLE, &Limits::DEFAULT).unwrap();
    assert_eq!(imported.point_sets[0].positions, mesh.vertices);

    // Every byte of the buffer changes the hash.
    let mut changed = parts.buffer.clone();
    changed[3] ^= 1;
    std::fs::write(&buffer, &changed).unwrap();
    assert_ne!(read("a.gltf", &path, &Limits::DEFAULT).unwrap().hash, source.hash);
    std::fs::write(&buffer, &parts.buffer).unwrap();
    assert_eq!(read("a.gltf", &path, &Limits::DEFAULT).unwrap().hash, source.hash);
    let limits = Limits { input_bytes: source.bytes.len() as u64 + 5, ..Limits::DEFAULT };
    assert!(
        matches!(read("a.gltf", &path, &limits), Err(ReadError::Import(e)) if e.to_string().contains("max_input_bytes"))
    );
    std::fs::write(&buffer, &parts.buffer[..100]).unwrap();
    let source = read("a.gltf", &path, &Limits::DEFAULT).unwrap();
    let error = import("a.gltf", "a", &path, &source, &WHOLE, &Limits::DEFAULT).unwrap_err();
    assert!(error.to_string().contains("has 100: it was cut off"), "{error}");
}

fn custom(accessors: &str, views: &str, primitive: &str, extra: &str, buffer: &[u8]) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},{extra}"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{primitive}]}}],"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{}}}]}}"#,
        buffer.len()
    );
    gltf::glb(json.as_bytes(), buffer)
}

#[test]
fn interleaved_sparse_and_quantized_accessors() {
    let point = r#"{"attributes":{"POSITION":0},"mode":0}"#;
    let positions = |accessor: &str, views: &str, buffer: &[u8]| {
        let bytes = custom(accessor, views, point, "", buffer);
        import_bytes("a.glb", &bytes, WHOLE).map(|imported| imported.point_sets[0].positions.clone())
    };
    let floats: Vec<u8> = [9.0_f32, 1.0, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = r#"{"buffer":0,"byteLength":32,"byteStride":16}"#;
    let accessor = r#"{"bufferView":0,"byteOffset":4,"componentType":5126,"type":"VEC3","count":2}"#;
    assert_eq!(positions(accessor, view, &floats).unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    // A sparse accessor without a buffer view: zeros, and one replacement.
    let sparse = r#"{"componentType":5126,"type":"VEC3","count":3,"sparse":{"count":1,
        "indices":{"bufferView":0,"componentType":5123},"values":{"bufferView":1}}}"#;
    let mut buffer = vec![1, 0, 0, 0];
    buffer.extend([7.0_f32, 8.0, 9.0].iter().flat_map(|x| x.to_le_bytes()));
    let views = r#"{"buffer":0,"byteLength":2},{"buffer":0,"byteOffset":4,"byteLength":12}"#;
    assert_eq!(positions(sparse, views, &buffer).unwrap(), [[0.0; 3], [7.0, 8.0, 9.0], [0.0; 3]]);
    for (from, to) in [(r#""count":3"#, r#""count":1"#), (r#""byteLength":2}"#, r#""byteLength":1}"#)] {
        let error = positions(&sparse.replace(from, to), &views.replace(from, to), &buffer).unwrap_err().to_string();
        assert!(error.contains("accessor 0"), "{error}");
    }
    // Quantized positions: shorts, normalized or not.
    let shorts: Vec<u8> = [32767_i16, -32768, 0, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let short = r#"{"bufferView":0,"componentType":5122,"type":"VEC3","count":1}"#;
    let view = r#"{"buffer":0,"byteLength":8}"#;
    assert_eq!(positions(short, view, &shorts).unwrap(), [[32767.0, -32768.0, 0.0]]);
    let normalized = short.replace("\"count\"", "\"normalized\":true,\"count\"");
    assert_eq!(positions(&normalized, view, &shorts).unwrap(), [[1.0, -1.0, 0.0]]);
    // Not finite.
    let nan: Vec<u8> = [1.0_f32, f32::NAN, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let accessor = r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":1}"#;
    let error = positions(accessor, r#"{"buffer":0,"byteLength":12}"#, &nan).unwrap_err().to_string();
    assert!(error.contains("node 0, mesh 0: vertex 0 is at [1.0, NaN, 0.0]"), "{error}");
}

#[test]
fn primitives_of_every_mode() {
    let floats: Vec<u8> = (0..15).flat_map(|x| (x as f32 * x as f32).to_le_bytes()).collect();
    let accessor = r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":5}"#;
    let view = r#"{"buffer":0,"byteLength":60}"#;
    for (mode, expected) in [
        (0, &[][..]),
        (3, &[]),
        (4, &[[0, 1, 2]]),
        (5, &[[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
        (6, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
    ] {
        let primitive = format!(r#"{{"attributes":{{"POSITION":0}},"mode":{mode}}}"#);
        let imported = import_bytes("a.glb", &custom(accessor, view, &primitive, "", &floats), WHOLE).unwrap();
        assert_eq!(imported.faces[0].triangles(&imported.point_sets[0].positions), expected, "{mode}");
        let left_out = if mode == 4 { 2 } else { 0 };
        assert_eq!(imported.unreferenced_count, left_out, "{mode}");
    }
    let twice = r#"{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":1}"#;
    let imported = import_bytes("a.glb", &custom(accessor, view, twice, "", &floats), WHOLE).unwrap();
    assert_eq!(imported.vertex_count, 5);
}

#[test]
fn gltf_errors_are_reported() {
    let mesh = prism(5);
    let good = gltf::parts(&[("prism", &mesh)], r#"{"mesh":0,"name":"crate"}"#, "0");
    let change = |from: &str, to: &str| {
        assert!(good.json.contains(from), "{from} in {}", good.json);
        let parts = gltf::Parts { json: good.json.replacen(from, to, 1), ..good.clone() };
        parts.glb()
    };
    for extension in ["EXT_mesh_gpu_instancing", "VENDOR_unheard_of"] {
        let bytes =
            change("\"scene\"", &format!(r#""extensionsRequired":["KHR_materials_unlit","{extension}"],"scene""#));
        fails("a.glb", &bytes, &format!("requires the extension {extension}"));
    }
    let fine = change("\"scene\"", r#""extensionsRequired":["KHR_materials_unlit","KHR_mesh_quantization"],"scene""#);
    assert!(import_bytes("a.glb", &fine, WHOLE).is_ok());
    for (from, to, expected) in [
        ("\"2.0\"", "\"1.0\"", "the file is glTF 1.0"),
        ("\"scene\":0", "\"scene\":3", "scene index 3 is out of range (the file has 1 scene)"),
        ("\"nodes\":[0]", "\"nodes\":[7]", "node index 7 is out of range"),
        ("\"nodes\":[0]", "\"nodes\":[0,0]", "node 0 (crate) has two parents"),
        ("\"mesh\":0", "\"mesh\":0,\"children\":[0]", "node 0 (crate) has two parents or is its own ancestor"),
        ("\"mesh\":0", "\"mesh\":9", "node 0 (crate) has the mesh index 9, which is out of range"),
        ("\"mesh\":0", "\"scale\":[1e308,1e308,1e308],\"mesh\":0", "vertex"),
        ("\"mesh\":0", "\"scale\":[1e40,1,1],\"mesh\":0", "too large for 32-bit floats"),
        ("\"mesh\":0", "\"matrix\":[1,0,0,0.5,0,1,0,0,0,0,1,0,0,0,0,1],\"mesh\":0", "last row"),
        ("\"mesh\":0", "\"rotation\":[0,0,0,0],\"mesh\":0", "not finite"),
        ("\"mesh\":0,", "", "the scene shows no mesh (the file has 1 mesh)"),
        ("\"POSITION\":0", "\"NORMAL\":0", "the scene shows no vertices (the file has 1 mesh)"),
        ("\"meshes\"", "\"other\"", "has the mesh index 0, which is out of range (the file has 0 meshes)"),
        ("\"POSITION\":0", "\"POSITION\":1", "accessor 1 is not of type VEC3"),
        ("\"POSITION\":0", "\"POSITION\":8", "accessor 8 does not exist"),
        ("\"POSITION\":0", "\"POSITION\":-8", "not a glTF document"),
        ("\"count\":10", "\"count\":11", "has 11 elements, more than its buffer view holds"),
        ("\"count\":10", "\"count\":9", "corner"),
        ("\"componentType\":5125", "\"componentType\":5126", "vertex indices stored as floats (component type 5126)"),
        ("\"componentType\":5126", "\"componentType\":7", "unknown component type 7"),
        ("\"byteOffset\":0", "\"byteOffset\":18446744073709551615", "buffer view 0"),
        ("\"bufferView\":0", "\"bufferView\":5", "buffer view 5, which does not exist"),
        ("\"asset\"", "\"nothing\"", "missing field `asset`"),
        ("{\"asset\"", "[{\"asset\"", "not a glTF document"),
        ("\"asset\":{", "\"asset\":[],\"x\":{", "invalid type: a list, expected an object at line 1 column"),
        ("\"asset\":{", "\"asset\":3,\"x\":{", "invalid type: integer `3`, expected an object at line 1 column"),
        (
            "\"asset\":{",
            "\"asset\":\"123456789012345678901234567890\",\"x\":{",
            "string \"123456789012345678…, expected an object at line 1",
        ),
    ] {
        fails("a.glb", &change(from, to), expected);
    }
    let text = good.text("data:;base64,%%%").replace(",\"nodes\"", ",\n\"nodes\"");
    fails("a.gltf", text.as_bytes(), "buffer 0 has invalid base64");
    fails("a.gltf", good.text("../up.bin").as_bytes(), "buffer 0 has the URI `../up.bin`");
    fails("a.gltf", good.text("beside.bin").as_bytes(), "buffer 0 (beside.bin) is missing");
    let wrong = import_bytes("a.gltf", b"{\"asset\":{\"version\":\"2.0\"},\n\"scene\":x}", WHOLE).unwrap_err();
    assert_eq!(wrong.line, Some(2), "{wrong}");
    fails("a.gltf", b" \n", "the file is empty");
    let glb = good.glb();
    for length in 0..glb.len() {
        assert!(import_bytes("a.glb", &glb[..length], WHOLE).is_err(), "{length}");
    }
    fails("a.glb", &glb[..40], "was cut off");
    let mut claims = glb.clone();
    claims[8] = 3;
    claims[9..12].fill(0);
    fails("a.glb", &claims, "a GLB chunk claims");
    fails("a.glb", b"glTF\x02\0\0\0\x0C\0\0\0", "no JSON chunk");
    fails("a.glb", b"glTF\x01\0\0\0\x0C\0\0\0", "the file is glTF 1.0");
    fails("a.glb", b"glTF\x03\0\0\0\x0C\0\0\0", "GLB version 3");
}

#[test]
fn stl_variants_and_errors() {
    let mesh = prism(5);
    let text = stl::text(&[("one", &mesh), ("two words", &mesh), ("one", &mesh)]);
    let imported = import_bytes("a.stl", text.as_bytes(), OBJECTS).unwrap();
    assert_eq!(names(&imported), ["one", "two words", "one_2"]);
    assert_eq!(imported.vertex_count, 10, "equal positions are one vertex");
    for text in [
        text.to_uppercase(),
        text.replace('\n', "\r\n"),
        text.replace('\n', " ").replace(" solid", "\nsolid").replace("facet normal", "\nfacet normal"),
        text.replace("normal 0 0 0", "normal nan -inf x"),
        text.replace("end", "end "),
    ] {
        assert_eq!(import_bytes("a.stl", text.trim_start().as_bytes(), OBJECTS).unwrap().point_count(), 30);
    }
    // With recentre, text coordinates are read as f64.
    let far = "solid x\nfacet normal 0 0 1 outer loop\nvertex 1000000.001 0 0 vertex 1000000.002 0 0\nvertex 1000000.003 1 0\nendloop endfacet endsolid";
    let recentred = ImportOptions { recentre: true, ..WHOLE };
    let imported = import_bytes("a.stl", far.as_bytes(), recentred).unwrap();
    assert_eq!(imported.point_sets[0].positions[0][0], -0.001);
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);

    let binary = stl::binary(&mesh, "solid");
    for (bytes, expected) in [
        (&b"  "[..], "the file is empty"),
        (b"mesh", "the file has 4 bytes; expected STL text"),
        (&binary[..200], "claims 16 triangles (884 bytes), but the file has 200"),
        (&stl::binary(&Mesh::default(), "x"), "no triangles found"),
        (
            b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0\nendloop",
            "a.stl:6: coordinate `endloop`",
        ),
        (
            b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop",
            "a.stl:5: a facet has 1 vertex; expected 3",
        ),
        (b"solid x\nfacet normal 0 0 1\nouter lop", "a.stl:3: found `lop`; expected `loop`"),
        (b"solid x\nfacet normal 0 0", "the file ends; expected one of the three numbers of a normal"),
        (b"solid x\nfacets\nendsolid", "a.stl:2: found `facets`; expected `facet`"),
        (b"solid x\nendsolid x", "no triangles found"),
        (b"solid x\nend facet\nendsolid x", "a.stl:2: found `end`; expected `facet`"),
    ] {
        fails("a.stl", bytes, expected);
    }
    let mut nan = binary.clone();
    nan[84 + 50 + 12 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    fails("a.stl", &nan, "corner 1 of triangle 1 has the coordinate NaN");
    let longer = [&binary[..], &[0; 7]].concat();
    assert!(import_bytes("a.stl", &longer, WHOLE).unwrap().warnings[0].starts_with("7 bytes at the end"));
}

#[test]
fn ply_variants_and_errors() {
    let header = |body: &str| format!("ply\nformat ascii 1.0\n{body}");
    let vertices = "element vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
    let points = "0 0 0\n1 0 0\n0 1 0\n0 0 1.00000001\n";
    let strips = header(&format!(
        "{vertices}element tristrips 1\nproperty list int int vertex_indices\nend_header\n{points}8 0 1 2 3 -1 3 2 0\n"
    ));
    let imported = import_bytes("a.ply", strips.as_bytes(), WHOLE).unwrap();
    assert_eq!(imported.faces[0].triangles(&imported.point_sets[0].positions), [[0, 1, 2], [2, 1, 3], [3, 2, 0]]);
    let edges = header(&format!(
        "element nothing 9\n{vertices}element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n{points}3 1"
    ));
    let imported = import_bytes("a.ply", edges.replace('\n', "\r\n").as_bytes(), WHOLE).unwrap();
    assert_eq!(imported.point_sets[0].source_vertices, [1, 3]);
    let cloud = header(&format!("{vertices}end_header\n{points}"));
    assert_eq!(import_bytes("a.ply", cloud.as_bytes(), WHOLE).unwrap().point_count(), 4);
    // Faces without corners reference nothing, so the file is a point cloud.
    let empty_faces = "element face 2\nproperty list uchar int vertex_index\n";
    let hollow = header(&format!("{vertices}{empty_faces}end_header\n{points}0\n0\n"));
    for split in [Split::None, Split::Object, Split::Auto] {
        let imported = import_bytes("a.ply", hollow.as_bytes(), ImportOptions { split, ..WHOLE }).unwrap();
        assert_eq!((imported.point_sets.len(), imported.point_count()), (1, 4));
    }
    // Doubles are moved first, then rounded once.
    let recentred = ImportOptions { recentre: true, ..WHOLE };
    let imported = import_bytes("a.ply", cloud.as_bytes(), recentred).unwrap();
    assert_eq!(imported.point_sets[0].positions[3][2], (1.00000001_f64 - 1.00000001 / 2.0) as f32);
    assert_eq!(imported.point_sets[0].origin[2], 1.00000001 / 2.0);

    let faces = "element face 1\nproperty list uchar int vertex_index\n";
    for (text, expected) in [
        ("".to_owned(), "the file is empty"),
        ("plywood\n".to_owned(), "a.ply:1: the first line is not `ply`"),
        (header("element vertex 1"), "no `end_header`"),
        ("ply\nend_header\n".to_owned(), "no `format` line"),
        (header("format ascii 2.0\n"), "a.ply:3: found `format ascii 2.0`; expected version 1.0"),
        (header("property int x\n"), "a.ply:3: found `property int x`; expected an `element`"),
        (header("element vertex many\n"), "a.ply:3: "),
        (header("element vertex 1\nproperty real x\n"), "a.ply:4: "),
        (header("end_header\n"), "no `element vertex`"),
        (header("element vertex 0\nend_header\n"), "no vertices"),
        (header("element vertex 1\nproperty float x\nend_header\n1"), "no number `y`"),
        (cloud.replace("vertex 4", "vertex 5"), "the file ends within vertex 4 of the 5"),
        (
            cloud.replace("vertex 4", "vertex 1000000000"),
            "claims 1000000000 vertices, and each takes less than 6 bytes",
        ),
        (cloud.replace("1 0 0", "1 x 0"), "a.ply:9: coordinate `x` is not a number"),
        (cloud.replace("1 0 0", "1 nan 0"), "a.ply:9: coordinate `nan`"),
        (
            header(&format!("{vertices}{faces}end_header\n{points}3 0 1 4\n")),
            "face 0 has the vertex index 4, which is out of range (the file has 4 vertices)",
        ),
        (header(&format!("{vertices}{faces}end_header\n{points}3 0 1 -1\n")), "face 0 has the vertex index -1"),
        (header(&format!("{vertices}{faces}end_header\n{points}9 0 1 2\n")), "face 0 claims a list of 9 numbers"),
    ] {
        fails("a.ply", text.as_bytes(), expected);
    }
    for encoding in [ply::Encoding::Little, ply::Encoding::Big] {
        let bytes = ply::file(&prism(5), encoding);
        for length in 0..bytes.len() {
            assert!(import_bytes("a.ply", &bytes[..length], WHOLE).is_err(), "{length}");
        }
        let at = bytes.len() - prism(5).faces.iter().map(|face| 9 + 4 * face.len()).sum::<usize>() - 13;
        let mut nan = bytes.clone();
        nan[at..at + 4].fill(0xFF);
        fails("a.ply", &nan, "vertex 9 has the coordinate NaN");
    }
}

/// Unknown header lines and surplus values were errors, and other readers skip them.
#[test]
fn ply_surplus_is_skipped_with_a_note() {
    let file = |format: &str, header: &str, body: &str| {
        format!(
            "ply\nformat {format} 1.0\n{header}element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n{body}"
        )
    };
    let read = |text: &str| {
        let imported = import_bytes("a.ply", text.as_bytes(), WHOLE).unwrap();
        let set = &imported.point_sets[0];
        assert_eq!(set.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{text}");
        assert_eq!(imported.faces[0].triangles(&set.positions), [[0, 1, 2], [2, 1, 0]], "{text}");
        imported.notes
    };
    let plain = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0\n";
    assert_eq!(read(&file("ascii", "", plain)), [""; 0]);
    assert_eq!(
        read(&file("ascii", "author me\n\nCOMMENT x\n", plain)),
        ["line 3: `author me`: 2 header lines with an unknown keyword, skipped"]
    );
    assert_eq!(
        read(&file("ascii", "", "0 0 0 9\n1 0 0\n\n 0 1 0 9 9\r\n3 0 1 2 255 0 0\n3 2 1 0 \nremark\n")),
        ["line 10: 3 lines have more values than the header declares, which are ignored"]
    );
    assert_eq!(
        read(&file("ascii", "", "0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n3 2 1 0")),
        ["line 11: 1 line has more values than the header declares, which are ignored"]
    );
    for body in [
        "0 0 0 1 0 0 0 1 0\n3 0 1 2\n3 2 1 0",
        "0 0\n0 1 0 0 0 1 0 3 0 1 2 3 2\n1 0",
        "0\n0\n0\n1 0 0\n0 1 0\n3\n0 1 2\n3\n2 1 0",
    ] {
        assert_eq!(read(&file("ascii", "", body)), [""; 0], "{body}");
    }
    let fault = |text: &str, expected: &str| fails("a.ply", text.as_bytes(), expected);
    fault(&file("ascii", "", "0 0 0 9\n1 0 0 9\n0 1 x 9\n3 0 1 2\n3 2 1 0"), "a.ply:12: coordinate `x`");
    fault(&file("ascii", "", "0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n3 2 1 3"), "a.ply:14: face 1 has the vertex index 3");
    fault(&file("ascii", "", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "the file ends within face 1 of the 2");
    fault(&file("ascii", "format\n", plain), "a.ply:3: found `format`; expected");
    fault(&file("ascii", "element a\n", plain), "a.ply:3: found `element a`; expected");
}

/// Regression: face indices were compared with the length of the first list, but used with the last
/// one.
#[test]
fn two_vertex_elements_are_rejected() {
    let list = |count: usize| format!("element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n");
    let faces = "element face 1\nproperty list uchar int vertex_index\n";
    for [first, second] in [[3, 1], [1, 3], [3, 0]] {
        let points = "0 0 0 ".repeat(first + second);
        let text =
            format!("ply\nformat ascii 1.0\n{}{}{faces}end_header\n{points}3 0 1 2\n", list(first), list(second));
        fails("a.ply", text.as_bytes(), "`element vertex` twice");
    }
}

#[test]
fn damaged_files_import_or_fail_with_an_error() {
    const SEED: u64 = 23;
    let mut random = SplitMix64::new(SEED);
    let (mut read_count, mut rejected_count) = (0, 0);
    // Draco's data is damaged before it is put into a file, so that it is decoded.
    type Wrap = fn(&[u8]) -> Vec<u8>;
    let plain = files(&prism(5)).into_iter().map(|(name, bytes)| (name, bytes, (|bytes| bytes.to_vec()) as Wrap));
    let draco = draco::prisms().into_iter().map(|data| ("draco.glb", data, (|data| draco::glb(data, "")) as Wrap));
    let files: Vec<_> = plain.chain(draco).collect();
    let limits = Limits { repeated_vertices: 1 << 16, ..Limits::DEFAULT };
    for round in 0..26_000 {
        // Three in four are Draco's.
        let which = if round % 4 == 0 { round / 4 % 11 } else { 11 + round % 10 };
        let (name, bytes, wrap) = &files[which];
        let mut bytes = bytes.clone();
        for _ in 0..=random.below(4) {
            if bytes.is_empty() {
                break;
            }
            let at = random.below(bytes.len());
            match random.below(5) {
                0 => bytes[at] = random.next_u64() as u8,
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, b"0-9e\"{}[],\0\xFF"[random.below(12)]),
                3 => bytes.truncate(at.max(1)),
                _ => {
                    let end = (at + random.below(9)).min(bytes.len());
                    bytes[at..end].fill([0, 0xFF, b'9'][random.below(3)]);
                }
            }
        }
        let source = SourceFile::alone(wrap(&bytes));
        match import(name, "shape", Path::new(name), &source, &OBJECTS, &limits) {
            Ok(imported) => {
                read_count += 1;
                for (set, faces) in imported.point_sets.iter().zip(&imported.faces) {
                    assert!(set.positions.iter().flatten().all(|x| x.is_finite()), "seed {SEED}, round {round}");
                    assert!(faces.corners.iter().all(|&corner| (corner as usize) < set.positions.len()));
                }
            }
            Err(error) => {
                rejected_count += 1;
                assert!(error.to_string().len() < 500, "seed {SEED}, round {round}: {error}");
                let is_its_own = !matches!(error.fault, crate::fault::Fault::Rejected(_));
                assert!(is_its_own || !name.ends_with("obj"), "seed {SEED}, round {round}: {error}");
            }
        }
    }
    println!("{read_count} read, {rejected_count} rejected");
    assert!(read_count > 1000 && rejected_count > 2000, "only {read_count} read and {rejected_count} rejected");
}

#[test]
fn convex_meshes_keep_their_vertices() {
    let ball: Vec<[f32; 3]> = Family::Sphere.points(200, 3);
    for (name, bytes) in files(&prism(5)) {
        let set = &import_bytes(name, &bytes, WHOLE).unwrap().point_sets[0];
        let hull = hullmap_bake::hull::build(set).unwrap();
        assert_eq!(hull.vertices, set.positions, "{name}");
    }
    let text: String = ball.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let text = format!(
        "o Ball\nv 9 9 9\np 1\no UCX_Ball_01\n{text}p {}\n",
        (2..202).map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
    );
    let imported = import_bytes("a.obj", text.as_bytes(), ImportOptions { split: Split::Auto, ..WHOLE }).unwrap();
    assert_eq!(names(&imported), ["UCX_Ball_01"]);
    let hull = hullmap_bake::hull::build(&imported.point_sets[0]).unwrap();
    assert_eq!(hull.vertices, ball);
    assert_eq!(hull.source_vertices, (1..201).collect::<Vec<u32>>());
}

#[test]
fn auto_selects_collision_parts() {
    let auto = ImportOptions { split: Split::Auto, ..WHOLE };
    let mesh = prism(5);
    let nodes = r#"{"mesh":0,"name":"Crate"},{"mesh":0,"name":"Crate-convcolonly"},{"mesh":0,"name":"UCX_Crate_01"}"#;
    let bytes = gltf::parts(&[("prism", &mesh)], nodes, "0,1,2").glb();
    let imported = import_bytes("a.glb", &bytes, auto).unwrap();
    assert_eq!(names(&imported), ["Crate-convcolonly", "UCX_Crate_01"]);
    assert!(imported.notes.iter().any(|note| note.contains("left out: 1")), "{:?}", imported.notes);
    let crates: Vec<_> = imported.point_sets.iter().map(|set| set.stands_for.clone().unwrap()).collect();
    assert!(Arc::ptr_eq(&crates[0], &crates[1]) && crates[0].name == "Crate");
    assert_eq!(crates[0].triangles, imported.faces[0].triangles(&imported.point_sets[0].positions));
    let coacd: String = (0..3)
        .map(|part| {
            format!(
                "o convex_{part}\nv {part} 0 0\nv {part} 1 0\nv {part} 0 1\nf {} {} {}\n",
                3 * part + 1,
                3 * part + 2,
                3 * part + 3
            )
        })
        .collect();
    let imported = import_bytes("a.obj", coacd.as_bytes(), auto).unwrap();
    assert_eq!(names(&imported), ["convex_0", "convex_1", "convex_2"]);
    assert_eq!(imported.faces[2].triangles(&imported.point_sets[2].positions), [[0, 1, 2]]);
    // Without such names, the same as --split none.
    let imported = import_bytes("a.obj", coacd.replace("convex_", "part_").as_bytes(), auto).unwrap();
    assert_eq!(names(&imported), ["shape"]);
    assert!(
        imported.notes.iter().any(|note| note.contains("no object has the name of a collision part")),
        "{:?}",
        imported.notes
    );
}
