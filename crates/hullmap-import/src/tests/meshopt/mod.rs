//! glTF files compressed by meshopt. They were encoded by other programs: `streams.json` by the
//! encoder of meshoptimizer (`tests/gltf/streams.mjs`), and the GLB files by gltfpack, which packed
//! `model.glb` (`tests/gltf/model.mjs`).

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use sha2::{Digest as _, Sha256};
use shapes::gltf;
use shapes::rng::SplitMix64;

use super::*;
use crate::gltf::read;

#[derive(Default, Deserialize)]
struct Stream {
    name: String,
    mode: String,
    filter: String,
    count: usize,
    stride: usize,
    data: String,
    sha256: String,
}

fn streams() -> Vec<Stream> {
    serde_json::from_str(include_str!("streams.json")).unwrap()
}

/// GLB file with this stream of positions or indices alone. The vertices of indices are zeros.
fn glb(stream: &Stream, count: usize, data: &[u8]) -> Vec<u8> {
    let Stream { mode, filter, stride, .. } = stream;
    let length = count * stride;
    let compressed = data.len();
    let view = format!(
        r#"{{"buffer":1,"byteLength":{length},"byteStride":{stride},"extensions":{{"KHR_meshopt_compression":{{"buffer":0,"byteLength":{compressed},"byteStride":{stride},"count":{count},"mode":"{mode}","filter":"{filter}"}}}}}}"#
    );
    let (attributes, accessors) = match (mode.as_str(), stride) {
        ("ATTRIBUTES", _) => ("{\"POSITION\":0}".to_owned(), accessor(count, "VEC3", 5126)),
        (_, stride) => {
            let kind = if *stride == 2 { 5123 } else { 5125 };
            let zeros = r#"{"componentType":5126,"type":"VEC3","count":65535}"#;
            ("{\"POSITION\":1},\"indices\":0".to_owned(), accessor(count, "SCALAR", kind) + "," + zeros)
        }
    };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["KHR_meshopt_compression"],"meshes":[{{"primitives":[{{"attributes":{attributes},"mode":4}}]}}],"accessors":[{accessors}],"bufferViews":[{view}],"buffers":[{{"byteLength":{compressed}}},{{"byteLength":{length}}}]}}"#
    );
    gltf::glb(json.as_bytes(), data)
}

