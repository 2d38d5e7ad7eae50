//! Indexed polygon mesh.

use crate::vector::{cross, dot, to_f64};
use std::collections::BTreeSet;

/// Polygons over shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<[f32; 3]>,
    /// Corners of each polygon: zero-based vertex indices, counter-clockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
}

impl Mesh {
    /// Adds a vertex, rounded to `f32`, and returns its index. Panics if the mesh already has 2^32
    /// vertices.
    pub fn push_vertex(&mut self, position: [f64; 3]) -> u32 {
        let index = u32::try_from(self.vertices.len()).expect("fewer than 2^32 vertices");
        self.vertices.push(crate::vector::to_f32(position));
        index
    }

    /// The faces as triangles, each a fan from its first corner.
    pub fn fans(&self) -> Vec<[u32; 3]> {
        let fan = |face: &Vec<u32>| -> Vec<[u32; 3]> {
            (2..face.len()).map(|corner| [face[0], face[corner - 1], face[corner]]).collect()
        };
        self.faces.iter().flat_map(fan).collect()
    }

    /// Volume enclosed, positive where faces wind counter-clockwise seen from outside.
    ///
    /// Sums the tetrahedra from the origin to the fan of each face. Up to rounding error this is
    /// exact for a closed mesh of planar faces, convex or not. Panics if a face references a vertex
    /// that does not exist.
    pub fn signed_volume(&self) -> f64 {
        let at = |index: u32| to_f64(self.vertices[index as usize]);
        let mut six_volumes = 0.0;
        for face in &self.faces {
            for pair in face.windows(2).skip(1) {
                six_volumes += dot(at(face[0]), cross(at(pair[0]), at(pair[1])));
            }
        }
        six_volumes / 6.0
    }

    /// Checks that every edge lies between exactly two faces with consistent winding. The error
    /// names the first defect found. Panics if a face references a vertex that does not exist.
    pub fn check_closed(&self) -> Result<(), String> {
        let mut edges = BTreeSet::new();
        for corners in &self.faces {
            assert!(corners.iter().all(|&corner| (corner as usize) < self.vertices.len()), "{corners:?}");
            if corners.len() < 3 {
                return Err(format!("fewer than three corners: {corners:?}"));
            }
            for edge @ (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                if !edges.insert(edge) {
                    return Err(format!("edge {from}->{to} is used twice in one direction"));
                }
            }
        }
        match edges.iter().find(|(from, to)| !edges.contains(&(*to, *from))) {
            Some((from, to)) => Err(format!("edge {from}->{to} has no face on its left")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Mesh {
        Mesh {
            vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            faces: vec![vec![0, 2, 1], vec![0, 1, 3], vec![0, 3, 2], vec![1, 2, 3]],
        }
    }

    #[test]
    fn corner_tetrahedron_has_a_sixth_of_a_cube() {
        assert_eq!(corner().signed_volume(), 1.0 / 6.0);
        assert_eq!(corner().check_closed(), Ok(()));
    }

    #[test]
    fn defects_are_found() {
        type Change = fn(&mut Mesh);
        let changes: [(&str, Change); 3] = [
            ("has no face", |mesh| _ = mesh.faces.pop()),
            ("used twice", |mesh| mesh.faces[3].reverse()),
            ("fewer than three", |mesh| _ = mesh.faces[2].pop()),
        ];
        for (expected, change) in changes {
            let mut mesh = corner();
            change(&mut mesh);
            let defect = mesh.check_closed().unwrap_err();
            assert!(defect.contains(expected), "{defect}");
        }
    }
}
