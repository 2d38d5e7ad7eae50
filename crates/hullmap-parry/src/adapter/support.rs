//! Support mapping and polygonal features: what parry's solvers and manifolds are made of.
//!
//! # The feature towards a direction
//! 1. The merged feature of hullmap: all faces within 1.15° of the direction. f32 breaks the flat
//!    caps of real meshes into slivers, and a body would tip over on one sliver.
//! 2. If that is an edge or a vertex, the baked face that is closest to the direction. parry clips
//!    whole faces, and keeps the points that are near enough.
//!
//! The merged feature alone lost round bodies, and the face alone lost flat ones.

use hullmap::{Corner, Feature, Shape as _};

use super::BakedHull;
use super::convert::{narrow, wide};
use super::parry::math::Vector;
use super::parry::shape::{PolygonalFeature, PolygonalFeatureMap, SupportMap};
use super::polygon;

impl SupportMap for BakedHull {
    #[inline]
    fn local_support_point(&self, dir: Vector) -> Vector {
        narrow(hullmap::SupportMap::support_point(self, wide(dir)).point)
    }
}

impl PolygonalFeatureMap for BakedHull {
    fn local_support_feature(&self, dir: Vector, out: &mut PolygonalFeature) {
        let mut feature = Feature::new();
        self.polygon_towards(dir, &mut feature);
        polygon::write(&feature, out);
    }

    fn is_convex_polyhedron(&self) -> bool {
        true
    }
}

impl BakedHull {
    /// The merged feature towards `dir` if it is a face, otherwise the closest baked face.
    fn polygon_towards(&self, dir: Vector, out: &mut Feature) {
        let dir = wide(dir);
        self.feature(dir, out);
        if out.corners().len() >= 3 {
            return;
        }
        let Some(face) = self.face_towards(dir) else { return };
        let corners = self.hull().face(face);
        // A face may have more corners than a feature.
        let stride = corners.len().div_ceil(hullmap::shapes::MAX_CORNERS).max(1);
        out.clear();
        for vertex in corners.step_by(stride) {
            if let Some(point) = self.vertex(vertex) {
                out.push(Corner { point, vertex });
            }
        }
    }
}
