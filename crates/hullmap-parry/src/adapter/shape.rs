//! parry's `Shape` for a baked hull.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use super::BakedHull;
use super::convert::narrow;
use super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::{FeatureId, PolygonalFeatureMap, Shape, ShapeType, SubShapeId, SupportMap, TypedShape};

impl Shape for BakedHull {
    fn compute_local_aabb(&self) -> Aabb {
        self.local_box()
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        self.ball()
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    /// `None` for an invalid scale; see [`BakedHull::scaled`].
    fn scale_dyn(&self, scale: Vector, _subdivisions: u32) -> Option<Box<dyn Shape>> {
        Some(Box::new(self.scaled(scale).ok()?))
    }

    /// The tight box with a margin for rounding, by six support queries.
    fn compute_aabb(&self, position: &Pose) -> Aabb {
        self.box_under(position)
    }

    fn mass_properties(&self, density: Real) -> MassProperties {
        self.baked_mass(density as f64)
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        self.thickness()
    }

    /// In radians, as for parry's convex polyhedron.
    fn ccd_angular_thickness(&self) -> Real {
        std::f64::consts::FRAC_PI_4 as Real
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(self)
    }

    fn as_polygonal_feature_map(&self) -> Option<(&dyn PolygonalFeatureMap, Real)> {
        Some((self, 0.0))
    }

    /// The normal of a face. For a vertex, the normal of one of its faces; `None` for an edge.
    fn feature_normal_at_point(&self, _subshape: SubShapeId, feature: FeatureId, _point: Vector) -> Option<Vector> {
        match feature {
            FeatureId::Face(face) => self.face_normal(face).map(narrow),
            FeatureId::Vertex(vertex) => {
                let face = self.hull().faces_at(vertex).next()?;
                self.face_normal(face).map(narrow)
            }
            FeatureId::Edge(_) | FeatureId::Unknown => None,
        }
    }
}
