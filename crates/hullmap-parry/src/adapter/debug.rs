//! Converts a baked hull to meshes for debug renderers, which draw nothing for custom shapes.

use super::BakedHull;
use super::convert::narrow;
use super::parry::math::Vector;
use super::parry::shape::ConvexPolyhedron;

impl BakedHull {
    /// Vertices and triangles of the surface in the local frame with the scale, for debugging, in
    /// O(n). Faces are split into fans. Seen from outside, triangles are counter-clockwise, also on
    /// a mirrored hull.
    pub fn to_trimesh(&self) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let hull = self.hull();
        let scale = self.scale_factors();
        let vertices = hull.vertices().map(|v| narrow(v.as_dvec3() * scale)).collect();
        let mirrored = scale.element_product() < 0.0;
        let mut triangles = Vec::new();
        for mut face in hull.faces() {
            let (Some(first), Some(mut last)) = (face.next(), face.next()) else { continue };
            for next in face {
                triangles.push(if mirrored { [first, next, last] } else { [first, last, next] });
                last = next;
            }
        }
        (vertices, triangles)
    }

    /// The scaled hull as parry's own polyhedron, for debugging and comparisons, in O(n); `None`
    /// for a flat hull, and for one that parry's constructor rejects.
    pub fn to_convex_polyhedron(&self) -> Option<ConvexPolyhedron> {
        if self.hull().rank() < 3 {
            return None;
        }
        let (vertices, triangles) = self.to_trimesh();
        ConvexPolyhedron::from_convex_mesh(vertices, &triangles)
    }
}
