//! parry's `Shape` for a surface.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use super::super::convert::narrow;
use super::super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::super::parry::mass_properties::MassProperties;
use super::super::parry::math::{Real, Vector};
use super::super::parry::shape::{CompositeShape, FeatureId, Shape, ShapeType, SubShapeId, TypedShape};
use super::BakedSurface;

impl Shape for BakedSurface {
    fn compute_local_aabb(&self) -> Aabb {
        self.content.bounds
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        self.content.bounds.bounding_sphere()
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    /// `None` unless the scale is 1 along each axis: scale the source before the bake.
    fn scale_dyn(&self, scale: Vector, _subdivisions: u32) -> Option<Box<dyn Shape>> {
        (scale == Vector::ONE).then(|| self.clone_dyn())
    }

    /// Zero: a surface is static.
    fn mass_properties(&self, _density: Real) -> MassProperties {
        MassProperties::new(Vector::ZERO, 0.0, Vector::ZERO)
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        0.0
    }

    /// In radians, as for parry's triangle meshes.
    fn ccd_angular_thickness(&self) -> Real {
        std::f64::consts::FRAC_PI_4 as Real
    }

    fn as_composite_shape(&self) -> Option<&(dyn CompositeShape + Sync)> {
        Some(self)
    }

    /// Normal of a triangle, named by a face or else by the subshape: on the side of a point.
    fn feature_normal_at_point(&self, subshape: SubShapeId, feature: FeatureId, point: Vector) -> Option<Vector> {
        let index = match feature {
            FeatureId::Face(face) => face,
            _ => subshape,
        };
        let (tile, triangle) = self.locate(index)?;
        let normal = narrow(tile.normal(triangle)?);
        let corner = narrow(tile.place().transform_point(tile.triangle(triangle)?.corners()[0]));
        let is_behind = !tile.is_one_sided() && (point - corner).dot(normal) < 0.0;
        Some(if is_behind { -normal } else { normal })
    }
}
