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
//! - The origin's foot may be outside the face of the smallest h(n), as in the middle of a flat or
//!   curved side with many vertices. Then GJK finds the witness points ([`Bound::search`]).
//! - The ball around the interior points bounds the depth from below too, so round shapes end at
//!   once.
//! - Polytopes come in four sizes: most queries never touch the large arrays.

mod flat;
pub(in crate::solver) mod polytope;
mod search;

pub(in crate::solver) use self::flat::{BESIDE_ROUNDINGS, FLAT_ROUNDINGS};
pub(in crate::solver) use self::search::{End, Expansion, TOUCHING_ROUNDINGS, Terms};

use self::polytope::Polytope;
use self::search::{KEEP, Next, State};
use crate::solver::answer::beside;
use crate::solver::bound::{Bound, FOOT_ROUNDINGS};
use crate::solver::cache::{Cache, CachedPolytope};
use crate::solver::kept_face::keep_face;
use crate::solver::minkowski::{Minkowski, Point, Step};
use crate::solver::scratch::{Big, Biggest, Medium, SIZES, Scratch, Workspace, cleared};
use crate::solver::status::Overlap;
use crate::solver::steps::Solver;
use crate::support::SupportMap;

/// Number of expansions that need no polytope of the last size, from any start.
pub(in crate::solver) const MAX_BIG_EXPANSIONS: u32 = (SIZES[2] - KEEP) as u32;

/// A portal is not a start if the height of its tetrahedron is at most this many rounding errors:
/// its planes would be rounding error.
const THIN_ROUNDINGS: f64 = 64.0;

/// Expansions from a kept polytope after which it is stale and dropped.
const WORN_OUT: u32 = 8;

/// Free vertices that a kept polytope must leave in the smallest size.
const SPARE: usize = 6;

/// Maximum number of EPA steps for a decision. Touching pairs need about a dozen.
const MAX_DECISION_STEPS: u32 = 250;

/// An expansion that waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EpaSearch {
    terms: Terms,
    state: State,
    is_medium: bool,
    /// It has started from the polytope of the cache.
    again: bool,
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized, Q> Solver<'_, '_, A, B, Q, Workspace> {
    /// Starts from `tetrahedron` if it has volume, else from one found here. `bound` is an upper
    /// bound known already.
    ///
    /// # Errors
    /// The difference is flat; this is the whole result.
    #[inline(always)]
    pub(in crate::solver) fn start_expansion(
        &mut self,
        tetrahedron: Option<[Point; 4]>,
        terms: Terms,
        bound: Bound,
    ) -> Result<EpaSearch, Expansion> {
        let small = cleared(&mut self.workspace.small, self.m.noise());
        let thin = THIN_ROUNDINGS * self.m.rounding_error();
        if !tetrahedron.is_some_and(|tetrahedron| small.start(tetrahedron, thin))
            && let Err(normal) = self.m.seed(small)
        {
            let expansion = self.m.expand_flat(normal, State::new(bound, false).out);
            return Err(self.m.settle_expansion(expansion));
        }
        Ok(EpaSearch { terms, state: State::new(bound, small.encloses()), is_medium: false, again: false })
    }

    /// Starts from the polytope in the cache. `None` if there is none, or if it does not certainly
    /// enclose the origin under the new pose.
    #[inline(always)]
    pub(in crate::solver) fn start_from_cache(&mut self, terms: Terms) -> Option<EpaSearch> {
        let (m, kept, workspace) = (&*self.m, self.cache.polytope()?, &mut *self.workspace);
        let is_medium = kept.points.len() + SPARE > SIZES[0];
        let encloses = if is_medium {
            restore(m, cleared(&mut workspace.medium, m.noise()), &kept)
        } else {
            restore(m, cleared(&mut workspace.small, m.noise()), &kept)
        };
        encloses.then_some(EpaSearch { terms, state: State::new(Bound::none(), true), is_medium, again: true })
    }
}

