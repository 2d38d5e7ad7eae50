//! Converts a baked hull to meshes for debug renderers, which draw nothing for custom shapes.

use super::BakedHull;
use super::convert::narrow;
use super::parry::math::Vector;
use super::parry::shape::ConvexPolyhedron;

impl BakedHull {
    /// Vertices and triangles of the surface, for debugging, in the local frame with the scale.
    /// Faces are split into fans. Seen from outside, triangles are counter-clockwise, also on a
    /// mirrored hull.
    ///
    /// # Complexity
    /// O(n), with allocations.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let pack = std::sync::Arc::new(pack());
    /// use hullmap_parry::BakedHull;
    ///
    /// let cube = BakedHull::new(pack.shared_hull_named("cube")?);
    /// let (vertices, triangles) = cube.to_trimesh();
    /// assert_eq!((vertices.len(), triangles.len()), (8, 12));
    /// # Ok(())
    /// # }
    /// ```
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

    /// The scaled hull as parry's own polyhedron, for debugging and comparisons; `None` for a flat
    /// hull, and for one that parry's constructor rejects.
    ///
    /// # Complexity
    /// O(n), with allocations.
    ///
    /// # Examples
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../hullmap/doc/rock.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let pack = std::sync::Arc::new(pack());
    /// use hullmap_parry::BakedHull;
    ///
    /// let cube = BakedHull::new(pack.shared_hull_named("cube")?);
    /// let polyhedron = cube.to_convex_polyhedron().ok_or("flat")?;
    /// assert_eq!(polyhedron.points().len(), 8);
    /// # Ok(())
    /// # }
    /// ```
    pub fn to_convex_polyhedron(&self) -> Option<ConvexPolyhedron> {
        if self.hull().rank() < 3 {
            return None;
        }
        let (vertices, triangles) = self.to_trimesh();
        ConvexPolyhedron::from_convex_mesh(vertices, &triangles)
    }
}
