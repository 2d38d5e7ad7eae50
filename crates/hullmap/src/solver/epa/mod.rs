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
//! `suspended` is the search as a state machine, for batches.
//!
//! # Deviations
//! - "Nearest" is by signed offset, so the origin need not be inside at the start. While it is
//!   outside, the polytope grows towards it, until it is inside or a support plane proves it
//!   outside. No portal is too poor to start from.
//! - d is a bound only once the surface certainly winds around the origin. Until then nothing is
//!   claimed.
//! - The smallest h(n) of all faces tried is kept with its face, so the upper bound never grows.
//! - The face of the smallest h(n) may be inside the difference, or the origin's foot may be
//!   outside the face, as in the middle of a flat or curved side with many vertices. Then GJK finds
//!   the witness points ([`Bound::settle`]).
//! - The ball around the interior points bounds the depth from below too, so round shapes end at
//!   once.
//! - Polytopes come in four sizes: most queries never touch the large arrays.

mod flat;
mod polytope;
mod search;
mod seed;
pub(in crate::solver) mod sizes;
mod suspended;

pub(in crate::solver) use self::polytope::Polytope;
pub(in crate::solver) use self::search::{End, Expansion, Goal};
pub(crate) use self::suspended::Room;
pub(in crate::solver) use self::suspended::{Progress, Search};

use self::flat::{expand_flat, settle, widest_normal};
use self::search::{State, Terms, run};
use self::seed::{Flat, seed};
use self::sizes::{Large, SIZES};
use crate::solver::bound::Bound;
use crate::solver::cache::{Cache, MAX_POINTS};
use crate::solver::minkowski::{Minkowski, Point};
use crate::solver::scratch::Scratch;
use crate::support::SupportMap;

/// Number of expansions that need no polytope of the last size, from any start.
pub(in crate::solver) const MAX_BIG_EXPANSIONS: u32 = (SIZES[2] - KEEP) as u32;

/// A portal is not a start if the height of its tetrahedron is at most this many rounding errors:
/// its planes would be noise.
const THIN_ROUNDINGS: f64 = 64.0;

/// Support values up to this many rounding errors count as touching: one for the support point, one
/// for the normal.
pub(in crate::solver) const TOUCHING_ROUNDINGS: f64 = 2.0;

/// The same for flat differences, in rounding errors: their thickness is up to half of this, and
/// their normal is as uncertain.
pub(in crate::solver) const FLAT_ROUNDINGS: f64 = 16.0;

/// Witness points may be this many rounding errors farther from the foot than the interval is wide:
/// one each for the support point and the closest point. The search for them ends at as many
/// noises.
pub(in crate::solver) const FOOT_ROUNDINGS: f64 = 2.0;

/// Witness points of a touching face that are more than this many rounding errors from each other
/// show that the origin is beside the face.
pub(in crate::solver) const BESIDE_ROUNDINGS: f64 = 4.0;

/// Number of vertices at which a polytope is kept for the next query, unless it ends with fewer.
/// Further vertices belong to small faces around the nearest one. These become dents when the pose
/// changes, and each dent costs a support call.
const KEEP: usize = MAX_POINTS;

/// Expansions from a kept polytope after which it is stale and dropped.
const WORN_OUT: u32 = 8;

/// Free vertices that a kept polytope must leave in the smallest size.
const SPARE: usize = 6;

/// Expands from `start` if it has volume, else from a tetrahedron found here. `bound` is an upper
/// bound known already. If the goal is a depth, keeps the polytope in `cache`.
pub(in crate::solver) fn expand<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    start: Option<[Point; 4]>,
    goal: Goal,
    bound: Bound,
    max_expansions: u32,
    cache: &mut Cache,
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
    cache: &mut Cache,
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
    let mut kept_in = terms.keeps_polytope().then_some(&mut *cache);
    if let Some(cache) = &mut kept_in {
        cache.forget_polytope();
    }
    if !run(m, &mut small, &mut state, &terms, kept_in.as_deref_mut()) {
        let mut medium = Polytope::<{ SIZES[1] }, { 2 * SIZES[1] }>::empty(0.0);
        small.copy_into(&mut medium);
        return expand_more(m, &mut medium, &mut state, &terms, cache);
    }
    finish(m, &small, &mut state, &terms, kept_in)
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
    let (expansion, steps) = if points + SPARE <= SIZES[0] {
        let mut small = Polytope::<{ SIZES[0] }, { 2 * SIZES[0] }>::empty(m.noise());
        let mut state = restore(m, &mut small, cache)?;
        let expansion = if run(m, &mut small, &mut state, &terms, None) {
            finish(m, &small, &mut state, &terms, Some(cache))
        } else {
            let mut medium = Polytope::<{ SIZES[1] }, { 2 * SIZES[1] }>::empty(0.0);
            small.copy_into(&mut medium);
            expand_more(m, &mut medium, &mut state, &terms, cache)
        };
        (expansion, state.out.iterations)
    } else {
        expand_medium_again(m, &terms, cache)?
    };
    if steps > WORN_OUT {
        cache.forget_polytope();
    }
    (expansion.end != End::Stalled).then(|| settle(m, expansion))
}

