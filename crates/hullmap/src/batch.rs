//! Many pairs at once: the same answers as one by one, in the pairs' order, on as many threads as there are.
//!
//! With the feature `parallel` pairs are shared out by rayon, on the pool that the call is made in; without it they are
//! solved one after the other on the calling thread. Each pair is a calculation of its own with a cache of its own, so the
//! answers are the same to the bit whatever the number of threads. Answers go into a slice of the caller's: nothing is
//! allocated for a pair.
//!
//! # Reference
//! Kenwright, section 4.6 (threading) and 4.7 (the data are each pair's own).

#![forbid(unsafe_code)]

use crate::{Cache, Contact, Distance, Intersection, Manifold, ManifoldSettings, Pose, Settings, Shape};

/// Fewest pairs that are worth another thread: some 20 µs of work, ten times what handing it over costs.
#[cfg(feature = "parallel")]
const MIN_PAIRS: usize = 32;

/// Two shapes and how they lie. Shapes of different kinds go into one batch as `&(dyn Shape + Sync)`.
#[derive(Debug)]
pub struct Pair<'s, A: ?Sized, B: ?Sized> {
    /// The first shape.
    pub a: &'s A,
    /// The second shape.
    pub b: &'s B,
    /// The second's frame in the first's.
    pub b_in_a: Pose,
}

impl<A: ?Sized, B: ?Sized> Clone for Pair<'_, A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A: ?Sized, B: ?Sized> Copy for Pair<'_, A, B> {}

/// Slices of a batch that do not go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{pairs} pairs need as many caches and places for answers, found {caches} and {answers}")]
pub struct BatchError {
    /// Number of pairs.
    pub pairs: usize,
    /// Number of caches.
    pub caches: usize,
    /// Number of places for answers.
    pub answers: usize,
}

/// Contacts of all pairs, by [`crate::contact`]: `out[i]` is that of `pairs[i]`, found with `caches[i]`.
///
/// # Errors
/// Slices of different lengths; nothing is written then.
///
/// # Complexity
/// That of the single queries, over the number of threads. No allocation for a pair.
///
/// # Examples
/// ```
/// use hullmap::batch::{self, Pair};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::{Cuboid, Sphere};
/// use hullmap::{Cache, Pose, Settings, Shape, contact};
///
/// let (ball, cube) = (Sphere::new(1.0)?, Cuboid::new(DVec3::ONE)?);
/// let shapes: [&(dyn Shape + Sync); 2] = [&ball, &cube];
/// let pairs: Vec<Pair<dyn Shape + Sync, dyn Shape + Sync>> = (0..100)
///     .map(|i| {
///         let b_in_a = Pose::from_translation(DVec3::new(0.04 * f64::from(i), 0.0, 0.0)).expect("finite");
///         Pair { a: shapes[i as usize % 2], b: &ball as &(dyn Shape + Sync), b_in_a }
///     })
///     .collect();
/// let mut caches = vec![Cache::new(); pairs.len()];
/// let mut contacts = vec![contact(&ball, &ball, Pose::IDENTITY, &Settings::default(), &mut Cache::new()); pairs.len()];
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
        *out = crate::contact(pair.a, pair.b, pair.b_in_a, settings, cache);
    })
}

/// Distances of all pairs, by [`crate::distance`]: `out[i]` is that of `pairs[i]`, found with `caches[i]`.
///
/// # Errors
/// Slices of different lengths; nothing is written then.
///
/// # Complexity
/// That of the single queries, over the number of threads. No allocation for a pair.
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
        *out = crate::distance(pair.a, pair.b, pair.b_in_a, settings, cache);
    })
}

/// Yes or no for all pairs, by [`crate::intersects`]: `out[i]` is that of `pairs[i]`, found with `caches[i]`.
///
/// # Errors
/// Slices of different lengths; nothing is written then.
///
/// # Complexity
/// That of the single queries, over the number of threads. No allocation for a pair.
pub fn intersects<A, B>(
    pairs: &[Pair<'_, A, B>],
    caches: &mut [Cache],
    out: &mut [Intersection],
) -> Result<(), BatchError>
where
    A: Shape + Sync + ?Sized,
    B: Shape + Sync + ?Sized,
{
    each(pairs, caches, out, |pair, cache, out| *out = crate::intersects(pair.a, pair.b, pair.b_in_a, cache))
}

/// Manifolds of all pairs, brought up to date by [`Manifold::update`]: `manifolds[i]` belongs to `pairs[i]`, as `caches[i]` does.
///
/// # Errors
/// Slices of different lengths; nothing is written then.
///
/// # Complexity
/// That of the single updates, over the number of threads. No allocation for a pair.
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

/// Solves each pair with its cache into its place.
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
        let places = caches.par_iter_mut().zip(out.par_iter_mut());
        let shared = pairs.par_iter().zip(places).with_min_len(MIN_PAIRS);
        shared.for_each(|(pair, (cache, out))| solve(pair, cache, out));
    }
    #[cfg(not(feature = "parallel"))]
    for (pair, (cache, out)) in pairs.iter().zip(caches.iter_mut().zip(out)) {
        solve(pair, cache, out);
    }
    Ok(())
}
