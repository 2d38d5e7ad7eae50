//! Support mapping and features: what solvers and manifolds are made of.
//!
//! # The feature towards a direction
//! Two candidates, of which the one with the larger area is taken:
//! 1. The merged feature of hullmap: all faces within 1.15° of the direction. f32 breaks the flat
//!    caps of real meshes into slivers, and a body would tip over on one sliver.
//! 2. The baked face that is closest to the direction, at any angle. Manifolds keep those of its
//!    points that are near enough. Without the far ones, a small body that lands on the rim of a
//!    face tips beyond the other rim within one step, and sinks into the floor while it rocks.
//!
//! # What did not work
//! - Face if the merged feature has fewer than three corners: a disc on its rim of many corners
//!   takes the rim. Of 102 bodies of 0.1 m, 20 sank into the floor.

use hullmap::glam::DVec3;
use hullmap::shapes::MAX_CORNERS;
use hullmap::{Corner, Feature, Shape as _};

use super::BakedHull;
use super::baked_hull::{Form, on_form};
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
        self.feature(wide(dir), &mut feature);
        polygon::write(&feature, out);
    }

    fn is_convex_polyhedron(&self) -> bool {
        true
    }
}

impl hullmap::Shape for BakedHull {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        on_form!(self, shape => shape.feature(dir, out));
        let mut face = Feature::new();
        self.face(dir, &mut face);
        if area(&face) > area(out) {
            *out = face;
        }
    }
}

impl BakedHull {
    /// The baked face that is closest to `dir`; of more than [`MAX_CORNERS`] corners, some.
    fn face(&self, dir: DVec3, out: &mut Feature) {
        let Some(face) = self.face_towards(dir) else { return };
        let corners = self.hull().face(face);
        let stride = corners.len().div_ceil(MAX_CORNERS).max(1);
        for vertex in corners.step_by(stride) {
            if let Some(point) = self.vertex(vertex) {
                out.push(Corner { point, vertex });
            }
        }
    }
}

/// Area of a polygon, by Newell's sum; 0 for an edge or a vertex.
fn area(feature: &Feature) -> f64 {
    let [first, rest @ ..] = feature.corners() else { return 0.0 };
    let mut sum = DVec3::ZERO;
    for pair in rest.windows(2) {
        if let [a, b] = pair {
            sum += (a.point - first.point).cross(b.point - first.point);
        }
    }
    0.5 * sum.length()
}
