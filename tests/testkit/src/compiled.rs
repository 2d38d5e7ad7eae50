//! The solver, compiled once for the types that most tests pass to it.
//!
//! With an `opt-level` of at most 1, rustc exports the generic functions that a library has
//! compiled, and crates that depend on the library use them. So the test binaries do not compile
//! the solver again for two `dyn Shape + Sync`, for two hulls, or for compounds with each other and
//! with a `dyn Shape + Sync`. Nothing calls these functions.

use hullmap::batch::{self, Pair};
use hullmap::shapes::HalfSpace;
use hullmap::{
    Cache, CastSettings, Compound, CompoundManifolds, Contact, Distance, Hull, Intersection, Manifold,
    ManifoldSettings, Motion, MotionSettings, Pose, Ray, RigidMotion, Settings, Shape,
};

/// Shapes on any thread. Without `Sync` it is another type, for which all is compiled again.
type Shared<'s> = dyn Shape + Sync + 's;

fn solve<A: Shape + ?Sized, B: Shape + ?Sized>(a: &A, b: &B, b_in_a: Pose, along: Motion, ray: &Ray) {
    let (settings, casts, mut cache) = (Settings::default(), CastSettings::default(), Cache::new());
    let cache = &mut cache;
    hullmap::contact(a, b, b_in_a, &settings, cache);
    hullmap::distance(a, b, b_in_a, &settings, cache);
    hullmap::intersects(a, b, b_in_a, cache);
    hullmap::cast(a, b, b_in_a, along, &casts, cache);
    let still = RigidMotion::still(b_in_a);
    hullmap::cast_motion(a, &still, b, &still, &MotionSettings::default(), cache);
    hullmap::ray(a, ray, &casts);
    let _ = hullmap::signed_distance(a, b_in_a.translation(), &settings, cache);
    Manifold::new().update(a, b, b_in_a, &ManifoldSettings::default(), cache);
}

fn solve_all<S: Shape + Sync + ?Sized>(pairs: &[Pair<'_, S, S>], caches: &mut [Cache]) {
    let _ = batch::contact(pairs, &Settings::default(), caches, &mut Vec::<Contact>::new());
    let _ = batch::distance(pairs, &Settings::default(), caches, &mut Vec::<Distance>::new());
    let _ = batch::intersects(pairs, caches, &mut Vec::<Intersection>::new());
    let _ = batch::manifolds(pairs, &ManifoldSettings::default(), caches, &mut Vec::<Manifold>::new());
}

/// Queries of two shapes that threads may share.
pub fn shapes(a: &Shared<'_>, b: &Shared<'_>, b_in_a: Pose, along: Motion, ray: &Ray) {
    solve(a, b, b_in_a, along, ray);
}

/// Queries of two hulls.
pub fn hulls(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose, along: Motion, ray: &Ray) {
    solve(a, b, b_in_a, along, ray);
}

/// Batches.
pub fn batches<'s>(
    shapes: &[Pair<'_, Shared<'s>, Shared<'s>>],
    hulls: &[Pair<'_, Hull<'s>, Hull<'s>>],
    caches: &mut [Cache],
) {
    solve_all(shapes, caches);
    solve_all(hulls, caches);
}

/// Queries of compounds with each other, with a shape, and with a half-space.
pub fn compounds(whole: &Compound<'_>, shape: &Shared<'_>, wall: &HalfSpace, pose: Pose, along: Motion, ray: &Ray) {
    let (settings, casts, manifold_settings) =
        (Settings::default(), CastSettings::default(), ManifoldSettings::default());
    let (mut cache, mut manifolds) = (Cache::with_pairs(8), CompoundManifolds::new(4));
    let cache = &mut cache;
    hullmap::intersects(whole, shape, pose, cache);
    hullmap::intersects(whole, whole, pose, cache);
    hullmap::distance(whole, shape, pose, &settings, cache);
    hullmap::distance(whole, whole, pose, &settings, cache);
    hullmap::contact(shape, whole, pose, &settings, cache);
    hullmap::contact(whole, shape, pose, &settings, cache);
    hullmap::contact(whole, whole, pose, &settings, cache);
    hullmap::cast(whole, shape, pose, along, &casts, cache);
    hullmap::cast(whole, whole, pose, along, &casts, cache);
    hullmap::ray(whole, ray, &casts);
    let _ = hullmap::signed_distance(whole, pose.translation(), &settings, cache);
    hullmap::contact(wall, whole, pose, &settings, cache);
    hullmap::cast(wall, whole, pose, along, &casts, cache);
    manifolds.update(whole, shape, pose, &manifold_settings);
    manifolds.update(whole, whole, pose, &manifold_settings);
    manifolds.update(wall, whole, pose, &manifold_settings);
}
