//! Shapes that move and turn, and derivatives.
#![allow(unsafe_code)]

use hullmap::RigidMotion;

use super::query::with_memory;
use crate::border::{self, Out, call};
use crate::failure::{Failure, Fallible};
use crate::handles::{Cache, Shape};
use crate::query::{check_pair, convex_for};
use crate::types::{
    CastSettings, ClearSettings, Clearance, Contact, DVec3, Derivatives, Differentiability, Distance, Motion,
    MotionKind, MotionSettings, Pose, RayHit, Result, Settings, TimeOfImpact, WitnessDerivatives,
};

/// A motion from C, checked.
fn motion_of(name: &str, motion: Motion) -> Fallible<RigidMotion> {
    let start = super::pose(name, motion.start)?;
    let checked = |found: std::result::Result<RigidMotion, hullmap::VectorError>| {
        found.map_err(|error| Failure::argument(name, error))
    };
    match motion.kind {
        kind if kind == MotionKind::Still as u32 => Ok(RigidMotion::still(start)),
        kind if kind == MotionKind::Between as u32 => {
            checked(RigidMotion::between(start, super::pose(name, motion.end)?))
        }
        kind if kind == MotionKind::Screw as u32 => {
            checked(RigidMotion::screw(start, motion.linear, motion.angular, motion.center))
        }
        kind => Err(Failure::argument(name, format_args!("kind {kind} is not a HullmapMotionKind"))),
    }
}

/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn moving<'p>(
    shapes: [*const Shape; 2],
    motions: [*const Motion; 2],
) -> Fallible<([&'p Shape; 2], [RigidMotion; 2])> {
    // SAFETY: this function's contract.
    let (a, b, motion_a, motion_b) = unsafe {
        let (a, b) = (border::handle("a", shapes[0])?, border::handle("b", shapes[1])?);
        (a, b, border::read("motion_a", motions[0])?, border::read("motion_b", motions[1])?)
    };
    Ok(([a, b], [motion_of("motion_a", motion_a)?, motion_of("motion_b", motion_b)?]))
}

/// Where an answer goes, or nothing for NULL.
///
/// # Safety
/// The pointer is as the rules at the head of the header require, or NULL.
unsafe fn optional_out<T>(name: &'static str, out: *mut T) -> Fallible<Option<Out<T>>> {
    // SAFETY: this function's contract.
    if out.is_null() { Ok(None) } else { Ok(Some(unsafe { Out::new(name, out)? })) }
}

/// When A and B, which move and turn, first come within a distance of each other. Motions are in a
/// common frame, as is the answer.
///
/// derivatives may be NULL. If not, it receives the derivatives of the time, by twists that
/// displace the whole motion of a shape, and turn it about the place of its origin at the impact.
/// settings and cache may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_cast_motion(
    a: *const Shape,
    motion_a: *const Motion,
    b: *const Shape,
    motion_b: *const Motion,
    settings: *const MotionSettings,
    cache: *mut Cache,
    out: *mut TimeOfImpact,
    derivatives: *mut Derivatives,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let ((shapes, motions), settings, cache, out) = unsafe {
            let (moving, settings) = (moving([a, b], [motion_a, motion_b])?, border::read_sized("settings", settings)?);
            (moving, settings, border::optional_handle("cache", cache)?, Out::new("out", out)?)
        };
        let settings = settings.map_or_else(hullmap::MotionSettings::default, |own| hullmap::MotionSettings {
            target_distance: own.target_distance,
            tolerance: own.tolerance,
            max_iterations: own.max_iterations,
        });
        // SAFETY: the caller keeps the rules at the head of the header.
        let by = unsafe { optional_out("derivatives", derivatives)? };
        let ([a, b], [motion_a, motion_b]) = (shapes, &motions);
        check_pair(a, b)?;
        let query = |memory: &mut _| Ok(hullmap::cast_motion(&a.0, motion_a, &b.0, motion_b, &settings, memory));
        let found = with_memory(cache, query)?;
        out.write(found);
        if let Some(by) = by {
            let with_b =
                |a: &dyn hullmap::Shape| b.0.with_part(found.parts[1], |b| found.derivatives(a, motion_a, b, motion_b));
            // A half-space has no support mapping.
            let unknown = || Derivatives { status: Differentiability::Inaccurate, ..Derivatives::default() };
            by.write(a.0.with_part(found.parts[0], with_b).flatten().unwrap_or_else(unknown));
        }
        Ok(())
    })
}

