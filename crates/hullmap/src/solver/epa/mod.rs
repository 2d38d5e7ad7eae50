//! EPA, the expanding polytope algorithm: penetration depth from a polytope that grows inside the
//! Minkowski difference until its nearest face is a face of the difference.
//!
//! Computes the minimum support value h(n) over all unit normals n, which is the penetration depth,
//! as an interval; or a separating plane, if the origin turns out to be outside.
//!
//! # Reference
//! van den Bergen 2001 (expanding polytope), cited by Kenwright as [15]. It takes over from portal
//! refinement, whose depth depends on the origin ray.
//!
//! # Steps
//! 1. Start from the tetrahedron of v0 and the portal, from the last query's polytope under the new
//!    pose, or from a tetrahedron of [`seed`].
//! 2. Take the face nearest to the origin. Its plane's offset d bounds the depth from below.
//! 3. Query w = support(n) along its normal n. The support value h(n) = w · n bounds the depth from
//!    above.
//! 4. Stop if the bounds are close. Else insert w into the polytope and repeat from step 2.
//!
//! `search` has steps 2 to 4, `polytope` the surface, and `flat` the cases without volume.
//!
//! # Deviations
//! - "Nearest" is by signed offset, so the origin need not be inside at the start. While it is
//!   outside, the polytope grows towards it, until it is inside or a support plane proves it
//!   outside. No portal is too poor to start from.
//! - d is a bound only once the surface certainly winds around the origin. Until then nothing is
//!   claimed.
//! - The smallest h(n) of all faces tried is kept with its face, so the upper bound never grows.
//! - Close bounds do not end the search before the witness points are good. If the face of the
//!   smallest h(n) is not on the surface of the difference, or the origin's foot lies outside the
//!   face, the search continues until a face or a support point gives good ones.
//! - The ball around the interior points bounds the depth from below too, so round shapes end at
//!   once.
//! - Polytopes come in four sizes: most queries never touch the large arrays.

mod flat;
mod polytope;
mod search;
mod seed;

pub(in crate::solver) use self::polytope::Polytope;
pub(in crate::solver) use self::search::{End, Expansion, Goal};

use self::flat::{expand_flat, settle, widest_normal};
use self::search::{State, Terms, run};
use self::seed::{Flat, seed};
use crate::solver::bound::Bound;
use crate::solver::cache::{Cache, MAX_POINTS};
use crate::solver::minkowski::{Minkowski, Point};
use crate::support::SupportMap;

/// Maximum number of vertices of each polytope size. The first is enough for small hulls and
/// touching pairs, the second for nearly all queries, the third for sphere-like hulls; the last
/// caps the cost of a query.
const SIZES: [usize; 4] = [24, 64, 256, 1024];

/// A portal is not a start if the height of its tetrahedron is at most this many rounding errors:
/// its planes would be noise.
const THIN_ROUNDINGS: f64 = 64.0;

/// Support values up to this many rounding errors count as touching: one for the support point, one
/// for the normal.
pub(in crate::solver) const TOUCHING_ROUNDINGS: f64 = 2.0;

/// The same for flat differences, in rounding errors: their thickness is up to half of this, and
/// their normal is as uncertain.
pub(in crate::solver) const FLAT_ROUNDINGS: f64 = 16.0;

/// A foot outside the face by at most this fraction of its distance counts as inside; witness
/// points are off by as much.
const FOOT_OFF: f64 = 1e-3;

/// Number of vertices at which a polytope is kept for the next query, unless it ends with fewer.
/// Further vertices belong to small faces around the nearest one. These become dents when the pose
/// changes, and each dent costs a support call.
const KEEP: usize = MAX_POINTS;

/// Expansions from a kept polytope after which it is stale and dropped.
const WORN_OUT: u32 = 8;

/// Free vertices that a kept polytope must leave in the smallest size.
const SPARE: usize = 6;

/// Expands from `start` if it has volume, else from a tetrahedron found here. `bound` is an upper
/// bound known already. With a `cache`, keeps the polytope there.
pub(in crate::solver) fn expand<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
    cache: Option<&mut Cache>,
) -> Expansion {
    let expansion = expand_from(m, start, goal, bound, max_expansions, cache);
    settle(m, expansion)
}

