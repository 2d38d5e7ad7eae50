//! Batch queries: many pairs in one call, on all threads.
//!
//! With the feature `parallel`, rayon distributes the pairs over the threads of the current pool.
//! Without it, the calling thread solves them in order. Every pair has a cache of its own, so the
//! answers are bit-identical to those of single queries, for any number of threads. They are
//! written to a slice of the caller, in the order of the pairs, without allocation per pair.
//!
//! # Reference
//! Kenwright, section 4.6 (threading) and 4.7 (data per pair).

#![forbid(unsafe_code)]

use crate::manifold::{Manifold, ManifoldSettings};
use crate::pose::Pose;
use crate::shapes::Shape;
use crate::solver::{Cache, Contact, Distance, Intersection, Settings, queries};

/// Minimum number of pairs per task: about 20 µs of work, ten times the cost of handing a task to
/// another thread.
#[cfg(feature = "parallel")]
const MIN_PAIRS: usize = 32;

/// Two shapes and their relative pose. For a batch of shapes of several types, use `dyn Shape +
/// Sync`.
///
/// # Examples
/// ```
/// use hullmap::batch::Pair;
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{Cuboid, Sphere};
/// use hullmap::{Pose, Shape, SupportMap};
///
/// let (ball, cube) = (Sphere::new(1.0)?, Cuboid::new(DVec3::ONE)?);
/// type AnyPair<'s> = Pair<'s, dyn Shape + Sync, dyn Shape + Sync>;
/// let pair: AnyPair = Pair { a: &ball, b: &cube, b_in_a: Pose::IDENTITY };
/// assert_eq!(pair.b.inner_radius(), 1.0);
/// # Ok::<(), hullmap::ShapeError>(())
/// ```
#[derive(Debug)]
pub struct Pair<'s, A: ?Sized, B: ?Sized> {
    /// The first shape.
    pub a: &'s A,
    /// The second shape.
    pub b: &'s B,
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
}

impl<A: ?Sized, B: ?Sized> Clone for Pair<'_, A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A: ?Sized, B: ?Sized> Copy for Pair<'_, A, B> {}

/// The slices of a batch differ in length.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::shapes::Sphere;
/// use hullmap::{Pose, Settings};
///
/// let ball = Sphere::new(1.0)?;
/// let pairs = [Pair { a: &ball, b: &ball, b_in_a: Pose::IDENTITY }];
/// let error = batch::contact(&pairs, &Settings::default(), &mut [], &mut []).unwrap_err();
/// assert_eq!((error.pairs, error.caches, error.answers), (1, 0, 0));
/// assert!(error.to_string().ends_with("found 0 and 0: pass slices of equal length"));
/// # Ok::<(), hullmap::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a batch of {pairs} pairs requires {pairs} caches and {pairs} answers, found {caches} and {answers}: \
     pass slices of equal length"
)]
pub struct BatchError {
    /// Number of pairs.
    pub pairs: usize,
    /// Number of caches.
    pub caches: usize,
    /// Number of answers, or of manifolds.
    pub answers: usize,
}

/// Writes the [`contact`](crate::contact()) of each `pairs[i]` to `out[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{Cuboid, Sphere};
/// use hullmap::{Cache, Contact, Pose, Settings, Shape};
///
/// let (ball, cube) = (Sphere::new(1.0)?, Cuboid::new(DVec3::ONE)?);
/// let shapes: [&(dyn Shape + Sync); 2] = [&ball, &cube];
/// let pairs: Vec<Pair<dyn Shape + Sync, dyn Shape + Sync>> = (0..100)
///     .map(|i| {
///         let x = 0.04 * f64::from(i);
///         let b_in_a = Pose::from_translation(DVec3::new(x, 0.0, 0.0)).expect("finite");
///         Pair { a: shapes[i as usize % 2], b: &ball as &(dyn Shape + Sync), b_in_a }
///     })
///     .collect();
/// let mut caches = vec![Cache::new(); pairs.len()];
/// let mut contacts = vec![Contact::default(); pairs.len()];
/// batch::contact(&pairs, &Settings::default(), &mut caches, &mut contacts)?;
/// assert!((contacts[20].depth - 1.2).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &Settings,
    caches: &mut [Cache],
    out: &mut [Contact],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    each(pairs, caches, out, |pair, cache, out| {
        *out = queries::contact(pair.a, pair.b, pair.b_in_a, settings, cache);
    })
}

