//! parry's convex primitives as hullmap's shapes, which hullmap solves against a baked hull.

// One of the two precisions makes each cast a no-op.
#![allow(clippy::unnecessary_cast)]

use hullmap::glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Rounded, Segment, Sphere, Triangle};
use hullmap::{Feature, Shape, SupportMap, SupportPoint};

use super::super::convert::wide;
use super::super::parry;

/// A primitive that hullmap solves against a hull. Its frame is the frame of parry's shape.
pub(super) enum Primitive {
    Ball(Sphere),
    Capsule(Capsule),
    Cone(Turned<Cone>),
    Cuboid(Cuboid),
    Cylinder(Turned<Cylinder>),
    RoundCone(Rounded<Turned<Cone>>),
    RoundCuboid(Rounded<Cuboid>),
    RoundCylinder(Rounded<Turned<Cylinder>>),
    RoundTriangle(Rounded<Triangle>),
    Segment(Segment),
    Triangle(Triangle),
}

impl Primitive {
    /// `shape` as hullmap's shape. `None` if it is of another kind, or its sizes are not valid.
    pub(super) fn from_shape(shape: &dyn parry::shape::Shape) -> Option<Self> {
        use parry::shape::TypedShape;
        Some(match shape.as_typed_shape() {
            TypedShape::Ball(ball) => Self::Ball(Sphere::new(ball.radius as f64).ok()?),
            TypedShape::Capsule(found) => {
                let [a, b] = [found.segment.a, found.segment.b].map(wide);
                Self::Capsule(Capsule::between(a, b, found.radius as f64).ok()?)
            }
            TypedShape::Cone(found) => Self::Cone(cone(found)?),
            TypedShape::Cuboid(found) => Self::Cuboid(cuboid(found)?),
            TypedShape::Cylinder(found) => Self::Cylinder(cylinder(found)?),
            TypedShape::RoundCone(found) => {
                Self::RoundCone(Rounded::new(cone(&found.inner_shape)?, found.border_radius as f64).ok()?)
            }
            TypedShape::RoundCuboid(found) => {
                Self::RoundCuboid(Rounded::new(cuboid(&found.inner_shape)?, found.border_radius as f64).ok()?)
            }
            TypedShape::RoundCylinder(found) => {
                Self::RoundCylinder(Rounded::new(cylinder(&found.inner_shape)?, found.border_radius as f64).ok()?)
            }
            TypedShape::RoundTriangle(found) => {
                Self::RoundTriangle(Rounded::new(triangle(&found.inner_shape)?, found.border_radius as f64).ok()?)
            }
            TypedShape::Segment(found) => Self::Segment(Segment::new(wide(found.a), wide(found.b)).ok()?),
            TypedShape::Triangle(found) => Self::Triangle(triangle(found)?),
            _ => return None,
        })
    }

    pub(super) fn shape(&self) -> &dyn Shape {
        match self {
            Self::Ball(shape) => shape,
            Self::Capsule(shape) => shape,
            Self::Cone(shape) => shape,
            Self::Cuboid(shape) => shape,
            Self::Cylinder(shape) => shape,
            Self::RoundCone(shape) => shape,
            Self::RoundCuboid(shape) => shape,
            Self::RoundCylinder(shape) => shape,
            Self::RoundTriangle(shape) => shape,
            Self::Segment(shape) => shape,
            Self::Triangle(shape) => shape,
        }
    }
}

fn cuboid(cuboid: &parry::shape::Cuboid) -> Option<Cuboid> {
    Cuboid::new(wide(cuboid.half_extents)).ok()
}

fn triangle(triangle: &parry::shape::Triangle) -> Option<Triangle> {
    Triangle::new([triangle.a, triangle.b, triangle.c].map(wide)).ok()
}

fn cylinder(cylinder: &parry::shape::Cylinder) -> Option<Turned<Cylinder>> {
    Some(Turned(Cylinder::new(cylinder.half_height as f64, cylinder.radius as f64).ok()?))
}

fn cone(cone: &parry::shape::Cone) -> Option<Turned<Cone>> {
    Some(Turned(Cone::new(cone.half_height as f64, cone.radius as f64).ok()?))
}

/// A shape along z, rotated to be along y as parry's shapes are. The coordinates are permuted
/// cyclically, which is an exact rotation.
pub(super) struct Turned<S>(S);

/// From the frame of the turned shape to the frame of the inner shape.
fn inward(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.x, v.y)
}

/// From the frame of the inner shape to the frame of the turned shape.
fn outward(v: DVec3) -> DVec3 {
    DVec3::new(v.y, v.z, v.x)
}

impl<S: SupportMap> SupportMap for Turned<S> {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let SupportPoint { point, feature } = self.0.support_point(inward(dir));
        SupportPoint { point: outward(point), feature }
    }

    fn interior_point(&self) -> DVec3 {
        outward(self.0.interior_point())
    }

    fn inner_radius(&self) -> f64 {
        self.0.inner_radius()
    }

    fn outer_radius(&self) -> f64 {
        self.0.outer_radius()
    }
}

impl<S: Shape> Shape for Turned<S> {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.0.feature(inward(dir), out);
        for corner in out.corners_mut() {
            corner.point = outward(corner.point);
        }
    }
}
