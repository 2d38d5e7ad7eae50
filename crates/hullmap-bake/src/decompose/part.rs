//! A convex part as a point set of its mesh: corners keep their source indices.

use glam::DVec3;

use crate::fit::Frame;
use crate::hull::{self, Hull};
use hullmap_format::archive::NO_SOURCE_VERTEX;
use hullmap_geometry::PointSet;

/// Maximum number of times that a part is built again because it lost vertices.
pub const BUILDS: usize = 4;

/// The vertices of a mesh in the frame of a search, for hulls in that frame.
pub struct SourceVertices<'a> {
    mesh: &'a PointSet,
    frame: &'a Frame,
    order: Vec<u32>,
}

impl<'a> SourceVertices<'a> {
    pub fn new(mesh: &'a PointSet, frame: &'a Frame) -> Self {
        let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        order.sort_unstable_by_key(|i| (bits(mesh.positions[*i as usize]), mesh.source_vertices[*i as usize]));
        Self { mesh, frame, order }
    }

    /// The vertices of a hull as an unnamed part in the frame of the source: sorted by source
    /// index, then by position.
    pub fn part(&self, hull: &Hull) -> PointSet {
        let in_source = |p: [f32; 3]| self.frame.to_source(DVec3::from_array(p.map(f64::from))).as_vec3().to_array();
        let of_vertex = |p: &[f32; 3]| (in_source(*p), self.source_vertex_at(*p));
        let mut points: Vec<([f32; 3], u32)> = hull.vertices.iter().map(of_vertex).collect();
        points.sort_unstable_by_key(|(p, source_vertex)| (*source_vertex, p.map(f32::to_bits)));
        points.dedup();
        let (positions, source_vertices) = points.into_iter().unzip();
        PointSet { positions, source_vertices, origin: self.mesh.origin, ..PointSet::default() }
    }

    /// The hull of a part as it is built in the frame of the source. Another frame or another order
    /// of the vertices may give faces, and thus bounds, that differ by rounding.
    pub fn built(&self, mut hull: Hull) -> Hull {
        for _ in 0..BUILDS {
            let Ok(built) = hull::build(&self.part(&hull)) else { break };
            let is_same = built.vertices.len() == hull.vertices.len();
            hull = self.frame.of_hull(built);
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
    use glam::{DMat3, EulerRot};
    use shapes::rng::SplitMix64;

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
        let part = SourceVertices::new(&mesh, &Frame::new(&mesh)).part(&hull::build(&moved).unwrap());
        assert_eq!(part.source_vertices, [10, 11, 12, NO_SOURCE_VERTEX]);
        assert_eq!(part.positions, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0, 0.0, 1.5]]);
        assert_eq!((part.name.as_str(), part.origin), ("", mesh.origin));
    }

    #[test]
    fn built_parts_have_their_faces_in_the_frame_of_the_source() {
        let seed = 2021;
        println!("seed {seed}");
        let mut rng = SplitMix64::new(seed);
        for _ in 0..200 {
            // Points of a turned cube's faces, which are above or below them by rounding.
            let turn = DMat3::from_euler(EulerRot::XYZ, 6.0 * rng.unit(), 6.0 * rng.unit(), 6.0 * rng.unit());
            let point = |_| {
                let mut p = DVec3::from_array([0; 3].map(|_| rng.unit()));
                p[rng.below(3)] = rng.below(2) as f64;
                (turn * p).as_vec3().to_array()
            };
            let mut mesh = PointSet::of_positions((0..60).map(point).collect());
            mesh.triangles = (0..20).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let frame = Frame::new(&mesh);
            let turned = frame.of_mesh(&mesh);
            let vertices = SourceVertices::new(&turned, &frame);
            let built = vertices.built(hull::build(&turned).unwrap());
            let in_source = hull::build(&vertices.part(&built)).unwrap();
            assert_eq!((in_source.vertices.len(), in_source.faces.len()), (built.vertices.len(), built.faces.len()));
            let planes = built.half_spaces();
            let outside = |p: DVec3| planes.iter().map(|plane| plane.height(p)).fold(f64::NEG_INFINITY, f64::max);
            assert!(built.positions().into_iter().all(|p| outside(p) <= 1e-12), "a face that is turned inward");
        }
    }
}
