//! Queries of shapes, by the functions of `hullmap`.

#![forbid(unsafe_code)]

use std::mem::MaybeUninit;

use hullmap::compound::SharedSheet;
use hullmap::glam::DVec3;
use hullmap::{Cache, CastSettings, ManifoldSettings, Motion, Pose, Settings, SharedGeometry};

use crate::failure::{Failure, Fallible};
use crate::handles::{Points, Shape};
use crate::types;

/// Checks that two shapes have queries at all.
#[inline(always)]
pub(crate) fn check_pair(a: &Shape, b: &Shape) -> Fallible<()> {
    a.0.check_pair(&b.0).map_err(Failure::unsupported)
}

/// Whether two shapes share a point.
#[inline(always)]
pub(crate) fn intersects(a: &Shape, b: &Shape, b_in_a: Pose, cache: &mut Cache) -> Fallible<types::Intersection> {
    check_pair(a, b)?;
    Ok(hullmap::intersects(&a.0, &b.0, b_in_a, cache).into())
}

/// Distance of two shapes.
#[inline(always)]
pub(crate) fn distance(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Fallible<types::Distance> {
    check_pair(a, b)?;
    Ok(hullmap::distance(&a.0, &b.0, b_in_a, settings, cache).into())
}

/// Contact of two shapes.
#[inline(always)]
pub(crate) fn contact(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Fallible<types::Contact> {
    check_pair(a, b)?;
    Ok(hullmap::contact(&a.0, &b.0, b_in_a, settings, cache).into())
}

/// When the moving shape B first meets A.
pub(crate) fn cast(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Fallible<types::Impact> {
    check_pair(a, b)?;
    Ok(hullmap::cast(&a.0, &b.0, b_in_a, motion, settings, cache).into())
}

/// Updates the points of a manifold.
pub(crate) fn update(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &ManifoldSettings,
    points: &mut Points,
) -> Fallible<()> {
    check_pair(a, b)?;
    points.update(|manifolds| manifolds.update(&a.0, &b.0, b_in_a, settings));
    Ok(())
}

#[cold]
fn not_for_sheets(sheet: &SharedSheet, query: &str) -> Failure {
    let (name, of_triangles) = match sheet {
        SharedSheet::Mesh(_) => (sheet.name(), "hullmap_triangle_mesh_triangle"),
        SharedSheet::Field(_) => (sheet.name(), "hullmap_height_field_triangle"),
    };
    let remedy = "query the distance of a sphere of radius 0, or its triangles one by one";
    Failure::unsupported(format_args!("{name} has no {query}: {remedy} ({of_triangles})"))
}

#[cold]
fn not_for(kind: &str, query: &str) -> Failure {
    Failure::unsupported(format_args!("{kind} has no {query}: query its hulls one by one (hullmap_shape_hull)"))
}

#[cold]
fn unbounded(query: &str) -> Failure {
    Failure::unsupported(format_args!("a half-space is unbounded and has no {query}"))
}

/// The shape behind its support mapping.
pub(crate) fn convex_for<'s>(shape: &'s Shape, query: &str) -> Fallible<&'s dyn hullmap::Shape> {
    let convex = shape.0.as_shape().map(|shape| shape as &dyn hullmap::Shape);
    convex.ok_or_else(|| match &shape.0 {
        SharedGeometry::HalfSpace(_) => unbounded(query),
        SharedGeometry::Sheet(sheet) => not_for_sheets(sheet, query),
        kind => not_for(kind.name(), query),
    })
}

/// Box around a shape at a pose.
pub(crate) fn bounds(shape: &Shape, pose: Pose) -> Fallible<types::Bounds> {
    if let SharedGeometry::HalfSpace(_) = shape.0 {
        return Err(unbounded("bounds"));
    }
    // Only a pack that was opened without checks has no hulls.
    let found = shape.0.bounds_under(pose).ok_or_else(|| Failure::unsupported("the compound has no hulls"))?;
    Ok(types::Bounds { min: found.min.into(), max: found.max.into() })
}

/// Where a ray enters a shape.
pub(crate) fn ray(shape: &Shape, ray: &hullmap::Ray, settings: &CastSettings) -> types::RayHit {
    hullmap::ray(&shape.0, ray, settings).into()
}

/// Signed distance of a point.
pub(crate) fn signed_distance(
    shape: &Shape,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Fallible<types::SignedDistance> {
    if let SharedGeometry::Sheet(sheet) = &shape.0 {
        return Err(not_for_sheets(sheet, "signed distance"));
    }
    let found = hullmap::signed_distance(&shape.0, point, settings, cache);
    Ok(found.map_err(|error| Failure::new(types::Result::InvalidArgument, error))?.into())
}

/// Support points in many directions.
pub(crate) fn support(
    shape: &Shape,
    directions: &[types::Vec3],
    out: &mut [MaybeUninit<types::Support>],
) -> Fallible<()> {
    fn each<S>(shape: &S, directions: &[types::Vec3], out: &mut [MaybeUninit<types::Support>])
    where
        S: hullmap::SupportMap + ?Sized,
    {
        for (direction, out) in directions.iter().zip(out) {
            out.write(shape.support_point((*direction).into()).into());
        }
    }
    match &shape.0 {
        SharedGeometry::Hull(hull) => each(hull.hull(), directions, out),
        _ => each(convex_for(shape, "support point")?, directions, out),
    }
    Ok(())
}
