//! Hulls as binary glTF 2.0: a node and a mesh each, with triangles, or lines or points. The extras
//! of a node have the mass of the mesh that the hull stands for.
//!
//! The crate `gltf` would bring five more packages into the command for the types of its JSON; it
//! reads the files in the tests.
//!
//! # Reference
//! Khronos Group, "glTF 2.0 Specification", sections 3.6 (binary data) and 3.7 (geometry).

use serde_json::{Value, json};

use super::body::Body;
use super::glb_chunks::{self, BIN, JSON};
use super::seal::{SEAL, sealed};

const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

const U32: u32 = 5125;
const F32: u32 = 5126;

const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The file. Fails if it would be larger than 4 GiB, the limit of its header.
pub fn write(bodies: &[Body]) -> Result<Vec<u8>, String> {
    let mut buffer = Vec::new();
    let (mut views, mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (index, body) in bodies.iter().enumerate() {
        let positions = push(&mut buffer, body.positions.iter().flatten().map(|coordinate| coordinate.to_le_bytes()));
        let (mode, indices): (u32, Vec<u32>) = match body.rank {
            0 => (POINTS, vec![0]),
            1 => (LINES, (0..body.positions.len() as u32).collect()),
            _ => (TRIANGLES, body.triangles().flatten().collect()),
        };
        let index_count = indices.len();
        let indices = push(&mut buffer, indices.into_iter().map(u32::to_le_bytes));
        let [low, high] = bounds(&body.positions);
        accessors.push(json!({
            "bufferView": 2 * index, "componentType": F32, "count": body.positions.len(), "type": "VEC3",
            "min": low, "max": high,
        }));
        accessors.push(json!({
            "bufferView": 2 * index + 1, "componentType": U32, "count": index_count, "type": "SCALAR",
        }));
        views.push(view(positions, VERTICES));
        views.push(view(indices, INDICES));
        let primitive = json!({ "attributes": { "POSITION": 2 * index }, "indices": 2 * index + 1, "mode": mode });
        meshes.push(json!({ "name": body.name, "primitives": [primitive] }));
        let mut node = json!({ "name": body.name, "mesh": index });
        if let Some(extras) = body.extras() {
            node["extras"] = extras;
        }
        nodes.push(node);
    }
    let root = json!({
        "asset": { "version": "2.0", "generator": SEAL },
        "scene": 0,
        "scenes": [{ "nodes": (0..bodies.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": buffer.len() }],
    });
    glb_chunks::write(vec![(JSON, root.to_string().into_bytes()), (BIN, buffer)]).map(sealed)
}

/// Appends numbers, and returns their offset and length in bytes.
fn push(buffer: &mut Vec<u8>, numbers: impl Iterator<Item = [u8; 4]>) -> [usize; 2] {
    let start = buffer.len();
    buffer.extend(numbers.flatten());
    [start, buffer.len() - start]
}

fn view([offset, length]: [usize; 2], target: u32) -> Value {
    json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target })
}

pub fn bounds(positions: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for position in positions {
        for (axis, coordinate) in position.iter().enumerate() {
            bounds[0][axis] = bounds[0][axis].min(*coordinate);
            bounds[1][axis] = bounds[1][axis].max(*coordinate);
        }
    }
    bounds
}