fn accessor(count: usize, kind: &str, component: u32) -> String {
    format!(r#"{{"bufferView":0,"componentType":{component},"type":"{kind}","count":{count}}}"#)
}

fn decode(stream: &Stream, count: usize, data: &[u8]) -> Result<Vec<u8>, ImportError> {
    let glb = glb(stream, count, data);
    crate::gltf::decoded_view(&glb, 0, &Limits::DEFAULT)
        .map_err(|crate::fault::LineFault { line, fault }| ImportError { file: "a.glb".to_owned(), line, fault })
}

/// GLB file of positions that are all 0: three bytes for 256 of them.
pub(super) fn zeros(count: usize) -> Vec<u8> {
    let mut data = vec![0xA1];
    data.resize(1 + 3 * count.div_ceil(256), 0xAA);
    data.resize(data.len() + 24, 0);
    let stream = Stream { mode: "ATTRIBUTES".to_owned(), filter: "NONE".to_owned(), stride: 12, ..Stream::default() };
    glb(&stream, count, &data)
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn streams_of_another_encoder_are_decoded() {
    let streams = streams();
    assert!(streams.len() >= 39);
    for stream in &streams {
        let data = STANDARD.decode(&stream.data).unwrap();
        let decoded = decode(stream, stream.count, &data).unwrap_or_else(|error| panic!("{}: {error}", stream.name));
        assert_eq!(decoded.len(), stream.count * stream.stride, "{}", stream.name);
        assert_eq!(hex(&Sha256::digest(&decoded)), stream.sha256, "{} {}", stream.name, stream.data.get(..2).unwrap());
    }
}

/// Attributes have room for 16 zeros at their end.
#[test]
fn damaged_streams_are_rejected() {
    for stream in &streams() {
        let data = STANDARD.decode(&stream.data).unwrap();
        for length in 0..data.len() {
            let cut = decode(stream, stream.count, &data[..length]);
            let error = cut.err().map(|error| error.to_string());
            // Zeros have no bytes that could be missing: what is cut off is padding.
            let is_padding = stream.name.starts_with("zeros") && length > 0;
            assert!(error.is_some() || is_padding, "{} to {length}", stream.name);
            assert!(error.is_none_or(|error| error.contains("buffer view 0, compressed by KHR")));
        }
        if stream.mode != "ATTRIBUTES" {
            for count in [stream.count + 3, stream.count - 3] {
                assert!(decode(stream, count, &data).is_err(), "{} as {count}", stream.name);
            }
        }
    }
}

#[test]
fn streams_with_flipped_bytes_are_decoded_or_rejected() {
    let mut random = SplitMix64::new(38);
    let (mut rejected, mut decoded) = (0, 0);
    for stream in &streams() {
        let data = STANDARD.decode(&stream.data).unwrap();
        for _ in 0..200 {
            let mut flipped = data.clone();
            for _ in 0..=random.next_u64() % 3 {
                let at = random.next_u64() as usize % flipped.len();
                flipped[at] ^= 1 << (random.next_u64() % 8);
            }
            match decode(stream, stream.count, &flipped) {
                Ok(bytes) => {
                    assert_eq!(bytes.len(), stream.count * stream.stride);
                    decoded += 1;
                }
                Err(_) => rejected += 1,
            }
        }
    }
    assert!(rejected > 1000 && decoded > 1000, "{rejected} rejected, {decoded} decoded");
}

#[test]
fn a_small_stream_cannot_claim_much_memory() {
    assert_eq!(import_file("a.glb", zeros(70_000), WHOLE).unwrap().vertex_count, 70_000);
    let stream = Stream { mode: "ATTRIBUTES".to_owned(), filter: "NONE".to_owned(), stride: 12, ..Stream::default() };
    for count in [1 << 27, usize::MAX / 64] {
        fails(import_file("a.glb", glb(&stream, count, &[0xA1; 64]), WHOLE), "max_instanced");
    }
}

#[test]
fn properties_that_contradict_one_another_are_rejected() {
    let streams = streams();
    let stream = streams.iter().find(|stream| stream.name == "floats 17 x 12").unwrap();
    let data = STANDARD.decode(&stream.data).unwrap();
    let good = String::from_utf8_lossy(&glb(stream, stream.count, &data)).into_owned();
    let json = &good[good.find('{').unwrap()..good.rfind("}]}").unwrap() + 3];
    let import = |json: &str| import_file("a.glb", gltf::glb(json.as_bytes(), &data), WHOLE);
    assert_eq!(import(json).unwrap().vertex_count, 17);
    check_damages("meshopt", json, import);
}

/// The model, packed with integers of 14 bits, with exponents, and as floats: each vertex stays at
/// its place to within the precision that gltfpack was given, and no triangle is lost.
#[test]
fn files_of_gltfpack_have_the_shape_of_their_model() {
    let model = import_file("a.glb", include_bytes!("model.glb"), WHOLE).unwrap();
    for (name, bytes, precision) in [
        ("ext-integers", &include_bytes!("ext-integers.glb")[..], 2.6 / f64::from(1 << 14)),
        ("khr-integers", include_bytes!("khr-integers.glb"), 2.6 / f64::from(1 << 14)),
        ("khr-exponents", include_bytes!("khr-exponents.glb"), 2.6 / f64::from(1 << 14)),
        ("ext-floats", include_bytes!("ext-floats.glb"), 1e-6),
    ] {
        let packed = import_file("a.glb", bytes, WHOLE).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(packed.vertex_count, model.vertex_count, "{name}");
        assert_eq!(packed.faces[0].len(), model.faces[0].len(), "{name}");
        for (points, others) in [(&packed, &model), (&model, &packed)] {
            for point in &points.point_sets[0].positions {
                let distance = |other: &[f32; 3]| {
                    (0..3).map(|axis| f64::from(point[axis] - other[axis]).powi(2)).sum::<f64>().sqrt()
                };
                let nearest = others.point_sets[0].positions.iter().map(distance).fold(f64::INFINITY, f64::min);
                assert!(nearest <= precision, "{name}: {point:?} is {nearest} away");
            }
        }
    }
}

#[test]
fn views_outside_the_scene_may_be_damaged() {
    let bytes = gltf::parts(
        &[("a", &shapes::solids::extrusion(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.0, 1.0))],
        r#"{"mesh":0}"#,
        "0",
    )
    .text_with_data();
    let view = r#""bufferViews":[{"buffer":0,"byteLength":36,"extensions":{"EXT_meshopt_compression":{"buffer":9,"byteLength":1,"byteStride":12,"count":3,"mode":"ATTRIBUTES"}}},"#;
    let text = bytes.replacen("\"bufferViews\":[", view, 1).replace("\"bufferView\":1", "\"bufferView\":2").replacen(
        "\"bufferView\":0",
        "\"bufferView\":1",
        1,
    );
    assert!(text.contains("\"bufferView\":1") && text.contains("\"bufferView\":2"));
    read(text.as_bytes(), &[], false, &Limits::DEFAULT).map_err(|fault| fault.fault.to_string()).unwrap();
}
