//! glTF primitives compressed by Draco, encoded here by the crate that decodes them. Its own tests
//! compare it with Google's library.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh as DracoInput, MeshEncoder,
    PointAttribute, PointIndex,
};
use shapes::gltf;

use super::*;
use crate::gltf::draco;

/// Versions of the format with different headers: the current version, and earlier ones.
const VERSIONS: [(u8, u8); 5] = [(2, 2), (2, 1), (2, 0), (1, 3), (1, 2)];

/// Exact positions. `speed` selects the encodings: 10 is sequential, the others EdgeBreaker.
fn encode(mesh: &Mesh, speed: i32) -> Vec<u8> {
    encode_rounded(mesh, speed, None)
}

fn encode_rounded(mesh: &Mesh, speed: i32, bits: Option<i32>) -> Vec<u8> {
    encode_as(VERSIONS[0], mesh, speed, bits).unwrap()
}

/// [`encode_rounded`] in a version of the format. `None` if the version lacks the encoding.
fn encode_as(version: (u8, u8), mesh: &Mesh, speed: i32, bits: Option<i32>) -> Option<Vec<u8>> {
    let mut input = DracoInput::new();
    let mut positions = PointAttribute::new();
    positions.init(GeometryAttributeType::Position, 3, DataType::Float32, false, mesh.vertices.len());
    for (at, x) in mesh.vertices.as_flattened().iter().enumerate() {
        positions.buffer_mut().write(4 * at, &x.to_le_bytes());
    }
    input.set_num_points(mesh.vertices.len());
    input.add_attribute(positions);
    let triangles = mesh.fans();
    input.set_num_faces(triangles.len());
    for (at, triangle) in triangles.iter().enumerate() {
        input.set_face(FaceIndex(at as u32), triangle.map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_version(version.0, version.1);
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    if let Some(bits) = bits {
        options.set_attribute_int(0, "quantization_bits", bits);
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(input);
    let mut buffer = EncoderBuffer::new();
    encoder.encode(&options, &mut buffer).ok()?;
    Some(buffer.data().to_vec())
}

/// Data of a prism in each encoding, exact and rounded.
pub(super) fn prisms() -> Vec<Vec<u8>> {
    let speeds = [0, 3, 5, 7, 10];
    let rounded = speeds.map(|speed| encode_rounded(&prism(9), speed, Some(11)));
    [speeds.map(|speed| encode(&prism(9), speed)), rounded].concat()
}

/// GLB file of a sheet of `2 * n` compressed triangles.
pub(super) fn sheet(n: u32) -> Vec<u8> {
    glb(&encode_rounded(&sheet_mesh(n), 5, Some(14)), "")
}

fn sheet_mesh(n: u32) -> Mesh {
    let side = 64;
    let vertices = (0..n + side + 1).map(|at| [(at % side) as f32, (at / side) as f32, (at % 7) as f32]);
    let faces = (0..n).flat_map(|at| [vec![at, at + 1, at + side], vec![at + side, at + 1, at + side + 1]]);
    Mesh { vertices: vertices.collect(), faces: faces.collect() }
}

fn json(length: usize, nodes: &str, uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"],{nodes}"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1}},"indices":0,"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":0}}}}}}}}]}}],"accessors":[{{"componentType":5123,"type":"SCALAR","count":3}},{{"componentType":5126,"type":"VEC3","count":3}}],"bufferViews":[{{"buffer":0,"byteLength":{length}}}],"buffers":[{{{uri}"byteLength":{length}}}]}}"#
    )
}

fn import_glb(bytes: Vec<u8>) -> Result<Imported, ImportError> {
    import_file("a.glb", bytes, WHOLE)
}

pub(super) fn glb(data: &[u8], nodes: &str) -> Vec<u8> {
    gltf::glb(json(data.len(), nodes, "").as_bytes(), data)
}

