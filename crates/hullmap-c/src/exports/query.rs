//! Queries of one shape, or of a pair.
#![allow(unsafe_code)]

use hullmap::Motion;

use crate::border::{self, Out, call};
use crate::failure::{Failure, Fallible};
use crate::handles::{Cache, Shape};
use crate::query::{self, CheckedPair};
use crate::types::{
    Bounds, CastSettings, Contact, DVec3, Distance, Impact, Intersection, Pose, RayHit, Result, Settings,
    SignedDistance, SupportPoint,
};

/// Runs a query with the memory of a cache, or with an empty one.
#[inline(always)]
pub(super) fn with_memory<T>(
    cache: Option<&Cache>,
    query: impl FnOnce(&mut hullmap::Cache) -> Fallible<T>,
) -> Fallible<T> {
    let (mut guard, mut empty);
    let memory = match cache {
        Some(cache) => {
            guard = cache.0.take("cache")?;
            &mut *guard
        }
        None => {
            empty = hullmap::Cache::new();
            &mut empty
        }
    };
    query(memory)
}

/// A pair that has queries.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
#[inline(always)]
pub(super) unsafe fn pair<'p>(a: *const Shape, b: *const Shape, b_in_a: *const Pose) -> Fallible<CheckedPair<'p>> {
    // SAFETY: this function's contract.
    let (a, b, b_in_a) = unsafe { (border::handle("a", a)?, border::handle("b", b)?, border::read("b_in_a", b_in_a)?) };
    query::check_pair(a, b)?;
    Ok(CheckedPair { a, b, b_in_a: super::pose("b_in_a", b_in_a)? })
}

/// Answers a query of a pair.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
#[inline(always)]
unsafe fn of_pair<S: Copy, T>(
    (a, b, b_in_a): (*const Shape, *const Shape, *const Pose),
    (settings, cache, out): (*const S, *mut Cache, *mut T),
    query: impl FnOnce(CheckedPair<'_>, Option<S>, &mut hullmap::Cache) -> Fallible<T>,
) -> Result {
    call(|| {
        // SAFETY: this function's contract.
        let (pair, settings, cache, out) = unsafe {
            let (pair, settings) = (pair(a, b, b_in_a)?, border::read_sized("settings", settings)?);
            (pair, settings, border::optional_handle("cache", cache)?, Out::new("out", out)?)
        };
        out.write(with_memory(cache, |memory| query(pair, settings, memory))?);
        Ok(())
    })
}

/// Support points of a shape in `count` directions: points of the shape with the maximum dot
/// product.
///
/// Directions are in the shape's frame and need not be of unit length. For a zero or non-finite
/// direction the answer is any point of the shape. Not for compounds and half-spaces.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_support(
    shape: *const Shape,
    directions: *const DVec3,
    count: usize,
    out: *mut SupportPoint,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (shape, directions, out) = unsafe {
            let (shape, directions) =
                (border::handle("shape", shape)?, border::array("directions", directions, count)?);
            (shape, directions, border::answers("out", out, count)?)
        };
        query::support(shape, directions, out)
    })
}

/// The box around a shape at a pose, in the frame that the pose maps to. It certainly contains the
/// shape. Not for half-spaces.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_bounds(shape: *const Shape, pose: *const Pose, out: *mut Bounds) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (shape, pose, out) =
            unsafe { (border::handle("shape", shape)?, border::read("pose", pose)?, Out::new("out", out)?) };
        out.write(query::bounds(shape, super::pose("pose", pose)?)?);
        Ok(())
    })
}

/// Whether two shapes share a point. cache may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_intersects(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    cache: *mut Cache,
    out: *mut Intersection,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pair((a, b, b_in_a), (std::ptr::null::<Settings>(), cache, out), |pair, _, memory| {
            Ok(hullmap::intersects(&pair.a.0, &pair.b.0, pair.b_in_a, memory))
        })
    }
}

/// Distance of two shapes, and their closest points. settings and cache may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_distance(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    settings: *const Settings,
    cache: *mut Cache,
    out: *mut Distance,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pair((a, b, b_in_a), (settings, cache, out), |pair, settings, memory| {
            Ok(hullmap::distance(&pair.a.0, &pair.b.0, pair.b_in_a, &super::settings(settings), memory))
        })
    }
}

/// Contact of two shapes: penetration depth, normal and deepest points. settings and cache may be
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_contact(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    settings: *const Settings,
    cache: *mut Cache,
    out: *mut Contact,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pair((a, b, b_in_a), (settings, cache, out), |pair, settings, memory| {
            Ok(hullmap::contact(&pair.a.0, &pair.b.0, pair.b_in_a, &super::settings(settings), memory))
        })
    }
}

/// When B, which starts at b_in_a and moves by `velocity` per unit of time, first meets A. Neither
/// shape turns. The velocity is in A's frame. settings and cache may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_cast(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    velocity: DVec3,
    settings: *const CastSettings,
    cache: *mut Cache,
    out: *mut Impact,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        of_pair((a, b, b_in_a), (settings, cache, out), |pair, settings, memory| {
            let motion = Motion::new(velocity).map_err(|error| Failure::new(Result::InvalidArgument, error))?;
            Ok(hullmap::cast(&pair.a.0, &pair.b.0, pair.b_in_a, motion, &super::cast_settings(settings), memory))
        })
    }
}

/// Where the ray of all points origin + t direction, t >= 0, first enters a shape. Origin and
/// direction are in the shape's frame; t is a factor of the direction, which need not be of unit
/// length. settings may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_ray(
    shape: *const Shape,
    origin: DVec3,
    direction: DVec3,
    settings: *const CastSettings,
    out: *mut RayHit,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (shape, settings, out) = unsafe {
            let (shape, settings) = (border::handle("shape", shape)?, border::read_sized("settings", settings)?);
            (shape, settings, Out::new("out", out)?)
        };
        let ray = ray_of(origin, direction)?;
        out.write(hullmap::ray(&shape.0, &ray, &super::cast_settings(settings)));
        Ok(())
    })
}

/// A ray from C, checked.
pub(super) fn ray_of(origin: DVec3, direction: DVec3) -> Fallible<hullmap::Ray> {
    let ray = hullmap::Ray::new(origin, direction);
    ray.map_err(|error| Failure::new(Result::InvalidArgument, error))
}

/// Signed distance of a point from the surface of a shape, in the shape's frame: positive outside,
/// negative inside. The cache is for this shape and points near each other. settings and cache may
/// be NULL.
///
/// For a compound, it is the minimum over its hulls: outside, the distance from the union; inside,
/// the depth in the hull in which the point is deepest. The union contains the ball of this radius
/// around the point, but its surface may be farther away where hulls overlap or touch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_signed_distance(
    shape: *const Shape,
    point: DVec3,
    settings: *const Settings,
    cache: *mut Cache,
    out: *mut SignedDistance,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (shape, settings, cache, out) = unsafe {
            let (shape, settings) = (border::handle("shape", shape)?, border::read_sized("settings", settings)?);
            (shape, settings, border::optional_handle("cache", cache)?, Out::new("out", out)?)
        };
        let settings = super::settings(settings);
        out.write(with_memory(cache, |memory| query::signed_distance(shape, point, &settings, memory))?);
        Ok(())
    })
}
