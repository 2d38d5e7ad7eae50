//! Converts a surface to a mesh for debug renderers, which draw nothing for custom shapes.

use super::super::convert::narrow;
use super::super::parry::math::Vector;
use super::BakedSurface;

impl BakedSurface {
    /// Vertices and triangles for debugging, in the frame of the shape, with three vertices for
    /// each triangle, and without holes.
    pub fn to_trimesh(&self) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let mut vertices = Vec::new();
        for tile in self.tiles() {
            for triangle in (0..tile.triangle_count()).filter_map(|index| tile.triangle(index)) {
                vertices.extend(triangle.corners().map(|corner| narrow(tile.place().transform_point(corner))));
            }
        }
        let triangles = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        (vertices, triangles)
    }
}