/// Also returns the number of expansions. Not inlined, so that the common path needs little stack.
#[inline(never)]
fn expand_medium_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    terms: &Terms,
    cache: &mut Cache,
) -> Option<(Expansion, u32)> {
    let mut medium = Polytope::<{ SIZES[1] }, { 2 * SIZES[1] }>::empty(m.noise());
    let mut state = restore(m, &mut medium, cache)?;
    let expansion = if run(m, &mut medium, &mut state, terms, None) {
        finish(m, &medium, &mut state, terms, Some(cache))
    } else {
        expand_large(m, &medium, &mut state, terms, cache.scratch())
    };
    Some((expansion, state.out.iterations))
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
    cache: &mut Cache,
) -> Expansion {
    if run(m, medium, state, terms, terms.keeps_polytope().then_some(&mut *cache)) {
        return finish(m, medium, state, terms, terms.keeps_polytope().then_some(cache));
    }
    expand_large(m, medium, state, terms, cache.scratch())
}

/// Continues in the third size, then in the last: in `scratch` if there is some, else on the stack.
/// Polytopes of these sizes are not kept.
fn expand_large<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
    scratch: Option<&mut Scratch>,
) -> Expansion {
    match scratch {
        Some(scratch) => expand_in(m, medium, state, terms, &mut scratch.large),
        None => expand_big(m, medium, state, terms),
    }
}

/// Continues in caller-owned memory.
#[inline(never)]
fn expand_in<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
    Large { big, biggest }: &mut Large,
) -> Expansion {
    medium.overwrite(big);
    if run(m, big, state, terms, None) {
        return finish(m, big, state, terms, None);
    }
    big.overwrite(biggest);
    // A full polytope is the limit, which the state reports already.
    run(m, biggest, state, terms, None);
    finish(m, biggest, state, terms, None)
}

/// Continues in the third size, on the stack.
#[inline(never)]
fn expand_big<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut big = Polytope::<{ SIZES[2] }, { 2 * SIZES[2] }>::empty(0.0);
    medium.copy_into(&mut big);
    if run(m, &mut big, state, terms, None) {
        return finish(m, &big, state, terms, None);
    }
    expand_biggest(m, &big, state, terms)
}

/// Continues in the last size, on the stack.
#[inline(never)]
fn expand_biggest<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    big: &Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    let mut biggest = Polytope::<{ SIZES[3] }, { 2 * SIZES[3] }>::empty(0.0);
    big.copy_into(&mut biggest);
    // A full polytope is the limit, which the state reports already.
    run(m, &mut biggest, state, terms, None);
    finish(m, &biggest, state, terms, None)
}

/// Computes the witness points of the bound and keeps the polytope if it is fit to be kept.
///
/// The steps of the search for witness points count in the result, and not in `state`.
fn finish<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
    cache: Option<&mut Cache>,
) -> Expansion {
    let Bound { upper, normal, .. } = state.out.bound;
    let face = state.corners.map(|corners| corners.map(|i| polytope.point(i)));
    if let Some(face) = &face {
        state.out.bound = Bound::at(upper, normal, face.each_ref());
    }
    let mut expansion = state.out;
    if expansion.end == End::Converged {
        let width = (upper - expansion.lower).min(terms.allowance(upper)).max(0.0);
        let enough = width + FOOT_ROUNDINGS * m.noise();
        expansion.iterations += expansion.bound.settle(m, face.as_ref().map_or(&[], |face| face), enough);
    }
    if let Some(cache) = cache {
        if !state.encloses || state.out.end == End::Stalled {
            cache.forget_polytope();
        } else if polytope.point_count() <= KEEP {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
    }
    expansion
}
