//! Queries of two shapes that move and turn, and derivatives.

#![forbid(unsafe_code)]

use hullmap::{Cache, CastSettings, ClearSettings, MotionSettings, Pose, Ray, RigidMotion, Settings};

use crate::failure::Fallible;
use crate::handles::Shape;
use crate::query::{check_pair, convex_for};
use crate::types::{self, Derivatives, WitnessDerivatives};

/// When two moving shapes first meet, and the derivatives of that time.
pub(crate) fn cast_motion(
    [a, b]: [&Shape; 2],
    motions: [&RigidMotion; 2],
    settings: &MotionSettings,
    cache: &mut Cache,
) -> Fallible<(types::TimeOfImpact, Derivatives)> {
    check_pair(a, b)?;
    let found = hullmap::cast_motion(&a.0, motions[0], &b.0, motions[1], settings, cache);
    let with_b = |a: &dyn hullmap::Shape| {
        b.0.with_part(found.parts[1], |b| found.derivatives(a, motions[0], b, motions[1]).into())
    };
    let by = a.0.with_part(found.parts[0], with_b).flatten().unwrap_or(UNKNOWN);
    Ok((found.into(), by))
}

/// Derivatives of a pair with a half-space, which has no support mapping.
const UNKNOWN: Derivatives =
    Derivatives { differentiability: types::Differentiability::Inaccurate, by_a: [0.0; 6], by_b: [0.0; 6] };

/// Whether two moving shapes stay clear of each other.
pub(crate) fn clear(
    [a, b]: [&Shape; 2],
    motions: [&RigidMotion; 2],
    settings: &ClearSettings,
    cache: &mut Cache,
) -> Fallible<types::Clearance> {
    check_pair(a, b)?;
    Ok(hullmap::clear(&a.0, motions[0], &b.0, motions[1], settings, cache).into())
}

/// Distance of two convex shapes, and its derivatives; if `is_witness`, also the derivatives of its
/// normal and points.
pub(crate) fn distance_derivatives(
    [a, b]: [&Shape; 2],
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
    is_witness: bool,
) -> Fallible<(types::Distance, Derivatives, Option<WitnessDerivatives>)> {
    let (a, b) = (convex_for(a, "derivatives")?, convex_for(b, "derivatives")?);
    let found = hullmap::distance(a, b, b_in_a, settings, cache);
    let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a).into());
    Ok((found.into(), found.derivatives(a, b, b_in_a).into(), witness))
}

/// Contact of two convex shapes, and the derivatives of its depth; if `is_witness`, also the
/// derivatives of its normal and points.
pub(crate) fn contact_derivatives(
    [a, b]: [&Shape; 2],
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
    is_witness: bool,
) -> Fallible<(types::Contact, Derivatives, Option<WitnessDerivatives>)> {
    let (a, b) = (convex_for(a, "derivatives")?, convex_for(b, "derivatives")?);
    let found = hullmap::contact(a, b, b_in_a, settings, cache);
    let by = found.derivatives(a, b, b_in_a, settings, cache);
    let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a, settings, cache).into());
    Ok((found.into(), by.into(), witness))
}

/// Where a ray first enters a convex shape, and the derivatives of t.
pub(crate) fn ray_derivatives(
    shape: &Shape,
    ray: &Ray,
    settings: &CastSettings,
) -> Fallible<(types::RayHit, Derivatives)> {
    let shape = convex_for(shape, "derivatives")?;
    let found = hullmap::ray(shape, ray, settings);
    Ok((found.into(), found.derivatives(shape, ray).into()))
}
