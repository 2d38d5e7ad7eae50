//! Queries of two shapes of any kind that move and turn, and derivatives.

#![forbid(unsafe_code)]

use hullmap::compound::{self, CompoundAnswer, Parts, half_space};
use hullmap::shapes::HalfSpace;
use hullmap::{CastSettings, ClearSettings, MotionSettings, Pose, Ray, RigidMotion, Settings};

use crate::failure::Fallible;
use crate::handles::{Kind, Memory, Shape};
use crate::query::{ShapeQuery, convex_for, run};
use crate::types::{self, Derivatives, WitnessDerivatives};

struct CastMotion<'q>([&'q RigidMotion; 2], &'q MotionSettings, &'q mut Memory);

impl ShapeQuery for CastMotion<'_> {
    type Answer = (hullmap::TimeOfImpact, [usize; 2]);

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        Ok((hullmap::cast_motion(a, self.0[0], b, self.0[1], self.1, &mut self.2.convex), [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let found = compound::cast_motion(a, self.0[0], b, self.0[1], self.1, self.2.compound());
        Ok((found.answer, found.hulls))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok((a.cast_motion(self.0[0], b, self.0[1], self.1), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = half_space::cast_motion(a, self.0[0], b, self.0[1], self.1);
        Ok((answer, hulls))
    }
}

/// When two moving shapes first meet, and the derivatives of that time.
pub(crate) fn cast_motion(
    [a, b]: [&Shape; 2],
    motions: [&RigidMotion; 2],
    settings: &MotionSettings,
    memory: &mut Memory,
) -> Fallible<(types::TimeOfImpact, Derivatives)> {
    let (found, hulls) = run(a, b, CastMotion(motions, settings, memory))?;
    let by =
        with_part(a, hulls[0], |a| with_part(b, hulls[1], |b| Some(found.derivatives(a, motions[0], b, motions[1]))));
    let by = by.map_or(UNKNOWN, Derivatives::from);
    Ok((types::TimeOfImpact::new(found, hulls), by))
}

/// Derivatives of a pair with a half-space, which has no support mapping.
const UNKNOWN: Derivatives =
    Derivatives { differentiability: types::Differentiability::Inaccurate, by_a: [0.0; 6], by_b: [0.0; 6] };

/// The hull or triangle of this index, or the shape itself, for a function of support mappings.
fn with_part<T>(shape: &Shape, index: usize, run: impl FnOnce(&dyn hullmap::Shape) -> Option<T>) -> Option<T> {
    match &shape.kind {
        Kind::Compound(pack) => run(&pack.hull(index).ok()?),
        Kind::Sheet(sheet) => run(&sheet.triangle(index)?),
        Kind::HalfSpace(_) => None,
        kind => run(kind.convex()?),
    }
}

struct Clear<'q>([&'q RigidMotion; 2], &'q ClearSettings, &'q mut Memory);

impl ShapeQuery for Clear<'_> {
    type Answer = types::Clearance;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        let found = hullmap::clear(a, self.0[0], b, self.0[1], self.1, &mut self.2.convex);
        Ok(types::Clearance::new(found, [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let found = compound::clear(a, self.0[0], b, self.0[1], self.1, self.2.compound());
        Ok(types::Clearance::new(found.answer, found.hulls))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok(types::Clearance::new(a.clear(self.0[0], b, self.0[1], self.1), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let found = half_space::clear(a, self.0[0], b, self.0[1], self.1);
        Ok(types::Clearance::new(found.answer, found.hulls))
    }
}

/// Whether two moving shapes stay clear of each other.
pub(crate) fn clear(
    [a, b]: [&Shape; 2],
    motions: [&RigidMotion; 2],
    settings: &ClearSettings,
    memory: &mut Memory,
) -> Fallible<types::Clearance> {
    run(a, b, Clear(motions, settings, memory))
}

/// Distance of two convex shapes, and its derivatives; if `is_witness`, also the derivatives of its
/// normal and points.
pub(crate) fn distance_derivatives(
    [a, b]: [&Shape; 2],
    b_in_a: Pose,
    settings: &Settings,
    memory: &mut Memory,
    is_witness: bool,
) -> Fallible<(types::Distance, Derivatives, Option<WitnessDerivatives>)> {
    let (a, b) = (convex_for(a, "derivatives")?, convex_for(b, "derivatives")?);
    let found = hullmap::distance(a, b, b_in_a, settings, &mut memory.convex);
    let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a).into());
    Ok((types::Distance::new(found, [0, 0]), found.derivatives(a, b, b_in_a).into(), witness))
}

/// Contact of two convex shapes, and the derivatives of its depth; if `is_witness`, also the
/// derivatives of its normal and points.
pub(crate) fn contact_derivatives(
    [a, b]: [&Shape; 2],
    b_in_a: Pose,
    settings: &Settings,
    memory: &mut Memory,
    is_witness: bool,
) -> Fallible<(types::Contact, Derivatives, Option<WitnessDerivatives>)> {
    let (a, b) = (convex_for(a, "derivatives")?, convex_for(b, "derivatives")?);
    let cache = &mut memory.convex;
    let found = hullmap::contact(a, b, b_in_a, settings, cache);
    let by = found.derivatives(a, b, b_in_a, settings, cache);
    let witness = is_witness.then(|| found.witness_derivatives(a, b, b_in_a, settings, cache).into());
    Ok((types::Contact::new(found, [0, 0]), by.into(), witness))
}

/// Where a ray first enters a convex shape, and the derivatives of t.
pub(crate) fn ray_derivatives(
    shape: &Shape,
    ray: &Ray,
    settings: &CastSettings,
) -> Fallible<(types::RayHit, Derivatives)> {
    let shape = convex_for(shape, "derivatives")?;
    let found = hullmap::ray(shape, ray, settings);
    Ok((types::RayHit::new(found, 0), found.derivatives(shape, ray).into()))
}
