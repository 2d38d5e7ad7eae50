//! glTF, STL and PLY: one mesh in every format, other readers, and the errors of bad files.

use std::path::Path;
use std::sync::Arc;

use shapes::mesh::Mesh;
use shapes::rng::SplitMix64;
use shapes::{collada, gltf, msh, ply, solids, stl};

use super::*;

/// The outlines of all point sets together.
fn outlines(imported: &Imported) -> Vec<[[u32; 3]; 3]> {
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
    let expected = outlines(&import_file("shape.obj", obj(&mesh), WHOLE).unwrap());
    assert_eq!(expected.len(), 8 * 2);
    for (name, bytes) in files(&mesh) {
        let imported = import_file(name, &bytes, WHOLE).unwrap();
        assert_eq!(outlines(&imported), expected, "{name}");
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
        let corners = triangles(imported).into_iter().flatten();
        corners.map(|corner| imported.point_sets[0].positions[corner as usize]).collect()
    };
    for (name, bytes) in files(&mesh) {
        let ours = import_file(name, &bytes, WHOLE).unwrap();
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
    let imported = import_file("a.glb", &bytes, OBJECTS).unwrap();
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
    has_note(&imported, "repeated instances of a mesh, all included: 1");
    assert_eq!(import_file("a.glb", &bytes, WHOLE).unwrap().point_sets[0].positions.len(), 28);
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
    let imported = import_source("a.gltf", &source, WHOLE).unwrap();
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
    let error = import_source("a.gltf", &source, WHOLE).unwrap_err();
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
        import_file("a.glb", &bytes, WHOLE).map(|imported| imported.point_sets[0].positions.clone())
    };
    let interleaved = floats(&[9.0, 1.0, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0]);
    let view = r#"{"buffer":0,"byteLength":32,"byteStride":16}"#;
    let accessor = r#"{"bufferView":0,"byteOffset":4,"componentType":5126,"type":"VEC3","count":2}"#;
    assert_eq!(positions(accessor, view, &interleaved).unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    // A sparse accessor without a buffer view: zeros, and one replacement.
    let sparse = r#"{"componentType":5126,"type":"VEC3","count":3,"sparse":{"count":1,
        "indices":{"bufferView":0,"componentType":5123},"values":{"bufferView":1}}}"#;
    let buffer = [vec![1, 0, 0, 0], floats(&[7.0, 8.0, 9.0])].concat();
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
    let nan = floats(&[1.0, f32::NAN, 0.0]);
    let accessor = r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":1}"#;
    let error = positions(accessor, r#"{"buffer":0,"byteLength":12}"#, &nan).unwrap_err().to_string();
    assert!(error.contains("node 0, mesh 0: vertex 0 is at [1.0, NaN, 0.0]"), "{error}");
}

#[test]
fn primitives_of_every_mode() {
    let floats = floats(&(0..15).map(|x| (x * x) as f32).collect::<Vec<_>>());
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
        let imported = import_file("a.glb", custom(accessor, view, &primitive, "", &floats), WHOLE).unwrap();
        assert_eq!(triangles(&imported), expected, "{mode}");
        let left_out = if mode == 4 { 2 } else { 0 };
        assert_eq!(imported.unreferenced_count, left_out, "{mode}");
    }
    let twice = r#"{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":1}"#;
    let imported = import_file("a.glb", custom(accessor, view, twice, "", &floats), WHOLE).unwrap();
    assert_eq!(imported.vertex_count, 5);
}

