use glam::DVec3;
use hullmap_geometry::planes::{HalfSpace, of_face};

/// A certified convex hull.
#[derive(Clone, Debug)]
pub struct Hull {
    /// Dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Positions of the vertices in source order, then of the vertices that the source lacks.
    /// Negative zeros are replaced by positive ones.
    pub vertices: Vec<[f32; 3]>,
    /// For each vertex, the first source vertex with that position;
    /// [`NO_SOURCE_VERTEX`](crate::NO_SOURCE_VERTEX) if there is none.
    pub source_vertices: Vec<u32>,
    /// Faces as polygons of vertex indices, counter-clockwise seen from outside. A solid has its
    /// facets; a polygon has both of its sides.
    pub faces: Vec<Vec<u32>>,
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// Maximum distance of a source point outside the hull, relative to the diameter.
    pub containment_error: f64,
}

impl Hull {
    /// Vertex positions in f64.
    pub fn positions(&self) -> Vec<DVec3> {
        self.vertices.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()
    }

    /// One half-space per face of a solid hull with area, each containing the whole face.
    pub fn half_spaces(&self) -> Vec<HalfSpace> {
        let positions = self.positions();
        let of_face = |face: &Vec<u32>| {
            let corners: Vec<DVec3> = face.iter().map(|v| positions[*v as usize]).collect();
            Some(of_face(&corners, &positions)?.0)
        };
        self.faces.iter().filter_map(of_face).collect()
    }

    /// For each vertex, the vertices that share an edge with it, ascending.
    ///
    /// # Complexity
    /// O(number of face corners), plus sorting.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); self.vertices.len()];
        for (a, b) in self.faces.iter().flat_map(|face| edges(face)) {
            neighbours[a as usize].push(b);
        }
        if self.rank == 1 {
            neighbours = vec![vec![1], vec![0]];
        }
        for list in &mut neighbours {
            list.sort_unstable();
            // Both sides of a polygon have the same edges, so each neighbour occurs twice.
            list.dedup();
        }
        neighbours
    }

    /// For each entry w in the list of vertex v in `neighbours`, the index of the face in which w
    /// follows v; 0 if there are no faces.
    ///
    /// # Complexity
    /// O(number of face corners), with a binary search in the vertex's neighbours for each.
    pub fn neighbour_faces(&self, neighbours: &[Vec<u32>]) -> Vec<u32> {
        let mut left: Vec<Vec<u32>> = neighbours.iter().map(|list| vec![0; list.len()]).collect();
        for (index, face) in self.faces.iter().enumerate() {
            for (a, b) in edges(face) {
                if let Ok(at) = neighbours[a as usize].binary_search(&b) {
                    left[a as usize][at] = index as u32;
                }
            }
        }
        left.concat()
    }
}

/// Directed edges of a polygon.
pub(crate) fn edges(face: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    face.iter().copied().zip(face.iter().copied().cycle().skip(1))
}
