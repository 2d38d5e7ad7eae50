//! The queries for shapes behind references, so that the solver is compiled once for all of them.
//!
//! Each pair of types compiles the whole solver again, twice: for the shapes and for their cores.
//! `hullmap_testkit::compiled` has compiled it for this type, and for hulls, which are also queried
//! by their own type, in `lean`, `stack` and `compound`, and in batches.

use glam::DVec3;
use hullmap::{
    Cache, CastSettings, Contact, Distance, Impact, Intersection, Manifold, ManifoldSettings, Motion, MotionSettings,
    Pose, Ray, RayHit, RigidMotion, Settings, Shape, SignedDistance, TimeOfImpact, VectorError,
};

/// Any shape.
pub type Any<'s> = dyn Shape + Sync + 's;

pub fn contact(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Contact {
    hullmap::contact(a, b, b_in_a, settings, cache)
}

pub fn distance(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Distance {
    hullmap::distance(a, b, b_in_a, settings, cache)
}

pub fn intersects(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, cache: &mut Cache) -> Intersection {
    hullmap::intersects(a, b, b_in_a, cache)
}

pub fn cast(
    a: &Any<'_>,
    b: &Any<'_>,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Impact {
    hullmap::cast(a, b, b_in_a, motion, settings, cache)
}

pub fn cast_motion(
    a: &Any<'_>,
    motion_a: &RigidMotion,
    b: &Any<'_>,
    motion_b: &RigidMotion,
    settings: &MotionSettings,
    cache: &mut Cache,
) -> TimeOfImpact {
    hullmap::cast_motion(a, motion_a, b, motion_b, settings, cache)
}

pub fn signed_distance(
    shape: &Any<'_>,
    point: DVec3,
    settings: &Settings,
    cache: &mut Cache,
) -> Result<SignedDistance, VectorError> {
    hullmap::signed_distance(shape, point, settings, cache)
}

pub fn ray(shape: &Any<'_>, ray: &Ray, settings: &CastSettings) -> RayHit {
    hullmap::ray(shape, ray, settings)
}

pub fn update(
    manifold: &mut Manifold,
    a: &Any<'_>,
    b: &Any<'_>,
    b_in_a: Pose,
    settings: &ManifoldSettings,
    cache: &mut Cache,
) -> Contact {
    manifold.update(a, b, b_in_a, settings, cache)
}
