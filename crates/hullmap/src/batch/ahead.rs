//! Fetches the shapes of the next queries ahead, while plain queries run.
//!
//! A contact takes 20 to 40 support queries, which read much of a hull of a hundred vertices. So
//! the next pairs are fetched as a whole, one part per support query of the current pair, and the
//! memory arrives while EPA computes. The query itself is an ordinary query, on a wrapper of the
//! first shape ([`Fetching`]).
//!
//! Small hulls are fetched as a whole before their pair. Their queries need no wrapper.

use std::cell::Cell;

use glam::DVec3;

use super::pair::{Pair, SupportQuery, has_facets};
use super::query::BatchQuery;
use crate::facets::view::Facets;
use crate::manifold::{Manifold, ManifoldSettings};
use crate::shapes::{Feature, Shape};
use crate::solver::{Cache, Contact, Ray, Settings, queries};
use crate::support::simd::{fetch, fetch_start};
use crate::support::{SupportMap, SupportPoint};

/// Number of pairs from the one that is fetched to the one that is solved.
const DISTANCE: usize = 4;

/// Number of pairs that are fetched as a whole before their turn. A pair that is separated leaves
/// little time for the next.
const LEAD: usize = 4;

/// Prefetches what the query `distance` pairs ahead reads first, and the shapes of the pair twice
/// as far ahead.
#[inline(always)]
pub(super) fn fetch_pairs<A, B>(pairs: &[Pair<'_, A, B>], at: usize, distance: usize)
where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
{
    if let Some(far) = pairs.get(at + 2 * distance) {
        fetch_start(far.a);
        fetch_start(far.b);
    }
    if let Some(near) = pairs.get(at + distance) {
        near.a.fetch_ahead();
        near.b.fetch_ahead();
    }
}

/// As [`fetch_pairs`], for support queries.
#[inline(always)]
pub(super) fn fetch_queries<S: Shape + ?Sized>(queries: &[SupportQuery<'_, S>], at: usize, distance: usize) {
    if let Some(far) = queries.get(at + 2 * distance) {
        fetch_start(far.shape);
    }
    if let Some(near) = queries.get(at + distance) {
        near.shape.fetch_ahead();
    }
}

/// Calls `solve` with the index of each pair, the pair, its cache and its answer, and `fetch_cache`
/// some pairs ahead. The slices have equal lengths.
fn each<A, B, T>(
    pairs: &[Pair<'_, A, B>],
    caches: &mut [Cache],
    out: &mut [T],
    fetch_cache: impl Fn(&Cache),
    mut solve: impl FnMut(usize, &Pair<'_, A, B>, &mut Cache, &mut T),
) where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
{
    for (at, (pair, out)) in pairs.iter().zip(out).enumerate() {
        fetch_pairs(pairs, at, DISTANCE);
        caches.get(at + DISTANCE).into_iter().for_each(&fetch_cache);
        let Some(cache) = caches.get_mut(at) else { break };
        solve(at, pair, cache, out);
    }
}

/// The support points of all queries. The slices have equal lengths.
pub(super) fn support_points<S: Shape + ?Sized>(queries: &[SupportQuery<'_, S>], out: &mut [SupportPoint]) {
    for (at, (query, out)) in queries.iter().zip(out).enumerate() {
        fetch_queries(queries, at, 2 * DISTANCE);
        *out = query.shape.support_point(query.dir);
    }
}

/// Answers all pairs by plain queries. The slices have equal lengths.
pub(super) fn answer_all<A, B, Q>(
    pairs: &[Pair<'_, A, B>],
    settings: &Q::Settings,
    caches: &mut [Cache],
    out: &mut [Q::Answer],
) where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
    Q: BatchQuery,
{
    each(pairs, caches, out, fetch_start, |_, pair, cache, out| *out = Q::answer(pair, settings, cache));
}

/// [`crate::contact()`] of all pairs. The slices have equal lengths.
pub(super) fn contact<A, B>(pairs: &[Pair<'_, A, B>], settings: &Settings, caches: &mut [Cache], out: &mut [Contact])
where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
{
    let ahead = Ahead { pairs, at: Cell::new(0), part: Cell::new(0), last: Cell::new(0) };
    each(pairs, caches, out, fetch, |at, pair, cache, out| {
        // The separating axis test reads each shape once, and has few support queries.
        *out = if has_facets(pair) {
            queries::contact(pair.a, pair.b, pair.b_in_a, settings, cache)
        } else {
            queries::contact(&ahead.fetching(at, pair.a), pair.b, pair.b_in_a, settings, cache)
        };
    });
}

/// [`Manifold::update`] of all pairs. The slices have equal lengths.
pub(super) fn manifolds<A, B>(
    pairs: &[Pair<'_, A, B>],
    settings: &ManifoldSettings,
    caches: &mut [Cache],
    manifolds: &mut [Manifold],
) where
    A: Shape + ?Sized,
    B: Shape + ?Sized,
{
    let ahead = Ahead { pairs, at: Cell::new(0), part: Cell::new(0), last: Cell::new(0) };
    each(pairs, caches, manifolds, fetch, |at, pair, cache, manifold| {
        if has_facets(pair) {
            manifold.update(pair.a, pair.b, pair.b_in_a, settings, cache);
        } else {
            manifold.update(&ahead.fetching(at, pair.a), pair.b, pair.b_in_a, settings, cache);
        }
    });
}

struct Ahead<'p, 's, A: ?Sized, B: ?Sized> {
    pairs: &'p [Pair<'s, A, B>],
    at: Cell<usize>,
    /// The part of its shapes.
    part: Cell<usize>,
    /// The last pair that may be fetched now.
    last: Cell<usize>,
}

impl<'p, 's, A: Shape + ?Sized, B: Shape + ?Sized> Ahead<'p, 's, A, B> {
    /// The first shape of the pair `at`, which is solved next and therefore not fetched.
    fn fetching<'f>(&'f self, at: usize, shape: &'f A) -> Fetching<'f, 'p, 's, A, A, B> {
        if self.at.get() <= at {
            self.at.set(at + 1);
            self.part.set(0);
        }
        self.last.set(at + LEAD);
        Fetching { shape, ahead: self }
    }

    #[inline]
    fn fetch(&self) {
        let (at, part) = (self.at.get(), self.part.get());
        if at > self.last.get() {
            return;
        }
        let Some(pair) = self.pairs.get(at) else { return };
        if pair.a.fetch_part(part) | pair.b.fetch_part(part) {
            self.part.set(part + 1);
        } else {
            self.at.set(at + 1);
            self.part.set(0);
        }
    }
}

/// A shape whose support queries each fetch a part of the next pairs.
struct Fetching<'f, 'p, 's, S: ?Sized, A: ?Sized, B: ?Sized> {
    shape: &'f S,
    ahead: &'f Ahead<'p, 's, A, B>,
}

impl<S: Shape + ?Sized, A: Shape + ?Sized, B: Shape + ?Sized> SupportMap for Fetching<'_, '_, '_, S, A, B> {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        self.ahead.fetch();
        self.shape.support_point(dir)
    }
    #[inline(always)]
    fn interior_point(&self) -> DVec3 {
        self.shape.interior_point()
    }
    #[inline(always)]
    fn inner_radius(&self) -> f64 {
        self.shape.inner_radius()
    }
    #[inline(always)]
    fn outer_radius(&self) -> f64 {
        self.shape.outer_radius()
    }
    #[inline(always)]
    fn support_error(&self) -> f64 {
        self.shape.support_error()
    }
    #[inline(always)]
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.shape.point(feature)
    }
    #[inline(always)]
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        self.shape.support_point_from(dir, hint)
    }
    #[inline(always)]
    fn convex_radius(&self) -> f64 {
        self.shape.convex_radius()
    }
    #[inline(always)]
    fn core_support_point(&self, dir: DVec3) -> SupportPoint {
        self.ahead.fetch();
        self.shape.core_support_point(dir)
    }
    #[inline(always)]
    fn core_radii(&self) -> [f64; 2] {
        self.shape.core_radii()
    }
    #[inline(always)]
    fn core_point(&self, feature: u32) -> Option<DVec3> {
        self.shape.core_point(feature)
    }
    #[inline(always)]
    fn facets(&self) -> Option<Facets<'_>> {
        self.shape.facets()
    }
}

impl<S: Shape + ?Sized, A: Shape + ?Sized, B: Shape + ?Sized> Shape for Fetching<'_, '_, '_, S, A, B> {
    fn feature(&self, dir: DVec3, out: &mut Feature) {
        self.shape.feature(dir, out);
    }
    fn feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.shape.feature_within(dir, reach, out);
    }
    fn reduced_feature_within(&self, dir: DVec3, reach: f64, out: &mut Feature) {
        self.shape.reduced_feature_within(dir, reach, out);
    }
    fn entry(&self, ray: &Ray, near: u32, until: f64) -> Option<f64> {
        self.shape.entry(ray, near, until)
    }
}
