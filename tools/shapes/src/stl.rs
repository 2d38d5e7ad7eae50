//! STL, as text and binary.

use crate::mesh::Mesh;

/// A binary file: each face as a fan of triangles, with normals of zero. The 80 bytes before the
/// count hold `header`, cut off or filled with blanks. Panics if there are 2^32 triangles or more.
pub fn binary(mesh: &Mesh, header: &str) -> Vec<u8> {
    let triangles = mesh.fans();
    let mut bytes: Vec<u8> = header.bytes().chain(std::iter::repeat(b' ')).take(80).collect();
    bytes.extend(u32::try_from(triangles.len()).expect("fewer than 2^32 triangles").to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        for corner in corners {
            bytes.extend(mesh.vertices[corner as usize].iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// A text of one solid for each name and mesh.
pub fn text(solids: &[(&str, &Mesh)]) -> String {
    let mut text = String::new();
    for (name, mesh) in solids {
        text += &format!("solid {name}\n");
        for corners in mesh.fans() {
            text += "  facet normal 0 0 0\n    outer loop\n";
            for corner in corners {
                let [x, y, z] = mesh.vertices[corner as usize];
                text += &format!("      vertex {x:e} {y:e} {z:e}\n");
            }
            text += "    endloop\n  endfacet\n";
        }
        text += &format!("endsolid {name}\n");
    }
    text
}