/// Whether A and B, which move and turn, stay farther apart than a margin, and which clearance is
/// proven. Motions are in a common frame. settings and cache may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_clear(
    a: *const Shape,
    motion_a: *const Motion,
    b: *const Shape,
    motion_b: *const Motion,
    settings: *const ClearSettings,
    cache: *mut Cache,
    out: *mut Clearance,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let ((shapes, motions), settings, cache, out) = unsafe {
            let (moving, settings) = (moving([a, b], [motion_a, motion_b])?, border::read_sized("settings", settings)?);
            (moving, settings, border::optional_handle("cache", cache)?, Out::new("out", out)?)
        };
        let settings = settings.map_or_else(hullmap::ClearSettings::default, |own| hullmap::ClearSettings {
            motion: hullmap::MotionSettings {
                target_distance: own.margin,
                tolerance: own.tolerance,
                max_iterations: own.max_iterations,
            },
            share: own.share,
        });
        let ([a, b], [motion_a, motion_b]) = (shapes, &motions);
        check_pair(a, b)?;
        let query = |memory: &mut _| Ok(hullmap::clear(&a.0, motion_a, &b.0, motion_b, &settings, memory));
        out.write(with_memory(cache, query)?);
        Ok(())
    })
}

/// Destinations of an answer, its derivatives, and the derivatives of its normal and points.
type Outs<T> = (*mut T, *mut Derivatives, *mut WitnessDerivatives);

/// Answers a query of two convex shapes with derivatives. The last argument of `query` is whether
/// derivatives of normal and points are requested.
///
/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn with_derivatives<T>(
    (a, b, b_in_a): (*const Shape, *const Shape, *const Pose),
    (settings, cache, (out, derivatives, witness)): (*const Settings, *mut Cache, Outs<T>),
    query: impl FnOnce(
        [&dyn hullmap::Shape; 2],
        hullmap::Pose,
        &hullmap::Settings,
        &mut hullmap::Cache,
        bool,
    ) -> (T, Derivatives, Option<WitnessDerivatives>),
) -> Result {
    call(|| {
        // SAFETY: this function's contract.
        let (pair, settings, cache, out, by, witness) = unsafe {
            let (pair, settings) = (super::query::pair(a, b, b_in_a)?, border::read_sized("settings", settings)?);
            let (out, by) = (Out::new("out", out)?, Out::new("derivatives", derivatives)?);
            let cache = border::optional_handle("cache", cache)?;
            (pair, super::settings(settings), cache, out, by, optional_out("witness", witness)?)
        };
        let shapes = [convex_for(pair.a, "derivatives")?, convex_for(pair.b, "derivatives")?];
        let is_witness = witness.is_some();
        let query = |memory: &mut _| Ok(query(shapes, pair.b_in_a, &settings, memory, is_witness));
        let (found, slopes, of_points) = with_memory(cache, query)?;
        out.write(found);
        by.write(slopes);
        if let (Some(witness), Some(of_points)) = (witness, of_points) {
            witness.write(of_points);
        }
        Ok(())
    })
}

/// Distance of two convex shapes, and its derivatives by the poses of both, in A's frame. settings
/// and cache may be NULL.
///
/// witness may be NULL. If not, it gets the derivatives of the normal and the points.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_distance_derivatives(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    settings: *const Settings,
    cache: *mut Cache,
    out: *mut Distance,
    derivatives: *mut Derivatives,
    witness: *mut WitnessDerivatives,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        let outs = (settings, cache, (out, derivatives, witness));
        with_derivatives((a, b, b_in_a), outs, |[a, b], b_in_a, settings, cache, is_witness| {
            let found = hullmap::distance(a, b, b_in_a, settings, cache);
            let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a));
            (found, found.derivatives(a, b, b_in_a), witness)
        })
    }
}

/// Contact of two convex shapes, and the derivatives of its depth by the poses of both, in A's
/// frame. settings and cache may be NULL.
///
/// witness may be NULL. If not, it gets the derivatives of the normal and the points.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_contact_derivatives(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
    settings: *const Settings,
    cache: *mut Cache,
    out: *mut Contact,
    derivatives: *mut Derivatives,
    witness: *mut WitnessDerivatives,
) -> Result {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe {
        let outs = (settings, cache, (out, derivatives, witness));
        with_derivatives((a, b, b_in_a), outs, |[a, b], b_in_a, settings, cache, is_witness| {
            let found = hullmap::contact(a, b, b_in_a, settings, cache);
            let by = found.derivatives(a, b, b_in_a, settings, cache);
            let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a, settings, cache));
            (found, by, witness)
        })
    }
}

/// Where a ray first enters a convex shape, and the derivatives of t, in the shape's frame.
/// settings may be NULL.
///
/// by_a is with respect to the pose of the shape, and by_b to the pose of the ray: of a frame with
/// its origin at the ray's, which turns with the direction.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_ray_derivatives(
    shape: *const Shape,
    origin: DVec3,
    direction: DVec3,
    settings: *const CastSettings,
    out: *mut RayHit,
    derivatives: *mut Derivatives,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (shape, settings, out, by) = unsafe {
            let (shape, settings) = (border::handle("shape", shape)?, border::read_sized("settings", settings)?);
            (shape, settings, Out::new("out", out)?, Out::new("derivatives", derivatives)?)
        };
        let ray = super::query::ray_of(origin, direction)?;
        let shape = convex_for(shape, "derivatives")?;
        let found = hullmap::ray(shape, &ray, &super::cast_settings(settings));
        out.write(found);
        by.write(found.derivatives(shape, &ray));
        Ok(())
    })
}
