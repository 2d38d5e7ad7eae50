//! parry's `Shape` for a baked hull.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use hullmap::SupportMap as _;
use hullmap::glam::DVec3;

use super::BakedHull;
use super::convert::{narrow, real, wide};
use super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::{FeatureId, PolygonalFeatureMap, Shape, ShapeType, SubShapeId, SupportMap, TypedShape};

/// Relative margin of the box in a pose, for rounding in f32: a smaller box would lose contacts.
const MARGIN: f64 = 1e-6;

impl Shape for BakedHull {
    fn compute_local_aabb(&self) -> Aabb {
        let [a, b] = self.hull().bounds().map(|bound| bound.as_dvec3() * self.scale_factors());
        Aabb::new(narrow(a.min(b)), narrow(a.max(b)))
    }

    /// A ball around the interior point, O(1).
    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere::new(narrow(self.interior_point()), real(self.outer_radius() * (1.0 + MARGIN)))
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
        let (mut mins, mut maxs) = (DVec3::ZERO, DVec3::ZERO);
        for world in DVec3::AXES {
            let local = wide(position.rotation.inverse() * narrow(world));
            let reach = |dir: DVec3| hullmap::SupportMap::support_point(self, dir).point.dot(local);
            let (low, high) = (reach(-local), reach(local));
            let margin = MARGIN * (low.abs().max(high.abs()));
            let shift = wide(position.translation).dot(world);
            mins += world * (shift + low - margin);
            maxs += world * (shift + high + margin);
        }
        Aabb::new(narrow(mins), narrow(maxs))
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
        real(self.inner_radius())
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
