//! Indexed polygon mesh.

use crate::vector::{cross, dot, to_f64};
use std::collections::BTreeSet;
use std::fmt;

/// Polygons over shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<[f32; 3]>,
    /// Corners of each polygon: zero-based vertex indices, counter-clockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
}

/// Reason why a mesh is not a closed, consistently wound surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshDefect {
    /// A face references a vertex that does not exist.
    IndexOutOfRange {
        /// Zero-based index of the face.
        face: usize,
        /// Vertex index out of range.
        index: u32,
    },
    /// A face has fewer than three corners.
    TooFewCorners {
        /// Zero-based index of the face.
        face: usize,
    },
    /// Two faces traverse an edge in the same direction, or one does so twice.
    EdgeRepeated {
        /// First vertex of the directed edge.
        from: u32,
        /// Second vertex of the directed edge.
        to: u32,
    },
    /// A face traverses an edge, and no face traverses it in the other direction.
    EdgeOpen {
        /// First vertex of the directed edge.
        from: u32,
        /// Second vertex of the directed edge.
        to: u32,
    },
}

impl fmt::Display for MeshDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange { face, index } => {
                write!(f, "face {face} has the vertex index {index}, which is out of range")
            }
            Self::TooFewCorners { face } => write!(f, "face {face} has fewer than three corners"),
            Self::EdgeRepeated { from, to } => {
                write!(f, "edge {from}->{to} is used twice in one direction")
            }
            Self::EdgeOpen { from, to } => write!(f, "edge {from}->{to} has no face on its left"),
        }
    }
}

impl std::error::Error for MeshDefect {}

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

    /// Checks that every edge lies between exactly two faces with consistent winding. The error is
    /// the first defect found.
    pub fn check_closed(&self) -> Result<(), MeshDefect> {
        let mut edges = BTreeSet::new();
        for (face, corners) in self.faces.iter().enumerate() {
            if corners.len() < 3 {
                return Err(MeshDefect::TooFewCorners { face });
            }
            for (i, &from) in corners.iter().enumerate() {
                if from as usize >= self.vertices.len() {
                    return Err(MeshDefect::IndexOutOfRange { face, index: from });
                }
                let to = corners[(i + 1) % corners.len()];
                if !edges.insert((from, to)) {
                    return Err(MeshDefect::EdgeRepeated { from, to });
                }
            }
        }
        for &(from, to) in &edges {
            if !edges.contains(&(to, from)) {
                return Err(MeshDefect::EdgeOpen { from, to });
            }
        }
        Ok(())
    }

    /// Vertices that no face uses, in ascending order.
    pub fn unreferenced_vertices(&self) -> Vec<u32> {
        let used: BTreeSet<u32> = self.faces.iter().flatten().copied().collect();
        (0..self.vertices.len() as u32).filter(|index| !used.contains(index)).collect()
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
        let mut open = corner();
        open.faces.pop();
        assert!(matches!(open.check_closed(), Err(MeshDefect::EdgeOpen { .. })));

        let mut flipped = corner();
        flipped.faces[3].reverse();
        assert!(matches!(flipped.check_closed(), Err(MeshDefect::EdgeRepeated { .. })));

        let mut missing = corner();
        missing.faces[0][1] = 4;
        assert_eq!(missing.check_closed(), Err(MeshDefect::IndexOutOfRange { face: 0, index: 4 }));

        let mut thin = corner();
        thin.faces[2].pop();
        assert_eq!(thin.check_closed(), Err(MeshDefect::TooFewCorners { face: 2 }));
    }

    #[test]
    fn unreferenced_vertices_are_listed() {
        let mut mesh = corner();
        let extra = mesh.push_vertex([9.0, -0.0, 9.0]);
        assert_eq!(mesh.unreferenced_vertices(), [extra]);
    }
}
