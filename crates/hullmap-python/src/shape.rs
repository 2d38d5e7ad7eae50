//! Shapes: hulls, packs as compounds, triangle meshes, height fields, primitives and half-spaces.

use hullmap::glam::DVec3;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, HalfSpace, Segment, Sphere, Triangle};
use hullmap::{self as core, SharedGeometry};
use pyo3::prelude::*;

use crate::error::ShapeError;

/// A shape, for queries.
#[pyclass(frozen, module = "hullmap._hullmap")]
pub struct Shape(pub SharedGeometry);

fn convex(shape: Result<impl core::Shape + Send + Sync + 'static, core::ShapeError>) -> PyResult<Shape> {
    let shape = shape.map_err(|error| ShapeError::new_err(error.to_string()))?;
    Ok(Shape(SharedGeometry::from_shape(shape)))
}

#[pymethods]
impl Shape {
    #[staticmethod]
    fn sphere(radius: f64) -> PyResult<Self> {
        convex(Sphere::new(radius))
    }

    #[staticmethod]
    fn cuboid(half_edges: [f64; 3]) -> PyResult<Self> {
        convex(Cuboid::new(DVec3::from_array(half_edges)))
    }

    #[staticmethod]
    fn capsule(half_length: f64, radius: f64) -> PyResult<Self> {
        convex(Capsule::new(half_length, radius))
    }

    #[staticmethod]
    fn cylinder(half_height: f64, radius: f64) -> PyResult<Self> {
        convex(Cylinder::new(half_height, radius))
    }

    #[staticmethod]
    fn cone(half_height: f64, radius: f64) -> PyResult<Self> {
        convex(Cone::new(half_height, radius))
    }

    #[staticmethod]
    fn segment(start: [f64; 3], end: [f64; 3]) -> PyResult<Self> {
        convex(Segment::new(DVec3::from_array(start), DVec3::from_array(end)))
    }

    #[staticmethod]
    fn triangle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> PyResult<Self> {
        convex(Triangle::new([a, b, c].map(DVec3::from_array)))
    }

    #[staticmethod]
    fn half_space(normal: [f64; 3], offset: f64) -> PyResult<Self> {
        let made = HalfSpace::new(DVec3::from_array(normal), offset);
        Ok(Self(made.map_err(|error| ShapeError::new_err(error.to_string()))?.into()))
    }
}