#[test]
fn draco_primitives_are_decoded() {
    let mesh = prism(9);
    let expected = outline(&mesh.vertices, &mesh.fans());
    for speed in [0, 3, 5, 7, 10] {
        let imported = import_glb(glb(&encode(&mesh, speed), "")).unwrap();
        let set = &imported.point_sets[0];
        assert_eq!(set.positions.len(), mesh.vertices.len(), "{speed}");
        assert_eq!(outline(&set.positions, &triangles(&imported)), expected, "{speed}");
        let imported = import_glb(glb(&encode_rounded(&mesh, speed, Some(14)), "")).unwrap();
        let is_near = |v: &[f32; 3]| mesh.vertices.iter().any(|w| (0..3).all(|axis| (v[axis] - w[axis]).abs() < 2e-4));
        assert_eq!((imported.point_count(), imported.faces[0].len()), (18, expected.len()));
        assert!(imported.point_sets[0].positions.iter().all(is_near), "{speed}");
    }
}

#[test]
fn instances_of_a_draco_mesh_are_placed_and_mirrored() {
    let mesh = prism(9);
    let nodes = r#""nodes":[{"mesh":0,"scale":[-1,1,1],"translation":[10,0,0]},{"mesh":0}],"#;
    let imported = import_file("a.glb", glb(&encode(&mesh, 5), nodes), OBJECTS).unwrap();
    let [mirrored, plain] = &imported.point_sets[..] else { panic!("{}", imported.point_sets.len()) };
    assert_eq!((mirrored.positions.len(), plain.source_vertices[0]), (18, 18));
    for (set, faces) in imported.point_sets.iter().zip(&imported.faces) {
        let faces = faces.triangles(&set.positions).iter().map(|corners| corners.to_vec()).collect();
        assert!(Mesh { vertices: set.positions.clone(), faces }.signed_volume() > 0.5);
    }
    for (a, b) in mirrored.positions.iter().zip(&plain.positions) {
        assert_eq!(*a, [(10.0 - f64::from(b[0])) as f32, b[1], b[2]]);
    }
}