/// Restores a polytope under the new pose. Returns whether it certainly encloses the origin.
#[inline]
fn restore<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    kept: &CachedPolytope<'_>,
) -> bool {
    let recall = |features| m.recall(features);
    polytope.restore(kept.points, recall, kept.corners, kept.neighbours) && polytope.encloses()
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Solver<'_, '_, A, B, EpaSearch, Workspace> {
    /// Continues up to the next support query, with the last support point, if any. The answer is
    /// `None` if the expansion started from the polytope of the cache and has stalled.
    #[inline(always)]
    pub(in crate::solver) fn advance(self, point: Option<Point>) -> Step<Option<Expansion>> {
        let Self { query: EpaSearch { terms, state, is_medium, again }, m, cache, workspace } = self;
        // While it grows. Entries that the cache has already are kept.
        let keeps = !*again && terms.keeps_polytope();
        let has_ended = match point {
            Some(point) if *is_medium => state.expand(workspace.medium(), terms, point),
            Some(point) => state.expand(workspace.small(), terms, point),
            None => false,
        };
        let mut next = if has_ended {
            Next::Ended
        } else if *is_medium {
            state.aim(workspace.medium(), terms, keeps.then_some(&mut *cache))
        } else {
            state.aim(workspace.small(), terms, keeps.then_some(&mut *cache))
        };
        if matches!(next, Next::Full) && !*is_medium {
            workspace.enlarge();
            *is_medium = true;
            next = state.aim(workspace.medium(), terms, keeps.then_some(&mut *cache));
        }
        let expansion = match next {
            Next::Ask => return Step::Ask(state.nearest.direction),
            Next::Ended if *is_medium => m.finish_expansion(workspace.medium(), state, terms, Some(&mut *cache)),
            Next::Ended => m.finish_expansion(workspace.small(), state, terms, Some(&mut *cache)),
            // Polytopes of the last two sizes are not kept, and they are rare: they are expanded at
            // once.
            Next::Full => match cache.scratch() {
                Some(scratch) => m.expand_in_scratch(workspace.medium(), state, terms, scratch),
                None => m.expand_on_stack(workspace.medium(), state, terms),
            },
        };
        if *again && state.out.iterations > WORN_OUT {
            cache.forget_polytope();
        }
        let is_useless = *again && expansion.end == End::Stalled;
        Step::Answer((!is_useless).then(|| m.settle_expansion(expansion)))
    }
}

impl<A: SupportMap + ?Sized, B: SupportMap + ?Sized> Minkowski<'_, A, B> {
    /// Decides at once whether the origin is inside, from `tetrahedron` if it has volume.
    ///
    /// The bound holds a separating axis if the origin is outside, and the witness points if the
    /// shapes touch. The last value is the number of steps.
    pub(in crate::solver) fn decide_by_expansion(
        &mut self,
        tetrahedron: Option<[Point; 4]>,
        cache: &mut Cache,
    ) -> (Overlap, Bound, u32) {
        let (mut workspace, terms) = (Workspace::default(), Terms::new(self, None, MAX_DECISION_STEPS));
        let mut solver = Solver { query: &mut (), m: &mut *self, cache: &mut *cache, workspace: &mut workspace };
        let Expansion { end, bound, iterations, .. } = match solver.start_expansion(tetrahedron, terms, Bound::none()) {
            Err(flat) => flat,
            Ok(mut query) => {
                let mut point = None;
                loop {
                    let (query, m, workspace) = (&mut query, &mut *self, &mut workspace);
                    match (Solver { query, m, cache: &mut *cache, workspace }).advance(point) {
                        Step::Ask(dir) => point = Some(self.point(dir)),
                        // Only an expansion from the cache's polytope has no result.
                        Step::Answer(expansion) => break expansion.unwrap_or(query.state.out),
                    }
                }
            }
        };
        let reach = FLAT_ROUNDINGS * self.rounding_error();
        // The face may be far from the origin and still on the surface of a polytope that is too
        // thin to enclose the origin for certain; and the origin may be beside a thin face.
        let is_near = bound.upper <= reach && bound.point_a.distance(bound.point_b) <= 2.0 * reach;
        let status = match end {
            End::Separated => Overlap::Separated,
            End::Inside => Overlap::Overlapping,
            End::Touching | End::Converged if is_near => Overlap::Touching,
            _ => Overlap::Undecided,
        };
        (status, bound, iterations)
    }

    #[inline(never)]
    fn expand_in_scratch(
        &mut self,
        medium: &Medium,
        state: &mut State,
        terms: &Terms,
        Scratch { big, biggest }: &mut Scratch,
    ) -> Expansion {
        match self.expand_in(medium, big, state, terms) {
            Ok(expansion) => expansion,
            Err(big) => self
                .expand_in(big, biggest, state, terms)
                .unwrap_or_else(|last| self.finish_expansion(last, state, terms, None)),
        }
    }

    #[inline(never)]
    fn expand_on_stack(&mut self, medium: &Medium, state: &mut State, terms: &Terms) -> Expansion {
        let mut big = Big::EMPTY;
        self.expand_in(medium, &mut big, state, terms).unwrap_or_else(|big| self.expand_to_the_limit(big, state, terms))
    }

    /// A function of its own, since most expansions do not need its stack.
    #[inline(never)]
    fn expand_to_the_limit(&mut self, big: &Big, state: &mut State, terms: &Terms) -> Expansion {
        let mut biggest = Biggest::EMPTY;
        self.expand_in(big, &mut biggest, state, terms)
            .unwrap_or_else(|last| self.finish_expansion(last, state, terms, None))
    }

    /// Moves the surface into `larger` and expands it there without suspending.
    ///
    /// # Errors
    /// That polytope is full too; the state reports it.
    fn expand_in<'p, const V: usize, const F: usize, const W: usize, const G: usize>(
        &mut self,
        polytope: &Polytope<V, F>,
        larger: &'p mut Polytope<W, G>,
        state: &mut State,
        terms: &Terms,
    ) -> Result<Expansion, &'p Polytope<W, G>> {
        polytope.overwrite(larger);
        loop {
            match state.aim(larger, terms, None) {
                Next::Ask if state.expand(larger, terms, self.point(state.nearest.direction)) => break,
                Next::Ask => {}
                Next::Ended => break,
                Next::Full => return Err(larger),
            }
        }
        Ok(self.finish_expansion(larger, state, terms, None))
    }

    /// Computes the witness points of the bound. If the goal is a depth, keeps the polytope in
    /// `cache`, provided that it is fit to be kept.
    ///
    /// The steps of the search for witness points count in the result, and not in `state`.
    fn finish_expansion<const V: usize, const F: usize>(
        &mut self,
        polytope: &Polytope<V, F>,
        state: &mut State,
        terms: &Terms,
        cache: Option<&mut Cache>,
    ) -> Expansion {
        let Bound { upper, normal, .. } = state.out.bound;
        let face = state.corners.map(|corners| corners.map(|i| polytope.point(i)));
        if let Some(face) = &face {
            state.out.bound = Bound::on_face(upper, normal, face.each_ref());
            state.out.features = Point::first_features(face.iter().map(|point| point.features));
        }
        if state.encloses && terms.keeps_polytope() {
            // Depths beyond it make no difference.
            let interval = [state.out.lower - self.noise(), upper.max(0.0) + self.rounding_error()];
            let limit = 2.0 * beside(interval, self.outer_radius());
            state.out.others = polytope.offset_beside(normal, limit);
        }
        let mut expansion = state.out;
        if expansion.end == End::Converged {
            let width = (upper - expansion.lower).min(terms.allowance(upper)).max(0.0);
            let enough = width + FOOT_ROUNDINGS * self.noise();
            // NaN takes the search.
            if !(expansion.bound.off() <= enough) {
                expansion.iterations += expansion.bound.search(self, face.as_ref().map_or(&[], |face| face), enough);
            }
        }
        if let Some(cache) = cache.filter(|_| terms.keeps_polytope()) {
            if let Some(face) = face.filter(|_| expansion.end == End::Converged) {
                keep_face(self, (upper, face.map(|point| point.features)), cache);
            }
            if !state.encloses || state.out.end == End::Stalled {
                cache.forget_polytope();
            } else if polytope.point_count <= KEEP {
                cache.keep_polytope(polytope.features(), polytope.faces());
            }
        }
        expansion
    }
}