fn expand_from<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
    mut cache: Option<&mut Cache>,
) -> Expansion {
    let terms = Terms::new(m, goal, max_expansions);
    let mut state = State::new(bound);
    let mut small = Polytope::<{ SIZES[0] }, { 2 * SIZES[0] }>::empty(m.noise());
    let thin = THIN_ROUNDINGS * m.rounding_error();
    if !start.is_some_and(|tetrahedron| small.start(tetrahedron, thin)) {
        match seed(m) {
            Ok(tetrahedron) if small.start(tetrahedron, 0.0) => {}
            // Its height is noise in the normal of a thin triangle.
            Ok(tetrahedron) => return expand_flat(m, widest_normal(tetrahedron), state.out),
            Err(Flat { normal }) => return expand_flat(m, normal, state.out),
        }
    }
    state.encloses = small.encloses();
    if let Some(cache) = &mut cache {
        cache.forget_polytope();
    }
    if !run(m, &mut small, &mut state, &terms, cache.as_deref_mut()) {
        let mut medium = small.grown::<{ SIZES[1] }, { 2 * SIZES[1] }>();
        return expand_more(m, &mut medium, &mut state, &terms, cache);
    }
    finish(&small, &mut state, cache)
}

/// Expands from the polytope in `cache`. `None` if there is none that encloses the origin under the
/// new pose, or if it stalls.
pub(in crate::solver) fn expand_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    goal: Goal,
    max_expansions: u32,
    cache: &mut Cache,
) -> Option<Expansion> {
    let points = cache.polytope()?.points().len();
    let terms = Terms::new(m, goal, max_expansions);
    let expansion = if points + SPARE <= SIZES[0] {
        let mut small = Polytope::<{ SIZES[0] }, { 2 * SIZES[0] }>::empty(m.noise());
        let mut state = restore(m, &mut small, cache)?;
        if run(m, &mut small, &mut state, &terms, None) {
            finish(&small, &mut state, Some(cache))
        } else {
            let mut medium = small.grown::<{ SIZES[1] }, { 2 * SIZES[1] }>();
            expand_more(m, &mut medium, &mut state, &terms, Some(cache))
        }
    } else {
        expand_medium_again(m, &terms, cache)?
    };
    if expansion.iterations > WORN_OUT {
        cache.forget_polytope();
    }
    (expansion.end != End::Stalled).then(|| settle(m, expansion))
}

/// Not inlined, so that the common path needs little stack.
#[inline(never)]
fn expand_medium_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    terms: &Terms,
    cache: &mut Cache,
) -> Option<Expansion> {
    let mut medium = Polytope::<{ SIZES[1] }, { 2 * SIZES[1] }>::empty(m.noise());
    let mut state = restore(m, &mut medium, cache)?;
    Some(if run(m, &mut medium, &mut state, terms, None) {
        finish(&medium, &mut state, Some(cache))
    } else {
        expand_big(m, &medium, &mut state, terms)
    })
}

/// Restores the polytope in `cache` under the new pose. `None` if it does not certainly enclose the
/// origin.
#[inline]
fn restore<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    cache: &Cache,
) -> Option<State> {
    let kept = cache.polytope()?;
    let points = kept.points().map(|features| m.recall(features));
    let encloses = polytope.restore(points, kept.faces()) && polytope.encloses();
    encloses.then(|| State { encloses: true, ..State::new(Bound::none()) })
}

/// Continues in the second size.
#[inline(never)]
fn expand_more<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &mut Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
    mut cache: Option<&mut Cache>,
) -> Expansion {
    if run(m, medium, state, terms, cache.as_deref_mut()) {
        return finish(medium, state, cache);
    }
    expand_big(m, medium, state, terms)
}

/// Continues in the third size. Polytopes of this size are not kept.
#[inline(never)]
fn expand_big<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut big = medium.grown::<{ SIZES[2] }, { 2 * SIZES[2] }>();
    if run(m, &mut big, state, terms, None) {
        return finish(&big, state, None);
    }
    expand_biggest(m, &big, state, terms)
}

/// Continues in the last size.
#[inline(never)]
fn expand_biggest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    big: &Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut biggest = big.grown::<{ SIZES[3] }, { 2 * SIZES[3] }>();
    // A full polytope is the cap, which the state reports already.
    run(m, &mut biggest, state, terms, None);
    finish(&biggest, state, None)
}

/// Computes the witness points of the bound and keeps the polytope if it is fit to be kept.
fn finish<const V: usize, const F: usize>(
    polytope: &Polytope<V, F>,
    state: &mut State,
    cache: Option<&mut Cache>,
) -> Expansion {
    if let Some(corners) = state.corners {
        let Bound { upper, normal, .. } = state.out.bound;
        state.out.bound = Bound::at(upper, normal, corners.map(|i| polytope.point(i)).each_ref());
    }
    if let Some(cache) = cache {
        if !state.encloses || state.out.end == End::Stalled {
            cache.forget_polytope();
        } else if polytope.point_count() <= KEEP {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
    }
    state.out
}
