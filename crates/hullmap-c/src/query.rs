//! Queries of shapes, by the functions of `hullmap`.

#![forbid(unsafe_code)]

use std::mem::MaybeUninit;

use hullmap::compound::SharedSheet;
use hullmap::glam::DVec3;
use hullmap::{Cache, ManifoldSettings, Pose, Settings, SharedGeometry};

use crate::failure::{Failure, Fallible};
use crate::handles::{Points, Shape};
use crate::types;

/// A pair whose pointers and pose have been checked, and that has queries.
pub(crate) struct CheckedPair<'p> {
    pub(crate) a: &'p Shape,
    pub(crate) b: &'p Shape,
    pub(crate) b_in_a: Pose,
}

/// Checks that two shapes have queries at all.
#[inline(always)]
pub(crate) fn check_pair(a: &Shape, b: &Shape) -> Fallible<()> {
    a.0.check_pair(&b.0).map_err(Failure::unsupported)
}

/// Updates the points of a manifold.
pub(crate) fn update(pair: &CheckedPair<'_>, settings: &ManifoldSettings, points: &mut Points) {
    points.update(|manifolds| manifolds.update(&pair.a.0, &pair.b.0, pair.b_in_a, settings));
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
    shape.0.bounds_under(pose).ok_or_else(|| Failure::unsupported("the compound has no hulls"))
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
    found.map_err(|error| Failure::new(types::Result::InvalidArgument, error))
}

/// Support points in many directions.
pub(crate) fn support(
    shape: &Shape,
    directions: &[types::DVec3],
    out: &mut [MaybeUninit<types::SupportPoint>],
) -> Fallible<()> {
    fn each<S>(shape: &S, directions: &[types::DVec3], out: &mut [MaybeUninit<types::SupportPoint>])
    where
        S: hullmap::SupportMap + ?Sized,
    {
        for (direction, out) in directions.iter().zip(out) {
            out.write(shape.support_point(*direction));
        }
    }
    match &shape.0 {
        SharedGeometry::Hull(hull) => each(hull.hull(), directions, out),
        _ => each(convex_for(shape, "support point")?, directions, out),
    }
    Ok(())
}