/// Writes the [`distance`](crate::distance()) of each `pairs[i]` to `out[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Cache, Distance, Pose, Settings};
///
/// let ball = Sphere::new(1.0)?;
/// let at = |x| Pose::from_translation(DVec3::new(x, 0.0, 0.0));
/// let pairs = [at(1.5)?, at(3.0)?].map(|b_in_a| Pair { a: &ball, b: &ball, b_in_a });
/// let mut caches = vec![Cache::new(); pairs.len()];
/// let mut gaps = vec![Distance::default(); pairs.len()];
/// batch::distance(&pairs, &Settings::default(), &mut caches, &mut gaps)?;
/// assert!(gaps[0].distance == 0.0 && (gaps[1].distance - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn distance<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &Settings,
    caches: &mut [Cache],
    out: &mut [Distance],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    each(pairs, caches, out, |pair, cache, out| {
        *out = queries::distance(pair.a, pair.b, pair.b_in_a, settings, cache);
    })
}

/// Writes whether the shapes of each `pairs[i]` [`intersect`](crate::intersects()) to `out[i]`,
/// using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single queries, divided among the threads. No allocation per pair.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Cache, Intersection, Pose};
///
/// let ball = Sphere::new(1.0)?;
/// let at = |x| Pose::from_translation(DVec3::new(x, 0.0, 0.0));
/// let pairs = [at(1.5)?, at(3.0)?].map(|b_in_a| Pair { a: &ball, b: &ball, b_in_a });
/// let mut caches = vec![Cache::new(); pairs.len()];
/// let mut found = vec![Intersection::default(); pairs.len()];
/// batch::intersects(&pairs, &mut caches, &mut found)?;
/// assert!(found[0].is_hit() && !found[1].is_hit());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn intersects<A, B>(
    pairs: &[Pair<'_, A, B>],
    caches: &mut [Cache],
    out: &mut [Intersection],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    each(pairs, caches, out, |pair, cache, out| *out = queries::intersects(pair.a, pair.b, pair.b_in_a, cache))
}

/// Calls [`Manifold::update`] on each `manifolds[i]` for `pairs[i]`, using `caches[i]`.
///
/// # Errors
/// [`BatchError`] if the slices differ in length. Nothing is written in that case.
///
/// # Complexity
/// The sum over the single updates, divided among the threads. No allocation per pair.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Cache, Manifold, ManifoldSettings, Pose};
///
/// let ball = Sphere::new(1.0)?;
/// let at = |x| Pose::from_translation(DVec3::new(x, 0.0, 0.0));
/// let pairs = [at(1.5)?, at(3.0)?].map(|b_in_a| Pair { a: &ball, b: &ball, b_in_a });
/// let mut caches = vec![Cache::new(); pairs.len()];
/// let mut manifolds = vec![Manifold::new(); pairs.len()];
/// batch::manifolds(&pairs, &ManifoldSettings::default(), &mut caches, &mut manifolds)?;
/// assert_eq!(manifolds[0].points().len(), 1);
/// assert!(manifolds[1].points().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn manifolds<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &ManifoldSettings,
    caches: &mut [Cache],
    manifolds: &mut [Manifold],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    each(pairs, caches, manifolds, |pair, cache, manifold| {
        manifold.update(pair.a, pair.b, pair.b_in_a, settings, cache);
    })
}

/// Calls `solve` with each pair, its cache and its answer.
fn each<A, B, T, F>(pairs: &[Pair<'_, A, B>], caches: &mut [Cache], out: &mut [T], solve: F) -> Result<(), BatchError>
where
    A: Sync + ?Sized,
    B: Sync + ?Sized,
    T: Send,
    F: Fn(&Pair<'_, A, B>, &mut Cache, &mut T) + Sync,
{
    if pairs.len() != caches.len() || pairs.len() != out.len() {
        return Err(BatchError { pairs: pairs.len(), caches: caches.len(), answers: out.len() });
    }
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let slots = caches.par_iter_mut().zip(out.par_iter_mut());
        let jobs = pairs.par_iter().zip(slots).with_min_len(MIN_PAIRS);
        jobs.for_each(|(pair, (cache, out))| solve(pair, cache, out));
    }
    #[cfg(not(feature = "parallel"))]
    for (pair, (cache, out)) in pairs.iter().zip(caches.iter_mut().zip(out)) {
        solve(pair, cache, out);
    }
    Ok(())
}
