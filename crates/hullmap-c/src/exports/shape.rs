//! Shapes: what queries take as A and B.
#![allow(unsafe_code)]

use std::sync::Arc;

use hullmap::compound::SharedSheet;
use hullmap::shapes::{Capsule, Cone, Cuboid, Cylinder, Segment, Sphere, Triangle};

use crate::border::{self, Out, call};
use crate::failure::Fallible;
use crate::handles::{HeightField, Pack, Shape, TriangleMesh};
use crate::types::{DVec3, Result};

/// Makes a shape and hands it out.
///
/// # Safety
/// `shape` is as the rules at the head of the header require.
unsafe fn make(shape: *mut *mut Shape, body: impl FnOnce() -> Fallible<Shape>) -> Result {
    call(|| {
        // SAFETY: this function's contract is the contract of `of_handle`.
        let out = unsafe { Out::of_handle("shape", shape)? };
        out.give(body()?);
        Ok(())
    })
}

/// The hull of index `hull`, counted from 0, in its own frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_hull(pack: *const Pack, hull: usize, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::hull(border::handle("pack", pack)?, hull)) }
}

/// The hull of index `hull`, scaled along the axes of its frame; a negative scale mirrors it. The
/// magnitude of a scale is from 1e-38 to 3.4e38.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_scaled_hull(
    pack: *const Pack,
    hull: usize,
    scale: DVec3,
    shape: *mut *mut Shape,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::scaled_hull(border::handle("pack", pack)?, hull, scale)) }
}

/// All hulls of a pack together: a concave mesh that was baked as convex parts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_compound(pack: *const Pack, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Ok(Shape::compound(border::handle("pack", pack)?))) }
}

/// All triangles of a mesh together: a static level, which collides on both sides. Answers
/// have the index of the triangle in place of the index of a hull. It has no support points and no
/// signed distance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_triangle_mesh(mesh: *const TriangleMesh, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Ok(Shape::sheet(SharedSheet::Mesh(Arc::clone(&border::handle("mesh", mesh)?.0))))) }
}

/// All triangles of a height field together: a terrain, which collides on both sides. Answers have
/// the index of the triangle in place of the index of a hull. It has no support points and no
/// signed distance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_height_field(field: *const HeightField, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Ok(Shape::sheet(SharedSheet::Field(Arc::clone(&border::handle("field", field)?.0))))) }
}

/// A sphere about the origin. Lengths of this and the following shapes are from 0 to 3.4e38.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_sphere(radius: f64, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Sphere::new(radius))) }
}

/// A box about the origin, with its edges along the axes: half their lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_cuboid(half_edges: DVec3, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Cuboid::new(half_edges))) }
}

/// A capsule about the origin, along z: half the length of the segment, without the caps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_capsule(half_length: f64, radius: f64, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Capsule::new(half_length, radius))) }
}

/// A cylinder about the origin, along z.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_cylinder(half_height: f64, radius: f64, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Cylinder::new(half_height, radius))) }
}

/// A cone along z: its base at -half_height, its apex at half_height.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_cone(half_height: f64, radius: f64, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Cone::new(half_height, radius))) }
}

/// The segment between two points, whose coordinates are from -3.4e38 to 3.4e38.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_segment(start: DVec3, end: DVec3, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Segment::new(start, end))) }
}

/// The triangle between three points, from both sides: for single triangles; a level is a
/// triangle mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_triangle(a: DVec3, b: DVec3, c: DVec3, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::convex(Triangle::new([a, b, c]))) }
}

/// Everything below a plane: the points p with normal . p <= offset, after the normal is
/// normalised. For floors and walls. Two half-spaces have no query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_half_space(normal: DVec3, offset: f64, shape: *mut *mut Shape) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { make(shape, || Shape::half_space(normal, offset)) }
}

/// Frees a shape; NULL is allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_shape_free(shape: *mut Shape) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(shape) }
}
