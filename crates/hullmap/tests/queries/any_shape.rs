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

macro_rules! queries {
    ($($name:ident($($argument:ident: $kind:ty),+) -> $answer:ty;)+) => {
        $(pub fn $name($($argument: $kind),+) -> $answer {
            hullmap::$name($($argument),+)
        })+
    };
}

queries! {
    contact(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Contact;
    distance(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Distance;
    intersects(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, cache: &mut Cache) -> Intersection;
    cast(a: &Any<'_>, b: &Any<'_>, b_in_a: Pose, by: Motion, settings: &CastSettings, cache: &mut Cache) -> Impact;
    cast_motion(
        a: &Any<'_>, by_a: &RigidMotion, b: &Any<'_>, by_b: &RigidMotion, settings: &MotionSettings, cache: &mut Cache
    ) -> TimeOfImpact;
    signed_distance(
        a: &Any<'_>, point: DVec3, settings: &Settings, cache: &mut Cache
    ) -> Result<SignedDistance, VectorError>;
    ray(a: &Any<'_>, ray: &Ray, settings: &CastSettings) -> RayHit;
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
