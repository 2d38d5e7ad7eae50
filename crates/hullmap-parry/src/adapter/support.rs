//! Support mapping and features of a baked hull, which solvers and manifolds query.
//!
//! # The feature towards a direction
//! - Where the prediction is known (`HullDispatcher`), hullmap's feature within it: the face
//!   closest to the direction, merged with the faces that are nearly in its plane, if three of its
//!   corners are near enough. Otherwise, the closest face at any angle.
//! - parry's own narrow phase does not pass its prediction. It gets the closest face at any angle,
//!   merged with faces within 2.3° of it, and reduced to the four corners that support the body
//!   best. If the body's centre is not over them, vertices farther out are considered as well.
//!
//! Points that are too far apart are dropped after clipping, so a face at any angle does no harm.
//! Without it, a body that lands on a rim has contact points there only, tips beyond the other rim
//! within one step, and sinks while it rocks. Faces are merged because in f32 the flat caps of real
//! meshes break into slivers.
//!
//! # What did not work
//! - The larger of this face and the faces merged around the direction: 176 of 2,448 bodies awake
//!   instead of 197, within the spread of the runs, and 50 % more time while bodies of 8,192
//!   vertices fall.
//! - The closest face only if the merged feature has fewer than three corners: for a disc that
//!   stands on its rim, the feature is the rim, which has many corners. Among 102 bodies of 0.1 m,
//!   20 sank into the floor.
//! - All vertices within the prediction of the support plane: then the best four points do not
//!   touch, and most bodies rock for ever.

use hullmap::glam::DVec3;
use hullmap::{Feature, Shape as _};

use super::BakedHull;
use super::baked_hull::{Form, on_form};
use super::convert::{narrow, wide};
use super::parry::math::Vector;
use super::parry::shape::{PolygonalFeature, PolygonalFeatureMap, SupportMap};
use super::polygon::Outline;

impl SupportMap for BakedHull {
    #[inline]
    fn local_support_point(&self, dir: Vector) -> Vector {
        narrow(hullmap::SupportMap::support_point(self, wide(dir)).point)
    }
}

impl PolygonalFeatureMap for BakedHull {
    fn local_support_feature(&self, dir: Vector, out: &mut PolygonalFeature) {
        let dir = wide(dir);
        let mut face = Feature::new();
        on_form!(self, shape => shape.reduced_feature_within(dir, f64::INFINITY, &mut face));
        let outline = Outline::new(self, dir);
        let mut four = outline.four(&face);
        if !outline.is_stable(&face, &four) {
            if face.is_reduced() {
                on_form!(self, shape => shape.feature_within(dir, f64::INFINITY, &mut face));
            }
            outline.widen(&mut face);
            four = outline.four(&face);
        }
        outline.write(&face, &four, out);
    }

    fn is_convex_polyhedron(&self) -> bool {
        true
    }
}

impl hullmap::Shape for BakedHull {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.feature_within(dir, f64::INFINITY, out);
    }

    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        on_form!(self, shape => shape.feature_within(dir, reach, out));
        if out.corners().len() < 3 {
            on_form!(self, shape => shape.feature_within(dir, f64::INFINITY, out));
        }
    }

    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        on_form!(self, shape => shape.reduced_feature_within(dir, reach, out));
        if out.corners().len() < 3 {
            on_form!(self, shape => shape.reduced_feature_within(dir, f64::INFINITY, out));
        }
    }
}