#[test]
fn the_buffer_of_draco_data_is_required() {
    let data = encode(&prism(9), 5);
    let text = json(data.len(), "", r#""uri":"a.bin","#).into_bytes();
    assert_eq!(crate::gltf::buffer_paths(&text).unwrap(), ["a.bin"]);
    let mut source = SourceFile::alone(text);
    source.beside = vec![("a.bin".to_owned(), data)];
    assert_eq!(import_source("a.gltf", &source, WHOLE).unwrap().point_count(), 18);
}

#[test]
fn the_fallback_of_draco_compression_is_read() {
    let points = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let buffer = [points, vec![0, 0, 1, 0, 2, 0]].concat();
    let text = json(9, "", r#""uri":"none.bin","#)
        .replace(r#"{"componentType":5123"#, r#"{"bufferView":2,"componentType":5123"#)
        .replace(r#"{"componentType":5126"#, r#"{"bufferView":1,"componentType":5126"#)
        .replace(r#""bufferViews":["#, r#""bufferViews":[{"buffer":1,"byteLength":9},{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6},"#)
        .replace(r#""buffers":["#, r#""buffers":[{"byteLength":42},"#);
    let imported = import_glb(gltf::glb(text.as_bytes(), &buffer)).unwrap();
    assert_eq!(imported.faces[0].corners, [0, 1, 2]);
}

#[test]
fn draco_data_is_limited_and_checked() {
    let data = encode(&prism(9), 5);
    check_damages("draco", &json(data.len(), "", ""), |text| import_glb(gltf::glb(text.as_bytes(), &data)));
    fails(import_glb(glb(b"DRACO is damaged", "")), "is damaged (");
    let mut cloud = data.clone();
    cloud[7] = 0;
    fails(import_glb(glb(&cloud, "")), "is damaged (it is not a mesh)");
    let large =
        Mesh { vertices: vec![[1.0; 3]; 20_000], faces: (0..19_998).map(|at| vec![at, at + 1, at + 2]).collect() };
    let large = encode_rounded(&large, 5, Some(11));
    assert!(large.len() < 20_000, "{}", large.len());
    let limits = Limits { repeated_vertices: 10_000, ..Limits::DEFAULT };
    fails(import_within(&limits, "a.glb", glb(&large, "")), "--set max_instanced");
    assert!(import_glb(glb(&large, "")).is_ok_and(|imported| imported.vertex_count > 1000));
}

/// A grid of 52 KB took two seconds and 137 MB before it was rejected.
#[test]
fn data_is_rejected_by_its_header_before_it_is_decoded() {
    let mesh = sheet_mesh(1000);
    let limits = Limits { repeated_vertices: 1000, ..Limits::DEFAULT };
    let mut versions = std::collections::BTreeSet::new();
    for version in VERSIONS {
        for speed in [0, 3, 5, 7, 10] {
            let Some(data) = encode_as(version, &mesh, speed, Some(11)) else { continue };
            versions.insert((version, speed == 10));
            let claim = draco::claim(&data).ok().unwrap();
            let claimed = (claim.triangles, claim.vertices);
            assert_eq!(claimed, (2000, mesh.vertices.len()), "{version:?}, speed {speed}");
            assert_eq!(draco::decode(&data, 0, claim).ok().unwrap().triangles.len(), 2000);
            fails(import_within(&limits, "a.glb", glb(&data[..24], "")), "max_instanced");
            fails(import_glb(glb(&data[..24], "")), "is damaged (");
        }
    }
    assert!(versions.len() > VERSIONS.len(), "{versions:?}");
}

/// Each byte of metadata took up to 270 bytes of memory.
#[test]
fn metadata_of_draco_data_is_skipped_and_limited() {
    let with_metadata = |metadata: &[u8]| {
        let mut data = encode(&prism(9), 5);
        // A flag of the header, which has 11 bytes.
        data[10] |= 0x80;
        data.splice(11..11, metadata.iter().copied());
        import_glb(glb(&data, ""))
    };
    // Metadata of one attribute, and of the whole, both with the entry `a`.
    let metadata = b"\x01\x00\x01\x01a\x02xy\x00\x01\x01a\x01z\x00";
    assert_eq!(with_metadata(metadata).unwrap().point_count(), 18);
    // 32,768 attributes without entries: 96 KiB.
    let many = [&b"\x80\x80\x02"[..], &[0; (3 << 15) + 2]].concat();
    fails(with_metadata(&many), "is damaged (");
}

/// An accessor that declared 3 elements for 40,000 points passed silently.
#[test]
fn a_wrong_count_of_an_accessor_is_reported() {
    let data = encode(&prism(9), 5);
    let warnings = |from: &str, to: &str| {
        let text = json(data.len(), "", "").replace(r#""SCALAR","count":3"#, r#""SCALAR","count":96"#);
        let text = text.replace(r#""VEC3","count":3"#, r#""VEC3","count":18"#);
        assert!(text.contains(from));
        import_glb(gltf::glb(text.replacen(from, to, 1).as_bytes(), &data)).unwrap().warnings
    };
    assert_eq!(3 * prism(9).fans().len(), 96);
    assert_eq!(warnings("18", "18"), [""; 0]);
    assert_eq!(
        warnings("18", "3"),
        ["accessor 1 declares 3 elements, but its compressed data has 18; all data is used: if the hull is wrong, \
          export the file again"]
    );
    assert!(warnings("96", "95")[0].starts_with("accessor 0 declares 95 elements"));
    // A strip declares the number of its corners, which differs from the number of its triangles.
    assert_eq!(warnings(r#""indices":0"#, r#""mode":5,"indices":0"#), [""; 0]);
    assert_eq!(warnings(r#""count":96"#, r#""count":12,"x":5"#).len(), 1);
}
