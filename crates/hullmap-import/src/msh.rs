//! MuJoCo's binary mesh format, MSH: four counts, then vertices, normals, texture coordinates and
//! triangles, all little-endian. A file is one object.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#asset-mesh>

use crate::fault::LineFault;
use crate::mesh::{Polygons, Positions, SourceMesh};

const HEADER: usize = 16;

pub fn read(bytes: &[u8]) -> Result<SourceMesh, LineFault> {
    if bytes.trim_ascii_start().starts_with(b"$MeshFormat") {
        return Err(LineFault::of_file("the file is a Gmsh mesh, not MuJoCo's MSH: export it as STL"));
    }
    let (Some(header), Some(body)) = (bytes.get(..HEADER), bytes.get(HEADER..)) else {
        return Err(LineFault::of_file(
            "the file has less than 16 bytes; expected the four counts of an MSH file: export it again",
        ));
    };
    let mut counts = [0_u64; 4];
    for (count, word) in counts.iter_mut().zip(header.as_chunks::<4>().0) {
        *count = u64::try_from(i32::from_le_bytes(*word)).map_err(|_| {
            LineFault::of_file("a count in the header is negative: this is not an MSH file, or it is damaged")
        })?;
    }
    let [vertices, normals, coordinates, faces] = counts;
    let expected = 12 * vertices + 12 * normals + 8 * coordinates + 12 * faces;
    if body.len() as u64 != expected {
        return Err(LineFault::of_file(format!(
            "the header states {expected} bytes of data, but there are {}: the file was cut off, or is not an MSH file",
            body.len()
        )));
    }
    if vertices == 0 {
        return Err(LineFault::of_file(
            "the file has no vertices, but a hull requires at least one point: export it again",
        ));
    }
    let (words, _) = body.as_chunks::<4>();
    let floats = words.get(..3 * vertices as usize).unwrap_or_default();
    let triples = floats.as_chunks::<3>().0;
    let positions: Vec<[f32; 3]> = triples.iter().map(|triple| triple.map(f32::from_le_bytes)).collect();
    if let Some(vertex) = positions.iter().position(|position| !position.iter().all(|x| x.is_finite())) {
        return Err(LineFault::of_file(format!(
            "vertex {vertex} is not finite, but a hull requires finite points: repair the mesh in its editor"
        )));
    }
    let mut polygons = Polygons::default();
    let start = (3 * vertices + 3 * normals + 2 * coordinates) as usize;
    for (face, corners) in words.get(start..).unwrap_or_default().as_chunks::<3>().0.iter().enumerate() {
        let corners = corners.map(u32::from_le_bytes);
        if corners.iter().any(|corner| u64::from(*corner) >= vertices) {
            return Err(LineFault::of_file(format!(
                "face {face} has an index out of range (the file has {vertices} vertices): export it again"
            )));
        }
        polygons.push(&corners);
    }
    Ok(SourceMesh::new(Positions::Single(positions), polygons))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Vec<u8> {
        let counts = [4_i32, 1, 1, 2].map(i32::to_le_bytes);
        let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 0.5]
            .map(f32::to_le_bytes);
        let faces = [0_i32, 2, 1, 0, 1, 3].map(i32::to_le_bytes);
        [counts.as_flattened(), floats.as_flattened(), faces.as_flattened()].concat()
    }

    #[test]
    fn vertices_and_faces_are_read() {
        let mesh = read(&tetrahedron()).unwrap();
        assert_eq!(mesh.positions.get(3), [0.0, 0.0, 1.0]);
        assert_eq!(mesh.faces.corners, [0, 2, 1, 0, 1, 3]);
    }

    #[test]
    fn damaged_files_are_rejected() {
        let good = tetrahedron();
        let changed = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            bytes
        };
        for (bytes, expected) in [
            (good[..10].to_vec(), "less than 16 bytes"),
            (good[..good.len() - 1].to_vec(), "the header states"),
            (changed(3, 0xff), "negative"),
            (changed(2, 0xff), "the header states"),
            (changed(good.len() - 1, 1), "face 1 has an index out of range"),
            ([&good[..16], &f32::NAN.to_le_bytes(), &good[20..]].concat(), "vertex 0 is not finite"),
            (vec![0; 16], "no vertices"),
            (b"$MeshFormat\n4.1 0 8\n".to_vec(), "Gmsh"),
        ] {
            let text = read(&bytes).unwrap_err().fault.to_string();
            assert!(text.contains(expected), "{text}");
        }
    }
}
