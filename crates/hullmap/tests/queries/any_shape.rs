//! The queries for shapes behind references, so that the solver is compiled once for all of them.
//!
//! Each pair of types compiles the whole solver again, twice: for the shapes and for their cores.
//! `hullmap_testkit::compiled` has compiled it for this type, and for hulls, which are also queried
//! by their own type, in `lean`, `stack` and `compound`, and in batches.

use hullmap::{
    Cache, CastSettings, Contact, Distance, Impact, Intersection, Manifold, ManifoldSettings, Motion, Pose, Ray,
    RayHit, Settings, Shape,
};

pub fn contact(
    a: &(dyn Shape + Sync),
    b: &(dyn Shape + Sync),
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Contact {
    hullmap::contact(a, b, b_in_a, settings, cache)
}

pub fn distance(
    a: &(dyn Shape + Sync),
    b: &(dyn Shape + Sync),
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
) -> Distance {
    hullmap::distance(a, b, b_in_a, settings, cache)
}

pub fn intersects(a: &(dyn Shape + Sync), b: &(dyn Shape + Sync), b_in_a: Pose, cache: &mut Cache) -> Intersection {
    hullmap::intersects(a, b, b_in_a, cache)
}

pub fn cast(
    a: &(dyn Shape + Sync),
    b: &(dyn Shape + Sync),
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    cache: &mut Cache,
) -> Impact {
    hullmap::cast(a, b, b_in_a, motion, settings, cache)
}

pub fn ray(shape: &(dyn Shape + Sync), ray: &Ray, settings: &CastSettings) -> RayHit {
    hullmap::ray(shape, ray, settings)
}

pub fn update(
    manifold: &mut Manifold,
    a: &(dyn Shape + Sync),
    b: &(dyn Shape + Sync),
    b_in_a: Pose,
    settings: &ManifoldSettings,
    cache: &mut Cache,
) -> Contact {
    manifold.update(a, b, b_in_a, settings, cache)
}
