//! A convex part as a point set of its mesh: corners keep their source indices.

use crate::hull::{self, Hull};
use hullmap_format::archive::NO_SOURCE_VERTEX;
use hullmap_geometry::PointSet;

/// Maximum number of times that a part is built again because it lost vertices.
pub const BUILDS: usize = 4;

pub struct SourceVertices<'a> {
    mesh: &'a PointSet,
    order: Vec<u32>,
}

impl<'a> SourceVertices<'a> {
    pub fn new(mesh: &'a PointSet) -> Self {
        let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        order.sort_unstable_by_key(|i| (bits(mesh.positions[*i as usize]), mesh.source_vertices[*i as usize]));
        Self { mesh, order }
    }

    /// The vertices of a hull as an unnamed part: sorted by source index, then by position.
    pub fn part(&self, hull: &Hull) -> PointSet {
        let mut points: Vec<([f32; 3], u32)> = hull.vertices.iter().map(|p| (*p, self.source_vertex_at(*p))).collect();
        points.sort_unstable_by_key(|(p, source_vertex)| (*source_vertex, p.map(f32::to_bits)));
        points.dedup();
        let (positions, source_vertices) = points.into_iter().unzip();
        PointSet { positions, source_vertices, origin: self.mesh.origin, ..PointSet::default() }
    }

    /// The hull of a part's vertices in their order in the mesh. Another order may give faces, and
    /// thus bounds, that differ by rounding.
    pub fn built(&self, mut hull: Hull) -> Hull {
        for _ in 0..BUILDS {
            let Ok(built) = hull::build(&self.part(&hull)) else { break };
            let is_same = built.vertices.len() == hull.vertices.len();
            hull = built;
            if is_same {
                break;
            }
        }
        hull
    }

    /// The source vertex at a position; [`NO_SOURCE_VERTEX`] if there is none.
    fn source_vertex_at(&self, p: [f32; 3]) -> u32 {
        let position = |i: &u32| bits(self.mesh.positions[*i as usize]);
        let index = self.order.partition_point(|i| position(i) < bits(p));
        let found = self.order.get(index).filter(|i| position(i) == bits(p));
        found.map_or(NO_SOURCE_VERTEX, |i| self.mesh.source_vertices[*i as usize])
    }
}

/// −0 and 0 are equal.
fn bits(p: [f32; 3]) -> [u32; 3] {
    p.map(|c| (c + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_are_source_vertices_keep_their_indices() {
        let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let mesh = PointSet {
            name: "mesh".to_owned(),
            positions: corners,
            source_vertices: vec![12, 14, 11, 13, 10],
            origin: [1.0, 2.0, 3.0],
            ..PointSet::default()
        };
        // A corner was moved, and another one is -0.
        let moved = vec![[-0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.5]];
        let moved = PointSet::of_positions(moved);
        let part = SourceVertices::new(&mesh).part(&hull::build(&moved).unwrap());
        assert_eq!(part.source_vertices, [10, 11, 12, NO_SOURCE_VERTEX]);
        assert_eq!(part.positions, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0, 0.0, 1.5]]);
        assert_eq!((part.name.as_str(), part.origin), ("", mesh.origin));
    }
}