#[test]
fn gltf_errors_are_reported() {
    let mesh = prism(5);
    let good = gltf::parts(&[("prism", &mesh)], r#"{"mesh":0,"name":"crate"}"#, "0");
    check_damages("gltf", &good.json, |json| {
        import_file("a.glb", gltf::Parts { json: json.to_owned(), ..good.clone() }.glb(), WHOLE)
    });
    for (uri, words) in [
        ("data:;base64,%%%", "buffer 0 has invalid base64"),
        ("../up.bin", "buffer 0 has the URI `../up.bin`"),
        ("beside.bin", "buffer 0 (beside.bin) is missing, since the file is read alone: export it as GLB"),
    ] {
        fails(import_file("a.gltf", good.text(uri), WHOLE), words);
    }
    let glb = good.glb();
    for length in 0..glb.len() {
        assert!(import_file("a.glb", &glb[..length], WHOLE).is_err(), "{length}");
    }
    let mut claims = glb.clone();
    claims[8] = 3;
    claims[9..12].fill(0);
    for (bytes, words) in [
        (&glb[..40], "was cut off"),
        (&claims, "a GLB chunk claims"),
        (b"glTF\x02\0\0\0\x0C\0\0\0", "no JSON chunk"),
        (b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0", "the file is glTF 1.0"),
        (b"glTF\x03\0\0\0\x0C\0\0\0", "GLB version 3"),
    ] {
        fails(import_file("a.glb", bytes, WHOLE), words);
    }
}

#[test]
fn stl_variants_and_errors() {
    let mesh = prism(5);
    let text = stl::text(&[("one", &mesh), ("two words", &mesh), ("one", &mesh)]);
    let imported = import_file("a.stl", text.as_bytes(), OBJECTS).unwrap();
    assert_eq!(names(&imported), ["one", "two words", "one_2"]);
    assert_eq!(imported.vertex_count, 10, "equal positions are one vertex");
    for text in [
        text.to_uppercase(),
        text.replace('\n', "\r\n"),
        text.replace('\n', " ").replace(" solid", "\nsolid").replace("facet normal", "\nfacet normal"),
        text.replace("normal 0 0 0", "normal nan -inf x"),
        text.replace("end", "end "),
    ] {
        assert_eq!(import_file("a.stl", text.trim_start().as_bytes(), OBJECTS).unwrap().point_count(), 30);
    }
    let binary = stl::binary(&mesh, "solid");
    let mut nan = binary.clone();
    nan[84 + 50 + 12 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    for (bytes, words) in [
        (&b"  "[..], "the file is empty"),
        (&binary[..200], "claims 16 triangles (884 bytes), but the file has 200"),
        (&stl::binary(&Mesh::default(), "x"), "no triangles found"),
        (&nan, "corner 1 of triangle 1 has the coordinate NaN"),
    ] {
        fails(import_file("a.stl", bytes, WHOLE), words);
    }
    let longer = [&binary[..], &[0; 7]].concat();
    assert!(import_file("a.stl", &longer, WHOLE).unwrap().warnings[0].starts_with("7 bytes at the end"));
}

#[test]
fn damaged_ply_files_are_errors() {
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
    let body = "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1.00000001\n3 0 1 2";
    check_damages("ply", &format!("{header}{body}"), |text| import_file("a.ply", text, WHOLE));
    for encoding in [ply::Encoding::Little, ply::Encoding::Big] {
        let bytes = ply::file(&prism(5), encoding);
        for length in 0..bytes.len() {
            assert!(import_file("a.ply", &bytes[..length], WHOLE).is_err(), "{length}");
        }
        let at = bytes.len() - prism(5).faces.iter().map(|face| 9 + 4 * face.len()).sum::<usize>() - 13;
        let mut nan = bytes.clone();
        nan[at..at + 4].fill(0xFF);
        fails(import_file("a.ply", &nan, WHOLE), "vertex 9 has the coordinate NaN");
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
        match crate::import(name, "shape", Path::new(name), &source, &OBJECTS, &limits) {
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
                let is_its_own = !matches!(error.fault, fault::Fault::Rejected(_));
                assert!(is_its_own || !name.ends_with("obj"), "seed {SEED}, round {round}: {error}");
            }
        }
    }
    println!("{read_count} read, {rejected_count} rejected");
    assert!(read_count > 1000 && rejected_count > 2000, "only {read_count} read and {rejected_count} rejected");
}

#[test]
fn auto_selects_collision_parts() {
    let mesh = prism(5);
    let nodes = r#"{"mesh":0,"name":"Crate"},{"mesh":0,"name":"Crate-convcolonly"},{"mesh":0,"name":"UCX_Crate_01"}"#;
    let bytes = gltf::parts(&[("prism", &mesh)], nodes, "0,1,2").glb();
    let imported = import_file("a.glb", &bytes, AUTO).unwrap();
    assert_eq!(names(&imported), ["Crate-convcolonly", "UCX_Crate_01"]);
    has_note(&imported, "left out: 1");
    let crates: Vec<_> = imported.point_sets.iter().map(|set| set.stands_for.clone().unwrap()).collect();
    assert!(Arc::ptr_eq(&crates[0], &crates[1]) && crates[0].name == "Crate");
    assert_eq!(crates[0].triangles, triangles(&imported));
}
