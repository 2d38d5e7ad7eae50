//! Wavefront OBJ text.

use crate::mesh::Mesh;

/// A file of vertices and polygons.
///
/// Numbers are written with Rust's `{}`: the shortest decimal that parses to the same `f32`,
/// without an exponent, and the same on every machine.
pub fn text(mesh: &Mesh) -> String {
    let mut text = String::new();
    for [x, y, z] in &mesh.vertices {
        text += &format!("v {x} {y} {z}\n");
    }
    for face in &mesh.faces {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_count_from_one() {
        let mesh = Mesh { vertices: vec![[0.0, 1e-7, -0.5], [1.0, 0.0, 0.1], [2.0; 3]], faces: vec![vec![2, 0, 1]] };
        assert_eq!(text(&mesh), "v 0 0.0000001 -0.5\nv 1 0 0.1\nv 2 2 2\nf 3 1 2\n");
    }
}
