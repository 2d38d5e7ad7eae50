//! MSH, the binary format of MuJoCo.

use crate::mesh::Mesh;

/// A file of vertices and triangles, without normals and texture coordinates. Polygons become
/// fans.
pub fn file(mesh: &Mesh) -> Vec<u8> {
    let triangles = mesh.fans();
    let counts = [mesh.vertices.len() as u32, 0, 0, triangles.len() as u32];
    let mut bytes: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
    bytes.extend(mesh.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes.extend(triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
    bytes
}
