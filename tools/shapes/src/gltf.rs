//! glTF 2.0: a document with one buffer, as text, text with embedded data, or GLB.

use crate::mesh::Mesh;

/// A document and its buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parts {
    /// The text. It contains `BUFFER_URI` in place of the `uri` member of the buffer.
    pub json: String,
    /// The buffer.
    pub buffer: Vec<u8>,
}

/// Stands for `"uri": …` in a document.
const BUFFER_URI: &str = "BUFFER_URI";

/// Document of named meshes, with faces triangulated as fans.
///
/// `nodes` is the text of glTF's list of nodes, and `roots` is the text of the scene's list of root
/// nodes. Mesh `i` has its positions in accessor `2 i` and its vertex indices in `2 i + 1`.
pub fn parts(meshes: &[(&str, &Mesh)], nodes: &str, roots: &str) -> Parts {
    let mut buffer = Vec::new();
    let (mut views, mut accessors, mut records) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (name, mesh)) in meshes.iter().enumerate() {
        let start = buffer.len();
        buffer.extend(mesh.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let middle = buffer.len();
        let fans = mesh.fans();
        buffer.extend(fans.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
        views.push(view(start, middle));
        views.push(view(middle, buffer.len()));
        let bound = |choose: fn(f32, f32) -> f32, from: f32| {
            [0, 1, 2].map(|axis| mesh.vertices.iter().map(|v| v[axis]).fold(from, choose))
        };
        let (low, high) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let (first, second) = (2 * index, 2 * index + 1);
        accessors.push(format!(
            r#"{{"bufferView":{first},"componentType":5126,"type":"VEC3","count":{},"min":{low:?},"max":{high:?}}}"#,
            mesh.vertices.len()
        ));
        accessors.push(format!(
            r#"{{"bufferView":{second},"componentType":5125,"type":"SCALAR","count":{}}}"#,
            3 * fans.len()
        ));
        records.push(format!(
            r#"{{"name":"{name}","primitives":[{{"attributes":{{"POSITION":{first}}},"indices":{second}}}]}}"#
        ));
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{roots}]}}],"nodes":[{nodes}],"meshes":[{}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{{BUFFER_URI}"byteLength":{}}}]}}"#,
        records.join(","),
        accessors.join(","),
        views.join(","),
        buffer.len()
    );
    Parts { json, buffer }
}

fn view(start: usize, end: usize) -> String {
    format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, end - start)
}

impl Parts {
    /// The text, with its buffer in the file `uri` beside it.
    pub fn text(&self, uri: &str) -> String {
        self.json.replace(BUFFER_URI, &format!(r#""uri":"{uri}","#))
    }

    /// The text, with its buffer as a data URI.
    pub fn text_with_data(&self) -> String {
        self.text(&format!("data:application/octet-stream;base64,{}", base64(&self.buffer)))
    }

    /// A GLB file.
    pub fn glb(&self) -> Vec<u8> {
        glb(self.json.replace(BUFFER_URI, "").as_bytes(), &self.buffer)
    }
}

/// GLB file of a text and a buffer. Panics if it would have 2^32 bytes or more.
pub fn glb(json: &[u8], buffer: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], pad: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), pad);
        bytes
    };
    let (json, buffer) = (padded(json, b' '), padded(buffer, 0));
    let length = |length: usize| u32::try_from(length).expect("less than 4 GiB").to_le_bytes();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend(length(12 + 8 + json.len() + 8 + buffer.len()));
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", buffer)] {
        bytes.extend(length(chunk.len()));
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// Base64 with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let word = three.iter().fold(0, |word, &byte| word << 8 | u32::from(byte)) << (8 * (3 - three.len()));
        for digit in 0..4 {
            let is_padding = digit > three.len();
            text.push(if is_padding { '=' } else { DIGITS[(word >> (18 - 6 * digit)) as usize & 63].into() });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_pads() {
        assert_eq!(
            ["", "f", "fo", "foo", "foob"].map(|s| base64(s.as_bytes())),
            ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg=="]
        );
    }

    #[test]
    fn chunks_are_aligned() {
        let mesh = crate::solids::extrusion(&crate::solids::regular_polygon(4, 1.0), 0.0, 1.0);
        let bytes = parts(&[("cube", &mesh)], r#"{"mesh":0}"#, "0").glb();
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(bytes[8..12], (bytes.len() as u32).to_le_bytes());
    }
}
