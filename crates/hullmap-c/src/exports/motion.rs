//! Shapes that move and turn, and derivatives.
#![allow(unsafe_code)]

use hullmap::RigidMotion;

use super::query::with_memory;
use crate::border::{self, Out, call};
use crate::failure::{Failure, Fallible};
use crate::handles::{Cache, Shape};
use crate::motion;
use crate::types::{
    CastSettings, ClearSettings, Clearance, Contact, Derivatives, Distance, Motion, MotionKind, MotionSettings, Pose,
    RayHit, Result, Settings, TimeOfImpact, Vec3, WitnessDerivatives,
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
            checked(RigidMotion::screw(start, motion.linear.into(), motion.angular.into(), motion.center.into()))
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
        let (found, slopes) =
            with_memory(cache, |memory| motion::cast_motion(shapes, [&motions[0], &motions[1]], &settings, memory))?;
        out.write(found);
        if let Some(by) = by {
            by.write(slopes);
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
        let motions = [&motions[0], &motions[1]];
        out.write(with_memory(cache, |memory| motion::clear(shapes, motions, &settings, memory))?);
        Ok(())
    })
}

/// # Safety
/// The pointers are as the rules at the head of the header require.
unsafe fn posed<'p>(
    a: *const Shape,
    b: *const Shape,
    b_in_a: *const Pose,
) -> Fallible<([&'p Shape; 2], hullmap::Pose)> {
    // SAFETY: this function's contract.
    let (a, b, b_in_a) = unsafe { (border::handle("a", a)?, border::handle("b", b)?, border::read("b_in_a", b_in_a)?) };
    Ok(([a, b], super::pose("b_in_a", b_in_a)?))
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
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let ((shapes, pose), settings, cache, out, by) = unsafe {
            let (posed, settings) = (posed(a, b, b_in_a)?, border::read_sized("settings", settings)?);
            let (out, by) = (Out::new("out", out)?, Out::new("derivatives", derivatives)?);
            (posed, settings, border::optional_handle("cache", cache)?, out, by)
        };
        let settings = super::settings(settings);
        // SAFETY: the caller keeps the rules at the head of the header.
        let witness = unsafe { optional_out("witness", witness)? };
        let (found, slopes, of_points) = with_memory(cache, |memory| {
            motion::distance_derivatives(shapes, pose, &settings, memory, witness.is_some())
        })?;
        out.write(found);
        by.write(slopes);
        if let (Some(witness), Some(of_points)) = (witness, of_points) {
            witness.write(of_points);
        }
        Ok(())
    })
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
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let ((shapes, pose), settings, cache, out, by) = unsafe {
            let (posed, settings) = (posed(a, b, b_in_a)?, border::read_sized("settings", settings)?);
            let (out, by) = (Out::new("out", out)?, Out::new("derivatives", derivatives)?);
            (posed, settings, border::optional_handle("cache", cache)?, out, by)
        };
        let settings = super::settings(settings);
        // SAFETY: the caller keeps the rules at the head of the header.
        let witness = unsafe { optional_out("witness", witness)? };
        let (found, slopes, of_points) = with_memory(cache, |memory| {
            motion::contact_derivatives(shapes, pose, &settings, memory, witness.is_some())
        })?;
        out.write(found);
        by.write(slopes);
        if let (Some(witness), Some(of_points)) = (witness, of_points) {
            witness.write(of_points);
        }
        Ok(())
    })
}

/// Where a ray first enters a convex shape, and the derivatives of t, in the shape's frame.
/// settings may be NULL.
///
/// by_a is with respect to the pose of the shape, and by_b to the pose of the ray: of a frame with
/// its origin at the ray's, which turns with the direction.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_ray_derivatives(
    shape: *const Shape,
    origin: Vec3,
    direction: Vec3,
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
        let (found, slopes) = motion::ray_derivatives(shape, &ray, &super::cast_settings(settings))?;
        out.write(found);
        by.write(slopes);
        Ok(())
    })
}
